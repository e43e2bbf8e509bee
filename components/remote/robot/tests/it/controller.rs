//! The simulated controller alone, and part zeros as text.

use robot::{Controller, Faults, Output, Volume};

const ZERO: [f64; 3] = [-400.0, 0.0, -30.0];

#[test]
fn the_controller_answers_garbage_and_moves_nothing() {
    let mut robot = Controller::new(Volume::default(), ZERO, Faults::default());
    robot.connect(0.0);
    let mut now = 6.0;
    robot.poll(now);
    let mut ask = |bytes: &[u8]| {
        robot.receive(bytes, now);
        now += 0.1;
        let mut out = robot.poll(now);
        now += 0.1;
        out.extend(robot.poll(now));
        let out = out.into_iter().map(|o| match o {
            Output::Bytes(b) => String::from_utf8(b).unwrap().trim().to_owned(),
            Output::Close => "closed".to_owned(),
        });
        let out = out.collect::<Vec<_>>().join(" ");
        assert!(!robot.is_moving());
        out
    };
    assert_eq!(ask(b"LMOVE,1,2,3\r\n"), "error unknown", "before inicio");
    assert_eq!(ask(b"inicio\n"), "done");
    for (line, answer) in [
        (&b"MOVE,1,2,3\r"[..], "error unknown"),
        (b"LMOVE,400,0,0\r\n", "error range"),
        (b"LMOVE,1,2\r\n", "error format"),
        (b"LMOVE,1,2,3,4\r\n", "error format"),
        (b"LMOVE,1,2,nan\r\n", "error format"),
        (b"LMOVE,1,2,1e9\r\n", "error format"),
        (b"SPEED,0\r\n", "error range"),
        (b"SPEED,15.1\r\n", "error range"),
        (b"SPEED,5", "done"),
        (b"\xff\xfe\r\n", "error unknown"),
        (b"\r\n\r\n", ""),
        (b"LMO", "error unknown"),
    ] {
        assert_eq!(ask(line), answer, "{:?}", String::from_utf8_lossy(line));
    }
    assert_eq!(ask(&[b'x'; 1000]), "error format");
    assert_eq!(ask(b"SPEED,4\r\nSPEED,3\nSPEED,2\r\n"), "done done done");
    assert_eq!(ask(b"EXIT\r\n"), "closed");
    assert!(robot.moves().is_empty());
}

#[test]
fn lines_beside_an_exit_move_nothing() {
    let mut robot = Controller::new(Volume::default(), ZERO, Faults::default());
    assert_eq!(robot.connect(0.0), None);
    assert!(!robot.poll(6.0).is_empty());
    robot.receive(b"inicio\r\nLMOVE,5,0,0\r\nEXIT\r\nLMOVE,10,0,0\r\n", 7.0);
    assert!(!robot.is_moving());
    assert_eq!(robot.poll(7.0), [Output::Close]);
}

#[test]
fn a_part_zero_is_three_numbers() {
    assert_eq!(robot::parse_zero("-400, 0,-30.5"), Ok([-400.0, 0.0, -30.5]));
    for (text, why) in [
        ("nan,0,0", "'nan' is not a number"),
        ("0,-inf,0", "'-inf' is not a number"),
        ("0,,0", "'' is not a number"),
        ("1,2", "three numbers are needed, such as -400,0,-30"),
        ("1,2,3,4", "three numbers are needed, such as -400,0,-30"),
    ] {
        assert_eq!(robot::parse_zero(text), Err(why.to_owned()));
    }
}
