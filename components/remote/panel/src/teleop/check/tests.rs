//! Programs that are refused with their line, and progress along a path.

use super::{Code, Lengths, Progress, Reason, read, reason};
use std::{fs, path::Path};

const INI: &str = "[TRAJ]\nLINEAR_UNITS = inch\nCOORDINATES = XYZ\n[KINS]\nJOINTS = 3\n\
                   [JOINT_0]\nMIN_LIMIT = 0\nMAX_LIMIT = 8\n";

#[test]
fn a_program_is_refused_with_its_line_or_has_a_length() {
    let folder = std::env::temp_dir().join(format!("halpanel-check-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let (ini, file) = (folder.join("m.ini"), folder.join("teleop.ngc"));
    fs::write(&ini, INI).unwrap();
    let read = |text: &str, x: f64| {
        fs::write(&file, text).unwrap();
        read(Some(&ini), &file, [x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &|| Ok(()))
    };
    for (text, x, code, begin) in [
        ("G20 G0 X1\nG1 X2\nM2\n", 0.0, Code::Sintaxis, "2 "),
        ("G20 F10\nG0 X1\nG2 X2 I9 J9\nM2\n", 0.0, Code::Sintaxis, "3 "),
        ("G20 F10\nG1 X8.5\nG1 X0\nM2\n", 0.0, Code::Limite, "2 X8.5000 is 0.5000 inch beyond"),
        ("G20 F10\nG91 G1 X2\nM2\n", 7.0, Code::Limite, "2 X9.0000 is 1.0000 inch beyond"),
        // An error behind a place beyond the limits comes first.
        ("G20 F10\nG1 X9\nG1 X\nM2\n", 0.0, Code::Sintaxis, "3 "),
    ] {
        let why = read(text, x).unwrap_err();
        assert!(why.code == Some(code) && why.text.starts_with(begin), "{text}: {why}");
    }
    // From 7 to 1, up, and a half circle of radius 1.
    let lengths = read("G21 F100\nG0 X25.4\nG1 Z25.4\nG3 X76.2 I25.4 J0\nM2\n", 7.0).unwrap().0;
    let lines: Vec<u32> = lengths.iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [2, 3, 4]);
    for ((_, length), right) in lengths.iter().zip([6.0, 7.0, 7.0 + core::f64::consts::PI]) {
        assert!((length - right).abs() < 1e-3, "{lengths:?}");
    }
    // The rest depends on the machine.
    let known = read("G20 F10\nG1 X1\nG1 X[#<_hal[a.pin]>]\nG1 X99\nM2\n", 0.0).unwrap().0;
    assert_eq!(known, [(2, 1.0)]);
    let gone = super::read(None, &folder.join("gone.ngc"), [0.0; 9], &|| Ok(())).unwrap_err();
    assert_eq!(gone.code, Some(Code::Falla), "{gone}");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn reading_ends_once_the_job_may_not_begin() {
    let folder = std::env::temp_dir().join(format!("halpanel-check-may-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join("endless.ngc");
    fs::write(&file, "o1 while [1]\n#1=[#1+1]\no1 endwhile\nM2\n").unwrap();
    let looks = core::cell::Cell::new(0);
    let off = || Reason::new(Code::Apagado, "the machine is in e-stop");
    let may = || {
        looks.set(looks.get() + 1);
        if looks.get() < 3 { Ok(()) } else { Err(off()) }
    };
    assert_eq!(read(None, &file, [0.0; 9], &may), Err(off()));
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_check_calls_no_function() {
    let folder = std::env::temp_dir().join(format!("halpanel-check-py-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let (ini, file) = (folder.join("m.ini"), folder.join("teleop.ngc"));
    // Neither the begin of the process nor a function leaves its mark.
    let mark = |name: &str| format!("    open('{}/mark', 'w').write('{name}')\n", folder.display());
    let begin = format!("import remap, oword\ndef __init__(self):\n{}", mark("begin"));
    fs::write(folder.join("toplevel.py"), begin).unwrap();
    fs::write(folder.join("remap.py"), format!("def report(self, **words):\n{}", mark("report")))
        .unwrap();
    fs::write(folder.join("oword.py"), format!("def square(self, x):\n{}", mark("square")))
        .unwrap();
    let python = "[PYTHON]\nPATH_PREPEND = .\nTOPLEVEL = toplevel.py\n[RS274NGC]\n\
                  REMAP = M400 modalgroup=10 py=report\n";
    fs::write(&ini, format!("{INI}{python}")).unwrap();
    for call in ["M400", "o<square> call [3]"] {
        fs::write(&file, format!("G20 F10\nG1 X1\n{call}\nG1 X99\nM2\n")).unwrap();
        let known = read(Some(&ini), &file, [0.0; 9], &|| Ok(())).unwrap().0;
        assert_eq!(known, [(2, 1.0)], "{call}");
        let text = hal_job::world::program(&file).unwrap();
        let shown = crate::geometry::read(
            Some(&ini),
            &file,
            text,
            crate::geometry::Wishes::default(),
            &mut |_| Ok(()),
        )
        .unwrap();
        assert_eq!(shown.error.as_ref().map(|(line, _)| *line), Some(3), "{call}");
        assert!(
            !folder.join("mark").exists(),
            "{call}: {}",
            fs::read_to_string(folder.join("mark")).unwrap_or_default()
        );
    }
    // Without functions it is an error.
    fs::write(&ini, INI).unwrap();
    let why = read(Some(&ini), &file, [0.0; 9], &|| Ok(())).unwrap_err();
    assert_eq!(why.code, Some(Code::Sintaxis), "{why}");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_refusal_of_the_task_has_line_and_text() {
    for (text, code, shown) in [
        ("/a b/t.ngc:7: radius 1 at start", Code::Sintaxis, "7 radius 1 at start"),
        ("/a b/t.ngc:7:3: odd\n/a b/t.ngc:9: even", Code::Sintaxis, "7 odd"),
        (
            "/a b/t.ngc:2: X9 is 1 mm beyond [JOINT_0]MAX_LIMIT = 8",
            Code::Limite,
            "2 X9 is 1 mm beyond [JOINT_0]MAX_LIMIT = 8",
        ),
        ("the machine is off", Code::Falla, "the machine is off"),
    ] {
        assert_eq!(reason(Path::new("/a b/t.ngc"), text), Reason::new(code, shown), "{text}");
    }
}

#[test]
fn progress_goes_by_length_and_never_back() {
    let mut job = Progress::new(Lengths(vec![(2, 10.0), (3, 20.0), (2, 30.0), (9, 40.0)]));
    assert_eq!(job.percent(), 0);
    for (line, to_go, percent) in [
        (0, 0.0, 0),
        (2, 9.0, 2),
        (2, 2.5, 18),
        // A look at the line that has begun, with the distance of the move before.
        (3, 10.0, 25),
        (3, 0.0, 50),
        // The same line again.
        (2, 5.0, 62),
        (2, 8.0, 62),
        (7, 1.0, 62),
        (9, 10.0, 75),
        (9, 0.0, 99),
        (0, 0.0, 99),
    ] {
        job.look(line, to_go);
        assert_eq!(job.percent(), percent, "{line} {to_go}");
    }
    let mut none = Progress::default();
    none.look(0, 0.0);
    assert_eq!(none.percent(), 0);
}
