//! The check of a whole program, before its start and ahead of it.

use super::*;
use hal_job::dry_run::Target;

/// A machine with X from -10 to 100, Y from -10 to 100 and Z up to 80.
fn machine(program: &str) -> Rig {
    Rig::on_machine(program, |machine, _| {
        machine.settings.axes = hal_gcode::axis::AxisMask(7);
        machine.limits[0] = (Some(-10.0), Some(100.0));
        machine.limits[1] = (Some(-10.0), Some(100.0));
    })
}

#[test]
fn a_job_for_another_machine_is_refused_with_all_reasons_before_anything_begins() {
    let mut rig = machine(
        "G21 G90 G0 X5\nG1 F100 X500 Y-50\nT7 M6\nG1 A5\nG1 X90 Y90\nG0 X501\nG1 Z81\nM2\n",
    );
    rig.fake.journal = "the journal of the job before".to_owned();
    rig.sent();
    let why = rig.refused(Command::Run);
    let folder = format!("{}/job.ngc:", rig.folder.display());
    let reasons: Vec<&str> = why.split(&folder).skip(1).collect();
    let wanted = [
        "2: X500.0000 is 400.0000 mm beyond [AXIS_X]MAX_LIMIT = 100",
        "2: Y-50.0000 is 40.0000 mm beyond [AXIS_Y]MIN_LIMIT = -10",
        "3:1: Requested tool 7 not found in the tool table",
        "4: Bad character 'a' used",
        "7: Z81.0000 is 1.0000 mm beyond [AXIS_Z]MAX_LIMIT = 80",
    ];
    assert_eq!(reasons.len(), wanted.len(), "{reasons:#?}");
    for (reason, wanted) in reasons.iter().zip(wanted) {
        assert!(reason.starts_with(wanted), "{wanted}: {reasons:#?}");
    }
    rig.pass(1.0);
    assert_eq!(rig.sent(), [""; 0], "nothing is sent");
    assert_eq!((rig.core.jobs, rig.core.is_busy()), ((0, 0), false));
    assert_eq!(rig.fake.journal, "the journal of the job before");
}

#[test]
fn a_program_of_another_control_is_refused_by_its_name_first() {
    let mut rig = machine("G21 G90\nG187 P1\nG154 P2\nG0 X1\nM2\n");
    let why = rig.refused(Command::Run);
    let first = "this program is for Haas, not for LinuxCNC (G154, G187); \
                 G187 (1 time, line 2): Haas's smoothing level; leave it out, or use G64 P; \
                 G154 (1 time, line 3): Haas's additional work offset; use G54 to G59.3; ";
    assert!(why.starts_with(first), "{why}");
    assert!(why.contains("G-code out of range: G187"), "{why}");
    // A program of LinuxCNC has its reasons only.
    let mut rig = machine("G187 P1\nG0 X1\nM2\n");
    let why = rig.refused(Command::Run);
    assert!(why.contains("G-code out of range: G187"), "{why}");
    assert!(!why.contains("this program is for"), "{why}");
}

#[test]
fn offsets_and_the_tool_of_the_machine_count_in_the_check() {
    let mut rig = machine("G21 G90 G54 G0 X50\nM2\n");
    rig.core.interpreter.state.frame.g5x.x = 60.0;
    let why = rig.refused(Command::Run);
    assert!(
        why.contains("job.ngc:1: X110.0000 is 10.0000 mm beyond [AXIS_X]MAX_LIMIT = 100"),
        "{why}"
    );
    rig.core.interpreter.state.frame.g5x.x = 50.0;
    rig.run();
}

#[test]
fn what_only_the_machine_knows_ends_the_check_and_not_the_program() {
    for question in ["G38.3 Z-1 F100", "M66 P1 L3 Q1"] {
        let mut rig = machine(&format!("G21 G0 X1\n{question}\nG0 X500\nM2\n"));
        rig.fake.motion.digital_in = 2;
        let sent = rig.run();
        assert!(sent.iter().any(|s| s.starts_with("3: line 500")), "{question}: {sent:?}");
    }
}

