//! Random machines, programs and conducts.

use super::{Conduct, robots::Robot};
use hal_corpus::{Kind, Mode as CorpusMode, Options, Program, Rng, random};
use hal_trajectory::{JOINTS, Limits, Machine};

/// A random case.
pub struct Case {
    /// Machine.
    pub machine: Machine,
    /// Program.
    pub program: Program,
    /// Way in which it is run.
    pub conduct: Conduct,
    /// Kinematics.
    pub robot: Robot,
}

/// Returns the case of a seed; programs have about `count` moves.
pub fn case(seed: u64, count: usize) -> Case {
    let mut rng = Rng::new(seed ^ 0x5EED);
    let jerk = rng.pick(&[f64::INFINITY, 1e6, 1e5, 1e5, 1e4, 1e4], 1e5);
    let base = Limits { velocity: 200.0, acceleration: 1750.0, jerk };
    let mut machine = Machine::uniform(base);
    for limits in &mut machine.axes {
        if rng.chance(0.3) {
            limits.velocity *= rng.log(0.2, 2.0);
            limits.acceleration *= rng.log(0.3, 2.0);
            limits.jerk *= rng.log(0.5, 2.0);
        }
    }
    machine.max_override = rng.pick(&[1.0, 1.2, 1.5], 1.0);
    // Every eighth program has splines.
    let kind =
        if seed % 8 == 7 { Kind::Splines } else { Kind::ALL[usize::try_from(seed % 7).unwrap()] };
    let mode = rng.pick(
        &[
            CorpusMode::ExactStop,
            CorpusMode::Exact,
            CorpusMode::Blend(0.0),
            CorpusMode::Blend(0.01),
            CorpusMode::Blend(0.1),
            CorpusMode::Blend(2.0),
            CorpusMode::Blend(1e3),
        ],
        CorpusMode::Exact,
    );
    let feed = rng.pick(&[1.0, 20.0, 60.0, 150.0, 500.0, 5000.0], 60.0);
    let mut axes = 1 + usize::try_from(rng.below(9)).unwrap();
    let stops = if rng.chance(0.5) { 0.02 } else { 0.0 };
    let conduct = Conduct {
        seed,
        // Every third program has rapid moves, so that the others are as they were.
        rapid: if seed % 3 == 1 { 0.4 } else { 0.0 },
        change: rng.pick(&[0.0, 0.003, 0.01, 0.1], 0.0),
        turn: rng.pick(&[0.0, 0.0, 0.002], 0.0),
        feed: rng.pick(&[0, 1, 8], 0),
        abort: rng.pick(&[0.0, 0.0, 0.0, 0.0, 0.0, 1e-3], 0.0),
    };
    // Every kind of programs on every robot in turn.
    let robot = Robot::ALL[usize::try_from(seed / 7 % 11).unwrap()];
    if let Some(most) = robot.axes() {
        axes = axes.min(most);
        for (k, limits) in machine.joints.iter_mut().take(JOINTS).enumerate() {
            let turns = robot.turns(k);
            let by = if turns { 1.0 } else { 1.5 } * rng.log(0.5, 1.0);
            *limits = Limits { velocity: 200.0 * by, acceleration: 1750.0 * by, jerk: jerk * by };
        }
    }
    // A crawl takes long: shorter programs.
    let count = if feed < 5.0 { count / 20 } else { count };
    let area = if robot.axes().is_some() { 40.0 } else { 300.0 };
    let options = Options { count, axes, mode, feed, stops, area };
    Case { machine, program: random(kind, seed, &options), conduct, robot }
}
