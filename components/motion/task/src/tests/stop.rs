//! Ends of jobs: abort, error, e-stop, off, at each state.

use super::*;

const JOB: &str = "G21 G91 G1 X1 F100\nG90 G1 X2\nM8\nG4 P1\nT2 M6\nG43 H2\nM66 P1 L3 Q5\nM0\n\
                   M3 S500\nG38.3 Z-5\nM101\nG0 X9\nM2\n";

/// The states of the job in which something ends it: seconds that pass, and a person who answers.
const STATES: [(&str, f64, bool); 9] = [
    ("first move", 0.05, false),
    ("second move", 0.15, false),
    ("dwell", 0.7, false),
    ("prepare", 1.5, false),
    ("change", 1.5, true),
    ("input", 2.0, true),
    ("pause", 7.0, true),
    ("probe", 7.2, true),
    ("user program", 8.0, true),
];

/// Runs the job to a state.
fn at(state: &str, seconds: f64, answers: bool) -> (Rig, Ticket) {
    let mut rig = Rig::new(JOB);
    let path = rig.folder.join("M101");
    std::fs::write(&path, "#!/bin/sh\n").unwrap();
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    let ticket = rig.send(Command::Run);
    let mut left = seconds;
    while left > 0.005 {
        rig.pass(0.05);
        left -= 0.05;
        let changing = rig.fake.changer.front().is_some_and(|(_, r)| *r == IoRequest::Change);
        if answers && !(changing && state == "change") {
            rig.fake.answer_changer();
        }
        if ["probe", "user program"].contains(&state)
            && rig.core.interpreting() == Interpreting::Paused
        {
            rig.good(Command::Resume);
        }
    }
    assert_eq!(rig.result(ticket), None, "{state}: the job has not ended");
    (rig, ticket)
}

/// Checks that everything has ended, and that the next job runs.
fn check_ended(rig: &mut Rig, ticket: Ticket, state: &str, why: &str) {
    rig.pass(0.1);
    let result = rig.result(ticket).unwrap_or_else(|| panic!("{state}: no result"));
    let result = result.unwrap_err();
    assert!(result.contains(why), "{state}: {result}");
    let sent = rig.sent();
    assert!(sent.contains(&"Abort".to_owned()), "{state}: {sent:?}");
    assert_eq!(rig.core.interpreting(), Interpreting::Idle, "{state}");
    assert!(rig.fake.moves.is_empty() && rig.fake.changer.is_empty(), "{state}");
    assert_eq!(rig.fake.program, Progress::Done, "{state}: the user's program has ended");
    assert_eq!((rig.core.mdi_len(), rig.core.queue_len()), (0, 0), "{state}");
    let modal = &rig.core.interpreter.state.modal;
    assert!(!modal.flood && !modal.mist, "{state}: coolant");
    assert_eq!(modal.spindles[0].direction, hal_gcode::canon::Direction::Stopped, "{state}");
    rig.pass(10.0);
    assert!(rig.sent().is_empty(), "{state}: nothing goes on by itself");
}

#[test]
fn an_abort_ends_the_job_in_every_state() {
    for (state, seconds, answers) in STATES {
        let (mut rig, ticket) = at(state, seconds, answers);
        rig.good(Command::Abort);
        check_ended(&mut rig, ticket, state, "aborted");
        // The task goes on from the state of the machine.
        let tool = rig.fake.io.tool.max(0);
        assert_eq!(rig.core.interpreter.state.tool.number, tool, "{state}");
        rig.good(Command::Mode(Mode::Mdi));
        let mdi = rig.send(Command::Mdi("G90 G21 G53 G0 X7 Y0 Z0".into()));
        rig.pass(0.5);
        assert_eq!(rig.result(mdi), Some(Ok(())), "{state}");
        assert_eq!(rig.sent(), ["1: line 7 0 0"], "{state}");
    }
}

