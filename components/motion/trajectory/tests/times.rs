//! Time of programs against bounds that are found by other means.
#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "tests"
)]

mod judge;

use hal_corpus::{Kind, Mode, Motion, Options, Program, Step, random};
use hal_trajectory::{Follower, Limits, Machine, Planner, Pose, Trivial};
use judge::{PLAIN, convert, run};

const V: f64 = 200.0;
const A: f64 = 1750.0;

/// Largest times of small arcs without a limit of jerk and with one, in one sense; in both senses with a limit of jerk, at
/// tolerances of 0.1, 0.01 and 0: there the curvature has to change its sign inside the tolerance.
const MOST: [f64; 2] = [1.02, 1.12];
const MOST_WITH_TURNS: [f64; 3] = [1.12, 1.32, 1.52];

fn machine(jerk: f64) -> Machine {
    Machine::uniform(Limits { velocity: V, acceleration: A, jerk })
}

/// Seconds that the follower takes.
fn taken(program: &Program, machine: &Machine) -> f64 {
    let out = run(program, machine, &Trivial, &PLAIN);
    assert_eq!(out.violations, 0, "{}", out.place);
    out.cycles as f64 * machine.period
}

/// A station of the grid: derivatives, highest squared speed, distance to the next, and true if the next is a stop.
type Station = ([f64; 9], [f64; 9], f64, f64, bool);

/// Least time over the same curves without a limit of jerk: reachability on a grid, with the exact constraints of
/// each axis at each station.
fn bound(program: &Program, machine: &Machine) -> f64 {
    let (moves, _) = convert(program, machine);
    let mut planner = Planner::new(*machine, Trivial, Pose(program.start)).unwrap();
    for m in &moves {
        m.push(&mut planner).unwrap();
    }
    planner.finish();
    let track = planner.track();
    let mut stations: Vec<Station> = Vec::new();
    for cell in track.cells() {
        let curve = track.curve(cell.curve).unwrap();
        let count = (cell.length / 0.05).ceil().max(2.0);
        for k in 0..count as usize {
            let d = curve.at(cell.from + cell.length * (k as f64 / count));
            let speed = d.first.norm(hal_trajectory::Group::Xyz);
            // The programmed feed, by the speed in XYZ at this very place.
            let feed = program.steps[cell.line as usize].feed;
            let mut top = if speed > 0.0 { feed / speed } else { 1e9 };
            for (q, l) in d.first.0.iter().zip(&machine.axes) {
                top = top.min(l.velocity / q.abs().max(1e-12));
            }
            stations.push((d.first.0, d.second.0, top * top, cell.length / count, false));
        }
        if cell.stop {
            stations.last_mut().unwrap().4 = true;
        }
    }
    let n = stations.len();
    // Lowest and highest acceleration along the path at a squared speed; `None` if there is none.
    let range = |s: &Station, b: f64| {
        let (mut low, mut high) = (-1e12_f64, 1e12_f64);
        for ((q1, q2), l) in s.0.iter().zip(&s.1).zip(&machine.axes) {
            let (a, c) = (l.acceleration, q2 * b);
            if q1.abs() < 1e-9 {
                if c.abs() > a {
                    return None;
                }
                continue;
            }
            let (x, y) = ((-a - c) / q1, (a - c) / q1);
            low = low.max(x.min(y));
            high = high.min(x.max(y));
        }
        (low <= high).then_some((low, high))
    };
    let mut next = 0.0;
    let mut top = vec![0.0; n + 1];
    for k in (0..n).rev() {
        let s = &stations[k];
        if s.4 {
            next = 0.0;
        }
        let good = |b: f64| range(s, b).is_some_and(|(low, _)| b + 2.0 * low * s.3 <= next);
        let mut high = s.2;
        if !good(high) {
            let mut low = 0.0;
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if good(middle) { low = middle } else { high = middle }
            }
            high = low;
        }
        top[k] = high;
        next = high;
    }
    let (mut b, mut time) = (0.0_f64, 0.0);
    for k in 0..n {
        let s = &stations[k];
        b = b.min(top[k]);
        let (_, high) = range(s, b).unwrap();
        let limit = if s.4 || k + 1 == n { 0.0 } else { top[k + 1] };
        let after = (b + 2.0 * high * s.3).min(limit).max(0.0);
        time += 2.0 * s.3 / (b.sqrt() + after.sqrt()).max(1e-12);
        b = after;
    }
    time
}

