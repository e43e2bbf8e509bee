//! From canonical calls to the steps of a job, in machine coordinates and units.

mod spline;

use crate::outside::{FileAction, FileKind, Move, Order, PathEnd, Pitch, Shape, Speed};
use hal_component::Wait;
use hal_gcode::{
    Call, Settings, State,
    axis::{Axis, Position},
    canon::{Direction, Frame, PathMode, Plane, Unit},
    state::{FeedMode, modal::MAX_SPINDLES},
};

/// A step of a job.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Action {
    /// An order that joins the path, without waiting for motion before it.
    Path(Order),
    /// An order that is sent at rest, and that has taken effect before the next step.
    Rest(Order),
    /// A pause of this many seconds, at rest.
    Dwell(f64),
    /// Asks for the next tool.
    Prepare(i32),
    /// Changes the tool, at rest.
    Change(i32),
    /// States which tool is in the spindle.
    SetTool(i32),
    /// Coolant: mist or flood.
    Coolant {
        mist: Option<bool>,
        flood: Option<bool>,
    },
    /// An entry of the tool table, from the interpreter's call.
    ToolEntry(Call),
    /// Reads the tool table again.
    ReloadTools,
    /// Waits for an input.
    Input {
        index: u32,
        analog: bool,
        mode: u8,
        timeout: f64,
    },
    /// Waits for a spindle's orientation.
    Oriented {
        timeout: f64,
    },
    /// Changes a spindle's constant surface speed: machine units per minute, and the top speed.
    SurfaceSpeed {
        spindle: u8,
        speed: Option<(f64, f64)>,
    },
    /// Feed override counts.
    FeedOverride(bool),
    /// Speed override of a spindle counts.
    SpeedOverride {
        spindle: u8,
        on: bool,
    },
    /// A user's program.
    UserCode {
        code: u16,
        p: f64,
        q: f64,
    },
    /// Pauses the job for this reason; at M1, if the operator wants that.
    Pause(Wait),
    /// A message for the operator.
    Message(Box<str>),
    /// The end of the program.
    End,
    /// The machine cannot do what the program says.
    /// A file of the program opens, gets a line, or closes.
    File(FileAction),
    Refuse(Box<str>),
}

/// A spindle as the calls so far have set it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spindle {
    /// Turns per minute, or surface speed in metres or feet per minute.
    speed: f64,
    /// Sign of the direction; 0 at rest.
    direction: f64,
    /// Top speed of constant surface speed.
    css_max: Option<f64>,
}

/// The state that canonical calls depend on, followed from call to call.
#[derive(Clone, Debug)]
pub(crate) struct Converter {
    pub(crate) frame: Frame,
    unit: Unit,
    axes: hal_gcode::axis::AxisMask,
    feed: f64,
    feed_per_turn: Option<u8>,
    path: PathMode,
    cam_tolerance: f64,
    sync: Option<Pitch>,
    spindles: [Spindle; MAX_SPINDLES],
    /// End of the last move, in machine units.
    at: [f64; 9],
    /// Coordinate system in force.
    pub(crate) system: u8,
    /// The line has changed the pallet: its stop is that of M60.
    pallet: bool,
    change_position: Option<[Option<f64>; 9]>,
}

impl Converter {
    /// Returns a converter for a machine with these settings, and the place for tool changes.
    pub(crate) fn new(settings: &Settings, change_position: Option<[Option<f64>; 9]>) -> Self {
        Self {
            frame: Frame::new(settings.program_unit),
            unit: settings.unit,
            axes: settings.axes,
            feed: 0.0,
            feed_per_turn: None,
            path: PathMode::Continuous { tolerance: 0.0 },
            cam_tolerance: 0.0,
            sync: None,
            spindles: [Spindle::default(); MAX_SPINDLES],
            at: [0.0; 9],
            system: 1,
            pallet: false,
            change_position,
        }
    }

