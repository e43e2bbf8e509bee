//! Axes U, V and W, and the control points of splines, which `rs274` does not print.

use std::sync::Arc;

use hal_gcode::{
    Answer, Call, Environment, Error, Interpreter, Issued, Numbered, Settings, Step,
    axis::Position,
    canon::{ControlPoint, Plane},
};

use crate::support::World;

fn run(text: &str) -> Result<(Vec<Issued>, Interpreter), Error> {
    let world: &dyn Environment = &World::new();
    let mut it = Interpreter::new(Settings::default(), Numbered::default());
    it.load("test.ngc", Arc::new(text.as_bytes().to_vec()));
    let mut out = Vec::new();
    let mut step = it.next(world, &mut out)?;
    while step != Step::Ended {
        step = match step {
            Step::Ask(_) => it.answer(&Answer::ToolChange { position: None }, world, &mut out)?,
            _ => it.next(world, &mut out)?,
        };
    }
    Ok((out, it))
}

/// The ends of moves as U, V and W.
fn uvw(text: &str) -> Vec<[f64; 3]> {
    let (calls, _) = run(text).unwrap();
    let ends = calls.iter().filter_map(|i| match i.call {
        Call::StraightFeed(p) | Call::StraightTraverse(p) | Call::ArcFeed { end: p, .. } => Some(p),
        _ => None,
    });
    ends.map(|p| [p.u, p.v, p.w]).collect()
}

