//! Limits of jerk, in every kind of motion.

use super::{Rig, follow::Turner, near};

/// Jerk of x in the tests, in units/s³.
const JERK: f64 = 30_000.0;

impl Rig {
    /// Returns a machine that is homed, with limits of jerk.
    fn soft() -> Self {
        let mut rig = Self::on(&[]);
        rig.say(&format!("motion.configure joint=0 max-jerk={JERK}"));
        rig.say("motion.configure joint=1 max-jerk=10000");
        rig.say("motion.configure joint=2 max-jerk=500");
        rig.done("motion.home joint=all");
        rig
    }

    /// Asserts that the watchman has seen a jerk of x near its limit, and none above it.
    fn judge(&self, what: &str) {
        self.judge_above(0.95, what);
    }

    /// Asserts that the watchman has seen more than this part of the limit of jerk, and no jerk above it.
    fn judge_above(&self, part: f64, what: &str) {
        let jerk = self.float("joint.0.watch-jerk");
        assert!(part < jerk && jerk <= 1.0, "{what}: {jerk}");
        assert_eq!(self.bench.get::<u32>("motion.watch.violations"), 0, "{what}");
    }
}

#[test]
fn jogs_of_joints_and_axes_keep_their_jerk() {
    for target in ["joint=0", "axis=x"] {
        let mut rig = Rig::soft();
        rig.done(&format!("motion.jog {target} velocity=80 position=30"));
        near(rig.joint(0, "pos-cmd"), 30.0);
        rig.say(&format!("motion.jog {target} velocity=-60"));
        rig.cycles(137);
        rig.done(&format!("motion.jog-stop {target}"));
        rig.say(&format!("motion.jog {target} velocity=90"));
        rig.cycles(300);
        // It turns round in motion, and ends at the soft limit.
        rig.say(&format!("motion.jog {target} velocity=-90"));
        rig.cycles(3000);
        near(rig.joint(0, "pos-cmd"), -50.0);
        rig.judge(target);
        assert!(rig.float("joint.0.watch-acceleration") > 0.9);
    }
}

#[test]
fn wheels_and_external_offsets_keep_their_jerk() {
    let mut rig = Rig::soft();
    rig.bench.set("joint.0.jog-scale", 0.5);
    rig.bench.set("joint.0.jog-enable", true);
    rig.cycle();
    for counts in [20, 21, 60, 12] {
        rig.bench.set("joint.0.jog-counts", counts);
        rig.cycles(160);
    }
    rig.cycles(1000);
    near(rig.joint(0, "pos-cmd"), 6.0);
    rig.judge("wheel");
    let mut rig = Rig::soft();
    rig.say("motion.configure axis=x offset-av-ratio=0.9");
    rig.bench.set("axis.x.eoffset-scale", 0.1);
    rig.bench.set("axis.x.eoffset-enable", true);
    rig.done("motion.mode mode=coord");
    for counts in [100, 140, -30] {
        rig.bench.set("axis.x.eoffset-counts", counts);
        rig.cycles(250);
    }
    rig.cycles(1000);
    near(rig.joint(0, "pos-cmd"), -3.0);
    // The offset has nine tenths of the limit.
    rig.judge_above(0.85, "offset");
}

#[test]
fn homing_keeps_its_jerk() {
    let mut rig = Rig::soft();
    rig.say(
        "motion.configure joint=0 home-search-vel=40 home-latch-vel=-4 home=-20 home-offset=3 \
         home-final-vel=0",
    );
    rig.say("motion.home joint=0");
    for _ in 0..20_000 {
        let is_on = rig.joint(0, "motor-pos-cmd") > 30.0;
        rig.bench.set("joint.0.home-sw-in", is_on);
        rig.cycle();
        if rig.is("joint.0.homed") {
            break;
        }
    }
    near(rig.joint(0, "pos-cmd"), -20.0);
    rig.judge("homing");
}

#[test]
fn a_path_keeps_the_jerk_of_joints_axes_and_path() {
    for (config, text) in [("joint=0", "joint"), ("axis=x", "axis"), ("", "path")] {
        let mut rig = Rig::homed(&[]);
        rig.say(&format!("motion.configure {config} max-jerk={JERK}"));
        let (mut last, mut worst, mut top) = ([0.0; 3], 0.0_f64, 0.0_f64);
        for to in ["x=40 y=0", "x=40 y=30", "x=0 y=0"] {
            rig.say(&format!("motion.move {to} velocity=80 mode=blend tolerance=0.5"));
        }
        for n in 0..4000 {
            rig.cycle();
            let x = rig.joint(0, "pos-cmd");
            let v = (x - last[0]) / super::DT;
            let a = (v - last[1]) / super::DT;
            if n > 2 {
                worst = worst.max((a - last[2]).abs() / super::DT);
                top = top.max(a.abs());
            }
            last = [x, v, a];
        }
        assert!(rig.is("motion.in-position") && top > 700.0, "{text} {top}");
        assert!(0.6 * JERK < worst && worst <= 1.001 * JERK, "{text}: {worst}");
        // 0 takes the limit away again.
        rig.say(&format!("motion.configure {config} max-jerk=0"));
        rig.done("motion.move x=30 velocity=50");
    }
}

/// Jerk along the path: on a diagonal the axes have less each.
#[test]
fn a_diagonal_keeps_the_jerk_along_the_path() {
    let mut rig = Rig::homed(&[]);
    rig.say(&format!("motion.configure max-jerk={JERK}"));
    rig.say("motion.move x=60 y=60 velocity=90");
    let (mut last, mut worst) = ([0.0; 3], 0.0_f64);
    for n in 0..2000 {
        rig.cycle();
        let s = rig.joint(0, "pos-cmd").hypot(rig.joint(1, "pos-cmd"));
        let v = (s - last[0]) / super::DT;
        let a = (v - last[1]) / super::DT;
        if n > 2 {
            worst = worst.max((a - last[2]).abs() / super::DT);
        }
        last = [s, v, a];
    }
    assert!(rig.is("motion.in-position"));
    assert!(0.6 * JERK < worst && worst <= 1.001 * JERK, "{worst}");
}

/// A thread changes its acceleration at once, by so little that the jerk is kept.
#[test]
fn a_thread_keeps_the_jerk_and_its_spindle() {
    let mut rig = Rig::soft();
    rig.say("motion.configure joint=0 max-jerk=500000");
    rig.turner = Some(Turner::new(50.0));
    rig.say("motion.spindle speed=600");
    rig.say("motion.move x=60 pitch=1.5");
    rig.cycles(1000);
    rig.say("motion.spindle override=0.7");
    let mut worst = 0.0_f64;
    while rig.joint(0, "pos-cmd") < 59.0 {
        rig.cycle();
        worst = worst.max(rig.float("spindle.0.sync-error").abs());
    }
    rig.cycles(300);
    assert!(rig.is("motion.in-position"));
    assert!(worst <= 1.5 * 10.0 * super::DT, "{worst}");
    rig.judge_above(0.5, "thread");
}
