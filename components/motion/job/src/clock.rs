//! Duration and path of a program on its machine: the planner of motion plans the moves, and its follower follows the plan, which
//! takes time, or the plan is drawn.

use crate::{
    machine::Machine,
    way::{Kind, Way},
};
use hal_gcode::{
    Call, Interpreter, Issued,
    axis::{Axis, Position},
    canon::{Frame, PathMode, Plane},
    state::FeedMode,
};
use hal_trajectory::{
    Curve, Deviation, Error, Follower, Limits, Machine as Motion, Mode, Move, Planner, Pose, Shape,
    Trivial,
};

/// Tolerance of blends after a G64 without P: only the length of the moves limits them.
const UNBOUNDED: f64 = 1e6;

/// Lowest feed whose time counts, in units per second: a micrometre in a second.
const SLOWEST: f64 = 1e-3;

/// Number of cells that stay planned ahead of the follower. The follower runs when there are twice as many.
const AHEAD: u64 = 1000;

/// Largest angle between two places of an arc that is drawn, in radians, and parts of a cell of another curve.
const STEP: f64 = core::f64::consts::PI / 90.0;
const PARTS: u32 = 4;

/// Most places of a cell.
const MAX_PLACES: f64 = 1000.0;

/// A place of the planned path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// In machine coordinates, in millimetres and degrees.
    pub at: Position,
    /// Line of the call.
    pub line: u32,
    /// True in a rapid move, and not in its blend with a move at feed.
    pub is_rapid: bool,
}

/// Clock that advances by the calls of a program.
#[derive(Debug)]
pub struct Clock {
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
    /// Drawing of the plan, in the place of its time.
    drawing: Option<Drawing>,
}

impl Clock {
    /// Returns a clock that starts at the interpreter's position; `None` if the INI file does not state the speed and
    /// acceleration of every axis.
    pub fn new(it: &Interpreter, machine: &Machine) -> Option<Self> {
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
            drawing: None,
        })
    }

    /// Draws the plan from now on, and takes no time.
    pub fn draw(&mut self) {
        let places = vec![Place { at: self.way.at, line: 0, is_rapid: false }];
        self.drawing = Some(Drawing { places, next: 0 });
    }

    /// Returns the places of the planned path since the last question, as far as it is final.
    pub fn places(&mut self) -> impl Iterator<Item = Place> {
        self.drawing
            .as_mut()
            .map(|d| core::mem::take(&mut d.places))
            .unwrap_or_default()
            .into_iter()
    }

    /// Plans the calls so far to their end.
    pub fn finish(&mut self) {
        self.rest();
    }

    /// Returns the memory that the plan takes, in bytes.
    pub fn memory(&self) -> usize {
        let places = self.drawing.as_ref().map_or(0, |d| d.places.capacity());
        self.planner.memory() + places * size_of::<Place>()
    }

    /// Takes a call into account.
    ///
    /// # Errors
    /// The planner refuses a move, as motion would.
    pub fn call(&mut self, issued: &Issued) -> Result<(), Error> {
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
    pub fn result(mut self) -> (f64, Deviation) {
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
        if let Some(drawing) = &mut self.drawing {
            drawing.follow(&mut self.planner);
        } else if self.ahead() > 2 * AHEAD {
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
        let _ = self.follower.step(self.planner.track(), 1.0, false);
        self.periods += 1;
    }

    /// Ends the planned path, and runs the follower to its end, or draws it.
    fn rest(&mut self) {
        self.planner.finish();
        if let Some(drawing) = &mut self.drawing {
            return drawing.follow(&mut self.planner);
        }
        while !self.follower.is_done(self.planner.track()) {
            self.step();
        }
        self.planner.forget(self.follower.oldest());
    }
}

/// The planned path as places on its curves.
#[derive(Debug)]
struct Drawing {
    places: Vec<Place>,
    /// Number of the next cell.
    next: u64,
}

impl Drawing {
    /// Adds the cells that the planner has made, whose curves are final, and lets it forget them.
    fn follow(&mut self, planner: &mut Planner<Trivial>) {
        let track = planner.track();
        while let Some(cell) = track.cell(self.next) {
            self.next += 1;
            let Some(curve) = track.curve(cell.curve) else { continue };
            let parts = match curve {
                Curve::Line { .. } => 1,
                Curve::Arc { rate, .. } => {
                    let parts = (cell.length * rate.abs() / STEP).ceil().min(MAX_PLACES);
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "up to MAX_PLACES"
                    )]
                    let whole = (parts as u32).max(1);
                    whole
                }
                Curve::Poly { .. } => PARTS,
            };
            self.places.extend((1..=parts).map(|n| {
                let s = cell.from + cell.length * (f64::from(n) / f64::from(parts));
                let is_rapid = cell.feed == f64::INFINITY;
                Place { at: position(curve.pose(s)), line: cell.line, is_rapid }
            }));
        }
        planner.forget(self.next.saturating_sub(1));
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

fn position(pose: Pose) -> Position {
    let mut out = Position::default();
    for (axis, value) in Axis::ALL.into_iter().zip(pose.0) {
        out[axis] = value;
    }
    out
}

fn pose(p: Position) -> Pose {
    Pose(Axis::ALL.map(|axis| p[axis]))
}
