//! A path without a task on a spindle that is stopped, and what motion waits for.

use super::Rig;
use hal_component::{MotionStatus, Wait};

fn status(rig: &Rig) -> MotionStatus {
    rig.bench.snapshot("motion.status")
}

fn x(rig: &Rig) -> f64 {
    rig.bench.get("joint.0.motor-pos-cmd")
}

/// A machine whose spindle turns, and whose X is in a feed of 50 units.
fn feeding() -> Rig {
    let mut rig = Rig::homed(&[]);
    rig.bench.command("motion.spindle", &["speed=500"]).unwrap();
    rig.bench.command("motion.move", &["x=50", "velocity=20"]).unwrap();
    rig.cycles(500);
    assert!(5.0 < x(&rig) && x(&rig) < 15.0, "{}", x(&rig));
    rig
}

#[test]
fn a_stop_in_the_middle_of_a_path_pauses_it() {
    for inhibits in [false, true] {
        let mut rig = feeding();
        match inhibits {
            true => rig.bench.set("spindle.0.inhibit", true),
            false => drop(rig.bench.command("motion.spindle", &["speed=0"]).unwrap()),
        }
        rig.cycles(300);
        let rests = x(&rig);
        rig.cycles(300);
        assert_eq!(x(&rig), rests, "{inhibits}");
        let seen = status(&rig);
        assert_eq!(
            (Wait::of(seen.wait), seen.spindles_stopped, seen.paused),
            (Wait::SpindleStopped, 1, true)
        );
        let lines = rig.bench.command("motion.status", &["stops=FALSE"]).unwrap();
        assert!(
            lines.iter().any(|line| line.starts_with("wait for=spindle-stopped number=0 since=")),
            "{lines:?}"
        );
        if inhibits {
            rig.bench.command("motion.resume", &[]).unwrap();
            rig.cycles(10);
            let why = rig.bench.failure().unwrap();
            assert_eq!(
                why,
                "spindle 0 was stopped, and cannot turn again: spindle.0.inhibit is TRUE"
            );
            rig.bench.set("spindle.0.inhibit", false);
            rig.cycles(300);
            assert_eq!(x(&rig), rests, "its end resumes nothing");
        }
        rig.bench.command("motion.resume", &[]).unwrap();
        rig.cycles(4000);
        assert!(rig.bench.get::<bool>("spindle.0.on"), "{inhibits}");
        assert_eq!((x(&rig), status(&rig).wait), (50.0, 0), "{inhibits}");
    }
}

#[test]
fn a_spindle_that_is_stopped_between_moves_is_no_wait() {
    let mut rig = feeding();
    rig.cycles(3000);
    rig.bench.command("motion.spindle", &["speed=0"]).unwrap();
    rig.cycles(10);
    rig.bench.command("motion.move", &["x=0", "velocity=20"]).unwrap();
    rig.cycles(4000);
    assert_eq!((x(&rig), status(&rig).spindles_stopped), (0.0, 0));
}

#[test]
fn each_wait_of_motion_is_in_its_status() {
    let mut rig = Rig::homed(&[]);
    rig.bench.command("motion.spindle", &["speed=600"]).unwrap();
    rig.cycles(5);
    rig.bench.set("spindle.0.at-speed", false);
    rig.bench.command("motion.move", &["x=1", "velocity=20"]).unwrap();
    rig.cycles(100);
    let wait =
        |rig: &Rig| (Wait::of(status(rig).wait), status(rig).wait_number, status(rig).wait_ends);
    assert_eq!(wait(&rig), (Wait::AtSpeed, 0, false));
    let since = status(&rig).wait_since_ns;
    // A ramp ends by itself.
    for n in 0..100 {
        rig.bench.set("spindle.0.speed-in", f64::from(n) * 0.05);
        rig.cycle();
    }
    assert_eq!((wait(&rig), status(&rig).wait_since_ns), ((Wait::AtSpeed, 0, true), since));
    rig.cycles(1500);
    assert_eq!(wait(&rig), (Wait::AtSpeed, 0, false), "the ramp has stopped");
    rig.bench.set("spindle.0.at-speed", true);
    rig.cycles(1000);
    assert_eq!((x(&rig), wait(&rig).0), (1.0, Wait::Nothing));
    for (pin, kind) in
        [("motion.feed-inhibit", Wait::FeedInhibit), ("motion.feed-hold", Wait::FeedHold)]
    {
        rig.bench.set(pin, true);
        rig.bench.command("motion.move", &["x=2", "velocity=20"]).unwrap();
        rig.cycles(100);
        assert_eq!(wait(&rig).0, kind);
        rig.bench.set(pin, false);
        rig.cycles(1000);
        rig.bench.command("motion.move", &["x=1", "velocity=20"]).unwrap();
        rig.cycles(1000);
    }
    rig.bench.command("motion.feed", &["override=0"]).unwrap();
    rig.bench.command("motion.move", &["x=2", "velocity=20"]).unwrap();
    rig.cycles(100);
    assert_eq!(wait(&rig).0, Wait::Override);
    rig.bench.command("motion.feed", &["override=1"]).unwrap();
    rig.cycles(1000);
    rig.bench.set("spindle.0.speed-in", 0.0);
    rig.bench.command("motion.move", &["x=3", "per-turn=1"]).unwrap();
    rig.cycles(100);
    assert_eq!(wait(&rig).0, Wait::SpindleSpeed);
    rig.bench.set("spindle.0.speed-in", 10.0);
    rig.cycles(1000);
    rig.bench.command("motion.move", &["x=8", "pitch=1"]).unwrap();
    rig.cycles(100);
    assert_eq!(wait(&rig).0, Wait::Index);
    rig.bench.command("motion.pause", &[]).unwrap();
    rig.cycles(100);
    assert_eq!(wait(&rig).0, Wait::Pause);
    rig.bench.command("motion.abort", &[]).unwrap();
    rig.cycles(100);
    assert_eq!(wait(&rig).0, Wait::Nothing);
    rig.bench.command("motion.spindle-orient", &["angle=90"]).unwrap();
    rig.cycles(100);
    assert_eq!(wait(&rig).0, Wait::Orient);
}
