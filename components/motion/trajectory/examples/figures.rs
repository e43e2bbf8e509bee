//! Figures of the planner and the follower on this machine: moves per second, time of a step, memory.
//!
//! `cargo run -p hal-trajectory --release --example figures`
#![expect(clippy::print_stdout, clippy::disallowed_methods, reason = "it measures and prints")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::allow_attributes,
    reason = "figures"
)]

use hal_corpus::Rng;
use hal_trajectory::{
    AXES, Error, Follower, JOINTS, Jet, Joints, Kinematics, Limits, Machine, Mode, Move, Path,
    Planner, Pose, Shape, Trivial, share,
};
use std::time::Instant;

fn main() -> Result<(), Error> {
    println!("nine axes, tiny lines:  {:>8.0} moves/s", rate(&tiny(100_000, 9), Trivial)?);
    println!("arcs and helices:       {:>8.0} moves/s", rate(&arcs(50_000), Trivial)?);
    println!("delta, tiny lines:      {:>8.0} moves/s", rate(&tiny(30_000, 3), Delta)?);
    println!("delta, lines of 10:     {:>8.0} moves/s", rate(&long(5_000), Delta)?);
    for depth in [200, 1000, 10_000] {
        let (mean, rare) = follower(depth)?;
        println!("step at a depth of {depth:>5}: {mean:>5.0} ns mean, {rare:>5.0} ns at 99.9 %");
    }
    println!("a million moves:        {:>8.1} MB at most", memory()? as f64 / 1e6);
    Ok(())
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
            Move { shape, feed: 150.0, mode: Mode::Blend(0.01), line }
        })
        .collect()
}

fn long(count: u32) -> Vec<Move> {
    let mut rng = Rng::new(2);
    (0..count)
        .map(|line| {
            let end = [0.0; 3].map(|_: f64| rng.between(-10.0, 10.0));
            let shape = Shape::Line { end: Pose::from_xyz(end) };
            Move { shape, feed: 150.0, mode: Mode::Blend(0.1), line }
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
            Move { shape, feed: 150.0, mode: Mode::Blend(0.1), line }
        })
        .collect()
}

/// Moves per second, with the certificate and the hand-over.
fn rate<K: Kinematics>(moves: &[Move], kinematics: K) -> Result<f64, Error> {
    let mut planner = Planner::new(machine(), kinematics, Pose::ZERO)?;
    let (mut publisher, reader) = share(16384, 1000);
    let begin = Instant::now();
    for m in moves {
        planner.push(m)?;
        publisher.publish(&mut planner);
        // A follower that has passed everything but the last thousands of cells.
        reader.release(planner.track().oldest().saturating_sub(4000));
    }
    let seconds = begin.elapsed().as_secs_f64();
    assert_eq!(planner.rejections().0, 0);
    Ok(moves.len() as f64 / seconds)
}

/// Mean and rare time of a step in nanoseconds, with so many moves ahead.
fn follower(depth: usize) -> Result<(f64, f64), Error> {
    let moves = tiny(100_000, 9);
    let mut moves = moves.iter();
    let mut planner = Planner::new(machine(), Trivial, Pose::ZERO)?;
    let (mut publisher, reader) = share(16384, 100);
    let mut follower = Follower::new(1e-3, Pose::ZERO);
    let mut times = Vec::new();
    let mut line = 0;
    for cycle in 0..60_000_u32 {
        while line as usize + depth > given(&moves) {
            let Some(m) = moves.as_slice().first() else { break };
            match planner.push(m) {
                Ok(()) => moves.next(),
                Err(Error::Full) => break,
                Err(error) => return Err(error),
            };
        }
        publisher.publish(&mut planner);
        let scale = f64::from(cycle / 200 % 4) / 3.0;
        let begin = Instant::now();
        let step = follower.step(&reader, scale, false);
        times.push(begin.elapsed().as_nanos() as u64);
        line = step.line;
    }
    times.sort_unstable();
    let mean = times.iter().sum::<u64>() as f64 / times.len() as f64;
    Ok((mean, times.get(times.len() * 999 / 1000).map_or(0.0, |t| *t as f64)))
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
