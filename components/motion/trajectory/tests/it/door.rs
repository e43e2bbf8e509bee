//! Unusable input is refused by name, and changes nothing.

use hal_trajectory::{
    AXES, Error, Follower, JOINTS, Jet, Joints, Kinematics, Limits, Machine, Mode, Move, Planner,
    Pose, Shape, Trivial,
};

const LIMITS: Limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 };

fn line(x: f64) -> Move {
    let shape = Shape::Line { end: Pose::from_xyz([x, 0.0, 0.0]) };
    Move { shape, feed: 60.0, rapid: false, mode: Mode::Blend(0.1), line: 7 }
}

fn arc(end: [f64; 3], center: [f64; 3], normal: [f64; 3]) -> Move {
    let shape = Shape::Arc { end: Pose::from_xyz(end), center, normal, turns: 0 };
    Move { shape, ..line(0.0) }
}

#[test]
fn moves_that_cannot_be_are_refused() {
    let mut planner = Planner::new(Machine::uniform(LIMITS), Trivial, Pose::ZERO).unwrap();
    planner.push(&line(10.0)).unwrap();
    let before = *planner.position();
    let z = [0.0, 0.0, 1.0];
    let cases: Vec<(Move, &str)> = vec![
        (line(f64::NAN), "line 7: a coordinate is not a number up to 1e9"),
        (line(f64::INFINITY), "line 7: a coordinate is not a number up to 1e9"),
        (line(2e9), "line 7: a coordinate is not a number up to 1e9"),
        (Move { feed: 0.0, ..line(1.0) }, "line 7: feed 0 is not a number from 1e-6 up"),
        (Move { feed: f64::NAN, ..line(1.0) }, "line 7: feed NaN is not a number from 1e-6 up"),
        (Move { feed: -5.0, ..line(1.0) }, "line 7: feed -5 is not a number from 1e-6 up"),
        (Move { mode: Mode::Blend(-1.0), ..line(1.0) }, "tolerance"),
        (Move { mode: Mode::Blend(f64::NAN), ..line(1.0) }, "tolerance"),
        (arc([12.0, 0.0, 0.0], [5.0, 0.0, 0.0], z), "radi"),
        (arc([10.0, 0.0, 0.0], [10.0, 0.0, 0.0], z), "radius"),
        (arc([0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0; 3]), "radius"),
        (arc([0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0], z), "not a number"),
    ];
    for (m, text) in cases {
        let error = planner.push(&m).unwrap_err();
        assert!(error.to_string().contains(text), "{error}, and not {text}");
        assert_eq!(*planner.position(), before);
    }
    // Lines too short to be a move are no error, and no motion.
    planner.push(&line(10.0)).unwrap();
    planner.push(&line(10.0 + 1e-10)).unwrap();
    assert_eq!(*planner.position(), before);
}

#[test]
fn machines_that_cannot_be_are_refused() {
    let new = |machine| Planner::new(machine, Trivial, Pose::ZERO).err();
    let good = Machine::uniform(LIMITS);
    assert_eq!(new(good), None);
    for bad in [0.0, -1.0, f64::NAN, 1e-9] {
        let mut axis = good;
        axis.axes[2].acceleration = bad;
        assert!(matches!(new(axis), Some(Error::Limit { index: 2, .. })));
        let mut joint = good;
        joint.joints[4].jerk = bad;
        assert!(matches!(new(joint), Some(Error::Limit { index: 104, .. })));
        for set in [
            Machine { period: bad, ..good },
            Machine { exact_tolerance: bad, ..good },
            Machine { angular_tolerance: bad, ..good },
            Machine { max_override: bad, ..good },
        ] {
            assert!(matches!(new(set), Some(Error::Setting { .. })));
        }
    }
    let nowhere = Planner::new(good, Trivial, Pose([f64::NAN; 9])).err();
    assert_eq!(nowhere, Some(Error::NotFinite { line: 0 }));
}

