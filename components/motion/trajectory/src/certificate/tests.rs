use super::*;
use crate::{
    blend::{Joint, joint},
    join::Join,
    machine::{Limits, Machine},
    moves::{Mode, straight},
    pose::Group,
};

const TOLERANCES: Tolerances = Tolerances { linear: 0.01, angular: 0.05 };

fn line(from: [f64; 2], to: [f64; 2]) -> Segment {
    let pose = |[x, y]: [f64; 2]| Pose::from_xyz([x, y, 0.0]);
    let shaped = straight(&pose(from), &pose(to)).unwrap();
    Segment {
        curve: shaped.curve,
        length: shaped.length,
        lead: Group::Xyz,
        main: Group::Xyz,
        lead_speed: 1.0,
        feed: 100.0,
        rounded_for: 100.0,
        rapid: false,
        mode: Mode::Blend(0.01),
        line: 7,
        smooth: false,
        off: 0.0,
    }
}

/// Piece of length 1 from (start, 0) on whose Y is these coefficients of 1, u, u², u³.
fn piece(start: f64, y: [f64; 4]) -> Curve {
    let c = |x: f64, y: f64| Pose::from_xyz([x, y, 0.0]);
    let [a, b, d, e] = y;
    let zero = Pose::ZERO;
    Curve::Poly { c: [c(start, a), c(1.0, b), c(0.0, d), c(0.0, e), zero, zero], length: 1.0 }
}

fn joined(curves: &[Curve], lines: &[Segment]) -> (bool, Certificate) {
    let mut certificate = Certificate::default();
    let tolerances = &TOLERANCES;
    let joined = Joined { curves, spacing: 1.0, lines, tolerances };
    (certificate.allows_joining(&joined), certificate)
}

/// Three lines of unequal lengths beside three pieces: the same coordinates, and others by up to 0.3.
#[test]
fn joined_lines_stay_inside_their_tolerance() {
    for shift in [0.0, 0.3] {
        let x = [0.0, 1.0 + shift, 2.0 - shift, 3.0];
        let lines: Vec<_> = x.windows(2).map(|w| line([w[0], 0.0], [w[1], 0.0])).collect();
        // Largest in the middle of the second piece: 4·h·u·(1 − u).
        for (height, good) in [(0.0, true), (0.009_999, true), (0.010_001, false), (0.02, false)] {
            let bump = [0.0, 4.0 * height, -4.0 * height, 0.0];
            let curves = [piece(0.0, [0.0; 4]), piece(1.0, bump), piece(2.0, [0.0; 4])];
            let (allowed, certificate) = joined(&curves, &lines);
            assert_eq!(allowed, good, "{height} {shift}");
            assert_eq!(certificate.rejections, u64::from(!good));
            let said = certificate.last.map(|r| (r.rule, r.line));
            assert_eq!(said, (!good).then_some((Rule::Joining, 7)));
        }
        // Past the end of the last line.
        let curves = [piece(0.0, [0.0; 4]), piece(1.0, [0.0; 4]), piece(2.02, [0.0; 4])];
        assert!(!joined(&curves, &lines).0);
    }
}

/// A spline along the first line beside a corner: it leaves the second line by the sine of the angle.
#[test]
fn a_spline_that_misses_a_corner_is_rejected() {
    for (rise, good) in [(0.009, true), (0.0101, false)] {
        let lines = [line([0.0, 0.0], [1.0, 0.0]), line([1.0, 0.0], [2.0, rise])];
        let curves = [piece(0.0, [0.0; 4]), piece(1.0, [0.0; 4])];
        assert_eq!(joined(&curves, &lines).0, good, "{rise}");
    }
    // The ends use what the middle of the outer half of their piece uses.
    let bump = |height: f64| piece(0.0, [0.0, 4.0 * height, -4.0 * height, 0.0]);
    let lines = [line([0.0, 0.0], [1.0, 0.0]), line([1.0, 0.0], [2.0, 0.0])];
    let curves = [bump(0.004), piece(1.0, [0.0; 4])];
    let [first, last] =
        Joined { curves: &curves, spacing: 1.0, lines: &lines, tolerances: &TOLERANCES }.ends();
    assert!((0.4..0.5).contains(&first) && last < 1e-9, "{first} {last}");
}

/// Numbers that are none pass no rule: of joined lines, of a blend, of a cell, without a limit of jerk too.
#[test]
fn what_is_no_number_is_rejected() {
    let lines = [line([0.0, 0.0], [1.0, 0.0]), line([1.0, 0.0], [2.0, 0.0])];
    for bad in [f64::NAN, f64::INFINITY] {
        let broken = piece(1.0, [0.0, 0.0, bad, 0.0]);
        let (allowed, certificate) = joined(&[piece(0.0, [0.0; 4]), broken], &lines);
        assert!(!allowed && certificate.rejections == 1, "{bad}");
        let mut certificate = Certificate::default();
        let blend = Blend { curve: broken, half: 0.5 };
        assert!(!certificate.allows(&blend, &lines[0], &lines[1], &TOLERANCES), "{bad}");
        for jerk in [1e5, f64::INFINITY] {
            let mut certificate = Certificate::default();
            let mut cell = raw(1.0, 0.0);
            certificate.judge(&law(jerk), &broken, None, &mut cell);
            assert!(certificate.rejections == 1 && cell.allowed.speed < 1e-9, "{bad} {jerk}");
        }
    }
}

