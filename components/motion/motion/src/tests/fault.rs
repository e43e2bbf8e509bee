//! Causes that switch the machine off.

use super::{Rig, near};
use hal_component::{MotionStatus, abi::TicketState};

const AMPS: [&str; 3] =
    ["joint.0.amp-enable-out", "joint.1.amp-enable-out", "joint.2.amp-enable-out"];

/// Asserts that everything is off, and that commands follow the motors.
fn is_off(rig: &mut Rig) {
    rig.strict = false;
    rig.cycles(2);
    assert_eq!(rig.which(&AMPS), [""; 0]);
    assert!(!rig.is("motion.motion-enabled"));
    rig.bench.set("joint.0.motor-pos-fb", 12.5);
    rig.stuck[0] = true;
    rig.cycles(2);
    assert_eq!(rig.joint(0, "motor-pos-cmd"), 12.5);
    assert_eq!(rig.joint(0, "f-error"), 0.0);
    assert!(rig.is("motion.in-position"));
    rig.stuck[0] = false;
}

#[test]
fn each_cause_switches_off_and_is_told_once() {
    for (pin, value, ticket, said) in [
        (
            "motion.enable",
            false,
            "motion stopped by enable input",
            "motion stopped by enable input",
        ),
        ("joint.1.amp-fault-in", true, "joint amplifier fault", "axis Y amplifier fault"),
        (
            "joint.2.pos-lim-sw-in",
            true,
            "joint on limit switch error",
            "axis Z on limit switch error",
        ),
        (
            "joint.0.neg-lim-sw-in",
            true,
            "joint on limit switch error",
            "axis X on limit switch error",
        ),
        (
            "motion.misc-error-01",
            true,
            "motion stopped by misc error",
            "Motion Stopped by misc error 1",
        ),
        ("spindle.0.amp-fault-in", true, "spindle amplifier fault", "spindle 0 amplifier fault"),
    ] {
        for text in [
            "motion.jog joint=0 velocity=20 position=100",
            "motion.move x=100 velocity=20",
            "motion.home joint=all",
        ] {
            let mut rig = Rig::homed(&[]);
            rig.say(text);
            rig.cycles(20);
            assert_eq!(rig.which(&AMPS), AMPS);
            rig.bench.set(pin, value);
            if text.contains("home") && pin.ends_with("lim-sw-in") {
                // Homing may begin on a limit switch.
                rig.cycles(1);
                assert!(rig.is("motion.motion-enabled"));
                continue;
            }
            assert_eq!(rig.end(), Err(ticket), "{pin}: {text}");
            is_off(&mut rig);
            assert_eq!(rig.bench.said(), [said], "{pin}: {text}");
        }
    }
}

#[test]
fn a_joint_that_does_not_follow() {
    let mut rig = Rig::homed(&[]);
    // At 90 units/s the limit is one unit, at rest a quarter.
    near(rig.joint(0, "f-error-lim"), 0.25);
    rig.say("motion.jog joint=0 velocity=45 position=100");
    rig.cycles(100);
    near(rig.joint(0, "f-error-lim"), 0.5);
    rig.stuck[0] = true;
    let mut largest = 0.0;
    while rig.is("motion.motion-enabled") {
        assert!(!rig.is("joint.0.error"));
        largest = rig.joint(0, "f-error");
        rig.cycle();
    }
    assert!(0.45 < largest && largest <= 0.5, "{largest}");
    assert_eq!(rig.bench.said(), ["axis X following error"]);
    assert_eq!(rig.end(), Err("joint following error"));
    assert!(rig.is("joint.0.error") && !rig.is("joint.1.error"));
    rig.strict = false;
    rig.cycles(5);
    // The error is shown until the machine is switched on again.
    assert!(rig.is("joint.0.error"));
    rig.stuck[0] = false;
    rig.done("motion.enable");
    assert!(!rig.is("joint.0.error"));
}

