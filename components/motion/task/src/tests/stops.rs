//! The table `stops.md`: how each state of a job ends by each event, found on the real core.

use super::*;
use hal_gcode::canon::Direction;
use std::fmt::Write as _;

/// A state: its name, a program that comes to it, and the condition by which it is known.
type State = (&'static str, &'static str, fn(&Rig) -> bool);

const STATES: [State; 13] = [
    ("move", "G1 X1\nG1 X2\n", |rig| rig.fake.moves.len() == 2),
    ("move that is held", "G1 X1\nG1 X2\n", |rig| rig.fake.paused),
    ("thread", "M3 S100\nG33 Z-5 K1\n", |rig| !rig.fake.moves.is_empty()),
    ("tap", "M3 S100\nG33.1 Z-5 K1\n", |rig| !rig.fake.moves.is_empty()),
    ("spindle not at speed", "M3 S100\nG1 X1\n", |rig| !rig.fake.moves.is_empty()),
    ("probe", "G38.3 Z-5\n", |rig| !rig.fake.moves.is_empty()),
    ("dwell", "G4 P9\n", |rig| rig.core.interpreting() == Interpreting::Waiting),
    ("input", "M66 P1 L3 Q9\n", |rig| rig.core.interpreting() == Interpreting::Waiting),
    ("user program", "M101\n", |rig| rig.fake.program == Progress::Pending),
    ("pause (M0)", "M8\nM0\n", |rig| rig.core.interpreting() == Interpreting::Paused),
    ("tool is prepared", "T2 M6\n", |rig| !rig.fake.changer.is_empty()),
    ("tool is changed", "T2 M6\n", |rig| {
        rig.fake.changer.front().is_some_and(|(_, r)| *r == IoRequest::Change)
    }),
    ("single steps", "G1 X1\nG1 X2\n", |rig| rig.core.is_stepping() && rig.fake.moves.is_empty()),
];

