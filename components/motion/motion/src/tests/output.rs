//! Spindles that orient and reach their speed, and outputs for programs.

use super::Rig;

const BITS: [&str; 4] = ["spindle.0.orient", "spindle.0.locked", "spindle.0.brake", "spindle.0.on"];

#[test]
fn a_spindle_orients() {
    let mut rig = Rig::on(&[]);
    rig.done("motion.spindle speed=600");
    rig.say("motion.spindle-orient angle=90 mode=2");
    rig.cycles(5);
    assert_eq!(rig.which(&BITS), ["spindle.0.orient"]);
    assert_eq!(rig.float("spindle.0.orient-angle"), 90.0);
    assert_eq!(rig.bench.get::<i32>("spindle.0.orient-mode"), 2);
    rig.bench.set("spindle.0.is-oriented", true);
    assert_eq!(rig.end(), Ok(()));
    assert_eq!(rig.which(&BITS), ["spindle.0.locked", "spindle.0.brake"]);
    // The spindle stays locked until the next command.
    rig.bench.set("spindle.0.is-oriented", false);
    rig.cycles(5);
    assert_eq!(rig.which(&BITS), ["spindle.0.locked", "spindle.0.brake"]);
    rig.done("motion.spindle speed=-600");
    assert_eq!(rig.which(&BITS), ["spindle.0.on"]);
    // Events that abort an orientation, or replace it.
    for (text, bits) in [
        ("motion.spindle speed=10", &["spindle.0.on"][..]),
        ("motion.spindle speed=0", &["spindle.0.brake"]),
        ("motion.spindle-orient angle=0", &["spindle.0.orient"]),
        ("motion.abort", &["spindle.0.brake"]),
        ("motion.disable", &["spindle.0.brake"]),
    ] {
        rig.say("motion.spindle-orient angle=360 mode=1");
        rig.cycles(2);
        assert_eq!(rig.which(&BITS), ["spindle.0.orient"]);
        rig.say(text);
        rig.cycles(2);
        assert_eq!(rig.which(&BITS), bits, "{text}");
        rig.bench.set("spindle.0.is-oriented", true);
        rig.cycles(2);
        let goes_on = text.contains("orient");
        assert_eq!(rig.is("spindle.0.locked"), goes_on, "{text}");
        rig.bench.set("spindle.0.is-oriented", false);
    }
}

/// Another angle during an orientation: `orient` falls for a cycle, so that the drive accepts the new angle.
#[test]
fn another_angle_begins_anew() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.spindle-orient angle=90");
    rig.cycles(5);
    rig.say("motion.spindle-orient angle=180");
    rig.cycle();
    assert_eq!(rig.which(&BITS), [""; 0]);
    assert_eq!(rig.float("spindle.0.orient-angle"), 180.0);
    // An is-oriented that belongs to the previous angle does not count.
    rig.bench.set("spindle.0.is-oriented", true);
    rig.cycle();
    assert_eq!(rig.which(&BITS), ["spindle.0.orient"]);
    rig.bench.set("spindle.0.is-oriented", false);
    rig.cycles(5);
    assert_eq!(rig.which(&BITS), ["spindle.0.orient"]);
    rig.bench.set("spindle.0.is-oriented", true);
    rig.cycle();
    assert_eq!(rig.which(&BITS), ["spindle.0.locked", "spindle.0.brake"]);
}

/// A spindle that turns is not locked, whatever is-oriented is.
#[test]
fn a_turning_spindle_is_not_locked() {
    for speed in [5.0, -0.11, f64::NAN, f64::INFINITY] {
        let mut rig = Rig::on(&[]);
        rig.bench.set("spindle.0.speed-in", speed);
        rig.bench.set("spindle.0.is-oriented", true);
        rig.say("motion.spindle-orient angle=90");
        rig.cycles(900);
        assert_eq!(rig.which(&BITS), ["spindle.0.orient"], "{speed}");
        assert_eq!(rig.bench.said(), [""; 0]);
        // After a second the operator is informed, once.
        rig.cycles(3000);
        assert_eq!(rig.which(&BITS), ["spindle.0.orient"], "{speed}");
        assert_eq!(
            rig.bench.said(),
            [format!(
                "spindle 0 is not locked: is-oriented is TRUE, but speed-in is {speed} turns/s"
            )]
        );
        rig.bench.set("spindle.0.speed-in", 0.1);
        assert_eq!(rig.end(), Ok(()));
        assert_eq!(rig.which(&BITS), ["spindle.0.locked", "spindle.0.brake"]);
        // Once locked, only a command unlocks the spindle.
        rig.bench.set("spindle.0.speed-in", speed);
        rig.cycles(5);
        assert_eq!(rig.which(&BITS), ["spindle.0.locked", "spindle.0.brake"]);
    }
}

