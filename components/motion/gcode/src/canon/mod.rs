//! Canonical calls: the typed output of the interpreter.

mod curve;
pub mod frame;
mod print;

use serde::{Deserialize, Serialize};

use crate::axis::{Axis, Position};
pub use curve::curve_point;
pub use frame::Frame;

/// The plane of arcs, cycles and compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Plane {
    /// G17
    Xy,
    /// G18
    Xz,
    /// G19
    Yz,
    /// G17.1
    Uv,
    /// G18.1
    Uw,
    /// G19.1
    Vw,
}

impl Plane {
    /// Returns the first and second axis of the plane and the axis across it.
    pub fn axes(self) -> (Axis, Axis, Axis) {
        match self {
            Self::Xy => (Axis::X, Axis::Y, Axis::Z),
            Self::Xz => (Axis::Z, Axis::X, Axis::Y),
            Self::Yz => (Axis::Y, Axis::Z, Axis::X),
            Self::Uv => (Axis::U, Axis::V, Axis::W),
            Self::Uw => (Axis::W, Axis::U, Axis::V),
            Self::Vw => (Axis::V, Axis::W, Axis::U),
        }
    }
}

/// The unit of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// Inches (G20).
    Inch,
    /// Millimetres (G21).
    Millimetre,
}

impl Unit {
    /// Returns the name in messages.
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Inch => "inch",
            Self::Millimetre => "mm",
        }
    }

    /// Returns the millimetres of one unit.
    pub fn millimetres(self) -> f64 {
        match self {
            Self::Inch => 25.4,
            Self::Millimetre => 1.0,
        }
    }

    /// Returns the factor from this unit to `other`.
    pub fn to(self, other: Self) -> f64 {
        match (self, other) {
            (Self::Inch, Self::Millimetre) => 25.4,
            (Self::Millimetre, Self::Inch) => 1.0 / 25.4,
            _ => 1.0,
        }
    }
}

/// The path control mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum PathMode {
    /// G61
    ExactPath,
    /// G61.1
    ExactStop,
    /// G64 with its tolerance; 0 means that none was given.
    Continuous {
        /// The largest distance from the path.
        tolerance: f64,
    },
}

/// A direction of the spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// M5
    Stopped,
    /// M3
    Clockwise,
    /// M4
    Counterclockwise,
}

/// A control point of a G5, G5.1 or G5.2 curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlPoint {
    /// X.
    pub x: f64,
    /// Y.
    pub y: f64,
    /// Weight, above zero.
    pub weight: f64,
}

/// A canonical call. Positions are in program coordinates and units; [`Frame`] turns them into machine coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields have the names of the words that set them")]
pub enum Call {
    /// The unit of all lengths that follow.
    UseLengthUnits(Unit),
    /// The plane of arcs.
    SelectPlane(Plane),
    /// The offset of coordinate system `system` (1 for G54).
    SetG5xOffset { system: u8, offset: Position },
    /// The offset of G92 and G52.
    SetG92Offset(Position),
    /// The rotation of the coordinate system about Z in degrees.
    SetXyRotation(f64),
    /// The tool's offset.
    UseToolLengthOffset(Position),
    /// A rapid move.
    StraightTraverse(Position),
    /// A move at feed.
    StraightFeed(Position),
    /// An arc or helix: its centre in the order of the plane's axes, `turns` negative for clockwise.
    ArcFeed { plane: Plane, end: Position, centre_first: f64, centre_second: f64, turns: i32 },
    /// A rational B-spline in XY. `order` is 4 for cubic ones.
    NurbsFeed { order: u32, points: Vec<ControlPoint>, end: Position },
    /// A probing move; the kind is that of G38.2 to G38.5.
    StraightProbe { end: Position, away: bool, must_trip: bool },
    /// A rigid tap to `end` and back, with a speed factor for the way back.
    RigidTap { end: Position, retract_scale: f64 },
    /// The feed rate in units of the feed mode.
    SetFeedRate(f64),
    /// The feed mode: feed per revolution of `spindle`, or per minute.
    SetFeedMode { spindle: u8, per_revolution: bool },
    /// The path control mode.
    SetPathMode(PathMode),
    /// The tolerance within which short lines join.
    SetNaiveCamTolerance(f64),
    /// Motion bound to the spindle: `pitch` per revolution, or its velocity.
    StartSpeedFeedSync { pitch: f64, velocity_mode: bool, spindle: u8 },
    /// The end of motion bound to the spindle.
    StopSpeedFeedSync,
    /// A pause in seconds.
    Dwell(f64),
    /// The speed of a spindle.
    SetSpindleSpeed { spindle: u8, speed: f64 },
    /// Constant surface speed with its top speed; 0 for constant revolutions.
    SetSpindleMode { spindle: u8, css_max: f64 },
    /// A spindle starts or stops.
    TurnSpindle { spindle: u8, direction: Direction },
    /// A spindle turns to an angle.
    OrientSpindle { spindle: u8, degrees: f64, mode: u8 },
    /// Motion waits for the oriented spindle.
    WaitSpindleOrient { spindle: u8, timeout: f64 },
    /// The next tool.
    SelectTool(i32),
    /// A tool change begins.
    StartChange,
    /// The tool changes.
    ChangeTool(i32),
    /// The tool in the spindle has this number, without a change.
    ChangeToolNumber(i32),
    /// An entry of the tool table changes.
    SetToolTableEntry {
        pocket: u32,
        tool: i32,
        offset: Position,
        diameter: f64,
        front: f64,
        back: f64,
        orientation: u8,
    },
    /// The tool table is read again.
    ReloadToolData,
    /// Mist (M7).
    Mist(bool),
    /// Flood (M8).
    Flood(bool),
    /// Feed override (M48 to M50).
    FeedOverride(bool),
    /// Speed override of a spindle (M48, M49, M51).
    SpeedOverride { spindle: u8, on: bool },
    /// Adaptive feed (M52).
    AdaptiveFeed(bool),
    /// Feed hold (M53).
    FeedHold(bool),
    /// A digital output, with the motion (M62, M63) or at once (M64, M65).
    DigitalOutput { index: u32, on: bool, with_motion: bool },
    /// An analog output, with the motion (M67) or at once (M68).
    AnalogOutput { index: u32, value: f64, with_motion: bool },
    /// A wait for an input (M66).
    Wait { index: u32, analog: bool, mode: u8, timeout: f64 },
    /// A user's program (M100 to M199).
    UserCode { code: u16, p: f64, q: f64 },
    /// The probe counts from here.
    TurnProbeOn,
    /// The probe counts no longer.
    TurnProbeOff,
    /// A pause (M0).
    ProgramStop,
    /// A pause if the operator wishes (M1).
    OptionalProgramStop,
    /// A change of pallets (M30, M60).
    PalletShuttle,
    /// The end (M2, M30).
    ProgramEnd,
    /// The end by a percent sign.
    Finish,
    /// A message for the operator.
    Message(Box<str>),
    /// A line for the terminal (`PRINT`).
    Print(Box<str>),
    /// A line for the log file.
    Log(Box<str>),
    /// A log file opens, at its end if `append`.
    LogOpen { name: Box<str>, append: bool },
    /// The log file closes.
    LogClose,
    /// A file for probe results opens.
    ProbeOpen(Box<str>),
    /// The file for probe results closes.
    ProbeClose,
    /// A remark that changes nothing.
    Comment(Box<str>),
}

/// A canonical call and the line that made it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Issued {
    /// The call.
    pub call: Call,
    /// The line, from 1.
    pub line: u32,
    /// The N number of the line.
    pub number: Option<u32>,
}