/// An event: its name, and what does it. A command returns the ticket of its result.
type Event = (&'static str, fn(&mut Rig) -> Option<Ticket>);

const EVENTS: [Event; 8] = [
    ("abort", |rig| Some(rig.send(Command::Abort))),
    ("e-stop", |rig| {
        (rig.fake.io.estop.commanded, rig.fake.motion.enabled) = (true, false);
        None
    }),
    ("amplifiers off", |rig| {
        rig.fake.motion.enabled = false;
        None
    }),
    ("motion or changer fails", |rig| {
        let ends = rig.fake.ends.values_mut().filter(|end| **end == Progress::Pending);
        ends.for_each(|end| *end = Progress::Failed("it failed".to_owned()));
        None
    }),
    ("home lost", |rig| {
        rig.fake.motion.all_homed = false;
        None
    }),
    ("mode manual", |rig| Some(rig.send(Command::Mode(Mode::Manual)))),
    ("run", |rig| Some(rig.send(Command::Run))),
    ("open", |rig| {
        let path = rig.folder.join("job.ngc");
        Some(rig.send(Command::Open(path)))
    }),
];

/// Runs a program to a state.
fn at((name, program, is_there): State) -> (Rig, Ticket) {
    let mut rig = Rig::new(&format!("G21 G90 F100\n{program}M2\n"));
    let path = rig.folder.join("M101");
    std::fs::write(&path, "#!/bin/sh\n").unwrap();
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    rig.fake.motion.at_speed = name != "spindle not at speed";
    let steps = name == "single steps";
    let ticket = rig.send(if steps { Command::Step } else { Command::Run });
    for _ in 0..100 {
        if is_there(&rig) {
            assert_eq!(rig.result(ticket), None, "{name}");
            return (rig, ticket);
        }
        if name == "move that is held" && rig.fake.moves.len() == 2 {
            rig.good(Command::Pause);
            continue;
        }
        if name == "tool is changed" {
            rig.fake.answer_changer();
        }
        rig.pass(0.01);
    }
    panic!("{name}: the state is not reached");
}

/// Returns how the job goes on or ends.
fn outcome(state: State, event: Event) -> String {
    let (mut rig, ticket) = at(state);
    rig.sent();
    let command = event.1(&mut rig);
    rig.pass(0.3);
    let said = command.and_then(|ticket| rig.result(ticket)).and_then(Result::err);
    let result = rig.result(ticket);
    if result.is_none_or(|result| result.is_ok()) {
        return if said.is_some() { "refused".to_owned() } else { "goes on".to_owned() };
    }
    // Every end is the same end.
    let name = format!("{} by {}", state.0, event.0);
    let sent = rig.sent();
    assert!(sent.iter().any(|s| s == "Abort"), "{name}: {sent:?}");
    assert_eq!(rig.core.interpreting(), Interpreting::Idle, "{name}");
    assert!(rig.fake.moves.is_empty() && rig.fake.changer.is_empty(), "{name}: something goes on");
    assert_eq!((rig.core.queue_len(), rig.core.mdi_len()), (0, 0), "{name}");
    assert_ne!(rig.fake.program, Progress::Pending, "{name}: the user's program goes on");
    let modal = &rig.core.interpreter.state.modal;
    assert!(!modal.flood && !modal.mist, "{name}: coolant");
    assert_eq!(modal.spindles[0].direction, Direction::Stopped, "{name}");
    rig.pass(5.0);
    assert_eq!(rig.sent(), [""; 0], "{name}: nothing goes on by itself");
    let power = match rig.core.power {
        Power::Estop => ", in e-stop",
        Power::Off => ", off",
        Power::On => "",
    };
    rig.fake.motion.enabled = true;
    rig.fake.io.estop.commanded = false;
    rig.step();
    rig.good(Command::Mode(Mode::Auto));
    let homed = if rig.fake.motion.all_homed {
        ""
    } else {
        let why = rig.refused(Command::Run);
        assert!(why.starts_with("a program needs homed joints: task.home joint=all"), "{why}");
        rig.fake.motion.all_homed = true;
        ", not homed"
    };
    let again = rig.send(Command::Run);
    let tool = match rig.result(again) {
        Some(Err(why)) if why.contains("was interrupted") => ", tool unknown",
        Some(Err(why)) => panic!("{name}: the next job: {why}"),
        _ => "",
    };
    format!("ends{power}{homed}{tool}")
}

#[test]
fn every_state_ends_as_the_table_says() {
    let mut text = "# Ends of jobs\n\nWritten by `UPDATE_EXPECT=1 cargo test -p task stops`, from the real core.\n\n\
        `ends`: motion brakes and the rest of the path is gone, spindles and coolant stop, requests to the changer are withdrawn, a \
        user's program ends, nothing goes on by itself, and the next program runs (`tool unknown`: after M61; `not homed`: after homing). `goes on`: the event \
        changes nothing. `refused`: so is the command.\n\n| in | "
        .to_owned();
    let names: Vec<&str> = EVENTS.iter().map(|(name, _)| *name).collect();
    writeln!(text, "{} |\n|---|{}", names.join(" | "), "---|".repeat(names.len())).unwrap();
    for state in STATES {
        let cells: Vec<String> = EVENTS.iter().map(|event| outcome(state, *event)).collect();
        writeln!(text, "| {} | {} |", state.0, cells.join(" | ")).unwrap();
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/stops.md");
    hal_golden::check(path.as_ref(), &text);
}

#[test]
fn a_machine_without_homing_runs_on_without_home() {
    let mut rig = Rig::with("G21 F100\nG1 X1\nG1 X2\nM2\n", |rules| rules.needs_homing = false);
    let ticket = rig.send(Command::Run);
    rig.pass(0.05);
    rig.fake.motion.all_homed = false;
    rig.pass(1.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
}

#[test]
fn an_override_that_counts_again_is_the_operators_although_motion_is_full() {
    let mut rig = Rig::new("M50 P0\nG4 P1\nM50 P1\nG4 P1\nM2\n");
    rig.good(Command::FeedOverride(0.5));
    rig.good(Command::RapidOverride(0.25));
    rig.send(Command::Run);
    rig.pass(0.5);
    assert_eq!((rig.fake.motion.feed_override, rig.core.feed.scale), (1.0, 0.5));
    assert_eq!((rig.fake.motion.rapid_override, rig.core.feed.rapid), (1.0, 0.25));
    for _ in 0..70 {
        rig.fake.refuse = Some(Refusal::Full);
        rig.pass(0.01);
    }
    rig.fake.refuse = None;
    rig.pass(0.3);
    assert_eq!((rig.fake.motion.feed_override, rig.core.feed.scale), (0.5, 0.5));
    assert_eq!((rig.fake.motion.rapid_override, rig.core.feed.rapid), (0.25, 0.25));
}

#[test]
fn an_analog_input_without_a_number_ends_the_job() {
    let mut rig = Rig::new("G21\nM66 E0 L0\n#1=#5399\nG0 X1\nM2\n");
    rig.fake.motion.analog_in[0] = f64::NAN;
    let ticket = rig.send(Command::Run);
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(
        why.ends_with("job.ngc:2: analog input 0 is NaN, which is not a finite number"),
        "{why}"
    );
    assert!(!rig.sent().iter().any(|s| s.contains("line")), "nothing moves");
}