    /// Takes over the modal state of an interpreter, and the place of the machine.
    pub(crate) fn restart(&mut self, state: &State, at: [f64; 9]) {
        self.frame = state.frame;
        self.feed = state.modal.feed;
        let per_turn = state.modal.feed_mode == FeedMode::PerRevolution;
        self.feed_per_turn = per_turn.then_some(state.modal.feed_spindle);
        self.path = state.modal.path;
        self.cam_tolerance = state.modal.naive_tolerance;
        self.system = state.modal.system;
        self.sync = None;
        self.pallet = false;
        self.at = at;
        for (spindle, modal) in self.spindles.iter_mut().zip(&state.modal.spindles) {
            spindle.speed = modal.speed;
            spindle.direction = sign(modal.direction);
            spindle.css_max = (modal.css_max > 0.0).then_some(modal.css_max);
        }
    }

    /// Adds the steps of a call to `out`.
    pub(crate) fn convert(&mut self, call: Call, line: u32, out: &mut Vec<Action>) {
        self.frame.apply(&call);
        match call {
            Call::StraightTraverse(to) => {
                let order = self.to(to, Shape::Line, true, line);
                out.push(Action::Path(order));
            }
            Call::StraightFeed(to) => {
                let order = self.to(to, Shape::Line, false, line);
                out.push(Action::Path(order));
            }
            Call::ArcFeed { plane, end, centre_first, centre_second, turns } => {
                match self.arc(plane, end, (centre_first, centre_second), turns) {
                    Some(shape) => {
                        let order = self.to(end, shape, false, line);
                        out.push(Action::Path(order));
                    }
                    None => out.push(refuse("arcs in U, V and W are not supported by motion")),
                }
            }
            Call::NurbsFeed { order, points, end } => {
                if !self.spline((order, &points), end, line, out) {
                    out.push(refuse("a curve has too few control points"));
                }
            }
            Call::StraightProbe { end, away, must_trip } => {
                let shape = Shape::Probe { away, must: must_trip };
                out.push(Action::Rest(self.to(end, shape, false, line)));
            }
            Call::RigidTap { end, retract_scale } => {
                out.push(Action::Path(self.to(end, Shape::Tap { retract_scale }, false, line)));
            }
            Call::UseToolLengthOffset(offset) => {
                let k = self.frame.unit.to(self.unit);
                let offset = Axis::ALL.map(|a| offset.scaled(k)[a]);
                out.push(Action::Path(Order::ToolOffset(offset)));
            }
            Call::SetG5xOffset { system, .. } => self.system = system,
            Call::SetFeedRate(feed) => self.feed = feed,
            Call::SetFeedMode { spindle, per_revolution } => {
                self.feed_per_turn = per_revolution.then_some(spindle);
            }
            Call::SetPathMode(path) => self.path = path,
            Call::SetNaiveCamTolerance(tolerance) => self.cam_tolerance = tolerance,
            Call::StartSpeedFeedSync { pitch, velocity_mode, spindle } => {
                let travel = pitch * self.frame.unit.to(self.unit);
                let is_at_surface = self.is_at_surface(spindle);
                self.sync = Some(Pitch { spindle, travel, velocity_mode, is_at_surface });
            }
            Call::StopSpeedFeedSync => self.sync = None,
            Call::PalletShuttle => self.pallet = true,
            Call::Dwell(seconds) => out.push(Action::Dwell(seconds)),
            Call::SetSpindleSpeed { .. }
            | Call::SetSpindleMode { .. }
            | Call::TurnSpindle { .. } => self.spindle(&call, out),
            Call::OrientSpindle { spindle, degrees, mode } => {
                out.push(Action::Rest(Order::Orient { spindle, degrees, mode }));
            }
            Call::WaitSpindleOrient { timeout, .. } => out.push(Action::Oriented { timeout }),
            other => other_action(other, self, line, out),
        }
    }

