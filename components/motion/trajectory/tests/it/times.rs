//! Time of programs against bounds that are found by other means.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "tests")]

use crate::judge;

use hal_corpus::{Mode, Motion, Program, Step};
use hal_trajectory::{Follower, Machine, Planner, Pose, Trivial};
use judge::{
    convert,
    times::{
        A, bound, dense_circles, line_in, long_lines, machine, random_cases, random_times,
        small_arcs, small_arcs_bound, taken,
    },
};

/// Largest times of small arcs without a limit of jerk and with one, in one sense; in both senses with a limit of jerk, at
/// tolerances of 0.1, 0.01 and 0: there the curvature has to change its sign inside the tolerance.
const MOST: [f64; 2] = [1.02, 1.12];
const MAX_WITH_TURNS: [f64; 3] = [1.12, 1.32, 1.52];

/// Trapezoids take at most 3 % more than the bound, in the mean; a jerk of 1e5 (57 times the acceleration) at most 8 %,
/// and a jerk of 1e4 at most 40 %.
#[test]
fn times_are_near_the_bounds() {
    println!("kind, tolerance: bound s, trapezoid, jerk 1e5, jerk 1e4 (times of the bound)");
    let mut sums = [0.0; 3];
    let mut count = 0.0;
    for (kind, p) in random_cases() {
        let [b, t, j5, j4] = random_times(kind, p);
        println!("{kind:?} P {p}: {b:.3} s, {:.4} {:.4} {:.4}", t / b, j5 / b, j4 / b);
        for (s, x) in sums.iter_mut().zip([t, j5, j4]) {
            *s += x / b;
        }
        count += 1.0;
    }
    let means = sums.map(|s| s / count);
    println!("mean: {means:.4?}");
    assert!(means[0] <= 1.03 && means[1] <= 1.08 && means[2] <= 1.40, "{means:?}");
}

/// Arcs of radius 4 at 1750 mm/s²: time over the length of the arcs at the speed whose centripetal acceleration is the limit.
#[test]
fn small_arcs_are_near_the_centripetal_bound() {
    let least = small_arcs_bound();
    for (name, both) in [("one sense", false), ("both senses", true)] {
        for (p, turning) in [0.1, 0.01, 0.0].into_iter().zip(MAX_WITH_TURNS) {
            let program = small_arcs(both, p);
            let [t, j] = [f64::INFINITY, 1e5].map(|jerk| taken(&program, &machine(jerk)) / least);
            println!("arcs of radius 4 in {name}, P {p}: {t:.4}, at a jerk of 1e5 {j:.4}");
            let most = if both { turning } else { MOST[1] };
            assert!(t <= MOST[0] && j <= most, "{t} {j}");
        }
    }
}

/// A circle of radius 10 in lines of 0.1, with and without noise of 1 um, at a tolerance of 0.01.
#[test]
fn dense_code_is_joined() {
    let [circle, noisy] = dense_circles();
    let [a, b, c] = [(&circle, 1e5), (&noisy, 1e5), (&circle, f64::INFINITY)]
        .map(|(p, jerk)| taken(p, &machine(jerk)));
    println!("circle in lines: {a:.3} s, with noise {b:.3} s, without a limit of jerk {c:.3} s");
    assert!(a <= 0.7 && b <= 1.35 * a, "{a} {b}");
}

/// Moves of more than a second: at most 0.5 % above the bound, and 5 % at a jerk of 57 times the acceleration.
#[test]
fn long_lines_are_near_the_bound() {
    let program = long_lines();
    let least = bound(&program, &machine(f64::INFINITY));
    let [t, j] = [f64::INFINITY, 1e5].map(|jerk| taken(&program, &machine(jerk)) / least);
    println!("long lines: {t:.4}, at a jerk of 1e5 {j:.4}");
    assert!(t <= 1.005 && j <= 1.05, "{t} {j}");
}

/// A single line takes the least time of its seven phases, and a few periods.
#[test]
fn a_line_takes_the_least_time() {
    let machine = machine(1e5);
    // Along X and Y at once: the limits of X along a line of direction (100, 40).
    let k = 100.0_f64.hypot(40.0) / 100.0;
    let (v, a, j) = (150.0, A * k, 1e5 * k);
    let least = 100.0_f64.hypot(40.0) / v + v / a + a / j;
    let time = taken(&line_in(1), &machine);
    println!("a line: {time:.3} s, seven phases {least:.4} s");
    assert!(least <= time && time <= least + 0.006, "{time} {least}");
}

/// Seconds of a program of these steps at an override.
fn at_override(steps: Vec<Step>, machine: &Machine, scale: f64) -> f64 {
    let program = Program { name: "one feed", seed: 0, start: [0.0; 9], steps };
    let mut planner = Planner::new(*machine, Trivial, Pose::ZERO).unwrap();
    for m in &convert(&program, machine).0 {
        m.push(&mut planner).unwrap();
    }
    planner.finish();
    let mut follower = Follower::new(machine.period, Pose::ZERO);
    let mut cycles = 0;
    while !follower.is_done(planner.track()) {
        let _ = follower.step(planner.track(), scale, false);
        cycles += 1;
    }
    f64::from(cycles) * machine.period
}

/// A circle of radius 50 at 50 mm/s takes its feed; start, stop and filter take 0.1 s.
#[test]
fn a_feed_is_reached_all_around_a_circle() {
    let circle = Motion::Arc {
        center: [50.0, 0.0, 0.0],
        normal: [0.0, 0.0, 1.0],
        angle: core::f64::consts::TAU,
        rise: 0.0,
        others: [0.0; 6],
    };
    let step = Step { motion: circle, mode: Mode::Exact, feed: 50.0 };
    for jerk in [1e5, f64::INFINITY] {
        let time = at_override(vec![step.clone()], &machine(jerk), 1.0);
        let least = core::f64::consts::TAU * 50.0 / 50.0;
        assert!(least < time && time < least + 0.1, "{time} s of {least} s");
    }
    // A circle of radius 1 at its centripetal limit, which cells of a large angle would not reach.
    let small = Motion::Arc {
        center: [1.0, 0.0, 0.0],
        normal: [0.0, 0.0, 1.0],
        angle: 60.0,
        rise: 0.0,
        others: [0.0; 6],
    };
    let step = Step { motion: small, mode: Mode::Exact, feed: 200.0 };
    let time = at_override(vec![step], &machine(f64::INFINITY), 1.0);
    let least = 60.0 / A.sqrt();
    println!("circle of radius 1: {:.4} of the bound", time / least);
    assert!(time < 1.05 * least, "{time} s of {least} s");
}

/// A line of 300 mm at 100 mm/s takes 2 s at an override of 1.5, if the plan is made for it.
#[test]
fn an_override_above_1_is_planned_for() {
    let line = Motion::Line { by: [300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] };
    let step = Step { motion: line, mode: Mode::Exact, feed: 100.0 };
    let fast = Machine { max_override: 1.5, ..machine(1e5) };
    let [slow, plain, fast] = [(machine(1e5), 1.5), (fast, 1.0), (fast, 1.5)]
        .map(|(machine, scale)| at_override(vec![step.clone()], &machine, scale));
    assert!(slow > 3.0 && plain > 3.0, "{slow} s and {plain} s at 100 mm/s");
    assert!(2.0 < fast && fast < 2.2, "{fast} s at 150 mm/s");
}