#[test]
fn u_v_and_w_move_as_x_y_and_z_do() {
    let cases = [
        ("g0 u1 v2 w3\ng91 g0 u1\nm2\n", vec![[1.0, 2.0, 3.0], [2.0, 2.0, 3.0]]),
        // Inches: positions stay where they are.
        ("g0 u25.4\ng20 g0 v1\nm2\n", vec![[25.4, 0.0, 0.0], [1.0, 1.0, 0.0]]),
        ("g10 l2 p1 u1 w-2\ng0 u0 v0 w0\nm2\n", vec![[0.0, 0.0, 0.0]]),
        ("g0 u5\ng92 u1\ng0 u2\nm2\n", vec![[5.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
        (
            "g0 w7\ng28.1\ng0 w1\ng28 w3\nm2\n",
            vec![[0.0, 0.0, 7.0], [0.0, 0.0, 1.0], [0.0, 0.0, 3.0], [0.0, 0.0, 7.0]],
        ),
        ("g43.1 v4\ng0 v1\ng53 g0 v1\nm2\n", vec![[0.0, 1.0, 0.0], [0.0, -3.0, 0.0]]),
        ("g52 w2\ng0 w1\ng92.1\ng0 u1\nm2\n", vec![[0.0, 0.0, 1.0], [1.0, 0.0, 3.0]]),
    ];
    for (text, expected) in cases {
        let got = uvw(text);
        assert_eq!(got.len(), expected.len(), "{text}");
        for (a, b) in got.iter().zip(&expected) {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{text}: {got:?}");
        }
    }
}

#[test]
fn arcs_and_cycles_work_in_the_planes_of_u_v_and_w() {
    let (calls, _) = run("g17.1 f100\ng2 u2 v0 i1 w5\nm2\n").unwrap();
    let arc = calls.iter().find_map(|i| match &i.call {
        Call::ArcFeed { plane, end, centre_first, centre_second, turns } => {
            Some((*plane, *end, *centre_first, *centre_second, *turns))
        }
        _ => None,
    });
    let end = Position { u: 2.0, w: 5.0, ..Position::default() };
    assert_eq!(arc, Some((Plane::Uv, end, 1.0, 0.0, -1)));
    // Down to W-4 and back to R; U and V name the hole.
    let w: Vec<[f64; 3]> = uvw("g17.1 f100 g0 w10\ng99 g81 u3 v4 w-4 r2\ng80\nm2\n");
    assert_eq!(w.last(), Some(&[3.0, 4.0, 2.0]));
    assert!(w.contains(&[3.0, 4.0, -4.0]) && w.contains(&[3.0, 4.0, 10.0]), "{w:?}");
    for (text, wanted) in [
        ("g17.1 f100\ng2 x1 i1\nm2\n", "Cannot move XYZ axes with arcs in UVW planes"),
        ("f100\ng2 x2 u1 i1\nm2\n", "Cannot move UVW axes with arcs in XYZ planes"),
        ("g17.1 f100 g0 w9\ng81 x1 w-1 r2\nm2\n", "Cannot put an x in canned cycle"),
        ("g17.1 f100\ng41.1 d1\nm2\n", "Cutter radius compensation allowed only in XY, XZ planes"),
    ] {
        let error = run(text).err().unwrap().to_string();
        assert!(error.contains(wanted), "{text}: {error}");
    }
}

/// The order and control points of each spline, and its end.
fn splines(text: &str) -> Vec<(u32, Vec<[f64; 3]>, [f64; 2])> {
    let (calls, _) = run(text).unwrap();
    let mut out = Vec::new();
    for issued in calls {
        if let Call::NurbsFeed { order, points, end } = issued.call {
            let point = |p: &ControlPoint| [p.x, p.y, p.weight];
            out.push((order, points.iter().map(point).collect(), [end.x, end.y]));
        }
    }
    out
}

#[test]
fn splines_have_their_control_points() {
    let got = splines("f100 g0 x1 y1\ng5 i0 j3 p0 q-3 x2 y2\ng5 p1 q-2 x5 y2\nm2\n");
    let first = vec![[1.0, 1.0, 1.0], [1.0, 4.0, 1.0], [2.0, -1.0, 1.0], [2.0, 2.0, 1.0]];
    // Without I and J, the next begins in the direction of the last one's end.
    let second = vec![[2.0, 2.0, 1.0], [2.0, 5.0, 1.0], [6.0, 0.0, 1.0], [5.0, 2.0, 1.0]];
    assert_eq!(got, [(4, first, [2.0, 2.0]), (4, second, [5.0, 2.0])]);
    let got = splines("f100 g0 x1 y1\ng91 g5.1 i1 j2 x3 y0\nm2\n");
    assert_eq!(got, [(3, vec![[1.0, 1.0, 1.0], [2.0, 3.0, 1.0], [4.0, 1.0, 1.0]], [4.0, 1.0])]);
}

#[test]
fn a_nurbs_has_its_weights_order_and_end() {
    let got = splines("f100 g0 x0 y1\ng5.2 p1 l3\nx2 y2 p0.5\nx2 p2\nx0 y0 p3\ng5.3\nm2\n");
    let points = vec![[0.0, 1.0, 1.0], [2.0, 2.0, 0.5], [2.0, 2.0, 2.0], [0.0, 0.0, 3.0]];
    assert_eq!(got, [(3, points, [0.0, 0.0])]);
    let got = splines("f100 g0 x1 y1\ng91 g5.2 x1 y1 p2 l2\nx1 y-1 p1\ng5.3\nm2\n");
    let points = vec![[1.0, 1.0, 2.0], [2.0, 2.0, 2.0], [3.0, 1.0, 1.0]];
    assert_eq!(got, [(2, points, [3.0, 1.0])]);
    // Other motion forgets an open one.
    let error = run("f100\ng5.2 x1 y1 p1\ng0 x1\ng5.3\nm2\n").err().unwrap().to_string();
    assert!(error.contains("Cannot use G5.3 without G5.2 first"), "{error}");
}

#[test]
fn the_time_of_an_inverse_move_is_that_of_its_lines_first() {
    let rates = |text: &str| -> Vec<f64> {
        let (calls, _) = run(text).unwrap();
        let rates = calls.iter().filter_map(|i| match i.call {
            Call::SetFeedRate(rate) if rate > 0.0 => Some(rate),
            _ => None,
        });
        rates.collect()
    };
    assert_eq!(
        rates("g93\ng1 u10 f2\ng1 u20 a90 f2\ng1 a0 f2\ng1 x3 u0 f2\nm2\n"),
        [20.0, 20.0, 180.0, 6.0]
    );
}

#[test]
fn a_spline_goes_on_after_a_change_of_units() {
    let got = splines("f100 g0 x0 y0\ng5 i0 j3 p0 q-25.4 x25.4 y0\ng20\ng5 p0 q-1 x2 y0\nm2\n");
    let [x, y, _] = got[1].1[1];
    assert!((x - 1.0).abs() < 1e-12 && (y - 1.0).abs() < 1e-12, "{got:?}");
}

#[test]
fn the_end_of_a_program_ends_its_modes() {
    let (_, it) = run("g96 s100 d1000 m3\ng18 g91 g95 f1 m7 m49\nm8\ng2 x1 z1 r5\nm2\n").unwrap();
    let modal = &it.state.modal;
    assert_eq!(modal.motion, 10);
    assert!(!modal.spindles[0].css && modal.absolute && !modal.mist && !modal.flood);
    assert!(modal.feed_override && modal.feed == 0.0 && modal.plane == Plane::Xy);
    let (_, it) = run("g55 g0 x1\nm2\n").unwrap();
    assert_eq!(it.state.modal.system, 1);
}

#[test]
fn a_probing_move_has_its_kind() {
    let world: &dyn Environment = &World::new();
    let kind = |code: &str| {
        let mut it = Interpreter::new(Settings::default(), Numbered::default());
        it.mdi(&format!("{code} f10 z-5"));
        let mut out = Vec::new();
        it.next(world, &mut out).unwrap();
        out.iter().find_map(|i| match i.call {
            Call::StraightProbe { away, must_trip, .. } => Some((away, must_trip)),
            _ => None,
        })
    };
    assert_eq!(kind("g38.2"), Some((false, true)));
    assert_eq!(kind("g38.3"), Some((false, false)));
    assert_eq!(kind("g38.4"), Some((true, true)));
    assert_eq!(kind("g38.5"), Some((true, false)));
}