    fn machine(&self, program: Position) -> [f64; 9] {
        let k = self.frame.unit.to(self.unit);
        let machine = self.frame.machine(program).scaled(k);
        // Axes that the machine does not have stay where they are.
        let mut out = [0.0; 9];
        for ((place, axis), at) in out.iter_mut().zip(Axis::ALL).zip(self.at) {
            *place = if self.axes.has(axis) { machine[axis] } else { at };
        }
        out
    }

    fn to(&mut self, to: Position, shape: Shape, rapid: bool, line: u32) -> Order {
        let to = self.machine(to);
        let k = self.frame.unit.to(self.unit);
        let turns_only = shape == Shape::Line && !moves_linearly(&self.at, &to);
        let feed = if turns_only { self.feed } else { self.feed * k };
        let pitch = if rapid { None } else { self.sync.or_else(|| self.per_turn(k)) };
        self.at = to;
        Order::Move(Move {
            to,
            shape,
            speed: if rapid { Speed::Rapid } else { Speed::Feed(feed / 60.0) },
            end: match self.path {
                PathMode::ExactStop => PathEnd::Stop,
                PathMode::ExactPath => PathEnd::Exact,
                PathMode::Continuous { tolerance } if tolerance > 0.0 => {
                    PathEnd::Blend(tolerance * k)
                }
                PathMode::Continuous { .. } => PathEnd::Blend(f64::INFINITY),
            },
            cam_tolerance: self.cam_tolerance * k,
            pitch,
            line,
        })
    }

    /// Returns the travel per turn of G95.
    fn per_turn(&self, k: f64) -> Option<Pitch> {
        let spindle = self.feed_per_turn?;
        let is_at_surface = self.is_at_surface(spindle);
        Some(Pitch { spindle, travel: self.feed * k, velocity_mode: true, is_at_surface })
    }

    fn is_at_surface(&self, spindle: u8) -> bool {
        self.spindles.get(usize::from(spindle)).is_some_and(|s| s.css_max.is_some())
    }

    fn arc(&self, plane: Plane, end: Position, center: (f64, f64), turns: i32) -> Option<Shape> {
        let (first, second, across) = plane.axes();
        if !matches!(plane, Plane::Xy | Plane::Xz | Plane::Yz) {
            return None;
        }
        let mut middle = end;
        middle[first] = center.0;
        middle[second] = center.1;
        let [x, y, z, ..] = self.machine(middle);
        let mut normal = Position::default();
        normal[across] = 1.0;
        let normal = normal.rotated(self.frame.rotation);
        Some(Shape::Arc {
            center: [x, y, z],
            normal: [normal.x, normal.y, normal.z],
            clockwise: turns < 0,
            turns: turns.unsigned_abs().saturating_sub(1),
        })
    }

    /// Follows a spindle's speed, mode and direction, and adds the step if it turns or its state changes.
    fn spindle(&mut self, call: &Call, out: &mut Vec<Action>) {
        let (number, turned) = match call {
            Call::SetSpindleSpeed { spindle, .. } | Call::SetSpindleMode { spindle, .. } => {
                (*spindle, false)
            }
            Call::TurnSpindle { spindle, .. } => (*spindle, true),
            _ => return,
        };
        let k = self.frame.unit.to(self.unit);
        let Some(s) = self.spindles.get_mut(usize::from(number)) else { return };
        match call {
            Call::SetSpindleSpeed { speed, .. } => s.speed = *speed,
            Call::SetSpindleMode { css_max, .. } => {
                s.css_max = (*css_max > 0.0).then_some(*css_max);
            }
            Call::TurnSpindle { direction, .. } => s.direction = sign(*direction),
            _ => {}
        }
        if !turned && s.direction == 0.0 {
            return;
        }
        let surface = s.css_max.filter(|_| s.direction != 0.0);
        // S counts in metres per minute, or in feet per minute.
        let long = if self.frame.unit == Unit::Inch { 12.0 } else { 1000.0 };
        let speed = surface.map(|top| (s.speed * s.direction * long * k, top));
        out.push(Action::SurfaceSpeed { spindle: number, speed });
        if surface.is_none() {
            let speed = s.speed * s.direction;
            out.push(Action::Rest(Order::Spindle { spindle: number, speed }));
        }
    }
}

