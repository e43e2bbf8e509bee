//! External offsets.

use super::{DT, Rig, near};

/// Returns a homed machine with a tenth of a unit per count of z's offset, whose share of the axis is one half.
fn rig() -> Rig {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.configure axis=z offset-av-ratio=0.5 min-limit=-100 max-limit=100");
    rig.bench.set("axis.z.eoffset-scale", 0.1);
    rig.bench.set("axis.z.eoffset-enable", true);
    rig.done("motion.mode mode=teleop");
    rig
}

fn ask(rig: &mut Rig, counts: i32) {
    rig.bench.set("axis.z.eoffset-counts", counts);
}

const SHOWN: [&str; 2] = ["motion.eoffset-active", "motion.eoffset-limited"];

#[test]
fn it_shifts_the_joint_and_not_the_axis() {
    let mut rig = rig();
    ask(&mut rig, 30);
    let (mut fastest, mut last, mut steepest) = (0.0_f64, 0.0, 0.0_f64);
    for _ in 0..3000 {
        rig.cycle();
        let vel = rig.joint(2, "vel-cmd");
        fastest = fastest.max(vel.abs());
        steepest = steepest.max((vel - last).abs() / DT);
        last = vel;
    }
    near(rig.joint(2, "pos-cmd"), 3.0);
    near(rig.float("axis.z.eoffset"), 3.0);
    assert_eq!(rig.float("axis.z.eoffset-request"), 30.0 * 0.1);
    assert_eq!(rig.float("axis.z.pos-cmd"), 0.0);
    assert_eq!(rig.which(&SHOWN), ["motion.eoffset-active"]);
    // The offset's half of 10 units/s and 35 units/s².
    assert!(
        fastest <= 5.0 * (1.0 + 1e-9) && steepest <= 17.5 * (1.0 + 1e-9),
        "{fastest} {steepest}"
    );
    assert!(fastest > 4.9, "{fastest}");
    // A move continues from there, with the other half; x is not affected.
    rig.say("motion.move x=20 z=-4 velocity=1000");
    rig.cycles(50);
    ask(&mut rig, -10);
    assert_eq!(rig.end(), Ok(()));
    rig.cycles(3000);
    near(rig.joint(0, "pos-cmd"), 20.0);
    near(rig.float("axis.z.pos-cmd"), -4.0);
    near(rig.joint(2, "pos-cmd"), -5.0);
    rig.done("motion.move x=40 velocity=90");
    rig.bench.set("axis.z.eoffset-clear", true);
    rig.cycles(2000);
    near(rig.joint(2, "pos-cmd"), -4.0);
    assert_eq!(rig.float("axis.z.eoffset"), 0.0);
    assert_eq!(rig.which(&SHOWN), [""; 0]);
    // Cleared counts do not return.
    ask(&mut rig, 50);
    rig.cycles(10);
    rig.bench.set("axis.z.eoffset-clear", false);
    rig.cycles(1000);
    assert_eq!(rig.float("axis.z.eoffset"), 0.0);
}

/// A move without the axis has full speed; a move with it leaves the offset its share.
#[test]
fn moves_leave_it_its_share() {
    let mut rig = rig();
    for (text, joint, most) in [
        ("motion.move x=100 velocity=1000", 0, 90.0),
        ("motion.move z=30 velocity=1000", 2, 5.0),
        ("motion.jog axis=x velocity=1000 position=0", 0, 90.0),
        ("motion.jog axis=z velocity=1000 position=0", 2, 5.0),
    ] {
        rig.say(text);
        let mut fastest = 0.0_f64;
        rig.cycles(1);
        while !rig.is("motion.in-position") {
            fastest = fastest.max(rig.joint(joint, "vel-cmd").abs());
            rig.cycle();
        }
        assert!((fastest - most).abs() < 1e-6, "{text}: {fastest}");
    }
}

#[test]
fn limits_hold_with_it() {
    let mut rig = rig();
    rig.done("motion.move z=99 velocity=10");
    ask(&mut rig, 30);
    rig.cycles(2000);
    near(rig.joint(2, "pos-cmd"), 100.0);
    near(rig.float("axis.z.eoffset-request"), 3.0);
    assert_eq!(rig.which(&SHOWN), SHOWN);
    assert!(!rig.is("motion.on-soft-limit"));
    // There is travel left again.
    rig.done("motion.move z=90 velocity=10");
    rig.cycles(2000);
    near(rig.joint(2, "pos-cmd"), 93.0);
    assert_eq!(rig.which(&SHOWN), ["motion.eoffset-active"]);
    // A move towards the limit ends where the offset cannot retract fast enough.
    rig.say("motion.move z=100 velocity=10");
    let said = "an external offset takes a joint beyond its limit: the move ends";
    assert_eq!(rig.end(), Err(said));
    rig.cycles(3000);
    assert!(rig.joint(2, "pos-cmd") <= 100.0 + 2e-6, "{}", rig.joint(2, "pos-cmd"));
    assert_eq!(rig.bench.said(), [said]);
}

