//! Axes whose kinematics do not lead back to the joints: no mode that moves axes, no jump.

use super::*;
use hal_component::{
    Builder, Component, Error, In, Kinematics, KinematicsKind, Pose, Solution, Solved, Touch,
    Unsolved, abi::component_flags,
};

/// Trivial kinematics with pins that introduce errors.
struct Leaps;

#[derive(Touch)]
struct Leap {
    /// TRUE if the forward kinematics have no solution.
    lost: In<bool>,
    /// TRUE if the inverse kinematics have no solution.
    shut: In<bool>,
    /// Error of joint 1 in the inverse kinematics.
    beside: In<f64>,
    /// Number of the joint whose place is NaN; -1 for none.
    nowhere: In<i32>,
    /// TRUE if joints 0 and 1 are the sum and the difference of X and Y.
    is_crossed: In<bool>,
}

impl Kinematics for Leap {
    fn joints(&self) -> usize {
        3
    }
    fn kind(&self) -> KinematicsKind {
        KinematicsKind::Both
    }
    fn joint_of(&self, _: usize) -> Option<usize> {
        None
    }
    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        if self.lost.get() {
            return Err(Unsolved::Unreachable);
        }
        pose[..3].copy_from_slice(&joints[..3]);
        if self.is_crossed.get() {
            pose[0] = 0.5 * (joints[0] + joints[1]);
            pose[1] = 0.5 * (joints[0] - joints[1]);
        }
        Ok(Solved::Regular)
    }
    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        if self.shut.get() {
            return Err(Unsolved::Unreachable);
        }
        joints[..3].copy_from_slice(&pose[..3]);
        if self.is_crossed.get() {
            joints[0] = pose[0] + pose[1];
            joints[1] = pose[0] - pose[1];
        }
        joints[1] += self.beside.get();
        if let Some(joint) =
            usize::try_from(self.nowhere.get()).ok().and_then(|n| joints.get_mut(n))
        {
            *joint = f64::NAN;
        }
        Ok(Solved::Regular)
    }
}

impl Component for Leaps {
    const NAME: &'static str = "leaps";
    const DOC: &'static str = "Kinematics that can be wrong.";
    const FLAGS: u32 = component_flags::ONCE;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let leap = Leap {
            lost: b.item("leaps.lost", "No pose.", false)?,
            shut: b.item("leaps.shut", "No joints.", false)?,
            beside: b.item("leaps.beside", "Other joints.", 0.0)?,
            nowhere: b.item("leaps.nowhere", "No number.", -1)?,
            is_crossed: b.item("leaps.is-crossed", "Sum and difference.", false)?,
        };
        b.offer_kinematics(leap)
    }
}

/// Returns a homed machine with joint 1 at 7.5.
fn rig() -> Rig {
    let mut bench = Bench::new();
    bench.load::<Leaps>(&[]).unwrap();
    let mut rig = Rig::with(bench);
    rig.done("motion.enable");
    rig.say("motion.configure joint=1 home=7.5 home-offset=7.5");
    rig.done("motion.home joint=all");
    rig
}

type Break = fn(&Rig);
const LOST: Break = |rig| rig.bench.set("leaps.lost", true);
const SHUT: Break = |rig| rig.bench.set("leaps.shut", true);
const BESIDE: Break = |rig| rig.bench.set("leaps.beside", 5.0);

const NO_POSE: &str = "the axes cannot move: the kinematics have no pose for joint 1 at 7.5";
const NO_POSE_0: &str = "the axes cannot move: the kinematics have no pose for joint 0 at 0";
const ELSEWHERE: &str =
    "the axes cannot move: joint 1 is at 7.5, but the kinematics put it at 12.5";

const BITS: [&str; 3] = ["motion.motion-enabled", "motion.teleop-mode", "motion.coord-mode"];

#[test]
fn no_mode_in_which_axes_move() {
    for (spoil, why) in [(LOST, NO_POSE), (SHUT, NO_POSE_0), (BESIDE, ELSEWHERE)] {
        for text in [
            "motion.mode mode=teleop",
            "motion.mode mode=coord",
            "motion.jog axis=y velocity=10",
            "motion.jog axis=x velocity=10 position=4",
            "motion.move x=0 y=0",
        ] {
            let mut rig = rig();
            spoil(&rig);
            // The last known pose is no longer that of the joints.
            if why == NO_POSE {
                rig.bench.set("leaps.lost", false);
                rig.done("motion.jog joint=1 velocity=50 position=0");
                rig.bench.set("leaps.lost", true);
                rig.done("motion.jog joint=1 velocity=50 position=7.5");
            }
            rig.failed(text);
            assert_eq!(rig.bench.failure().as_deref(), Some(why), "{text}");
            assert_eq!(rig.bench.said(), [why], "{text}");
            for n in 0..50 {
                rig.bench.set("axis.y.jog-enable", true);
                rig.bench.set("axis.y.jog-scale", 1.0);
                rig.bench.set("axis.y.jog-counts", n);
                rig.cycle();
                near(rig.joint(1, "pos-cmd"), 7.5);
            }
            assert_eq!(rig.which(&BITS), ["motion.motion-enabled"]);
            assert!(rig.bench.said().is_empty());
        }
    }
}

