//! Highest speeds that were not planned: they are those of the group that governs the feed, whatever the path coordinate is.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_trajectory::{Follower, Limits, Machine, Mode, Move, Planner, Pose, Shape, Tops, Trivial};

const H: f64 = 1e-3;

fn machine(jerk: f64) -> Machine {
    Machine::uniform(Limits { velocity: 200.0, acceleration: 1750.0, jerk })
}

/// Plans lines to these places of X, A and U, as fast as the limits allow.
fn planned(jerk: f64, mode: Mode, ends: &[[f64; 3]]) -> Planner<Trivial> {
    let mut planner = Planner::new(machine(jerk), Trivial, Pose::ZERO).unwrap();
    for (line, [x, a, u]) in (1..).zip(ends) {
        let end = Pose([*x, 0.0, 0.0, *a, 0.0, 0.0, *u, 0.0, 0.0]);
        let shape = Shape::Line { end };
        planner.push(&Move { shape, feed: f64::INFINITY, rapid: false, mode, line }).unwrap();
    }
    planner.finish();
    planner
}

/// Returns the highest speeds of X, A and U in each line, and the time of all.
fn run(planner: &Planner<Trivial>, tops: Tops) -> (Vec<[f64; 3]>, f64) {
    let mut follower = Follower::new(H, Pose::ZERO);
    follower.limit(tops);
    let (mut at, mut out, mut time) = (Pose::ZERO, Vec::new(), 0.0);
    while !follower.is_done(planner.track()) {
        let step = follower.step(planner.track(), 1.0, false);
        let by = (step.pose - at) * (1.0 / H);
        at = step.pose;
        let line = usize::try_from(step.line).unwrap();
        out.resize(out.len().max(line), [0.0_f64; 3]);
        for (most, k) in out[line - 1].iter_mut().zip([0, 3, 6]) {
            *most = most.max(by.0[k].abs());
        }
        time += H;
        assert!(time < 1e3, "it stands");
    }
    (out, time)
}

/// Each move takes the time of a trapezoid of its lead group at the highest speed: of X, else of U, else of A, whose speed no
/// limit of lengths counts for.
#[test]
fn a_highest_speed_is_that_of_the_group_that_governs_the_feed() {
    for ([x, a, u], lead, way) in [
        ([10.0, 0.0, 0.0], 0, 10.0),
        ([1.0, 30.0, 0.0], 0, 1.0),
        ([1.0, 300.0, 20.0], 0, 1.0),
        ([0.0, 0.0, 10.0], 2, 10.0),
        ([0.0, 30.0, 2.0], 2, 2.0),
        ([0.0, 40.0, 0.0], 1, 40.0),
    ] {
        let planner = planned(f64::INFINITY, Mode::ExactStop, &[[x, a, u]]);
        let longest = [x, a, u].into_iter().fold(0.0, f64::max);
        for (tops, is_of_feed) in
            [(Tops { feed: 0.5, ..Tops::NONE }, true), (Tops { linear: 0.5, ..Tops::NONE }, false)]
        {
            let (speeds, time) = run(&planner, tops);
            // The longest way has the full acceleration, and the full speed if nothing else limits it.
            let has_top = is_of_feed || lead != 1;
            let top = if has_top { 0.5 } else { 200.0 };
            let acceleration = 1750.0 * way / longest;
            let peak = f64::min(top, (way * acceleration).sqrt());
            let wanted = way / peak + peak / acceleration;
            assert!((time - wanted).abs() < 3.0 * H, "{x} {a} {u} {tops:?}: {time}, {wanted}");
            assert!(speeds[0][lead] <= top + 1e-9, "{x} {a} {u}: {speeds:?}");
        }
    }
}

/// The motion brakes before the end of a move with a slow lead group, if all of the next move is its lead group; the
/// average of the last periods under a limit of jerk is a little late.
#[test]
fn a_motion_is_slow_enough_before_its_lead_group_is_faster() {
    for jerk in [f64::INFINITY, 1e5, 1e4] {
        for mode in [Mode::ExactStop, Mode::Exact, Mode::Blend(0.05), Mode::Blend(1.0)] {
            let ends = [[2.0, 60.0, 0.0], [30.0, 60.0, 0.0], [31.0, 0.0, 0.0], [32.0, 1.0, 0.0]];
            let planner = planned(jerk, mode, &ends);
            for feed in [0.5, 3.0, 5.0] {
                let (speeds, _) = run(&planner, Tops { feed, ..Tops::NONE });
                for (line, [x, ..]) in (1..).zip(&speeds) {
                    let off = x / feed - 1.0;
                    let most = if jerk < f64::INFINITY { 0.1 } else { 1e-3 };
                    assert!(off < most, "jerk {jerk} {mode:?} feed {feed} line {line}: {x}");
                }
            }
        }
    }
}
