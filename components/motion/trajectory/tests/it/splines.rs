//! B-splines and NURBS as moves, judged by the watchman against curves that are found by other means.
#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    reason = "tests"
)]

use hal_corpus::Rng;
use hal_trajectory::{
    Error, Follower, Limits, Machine, Mode, Move, Planner, Pose, Shape, Spline, SplineFault,
    Trivial,
};
use std::fmt::Write as _;

use hal_watchman::{
    AXES, Limits as WatchLimits, PathWatch, Shape as WatchShape, Tolerance, Watchman,
};

fn machine(jerk: f64) -> Machine {
    Machine::uniform(Limits { velocity: 200.0, acceleration: 1750.0, jerk })
}

/// A spline as data, evaluated by the recursion of Cox and de Boor for its basis functions.
struct Data {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<(Pose, f64)>,
}

impl Data {
    fn basis(&self, k: usize, p: usize, u: f64) -> f64 {
        let t = &self.knots;
        let share = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        if p == 0 {
            return f64::from(u8::from(t[k] <= u && u < t[k + 1]));
        }
        share(u - t[k], t[k + p] - t[k]) * self.basis(k, p - 1, u)
            + share(t[k + p + 1] - u, t[k + p + 1] - t[k + 1]) * self.basis(k + 1, p - 1, u)
    }

    fn at(&self, u: f64) -> Pose {
        let (mut sum, mut weight) = (Pose::ZERO, 0.0);
        for (k, (point, w)) in self.points.iter().enumerate() {
            let b = self.basis(k, self.degree, u) * w;
            sum = sum + *point * b;
            weight += b;
        }
        sum * (1.0 / weight)
    }

    fn spline(&self) -> Spline {
        Spline::new(self.degree, &self.knots, &self.points).unwrap()
    }

    /// The curve as chords, and the largest distance between a chord and the middle of its part of the curve. No chord
    /// cuts the corner that the curve may have at a double knot.
    fn chords(&self) -> (Vec<[f64; AXES]>, f64) {
        let inside = &self.knots[self.degree..=self.points.len()];
        let last = inside[inside.len() - 1];
        let at = |u: f64| self.at(u.min(last - 1e-12 * (last - inside[0])));
        let mut off: f64 = 0.0;
        let mut ends = vec![at(inside[0])];
        for span in inside.windows(2).filter(|span| span[0] < span[1]) {
            let u = |k: f64| span[0] + (span[1] - span[0]) * (k / CHORDS as f64);
            for k in 0..CHORDS {
                let (middle, end) = (at(u(k as f64 + 0.5)), at(u(k as f64 + 1.0)));
                let by = middle - (ends[ends.len() - 1] + end) * 0.5;
                off = off.max(by.dot_all(&by).sqrt());
                ends.push(end);
            }
        }
        (ends.into_iter().map(|p| p.0).collect(), off)
    }
}

/// Number of chords between two knots.
const CHORDS: usize = 250;

/// Random control points in nine axes; knots are random, some of them double.
fn random(seed: u64) -> Data {
    let mut rng = Rng::new(seed);
    let degree = 2 + (seed % 2) as usize;
    let count = 5 + rng.below(12) as usize;
    let rational = rng.chance(0.6);
    let axes = 2 + rng.below(8) as usize;
    let mut pose = Pose::ZERO;
    let mut points = Vec::new();
    for _ in 0..count {
        let weight = if rational { rng.log(0.3, 3.0) } else { 1.0 };
        points.push((pose, weight));
        for x in pose.0.iter_mut().take(axes) {
            *x += rng.between(-12.0, 15.0);
        }
    }
    let (mut knots, mut u) = (vec![0.0; degree + 1], 0.0);
    for _ in degree + 1..count {
        u += if rng.chance(0.15) && u > 0.0 && knots[knots.len() - 2] < u {
            0.0
        } else {
            rng.between(0.5, 2.0)
        };
        knots.push(u);
    }
    knots.extend(vec![u + 1.0; degree + 1]);
    Data { degree, knots, points }
}

