//! Programs whose time is compared with a bound, and the bound of a path without a limit of jerk.

use super::{PLAIN, convert, run};
use hal_corpus::{Kind, Mode, Motion, Options, Program, Rng, Step, named, random};
use hal_trajectory::{Limits, Machine, Planner, Pose, Trivial};

/// Velocity and acceleration of each axis.
const V: f64 = 200.0;
pub const A: f64 = 1750.0;

/// Machine of nine equal axes.
pub fn machine(jerk: f64) -> Machine {
    Machine::uniform(Limits { velocity: V, acceleration: A, jerk })
}

/// Seconds that the follower takes.
pub fn taken(program: &Program, machine: &Machine) -> f64 {
    let out = run(program, machine, &Trivial, &PLAIN);
    assert_eq!(out.violations, 0, "{}", out.place);
    out.cycles as f64 * machine.period
}

/// A station of the grid: derivatives, highest squared speed, distance to the next, and true if the next is a stop.
type Station = ([f64; 9], [f64; 9], f64, f64, bool);

/// Least time over the same curves without a limit of jerk: reachability on a grid, with the exact constraints of
/// each axis at each station.
pub fn bound(program: &Program, machine: &Machine) -> f64 {
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
        let mut k = 0.0;
        while k < count {
            let d = curve.at(cell.from + cell.length * (k / count));
            let speed = d.first.norm(hal_trajectory::Group::Xyz);
            // The programmed feed, by the speed in XYZ at this very place.
            let feed = program.steps[cell.line as usize].feed;
            let mut top = if speed > 0.0 { feed / speed } else { 1e9 };
            for (q, l) in d.first.0.iter().zip(&machine.axes) {
                top = top.min(l.velocity / q.abs().max(1e-12));
            }
            stations.push((d.first.0, d.second.0, top * top, cell.length / count, false));
            k += 1.0;
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

/// Times of random programs of one kind at a tolerance: the bound, without a limit of jerk, at a jerk of 1e5 and of 1e4.
pub fn random_times(kind: Kind, p: f64) -> [f64; 4] {
    let mut times = [0.0; 4];
    for (seed, feed) in [(1, 20.0), (2, 60.0), (3, 150.0), (4, 500.0)] {
        let mode = Mode::Blend(p);
        let options = Options { count: 60, axes: 3, mode, feed, stops: 0.02, area: 150.0 };
        let program = random(kind, seed, &options);
        times[0] += bound(&program, &machine(f64::INFINITY));
        times[1] += taken(&program, &machine(f64::INFINITY));
        times[2] += taken(&program, &machine(1e5));
        times[3] += taken(&program, &machine(1e4));
    }
    times
}

/// Kinds and tolerances whose times are compared with the bound.
pub fn random_cases() -> impl Iterator<Item = (Kind, f64)> {
    let kinds = [Kind::Lines, Kind::Arcs, Kind::Reversals, Kind::Mixed];
    kinds.into_iter().flat_map(|kind| [0.0, 0.01, 0.1, 2.0].map(|p| (kind, p)))
}

/// Tangent arcs of radius 4, in one sense or in both in turn.
pub fn small_arcs(both: bool, p: f64) -> Program {
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
        if both {
            turn = -turn;
        }
    }
    Program { name: "tangent arcs", seed: 0, start: [0.0; 9], steps }
}

/// Time of [`small_arcs`] at the speed whose centripetal acceleration is the limit.
pub fn small_arcs_bound() -> f64 {
    40.0 * 2.5 * 4.0 / (A * 4.0).sqrt()
}

/// A circle of radius 10 in lines of 0.1 at a tolerance of 0.01, and the same with noise of 1 um.
pub fn dense_circles() -> [Program; 2] {
    let circle = named("circle-in-lines", 0.01, 150.0).unwrap();
    let mut noisy = circle.clone();
    let mut rng = Rng::new(5);
    let mut last = [0.0; 2];
    for step in &mut noisy.steps {
        if let Motion::Line { by } = &mut step.motion {
            let next = [rng.between(-1e-3, 1e-3), rng.between(-1e-3, 1e-3)];
            by[0] += next[0] - last[0];
            by[1] += next[1] - last[1];
            last = next;
        }
    }
    [circle, noisy]
}

/// Lines of 200 to 400 at 150 per second, each longer than a second.
pub fn long_lines() -> Program {
    let mut rng = Rng::new(8);
    let (mut steps, mut heading) = (Vec::new(), 0.0);
    for _ in 0..40 {
        let (sin, cos) = libm::sincos(heading);
        let length = rng.between(200.0, 400.0);
        let by = [length * cos, length * sin, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        steps.push(Step { motion: Motion::Line { by }, mode: Mode::Blend(0.1), feed: 150.0 });
        heading += rng.between(-2.5, 2.5);
    }
    Program { name: "long lines", seed: 8, start: [0.0; 9], steps }
}

/// A line of 108 in one piece, or in a thousand.
pub fn line_in(pieces: u32) -> Program {
    let part = 1.0 / f64::from(pieces);
    let by = [100.0 * part, 40.0 * part, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let step = Step { motion: Motion::Line { by }, mode: Mode::Exact, feed: 150.0 };
    let steps = vec![step; usize::try_from(pieces).unwrap()];
    Program { name: "split", seed: 0, start: [0.0; 9], steps }
}
