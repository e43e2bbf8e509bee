//! Closed forms: nothing is invented on a motion that obeys its limits, and a violation of a thousandth is found.

use crate::{Limits, PathWatch, Shape, Spline, Tolerance, Watchman};

const H: f64 = 1e-3;
const LIMITS: Limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 };

/// A motion of constant jerk per piece: (jerk, duration).
fn play(pieces: &[(f64, f64)], start: f64, mut see: impl FnMut(f64)) {
    let total: f64 = pieces.iter().map(|p| p.1).sum();
    let mut cycle = 0.0;
    loop {
        let t = cycle * H;
        let (mut left, mut s, mut v, mut a) = (t, start, 0.0, 0.0);
        for (jerk, length) in pieces {
            let d = left.min(*length);
            s += d * (v + d * (a / 2.0 + d * jerk / 6.0));
            v += d * (a + d * jerk / 2.0);
            a += d * jerk;
            left -= d;
        }
        see(s);
        if t > total + 10.0 * H {
            return;
        }
        cycle += 1.0;
    }
}

/// A rest-to-rest move that reaches the velocity `v`, acceleration `a` and jerk `j`.
fn s_curve(v: f64, a: f64, j: f64) -> Vec<(f64, f64)> {
    let (ramp, flat) = (a / j, v / a - a / j);
    vec![(j, ramp), (0.0, flat), (-j, ramp), (0.0, 0.1), (-j, ramp), (0.0, flat), (j, ramp)]
}

fn judge(limits: Limits, pieces: &[(f64, f64)], start: f64) -> Watchman<1> {
    let mut watch = Watchman::new([limits], H, start.abs());
    watch.rest_at(&[start]);
    play(pieces, start, |s| {
        watch.step(&[s], 7);
    });
    watch
}

#[test]
fn a_motion_at_its_limits_is_no_violation() {
    for start in [0.0, -12.5, 1000.0, 1e6] {
        for scale in [1.0, 0.9, 0.31] {
            let l = LIMITS;
            let pieces = s_curve(l.velocity * scale, l.acceleration * scale, l.jerk * scale);
            let report = *judge(LIMITS, &pieces, start).report();
            assert_eq!(report.violations, 0, "start {start} scale {scale}: {report:?}");
            let near = if start.abs() < 1e5 { 0.999 * scale } else { 0.9 * scale };
            assert!(report.velocity.ratio > near, "{report:?}");
            assert!(report.acceleration.ratio > near * 0.9, "{report:?}");
            assert!(report.jerk.ratio > near * 0.9, "{report:?}");
        }
    }
}

#[test]
fn a_violation_of_a_thousandth_is_found() {
    let more = 1.001;
    for start in [0.0, 1000.0] {
        let l = LIMITS;
        let cases = [
            (s_curve(l.velocity * more, l.acceleration * 0.8, l.jerk * 0.8), 0),
            (s_curve(l.velocity * 0.8, l.acceleration * more, l.jerk * 0.8), 1),
            (s_curve(l.velocity * 0.8, l.acceleration * 0.8, l.jerk * more), 2),
        ];
        for (pieces, which) in cases {
            let report = *judge(LIMITS, &pieces, start).report();
            assert!(report.violations > 0, "start {start}, value {which}: {report:?}");
            let ratios = [report.velocity.ratio, report.acceleration.ratio, report.jerk.ratio];
            for (k, ratio) in ratios.iter().enumerate() {
                assert_eq!(*ratio > 1.0, k == which, "start {start}: {report:?}");
            }
            assert!((ratios[which] - more).abs() < 2e-4, "{report:?}");
        }
    }
}

#[test]
fn the_worst_has_its_cycle_joint_and_line() {
    let mut watch = Watchman::new([LIMITS; 3], H, 1.0);
    watch.rest_at(&[0.0; 3]);
    for cycle in 0..20_u32 {
        let step = if cycle < 9 { 0.0 } else { 1e-6 };
        watch.step(&[0.0, 0.0, step], cycle + 100);
    }
    let jerk = watch.report().jerk;
    // The third difference of a step of 1e-6 is at most 2e-6: 2000 units per second cubed.
    assert_eq!((jerk.cycle, jerk.joint, jerk.line), (10, 2, 110));
    assert!((jerk.ratio - 2000.0 / LIMITS.jerk).abs() < 1e-6, "{jerk:?}");
}

#[test]
fn the_first_position_counts_from_the_point_of_rest() {
    let mut watch = Watchman::new([LIMITS], H, 1.0);
    watch.rest_at(&[0.0]);
    assert!(!watch.step(&[0.1], 0), "0.1 units from rest in a period is an acceleration of 1e5");
    let mut watch = Watchman::new([LIMITS], H, 1.0);
    assert!(watch.step(&[0.1], 0), "without a point of rest the first position is one");
}

