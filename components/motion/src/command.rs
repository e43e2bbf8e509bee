//! What commands ask of the realtime side.

use crate::config::{AxisConfig, JointConfig, TrajConfig};
use hal_component::{Pose, TicketHandle};

/// How jogs and moves are understood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Joints, one by one.
    #[default]
    Free,
    /// Axes, by jogs.
    Teleop,
    /// Axes, along a path.
    Coord,
}

/// What is jogged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// A joint.
    Joint(usize),
    /// An axis, by its place among the letters.
    Axis(usize),
}

/// How far a jog goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Far {
    /// Until it is stopped, in the direction of its velocity.
    On,
    /// So much farther than where it goes already.
    By(f64),
    /// To a position.
    To(f64),
}

/// A jog.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jog {
    pub(crate) what: What,
    pub(crate) velocity: f64,
    pub(crate) far: Far,
}

/// A coordinated move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    /// Letters that stay are not numbers.
    pub(crate) to: Pose,
    pub(crate) velocity: Option<f64>,
    pub(crate) acceleration: Option<f64>,
}

/// What `motion.feed` changes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FeedChange {
    pub(crate) scale: Option<f64>,
    pub(crate) adaptive: Option<bool>,
    pub(crate) hold: Option<bool>,
}

/// What `motion.spindle` changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpindleChange {
    pub(crate) spindle: usize,
    pub(crate) speed: Option<f64>,
    pub(crate) scale: Option<f64>,
    pub(crate) brake: Option<bool>,
}

/// What an output for programs is set to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Output {
    Digital(usize, bool),
    Analog(usize, f64),
}

/// A set of joints, one bit each.
pub(crate) type Joints = u32;

/// What takes machine time or depends on the machine's state: answered through a ticket.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ask {
    Enable,
    Disable,
    Mode(Mode),
    Home(Joints),
    Unhome(Joints),
    Jog(Jog),
    JogStop(Option<What>),
    Move(Move),
    Abort,
    Spindle(SpindleChange),
    /// A spindle, the angle in degrees, and the direction.
    Orient(usize, f64, i32),
    Output(Output),
    Feed(FeedChange),
    OverrideLimits,
}

/// A command on its way to the realtime side.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Command {
    Joint(usize, JointConfig),
    Axis(usize, AxisConfig),
    Traj(TrajConfig),
    Ask(Ask, TicketHandle),
}
