//! Gaps in time: the process, the computer or the threads stood still.

use super::Rig;

const CAUSE: &str = "motion stopped: the process stood still";
const MEASURED: [&str; 3] = [
    "joint.0.motor-pos-fb-measured",
    "joint.1.motor-pos-fb-measured",
    "joint.2.motor-pos-fb-measured",
];
const HOMED: [&str; 3] = ["joint.0.homed", "joint.1.homed", "joint.2.homed"];

/// Asserts that the first cycle after a gap has switched the machine off and has moved nothing.
fn stops(rig: &mut Rig, what: &str) {
    rig.strict = false;
    let feedback = [0, 1, 2].map(|n| rig.joint(n, "motor-pos-fb"));
    rig.bench.gap();
    rig.cycle();
    assert!(!rig.is("motion.motion-enabled"), "{what}");
    let commanded = [0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd"));
    assert_eq!(commanded, feedback, "{what}: nothing moves in that cycle");
    rig.cycles(100);
    assert_eq!([0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd")), feedback, "{what}: nor later");
}

#[test]
fn motion_of_any_kind_ends_in_the_first_cycle_after_a_gap() {
    for text in [
        "motion.jog joint=0 velocity=20",
        "motion.jog joint=0 velocity=20 distance=50",
        "motion.move x=100 velocity=20",
        "motion.home joint=1",
    ] {
        let mut rig = Rig::homed(&[]);
        if text.contains("home ") {
            rig.say("motion.configure joint=1 home-search-vel=-5 home-latch-vel=1");
        }
        rig.say(text);
        rig.cycles(200);
        stops(&mut rig, text);
        assert_eq!(rig.bench.said().first().map(String::as_str), Some(CAUSE), "{text}");
        // The command of a jog without an end is done when the jog has begun.
        let is_endless = text.ends_with("velocity=20") && text.contains("jog");
        assert_eq!(rig.end(), if is_endless { Ok(()) } else { Err(CAUSE) }, "{text}");
        // A person switches it on again, and nothing goes on by itself.
        let before = rig.places();
        rig.done("motion.enable");
        rig.cycles(200);
        assert_eq!(rig.places(), before, "{text}");
    }
}

#[test]
fn a_joint_that_moved_is_unhomed_unless_a_sensor_measures_it() {
    for (measured, homed) in
        [(&MEASURED[..0], &HOMED[2..]), (&MEASURED[1..2], &HOMED[1..]), (&MEASURED[..], &HOMED[..])]
    {
        let mut rig = Rig::homed(&[]);
        measured.iter().for_each(|pin| rig.bench.set(pin, true));
        rig.say("motion.jog joint=0 velocity=20");
        rig.say("motion.jog joint=1 velocity=20");
        rig.cycles(200);
        stops(&mut rig, "jogs");
        // Joint 2 did not move.
        assert_eq!(rig.which(&HOMED), homed, "{measured:?}");
        let mut want = vec![CAUSE.to_owned()];
        want.extend((0..2).filter(|n| !measured.contains(&MEASURED[*n])).map(|n| {
            format!(
                "joint {n} is no longer homed: it moved when the process stood still, and only its \
                 own steps are counted"
            )
        }));
        assert_eq!(rig.bench.said(), want);
    }
}

/// A joint that rests loses a volatile home with the power alone, and one that was not homed has none to lose.
#[test]
fn only_homed_joints_that_moved_are_said_to_have_moved() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.configure joint=1 volatile-home=1");
    rig.say("motion.unhome joint=0");
    rig.say("motion.jog joint=0 velocity=20");
    rig.cycles(200);
    assert_eq!(rig.which(&HOMED), HOMED[1..]);
    stops(&mut rig, "a joint without a home");
    assert_eq!(
        (rig.which(&HOMED), rig.bench.said()),
        (HOMED[2..].to_vec(), vec![CAUSE.to_owned()])
    );
}

#[test]
fn a_gap_of_a_machine_at_rest_unhomes_nothing_and_one_that_is_off_only_refuses_old_orders() {
    let mut rig = Rig::homed(&[]);
    rig.cycles(10);
    stops(&mut rig, "rest");
    assert_eq!((rig.which(&HOMED), rig.bench.said()), (HOMED.to_vec(), vec![CAUSE.to_owned()]));
    // An order that waits since before the gap switches nothing on.
    rig.say("motion.enable");
    rig.bench.gap();
    assert!(rig.end().is_err());
    assert!(!rig.is("motion.motion-enabled"));
    assert_eq!(rig.bench.said(), ["a stop has come meanwhile: give the command again"]);
    rig.done("motion.enable");
    rig.done("motion.jog joint=0 velocity=20 distance=1");
}

#[test]
fn gaps_before_the_first_cycle_are_none() {
    let mut rig = Rig::off(&[]);
    rig.bench.gap();
    rig.done("motion.enable");
    rig.cycles(3);
    assert!(rig.is("motion.motion-enabled"));
}

/// A driver may count more than what moved when its hardware is lost.
#[test]
fn a_joint_that_moved_when_hardware_was_lost_is_unhomed_unless_a_sensor_measures_it() {
    for (measured, homed) in
        [(&MEASURED[..0], &HOMED[2..]), (&MEASURED[1..2], &HOMED[1..]), (&MEASURED[..], &HOMED[..])]
    {
        let mut rig = Rig::homed(&[]);
        rig.strict = false;
        measured.iter().for_each(|pin| rig.bench.set(pin, true));
        rig.say("motion.jog joint=0 velocity=20");
        rig.say("motion.jog joint=1 velocity=20");
        rig.cycles(200);
        rig.bench.fail_hardware(true);
        rig.cycle();
        assert!(!rig.is("motion.motion-enabled"));
        assert_eq!(rig.which(&HOMED), homed, "{measured:?}");
        let said = rig.bench.said();
        assert_eq!(said.len(), 1 + 3 - homed.len(), "{said:?}");
        // A second loss at rest unhomes nothing more.
        rig.bench.fail_hardware(false);
        rig.cycles(3);
        rig.bench.fail_hardware(true);
        rig.cycles(3);
        assert_eq!(rig.which(&HOMED), homed, "{measured:?}");
    }
}

/// A driver in a faster thread may have lost its hardware, and have it again, between two cycles.
#[test]
fn a_loss_that_ends_before_the_next_cycle_switches_motion_off() {
    let mut rig = Rig::homed(&[]);
    rig.strict = false;
    rig.say("motion.jog joint=0 velocity=20");
    rig.cycles(200);
    rig.bench.fail_hardware(true);
    rig.bench.fail_hardware(false);
    rig.cycle();
    assert!(!rig.is("motion.motion-enabled"));
    assert_eq!(rig.which(&HOMED), HOMED[1..]);
    let lost = "joint 0 is no longer homed: it moved when a driver lost its hardware, and only its own \
        steps are counted";
    let cause = "motion stopped: a driver has lost its hardware, which its own message names";
    assert_eq!(rig.bench.said(), [cause, lost]);
    let before = rig.places();
    rig.cycles(200);
    assert_eq!(rig.places(), before, "nothing resumes");
    rig.done("motion.enable");
}