#[test]
fn nan_and_infinity_are_violations() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut watch = Watchman::new([LIMITS], H, 1.0);
        assert!(watch.step(&[0.0], 0));
        assert!(!watch.step(&[bad], 0));
        assert_eq!(watch.report().violations, 1);
        let line = Shape::Line { from: [0.0; 9], to: [1.0; 9] };
        let tolerance = Tolerance { linear: 1.0, angular: 1.0 };
        let mut path = PathWatch::new(Box::new([(line, tolerance)]), 1.0, 2);
        assert!(!path.step(&[0.0, bad, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0));
    }
}

#[test]
fn no_limit_is_no_violation_and_a_limit_of_zero_allows_no_motion() {
    let free = Limits { jerk: f64::INFINITY, ..LIMITS };
    let mut watch = Watchman::new([free], H, 1.0);
    watch.rest_at(&[0.0]);
    watch.step(&[0.001], 0);
    assert_eq!(watch.report().jerk.ratio, 0.0);
    assert!(watch.report().acceleration.ratio > 0.5);
    let none = Limits { velocity: 0.0, ..LIMITS };
    let mut watch = Watchman::new([none], H, 1.0);
    watch.rest_at(&[5.0]);
    assert!(watch.step(&[5.0], 0));
    assert!(!watch.step(&[5.000_001], 0));
}