/// Round a polygon with sixteen corners, at the same height, the eight lines on either side of any corner lead back to
/// where they came from: together they have no direction there. The run becomes a spline all the same.
#[test]
fn directions_that_cancel_give_no_derivatives() {
    // Exact in binary, so that opposite corners are.
    let round = |x: f64| (x * 1024.0).round() / 1024.0;
    let corner = |k: u32| {
        let (sin, cos) = libm::sincos(core::f64::consts::PI / 8.0 * f64::from(k % 8));
        let sign = if (k / 8).is_multiple_of(2) { 0.25 } else { -0.25 };
        [sign * round(cos), sign * round(sin)]
    };
    let mut join = Join::default();
    for k in 0..64 {
        join.push(&line(corner(k), corner(k + 1)));
    }
    let mut certificate = Certificate::default();
    let found = join.curve(true, &TOLERANCES, &TOLERANCES, &mut certificate);
    let out = join.give(true, found);
    assert_eq!(certificate.rejections, 0);
    assert!(out.iter().all(|s| matches!(s.curve, Curve::Poly { .. })), "lines stay lines");
    for segment in &out {
        assert!(segment.curve.pose(0.5 * segment.length).is_usable(), "{segment:?}");
    }
}

/// A bound of the share that an end uses, coarser than the one that allowed the spline, leaves no tolerance below zero.
#[test]
fn ends_use_no_more_than_the_tolerance() {
    // Largest at 3/16, where the coarse bound of 1/8 to 1/4 is above it.
    let (high, k, at) = (0.009_999, 0.01, 0.1875);
    let curves = [piece(0.0, [high - k * at * at, 2.0 * k * at, -k, 0.0]), piece(1.0, [0.0; 4])];
    let lines = [line([0.0, 0.0], [1.0, 0.0]), line([1.0, 0.0], [2.0, 0.0])];
    assert!(joined(&curves, &lines).0);
    let [first, last] =
        Joined { curves: &curves, spacing: 1.0, lines: &lines, tolerances: &TOLERANCES }.ends();
    assert!((0.99..=1.0).contains(&first) && last < 1e-9, "{first} {last}");
    // With nothing left, the joint at such an end is a stop.
    let none = Tolerances { linear: 0.0, angular: 0.0 };
    let end = Segment { curve: curves[0], length: 1.0, ..lines[0] };
    assert_eq!(joint(&end, &lines[1], 0.5, &none, true), Joint::Stop);
}

fn law(jerk: f64) -> Law {
    let machine = Machine::uniform(Limits { velocity: 200.0, acceleration: 1750.0, jerk });
    Law::new(&machine, machine.axes)
}

fn raw(speed: f64, start: f64) -> Raw {
    let allowed = Allowed { speed, rest: 1000.0, fade: 0.0 };
    Raw {
        curve: 0,
        from: 0.0,
        length: 1.0,
        allowed,
        feed: 100.0,
        rapid: f64::INFINITY,
        lead: 1.0,
        linear: 1.0,
        line: 7,
        start,
    }
}

/// A cell above a limit of speed gets less, and the reason has a name.
#[test]
fn a_cell_that_is_too_fast_is_slowed_down() {
    let (law, curve) = (law(f64::INFINITY), line([0.0, 0.0], [1.0, 0.0]).curve);
    let mut certificate = Certificate::default();
    let mut good = raw(199.0, 0.0);
    certificate.judge(&law, &curve, None, &mut good);
    assert_eq!((certificate.rejections, good), (0, raw(199.0, 0.0)));
    let mut fast = raw(201.0, 0.0);
    certificate.judge(&law, &curve, None, &mut fast);
    assert_eq!(fast.allowed.speed, 100.5);
    let last = certificate.last.unwrap();
    assert_eq!((certificate.rejections, last.rule), (1, Rule::Limits));
    assert_eq!(
        last.to_string(),
        "line 7: a limit of an axis or joint would be exceeded at a speed of 201; the motion is slower there"
    );
}

/// A cell in reach of a slower one gets the limits of that one; out of reach it keeps its own.
#[test]
fn a_cell_beside_a_slower_one_is_slowed_down() {
    for (start, good) in [(1.05, false), (1.15, true)] {
        let mut certificate = Certificate::default();
        let slow = raw(10.0, 0.0);
        // 10 units per second for a hundredth of a second.
        certificate.remember(&slow, 0.01);
        let mut fast = raw(50.0, start);
        certificate.remember(&fast, 0.01);
        certificate.admit(&mut fast);
        assert_eq!(fast.allowed.speed, if good { 50.0 } else { 10.0 });
        let rule = certificate.last.map(|r| r.rule);
        assert_eq!(rule, (!good).then_some(Rule::Neighbour));
    }
}

/// A blend of twice the half that the tolerance allows is no blend.
#[test]
fn a_blend_outside_its_tolerance_is_rejected() {
    let (a, b) = (line([0.0, 0.0], [5.0, 0.0]), line([5.0, 0.0], [5.0, 5.0]));
    for (tolerance, good) in [(0.01, true), (0.02, false)] {
        let t = Tolerances { linear: tolerance, ..TOLERANCES };
        let Joint::Blend(blend) = joint(&a, &b, 2.5, &t, true) else { panic!("no blend") };
        let mut certificate = Certificate::default();
        assert_eq!(certificate.allows(&blend, &a, &b, &TOLERANCES), good);
        let rule = certificate.last.map(|r| r.rule);
        assert_eq!(rule, (!good).then_some(Rule::Deviation));
    }
}
