//! Duration of a program on its machine: the planner of motion plans the moves, and its follower follows the plan.

use hal_gcode::{
    Call, Interpreter, Issued,
    axis::{Axis, Position},
    canon::{Frame, PathMode, Plane},
    state::FeedMode,
};
use hal_job::{
    machine::Machine,
    way::{Kind, Way},
};
use hal_trajectory::{
    Deviation, Error, Follower, Limits, Machine as Motion, Mode, Move, Planner, Pose, Shape,
    Trivial,
};

/// Tolerance of blends after a G64 without P: only the length of the moves limits them.
const UNBOUNDED: f64 = 1e6;

/// Lowest feed whose time counts, in units per second: a micrometre in a second.
const SLOWEST: f64 = 1e-3;

/// Number of cells that stay planned ahead of the follower. The follower runs when there are twice as many.
const AHEAD: u64 = 1000;

/// Distance of places of the planned path from each other at least, in millimetres.
const NEAR: f64 = 0.005;

/// Clock that advances by the calls of a program.
pub(super) struct Clock {
    planner: Planner<Trivial>,
    follower: Follower,
    period: f64,
    periods: u64,
    dwells: f64,
    frame: Frame,
    way: Way,
    /// Highest speeds along the path, linear and angular, in units per second.
    top: (f64, f64),
    mode: Mode,
    feed: f64,
    /// The spindle of a feed per revolution.
    per_revolution: Option<u8>,
    /// Commanded speeds of the spindles, in turns per minute.
    speeds: Vec<f64>,
    /// Travel per revolution, or per minute, of motion bound to a spindle, and its number.
    bound: Option<(f64, bool, u8)>,
    /// Places of the planned path in X, Y and Z, if they are kept.
    path: Option<Vec<[f64; 3]>>,
}

impl Clock {
    /// Returns a clock that starts at the interpreter's position; `None` if the INI file does not state the speed and
    /// acceleration of every axis.
    pub(super) fn new(it: &Interpreter, machine: &Machine) -> Option<Self> {
        let state = &it.state;
        let motion = motion(machine)?;
        let start = pose(state.frame.machine_mm(state.position));
        let mut planner = Planner::new(motion, Trivial, start).ok()?;
        planner.watch_deviation();
        Some(Self {
            planner,
            follower: Follower::new(motion.period, start),
            period: motion.period,
            periods: 0,
            dwells: 0.0,
            frame: state.frame,
            way: Way::new(state.frame, state.position),
            top: machine.top_speed,
            mode: mode(state.modal.path, state.frame.unit.millimetres()),
            feed: state.modal.feed,
            per_revolution: (state.modal.feed_mode == FeedMode::PerRevolution)
                .then_some(state.modal.feed_spindle),
            speeds: state.modal.spindles.iter().map(|s| s.speed).collect(),
            bound: None,
            path: None,
        })
    }

    /// Keeps the places of the planned path from now on.
    pub(super) fn keep_path(&mut self) {
        self.path = Some(Vec::new());
    }

    /// Returns the number of places that are kept.
    pub(super) fn places(&self) -> usize {
        self.path.as_ref().map_or(0, Vec::len)
    }

    /// Returns the planned path in machine coordinates, in millimetres, with a place at least every servo period or every
    /// [`NEAR`].
    pub(super) fn path(mut self) -> Vec<[f64; 3]> {
        self.rest();
        self.path.unwrap_or_default()
    }

    /// Takes a call into account.
    ///
    /// # Errors
    /// The planner refuses a move, as motion would.
    pub(super) fn call(&mut self, issued: &Issued) -> Result<(), Error> {
        let unit = self.frame.unit.millimetres();
        match &issued.call {
            Call::SetFeedRate(feed) => self.feed = *feed,
            Call::SetFeedMode { spindle, per_revolution } => {
                self.per_revolution = per_revolution.then_some(*spindle);
            }
            Call::SetSpindleSpeed { spindle, speed } => {
                if let Some(slot) = self.speeds.get_mut(usize::from(*spindle)) {
                    *slot = *speed;
                }
            }
            Call::SetPathMode(path) => self.mode = mode(*path, unit),
            Call::StartSpeedFeedSync { pitch, velocity_mode, spindle } => {
                self.bound = Some((*pitch, *velocity_mode, *spindle));
            }
            Call::StopSpeedFeedSync => self.bound = None,
            Call::Dwell(seconds) => {
                self.rest();
                self.dwells += seconds.max(0.0);
            }
            // Motion rests until these are done.
            Call::ChangeTool(_)
            | Call::WaitSpindleOrient { .. }
            | Call::Wait { .. }
            | Call::UserCode { .. }
            | Call::ProgramStop
            | Call::PalletShuttle
            | Call::ProgramEnd
            | Call::Finish => self.rest(),
            _ => {}
        }
        self.frame.apply(&issued.call);
        let from = self.way.at;
        let mut points = Vec::new();
        self.way.follow(&issued.call, &mut |kind, point| points.push((kind, point)));
        if let Call::ArcFeed { plane, end, centre_first, centre_second, turns } = &issued.call
            && let Some(arc) = self.arc(*plane, *end, (*centre_first, *centre_second), *turns)
        {
            let taken = self.push(from, self.way.at, arc, Kind::Feed, issued.line);
            if taken.is_ok() {
                return Ok(());
            }
        }
        let stops = matches!(issued.call, Call::RigidTap { .. } | Call::StraightProbe { .. });
        let mut last = from;
        let mut refused = Ok(());
        for (kind, point) in points {
            let line = Shape::Line { end: pose(point) };
            refused = refused.and(self.push(last, point, line, kind, issued.line));
            if stops {
                self.rest();
            }
            last = point;
        }
        refused
    }

