//! Programs in RS274-D that break off: what they have set returns, and their place is found again.

use super::*;
use hal_gcode::{
    Dialect,
    canon::{PathMode, Unit},
};
use hal_job::journal::Journal;

const PROGRAM: &str = "G21\nG00 X10\nG92 X0\nG01 X5 F60\nG01 X50\nG01 X51\n";
/// X of the offset of G92 in the parameters.
const G92_X: i32 = 5211;

fn rig(program: &str) -> Rig {
    Rig::on_machine(program, |machine, _| {
        machine.settings.axes = hal_gcode::axis::AxisMask(7);
        machine.settings.dialect = Dialect::Rs274d;
    })
}

/// An end of a job, with a part of its reason.
type End = (fn(&mut Rig), &'static str);

const ENDS: [End; 4] = [
    (|rig| rig.good(Command::Abort), "aborted"),
    (
        |rig| {
            rig.fake.io.estop.commanded = true;
            rig.fake.motion.enabled = false;
        },
        "e-stop",
    ),
    (
        |rig| {
            rig.send(Command::Off);
        },
        "switched off",
    ),
    (
        |rig| {
            rig.fake.refuse = Some(Refusal::Why("the drive is too hot".into()));
            for (_, _, end) in &mut rig.fake.moves {
                *end = rig.fake.now;
            }
        },
        "too hot",
    ),
];

#[test]
fn what_a_program_has_set_does_not_outlive_its_job() {
    for (end, why) in ENDS {
        for before in ["G92.1", "G92 X-2"] {
            let mut rig = rig(PROGRAM);
            rig.good(Command::Mode(Mode::Mdi));
            let mdi = rig.send(Command::Mdi(format!("G21 G64 P0.5 {before}").into()));
            rig.pass(0.3);
            assert_eq!(rig.result(mdi), Some(Ok(())), "{why}");
            rig.good(Command::Mode(Mode::Auto));
            let state = |rig: &Rig| {
                let state = &rig.core.interpreter.state;
                let modal = &state.modal;
                (state.frame.g92.x, state.numbered.get(G92_X), modal.unit, modal.path)
            };
            let was = state(&rig);
            assert_eq!((was.2, was.3), (Unit::Millimetre, PathMode::Continuous { tolerance: 0.5 }));
            let ticket = rig.send(Command::Run);
            // The moves behind G92 are in execution, or wait for motion.
            rig.fake.move_time = 0.3;
            rig.pass(0.5);
            end(&mut rig);
            rig.pass(0.3);
            let ended = rig.result(ticket).unwrap_or_else(|| panic!("{why}: no end"));
            assert!(ended.as_ref().is_err_and(|e| e.contains(why)), "{why}: {ended:?}");
            assert_eq!(state(&rig), was, "{why}, {before}");
        }
    }
}

#[test]
fn a_run_after_an_abort_cuts_in_the_same_place() {
    let mut rig = rig(PROGRAM);
    let lines = |rig: &mut Rig| {
        let mut sent = rig.sent();
        sent.retain(|l| l.contains(": line"));
        sent
    };
    rig.run();
    rig.send(Command::Run);
    rig.pass(0.25);
    rig.good(Command::Abort);
    rig.pass(0.3);
    rig.sent();
    rig.send(Command::Run);
    rig.pass(2.0);
    let wanted = ["2: line 10 0 0", "4: line 15 0 0", "5: line 60 0 0", "6: line 61 0 0"];
    assert_eq!(lines(&mut rig), wanted);
    // MDI is in millimetres again.
    rig.good(Command::Mode(Mode::Mdi));
    rig.send(Command::Mdi("G0 X2".into()));
    rig.pass(0.5);
    assert_eq!(lines(&mut rig), ["1: line 2 0 0"]);
}

#[test]
fn a_part_that_was_opened_by_a_relative_name_goes_on_after_an_abort() {
    let mut rig = rig(PROGRAM);
    rig.send(Command::Run);
    rig.pass(0.25);
    rig.good(Command::Abort);
    rig.pass(0.3);
    // The journal of a job that began in the folder of its program, which is not that of the tests.
    let mut begin = Journal::parse(rig.fake.journal.as_bytes()).unwrap().begin;
    begin.name = "part.nc".into();
    begin.state.levels[0].file = "part.nc".into();
    let (_, rest) = rig.fake.journal.split_once('\n').unwrap();
    rig.fake.journal = Record::Begin(begin).line() + rest;
    let found = rig.send(Command::Recover);
    rig.pass(0.3);
    assert_eq!(rig.result(found), Some(Ok(())));
    let ticket = rig.send(Command::Confirm(1));
    rig.pass(2.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
}
