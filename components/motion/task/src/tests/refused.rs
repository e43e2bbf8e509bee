//! Refusals and failures: each is reported once, with its line, and at a level by who has caused it.

use super::*;

#[test]
fn parameters_that_are_not_saved_are_an_error_of_the_line() {
    let mut rig = Rig::new("G10 L2 P1 X5\nM2\n");
    rig.fake.is_unwritable = true;
    let ticket = rig.send(Command::Run);
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("job.ngc:2: v.var: No space left on device"), "{why}");
    assert_eq!(rig.fake.messages, [why], "told once");
    rig.good(Command::Mode(Mode::Mdi));
    let ticket = rig.send(Command::Mdi("G10 L2 P1 X6".into()));
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert_eq!(why, "v.var: No space left on device");
    rig.fake.is_unwritable = false;
    let ticket = rig.send(Command::Mdi("G10 L2 P1 X7".into()));
    rig.pass(0.5);
    assert_eq!((rig.result(ticket), rig.fake.saved), (Some(Ok(())), Some(7.0)));
}

#[test]
fn a_command_to_switch_on_follows_the_reset_before_it() {
    let mut rig = Rig::new("M2\n");
    (rig.fake.io.estop.commanded, rig.fake.motion.enabled) = (true, false);
    rig.pass(0.1);
    assert_eq!(rig.refused(Command::On), "the machine is in e-stop: task.estop-reset comes first");
    // Both are given before the reset has ended.
    let reset = rig.send(Command::EstopReset);
    let on = rig.send(Command::On);
    assert_eq!(rig.result(on), None);
    rig.fake.io.estop.commanded = false;
    rig.pass(0.1);
    assert_eq!((rig.result(reset), rig.result(on)), (Some(Ok(())), Some(Ok(()))));
    assert!(rig.fake.motion.enabled);
    // A reset that has not helped.
    (rig.fake.io.estop.open, rig.fake.motion.enabled) = (true, false);
    rig.pass(0.1);
    rig.send(Command::EstopReset);
    let on = rig.send(Command::On);
    rig.pass(0.1);
    assert!(rig.result(on).unwrap().unwrap_err().starts_with("the machine is in e-stop"));
}

/// End of a job: its name, its cause, the text of the end, the levels of messages, and the field `ended_by`.
type End = (&'static str, fn(&mut Rig), &'static str, &'static [Level], u32);

const ENDS: [End; 6] = [
    ("the end", |rig| rig.pass(1.0), "", &[], 1),
    ("an abort", |rig| rig.good(Command::Abort), "aborted", &[], 3),
    (
        "an e-stop",
        |rig| (rig.fake.io.estop.commanded, rig.fake.motion.enabled) = (true, false),
        "the machine is in e-stop",
        &[],
        4,
    ),
    ("off", |rig| rig.fake.motion.enabled = false, "the machine was switched off", &[], 5),
    (
        "a refusal of motion",
        |rig| {
            let ends = rig.fake.ends.values_mut().filter(|end| **end == Progress::Pending);
            ends.for_each(|end| *end = Progress::Failed("it is too far".to_owned()));
        },
        ":2: it is too far",
        &[Level::Error],
        2,
    ),
    (
        "home lost",
        |rig| rig.fake.motion.all_homed = false,
        ":2: a joint is no longer homed",
        &[Level::Error],
        2,
    ),
];

#[test]
fn a_stop_by_a_person_is_no_error() {
    for (name, event, text, levels, ended_by) in ENDS {
        let mut rig = Rig::new("G21 G90 F1\nG1 X1\nM2\n");
        rig.fake.move_time = 0.5;
        let ticket = rig.send(Command::Run);
        rig.pass(0.2);
        event(&mut rig);
        rig.pass(0.3);
        let why = rig.result(ticket).unwrap().err().unwrap_or_default();
        assert!(why.ends_with(text) && text.is_empty() == why.is_empty(), "{name}: {why}");
        assert_eq!(rig.fake.levels, levels, "{name}");
        assert_eq!(rig.core.ended_by as u32, ended_by, "{name}");
    }
}

#[test]
fn a_spindle_that_comes_too_late_fails_at_the_line_that_waits() {
    let mut rig = Rig::new("G21 G90 F1\nM3 S100\n\nG1 X1\nM2\n");
    rig.fake.motion.at_speed = false;
    rig.fake.move_time = 100.0;
    let ticket = rig.send(Command::Run);
    rig.pass(6.0);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("job.ngc:4: the spindle was not at speed within 5 s"), "{why}");
}

#[test]
fn a_resume_that_motion_refuses_leaves_the_job_paused() {
    let mut rig = Rig::new("G21 G90 F1\nM3 S100\nG1 X1\nM2\n");
    rig.fake.move_time = 100.0;
    rig.send(Command::Run);
    rig.pass(0.2);
    rig.good(Command::Pause);
    (rig.fake.motion.spindles_stopped, rig.fake.motion.spindles_inhibited) = (1, 1);
    for command in [Command::Resume, Command::Step] {
        if command == Command::Step {
            // A step in the middle of a path is motion's own.
            continue;
        }
        let why = rig.refused(command);
        assert_eq!(why, "spindle 0 was stopped, and cannot turn again: spindle.0.inhibit is TRUE");
    }
    assert_eq!(rig.core.interpreting(), Interpreting::Paused);
    rig.fake.motion.spindles_inhibited = 0;
    rig.sent();
    rig.good(Command::Resume);
    assert_eq!(rig.sent(), ["Resume"]);
}
