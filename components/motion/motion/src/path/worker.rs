//! The planner: a worker that turns moves into a path that keeps every limit, and publishes it to the realtime side.

use crate::{
    commands::refusal::Refusal,
    path::{
        image::Image,
        order::{HandOver, Kind, Order, PathMove, PathSetup, Report, Rider, Session, Way},
        pace, reach,
        sweep::Sweep,
        tap,
    },
};
use hal_component::{KinematicsRef, SeqReader, Takes, Touch, Work};
use hal_trajectory::{
    AXES, Error, Follower, Kinematics, Limits, Machine, Move, Planner, Pose, Publisher, Pursuer,
    share,
};

/// Period of the planner in machine time, in nanoseconds.
pub(crate) const PERIOD_NS: i64 = 2_000_000;

/// Largest number of moves in a step.
pub(crate) const ITEMS: u32 = 64;

/// Cells of a path in the memory that both sides share, and how many of them are kept for reverse motion.
const CELLS: usize = 4096;
const HISTORY: usize = 1024;

/// Number of cells planned ahead of what fits into the shared memory.
const AHEAD: usize = 512;

/// Number of steps without a new move after which the path may end for now.
const IDLE: u32 = 3;

/// Time that is left before the motion must brake when the path ends for now, in seconds, and how much of it is looked for.
const RESERVE: f64 = 0.05;
const ENOUGH: f64 = 1.0;

/// Angular tolerance of a path, in degrees.
const ANGULAR: f64 = 0.05;

/// State of the planner.
#[derive(Debug, Touch)]
pub(crate) struct PlannerWorker {
    hand: Takes<HandOver>,
    setup: SeqReader<PathSetup>,
    kinematics: KinematicsRef,
    #[state]
    held: Option<Order>,
    #[state]
    job: Option<Job>,
}

/// The path in progress.
#[derive(Debug)]
struct Job {
    setup: PathSetup,
    planning: Result<Planning, Refusal>,
    /// True after a refusal: moves are skipped.
    skips: bool,
    /// Number of the last move that was planned.
    last: u32,
    /// True while the path has moves whose end is not published.
    open: bool,
    /// Steps without a new move.
    idle: u32,
    /// Time that is left before the motion must brake when the path ends for now, in seconds.
    reserve: f64,
}

#[derive(Debug)]
struct Planning {
    planner: Planner<Image>,
    publisher: Publisher,
    /// The kinematics for the check of limits.
    image: Image,
}

impl PlannerWorker {
    pub(crate) const fn new(
        hand: Takes<HandOver>,
        setup: SeqReader<PathSetup>,
        kinematics: KinematicsRef,
    ) -> Self {
        Self { hand, setup, kinematics, held: None, job: None }
    }
}

impl Work for PlannerWorker {
    fn work(&mut self, items: u32) -> u32 {
        let mut done = 0;
        while done < items {
            let Some(order) = self.held.take().or_else(|| self.hand.orders.pop()) else { break };
            if !self.take(&order) {
                self.held = Some(order);
                break;
            }
            done += 1;
        }
        if let Some(job) = &mut self.job {
            job.publish(&self.hand, done > 0 || self.held.is_some());
        }
        self.free_paths();
        done
    }
}

impl PlannerWorker {
    /// Takes an order; returns false if there is no room for it yet.
    fn take(&mut self, order: &Order) -> bool {
        let latest = self.hand.latest();
        match *order {
            Order::Begin { generation } if generation == latest => {
                if self.hand.made.is_full() {
                    return false;
                }
                self.free_paths();
                self.begin(generation);
            }
            Order::Finish { generation } => {
                if let Some(job) = self.job.as_mut().filter(|j| j.setup.generation == generation) {
                    job.finish();
                }
            }
            Order::Resume { generation } => {
                if let Some(job) = self.job.as_mut().filter(|j| j.setup.generation == generation) {
                    job.skips = false;
                }
            }
            Order::Move { generation, id, order: step } if generation == latest => {
                if step.is_tap() {
                    return self.begin_tap(generation, id, &step);
                }
                let hand = &self.hand;
                let job = self.job.as_mut().filter(|j| j.setup.generation == generation);
                if let Some(job) = job
                    && !job.take(hand, id, &step)
                {
                    return false;
                }
            }
            Order::Begin { .. } | Order::Move { .. } => {}
        }
        true
    }

    /// Frees the paths that the realtime side has returned.
    fn free_paths(&self) {
        while let Some(session) = self.hand.old.pop() {
            drop(session);
        }
    }

