//! The path of a rigid tap: beyond its depth and beyond its start, as far as the limits allow.

use crate::{
    commands::refusal::Refusal,
    path::{
        image::Image,
        order::{PathMove, PathSetup, Rider, Session, Way},
        reach, worker,
    },
};
use hal_trajectory::{Group, Mode, Move, Planner, Pose, Shape};

/// Number of halvings in the search for the longest overrun.
const HALVINGS: u32 = 12;

/// Plans a tap from the start of a path. The motion begins at that start, in the middle of the path.
pub(super) fn plan(
    setup: &PathSetup,
    image: Image,
    id: u32,
    step: &PathMove,
) -> Result<Session, Refusal> {
    let Shape::Line { end } = step.shape else {
        return Err(Refusal::new("a tap is a straight line"));
    };
    let start = Pose(setup.start);
    reach::check(setup, &image, &start, step)?;
    let by = end - start;
    let length = by.norm(Group::Xyz);
    let overrun = by * (setup.overrun / length);
    let above = reachable(setup, &image, step, start, overrun * -1.0);
    let below = reachable(setup, &image, step, end, overrun);
    let top = start + overrun * -above;
    let refuse = |why| worker::refusal(why).on_line(step.line);
    let rider =
        Rider::Pursuer(worker::pursuer(setup, &image, start).begin_at(setup.overrun * above));
    let mut planner = Planner::new(worker::machine(setup), image, top).map_err(refuse)?;
    planner.limit_jerk(setup.path_jerk);
    let shape = Shape::Line { end: end + overrun * below };
    let whole = Move { shape, feed: f64::INFINITY, rapid: false, mode: Mode::ExactStop, line: id };
    planner.limit_acceleration(step.acceleration);
    planner.push(&whole).map_err(refuse)?;
    planner.finish();
    let way = Way::Own(Box::new(planner.track().clone()));
    Ok(Session { generation: setup.generation, rider, way })
}

/// Returns the largest part of a way from a pose that keeps all limits.
fn reachable(setup: &PathSetup, image: &Image, step: &PathMove, from: Pose, by: Pose) -> f64 {
    let may = |part: f64| {
        let shape = Shape::Line { end: from + by * part };
        reach::check(setup, image, &from, &PathMove { shape, ..*step }).is_ok()
    };
    if may(1.0) {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if may(middle) { low = middle } else { high = middle }
    }
    low
}
