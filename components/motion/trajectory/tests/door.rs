//! Unusable input is refused by name, and changes nothing.

use hal_trajectory::{Error, Limits, Machine, Mode, Move, Planner, Pose, Shape, Trivial};

const LIMITS: Limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 };

fn line(x: f64) -> Move {
    let shape = Shape::Line { end: Pose::from_xyz([x, 0.0, 0.0]) };
    Move { shape, feed: 60.0, mode: Mode::Blend(0.1), line: 7 }
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