/// Moves along the splines one after another; returns the periods and the worst ratios of velocity, acceleration, jerk and
/// distance. The override changes at random, if it changes at all.
fn judged(
    splines: &[Spline],
    shapes: Vec<(WatchShape, Tolerance)>,
    machine: &Machine,
    mode: Mode,
    feed: f64,
    seed: u64,
) -> (u64, [f64; 4]) {
    let mut planner = Planner::new(*machine, Trivial, Pose::ZERO).unwrap();
    for spline in splines {
        planner.push_spline(spline, feed, mode, 0).unwrap();
    }
    planner.finish();
    assert_eq!(planner.rejections().0, 0, "seed {seed}");
    let end = *planner.position();
    let limits = |l: &Limits| WatchLimits {
        velocity: l.velocity,
        acceleration: l.acceleration,
        jerk: l.jerk,
    };
    let mut watch = Watchman::<AXES>::new(machine.axes.map(|l| limits(&l)), machine.period, 300.0);
    watch.rest_at(&[0.0; AXES]);
    let starts: Vec<Pose> = shapes.iter().map(|(shape, _)| Pose(shape.at(0.0))).collect();
    let mut path = PathWatch::new(shapes.into(), 300.0, 40);
    let mut follower = Follower::new(machine.period, Pose::ZERO);
    let mut rng = Rng::new(seed);
    let (mut scale, mut cycles, mut near, mut pose) = (1.0, 0, 0, Pose::ZERO);
    while !follower.is_done(planner.track()) {
        if seed > 0 && cycles < 20_000 && rng.chance(0.005) {
            scale = rng.pick(&[0.0, 0.3, 1.0, 1.0], 1.0);
        } else if cycles >= 20_000 || scale == 0.0 && rng.chance(0.01) {
            scale = 1.0;
        }
        let step = follower.step(planner.track(), scale, false);
        // The nearest of the next starts. Where the path turns back, the very next one is farther for a while.
        let far = |k: &usize| {
            let by = step.pose - starts[*k];
            by.dot_all(&by)
        };
        let next = near..starts.len().min(near + 64);
        near = next.min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(near);
        let good = watch.step(&step.pose.0, 0);
        let good = path.step(&step.pose.0, near) && good;
        assert!(good, "seed {seed}: {:?} {:?}", watch.report(), path.worst());
        cycles += 1;
        pose = step.pose;
    }
    let by = pose - end;
    assert!(by.dot_all(&by) < 1e-18, "seed {seed} ends elsewhere");
    let r = watch.report();
    (cycles, [r.velocity.ratio, r.acceleration.ratio, r.jerk.ratio, path.worst().ratio])
}

/// Weights that make a circle of this radius around (-radius, 0).
fn circle(radius: f64) -> Data {
    let w = 0.5_f64.sqrt();
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points = corners.iter().enumerate().map(|(k, (x, y))| {
        let pose = [radius * f64::from(*x) - radius, radius * f64::from(*y), 0.0];
        (Pose::from_xyz(pose), if k % 2 == 0 { 1.0 } else { w })
    });
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    Data { degree: 2, knots, points: points.collect() }
}

/// A NURBS circle stays on the true circle, at the speed that it allows.
#[test]
fn a_nurbs_circle_is_a_circle() {
    for (radius, tolerance) in [(4.0, 0.1), (4.0, 0.0), (30.0, 0.01)] {
        for jerk in [f64::INFINITY, 1e5] {
            let data = circle(radius);
            let shape = WatchShape::Arc {
                from: [0.0; AXES],
                to: [0.0; AXES],
                center: [-radius, 0.0, 0.0],
                normal: [0.0, 0.0, 1.0],
                angle: core::f64::consts::TAU,
            };
            let machine = machine(jerk);
            let mode = Mode::Blend(tolerance);
            let linear = if tolerance > 0.0 { tolerance } else { machine.exact_tolerance };
            let judge = (shape, Tolerance { linear, angular: 0.05 });
            let (cycles, worst) = judged(&[data.spline()], vec![judge], &machine, mode, 100.0, 0);
            let speed = (1750.0 * radius).sqrt().min(100.0);
            let least = core::f64::consts::TAU * radius / speed;
            let time = cycles as f64 * 1e-3;
            println!(
                "radius {radius} P {tolerance} J {jerk}: {time:.3} s, bound {least:.3} s, {worst:.6?}"
            );
            // Under a limit of jerk its double knots, where the second derivative jumps, are blends.
            assert!(tolerance < 0.1 || time < 1.1 * least + 0.1 || jerk < 1e6, "{time} s");
        }
    }
}

/// Judges the random splines of these seeds; returns their spans.
fn many(seeds: core::ops::Range<u64>) -> usize {
    let (mut cycles, mut worst, mut pieces) = (0, [0.0_f64; 4], 0);
    for seed in seeds {
        let data = random(seed);
        let jerk = [f64::INFINITY, 1e5, 1e4][(seed % 3) as usize];
        let tolerance = [0.1, 0.01, 1.0, 0.0][(seed / 3 % 4) as usize];
        let machine = machine(jerk);
        let (chords, off) = data.chords();
        let linear = if tolerance > 0.0 { tolerance } else { machine.exact_tolerance };
        // The chords themselves are off by a little.
        let judge = Tolerance { linear: linear + 1.1 * off, angular: 0.05 + 1.1 * off };
        let shapes: Vec<_> =
            chords.windows(2).map(|w| (WatchShape::Line { from: w[0], to: w[1] }, judge)).collect();
        pieces += data.points.len() - data.degree;
        let mode = Mode::Blend(tolerance);
        let (count, ratios) = judged(&[data.spline()], shapes, &machine, mode, 80.0, seed);
        cycles += count;
        for (w, r) in worst.iter_mut().zip(ratios) {
            *w = w.max(r);
        }
    }
    println!("{pieces} spans, {cycles} cycles, worst {worst:.9?}");
    assert!(worst[3] > 0.5, "the judge of the path sees deviations");
    pieces
}

