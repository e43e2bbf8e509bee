//! The figures that the README states: times against bounds, rates of planning, time of a step, memory. Rates and steps
//! are in processor time, measured in turns, so that other programs on the machine change little.
//!
//! `cargo run -p hal-trajectory --release --example figures`
#![expect(clippy::print_stdout, clippy::disallowed_methods, reason = "it measures and prints")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::allow_attributes,
    reason = "figures"
)]

#[path = "../tests/it/judge/mod.rs"]
mod judge;

use hal_corpus::Rng;
use hal_trajectory::{
    AXES, Error, Follower, JOINTS, Jet, Joints, Kinematics, Limits, Machine, Mode, Move, Path,
    Planner, Pose, Shape, Trivial, share,
};
use judge::times;
use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;

/// Turns in which the rates are measured; each line prints the median and the best.
const TURNS: usize = 5;

fn main() -> Result<(), Error> {
    let sets: [(&str, f64, Vec<Move>, bool); 4] = [
        ("nine axes, tiny lines", 2e5, tiny(60_000, 9), false),
        ("arcs and helices", 1e5, arcs(30_000), false),
        ("delta, tiny lines", 3e4, tiny(15_000, 3), true),
        ("delta, lines of 10 (no figure is wanted)", 0.0, long(2_000), true),
    ];
    if let Some(number) = std::env::args().nth(1).and_then(|n| n.parse::<usize>().ok()) {
        // One set, once and without a clock, for a program that counts instructions.
        return match sets.get(number) {
            Some((_, _, moves, true)) => plan(moves, Delta),
            Some((_, _, moves, false)) => plan(moves, Trivial),
            None => Ok(()),
        };
    }
    print_times();
    println!(
        "\nrates of planning, in moves per second of processor time:   wanted   median     best"
    );
    let mut rates = sets.each_ref().map(|_| Vec::new());
    for _ in 0..TURNS {
        for ((_, _, moves, delta), rates) in sets.iter().zip(&mut rates) {
            rates.push(if *delta { rate(moves, Delta)? } else { rate(moves, Trivial)? });
        }
    }
    for ((name, wanted, ..), rates) in sets.iter().zip(&mut rates) {
        let (median, best) = middle(rates);
        let met = if *wanted > 0.0 { least(median, *wanted) } else { "" };
        println!("  {name:<56}  {wanted:>8.0} {median:>8.0} {best:>8.0} {met}");
    }
    println!(
        "\na step of nine axes in ns (wanted: 250 mean, 1000 at 99.9 %):  mean    99.9 %   events"
    );
    for depth in [200, 1000, 10_000] {
        let mut means = Vec::new();
        let mut rare = Vec::new();
        let mut events = 0;
        for _ in 0..TURNS {
            let found = follower(depth)?;
            means.push(-found.0);
            rare.push(-found.1);
            events = found.2;
        }
        // The best of the turns is the one that other programs disturbed least.
        let [mean, rare] = [middle(&mut means), middle(&mut rare)].map(|(_, best)| -best);
        let (a, b) = (most(mean, 250.0), most(rare, 1000.0));
        println!("  at a depth of {depth:>6} moves  {mean:>38.0} {rare:>9.0} {events:>8} {a}, {b}");
    }
    let megabytes = memory()? as f64 / 1e6;
    println!(
        "\na million moves take {megabytes:.1} MB at most (wanted: 16) {}",
        most(megabytes, 16.0)
    );
    println!("\nshown by tests, each with cargo test -p hal-trajectory --release --test it:");
    for (what, test) in [
        ("a million segments", "limits -- --ignored --nocapture"),
        ("a hold from any state", "invariants::a_hold_stops_in_time"),
        ("a planner that stops for 5 s", "share::a_planner_that_stops"),
        ("holds and reverse motion", "invariants::holds_and_reversals"),
        ("no allocation in a step", "and --test realtime"),
        ("known mistakes are seen", "mutants -- --ignored --nocapture"),
    ] {
        println!("  {what:<30} {test}");
    }
    Ok(())
}