    fn begin(&mut self, generation: u32) {
        let setup = self.setup.get();
        if setup.generation != generation {
            return;
        }
        let start = Pose(setup.start);
        let image = Image::new(self.kinematics, &setup.places);
        if setup.overrun > 0.0 {
            // The path of a tap comes with its move.
            let planning = Err(Refusal::new("a tap has a path of its own"));
            self.job = Some(Job::new(&setup, planning));
            return;
        }
        let planning = Planner::new(machine(&setup), image.clone(), start).map_err(refusal);
        let planning = planning.map(|mut planner| {
            planner.limit_jerk(setup.path_jerk);
            let (publisher, reader) = share(CELLS, HISTORY);
            let rider = match setup.is_bound {
                true => Rider::Pursuer(pursuer(&setup, &image, start)),
                false => Rider::Follower(Follower::new(setup.period, start)),
            };
            let way = Way::Shared(reader);
            let session = Box::new(Session { generation, rider, way });
            // The caller has made sure that there is room.
            drop(self.hand.made.push(session));
            Planning { planner, publisher, image }
        });
        self.job = Some(Job::new(&setup, planning));
    }

    /// Plans a tap as a whole; returns false if there is no room for it yet.
    fn begin_tap(&mut self, generation: u32, id: u32, step: &PathMove) -> bool {
        let job = self.job.as_mut().filter(|j| j.setup.generation == generation);
        let Some(job) = job else { return true };
        if self.hand.made.is_full() || self.hand.reports.is_full() {
            return false;
        }
        let image = Image::new(self.kinematics, &job.setup.places);
        // The caller has made sure that there is room.
        match tap::plan(&job.setup, image, id, step) {
            Ok(session) => drop(self.hand.made.push(Box::new(session))),
            Err(why) => {
                let report = Report { generation: job.setup.generation, id, why };
                job.skips = self.hand.reports.push(report).is_ok();
            }
        }
        true
    }
}

impl Job {
    fn new(setup: &PathSetup, planning: Result<Planning, Refusal>) -> Self {
        let reserve = if setup.is_bound { RESERVE + rise(setup) } else { RESERVE };
        Self { setup: *setup, planning, skips: false, last: 0, open: false, idle: 0, reserve }
    }

    /// Plans the moves so far to their end.
    fn finish(&mut self) {
        if let Ok(planning) = &mut self.planning {
            planning.planner.finish();
        }
    }

    /// Plans a move; returns false if there is no room for it yet.
    fn take(&mut self, hand: &HandOver, id: u32, step: &PathMove) -> bool {
        if self.skips {
            return true;
        }
        let planned = match &mut self.planning {
            Ok(planning) if planning.planner.track().len() > AHEAD => return false,
            Ok(planning) => planning.plan(&self.setup, id, step),
            Err(why) => Err(Some(*why)),
        };
        match planned {
            Ok(()) => {
                self.last = id;
                self.open = true;
                true
            }
            Err(None) => false,
            Err(Some(why)) => {
                let report = Report { generation: self.setup.generation, id, why };
                self.skips = hand.reports.push(report).is_ok();
                self.skips
            }
        }
    }

    fn publish(&mut self, hand: &HandOver, is_fed: bool) {
        let Ok(planning) = &mut self.planning else { return };
        let Planning { planner, publisher, .. } = planning;
        self.idle = if is_fed { 0 } else { self.idle.saturating_add(1) };
        publisher.publish(planner);
        if self.open
            && self.idle >= IDLE
            && publisher.is_complete(planner)
            && publisher.time_ahead(hand.input(), self.setup.period, ENOUGH) < self.reserve
        {
            planner.finish();
            publisher.publish(planner);
            self.open = false;
        }
        if !self.open && publisher.is_complete(planner) {
            hand.finish(self.setup.generation, self.last);
        }
    }
}

impl Planning {
    /// Plans a move. `None` as the reason: there is no room yet.
    fn plan(&mut self, setup: &PathSetup, id: u32, step: &PathMove) -> Result<(), Option<Refusal>> {
        let start = *self.planner.position();
        reach::check(setup, &self.image, &start, step).map_err(Some)?;
        pace::check(setup, &self.image, &start, step).map_err(Some)?;
        if step.probe.is_some() {
            // A probe move begins at rest.
            self.planner.finish();
        }
        self.planner.limit_acceleration(step.acceleration);
        let feed = if step.is_time {
            Sweep::new(&start.0, &step.shape).length() / step.feed
        } else {
            step.feed
        };
        // A move of no length has no feed.
        let feed = if feed > 0.0 { feed.max(1e-6) } else { 1.0 };
        let rapid = step.kind == Kind::Rapid;
        let next = Move { shape: step.shape, feed, rapid, mode: step.mode, line: id };
        // A spindle that stands still yet may turn by then.
        let speed = step.sync.map_or(f64::INFINITY, |sync| sync.pitch * step.turns);
        let speed = if speed > 0.0 { speed } else { f64::INFINITY };
        self.planner.push_for(&next, speed).map_err(|why| match why {
            Error::Full => None,
            why => Some(refusal(why).on_line(step.line)),
        })
    }
}