#[test]
fn a_fault_ends_it() {
    let mut rig = Rig::on(&[]);
    rig.bench.set("spindle.0.orient-fault", 7_i32);
    rig.cycles(3);
    assert_eq!(rig.bench.said(), [""; 0]);
    assert_eq!(rig.failed("motion.spindle-orient angle=45"), "spindle orient fault");
    assert_eq!(rig.bench.said(), ["spindle 0 orient fault 7"]);
    assert_eq!(rig.which(&BITS), ["spindle.0.brake"]);
    for (text, why) in [
        ("spindle=1 angle=0", "there is no spindle 1, there are 1"),
        ("spindle=-1 angle=0", "there is no spindle -1, there are 1"),
        ("angle=361", "angle is 361, must be 0 to 360"),
        ("angle=nan", "angle is NaN, must be a finite number"),
        ("angle=0 mode=3", "there is no mode 3, there are 0, 1 and 2"),
    ] {
        assert_eq!(rig.try_say(&format!("motion.spindle-orient {text}")), Err(why.into()));
    }
    rig.done("motion.disable");
    let why = "the spindle cannot turn: the machine is not enabled";
    assert_eq!(rig.failed("motion.spindle-orient angle=0"), why);
}

#[test]
fn moves_wait_for_the_speed() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("spindle.0.at-speed", false);
    // Moves do not wait for a spindle at rest.
    rig.done("motion.move x=1 velocity=50");
    rig.done("motion.spindle speed=600");
    rig.say("motion.move x=2 velocity=50");
    rig.cycles(500);
    assert_eq!(rig.joint(0, "pos-cmd"), 1.0);
    assert!(!rig.is("motion.in-position"));
    rig.bench.set("spindle.0.at-speed", true);
    rig.cycles(2);
    assert!(rig.joint(0, "pos-cmd") > 1.0);
    // A move that has begun continues.
    rig.bench.set("spindle.0.at-speed", false);
    assert_eq!(rig.end(), Ok(()));
    assert_eq!(rig.joint(0, "pos-cmd"), 2.0);
    // A waiting move can be aborted, and a jog does not wait.
    rig.say("motion.move x=3 velocity=50");
    rig.cycles(10);
    rig.done("motion.abort");
    rig.done("motion.jog joint=0 velocity=50 position=5");
}

#[test]
fn outputs_for_programs() {
    let mut rig = Rig::off(&[]);
    rig.done("motion.digital-out index=3 value=1");
    rig.done("motion.analog-out index=0 value=-2.5");
    assert!(rig.is("motion.digital-out-03") && !rig.is("motion.digital-out-02"));
    assert_eq!(rig.float("motion.analog-out-00"), -2.5);
    rig.done("motion.digital-out index=3 value=0");
    assert!(!rig.is("motion.digital-out-03"));
    for (text, why) in [
        ("motion.digital-out index=4 value=1", "there is no index 4, there are 4 outputs"),
        ("motion.analog-out index=-1 value=1", "there is no index -1, there are 4 outputs"),
        ("motion.analog-out index=0 value=inf", "value is inf, must be a finite number"),
    ] {
        assert_eq!(rig.try_say(text), Err(why.into()));
    }
}

#[test]
fn feeds_follow_the_unit_of_the_machine() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.move x=30 velocity=5");
    rig.cycles(2000);
    let feeds = |rig: &Rig| {
        ["motion.feed-upm", "motion.feed-mm-per-minute"].map(|pin| rig.float(pin).round())
    };
    let before = feeds(&rig);
    assert!(before[0] > 0.0 && before[0] == before[1], "{before:?}");
    rig.say("motion.configure linear-units=inch");
    rig.cycle();
    assert_eq!(feeds(&rig), [before[0], (before[0] * 25.4).round()]);
}

#[test]
fn the_limits_of_a_spindle() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.configure spindle=0 min-forward-velocity=100 max-forward-velocity=2000");
    let speed = |rig: &mut Rig, text: &str| {
        rig.done(&format!("motion.spindle {text}"));
        rig.cycle();
        rig.float("spindle.0.speed-out")
    };
    for (text, out) in [
        ("speed=1000", 1000.0),
        ("speed=3000", 2000.0),
        ("override=0.5", 1500.0),
        ("override=0.01", 100.0),
        ("speed=-50 override=1", -100.0),
        ("speed=-5000", -2000.0),
        ("speed=0", 0.0),
    ] {
        assert_eq!(speed(&mut rig, text), out, "{text}");
    }
    rig.say("motion.configure spindle=0 min-reverse-velocity=0 max-reverse-velocity=500");
    assert_eq!(speed(&mut rig, "speed=-5000"), -500.0);
    assert_eq!(speed(&mut rig, "speed=-5"), -5.0);
    assert_eq!(speed(&mut rig, "speed=5"), 100.0);
    for (text, why) in [
        ("spindle=1 max-forward-velocity=1", "there is no spindle 1, the machine has 1"),
        ("spindle=0 joint=0", "joint= and spindle= exclude each other"),
        ("spindle=0 axis=x", "axis= and spindle= exclude each other"),
        ("spindle=0 min-limit=1", "min-limit= does not belong to spindle="),
        ("joint=0 max-forward-velocity=1", "max-forward-velocity= does not belong to joint="),
        (
            "spindle=0 max-forward-velocity=50",
            "min-forward-velocity 100 is above max-forward-velocity 50",
        ),
        ("spindle=0 max-reverse-velocity=-5", "max-reverse-velocity is -5, must be 0 or more"),
    ] {
        assert_eq!(rig.try_say(&format!("motion.configure {text}")), Err(why.to_owned()));
    }
}