/// Times against the bounds of the same path without a limit of jerk.
fn print_times() {
    println!("times, in parts of the bound without a limit of jerk (wanted):");
    let bound = times::small_arcs_bound();
    for (name, both) in [("one sense", false), ("both senses", true)] {
        for p in [0.1, 0.01, 0.0] {
            let program = times::small_arcs(both, p);
            let [t, j] = [f64::INFINITY, 1e5]
                .map(|jerk| times::taken(&program, &times::machine(jerk)) / bound);
            println!(
                "  arcs of radius 4, {name}, tolerance {p}: {t:.3} (1.02) {}, jerk 1e5 {j:.3} (1.12) {}",
                most(t, 1.02),
                most(j, 1.12)
            );
        }
    }
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    for (kind, p) in times::random_cases() {
        let [bound, rest @ ..] = times::random_times(kind, p);
        for (s, x) in sums.iter_mut().zip(rest) {
            *s += x / bound;
        }
        count += 1.0;
    }
    let [t, j5, j4] = sums.map(|s| s / count);
    println!(
        "  random programs: {t:.3} (1.03) {}, jerk 1e5 {j5:.3} (1.08) {}, jerk 1e4 {j4:.3} (1.40) {}",
        most(t, 1.03),
        most(j5, 1.08),
        most(j4, 1.40)
    );
    let long = times::long_lines();
    let bound = times::bound(&long, &times::machine(f64::INFINITY));
    let [t, j] =
        [f64::INFINITY, 1e5].map(|jerk| times::taken(&long, &times::machine(jerk)) / bound);
    println!(
        "  lines of more than a second: {t:.4} (1.005) {}, jerk 1e5 {j:.3} (1.05) {}",
        most(t, 1.005),
        most(j, 1.05)
    );
    let machine = times::machine(1e5);
    let [circle, noisy] = times::dense_circles();
    let [a, b] = [&circle, &noisy].map(|p| times::taken(p, &machine));
    println!(
        "  circle of radius 10 in lines of 0.1: {a:.3} s (0.70) {}, with noise {:.3} times (1.35) {}",
        most(a, 0.70),
        b / a,
        most(b / a, 1.35)
    );
    let [one, many] = [1, 1000].map(|pieces| times::taken(&times::line_in(pieces), &machine));
    println!("  a line of 108 in one piece {one:.3} s, in a thousand {many:.3} s");
}

/// Judges a figure that is to be so high at most, to the digits that are printed.
fn most(found: f64, wanted: f64) -> &'static str {
    if found <= wanted * 1.0005 { "met" } else { "NOT MET" }
}

/// Judges a figure that is to be so high at least.
fn least(found: f64, wanted: f64) -> &'static str {
    if found >= wanted { "met" } else { "NOT MET" }
}