#[test]
fn random_splines_keep_every_limit() {
    let spans = many(1..1400);
    assert!(spans >= 10_000, "{spans}");
}

/// A cubic B-spline is followed exactly: the curve of the track is the curve itself.
#[test]
fn a_cubic_b_spline_is_met_exactly() {
    let points: Vec<Pose> =
        [[0.0, 0.0], [10.0, 0.0], [20.0, 15.0], [5.0, 30.0], [0.0, 10.0], [-9.0, 2.0]]
            .map(|[x, y]| Pose([x, y, 0.5 * x, y, 0.0, 0.0, x, 0.0, 0.0]))
            .to_vec();
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0];
    let data = Data { degree: 3, knots, points: points.iter().map(|p| (*p, 1.0)).collect() };
    assert_eq!(Spline::cubic(&points).unwrap(), data.spline());
    let mut planner = Planner::new(machine(1e5), Trivial, Pose::ZERO).unwrap();
    planner.push_spline(&data.spline(), 50.0, Mode::ExactStop, 3).unwrap();
    planner.finish();
    let track = planner.track();
    let length: f64 = track.cells().map(|c| c.length).sum();
    let mut s = 0.0;
    for cell in track.cells() {
        let pose = track.curve(cell.curve).unwrap().pose(cell.from);
        let by = pose - data.at(3.0 * s / length);
        assert!(by.dot_all(&by).sqrt() < 1e-9, "{by:?} at {s}");
        s += cell.length;
    }
    // Only the end is a stop.
    assert_eq!(track.cells().filter(|c| c.stop).count(), 1);
}

#[test]
fn splines_that_cannot_be_are_refused() {
    let p = |x: f64| (Pose::from_xyz([x, 0.0, 0.0]), 1.0);
    let four = [p(0.0), p(1.0), p(2.0), p(3.0)];
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let fault = |degree, knots: &[f64], points: &[(Pose, f64)]| {
        Spline::new(degree, knots, points).unwrap_err()
    };
    assert_eq!(fault(4, &knots, &four), SplineFault::Degree);
    assert_eq!(fault(3, &knots[1..], &four), SplineFault::Count);
    assert_eq!(fault(3, &knots, &four[..3]), SplineFault::Count);
    let mut falling = knots;
    falling[7] = 0.5;
    assert_eq!(fault(3, &falling, &four), SplineFault::Knots);
    assert_eq!(fault(3, &[0.0; 8], &four), SplineFault::Knots);
    assert_eq!(fault(3, &knots.map(|k| k * f64::NAN), &four), SplineFault::Knots);
    for bad in [0.0, -1.0, f64::NAN, 1e7, f64::INFINITY] {
        let mut points = four;
        points[1].1 = bad;
        assert_eq!(fault(3, &knots, &points), SplineFault::Weight, "{bad}");
    }
    assert_eq!(fault(3, &knots, &four.map(|_| p(f64::NAN))), SplineFault::Weight);

    let mut planner = Planner::new(machine(1e5), Trivial, Pose::ZERO).unwrap();
    let refused = |planner: &mut Planner<Trivial>, points: &[(Pose, f64)]| {
        let spline = Spline::new(3, &knots, points).unwrap();
        planner.push_spline(&spline, 50.0, Mode::Exact, 9).unwrap_err()
    };
    let far = refused(&mut planner, &four.map(|q| (q.0 * 2.0 + four[1].0, 1.0)));
    assert_eq!(far.to_string(), "line 9: spline: it does not start where the move before ends");
    let none = refused(&mut planner, &four.map(|_| four[0]));
    assert_eq!(none, Error::Spline { line: 9, fault: SplineFault::Short });
    assert!(planner.track().is_empty());
}