/// Returns a program of this many short moves, whose last one is far.
fn long(lines: u32, last: &str) -> String {
    let mut text = "G21 G90 F600\n".to_owned();
    for n in 0..lines {
        text.push_str(&format!("G1 X{}\n", n % 7));
    }
    text + last + "\nM2\n"
}

#[test]
fn a_long_program_begins_before_its_check_ends_and_pauses_before_the_wrong_line() {
    let lines = 90_000;
    let mut rig = machine(&long(lines, "G1 X500"));
    let ticket = rig.send(Command::Run);
    assert_eq!(rig.core.interpreting(), Interpreting::Reading);
    let refused = rig.refused(Command::Mode(Mode::Mdi));
    assert!(refused.contains("while a program is checked"), "{refused}");
    rig.pass(0.15);
    assert_eq!(rig.sent(), [""; 0], "it is still checked");
    rig.pass(0.1);
    assert!(rig.sent().iter().any(|s| s.contains("line")), "it moves after 0.2 s");
    rig.pass(2.0);
    let told = &rig.fake.messages;
    let wanted = format!(
        "job.ngc:{}: X500.0000 is 400.0000 mm beyond [AXIS_X]MAX_LIMIT = 100: the program pauses before this line",
        lines + 2
    );
    assert!(told.len() == 1 && told[0].ends_with(&wanted), "{told:?}");
    assert_eq!(rig.result(ticket), None);
    rig.good(Command::Abort);
    rig.pass(0.5);
    assert!(!rig.core.is_busy());
}

#[test]
fn the_program_pauses_before_a_wrong_line_that_the_check_found_ahead_of_it() {
    let mut text = long(90_000, "G1 X500");
    // The lines until shortly before the end make no moves.
    text = text.replacen("G21 G90 F600\n", "G21 G90 F600\nG0 X1\nG4 P3\n", 1);
    let text = text.replace("G1 X3\n", "#1=3\n").replace("G1 X2\n", "#1=2\n");
    let text: String = text
        .lines()
        .enumerate()
        .map(|(n, line)| match line.starts_with("G1") && n < 89_980 {
            true => "#1=1\n".to_owned(),
            false => format!("{line}\n"),
        })
        .collect();
    let mut rig = machine(&text);
    let ticket = rig.send(Command::Run);
    for _ in 0..2000 {
        rig.pass(0.1);
        if rig.core.interpreting() == Interpreting::Paused {
            break;
        }
    }
    assert_eq!(rig.result(ticket), None);
    assert_eq!(rig.core.interpreting(), Interpreting::Paused);
    let sent = rig.sent();
    assert!(sent.iter().any(|s| s.contains(": line")), "{sent:?}");
    assert!(!sent.iter().any(|s| s.contains("line 500")), "{sent:?}");
    rig.good(Command::Resume);
    rig.pass(0.2);
    assert!(rig.sent().iter().any(|s| s.contains("line 500")), "the operator wanted it");
}

#[test]
fn a_check_ends_with_an_abort_or_the_machine() {
    type End = fn(&mut Rig);
    let ends: [(End, &str); 3] = [
        (|rig| rig.good(Command::Abort), "aborted"),
        (|rig| rig.fake.motion.enabled = false, "the machine was switched off"),
        (|rig| rig.fake.motion.all_homed = false, "a program needs homed joints"),
    ];
    for (end, wanted) in ends {
        let mut rig = machine(&long(90_000, ""));
        let ticket = rig.send(Command::Run);
        rig.pass(0.05);
        end(&mut rig);
        rig.pass(0.3);
        let why = rig.result(ticket).unwrap().unwrap_err();
        assert!(why.contains(wanted), "{why}");
        assert!(!rig.sent().iter().any(|s| s.contains("line")) && !rig.core.is_busy());
    }
}

#[test]
fn a_start_in_the_middle_is_refused_if_the_rest_is_wrong() {
    let mut rig = machine("G21 F100 G0 X5\nG1 X6\nG1 X7\nG1 X500\nM2\n");
    let ticket = rig.send(Command::RunFrom(Target::Line { file: None, line: 3, pass: 1 }));
    rig.pass(0.1);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    rig.sent();
    let why = rig.refused(Command::Confirm(1));
    assert!(why.contains("job.ngc:4: X500.0000 is 400.0000 mm beyond"), "{why}");
    assert_eq!(rig.sent(), [""; 0]);
    assert!(rig.core.shown_start().is_some(), "the proposal stays");
}

