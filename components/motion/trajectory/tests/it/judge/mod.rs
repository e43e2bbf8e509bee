//! Runs a program through planner and follower, under the eyes of the watchman.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]
#![allow(
    unreachable_pub,
    dead_code,
    unused_imports,
    clippy::allow_attributes,
    reason = "each test uses a part"
)]

mod case;
mod robots;
pub mod times;

pub use case::{Case, case};
pub use robots::Robot;

use hal_corpus::{Mode as CorpusMode, Motion, Program, Rng, Step};
use hal_trajectory::{
    AXES, Error, Follower, JOINTS, Kinematics, Limits, Machine, Mode, Move, Planner, Pose,
    Rejection, Scales, Shape, Spline,
};
use hal_watchman::{
    Limits as WatchLimits, PathWatch, Shape as WatchShape, Spline as WatchSpline, Tolerance,
    Watchman,
};

/// Schedule of a run: seed, rapid moves, overrides, direction, feeding of moves and abort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conduct {
    /// Seed of the schedule.
    pub seed: u64,
    /// Share of the lines that are rapid moves.
    pub rapid: f64,
    /// Probability per period that the override of feeds changes, and that of rapid moves.
    pub change: f64,
    /// Probability per period that the direction changes.
    pub turn: f64,
    /// Largest number of moves per period that the planner receives; 0 gives it all of them at once.
    pub feed: u64,
    /// Probability per period that the program is aborted: the run ends at rest.
    pub abort: f64,
}

/// Overrides of 1, no rapid moves, and every move at once.
pub const PLAIN: Conduct =
    Conduct { seed: 0, rapid: 0.0, change: 0.0, turn: 0.0, feed: 0, abort: 0.0 };

/// Findings about a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Periods.
    pub cycles: u64,
    /// Periods with a violation, of whatever kind.
    pub violations: u64,
    /// Worst ratios of velocity, acceleration, jerk, and distance from the path.
    pub worst: [f64; 4],
    /// Description of the worst place.
    pub place: String,
    /// Largest number of follower events in a period.
    pub events: u32,
    /// Cells that the certificate rejected.
    pub rejected: u64,
    /// Last of them.
    pub rejection: Option<Rejection>,
    /// Largest memory of the track.
    pub memory: usize,
    /// Last pose.
    pub end: Pose,
    /// Moves that were refused.
    pub refused: usize,
    /// Reason of the last refusal.
    pub refusal: Option<Error>,
    /// Moves that the motion has reached.
    pub reached: usize,
    /// Splines among them.
    pub splines: usize,
    /// Runs that still moved when their time was over.
    pub unfinished: usize,
}

/// A step of a program as the planner takes it.
#[derive(Clone, Debug)]
pub enum PlannerStep {
    /// A line or an arc.
    Move(Move),
    /// A spline, with feed, mode and line.
    Spline(Spline, f64, Mode, u32),
}

impl PlannerStep {
    /// Gives the step to a planner.
    pub fn push<K: Kinematics>(&self, planner: &mut Planner<K>) -> Result<(), Error> {
        match self {
            Self::Move(m) => planner.push(m),
            Self::Spline(spline, feed, mode, line) => {
                planner.push_spline(spline, *feed, *mode, *line)
            }
        }
    }
}

/// Converts a program to steps of the planner and to shapes for the path judge.
pub fn convert(
    program: &Program,
    machine: &Machine,
) -> (Vec<PlannerStep>, Vec<(WatchShape, Tolerance)>) {
    let poses = program.poses();
    let mut moves = Vec::new();
    let mut shapes = Vec::new();
    for (k, step) in program.steps.iter().enumerate() {
        let (from, to) = (poses[k], poses[k + 1]);
        moves.push(convert_step(step, &from, &to, u32::try_from(k).unwrap()));
        let linear = match step.mode {
            CorpusMode::Blend(p) if p >= 1e-6 => p,
            _ => machine.exact_tolerance,
        };
        let tolerance = Tolerance { linear, angular: machine.angular_tolerance };
        let shape = match &step.motion {
            Motion::Line { .. } => WatchShape::Line { from, to },
            Motion::Arc { center, normal, angle, .. } => {
                let center = [from[0] + center[0], from[1] + center[1], from[2] + center[2]];
                WatchShape::Arc { from, to, center, normal: *normal, angle: *angle }
            }
            Motion::Spline(s) => WatchShape::Spline(Box::new(
                WatchSpline::new(s.degree, &s.knots, &s.placed(&from)).unwrap(),
            )),
        };
        shapes.push((shape, tolerance));
    }
    (moves, shapes)
}