fn options(mode: Mode, feed: f64, axes: usize) -> Options {
    Options { count: 60, axes, mode, feed, stops: 0.02, area: 150.0 }
}

/// Trapezoids take at most 3 % more than the bound, in the mean; a jerk of 1e5 (57 times the acceleration) at most 8 %,
/// and a jerk of 1e4 at most 40 %.
#[test]
fn times_are_near_the_bounds() {
    println!("kind, tolerance: bound s, trapezoid, jerk 1e5, jerk 1e4 (times of the bound)");
    let mut sums = [0.0; 3];
    let mut count = 0.0;
    for kind in [Kind::Lines, Kind::Arcs, Kind::Reversals, Kind::Mixed] {
        for p in [0.0, 0.01, 0.1, 2.0] {
            let mut times = [0.0; 4];
            for (seed, feed) in [(1, 20.0), (2, 60.0), (3, 150.0), (4, 500.0)] {
                let program = random(kind, seed, &options(Mode::Blend(p), feed, 3));
                times[0] += bound(&program, &machine(f64::INFINITY));
                times[1] += taken(&program, &machine(f64::INFINITY));
                times[2] += taken(&program, &machine(1e5));
                times[3] += taken(&program, &machine(1e4));
            }
            let [b, t, j5, j4] = times;
            println!("{kind:?} P {p}: {b:.3} s, {:.4} {:.4} {:.4}", t / b, j5 / b, j4 / b);
            for (s, x) in sums.iter_mut().zip([t, j5, j4]) {
                *s += x / b;
            }
            count += 1.0;
        }
    }
    let means = sums.map(|s| s / count);
    println!("mean: {means:.4?}");
    assert!(means[0] <= 1.03 && means[1] <= 1.08 && means[2] <= 1.40, "{means:?}");
}

/// Arcs of radius 4 at 1750 mm/s²: time over the length of the arcs at the speed whose centripetal acceleration is the limit.
#[test]
fn small_arcs_are_near_the_centripetal_bound() {
    let least = 40.0 * 2.5 * 4.0 / (A * 4.0).sqrt();
    for (name, flip) in [("one sense", 1.0), ("both senses", -1.0)] {
        for (p, turning) in [0.1, 0.01, 0.0].into_iter().zip(MOST_WITH_TURNS) {
            let (mut steps, mut heading, mut turn) = (Vec::new(), 0.0, 2.5);
            for _ in 0..40 {
                let (sin, cos) = libm::sincos(heading);
                let r = 4.0_f64.copysign(turn);
                steps.push(Step {
                    motion: Motion::Arc {
                        center: [-r * sin, r * cos, 0.0],
                        normal: [0.0, 0.0, 1.0],
                        angle: turn,
                        rise: 0.0,
                        others: [0.0; 6],
                    },
                    mode: Mode::Blend(p),
                    feed: 150.0,
                });
                heading += turn;
                turn *= flip;
            }
            let program = Program { name: "tangent arcs", seed: 0, start: [0.0; 9], steps };
            let [t, j] = [f64::INFINITY, 1e5].map(|jerk| taken(&program, &machine(jerk)) / least);
            println!("arcs of radius 4 in {name}, P {p}: {t:.4}, at a jerk of 1e5 {j:.4}");
            let most = if flip > 0.0 { MOST[1] } else { turning };
            assert!(t <= MOST[0] && j <= most, "{t} {j}");
        }
    }
}

/// A circle of radius 10 in lines of 0.1, with and without noise of 1 um, at a tolerance of 0.01.
#[test]
fn dense_code_is_joined() {
    let circle = hal_corpus::named("circle-in-lines", 0.01, 150.0).unwrap();
    let mut noisy = circle.clone();
    let mut rng = hal_corpus::Rng::new(5);
    let mut last = [0.0; 2];
    for step in &mut noisy.steps {
        if let Motion::Line { by } = &mut step.motion {
            let next = [rng.between(-1e-3, 1e-3), rng.between(-1e-3, 1e-3)];
            by[0] += next[0] - last[0];
            by[1] += next[1] - last[1];
            last = next;
        }
    }
    let [a, b, c] = [(&circle, 1e5), (&noisy, 1e5), (&circle, f64::INFINITY)]
        .map(|(p, jerk)| taken(p, &machine(jerk)));
    println!("circle in lines: {a:.3} s, with noise {b:.3} s, without a limit of jerk {c:.3} s");
    assert!(a <= 0.7 && b <= 1.35 * a, "{a} {b}");
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