/// Returns the limits for the planner.
pub(super) fn machine(setup: &PathSetup) -> Machine {
    let mut machine = Machine::uniform(Limits::NONE);
    let limits = |velocity: &f64, acceleration: &f64, jerk: &f64| Limits {
        velocity: *velocity,
        acceleration: *acceleration,
        jerk: *jerk,
    };
    let axes = setup.axis_velocity.iter().zip(&setup.axis_acceleration).zip(&setup.axis_jerk);
    for (slot, ((velocity, acceleration), jerk)) in machine.axes.iter_mut().zip(axes) {
        *slot = limits(velocity, acceleration, jerk);
    }
    let joints = setup.joint_velocity.iter().zip(&setup.joint_acceleration).zip(&setup.joint_jerk);
    for (slot, (((velocity, acceleration), jerk), active)) in
        machine.joints.iter_mut().zip(joints.zip(&setup.joint_active))
    {
        if *active {
            *slot = limits(velocity, acceleration, jerk);
        }
    }
    machine.period = setup.period;
    machine.exact_tolerance = setup.exact_tolerance;
    machine.angular_tolerance = ANGULAR;
    machine.max_override = setup.max_override;
    machine
}

/// Returns what moves along a path as a spindle turns.
pub(super) fn pursuer(setup: &PathSetup, image: &Image, start: Pose) -> Pursuer {
    let jerks = with_joints(setup, image, &setup.axis_jerk, &setup.joint_jerk);
    Pursuer::new(setup.period, start, jerks, setup.path_jerk)
}

/// Returns limits of the axes with those of the joints, if each joint follows an axis.
pub(super) fn with_joints(
    setup: &PathSetup,
    image: &Image,
    axes: &[f64; AXES],
    joints: &[f64],
) -> Option<[f64; AXES]> {
    let axis_of = image.axes_of_joints()?;
    let mut all = *axes;
    let joints = joints.iter().zip(&setup.joint_active).zip(axis_of);
    for ((limit, _), axis) in joints.filter(|((_, active), _)| **active) {
        if let Some(place) = axis.and_then(|axis| all.get_mut(axis))
            && limit < place
        {
            *place = *limit;
        }
    }
    Some(all)
}

/// Returns the longest time in which an axis or joint comes from rest to its acceleration, at most as much as is looked for
/// ahead.
fn rise(setup: &PathSetup) -> f64 {
    let axes = setup.axis_acceleration.iter().zip(&setup.axis_jerk);
    let joints = setup.joint_acceleration.iter().zip(&setup.joint_jerk).zip(&setup.joint_active);
    let joints = joints.filter(|(_, active)| **active).map(|(limits, _)| limits);
    let times = axes.chain(joints).map(|(acceleration, jerk)| acceleration / jerk);
    times.filter(|time| time.is_finite()).fold(0.0, f64::max).min(ENOUGH - RESERVE)
}

/// Returns the refusal for an error of the planner. The line is replaced by that of the program.
pub(super) fn refusal(why: Error) -> Refusal {
    let (text, numbers) = match why {
        Error::NotFinite { .. } => {
            ("move on line {}: a coordinate is not a number up to 1e9", [0.0; 2])
        }
        Error::Feed { feed, .. } => {
            ("move on line {}: feed {} is not a number above 0", [feed, 0.0])
        }
        Error::Tolerance { tolerance, .. } => {
            ("move on line {}: tolerance {} is not a number from 0 up", [tolerance, 0.0])
        }
        Error::RadiiDiffer { start, end, .. } => {
            ("circular move on line {}: radius to start is {}, radius to end is {}", [start, end])
        }
        Error::NoRadius { .. } => {
            ("circular move on line {}: the arc has no radius or its axis no direction", [0.0; 2])
        }
        Error::Limit { .. } => {
            ("move on line {}: a limit of velocity or acceleration is below 1e-6", [0.0; 2])
        }
        Error::Setting { value } => {
            ("move on line {}: the setting {} is outside its range", [value, 0.0])
        }
        Error::Unreachable { .. } => ("move on line {}: the kinematics cannot go there", [0.0; 2]),
        Error::Singular { joint, .. } => (
            "move on line {}: near a singular place joint {} allows less than 1 % of the feed",
            [joint as f64, 0.0],
        ),
        _ => ("move on line {}: the path is not possible", [0.0; 2]),
    };
    let [a, b] = numbers;
    Refusal::with(text, [0.0, a, b, 0.0])
}