#[test]
fn e_stop_and_off_end_the_job_in_every_state() {
    for (state, seconds, answers) in STATES {
        let (mut rig, ticket) = at(state, seconds, answers);
        rig.fake.io.estop.commanded = true;
        rig.fake.motion.enabled = false;
        rig.step();
        assert_eq!(rig.core.power, Power::Estop);
        check_ended(&mut rig, ticket, state, "e-stop");
        let why = rig.refused(Command::Run);
        assert!(why.contains("not possible in e-stop"), "{state}: {why}");

        let (mut rig, ticket) = at(state, seconds, answers);
        rig.send(Command::Off);
        rig.step();
        assert_eq!(rig.core.power, Power::Off);
        check_ended(&mut rig, ticket, state, "switched off");
    }
}

#[test]
fn the_modal_state_after_an_abort_is_that_of_the_line_in_motion() {
    let mut rig = Rig::new("G21 G91 G1 X1 F100\nG1 X1\nG90 G55 G20 G1 X5\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.15);
    assert_eq!(rig.core.line(), 2);
    let ahead = &rig.core.interpreter.state.modal;
    assert!(ahead.absolute, "the program was read to its end");
    rig.good(Command::Abort);
    rig.pass(0.1);
    let modal = &rig.core.interpreter.state.modal;
    assert!(!modal.absolute && modal.system == 1);
    assert_eq!(modal.unit, hal_gcode::canon::Unit::Millimetre);
    rig.sent();
    rig.good(Command::Mode(Mode::Mdi));
    rig.send(Command::Mdi("G1 X1".into()));
    rig.pass(0.5);
    assert_eq!(rig.sent(), ["1: line 2 0 0"], "incremental, from where the abort left it");
}

#[test]
fn an_error_behind_a_fact_of_the_machine_ends_the_job_behind_the_lines_before_it() {
    let mut rig = Rig::new("G21 G0 X1\nM66 P1 L0\nG0 X2\nG1 Y\nG0 X3\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    assert_eq!(rig.result(ticket), None);
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("job.ngc:4"), "{why}");
    assert_eq!(rig.sent(), ["1: line 1 0 0", "3: line 2 0 0", "Abort", "Abort"]);
    assert_eq!(rig.fake.messages, [why]);
    assert_eq!(rig.core.jobs, (1, 1));
}

#[test]
fn a_refused_move_ends_the_job_at_its_line() {
    let mut rig = Rig::new("G21 G4 P0.1\nG0 X999\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.step();
    rig.fake.refuse = Some(Refusal::Why("beyond the limit of x".into()));
    rig.pass(0.2);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("job.ngc:2: beyond the limit of x"), "{why}");
}

#[test]
fn a_full_motion_takes_the_move_later() {
    let mut rig = Rig::new("G21 G4 P0.1\nG0 X1\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.step();
    rig.fake.refuse = Some(Refusal::Full);
    rig.pass(1.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    assert_eq!(rig.sent()[0], "2: line 1 0 0");
}

#[test]
fn a_spindle_that_does_not_reach_its_speed_ends_the_job() {
    let mut rig = Rig::new("M3 S100\nG21 G1 X1 F100\nM2\n");
    rig.fake.motion.at_speed = false;
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    rig.fake.paused = true;
    rig.pass(4.0);
    assert_eq!(rig.result(ticket), None);
    rig.pass(1.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("not at speed within 5 s"), "{why}");
}

#[test]
fn a_refusal_has_every_reason() {
    let mut rig = Rig::new("M2\n");
    rig.good(Command::Mode(Mode::Manual));
    rig.fake.motion.all_homed = false;
    rig.fake.motion.enabled = false;
    rig.step();
    assert_eq!(
        rig.refused(Command::Run),
        "a program needs a machine that is on: task.on comes first; a program needs mode auto, the \
         mode is manual: task.mode mode=auto; a program needs homed joints: task.home joint=all"
    );
    assert!(rig.refused(Command::Open("/none.ngc".into())).contains("No such file"));
    let mut rig = Rig::with("G21 G0 X1\nM2\n", |rules| rules.needs_homing = false);
    rig.fake.motion.all_homed = false;
    assert_eq!(rig.run()[0], "1: line 1 0 0");
}

/// In e-stop the machine is switched off, also where nothing else does it.
#[test]
fn an_estop_switches_motion_off() {
    let mut rig = Rig::new("M2\n");
    rig.step();
    assert!(rig.fake.motion.enabled);
    rig.fake.io.estop = Estop { commanded: true, open: false };
    rig.step();
    assert!(!rig.fake.motion.enabled, "{:?}", rig.fake.log);
    // After the e-stop it stays off.
    rig.fake.io.estop = Estop { commanded: false, open: false };
    rig.pass(1.0);
    assert!(!rig.fake.motion.enabled);
}

#[test]
fn the_parameters_after_an_abort_are_those_of_the_line_in_motion() {
    let mut rig = Rig::new(
        "G21 G10 L2 P1 X5\n#100=7\nG1 X1 F100\n#100=8\n#100=9\nG10 L2 P1 X50\nG92 X0\nG10 L1 P1 Z99\n\
         G1 X2\n#101=3\nM2\n",
    );
    rig.send(Command::Run);
    rig.pass(0.05);
    let numbered = &rig.core.interpreter.state.numbered;
    assert_eq!([5221, 100, 101].map(|n| numbered.get(n)), [50.0, 9.0, 3.0], "read ahead");
    rig.good(Command::Abort);
    rig.pass(0.1);
    let state = &rig.core.interpreter.state;
    assert_eq!([5221, 5211, 100, 101].map(|n| state.numbered.get(n)), [5.0, 0.0, 7.0, 0.0]);
    assert_eq!((state.frame.g5x.x, state.frame.g92.x), (5.0, 0.0), "the active frame");
    assert_eq!(rig.fake.saved, Some(5.0), "the parameter file");
    // The tool table is unchanged, and so is what a program sees of it.
    rig.good(Command::Mode(Mode::Mdi));
    rig.send(Command::Mdi("G43 H1".into()));
    rig.pass(0.5);
    assert_eq!(rig.core.interpreter.state.frame.tool.z, 10.0);
}

#[test]
fn a_result_of_the_machine_stays_after_an_abort() {
    let mut rig = Rig::new("G21 M66 P3 L3 Q5\n#1=#5399\nG4 P1\n#1=7\nG4 P1\nM2\n");
    rig.send(Command::Run);
    rig.fake.motion.digital_in = 1 << 3;
    rig.pass(0.5);
    rig.good(Command::Abort);
    rig.pass(0.1);
    let numbered = &rig.core.interpreter.state.numbered;
    assert_eq!([5399, 1].map(|n| numbered.get(n)), [1.0, 1.0]);
}

#[test]
fn stops_are_counted_also_without_a_job() {
    let mut rig = Rig::new("M2\n");
    rig.pass(0.1);
    let before = rig.core.stops;
    rig.good(Command::Abort);
    assert_eq!(rig.core.stops, before + 1, "an abort");
    rig.fake.io.estop = Estop { commanded: true, open: false };
    rig.pass(0.1);
    assert_eq!(rig.core.stops, before + 2, "an e-stop");
    rig.pass(0.1);
    assert_eq!(rig.core.stops, before + 2, "once");
}

#[test]
fn a_run_that_was_asked_for_before_a_stop_is_refused() {
    let mut rig = Rig::new("G21 G91 G1 X1 F100\nM2\n");
    rig.pass(0.1);
    let before = rig.core.stops;
    rig.good(Command::Abort);
    let why = rig.refused(Command::RunUnlessStopped(before));
    assert_eq!(why, "a stop has come meanwhile: give the command again");
    assert!(rig.fake.moves.is_empty());
    rig.pass(1.0);
    let ticket = rig.send(Command::RunUnlessStopped(before + 1));
    rig.pass(5.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
}

/// Somebody else stops motion, as its service does: the moves end, and the epoch rises.
fn stop_by_another(rig: &mut Rig) {
    for (id, ..) in rig.fake.moves.drain(..) {
        rig.fake.ends.insert(id, Progress::Failed("aborted".to_owned()));
    }
    rig.fake.motion.epoch.stops += 1;
    (rig.fake.motion.in_position, rig.fake.motion.queue) = (true, 0);
}

#[test]
fn a_stop_of_motion_by_another_ends_the_job_in_every_state() {
    for (state, seconds, answers) in STATES {
        let (mut rig, ticket) = at(state, seconds, answers);
        let aborts = |rig: &mut Rig| rig.sent().iter().filter(|s| *s == "Abort").count();
        aborts(&mut rig);
        stop_by_another(&mut rig);
        rig.step();
        // Coolant and changer end; motion, which is stopped, gets no second abort.
        assert_eq!(aborts(&mut rig), 1, "{state}");
        rig.fake.log.push("Abort".to_owned());
        check_ended(&mut rig, ticket, state, "aborted");
        // What is given after the stop runs.
        rig.good(Command::Mode(Mode::Mdi));
        let mdi = rig.send(Command::Mdi("G90 G21 G53 G0 X7 Y0 Z0".into()));
        rig.pass(0.5);
        assert_eq!(rig.result(mdi), Some(Ok(())), "{state}");
    }
}

#[test]
fn a_pause_of_motion_by_another_pauses_the_job_in_every_state() {
    for (state, seconds, answers) in STATES {
        let (mut rig, ticket) = at(state, seconds, answers);
        rig.fake.motion.epoch.pauses += 1;
        rig.fake.paused = true;
        rig.step();
        assert_eq!(rig.core.interpreting(), Interpreting::Paused, "{state}");
        rig.sent();
        rig.pass(5.0);
        assert!(rig.sent().iter().all(|s| !s.contains("line")), "{state}: nothing begins");
        assert_eq!(rig.result(ticket), None, "{state}");
        rig.good(Command::Resume);
        assert!(!rig.fake.paused, "{state}: motion goes on");
        assert_ne!(rig.core.interpreting(), Interpreting::Paused, "{state}");
    }
}

#[test]
fn commands_that_were_given_before_a_stop_begin_nothing() {
    const LATE: &str = "a stop has come meanwhile: give the command again";
    let line = || Box::<str>::from("G0 X1");
    let all = |stops: u32, pauses: u32| {
        let mut rig = Rig::new("G21 G91 G1 X1 F100\nM2\n");
        rig.pass(0.1);
        let given = rig.fake.motion.epoch;
        rig.fake.motion.epoch.stops += stops;
        rig.fake.motion.epoch.pauses += pauses;
        let mut refused = Vec::new();
        for (name, command) in [
            ("reset", Command::EstopReset),
            ("on", Command::On),
            ("home", Command::Home(None)),
            ("run", Command::Run),
            ("confirm", Command::Confirm(1)),
            ("resume", Command::Resume),
            ("step", Command::Step),
            ("mdi", Command::Mdi(line())),
            ("brief", Command::BriefMdi(line())),
            ("estop", Command::Estop),
            ("off", Command::Off),
            ("pause", Command::Pause),
            ("abort", Command::Abort),
        ] {
            rig.tickets += 1;
            let ticket = Ticket(rig.tickets);
            rig.core.command(command, given, ticket, &mut rig.fake);
            if rig.result(ticket) == Some(Err(LATE.to_owned())) {
                refused.push(name);
            }
        }
        refused
    };
    let both = ["reset", "on", "home", "run", "confirm", "resume", "step", "mdi", "brief"];
    assert_eq!(all(1, 0), both);
    assert_eq!(all(0, 1), ["home", "resume", "step", "mdi", "brief"]);
    assert_eq!(all(0, 0), [""; 0]);
}

#[test]
fn a_line_of_mdi_that_waits_does_not_outlive_a_stop() {
    for (stops, pauses) in [(1, 0), (0, 1)] {
        let mut rig = Rig::new("M2\n");
        rig.good(Command::Mode(Mode::Mdi));
        rig.send(Command::Mdi("G4 P1".into()));
        let waits = rig.send(Command::Mdi("G21 G0 X1".into()));
        rig.pass(0.1);
        rig.fake.motion.epoch.stops += stops;
        rig.fake.motion.epoch.pauses += pauses;
        rig.step();
        if pauses > 0 {
            rig.good(Command::Resume);
        }
        rig.pass(3.0);
        let end = rig.result(waits).unwrap().unwrap_err();
        assert!(end == "aborted" || end.starts_with("a stop has come"), "{end}");
        assert!(rig.sent().iter().all(|s| !s.contains("line")));
    }
}
