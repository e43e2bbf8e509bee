//! Sections, entries, escapes, includes, and every message.

use super::*;

fn check(text: &str, want: &str) {
    let shown = match Ini::parse("m.ini", text.as_bytes()) {
        Ok(ini) => ini
            .entries
            .iter()
            .map(|e| format!("[{}]{}={:?}@{}\n", e.section, e.name, e.value, e.line))
            .collect::<String>(),
        Err(e) => format!("! {e}"),
    };
    assert_eq!(shown, want, "{text:?}");
}

#[test]
fn sections_and_entries() {
    for (text, want) in [
        ("[A]\nX = 1\n[B]\nX=2", "[A]X=\"1\"@2\n[B]X=\"2\"@4\n"),
        ("[A]\n  X  =  some text  \n", "[A]X=\"some text\"@2\n"),
        ("[A]\r\nX = 1\r\n", "[A]X=\"1\"@2\n"),
        ("# c\n; c\n[A] # c\nX = 1 # kept\n", "[A]X=\"1 # kept\"@4\n"),
        ("[A]\nX = a\nX = b\n", "[A]X=\"a\"@2\n[A]X=\"b\"@3\n"),
        ("[A]\nX =\n", "[A]X=\"\"@2\n"),
        ("[A]\nX = .25\nY = 5mm .5mm\n", "[A]X=\".25\"@2\n[A]Y=\"5mm .5mm\"@3\n"),
        ("[A]\nX = a=b\n", "[A]X=\"a=b\"@2\n"),
        ("[A]\nX = one \\\n   two\nY = 1\n", "[A]X=\"one    two\"@3\n[A]Y=\"1\"@4\n"),
        ("[A]\nX-Y.Z = 1\n", "[A]X-Y.Z=\"1\"@2\n"),
        ("\u{feff}[A]\nX = 1\n", "[A]X=\"1\"@2\n"),
        ("", ""),
    ] {
        check(text, want);
    }
}

#[test]
fn escapes() {
    for (value, want) in [
        ("a\\tb\\x41", "a\tbA"),
        ("\\101\\\\\\n", "A\\\n"),
        ("\\u00e9\\U0001F600", "é😀"),
        ("c:\\qdir", "c:\\qdir"),
        ("\\xzz", "\\xzz"),
    ] {
        let ini = Ini::parse("m", format!("[A]\nX = {value}\n").as_bytes()).unwrap();
        assert_eq!(ini.get("A", "X"), Some(want), "{value}");
    }
}

#[test]
fn what_is_wrong_names_its_line() {
    for (text, want) in [
        ("X = 1\n", "! m.ini:1: this entry is before the first [SECTION]"),
        ("[A\n", "! m.ini:1: a section is [NAME]: letters, digits and _"),
        ("[A]\nX = \\uD800\n", "! m.ini:2: no such character"),
        (
            "#INCLUDE /dev/zero\n",
            "! m.ini:1: #INCLUDE: could not open INI file '/dev/zero': it is a device, not a file",
        ),
        ("net x a.0.out\nnet y b.0.out\n", "! m.ini:1: this entry is before the first [SECTION]"),
    ] {
        check(text, want);
    }
    let bad = Ini::parse("m.ini", b"[A]\nX = \xff\n").unwrap_err();
    assert_eq!(bad.to_string(), "m.ini:2: this is not UTF-8");
}

/// LinuxCNC goes on without these lines (measured with `inivar` and `linuxcnc` 2.9).
#[test]
fn lines_without_meaning_are_ignored_with_a_warning() {
    const ENTRY: &str = "expected NAME = value, with letters, digits and _ in the name";
    for (text, entries, warning) in [
        ("[A]\n\nX 1\nY = 2\n", "Y2", format!("3: Warning: this line is ignored: {ENTRY}")),
        ("[A]\n9X = 1\nY = 2\n", "Y2", format!("2: Warning: this line is ignored: {ENTRY}")),
        ("[A] is gone\nX = 1\n", "X1", "1: Warning: the text after [A] is ignored".to_owned()),
        (
            "X = 1\n[A]\nY = 2\n",
            "Y2",
            "1: Warning: this line is ignored: it is before the first [SECTION]".to_owned(),
        ),
        (
            "[A]\nX = 1\n#INCLUDE\nY = 2\n",
            "X1 Y2",
            "3: Warning: this line is ignored: #INCLUDE needs the name of a file".to_owned(),
        ),
        (
            "[A]\n#INCLUDE /nowhere/x\nY = 2\n",
            "Y2",
            "2: Warning: this line is ignored: could not open INI file '/nowhere/x': No such file or directory"
                .to_owned(),
        ),
    ] {
        let ini = Ini::parse("m", text.as_bytes()).unwrap();
        let all: Vec<_> = ini.section("A").map(|e| format!("{}{}", e.name, e.value)).collect();
        assert_eq!(all.join(" "), entries, "{text:?}");
        let [found] = ini.warnings() else { panic!("{text:?}: {:?}", ini.warnings()) };
        assert_eq!((found.to_string(), found.doubt), (format!("m:{warning}"), Doubt::Ignored));
    }
}

