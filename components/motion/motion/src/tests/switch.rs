//! Kinematics that can be switched while the machine runs.

use super::*;
use hal_component::{
    Builder, Component, Error, Kinematics, KinematicsKind, Pose, Solution, Solved, Touch, Unsolved,
    abi::component_flags,
};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Straight kinematics, or with x and z swapped and y reversed; the third type has no pose.
struct Lathe;

#[derive(Touch)]
struct Types {
    #[state]
    is: AtomicU32,
}

impl Types {
    fn turned(&self, from: &[f64]) -> [f64; 3] {
        let [x, y, z] = [from[0], from[1], from[2]];
        if self.is.load(Relaxed) == 1 { [z, -y, x] } else { [x, y, z] }
    }
}

impl Kinematics for Types {
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
        if self.is.load(Relaxed) == 2 {
            return Err(Unsolved::NotFound);
        }
        pose[..3].copy_from_slice(&self.turned(joints));
        Ok(Solved::Regular)
    }
    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        joints[..3].copy_from_slice(&self.turned(pose));
        Ok(Solved::Regular)
    }
    fn types(&self) -> u32 {
        3
    }
    fn switch(&self, to: u32) -> bool {
        self.is.store(to, Relaxed);
        to < 3
    }
}

impl Component for Lathe {
    const NAME: &'static str = "lathe";
    const DOC: &'static str = "A lathe.";
    const FLAGS: u32 = component_flags::ONCE;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        b.offer_kinematics(Types { is: AtomicU32::new(0) })
    }
}

fn lathe() -> Rig {
    let mut bench = Bench::new();
    bench.load::<Lathe>(&[]).unwrap();
    let mut rig = Rig::with(bench);
    rig.done("motion.enable");
    rig.done("motion.home joint=all");
    rig.say("motion.mode mode=coord");
    rig.cycle();
    rig
}

fn switch(rig: &mut Rig, to: f64) {
    rig.bench.set("motion.switchkins-type", to);
    rig.cycle();
}

#[test]
fn a_switch_changes_the_pose_and_no_joint() {
    let mut rig = lathe();
    rig.done("motion.move x=10 y=20 z=5 velocity=1000");
    switch(&mut rig, 1.9);
    assert_eq!(rig.places(), [10.0, 20.0, 5.0]);
    assert_eq!(
        ["x", "y", "z"].map(|l| rig.float(&format!("axis.{l}.pos-cmd"))),
        [5.0, -20.0, 10.0]
    );
    rig.done("motion.move x=-7 velocity=1000");
    let [x, y, z] = rig.places();
    near(x, 10.0);
    near(y, 20.0);
    near(z, -7.0);
}

#[test]
fn a_switch_waits_until_nothing_moves() {
    let mut rig = lathe();
    rig.say("motion.move x=10 velocity=1000");
    rig.cycles(10);
    switch(&mut rig, 1.0);
    assert_eq!(rig.end(), Ok(()));
    assert_eq!(rig.places(), [10.0, 0.0, 0.0]);
    rig.cycle();
    assert_eq!(rig.float("axis.z.pos-cmd"), 10.0);
}

#[test]
fn a_type_that_there_is_not_changes_nothing() {
    let mut rig = lathe();
    rig.done("motion.move x=10 velocity=1000");
    for (to, why) in [
        (3.0, "there are no kinematics of type 3"),
        (-1.0, "there are no kinematics of type -1"),
        (f64::NAN, "there are no kinematics of type NaN"),
        (2.0, "the kinematics of type 2 have no pose for these joints"),
    ] {
        switch(&mut rig, to);
        rig.cycle();
        let said = rig.bench.said();
        assert!(said.iter().any(|s| s.contains(why)), "{to}: {said:?}");
        assert_eq!(said.len(), 1, "{to}: {said:?}");
        assert_eq!(rig.float("axis.x.pos-cmd"), 10.0, "{to}");
    }
    switch(&mut rig, 0.0);
    rig.done("motion.move x=12 velocity=1000");
    near(rig.places()[0], 12.0);
}