#[test]
fn the_time_left_falls_within_a_long_line() {
    let mut rig = machine("G21 G90 F60\nG1 X100\nG1 X0\nM2\n");
    rig.core.world.machine.rates[0][0] = Some(1000.0);
    rig.fake.move_time = 100.0;
    rig.send(Command::Run);
    rig.pass(0.05);
    for _ in 0..19 {
        let before = rig.core.time_left().unwrap();
        rig.pass(5.0);
        let after = rig.core.time_left().unwrap();
        assert!((before - after - 5.0).abs() < 0.5, "{before} before 5 s, {after} after them");
    }
    // A line that takes longer than its estimate leaves what follows it.
    for (_, _, end) in &mut rig.fake.moves {
        *end += 50.0;
    }
    rig.pass(40.0);
    let left = rig.core.time_left().unwrap();
    assert!((left - 100.0).abs() < 1.0, "{left}");
}

#[test]
fn the_time_left_follows_the_machine() {
    // Each move is estimated at 1 s, and takes 0.1 s here.
    let mut rig = machine(&("G21 G90 F600\n".to_owned() + &"G1 X10\nG1 X0\n".repeat(100) + "M2\n"));
    rig.core.world.machine.rates[0][0] = Some(1000.0);
    assert_eq!(rig.core.time_left(), None);
    let ticket = rig.send(Command::Run);
    let first = rig.core.time_left().unwrap();
    assert!((first - 200.0).abs() < 2.0, "{first}");
    rig.pass(15.0);
    let later = rig.core.time_left().unwrap();
    assert!((4.0..12.0).contains(&later), "5 s and what is known of the pace: {later}");
    rig.pass(6.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    assert_eq!(rig.core.time_left(), None);
}

/// A program in RS274-D is checked as a whole, however long that takes.
#[test]
fn a_program_in_rs274d_is_refused_as_a_whole_before_anything_moves() {
    let rig = |program: &str| {
        Rig::on_machine(program, |machine, _| {
            machine.settings.axes = hal_gcode::axis::AxisMask(7);
            machine.settings.dialect = hal_gcode::Dialect::Rs274d;
            machine.limits[0] = (Some(-10.0), Some(100.0));
        })
    };
    let mut text = "G21 F600 # no end is needed\n".to_owned();
    for n in 0..90_000 {
        text.push_str(&format!("G01 X{}\n", n % 7));
    }
    let mut good = rig("G21 F600 (c)\nM03 G01 X5 # c\nG04 P500\n");
    let sent = good.run();
    assert!(sent.iter().any(|s| s.starts_with("2: line 5")), "{sent:?}");
    let warned =
        good.fake.messages.iter().any(|m| m.contains("job.ngc:2: warning: M03 is ignored"));
    assert!(warned, "{:?}", good.fake.messages);
    for (last, wanted) in [
        ("G41 X1", "job.ngc:90002:1: G41 (cutter compensation left) is not part of RS274-D"),
        ("G02 X9 Y9 I1", "job.ngc:90002:1: Radius to end of arc differs from radius to start"),
        ("G01 X500", "job.ngc:90002: X500.0000 is 400.0000 mm beyond [AXIS_X]MAX_LIMIT = 100"),
    ] {
        let mut rig = rig(&format!("{text}{last}\n"));
        let ticket = rig.send(Command::Run);
        rig.pass(2.0);
        let why = rig.result(ticket).unwrap().unwrap_err();
        assert!(why.contains(wanted), "{why}");
        assert_eq!(rig.sent(), [""; 0], "nothing is sent");
        // Nor from its middle.
        let found = rig.send(Command::RunFrom(Target::Line { file: None, line: 3, pass: 1 }));
        rig.pass(3.0);
        assert_eq!(rig.result(found), Some(Ok(())));
        let why = rig.refused(Command::Confirm(1));
        assert!(why.contains(wanted), "{why}");
    }
}