/// Ends of lines within this distance of a curve, as G-code's curves become them.
fn lines(data: &Data, tolerance: f64) -> Vec<Pose> {
    let last = data.knots[data.points.len()];
    let at = |n: usize, of: usize| {
        let share = n as f64 / of as f64;
        if n == of { data.points[data.points.len() - 1].0 } else { data.at(share * last) }
    };
    let mut count = 8;
    loop {
        let off = |n: usize| {
            let [a, b, c] = [2 * n, 2 * n + 1, 2 * n + 2].map(|k| at(k, 2 * count));
            let (by, along) = (b - a, c - a);
            let share = by.dot_all(&along) / along.dot_all(&along);
            let off = by - along * share;
            off.dot_all(&off).sqrt()
        };
        if count >= 4096 || (0..count).all(|n| off(n) <= tolerance) {
            return (1..=count).map(|n| at(n, count)).collect();
        }
        count *= 2;
    }
}

/// Plans and follows; returns the time in seconds and the number of cells.
fn time(machine: &Machine, push: impl FnOnce(&mut Planner<Trivial>)) -> (f64, usize) {
    let mut planner = Planner::new(*machine, Trivial, Pose::ZERO).unwrap();
    push(&mut planner);
    planner.finish();
    let mut follower = Follower::new(machine.period, Pose::ZERO);
    let mut cycles = 0;
    while !follower.is_done(planner.track()) {
        let _ = follower.step(planner.track(), 1.0, false);
        cycles += 1;
    }
    (cycles as f64 * machine.period, planner.track().len())
}

/// Compares curves of G5 and G5.2 as lines, within a tenth of the tolerance and 0.1 µm at most, with the same curves as single moves. The motion
/// controller has no splines among its moves, because they take longer.
#[test]
fn curves_as_lines_take_no_longer_than_as_splines() {
    let mut table = "\n\n| jerk limit, units/s³ | tolerance, units | as lines, s | cells of the path | as splines, s | cells | slowest as lines |\n\
                     |---|---|---|---|---|---|---|\n"
        .to_owned();
    for (jerk, name) in [(f64::INFINITY, "none"), (1e5, "100000")] {
        for tolerance in [0.1, 0.01, 0.001] {
            let machine = machine(jerk);
            let (mut of_lines, mut of_splines, mut slowest) = (0.0, 0.0, 0.0_f64);
            let [mut cells, mut spline_cells] = [0; 2];
            for seed in 1..40 {
                let mut data = random(seed);
                for (point, _) in &mut data.points {
                    *point = Pose([point.0[0], point.0[1], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                }
                let (spline, more) = time(&machine, |planner| {
                    let mode = Mode::Blend(tolerance);
                    planner.push_spline(&data.spline(), 80.0, mode, 0).unwrap();
                });
                spline_cells += more;
                let ends = lines(&data, (0.1_f64 * tolerance).min(0.000_1));
                let (lines, more) = time(&machine, |planner| {
                    for end in ends {
                        let (shape, mode) = (Shape::Line { end }, Mode::Blend(0.9 * tolerance));
                        planner
                            .push(&Move { shape, feed: 80.0, rapid: false, mode, line: 0 })
                            .unwrap();
                    }
                });
                cells += more;
                of_lines += lines;
                of_splines += spline;
                slowest = slowest.max(lines / spline);
            }
            writeln!(
                table,
                "| {name} | {tolerance} | {of_lines:.2} | {cells} | {of_splines:.2} | {spline_cells} | {slowest:.2} |"
            )
            .unwrap();
            assert!(of_lines < of_splines, "{of_lines} s, {of_splines} s");
        }
    }
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../motion/README.md");
    hal_golden::check_part(
        page.as_ref(),
        "<!-- curves:begin -->",
        "<!-- curves:end -->",
        &(table + "\n"),
    );
}

/// A curve of lines takes no more time at a looser tolerance, but for what the ends of the windows of joined lines differ.
#[test]
fn looser_curves_take_no_more_time() {
    for jerk in [f64::INFINITY, 1e5] {
        let machine = machine(jerk);
        let mut sums = [0.0; 4];
        for seed in 1..40 {
            let data = random(seed);
            let mut least = f64::INFINITY;
            for (sum, tolerance) in sums.iter_mut().zip([0.001_f64, 0.01, 0.1, 1.0]) {
                let ends = lines(&data, (0.1 * tolerance).min(0.000_1));
                let (time, _) = time(&machine, |planner| {
                    for end in ends {
                        let (shape, mode) = (Shape::Line { end }, Mode::Blend(0.9 * tolerance));
                        let next = Move { shape, feed: 80.0, rapid: false, mode, line: 0 };
                        planner.push(&next).unwrap();
                    }
                });
                assert!(
                    time <= 1.05 * least,
                    "seed {seed} P {tolerance}: {time} s after {least} s"
                );
                least = least.min(time);
                *sum += time;
            }
        }
        println!("jerk {jerk}, P 0.001 to 1: {sums:.2?} s");
        let pairs = sums.windows(2).map(|w| w[1] / w[0]);
        assert!(pairs.fold(0.0, f64::max) < 1.002, "{sums:?}");
    }
}