fn convert_step(step: &Step, from: &[f64; AXES], to: &[f64; AXES], line: u32) -> PlannerStep {
    let mode = match step.mode {
        CorpusMode::ExactStop => Mode::ExactStop,
        CorpusMode::Exact => Mode::Exact,
        CorpusMode::Blend(p) => Mode::Blend(p),
    };
    let end = Pose(*to);
    let shape = match &step.motion {
        Motion::Line { .. } => Shape::Line { end },
        Motion::Arc { center: c, normal: n, angle, .. } => {
            let turns = ((angle.abs() - 1e-6) / core::f64::consts::TAU).floor().max(0.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            let turns = turns as u32;
            let s = angle.signum();
            Shape::Arc {
                end,
                center: [from[0] + c[0], from[1] + c[1], from[2] + c[2]],
                normal: [n[0] * s, n[1] * s, n[2] * s],
                turns,
            }
        }
        Motion::Spline(s) => {
            let points: Vec<_> = s.placed(from).into_iter().map(|(p, w)| (Pose(p), w)).collect();
            let spline = Spline::new(s.degree, &s.knots, &points).unwrap();
            return PlannerStep::Spline(spline, step.feed, mode, line);
        }
    };
    PlannerStep::Move(Move { shape, feed: step.feed, rapid: false, mode, line })
}

/// Makes a share of the lines rapid moves.
fn make_rapid(moves: &mut [PlannerStep], share: f64, mut rng: Rng) {
    for step in moves {
        if let PlannerStep::Move(m) = step
            && matches!(m.shape, Shape::Line { .. })
            && rng.chance(share)
        {
            (m.rapid, m.feed) = (true, f64::INFINITY);
        }
    }
}

/// Returns a random override.
fn any_scale(rng: &mut Rng) -> f64 {
    let scale = rng.pick(&[0.0, 0.1, 0.5, 1.0, 1.0, 1.5, -1.0], 1.0);
    if scale < 0.0 { rng.unit() } else { scale }
}

/// Runs a program and judges it.
pub fn run<K: Kinematics + Clone>(
    program: &Program,
    machine: &Machine,
    kinematics: &K,
    conduct: &Conduct,
) -> Outcome {
    let (mut moves, shapes) = convert(program, machine);
    if conduct.rapid > 0.0 {
        make_rapid(&mut moves, conduct.rapid, Rng::new(conduct.seed ^ 0x9A71D));
    }
    let start = Pose(program.start);
    let size = program.size();
    let mut rng = Rng::new(conduct.seed);
    let mut planner = Planner::new(*machine, kinematics.clone(), start).unwrap();
    let mut follower = Follower::new(machine.period, start);
    let watch_limits = |l: &Limits| WatchLimits {
        velocity: l.velocity,
        acceleration: l.acceleration,
        jerk: l.jerk,
    };
    let mut axes =
        Watchman::<AXES>::new(machine.axes.map(|l| watch_limits(&l)), machine.period, size);
    axes.rest_at(&start.0);
    let mut joints =
        Watchman::<JOINTS>::new(machine.joints.map(|l| watch_limits(&l)), machine.period, size);
    joints.rest_at(&kinematics.inverse(&start).unwrap());
    let limited = machine.joints.iter().any(|l| *l != Limits::NONE);
    let mut path = PathWatch::new(shapes.into_boxed_slice(), size, 12);
    let mut out = Outcome::default();
    let (mut given, mut finished, mut scales, mut reverse) = (0, false, Scales::FULL, false);
    let (mut flat_cycles, mut stuck, mut aborted) = (0, false, false);
    let most: u64 = 1_000_000;
    // Random changes end after a while, so that every program ends.
    let quiet = 30_000;
    while out.cycles < most {
        let mut room = if conduct.feed == 0 { u64::MAX } else { rng.below(conduct.feed + 1) };
        while given < moves.len() && room > 0 {
            match moves[given].push(&mut planner) {
                Ok(()) => {}
                Err(Error::Full) => break,
                Err(e) => {
                    out.refusal = Some(e);
                    // The rest of the program would start at another place.
                    out.refused += 1;
                    given = moves.len();
                    break;
                }
            }
            given += 1;
            room -= 1;
        }
        if given == moves.len() && !finished {
            planner.finish();
            finished = true;
        }
        if out.cycles > quiet {
            (scales, reverse) = (Scales::FULL, false);
        } else if conduct.change > 0.0 {
            if rng.chance(conduct.change) {
                scales.feed = any_scale(&mut rng);
            }
            if conduct.rapid > 0.0 && rng.chance(conduct.change) {
                scales.rapid = any_scale(&mut rng);
            }
        }
        let turns = if reverse { 5.0 * conduct.turn } else { conduct.turn };
        if out.cycles <= quiet && turns > 0.0 && rng.chance(turns) {
            reverse = !reverse;
        }
        // A hold or a reverse motion to the oldest cell ends after a while.
        let waits = usize::from(planner.track().cell(follower.oldest()).map_or(1, |c| c.samples));
        if flat_cycles > waits + 50 {
            (scales, reverse) = (Scales::FULL, false);
        }
        aborted |= out.cycles <= quiet && conduct.abort > 0.0 && rng.chance(conduct.abort);
        if aborted {
            (scales, reverse) = (Scales::HOLD, false);
        }
        let step = follower.step(planner.track(), scales, reverse);
        flat_cycles = if step.moving { 0 } else { flat_cycles + 1 };
        let good_axes = axes.step(&step.pose.0, step.line);
        let good_joints = !limited || {
            let at = kinematics.inverse(&step.pose).unwrap_or([f64::NAN; JOINTS]);
            joints.step(&at, step.line)
        };
        let good_path = path.step(&step.pose.0, usize::try_from(step.line).unwrap());
        if !(good_axes && good_joints && good_path) {
            out.violations += 1;
        }
        out.cycles += 1;
        if out.cycles % 64 == 0 {
            out.memory = out.memory.max(planner.track().memory());
            if !reverse {
                planner.forget(follower.oldest().saturating_sub(200));
            }
        }
        out.end = step.pose;
        out.reached = out.reached.max(usize::try_from(step.line).unwrap() + 1);
        if finished && !reverse && follower.is_done(planner.track()) || aborted && !step.moving {
            break;
        }
        // A motion that never starts again hangs; a slow one does not.
        if finished && flat_cycles > 10_000 {
            stuck = true;
            break;
        }
    }
    out.unfinished = usize::from(out.cycles >= most);
    let (a, j) = (axes.report(), joints.report());
    out.worst = [
        a.velocity.ratio.max(j.velocity.ratio),
        a.acceleration.ratio.max(j.acceleration.ratio),
        a.jerk.ratio.max(j.jerk.ratio),
        path.worst().ratio,
    ];
    if out.violations > 0 {
        out.place = format!("axes {a:?}\n joints {j:?}\n path {:?}", path.worst());
    }
    if stuck {
        out.place.push_str(&format!(
            " rests before the end {}",
            format!("{follower:?}").chars().take(300).collect::<String>()
        ));
        out.violations += 1;
    }
    out.events = follower.events();
    let spline = |s: &&Step| matches!(s.motion, Motion::Spline(_));
    out.splines = program.steps.iter().take(out.reached).filter(spline).count();
    (out.rejected, out.rejection) = planner.rejections();
    out
}