#[test]
fn the_number_of_warnings_is_bounded() {
    let ini = Ini::parse("m", format!("[A]\n{}", "x\n".repeat(1_000_000)).as_bytes()).unwrap();
    assert_eq!(ini.warnings().len(), MAX_WARNINGS);
    let last = &ini.warnings().last().unwrap().text;
    assert!(last.ends_with("in the name; 999900 more warnings are not shown"), "{last}");
}

#[test]
fn look_ups() {
    let text = b"[A]\nX = 1\n[B]\nX = 2\nY = 3\n[A]\nX = 4\n";
    let ini = Ini::parse("m", text).unwrap();
    assert_eq!(ini.get("A", "X"), Some("1"));
    assert_eq!(ini.get("", "Y"), Some("3"));
    assert_eq!(ini.get("a", "X"), None);
    let all: Vec<_> = ini.all("A", "X").map(|e| e.value.as_str()).collect();
    assert_eq!(all, ["1", "4"]);
    let warning = "m:6: Warning: section [A] is repeated; its entries are added to the first";
    let [found] = ini.warnings() else { panic!("{:?}", ini.warnings()) };
    assert_eq!((found.to_string().as_str(), found.doubt), (warning, Doubt::Repeated));
}

#[test]
fn the_old_kind_has_numbered_axes_and_no_joints() {
    for (text, old) in [
        ("[AXIS_0]\n", true),
        ("[AXIS_X]\n[JOINT_0]\n", false),
        ("[AXIS_0]\n[JOINT_0]\n", false),
        ("[AXIS_]\n", false),
        ("", false),
    ] {
        assert_eq!(Ini::parse("m", text.as_bytes()).unwrap().is_old(), old, "{text}");
    }
}