/// Kinematics with one joint per axis, whose answers are wrong in a part of the space.
#[derive(Clone, Copy)]
struct Faulty {
    /// True where the answer is wrong.
    wrong: fn(&Pose) -> bool,
    /// Wrong value of joint 1; none means that the kinematics refuses the pose.
    value: Option<f64>,
    /// True if derivatives are offered, and the first one of them is wrong instead of the position.
    jets: bool,
}

impl Kinematics for Faulty {
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize> {
        let mut joints = Trivial.inverse(pose)?;
        if (self.wrong)(pose) {
            joints[1] = self.value.ok_or(1_usize)?;
        }
        Ok(joints)
    }

    fn derivatives(&self, pose: &[Jet; AXES]) -> Option<Result<[Jet; JOINTS], usize>> {
        if !self.jets {
            return None;
        }
        let mut jets = [Jet::default(); JOINTS];
        jets[..AXES].copy_from_slice(pose);
        if (self.wrong)(&Pose(pose.map(|jet| jet.0[0]))) {
            jets[1].0[1] = self.value.unwrap_or(f64::NAN);
        }
        Some(Ok(jets))
    }
}

/// Answers of a kinematics that are no numbers never pass the door, wherever on the move they are.
#[test]
fn moves_without_joint_positions_are_refused_with_joint_and_place() {
    let wrong: fn(&Pose) -> bool = |p| p.0[0] > 6.0;
    let refused = "line 7: joint 1 has no position for a pose on the path, at X";
    for value in [None, Some(f64::NAN), Some(f64::INFINITY), Some(f64::NEG_INFINITY)] {
        for jets in [false, true] {
            let kinematics = Faulty { wrong, value, jets };
            let mut planner =
                Planner::new(Machine::uniform(LIMITS), kinematics, Pose::ZERO).unwrap();
            planner.push(&line(5.0)).unwrap();
            let before = *planner.position();
            let text = planner.push(&line(10.0)).unwrap_err().to_string();
            let place: f64 = text
                .strip_prefix(refused)
                .and_then(|rest| rest.strip_suffix(" Y0.0000 Z0.0000"))
                .unwrap_or_else(|| panic!("{text}"))
                .parse()
                .unwrap();
            assert!((5.9..=6.6).contains(&place), "{text}");
            assert_eq!(*planner.position(), before);
            // The path that was there goes on.
            planner.push(&line(3.0)).unwrap();
        }
    }
}

/// A corner whose blend would lead through poses without joints is passed as an exact stop.
#[test]
fn a_blend_without_joint_positions_is_a_stop() {
    let inside: fn(&Pose) -> bool = |p| p.0[0] < 9.99 && p.0[1] > 0.01;
    let corner = |wrong| {
        let kinematics = Faulty { wrong, value: None, jets: false };
        let machine = Machine::uniform(LIMITS);
        let mut planner = Planner::new(machine, kinematics, Pose::ZERO).unwrap();
        for end in [[10.0, 0.0, 0.0], [10.0, 10.0, 0.0], [10.0, 20.0, 0.0]] {
            let shape = Shape::Line { end: Pose::from_xyz(end) };
            planner.push(&Move { shape, mode: Mode::Blend(0.5), ..line(0.0) }).unwrap();
        }
        planner.finish();
        let mut follower = Follower::new(1e-3, Pose::ZERO);
        let (mut cut, mut near, mut last) = (0, f64::INFINITY, Pose::ZERO);
        for _ in 0..5000 {
            last = follower.step(planner.track(), 1.0, false).pose;
            cut += usize::from(inside(&last));
            near = near.min((last.0[0] - 10.0).hypot(last.0[1]));
        }
        assert!((last.0[1] - 20.0).abs() < 1e-9, "{last:?}");
        (cut, near)
    };
    let (cut, near) = corner(|_| false);
    assert!(cut > 5 && near > 0.05, "the blend cuts the corner: {cut} {near}");
    let (cut, near) = corner(inside);
    assert!(cut == 0 && near < 1e-6, "it stops at the corner: {cut} {near}");
}
