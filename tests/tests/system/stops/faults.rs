//! Faults of a machine that the table must find: each is put into a cell that is good without it.

use super::{
    cell::{Fault, Outcome, Phase, cell, faulty},
    data::{Motion, controls, machines},
    rig::Rig,
};

/// A fault, with the machine, control and motion of a cell that finds it, and what its report says.
const FAULTS: &[(Fault, &str, &str, Motion, &str)] = &[
    (Fault::OldCommand, "rs03n", "halcmd iocontrol.estop", Motion::Line, "not switched off"),
    (Fault::Late, "mill", "halcmd iocontrol.estop", Motion::Jog, "off after 2 cycles"),
    (Fault::Late, "mill", "halcmd motion.abort", Motion::Line, "braking begins after 2 cycles"),
    (Fault::Queue, "mill", "halcmd motion.abort", Motion::Line, "come to rest"),
    (Fault::Resumes, "mill", "halcmd motion.pause", Motion::Line, "come to rest"),
    (Fault::Restarts, "mill", "halcmd iocontrol.estop", Motion::Line, "after reset and on"),
    (Fault::Slow, "mill", "halcmd motion.abort", Motion::Jog, "at rest after"),
];

#[test]
fn every_planted_fault_is_found() {
    for &(fault, name, control, motion, report) in FAULTS {
        let machine = machines().into_iter().find(|m| m.name == name).unwrap();
        let control = controls().into_iter().find(|c| c.name == control).unwrap();
        let mut rig = Rig::start(&machine);
        let sound = cell(&mut rig, &control, motion, Phase::Constant);
        assert!(matches!(sound, Outcome::Good(_)), "{fault:?}: without it: {sound:?}");
        let found = faulty(&mut rig, &control, motion, Phase::Constant, fault);
        let is_found = matches!(&found, Outcome::Bad(why) if why.contains(report));
        assert!(is_found, "{fault:?}: {found:?}");
    }
}
