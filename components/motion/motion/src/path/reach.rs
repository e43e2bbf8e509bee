//! Check of a move against the limits of axes and joints, before anything moves.

use crate::{
    commands::refusal::Refusal,
    path::{image::Image, order::PathMove, order::PathSetup, sweep::Sweep},
};
use hal_trajectory::{Joints, Kinematics, Pose, Shape};

/// Tolerance for rounding of a position, in machine units.
const SLACK: f64 = 1e-6;

/// Distance between two samples of the joints along a move, and their least and largest number.
const SAMPLE: f64 = 2.0;
const SAMPLES: (f64, f64) = (16.0, 4000.0);

/// Texts about moves beyond a limit of each axis: of lines and of arcs, positive and negative.
macro_rules! beyond {
    ($kind:literal: $($axis:literal)*) => {
        [$([
            concat!($kind, " move on line {} would exceed ", $axis, "'s positive limit, {}, by {}"),
            concat!($kind, " move on line {} would exceed ", $axis, "'s negative limit, {}, by {}"),
        ]),*]
    };
}
static LINES: [[&str; 2]; 9] = beyond!("linear": "X" "Y" "Z" "A" "B" "C" "U" "V" "W");
static ARCS: [[&str; 2]; 9] = beyond!("circular": "X" "Y" "Z" "A" "B" "C" "U" "V" "W");

/// Refuses a move that leaves the limits of an axis or joint, or that the kinematics have no joints for. A joint that is
/// beyond its limit at the start may come back.
pub(crate) fn check(
    setup: &PathSetup,
    image: &Image,
    start: &Pose,
    order: &PathMove,
) -> Result<(), Refusal> {
    let sweep = Sweep::new(&start.0, &order.shape);
    axes(setup, &sweep, start, order)?;
    joints(setup, image, &sweep, order)
}

fn is_arc(order: &PathMove) -> bool {
    matches!(order.shape, Shape::Arc { .. })
}

fn axes(setup: &PathSetup, sweep: &Sweep, start: &Pose, order: &PathMove) -> Result<(), Refusal> {
    let texts = if is_arc(order) { &ARCS } else { &LINES };
    let line = f64::from(order.line);
    let judge = |n: usize, pos: f64| {
        let (Some(min), Some(max)) = (setup.axis_min.get(n), setup.axis_max.get(n)) else {
            return Ok(());
        };
        let [above, below] = texts.get(n).copied().unwrap_or_default();
        if pos > max + SLACK {
            return Err(Refusal::with(above, [line, *max, pos - max, 0.0]));
        }
        if pos < min - SLACK {
            return Err(Refusal::with(below, [line, *min, min - pos, 0.0]));
        }
        Ok(())
    };
    let end = sweep.at(1.0);
    for (n, (pos, from)) in end.iter().zip(&start.0).enumerate() {
        // An axis that stays where it is may be beyond a limit already.
        if pos.to_bits() != from.to_bits() || is_arc(order) && n < 3 {
            judge(n, *pos)?;
        }
        for k in 0..2 {
            let Some(t) = sweep.extreme(n, k) else { break };
            judge(n, sweep.at(t).get(n).copied().unwrap_or(0.0))?;
        }
    }
    Ok(())
}

fn joints(
    setup: &PathSetup,
    image: &Image,
    sweep: &Sweep,
    order: &PathMove,
) -> Result<(), Refusal> {
    let at = |t: f64| solved(image, &Pose(sweep.at(t)), order.line);
    let from = at(0.0)?;
    let direct = image.axes_of_joints().is_some();
    if direct {
        for t in (0..3).flat_map(|n| (0..2).filter_map(move |k| sweep.extreme(n, k))) {
            inside(setup, image, &from, &at(t)?, (order, false))?;
        }
    } else {
        let parts = (sweep.length() / SAMPLE).ceil();
        let parts = if parts > SAMPLES.0 { parts.min(SAMPLES.1) } else { SAMPLES.0 };
        let mut t = 1.0;
        while t < parts {
            inside(setup, image, &from, &at(t / parts)?, (order, false))?;
            t += 1.0;
        }
    }
    inside(setup, image, &from, &at(1.0)?, (order, true))
}

fn solved(image: &Image, pose: &Pose, line: u32) -> Result<Joints, Refusal> {
    image.inverse(pose).map_err(|_| {
        let [x, y, z, ..] = pose.0;
        Refusal::with(
            "move on line {}: the kinematics cannot go there: x {} y {} z {}",
            [f64::from(line), x, y, z],
        )
    })
}

/// Refuses joint positions beyond a limit, and motion of a joint that is not configured.
fn inside(
    setup: &PathSetup,
    image: &Image,
    from: &Joints,
    places: &Joints,
    (order, is_end): (&PathMove, bool),
) -> Result<(), Refusal> {
    let line = f64::from(order.line);
    let limits = setup.joint_min.iter().zip(&setup.joint_max).zip(&setup.joint_active);
    for (n, ((place, start), ((min, max), active))) in
        places.iter().zip(from).zip(limits).enumerate()
    {
        let joint = n as f64;
        if !active {
            if (place - start).abs() > SLACK {
                return Err(Refusal::with(
                    "move on line {} needs joint {}, which is not configured",
                    [line, joint, 0.0, 0.0],
                ));
            }
            continue;
        }
        let is_beyond = |pos: f64| pos > max + SLACK || pos < min - SLACK;
        if !is_beyond(*place) || !is_end && is_beyond(*start) {
            continue;
        }
        // A person knows the axis, where each joint follows one.
        let axis = image.axes_of_joints().and_then(|axes| axes.get(n).copied().flatten());
        let known = if is_arc(order) { &ARCS } else { &LINES };
        if let Some([above, below]) = axis.and_then(|axis| known.get(axis)) {
            return Err(if place > max {
                Refusal::with(above, [line, *max, place - max, 0.0])
            } else {
                Refusal::with(below, [line, *min, min - place, 0.0])
            });
        }
        let texts = if is_arc(order) { CIRCULAR } else { LINEAR };
        return Err(if place > max {
            Refusal::with(texts[0], [line, joint, *max, place - max])
        } else {
            Refusal::with(texts[1], [line, joint, *min, min - place])
        });
    }
    Ok(())
}

const LINEAR: [&str; 2] = [
    "linear move on line {} would exceed joint {}'s positive limit, {}, by {}",
    "linear move on line {} would exceed joint {}'s negative limit, {}, by {}",
];
const CIRCULAR: [&str; 2] = [
    "circular move on line {} would exceed joint {}'s positive limit, {}, by {}",
    "circular move on line {} would exceed joint {}'s negative limit, {}, by {}",
];