#[test]
fn feedback_that_is_no_number_is_a_following_error() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for wide in [false, true] {
            let mut rig = Rig::homed(&[]);
            if wide {
                rig.say("motion.configure joint=1 ferror=1e300 min-ferror=1e300");
                rig.cycles(1);
            }
            rig.stuck[1] = true;
            rig.bench.set("joint.1.motor-pos-fb", value);
            rig.cycles(1);
            assert!(!rig.is("motion.motion-enabled"));
            assert_eq!(rig.bench.said(), ["axis Y following error"]);
            assert!(rig.joint(1, "motor-pos-cmd").is_finite());
            // It cannot be switched on in this state.
            assert_eq!(rig.failed("motion.enable"), "joint following error");
            assert_eq!(rig.which(&AMPS), [""; 0]);
            rig.strict = false;
            rig.stuck[1] = false;
            rig.cycles(2);
            rig.done("motion.enable");
            rig.done("motion.move x=1 y=2 velocity=9");
            assert_eq!(rig.places(), [1.0, 2.0, 0.0]);
        }
    }
}

#[test]
fn the_machine_stays_off_while_the_cause_lasts() {
    for (pin, value, why) in [
        ("motion.enable", false, "can't enable motion, enable input is false"),
        ("joint.0.pos-lim-sw-in", true, "joint on limit switch error"),
        ("joint.0.amp-fault-in", true, "joint amplifier fault"),
    ] {
        let mut rig = Rig::off(&[]);
        rig.bench.set(pin, value);
        assert_eq!(rig.failed("motion.enable"), why);
        assert_eq!(rig.which(&AMPS), [""; 0]);
        rig.bench.set(pin, !value);
        rig.done("motion.enable");
        assert_eq!(rig.which(&AMPS), AMPS);
    }
}

/// The wire of several switches is cut: all causes come in one cycle.
#[test]
fn several_causes_of_a_joint_at_once_switch_off_as_well() {
    let pins = ["joint.0.pos-lim-sw-in", "joint.0.neg-lim-sw-in", "joint.0.amp-fault-in"];
    for causes in 1..8_u32 {
        let mut rig = Rig::homed(&[]);
        rig.say("motion.jog joint=0 velocity=20 position=100");
        rig.cycles(20);
        for (n, pin) in pins.iter().enumerate() {
            rig.bench.set(pin, causes >> n & 1 == 1);
        }
        rig.strict = false;
        rig.cycle();
        assert_eq!(rig.which(&AMPS), [""; 0], "{causes:03b}");
    }
}

#[test]
fn off_a_switch_with_limits_overridden() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("joint.0.pos-lim-sw-in", true);
    rig.cycles(1);
    assert!(!rig.is("motion.motion-enabled"));
    assert!(rig.is("joint.0.pos-hard-limit") && !rig.is("joint.0.neg-hard-limit"));
    rig.done("motion.override-limits");
    rig.done("motion.enable");
    assert_eq!(rig.bench.said(), ["axis X on limit switch error"]);
    assert_eq!(
        rig.failed("motion.jog joint=0 velocity=5 distance=1"),
        "cannot jog further past the positive limit switch"
    );
    assert_eq!(rig.bench.said(), ["Can't jog axis X further past max hard limit."]);
    rig.say("motion.jog joint=0 velocity=5 distance=-1");
    rig.cycles(100);
    rig.bench.set("joint.0.pos-lim-sw-in", false);
    assert_eq!(rig.end(), Ok(()));
    // The override was for one jog.
    rig.bench.set("joint.0.pos-lim-sw-in", true);
    rig.cycles(2);
    assert!(!rig.is("motion.motion-enabled"));
    // Without a closed switch there is nothing to override.
    rig.bench.set("joint.0.pos-lim-sw-in", false);
    rig.done("motion.override-limits");
    rig.done("motion.enable");
    rig.bench.set("joint.0.pos-lim-sw-in", true);
    rig.cycles(2);
    assert!(!rig.is("motion.motion-enabled"));
}