/// A step that a joint can make from rest in one cycle does not count as a jump.
#[test]
fn what_rounding_makes_is_the_same_place() {
    let (acc, v) = (LIMITS[1].1, LIMITS[1].0);
    assert!(acc * DT * DT < v * DT);
    for (beside, is_there) in [(acc * DT * DT * 0.99, true), (acc * DT * DT * 1.01, false)] {
        let mut rig = rig();
        rig.bench.set("leaps.beside", beside);
        assert_eq!(rig.wait("motion.mode mode=teleop").is_ok(), is_there, "{beside}");
        rig.cycles(5);
        assert!(rig.is("motion.motion-enabled"));
    }
}

#[test]
fn a_machine_that_is_switched_on_leaves_such_a_mode() {
    for (spoil, why) in [(LOST, NO_POSE_0), (SHUT, NO_POSE_0), (BESIDE, ELSEWHERE)] {
        for mode in ["teleop", "coord"] {
            let mut rig = rig();
            rig.done(&format!("motion.mode mode={mode}"));
            rig.done("motion.disable");
            spoil(&rig);
            rig.cycles(3);
            rig.done("motion.enable");
            rig.cycles(20);
            near(rig.joint(1, "pos-cmd"), 7.5);
            assert_eq!(rig.which(&BITS), ["motion.motion-enabled"], "{mode}");
            assert_eq!(rig.bench.said(), [why, "the machine is in free mode now"]);
            rig.done("motion.jog joint=1 velocity=10 distance=-1");
        }
    }
    // Moved by hand while off: the mode stays, and continues from the joint's position.
    let mut rig = rig();
    rig.done("motion.mode mode=coord");
    rig.done("motion.disable");
    rig.stuck[1] = true;
    rig.bench.set("joint.1.motor-pos-fb", -27.5);
    rig.cycles(2);
    rig.stuck[1] = false;
    rig.done("motion.enable");
    rig.cycles(5);
    near(rig.joint(1, "pos-cmd"), -20.0);
    assert_eq!(rig.which(&BITS), ["motion.motion-enabled", "motion.coord-mode"]);
    rig.done("motion.move y=-19 velocity=10");
}

/// Kinematics that change, whether axes move or not, are stopped by the guard, not by a mode.
#[test]
fn kinematics_that_change_do_not_move_a_joint_at_once() {
    for (begin, by) in [
        ("motion.jog axis=x velocity=20", "a jog of an axis"),
        ("motion.move x=40 velocity=20", "a coordinated move"),
        ("motion.mode mode=teleop", "the kinematics, while no axis moves"),
        ("motion.mode mode=coord", "the kinematics, while no axis moves"),
    ] {
        let mut rig = rig();
        rig.say(begin);
        rig.cycles(50);
        let before = rig.joint(0, "motor-pos-cmd");
        rig.strict = false;
        rig.bench.set("leaps.beside", 450.0);
        rig.cycle();
        assert!(!rig.is("motion.motion-enabled"));
        near(rig.joint(1, "pos-cmd"), 7.5);
        assert_eq!(rig.joint(0, "motor-pos-cmd"), before);
        assert_eq!(
            rig.bench.said(),
            [format!(
                "joint 1 would jump from 7.5 to 457.5 in one cycle, where at most 0.09 is \
                 allowed: {by}; the machine is switched off"
            )]
        );
        // When it is switched on again, the mode is refused.
        rig.cycles(3);
        rig.done("motion.enable");
        assert_eq!(rig.which(&BITS), ["motion.motion-enabled"]);
    }
}

/// A lasting condition is reported once.
#[test]
fn a_pose_that_cannot_be_reached_any_more_is_told_once() {
    for mode in ["teleop", "coord"] {
        let mut rig = rig();
        rig.done(&format!("motion.mode mode={mode}"));
        for _ in 0..3 {
            rig.bench.set("leaps.shut", true);
            rig.cycles(200);
            assert_eq!(rig.bench.said(), ["the kinematics cannot go there"], "{mode}");
            assert!(rig.is("motion.motion-enabled"));
            near(rig.joint(1, "pos-cmd"), 7.5);
            rig.bench.set("leaps.shut", false);
            rig.cycles(5);
        }
        assert!(rig.bench.said().is_empty());
    }
}

