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
        read(Some(&ini), &file, [x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
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
    let gone = super::read(None, &folder.join("gone.ngc"), [0.0; 9]).unwrap_err();
    assert_eq!(gone.code, Some(Code::Falla), "{gone}");
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