#[test]
fn a_file_with_an_error_has_nothing() {
    let path = std::env::temp_dir().join(format!("ferrule-broken-{}.ini", std::process::id()));
    std::fs::write(&path, "[A]\nX = 1\n[B\n").unwrap();
    let broken = Ini::open(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(broken.get("A", "X"), None);
    let why = broken.broken().unwrap().to_string();
    assert!(why.ends_with(".ini:3: a section is [NAME]: letters, digits and _"), "{why}");
    assert!(Ini::open(&path).is_err(), "a file that is not there");
}

#[test]
fn the_nearest_entry() {
    let ini = Ini::parse("m", b"[TRAJ]\nAXES = 3\n[JOINT_0]\nSCALE = 1\nMAX_LIMIT = 2\n").unwrap();
    for (section, name, want) in [
        ("JOINT_0", "SCALES", Some(("[JOINT_0]SCALE", true))),
        ("JOINT_1", "SCALE", Some(("[JOINT_0]SCALE", true))),
        ("AXIS_0", "SCALE", Some(("[JOINT_0]SCALE", true))),
        ("traj", "axes", Some(("[TRAJ]AXES", true))),
        ("JOINT_0", "MAXLIMIT", Some(("[JOINT_0]MAX_LIMIT", true))),
        ("HAL", "TWOPASS", Some(("[TRAJ]AXES", false))),
    ] {
        let near = ini.nearest(section, name);
        assert_eq!(near, want.map(|(n, m)| (n.to_owned(), m)), "[{section}]{name}");
    }
    assert_eq!(Ini::default().nearest("A", "B"), None);
}

#[test]
fn files_include_each_other() {
    let folder = std::env::temp_dir().join(format!("ferrule-ini-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("sub")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("a.ini", "[A]\nX = 1\n#INCLUDE sub/b.ini\nU = 6\n[A]\nZ = 3\n");
    write("sub/b.ini", "[B]\nY = 2\n#INCLUDE c.ini\n");
    write("sub/c.ini", "V = 5\n[C]\nW = 4\n");
    write("loop.ini", "#INCLUDE loop.ini\n");
    for n in 0..18 {
        write(&format!("d{n}.ini"), &format!("[D]\nD = {n}\n#INCLUDE d{}.ini\n", n + 1));
    }
    write("d18.ini", "");
    // The deepest file that is allowed, and one level more.
    let deep = Ini::read(&folder.join("d2.ini")).unwrap();
    let deeper = Ini::read(&folder.join("d1.ini")).unwrap_err().to_string();
    let ini = Ini::read(&folder.join("a.ini")).unwrap();
    let names: Vec<_> = ini.names().collect();
    let endless = Ini::read(&folder.join("loop.ini")).unwrap_err().to_string();
    std::fs::remove_dir_all(&folder).unwrap();
    // The text of a file stands in the place of the line that includes it.
    assert_eq!(names, ["[A]X", "[B]Y", "[B]V", "[C]W", "[C]U", "[A]Z"]);
    assert_eq!(deep.all("D", "D").count(), 16);
    assert!(deeper.ends_with("files include each other too deeply (16 at most)"), "{deeper}");
    assert!(endless.ends_with("loop.ini:1: files include each other too deeply (16 at most)"));
}

#[test]
fn the_number_of_files_is_bounded() {
    let folder = std::env::temp_dir().join(format!("ferrule-ini-many-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for n in 0..14 {
        let twice = format!("#INCLUDE d{}.ini\n", n + 1).repeat(2);
        std::fs::write(folder.join(format!("d{n}.ini")), twice).unwrap();
    }
    std::fs::write(folder.join("d14.ini"), "").unwrap();
    let few = Ini::read(&folder.join("d6.ini"));
    let many = Ini::read(&folder.join("d0.ini")).unwrap_err().to_string();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(few.is_ok(), "511 files");
    assert!(many.ends_with("it consists of more than 1000 files"), "{many}");
}

#[test]
fn the_bytes_of_all_files_are_bounded() {
    let large = std::env::temp_dir().join(format!("hal-ini-large-{}.ini", std::process::id()));
    std::fs::File::create(&large).unwrap().set_len(MAX_BYTES + 1).unwrap();
    let of_large = Ini::read(&large);
    std::fs::remove_file(&large).unwrap();
    for (read, wanted) in [
        (of_large, "it is larger than 64 MiB"),
        (Ini::read(Path::new("/dev/zero")), "it is a device, not a file"),
    ] {
        let refused = read.unwrap_err();
        let Error::File { why, .. } = refused else { panic!("{refused}") };
        assert_eq!(&*why, wanted);
    }
}

#[test]
fn the_unit_of_length_is_the_inch_or_the_millimetre() {
    for (entry, unit) in [
        ("LINEAR_UNITS = inch", Some("inch")),
        ("LINEAR_UNITS = IN", Some("inch")),
        ("LINEAR_UNITS = Imperial", Some("inch")),
        ("LINEAR_UNITS = 0.03937", Some("inch")),
        ("LINEAR_UNITS = mm", Some("mm")),
        ("LINEAR_UNITS = Metric", Some("mm")),
        ("LINEAR_UNITS = 1.0", Some("mm")),
        ("AXES = 3", Some("mm")),
        ("LINEAR_UNITS = cm", None),
        ("LINEAR_UNITS = NaN", None),
        ("LINEAR_UNITS =", None),
    ] {
        let ini = Ini::parse("m.ini", format!("[TRAJ]\n{entry}\n").as_bytes()).unwrap();
        let found = ini.is_inch().map(|is_inch| if is_inch { "inch" } else { "mm" });
        assert_eq!(found.ok(), unit, "{entry}");
    }
}

#[test]
fn joints_have_the_letters_of_the_kinematics_or_of_the_trajectory() {
    for (text, letters) in [
        ("", None),
        ("[TRAJ]\nCOORDINATES = x y z\n", Some("XYZ")),
        ("[TRAJ]\nCOORDINATES = XY\n[KINS]\nKINEMATICS = trivkins coordinates=yx\n", Some("YX")),
        ("[TRAJ]\nCOORDINATES = XY\n[KINS]\nKINEMATICS = corexykins coordinates=yx\n", Some("XY")),
        ("[KINS]\nKINEMATICS = trivkins kinstype=b coordinates=XYYZ\n", Some("XYYZ")),
    ] {
        let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
        assert_eq!(ini.joint_letters().as_deref(), letters, "{text}");
    }
}
