//! Canonical calls as steps.

use super::*;
use crate::convert::Action;
use hal_gcode::{
    Call, Settings,
    axis::{AxisMask, Position},
    canon::{Plane, Unit},
};

fn at(x: f64, y: f64, z: f64) -> Position {
    Position { x, y, z, ..Position::default() }
}

fn converted(settings: &Settings, calls: &[Call]) -> Vec<Action> {
    let mut converter = Converter::new(settings, None);
    let mut out = Vec::new();
    for call in calls {
        converter.convert(call.clone(), 1, &mut out);
    }
    out
}

fn only_move(settings: &Settings, calls: &[Call]) -> Move {
    match converted(settings, calls).as_slice() {
        [Action::Path(Order::Move(m))] => *m,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_machine_in_inches_runs_a_program_in_millimetres() {
    let settings = Settings {
        unit: Unit::Inch,
        program_unit: Unit::Millimetre,
        axes: AxisMask(7),
        ..Settings::default()
    };
    let mut to = at(25.4, 0.0, 0.0);
    to.a = 90.0;
    let m = only_move(&settings, &[Call::SetFeedRate(1524.0), Call::StraightFeed(to)]);
    assert!((m.to[0] - 1.0).abs() < 1e-12 && m.to[3] == 0.0, "the machine has no A");
    let crate::outside::Speed::Feed(feed) = m.speed else { panic!("{:?}", m.speed) };
    assert!((feed - 1.0).abs() < 1e-12, "inches per second");
}

#[test]
fn a_feed_of_rotary_axes_is_in_degrees() {
    let settings = Settings { program_unit: Unit::Inch, ..Settings::default() };
    let to = Position { a: 10.0, ..Position::default() };
    let m = only_move(&settings, &[Call::SetFeedRate(60.0), Call::StraightFeed(to)]);
    assert_eq!(m.speed, crate::outside::Speed::Feed(1.0));
}

#[test]
fn arcs_have_their_plane_and_rotation() {
    let settings = Settings::default();
    let arc = |plane, centre: (f64, f64), turns| Call::ArcFeed {
        plane,
        end: at(2.0, 0.0, 0.0),
        centre_first: centre.0,
        centre_second: centre.1,
        turns,
    };
    let shape = |calls: &[Call]| match only_move(&settings, calls).shape {
        Shape::Arc { center, normal, clockwise, turns } => (center, normal, clockwise, turns),
        other => panic!("{other:?}"),
    };
    let flat = shape(&[arc(Plane::Xy, (1.0, 0.5), -1)]);
    assert_eq!(flat, ([1.0, 0.5, 0.0], [0.0, 0.0, 1.0], true, 0));
    let turns = shape(&[arc(Plane::Xz, (0.25, 1.0), 3)]);
    assert_eq!(turns, ([1.0, 0.0, 0.25], [0.0, 1.0, 0.0], false, 2));
    let (center, normal, ..) = shape(&[Call::SetXyRotation(90.0), arc(Plane::Yz, (1.0, 0.5), 1)]);
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near(normal, [0.0, 1.0, 0.0]) && near(center, [-1.0, 2.0, 0.5]), "{center:?}");
    let refused = converted(&settings, &[arc(Plane::Uv, (0.0, 0.0), 1)]);
    assert!(matches!(&refused[..], [Action::Refuse(_)]));
}

#[test]
fn moves_bound_to_the_spindle_have_a_pitch() {
    let settings = Settings::default();
    let sync = Call::StartSpeedFeedSync { pitch: 1.5, velocity_mode: false, spindle: 0 };
    let m = only_move(&settings, &[sync, Call::StraightFeed(at(0.0, 0.0, -9.0))]);
    let pitch = m.pitch.unwrap();
    assert_eq!((pitch.travel, pitch.velocity_mode), (1.5, false));
    let per_turn = [
        Call::SetFeedMode { spindle: 0, per_revolution: true },
        Call::SetFeedRate(0.2),
        Call::StraightFeed(at(1.0, 0.0, 0.0)),
    ];
    let pitch = only_move(&settings, &per_turn).pitch.unwrap();
    assert_eq!((pitch.travel, pitch.velocity_mode), (0.2, true));
    assert!(!pitch.is_at_surface);
    // At constant surface speed, the turns at the move are not known before.
    let [mode, feed, feeds] = per_turn.clone();
    let surface = Call::SetSpindleMode { spindle: 0, css_max: 2000.0 };
    let pitch = only_move(&settings, &[surface, mode, feed, feeds]).pitch.unwrap();
    assert!(pitch.is_at_surface);
    let rapid =
        [per_turn[0].clone(), per_turn[1].clone(), Call::StraightTraverse(at(1.0, 0.0, 0.0))];
    assert_eq!(only_move(&settings, &rapid).pitch, None);
}

#[test]
fn a_tool_change_leaves_axes_without_a_coordinate() {
    let settings = Settings { axes: AxisMask(15), ..Settings::default() };
    let mut place = [None; 9];
    place[2] = Some(50.0);
    let mut converter = Converter::new(&settings, Some(place));
    let mut out = Vec::new();
    for call in [Call::StraightFeed(Position { a: 90.0, ..at(1.0, 2.0, 3.0) }), Call::ChangeTool(1)]
    {
        converter.convert(call, 1, &mut out);
    }
    let [_, Action::Path(Order::Move(m)), Action::Change(1)] = out.as_slice() else {
        panic!("{out:?}")
    };
    assert_eq!(m.to, [1.0, 2.0, 50.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}
