//! Commands from the control side to the realtime side.

use crate::commands::config::{AxisConfig, JointConfig, SpindleConfig, TrajConfig};
use hal_component::{MotionSource, Pose, StopEpoch, TicketHandle};
pub(crate) use hal_safety::Mode;
use hal_safety::OrderKind;
pub(crate) use hal_trajectory::Mode as PathMode;

/// Target of a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JogTarget {
    /// A joint.
    Joint(usize),
    /// An axis, by its index among the letters.
    Axis(usize),
}

/// Extent of a jog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JogDistance {
    /// Until it is stopped, in the direction of its velocity.
    Continuous,
    /// By a distance, added to the current target.
    Incremental(f64),
    /// To a position.
    Absolute(f64),
}

/// A jog.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jog {
    pub(crate) target: JogTarget,
    pub(crate) velocity: f64,
    pub(crate) distance: JogDistance,
}

/// A coordinated move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    /// Target pose; letters that do not move are NaN.
    pub(crate) to: Pose,
    pub(crate) arc: Option<Arc>,
    pub(crate) probe: Option<Probe>,
    pub(crate) speed: Speed,
    pub(crate) acceleration: Option<f64>,
    /// Path control at the end.
    pub(crate) mode: PathMode,
    /// Line of the program.
    pub(crate) line: u32,
    /// Spindle that the move follows.
    pub(crate) sync: Option<Sync>,
}

/// Relation of a move to a spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sync {
    pub(crate) spindle: usize,
    /// Units per turn.
    pub(crate) pitch: f64,
    pub(crate) follows: Follows,
    /// True at constant surface speed (G96): the turns depend on the place.
    pub(crate) is_at_surface: bool,
}

/// Property of a spindle that a move follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Follows {
    /// The measured speed: feed per turn (G95).
    Speed,
    /// The place from its index on: thread (G33).
    Place,
    /// The place, in and out again: rigid tap (G33.1).
    Tap {
        /// Factor for the spindle's speed on the way out.
        back: f64,
    },
}

/// Speed of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Speed {
    /// The default velocity.
    Default,
    /// As fast as the limits allow.
    Rapid,
    /// Units per second along the path.
    Feed(f64),
    /// The whole move takes this time, in seconds.
    Time(f64),
}

/// A move that ends where the probe changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Probe {
    /// True if the probe must lose its contact (G38.4, G38.5).
    pub(crate) away: bool,
    /// True if a move without a change fails (G38.2, G38.4).
    pub(crate) must: bool,
}

/// The circular part of a move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    /// Centre; a NaN coordinate is that of the start.
    pub(crate) center: [f64; 3],
    /// Direction of the axis; the motion is counter-clockwise around it.
    pub(crate) normal: [f64; 3],
    /// Additional full turns.
    pub(crate) turns: u32,
}

/// Changes of a path in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Run {
    Pause,
    Resume,
    Step,
    Reverse,
    Forward,
}

/// Settings that `motion.feed` changes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FeedChange {
    pub(crate) scale: Option<f64>,
    pub(crate) rapid: Option<f64>,
    pub(crate) adaptive: Option<bool>,
    pub(crate) hold: Option<bool>,
}

/// Settings that `motion.spindle` changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpindleChange {
    pub(crate) spindle: usize,
    pub(crate) speed: Option<f64>,
    pub(crate) scale: Option<f64>,
    pub(crate) brake: Option<bool>,
}

impl SpindleChange {
    /// Returns whether the spindle may turn by this.
    const fn turns(&self) -> bool {
        let stands = matches!(self.speed, None | Some(0.0));
        !stands || matches!(self.brake, Some(false))
    }
}

/// New value of an output for programs.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Output {
    Digital(usize, bool),
    Analog(usize, f64),
    /// The tool offset that a program uses.
    ToolOffset(Pose),
}

/// A set of joints, one bit each.
pub(crate) type Joints = u32;

/// Requests that take machine time or depend on the machine's state; the reply comes through a ticket.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Request {
    Enable,
    Disable,
    Mode(Mode),
    Home(Joints),
    Unhome(Joints),
    Jog(Jog),
    JogStop(Option<JogTarget>),
    Move(Move),
    /// An output that changes when the motion gets there.
    PathOutput(Output),
    Run(Run),
    Abort,
    Spindle(SpindleChange),
    /// A spindle, the angle in degrees, and the direction.
    Orient(usize, f64, i32),
    Output(Output),
    Feed(FeedChange),
    OverrideLimits,
}

/// A command in the queue to the realtime side.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Command {
    Joint(usize, JointConfig),
    Axis(usize, AxisConfig),
    Spindle(usize, SpindleConfig),
    Traj(TrajConfig),
    /// A request of a source, given in this stop epoch.
    Request(Request, MotionSource, StopEpoch, TicketHandle),
}

impl Request {
    /// Returns whether this is a step of a job of the owner of motion.
    pub(crate) const fn is_of_job(&self) -> bool {
        matches!(
            self,
            Self::Move(_)
                | Self::PathOutput(_)
                | Self::Spindle(_)
                | Self::Orient(..)
                | Self::Run(_)
        )
    }

    /// Returns the order that the safety machine decides on.
    pub(crate) const fn order(&self) -> OrderKind {
        match self {
            Self::Enable => OrderKind::Enable,
            Self::Mode(mode) => OrderKind::Mode(*mode),
            Self::Home(_) => OrderKind::Home,
            Self::Unhome(_) => OrderKind::Unhome,
            Self::Jog(Jog { target: JogTarget::Joint(_), .. }) => {
                OrderKind::Jog(hal_safety::Jog::Joint)
            }
            Self::Jog(Jog { target: JogTarget::Axis(_), .. }) => {
                OrderKind::Jog(hal_safety::Jog::Axis)
            }
            Self::Move(_) => OrderKind::Move,
            Self::PathOutput(_) => OrderKind::PathOutput,
            Self::Run(Run::Resume) => OrderKind::Resume,
            Self::Run(Run::Step) => OrderKind::Step,
            Self::Run(Run::Reverse) => OrderKind::Reverse,
            Self::Run(Run::Forward) => OrderKind::Forward,
            Self::Spindle(change) => OrderKind::Spindle {
                // A stop is for everybody.
                drives: !matches!((change.speed, change.brake), (None | Some(0.0), None)),
                turns: change.turns(),
                powers: !matches!(change.speed, None | Some(0.0)),
            },
            Self::Orient(..) => OrderKind::Orient,
            Self::Output(_) | Self::OverrideLimits => OrderKind::Setting,
            Self::Disable
            | Self::Abort
            | Self::JogStop(_)
            | Self::Feed(_)
            | Self::Run(Run::Pause) => OrderKind::Harmless,
        }
    }
}