/// Converts the calls that do not depend on the state of the path.
fn other_action(call: Call, converter: &mut Converter, line: u32, out: &mut Vec<Action>) {
    let action = match call {
        Call::SelectTool(tool) => Action::Prepare(tool),
        Call::ChangeTool(tool) => {
            if let Some(place) = converter.change_position {
                let mut to = converter.at;
                for (value, stated) in to.iter_mut().zip(place) {
                    *value = stated.unwrap_or(*value);
                }
                converter.at = to;
                out.push(Action::Path(Order::Move(Move {
                    to,
                    shape: Shape::Line,
                    speed: Speed::Rapid,
                    end: PathEnd::Stop,
                    cam_tolerance: 0.0,
                    pitch: None,
                    line,
                })));
            }
            Action::Change(tool)
        }
        Call::ChangeToolNumber(tool) => Action::SetTool(tool),
        Call::SetToolTableEntry { .. } => Action::ToolEntry(call),
        Call::ReloadToolData => Action::ReloadTools,
        Call::Mist(on) => Action::Coolant { mist: Some(on), flood: None },
        Call::Flood(on) => Action::Coolant { mist: None, flood: Some(on) },
        Call::FeedOverride(on) => Action::FeedOverride(on),
        Call::SpeedOverride { spindle, on } => Action::SpeedOverride { spindle, on },
        Call::AdaptiveFeed(on) => Action::Rest(Order::AdaptiveFeed(on)),
        Call::FeedHold(on) => Action::Rest(Order::FeedHold(on)),
        Call::DigitalOutput { index, on, with_motion } => {
            output(Order::Digital { index, on, with_motion }, with_motion)
        }
        Call::AnalogOutput { index, value, with_motion } => {
            output(Order::Analog { index, value, with_motion }, with_motion)
        }
        Call::Wait { index, analog, mode, timeout } => {
            Action::Input { index, analog, mode, timeout }
        }
        Call::UserCode { code, p, q } => Action::UserCode { code, p, q },
        Call::ProgramStop if core::mem::take(&mut converter.pallet) => Action::Pause(Wait::Pallet),
        Call::ProgramStop => Action::Pause(Wait::Stop),
        Call::OptionalProgramStop => Action::Pause(Wait::OptionalStop),
        Call::ProgramEnd | Call::Finish => {
            converter.pallet = false;
            Action::End
        }
        Call::Message(text) | Call::Print(text) => Action::Message(text),
        Call::LogOpen { name, append } => {
            Action::File(FileAction::Open { kind: FileKind::Log, name, append })
        }
        Call::Log(text) => Action::File(FileAction::Line(FileKind::Log, text)),
        Call::LogClose => Action::File(FileAction::Close(FileKind::Log)),
        Call::ProbeOpen(name) => {
            Action::File(FileAction::Open { kind: FileKind::Probe, name, append: false })
        }
        Call::ProbeClose => Action::File(FileAction::Close(FileKind::Probe)),
        _ => return,
    };
    out.push(action);
}

fn output(order: Order, with_motion: bool) -> Action {
    if with_motion { Action::Path(order) } else { Action::Rest(order) }
}

fn refuse(why: &str) -> Action {
    Action::Refuse(why.into())
}

fn sign(direction: Direction) -> f64 {
    match direction {
        Direction::Stopped => 0.0,
        Direction::Clockwise => 1.0,
        Direction::Counterclockwise => -1.0,
    }
}

fn moves_linearly(from: &[f64; 9], to: &[f64; 9]) -> bool {
    let linear = Axis::ALL.iter().zip(from.iter().zip(to)).filter(|(a, _)| !a.is_rotary());
    let mut rotary = Axis::ALL.iter().zip(from.iter().zip(to)).filter(|(a, _)| a.is_rotary());
    linear.into_iter().any(|(_, (a, b))| a != b) || !rotary.any(|(_, (a, b))| a != b)
}