/// Processor time of this thread, in seconds.
fn processor() -> f64 {
    let t = clock_gettime(ClockId::ThreadCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

/// Median and largest.
fn middle(values: &mut [f64]) -> (f64, f64) {
    values.sort_unstable_by(f64::total_cmp);
    let at = |k: usize| values.get(k).copied().unwrap_or(f64::NAN);
    (at(values.len() / 2), at(values.len() - 1))
}

fn machine() -> Machine {
    Machine::uniform(Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 })
}

fn tiny(count: u32, axes: usize) -> Vec<Move> {
    let mut rng = Rng::new(1);
    let mut pose = Pose::ZERO;
    let mut heading = 0.0_f64;
    (0..count)
        .map(|line| {
            heading += rng.between(-0.12, 0.12) - 0.002 * pose.0[0] * heading.cos().signum();
            let (sin, cos) = libm::sincos(heading);
            for (k, x) in pose.0.iter_mut().take(axes).enumerate() {
                *x += match k {
                    0 => 0.15 * cos - 5e-3 * *x,
                    1 => 0.15 * sin - 5e-3 * *x,
                    _ => rng.between(-0.01, 0.01) - 5e-3 * *x,
                };
            }
            let shape = Shape::Line { end: pose };
            Move { shape, feed: 150.0, rapid: false, mode: Mode::Blend(0.01), line }
        })
        .collect()
}

fn long(count: u32) -> Vec<Move> {
    let mut rng = Rng::new(2);
    (0..count)
        .map(|line| {
            let end = [0.0; 3].map(|_: f64| rng.between(-10.0, 10.0));
            let shape = Shape::Line { end: Pose::from_xyz(end) };
            Move { shape, feed: 150.0, rapid: false, mode: Mode::Blend(0.1), line }
        })
        .collect()
}

fn arcs(count: u32) -> Vec<Move> {
    let mut at = [0.0_f64; 3];
    (0..count)
        .map(|line| {
            let heading = 0.9 * f64::from(line);
            let (sin, cos) = libm::sincos(heading);
            let center = [at[0] - 4.0 * sin, at[1] + 4.0 * cos, at[2]];
            let (s, c) = libm::sincos(heading + 0.9);
            let rise = if line % 4 == 0 { 0.5 } else { 0.0 };
            at = [center[0] + 4.0 * s, center[1] - 4.0 * c, at[2] + rise - 0.125];
            let normal = [0.0, 0.0, 1.0];
            let shape = Shape::Arc { end: Pose::from_xyz(at), center, normal, turns: 0 };
            Move { shape, feed: 150.0, rapid: false, mode: Mode::Blend(0.1), line }
        })
        .collect()
}

/// Moves per second, with the certificate and the hand-over.
fn rate<K: Kinematics>(moves: &[Move], kinematics: K) -> Result<f64, Error> {
    let begin = processor();
    plan(moves, kinematics)?;
    Ok(moves.len() as f64 / (processor() - begin))
}

#[inline(never)]
fn plan<K: Kinematics>(moves: &[Move], kinematics: K) -> Result<(), Error> {
    let mut planner = Planner::new(machine(), kinematics, Pose::ZERO)?;
    let (mut publisher, reader) = share(16384, 1000);
    for m in moves {
        planner.push(m)?;
        publisher.publish(&mut planner);
        // A follower that has passed everything but the last thousands of cells.
        reader.release(planner.track().oldest().saturating_sub(4000));
    }
    assert_eq!(planner.rejections().0, 0);
    Ok(())
}

/// Mean and rare time of a step in nanoseconds, with so many moves ahead, and the most events of a step. The planner works
/// in between, once in a hundred steps.
fn follower(depth: usize) -> Result<(f64, f64, u32), Error> {
    let moves = tiny(100_000, 9);
    let mut moves = moves.iter();
    let mut planner = Planner::new(machine(), Trivial, Pose::ZERO)?;
    let (mut publisher, reader) = share(16384, 100);
    let mut follower = Follower::new(1e-3, Pose::ZERO);
    let (mut times, mut sum) = (Vec::new(), 0.0);
    let mut line = 0;
    for block in 0..400_u32 {
        while line as usize + depth > given(&moves) {
            let Some(m) = moves.as_slice().first() else { break };
            match planner.push(m) {
                Ok(()) => moves.next(),
                Err(Error::Full) => break,
                Err(error) => return Err(error),
            };
        }
        publisher.publish(&mut planner);
        // The mean without clocks in between, the rare ones with them, in turn.
        let scale = f64::from(block / 2 % 4) / 3.0;
        if block % 2 == 0 {
            let begin = processor();
            for _ in 0..100 {
                line = follower.step(&reader, scale, false).line;
            }
            sum += processor() - begin;
            continue;
        }
        for _ in 0..100 {
            let begin = Instant::now();
            line = follower.step(&reader, scale, false).line;
            times.push(begin.elapsed().as_nanos() as u64);
        }
    }
    times.sort_unstable();
    let rare = times.get(times.len() * 999 / 1000).map_or(0.0, |t| *t as f64);
    Ok((1e9 * sum / 20_000.0, rare, follower.events()))
}

/// Number of moves that were taken.
fn given(moves: &core::slice::Iter<'_, Move>) -> usize {
    100_000 - moves.len()
}

/// Largest memory of planner, hand-over and follower for a program of a million moves.
fn memory() -> Result<usize, Error> {
    let mut planner = Planner::new(machine(), Trivial, Pose::ZERO)?;
    let (mut publisher, reader) = share(16_384, 2000);
    let mut most = 0;
    for _ in 0..10 {
        let at = *planner.position();
        for m in &tiny(100_000, 9) {
            let Shape::Line { end } = m.shape else { continue };
            planner.push(&Move { shape: Shape::Line { end: end + at }, ..*m })?;
            publisher.publish(&mut planner);
            reader.release(planner.track().oldest().saturating_sub(4000));
            most = most.max(publisher.memory() + planner.memory());
        }
    }
    Ok(most + 2000 * 8)
}

/// Linear delta: three towers at radius 120 with rods of 250.
#[derive(Clone, Copy, Debug)]
struct Delta;

const TOWERS: [(f64, f64); 3] = [(0.0, 120.0), (-103.923, -60.0), (103.923, -60.0)];

impl Kinematics for Delta {
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize> {
        let mut joints = [0.0; JOINTS];
        for (joint, (x, y)) in joints.iter_mut().zip(TOWERS) {
            let (dx, dy) = (pose.0[0] - x, pose.0[1] - y);
            *joint = pose.0[2] + (62_500.0 - dx * dx - dy * dy).max(0.0).sqrt();
        }
        Ok(joints)
    }

    fn derivatives(&self, pose: &[Jet; AXES]) -> Option<Result<[Jet; JOINTS], usize>> {
        let mut joints = [Jet::default(); JOINTS];
        for (k, (joint, (x, y))) in joints.iter_mut().zip(TOWERS).enumerate() {
            let (dx, dy) = (pose[0] - Jet::constant(x), pose[1] - Jet::constant(y));
            let rest = Jet::constant(62_500.0) - dx * dx - dy * dy;
            if rest.0[0] <= 1.0 {
                return Some(Err(k));
            }
            *joint = pose[2] + rest.sqrt();
        }
        Some(Ok(joints))
    }
}