/// Places of joints that the kinematics do not move count as nothing.
#[test]
fn a_joint_without_a_number_counts_only_if_the_kinematics_move_it() {
    for (nowhere, counts) in [(0, true), (1, true), (2, true), (3, false), (4, false)] {
        for mode in ["teleop", "coord"] {
            let mut bench = Bench::new();
            bench.load::<Leaps>(&[]).unwrap();
            let mut rig = Rig::load::<Motmod>(bench, &["num_joints=5", "num_extrajoints=1"]);
            rig.say("motion.configure joint=4 max-velocity=50 max-acceleration=500");
            rig.done("motion.enable");
            rig.done("motion.home joint=all");
            rig.done(&format!("motion.mode mode={mode}"));
            rig.bench.set("leaps.nowhere", nowhere);
            rig.cycles(5);
            let said = rig.bench.said();
            let expected: &[&str] = if counts { &["the kinematics cannot go there"] } else { &[] };
            assert_eq!(said, expected, "{nowhere} {mode}");
            assert!(rig.is("motion.motion-enabled"));
            (0..3).for_each(|n| assert!(rig.joint(n, "motor-pos-cmd").is_finite()));
        }
    }
}

/// A gantry with one joint out of line.
#[test]
fn a_gantry_that_stands_askew_does_not_jump_straight() {
    for kind in ["kinstype=b", "kinstype=1"] {
        let mut rig = Rig::homed(&["coordinates=xyy", kind]);
        rig.done("motion.jog joint=2 velocity=5 position=0.5");
        let why = "the axes cannot move: joint 2 is at 0.5";
        rig.failed("motion.jog axis=y velocity=5");
        let told = rig.bench.failure().unwrap();
        let other = told.replace("joint 2 is at 0.5", "joint 1 is at 0");
        assert!(told.starts_with(why) || other.starts_with(why), "{told}");
        rig.done("motion.jog joint=2 velocity=5 position=0");
        rig.done("motion.move y=3 velocity=5");
    }
}

#[test]
fn a_joint_that_joins_does_not_jump() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&["coordinates=xyy"]).unwrap();
    bench.load::<Motmod>(&["num_joints=3"]).unwrap();
    let run = |n: usize| {
        for _ in 0..n {
            bench.run("motion-command-handler", PERIOD);
            bench.run("motion-controller", PERIOD);
        }
    };
    for n in ["joint=0", "joint=1"] {
        bench.command("motion.configure", &[n, "max-velocity=50"]).unwrap();
    }
    bench.set("joint.2.motor-pos-fb", 4.0);
    bench.command("motion.enable", &[]).unwrap();
    bench.command("motion.mode", &["mode=teleop"]).unwrap();
    run(5);
    assert!(bench.get::<bool>("motion.teleop-mode"));
    bench.command("motion.configure", &["joint=2", "max-velocity=50"]).unwrap();
    run(5);
    assert_eq!(bench.get::<f64>("joint.2.motor-pos-cmd"), 4.0);
    assert!(bench.get::<bool>("motion.motion-enabled"));
    assert!(!bench.get::<bool>("motion.teleop-mode"));
    assert_eq!(bench.said().len(), 2);
}

/// Two axes that share a joint: the joint keeps its velocity limit, and nothing is stopped.
#[test]
fn several_axes_at_once_keep_to_the_velocity_of_each_joint() {
    let mut rig = rig();
    rig.bench.set("leaps.is-crossed", true);
    rig.strict = false;
    for letter in ["x", "y", "z"] {
        rig.say(&format!("motion.configure axis={letter} offset-av-ratio=0.5"));
        rig.bench.set(&format!("axis.{letter}.eoffset-scale"), 1.0);
        rig.bench.set(&format!("axis.{letter}.eoffset-enable"), true);
    }
    for mode in ["teleop", "coord"] {
        rig.done(&format!("motion.mode mode={mode}"));
        rig.cycle();
        if mode == "teleop" {
            rig.say("motion.jog axis=x velocity=90");
            rig.say("motion.jog axis=y velocity=90");
        } else {
            rig.say("motion.move x=0 y=0 velocity=90");
        }
        let counts = if mode == "teleop" { 30 } else { 0 };
        rig.bench.set("axis.x.eoffset-counts", counts);
        rig.bench.set("axis.y.eoffset-counts", counts);
        let mut fastest = 0.0_f64;
        for _ in 0..700 {
            let before = rig.joint(0, "motor-pos-cmd");
            rig.cycle();
            let speed = (rig.joint(0, "motor-pos-cmd") - before).abs() / DT;
            assert!(speed <= 90.0 * (1.0 + 1e-6), "{speed}");
            fastest = fastest.max(speed);
            assert!(rig.is("motion.motion-enabled"), "{:?}", rig.bench.said());
        }
        assert!(fastest > 40.0, "{mode}: {fastest}");
        rig.done("motion.jog-stop");
        rig.cycles(500);
    }
}