    /// Returns the time in seconds, without refused moves, and the largest distance from the programmed path, in
    /// millimetres.
    pub(super) fn result(mut self) -> (f64, Deviation) {
        self.rest();
        let seconds = self.periods as f64 * self.period + self.dwells;
        (seconds, self.planner.deviation().unwrap_or_default())
    }

    /// Returns an arc in machine coordinates; `None` in planes of U, V and W.
    fn arc(&self, plane: Plane, end: Position, centre: (f64, f64), turns: i32) -> Option<Shape> {
        if !matches!(plane, Plane::Xy | Plane::Xz | Plane::Yz) {
            return None;
        }
        let (first, second, third) = plane.axes();
        let mut middle = end;
        (middle[first], middle[second]) = centre;
        let mut above = middle;
        above[third] += if turns < 0 { -1.0 } else { 1.0 };
        let [middle, above] = [middle, above].map(|p| self.frame.machine_mm(p));
        let by = above - middle;
        Some(Shape::Arc {
            end: pose(self.frame.machine_mm(end)),
            center: [middle.x, middle.y, middle.z],
            normal: [by.x, by.y, by.z],
            turns: turns.unsigned_abs().saturating_sub(1),
        })
    }

    fn push(
        &mut self,
        from: Position,
        to: Position,
        shape: Shape,
        kind: Kind,
        line: u32,
    ) -> Result<(), Error> {
        let is_arc = matches!(shape, Shape::Arc { .. });
        let by = to - from;
        let linear = is_arc || [by.x, by.y, by.z, by.u, by.v, by.w].iter().any(|d| *d != 0.0);
        let (unit, top) =
            if linear { (self.frame.unit.millimetres(), self.top.0) } else { (1.0, self.top.1) };
        let speed = |spindle: u8| self.speeds.get(usize::from(spindle)).map_or(0.0, |s| s.abs());
        let per_minute = match (self.bound, self.per_revolution) {
            (Some((pitch, true, _)), _) => pitch,
            (Some((pitch, false, spindle)), _) => pitch * speed(spindle),
            (None, Some(spindle)) => self.feed * speed(spindle),
            (None, None) => self.feed,
        };
        let feed = match kind {
            Kind::Rapid => top,
            // A spindle that stands still, or a feed that is none, gives no time: the path alone is planned.
            Kind::Feed if per_minute * unit / 60.0 <= SLOWEST => top,
            Kind::Feed => (per_minute * unit / 60.0).min(top),
        };
        let rapid = kind == Kind::Rapid;
        let next = Move { shape, feed, rapid, mode: self.mode, line };
        if self.ahead() > 2 * AHEAD {
            while self.ahead() > AHEAD {
                self.step();
            }
            self.planner.forget(self.follower.oldest());
        }
        self.planner.push(&next)
    }

    /// Returns the number of cells ahead of the follower.
    fn ahead(&self) -> u64 {
        let track = self.planner.track();
        (track.oldest() + track.len() as u64).saturating_sub(self.follower.oldest())
    }

    fn step(&mut self) {
        let step = self.follower.step(self.planner.track(), 1.0, false);
        self.periods += 1;
        let Some(path) = &mut self.path else { return };
        let [x, y, z, ..] = step.pose.0;
        let is_near = |last: &[f64; 3]| {
            [x, y, z].iter().zip(last).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() < NEAR * NEAR
        };
        if !path.last().is_some_and(is_near) {
            path.push([x, y, z]);
        }
    }

    /// Ends the planned path, and runs the follower to its end.
    fn rest(&mut self) {
        self.planner.finish();
        while !self.follower.is_done(self.planner.track()) {
            self.step();
        }
        self.planner.forget(self.follower.oldest());
    }
}

/// Returns the machine of the planner.
fn motion(machine: &Machine) -> Option<Motion> {
    let mut motion = Motion::uniform(Limits::NONE);
    for axis in Axis::ALL {
        let index = usize::from(axis.index());
        let slot = motion.axes.get_mut(index)?;
        if machine.settings.axes.0 >> axis.index() & 1 == 1 {
            let [velocity, acceleration, jerk] = machine.rates.get(index).copied()?;
            *slot = Limits {
                velocity: velocity?,
                acceleration: acceleration?,
                jerk: jerk.unwrap_or(f64::INFINITY),
            };
        }
    }
    motion.period = machine.period;
    Some(motion)
}

/// Returns the planner's mode. The tolerance is in the program's unit.
const fn mode(path: PathMode, unit: f64) -> Mode {
    match path {
        PathMode::ExactPath => Mode::Exact,
        PathMode::ExactStop => Mode::ExactStop,
        PathMode::Continuous { tolerance } => {
            Mode::Blend(if tolerance > 0.0 { tolerance * unit } else { UNBOUNDED })
        }
    }
}

fn pose(p: Position) -> Pose {
    Pose(Axis::ALL.map(|axis| p[axis]))
}
