//! Check of a feed per turn against the velocities of the axes, before it moves.

use crate::{
    commands::command::{Follows, Sync},
    commands::refusal::Refusal,
    path::{image::Image, order::PathMove, order::PathSetup, sweep::Sweep, worker},
};
use hal_trajectory::{Group, Pose, Shape};

/// Number of parts of an arc whose directions count.
const PARTS: u32 = 64;

const FAST: &str = "move on line {}: a feed of {} per turn at {} turns/min is faster than the axes allow, {} units/s";

/// Refuses a feed per turn that is faster, at the commanded speed of its spindle, than the axes anywhere along the move.
pub(super) fn check(
    setup: &PathSetup,
    image: &Image,
    start: &Pose,
    step: &PathMove,
) -> Result<(), Refusal> {
    let is_judged = |sync: &Sync| sync.follows == Follows::Speed && !sync.is_at_surface;
    let Some(sync) = step.sync.filter(is_judged) else { return Ok(()) };
    let velocities = worker::with_joints(setup, image, &setup.axis_velocity, &setup.joint_velocity);
    // Other kinematics have other velocities at each place.
    let velocities = velocities.unwrap_or([f64::INFINITY; 9]);
    let sweep = Sweep::new(&start.0, &step.shape);
    let parts = if matches!(step.shape, Shape::Arc { .. }) { PARTS } else { 1 };
    let length = sweep.length() / f64::from(parts);
    let mut top = setup.path_velocity;
    let end = Pose(sweep.at(1.0));
    if [Group::Xyz, Group::Uvw].iter().all(|group| (end - *start).norm(*group) == 0.0) && parts == 1
    {
        // The velocity of the path is that of a length.
        top = f64::INFINITY;
    }
    let mut from = *start;
    for n in 1..=parts {
        let to = Pose(sweep.at(f64::from(n) / f64::from(parts)));
        for (by, velocity) in (to - from).0.iter().zip(&velocities) {
            let along = velocity * length / by.abs();
            top = if along < top { along } else { top };
        }
        from = to;
    }
    // Rounding of a direction is no excess.
    if sync.pitch * step.turns <= top * (1.0 + 1e-9) {
        return Ok(());
    }
    let line = f64::from(step.line);
    Err(Refusal::with(FAST, [line, sync.pitch, 60.0 * step.turns, top]))
}
