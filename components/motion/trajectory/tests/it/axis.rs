//! A single axis: limits at goals that change at any time, and its time against the time-optimal motion.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_corpus::Rng;
use hal_trajectory::{Axis, Goal, Limits};
use hal_watchman::{Limits as WatchLimits, Watchman};
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory};

const H: f64 = 1e-3;

fn watch(l: &Limits, size: f64) -> Watchman<1> {
    let limits = WatchLimits { velocity: l.velocity, acceleration: l.acceleration, jerk: l.jerk };
    let mut watch = Watchman::new([limits], H, size);
    watch.rest_at(&[0.0]);
    watch
}

#[test]
fn limits_hold_at_goals_that_change_at_any_time() {
    for seed in 0..400 {
        let mut rng = Rng::new(seed);
        let limits = Limits {
            velocity: rng.log(1.0, 500.0),
            acceleration: rng.log(10.0, 5000.0),
            jerk: rng.pick(&[f64::INFINITY, 1e4, 1e5, 1e6], 1e5),
        };
        let mut axis = Axis::new(limits, H, 0.0).unwrap();
        let mut watch = watch(&limits, 1000.0);
        let change = rng.log(1e-3, 0.3);
        let mut goal = Goal::Velocity(0.0);
        for _ in 0..20_000 {
            if rng.chance(change) {
                goal = match rng.below(4) {
                    0 => Goal::Velocity(0.0),
                    1 => Goal::Velocity(rng.between(-600.0, 600.0)),
                    2 => Goal::Position {
                        to: axis.position() + rng.between(-1.0, 1.0) * rng.log(1e-9, 10.0),
                        speed: rng.log(0.01, 600.0),
                    },
                    _ => Goal::Position { to: rng.between(-300.0, 300.0), speed: 1e6 },
                };
            }
            let x = axis.step(&goal);
            assert!(watch.step(&[x], 0), "seed {seed} {limits:?}: {:?}", watch.report());
        }
        let last = Goal::Position { to: 12.5, speed: 1e3 };
        for _ in 0..2_000_000 {
            let x = axis.step(&last);
            assert!(watch.step(&[x], 0), "seed {seed}: {:?}", watch.report());
            // At a turn the axis rests for a moment.
            if !axis.is_moving() && x == 12.5 {
                break;
            }
        }
        assert_eq!(axis.position(), 12.5, "seed {seed}");
    }
}

/// Least time of a move from rest to rest.
fn least(limits: &Limits, distance: f64) -> f64 {
    let mut otg = Ruckig::<1, ThrowErrorHandler>::new(None, H);
    let mut input = InputParameter::<1>::new(None);
    input.max_velocity[0] = limits.velocity;
    input.max_acceleration[0] = limits.acceleration;
    input.max_jerk[0] = limits.jerk;
    input.target_position[0] = distance;
    let mut trajectory = Trajectory::<1>::new(None);
    let _ = otg.calculate(&input, &mut trajectory).unwrap();
    trajectory.get_duration()
}

#[test]
fn moves_take_the_least_time() {
    let mut rng = Rng::new(1);
    for round in 0..2000 {
        let limits = Limits {
            velocity: rng.log(20.0, 500.0),
            acceleration: rng.log(200.0, 5000.0),
            jerk: rng.log(2e4, 1e6),
        };
        let distance = rng.log(0.01, 1000.0);
        let mut axis = Axis::new(limits, H, 0.0).unwrap();
        let goal = Goal::Position { to: distance, speed: 1e9 };
        let mut periods = 1.0;
        while (axis.step(&goal) < distance || axis.is_moving()) && periods < 1e6 {
            periods += 1.0;
        }
        let time = periods * H;
        let least = least(&limits, distance);
        let filter =
            (limits.acceleration / limits.jerk).min((limits.velocity / limits.jerk).sqrt());
        // The move reaches its acceleration if its peak speed is above A²/J.
        let full = limits.acceleration * limits.acceleration / limits.jerk;
        let reaches =
            limits.velocity >= full && distance >= 2.0 * full * full / limits.acceleration;
        let more = if reaches { 0.0 } else { 2.0 * filter };
        assert!(
            least - 2.0 * H <= time && time <= least * 1.0001 + more + 6.0 * H,
            "round {round}: {time} s, least {least} s, filter {filter} s, {limits:?}, {distance}"
        );
    }
}

/// The place where a jog would stop, if it stopped now, is where it stops.
#[test]
fn a_stop_ends_where_it_was_announced() {
    let limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 };
    for moment in [3, 10, 40, 90, 150, 400] {
        let mut axis = Axis::new(limits, H, 0.0).unwrap();
        for _ in 0..moment {
            axis.step(&Goal::Velocity(150.0));
        }
        let announced = axis.stopping_position();
        axis.step(&Goal::Velocity(0.0));
        while axis.is_moving() {
            axis.step(&Goal::Velocity(0.0));
        }
        let by = axis.position() - announced;
        assert!(by.abs() < 1e-9, "moment {moment}: {by}");
    }
}

#[test]
fn unusable_settings_are_refused_by_name() {
    let good = Limits { velocity: 1.0, acceleration: 1.0, jerk: 1.0 };
    for bad in [0.0, -1.0, f64::NAN, 1e-9] {
        assert!(Axis::new(Limits { velocity: bad, ..good }, H, 0.0).is_err());
        assert!(Axis::new(Limits { acceleration: bad, ..good }, H, 0.0).is_err());
        assert!(Axis::new(Limits { jerk: bad, ..good }, H, 0.0).is_err());
        assert!(Axis::new(good, bad, 0.0).is_err());
    }
    assert!(Axis::new(good, H, f64::INFINITY).is_err());
    let mut axis = Axis::new(good, H, 1.0).unwrap();
    for goal in [Goal::Velocity(f64::NAN), Goal::Position { to: f64::NAN, speed: 1.0 }] {
        assert_eq!(axis.step(&goal), 1.0);
    }
}