#[test]
fn a_wheel_does_not_go_farther_onto_an_overridden_switch() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("joint.0.neg-lim-sw-in", true);
    rig.cycles(1);
    rig.done("motion.override-limits");
    rig.done("motion.enable");
    rig.bench.set("joint.0.jog-enable", true);
    rig.bench.set("joint.0.jog-scale", 1.0);
    rig.cycles(1);
    rig.bench.set("joint.0.jog-counts", -3_i32);
    rig.cycles(100);
    assert_eq!(rig.joint(0, "pos-cmd"), 0.0);
}

#[test]
fn switches_of_joints_that_are_not_configured_do_nothing() {
    let mut bench = hal_bench::Bench::new();
    bench.load::<trivkins::Trivkins>(&[]).unwrap();
    bench.load::<crate::Motmod>(&["num_joints=2"]).unwrap();
    bench.command("motion.configure", &["joint=0", "max-velocity=5"]).unwrap();
    bench.set("joint.1.neg-lim-sw-in", true);
    bench.set("joint.1.amp-fault-in", true);
    bench.set("joint.1.motor-pos-fb", f64::NAN);
    bench.command("motion.enable", &[]).unwrap();
    for _ in 0..5 {
        bench.run("motion-command-handler", 1_000_000);
        bench.run("motion-controller", 1_000_000);
    }
    assert!(bench.get::<bool>("motion.motion-enabled"));
    assert!(bench.get::<bool>("joint.0.amp-enable-out"));
    assert!(!bench.get::<bool>("joint.1.amp-enable-out"));
    assert!(!bench.get::<bool>("joint.1.neg-hard-limit"));
}

#[test]
fn disabling_stops_the_spindle() {
    let mut rig = Rig::homed(&[]);
    rig.done("motion.spindle speed=-600");
    rig.cycles(1);
    let bits = ["spindle.0.on", "spindle.0.forward", "spindle.0.reverse", "spindle.0.brake"];
    assert_eq!(rig.which(&bits), ["spindle.0.on", "spindle.0.reverse"]);
    rig.done("motion.disable");
    assert_eq!(rig.which(&bits), ["spindle.0.brake"]);
    assert_eq!(rig.float("spindle.0.speed-out"), 0.0);
    let why = "the spindle cannot turn: the machine is not enabled";
    assert_eq!(rig.failed("motion.spindle speed=1"), why);
}

/// A planner that never runs again: the axes go to the end of what is planned and rest there, and the machine can be
/// operated. Its status is written in every cycle, although nobody reads it.
#[test]
fn a_machine_without_its_planner_rests_and_can_be_operated() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=100 velocity=45");
    rig.cycles(300);
    rig.is_starved = true;
    rig.say("motion.move y=50 velocity=45");
    let waits = rig.bench.tickets().len() - 1;
    let cycle = |rig: &Rig| rig.bench.snapshot::<MotionStatus>("motion.status").cycle;
    let before = cycle(&rig);
    rig.cycles(4000);
    assert_eq!(cycle(&rig), before + 4000);
    assert_eq!(rig.places(), [100.0, 0.0, 0.0]);
    assert_eq!(rig.bench.tickets()[waits], TicketState::Pending);
    rig.done("motion.abort");
    assert_eq!(rig.bench.tickets()[waits], TicketState::Failed("aborted"));
    assert!(rig.is("motion.in-position") && rig.is("motion.motion-enabled"));
    rig.done("motion.jog joint=1 velocity=20 distance=1");
    near(rig.places()[1], 1.0);
    // A move without a planner waits, until it is aborted.
    rig.say("motion.move x=0 velocity=45");
    let places = rig.places();
    rig.cycles(500);
    assert_eq!(rig.places(), places);
    rig.done("motion.abort");
    // With a planner again, what was aborted stays so.
    rig.is_starved = false;
    rig.cycles(500);
    assert_eq!(rig.places(), places);
    rig.done("motion.move x=90 velocity=45");
    near(rig.places()[0], 90.0);
    assert!(rig.bench.said().is_empty(), "{:?}", rig.bench.said());
}