fn pose(x: f64, y: f64, z: f64) -> [f64; 9] {
    [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
}

fn ratio(shapes: &[(Shape, Tolerance)], at: [f64; 9], near: usize) -> f64 {
    let mut watch = PathWatch::new(shapes.into(), 10.0, 1);
    watch.step(&at, near);
    watch.worst().ratio
}

#[test]
fn distance_from_lines() {
    let tolerance = Tolerance { linear: 0.1, angular: 0.05 };
    let shapes: Vec<_> = (0..50)
        .map(|k| {
            let x = f64::from(k);
            (Shape::Line { from: pose(x, 0.0, 0.0), to: pose(x + 1.0, 0.0, 0.0) }, tolerance)
        })
        .collect();
    assert_eq!(ratio(&shapes, pose(3.5, 0.0, 0.0), 3), 0.0);
    assert!((ratio(&shapes, pose(3.5, 0.06, 0.08), 3) - 1.0).abs() < 1e-9);
    assert!(ratio(&shapes, pose(3.5, 0.0, 0.1001), 3) > 1.0005);
    assert!((ratio(&shapes, pose(-0.05, 0.0, 0.0), 0) - 0.5).abs() < 1e-9, "before the start");
    assert_eq!(ratio(&shapes, pose(40.0, 0.0, 0.0), 3), 0.0, "a poor hint costs time only");
    let mut tilted = pose(3.5, 0.0, 0.0);
    tilted[4] = 0.06;
    assert!((ratio(&shapes, tilted, 3) - 1.2).abs() < 1e-9, "rotary axes have their own tolerance");
    tilted[4] = 0.0;
    tilted[7] = 0.05;
    assert!((ratio(&shapes, tilted, 3) - 0.5).abs() < 1e-9, "UVW count as lengths");
}

#[test]
fn a_pure_rotary_line_is_judged_in_degrees() {
    let mut to = [0.0; 9];
    to[3] = 90.0;
    let tolerance = Tolerance { linear: 0.1, angular: 0.05 };
    let shapes = [(Shape::Line { from: [0.0; 9], to }, tolerance)];
    let mut at = [0.0; 9];
    at[3] = 45.0;
    assert_eq!(ratio(&shapes, at, 0), 0.0);
    at[4] = 0.1;
    assert!((ratio(&shapes, at, 0) - 2.0).abs() < 1e-9);
}

#[test]
fn distance_from_arcs_and_helices() {
    let tolerance = Tolerance { linear: 0.1, angular: 0.05 };
    for angle in [4.0, -4.0, 7.0, 628.0] {
        for rise in [0.0, 0.3] {
            let turned = |t: f64| {
                let (sin, cos) = libm::sincos(angle * t);
                pose(10.0 + 5.0 * cos, 5.0 * sin, rise * angle.abs() * t)
            };
            let arc = Shape::Arc {
                from: turned(0.0),
                to: turned(1.0),
                center: [10.0, 0.0, 0.0],
                normal: [0.0, 0.0, 1.0],
                angle,
            };
            let shapes = [(arc, tolerance)];
            for k in 0..=10 {
                let t = f64::from(k) / 10.0;
                let on = turned(t);
                let found = ratio(&shapes, on, 0);
                assert!(found < 1e-5, "angle {angle} rise {rise} t {t}: {found}");
                let (sin, cos) = libm::sincos(angle * t);
                let mut off = on;
                off[0] += 0.2 * cos;
                off[1] += 0.2 * sin;
                let found = ratio(&shapes, off, 0);
                assert!((found - 2.0).abs() < 1e-4, "angle {angle} rise {rise} t {t}: {found}");
            }
        }
    }
}

/// The best place on the arc is between the one that is nearest in XYZ and the one that is nearest in ABC. With distances of
/// `radius * angle * (d - x)` and `degrees * x` from it, the larger ratio to the tolerance is least where both are equal.
#[test]
fn an_arc_with_rotary_axes_is_judged_where_both_distances_are_small() {
    let tolerance = Tolerance { linear: 0.1, angular: 0.05 };
    let (radius, degrees) = (5.0, 12.0);
    for angle in [2.0_f64, -4.0] {
        let turned = |t: f64, a: f64| {
            let (sin, cos) = libm::sincos(angle * t);
            let mut at = pose(radius * cos, radius * sin, 0.0);
            at[3] = degrees * a;
            at
        };
        let (from, to) = (turned(0.0, 0.0), turned(1.0, 1.0));
        let (center, normal) = ([0.0; 3], [0.0, 0.0, 1.0]);
        let shapes = [(Shape::Arc { from, to, center, normal, angle }, tolerance)];
        for t in [0.1, 0.5, 0.8] {
            for d in [0.012, -0.02] {
                let along = radius * angle.abs() / tolerance.linear;
                let tilt = degrees / tolerance.angular;
                let wanted = f64::abs(d) / (1.0 / along + 1.0 / tilt);
                let watch = PathWatch::new(shapes.clone().into(), 10.0, 1);
                let found = watch.ratio(&turned(t + d, t), 0, 0);
                assert!((found - wanted).abs() < 1e-3 * wanted, "{t} {d}: {found}, not {wanted}");
            }
        }
    }
}

#[test]
fn a_changed_zero_is_no_motion() {
    let limits = Limits { jerk: f64::INFINITY, ..LIMITS };
    let mut watch = Watchman::new([limits], H, 1000.0);
    watch.rest_at(&[0.0]);
    let mut x = 0.0;
    for n in 0..200 {
        x += 0.1 * LIMITS.velocity * H * f64::from(n.min(100)) / 100.0;
        if n == 30 || n == 70 {
            x += 777.0;
            watch.restart();
        }
        assert!(watch.step(&[x], 3), "{n}: {:?}", watch.report());
    }
    // What follows is judged again: velocity, acceleration and jerk in turn.
    for (after, good) in [(1, true), (2, true), (3, false)] {
        let mut watch = Watchman::new([LIMITS], H, 1000.0);
        watch.rest_at(&[0.0]);
        watch.restart();
        let step = 0.5 * LIMITS.velocity * H;
        let mut fine = true;
        for n in 0..after {
            fine &= watch.step(&[if n < 2 { f64::from(n) * step } else { step }], 4);
        }
        assert_eq!(fine, good, "{after}");
    }
    watch.restart();
    assert!(watch.step(&[0.0], 5));
    assert!(!watch.step(&[777.0], 6));
    assert_eq!(watch.report().velocity.line, 6);
    watch.forget();
    assert_eq!(watch.report().velocity.ratio, 0.0);
}

#[test]
fn limits_change_on_the_way() {
    let mut watch = Watchman::new([LIMITS], H, 1.0);
    watch.rest_at(&[0.0]);
    let step = 1e-7;
    assert!(watch.step(&[0.0], 0) && watch.step(&[step * 1e-3], 0));
    watch.set_limits([Limits { velocity: 1e-8, ..LIMITS }], H, 0.0);
    assert!(!watch.step(&[step], 0));
    assert!(watch.report().velocity.ratio > 1.0);
}

/// A full circle of nine weighted points is met within rounding, and a pose 0.15 beside it is so far away.
#[test]
fn a_nurbs_circle_is_judged_as_a_circle() {
    let w = 0.5_f64.sqrt();
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points: Vec<_> = corners
        .iter()
        .enumerate()
        .map(|(k, (x, y))| {
            (pose(4.0 * f64::from(*x), 4.0 * f64::from(*y), 0.0), if k % 2 == 0 { 1.0 } else { w })
        })
        .collect();
    let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    assert_eq!(Spline::new(2, &knots[1..], &points), None);
    assert_eq!(Spline::new(8, &knots, &points), None);
    let spline = Spline::new(2, &knots, &points).unwrap();
    for k in 0..=1000 {
        let at = spline.at(f64::from(k) / 1000.0);
        assert!((at[0].hypot(at[1]) - 4.0).abs() < 1e-12, "{at:?}");
    }
    let shapes = [(Shape::Spline(Box::new(spline)), Tolerance { linear: 0.1, angular: 1.0 })];
    for k in 0..1000 {
        let (sin, cos) = libm::sincos(0.01 * f64::from(k));
        for r in [4.0, 4.15, 3.85] {
            let found = ratio(&shapes, pose(r * cos, r * sin, 0.0), 0);
            // A value up to 1 need not be the least.
            let good = if r == 4.0 { found <= 1.0 } else { (found - 1.5).abs() < 1e-6 };
            assert!(good, "{r} {found}");
        }
    }
    // Asked for the least ratio, the judge does not stop at the first one inside the tolerance.
    let watch = PathWatch::new(shapes.into(), 10.0, 1);
    for k in 0..100 {
        let (sin, cos) = libm::sincos(0.1 * f64::from(k));
        for (r, least) in [(4.0, 0.0), (4.03, 0.3), (3.91, 0.9)] {
            let found = watch.ratio(&pose(r * cos, r * sin, 0.0), 0, 1);
            assert!((found - least).abs() < 1e-6, "{r} {found}");
        }
    }
}

/// Deliberate faults of a judge, each of which the tests above must notice.
#[test]
fn faults_of_the_judge_would_be_noticed() {
    let pieces = s_curve(LIMITS.velocity, LIMITS.acceleration * 1.001, LIMITS.jerk * 0.8);
    let blind = Limits { acceleration: LIMITS.acceleration * 1.01, ..LIMITS };
    assert_eq!(judge(blind, &pieces, 0.0).report().violations, 0, "a limit that is 1 % too wide");
    let pieces = s_curve(LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk);
    let strict = Limits { jerk: LIMITS.jerk * 0.999, ..LIMITS };
    assert!(judge(strict, &pieces, 0.0).report().violations > 0, "a limit that is too narrow");
    let mut late = Watchman::new([LIMITS], H * 1.001, 1.0);
    late.rest_at(&[0.0]);
    play(&s_curve(LIMITS.velocity * 1.0005, LIMITS.acceleration, LIMITS.jerk), 0.0, |s| {
        late.step(&[s], 0);
    });
    assert_eq!(late.report().velocity.ratio.max(1.0), 1.0, "a wrong period hides 0.05 %");
}

/// A cubic B-spline that turns back within a hundredth of a span: the distance has two least values beside the bend.
#[test]
fn a_hairpin_of_a_spline_is_searched_on_both_sides() {
    let at = |x: f64, y: f64| ([x, y, 0.3 * y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    for sharp in [1e-3, 0.01, 0.1, 1.0] {
        // The curve runs out along X, and comes back beside itself.
        let points = [at(0.0, 0.0), at(40.0, 0.0), at(7.0, sharp), at(39.0, sharp), at(0.0, 5.0)];
        let spline = Spline::new(3, &knots, &points).unwrap();
        let shape = Shape::Spline(Box::new(spline.clone()));
        let tolerance = Tolerance { linear: 1.0, angular: 1.0 };
        let watch = PathWatch::new(Box::new([(shape, tolerance)]), 50.0, 0);
        let dense: Vec<_> = (0..=40_000).map(|k| spline.at(f64::from(k) / 40_000.0)).collect();
        let (mut seen, mut wide) = (0.0_f64, 0);
        for (k, on) in dense.iter().enumerate().step_by(37) {
            let away = [0.0, 1e-4, 0.003, 0.02, 0.3][k % 5];
            let mut pose = *on;
            pose[1] += away;
            pose[2] -= 0.5 * away;
            let distance = |p: &[f64; 9]| {
                p.iter().zip(&pose).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
            };
            let least = dense.iter().map(distance).fold(f64::INFINITY, f64::min);
            let ratio = watch.ratio(&pose, 0, 0);
            // The dense places are 0.002 apart at most; the search ends with a ten-millionth of its interval.
            assert!(ratio <= least + 1e-6, "sharp {sharp}, place {k}: {ratio} instead of {least}");
            assert!(ratio >= least - 2e-3, "sharp {sharp}, place {k}: {ratio} instead of {least}");
            seen = seen.max(ratio);
            wide += usize::from(away > 0.1 && ratio > 0.05);
        }
        assert!(seen > 0.1 && wide > 100, "sharp {sharp}: the worst is {seen}, {wide} far away");
    }
}
