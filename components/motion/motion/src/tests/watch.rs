//! The watchman: violations are counted and reported, and stop the machine if they may.

use super::{jump::rig, *};

fn counts(rig: &Rig) -> (u32, u32) {
    (rig.bench.get("motion.watch.violations"), rig.bench.get("motion.watch.hard-stops"))
}

/// Lets joint 0 jog, and moves it by a distance more in one cycle.
fn spoilt(by: f64) -> Rig {
    let mut rig = rig();
    rig.strict = false;
    rig.say("motion.jog joint=0 velocity=45 position=150");
    rig.cycles(200);
    assert_eq!(counts(&rig), (0, 0));
    assert!((rig.float("joint.0.watch-velocity") - 0.5).abs() < 1e-6);
    assert!((rig.float("joint.0.watch-acceleration") - 0.999).abs() < 1e-4);
    assert_eq!(rig.float("joint.1.watch-velocity"), 0.0);
    rig.bench.set("wrong.how", 2);
    rig.bench.set("wrong.by", by);
    rig.cycle();
    rig.bench.set("wrong.how", 0);
    rig
}

#[test]
fn a_violation_is_counted_and_reported_once() {
    // 0.99 and 1.02 of the acceleration, in one cycle of 1 ms.
    let step = LIMITS[0].1 * DT * DT;
    assert_eq!(counts(&spoilt(0.99 * step)), (0, 0));
    let mut rig = spoilt(1.02 * step);
    // The step, and the return to the velocity before.
    rig.cycle();
    assert_eq!(counts(&rig), (2, 0));
    assert!((rig.float("motion.watch.worst") - 1.02 / 1.001).abs() < 1e-6);
    let said = rig.bench.said();
    let [text] = &said[..] else { panic!("{said:?}") };
    assert!(text.starts_with("joint 0: 0.515"), "{text}");
    assert!(text.contains(" times its velocity and 1.018"), "{text}");
    assert!(text.ends_with(" times its acceleration, line 0"), "{text}");
    assert!(rig.is("motion.motion-enabled"));
    rig.end().unwrap();
    rig.bench.set("wrong.how", 2);
    rig.bench.set("wrong.joint", 1);
    rig.bench.set("wrong.by", 1.5 * step);
    rig.cycle();
    rig.bench.set("wrong.how", 0);
    assert_eq!(rig.bench.get::<i32>("motion.watch.joint"), 1);
    assert!(rig.bench.said().is_empty());
    rig.cycles(5);
    rig.bench.set("motion.watch.reset", true);
    rig.cycle();
    rig.bench.set("motion.watch.reset", false);
    rig.cycles(5);
    assert_eq!(counts(&rig), (0, 0));
    assert_eq!(rig.float("motion.watch.worst"), 0.0);
    for pin in ["watch-velocity", "watch-acceleration", "watch-jerk"] {
        assert_eq!(rig.joint(1, pin), 0.0, "{pin}");
    }
}

#[test]
fn it_stops_the_machine_if_it_may() {
    let mut rig = rig();
    rig.strict = false;
    rig.bench.set("motion.watch.stop", true);
    rig.say("motion.move x=150 velocity=45 line=77");
    rig.cycles(200);
    rig.bench.set("wrong.how", 1);
    rig.bench.set("wrong.by", 0.01);
    rig.cycle();
    rig.bench.set("wrong.how", 0);
    assert_eq!(rig.end(), Err("a joint broke its limits, and motion.watch.stop is TRUE"));
    assert!(!rig.is("motion.motion-enabled") && rig.is("joint.0.error"));
    assert_eq!(counts(&rig).0, 1);
    assert_eq!(rig.bench.get::<i32>("motion.watch.line"), 77);
    rig.cycles(50);
    rig.done("motion.enable");
    rig.done("motion.move x=0 velocity=45");
    assert_eq!(counts(&rig).0, 1, "the next start is judged from rest");
}

#[test]
fn stops_at_once_are_counted_by_themselves() {
    let mut rig = rig();
    rig.strict = false;
    for (n, stop) in (1..).zip(["motion.jog-stop-immediate", "motion.enable", "motion.disable"]) {
        assert_eq!(rig.wait("motion.enable"), Ok(()));
        rig.say("motion.jog joint=0 velocity=45");
        rig.cycles(200);
        match stop {
            "motion.disable" => rig.done(stop),
            pin => {
                let before: bool = rig.bench.get(pin);
                rig.bench.set(pin, !before);
                rig.cycles(3);
                rig.bench.set(pin, before);
            }
        }
        rig.cycles(20);
        assert_eq!(counts(&rig), (0, n), "{stop}");
        rig.say("motion.jog-stop");
        rig.cycles(100);
    }
    // At rest, switching off is no stop.
    rig.done("motion.enable");
    rig.done("motion.disable");
    rig.cycles(5);
    assert_eq!(counts(&rig), (0, 3));
}

/// A limit that is lowered in motion counts once the joint has had time to brake.
#[test]
fn limits_that_are_lowered_in_motion() {
    let mut rig = rig();
    rig.strict = false;
    rig.say("motion.jog joint=0 velocity=80");
    rig.cycles(200);
    rig.say("motion.configure joint=0 max-velocity=20 max-acceleration=400");
    rig.cycles(500);
    assert_eq!(rig.joint(0, "vel-cmd"), 20.0);
    assert_eq!(counts(&rig), (0, 0));
    rig.done("motion.jog-stop joint=0");
    rig.bench.set("motion.watch.reset", true);
    rig.cycles(2);
    rig.bench.set("motion.watch.reset", false);
    rig.done("motion.jog joint=0 velocity=80 position=-40");
    assert!((rig.float("joint.0.watch-acceleration") - 0.999).abs() < 1e-4);
    assert_eq!(counts(&rig), (0, 0));
}

#[test]
fn an_immediate_stop_of_jogs_is_no_stop_of_a_path() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=100 velocity=45");
    rig.cycles(300);
    rig.bench.set("motion.jog-stop-immediate", true);
    rig.cycles(10);
    assert_eq!(counts(&rig), (0, 0));
    assert!((rig.joint(0, "vel-cmd") - 45.0).abs() < 1e-6);
}