/// A jog toward the limit, with an offset that is there, moves toward the limit, or away from it, or is asked for meanwhile.
#[test]
fn a_jog_with_an_offset_ends_where_both_are_at_the_limit() {
    for (jerk, share) in [(f64::INFINITY, 0.3), (f64::INFINITY, 0.7), (200.0, 0.3), (200.0, 0.5)] {
        for (first, then, wait) in [
            (-300, -300, 3000),
            (-300, -900, 3000),
            (-900, -900, 900),
            (-300, 0, 3000),
            (0, -900, 1),
        ] {
            let mut rig = rig();
            rig.say(&format!("motion.configure axis=z offset-av-ratio={share}"));
            if jerk.is_finite() {
                rig.say(&format!("motion.configure joint=2 max-jerk={jerk}"));
            }
            ask(&mut rig, first);
            rig.cycles(wait);
            rig.say("motion.jog axis=z velocity=-1000");
            rig.cycles(300);
            ask(&mut rig, then);
            let mut lowest = 0.0_f64;
            for cycle in 0..60_000 {
                if cycle == 30_000 {
                    rig.say("motion.jog axis=z velocity=-1000");
                }
                rig.cycle();
                lowest = lowest.min(rig.joint(2, "pos-cmd"));
            }
            let case = format!("{first} {then} {wait} {jerk} {share}");
            assert!((-100.0 - 2e-6..-99.9).contains(&lowest), "{case}: {lowest}");
            assert!(rig.bench.said().is_empty(), "{case}: {:?}", rig.bench.said());
        }
    }
}

#[test]
fn when_it_does_not_count() {
    // Not homed, not enabled, no share of the axis, no finite scale.
    for (home, enable, ratio, scale) in [
        (false, true, 0.5, 0.1),
        (true, false, 0.5, 0.1),
        (true, true, 0.0, 0.1),
        (true, true, 0.5, f64::NAN),
        (true, true, 0.5, f64::INFINITY),
    ] {
        let mut rig = if home { Rig::homed(&[]) } else { Rig::on(&[]) };
        rig.say(&format!("motion.configure axis=z offset-av-ratio={ratio}"));
        rig.bench.set("axis.z.eoffset-scale", scale);
        rig.bench.set("axis.z.eoffset-enable", enable);
        rig.done("motion.mode mode=teleop");
        rig.cycles(1);
        ask(&mut rig, 30);
        rig.cycles(500);
        assert_eq!(rig.joint(2, "pos-cmd"), 0.0, "{home} {enable} {ratio} {scale}");
        assert_eq!(rig.float("axis.z.eoffset-request"), 0.0);
    }
    // In free mode, and counts in the meantime are not applied later.
    let mut rig = rig();
    rig.done("motion.mode mode=free");
    ask(&mut rig, 30);
    rig.cycles(100);
    rig.done("motion.mode mode=coord");
    rig.cycles(100);
    assert_eq!(rig.float("axis.z.eoffset-request"), 0.0);
    // An offset excludes moves of single joints, and a machine that goes off loses its offset.
    ask(&mut rig, 40);
    rig.cycles(2000);
    let why = "joints cannot be moved while an external offset is applied";
    for text in ["motion.mode mode=free", "motion.jog joint=0 velocity=1", "motion.home joint=0"] {
        assert_eq!(rig.failed(text), why);
    }
    rig.done("motion.disable");
    rig.cycles(1);
    assert_eq!(rig.float("axis.z.eoffset"), 0.0);
    near(rig.joint(2, "pos-cmd"), 1.0);
    near(rig.float("axis.z.pos-cmd"), 1.0);
    rig.done("motion.enable");
    rig.done("motion.jog joint=0 velocity=1 distance=1");
    // Without a share, the offset stays as it is while the machine is on.
    rig.done("motion.mode mode=coord");
    ask(&mut rig, 50);
    rig.cycles(2000);
    let applied = rig.float("axis.z.eoffset");
    near(applied, 1.0);
    rig.say("motion.configure axis=z offset-av-ratio=0");
    rig.bench.set("axis.z.eoffset-clear", true);
    rig.cycles(500);
    assert_eq!(rig.float("axis.z.eoffset"), applied);
    rig.done("motion.disable");
    rig.cycles(1);
    assert_eq!(rig.float("axis.z.eoffset"), 0.0);
    let most = "offset-av-ratio is 0.95, must be 0 to 0.9";
    assert_eq!(rig.try_say("motion.configure axis=z offset-av-ratio=0.95"), Err(most.into()));
}

/// With non-trivial kinematics, all joints leave their share, and unreachable offsets are not applied.
#[test]
fn with_kinematics_of_their_own() {
    let mut rig = Rig::homed(&["kinstype=b"]);
    rig.say("motion.configure axis=z offset-av-ratio=0.2");
    rig.bench.set("axis.z.eoffset-scale", -1.0);
    rig.bench.set("axis.z.eoffset-enable", true);
    rig.done("motion.mode mode=coord");
    ask(&mut rig, 2);
    rig.say("motion.move x=50 z=3 velocity=1000");
    let mut fastest = 0.0_f64;
    rig.cycles(1);
    while !rig.is("motion.in-position") {
        fastest = fastest.max(rig.joint(0, "vel-cmd"));
        rig.cycle();
    }
    assert_eq!(rig.end(), Ok(()));
    assert!(fastest <= 72.0 * (1.0 + 1e-9), "{fastest}");
    rig.cycles(3000);
    near(rig.joint(2, "pos-cmd"), 1.0);
    near(rig.float("axis.z.pos-cmd"), 3.0);
}
