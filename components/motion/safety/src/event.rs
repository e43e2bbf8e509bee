//! Events that a machine receives, facts that it knows at that moment, and its answers.

use crate::{Ends, Epoch, Refused};

/// Mode that determines the meaning of jogs and moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mode {
    /// Jogs move single joints.
    #[default]
    Free,
    /// Jogs move axes.
    Teleop,
    /// Moves take the axes along a path.
    Coord,
}

/// Source of an order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OrderSource {
    /// The owner of motion: a program or MDI.
    Task,
    /// An operator at the machine.
    #[default]
    Local,
    /// A remote operator.
    Remote,
}

/// Place of the axes relative to a paused path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Parked {
    /// On the path, or there is none.
    #[default]
    No,
    /// The axes have left the path.
    Away,
    /// The axes go back to the path.
    Returns,
}

/// Object of a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jog {
    /// A joint.
    Joint,
    /// An axis.
    Axis,
}

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OrderKind {
    /// Switches the machine on.
    Enable,
    /// Changes the mode.
    Mode(Mode),
    /// Homes joints.
    Home,
    /// Forgets the places of joints.
    Unhome,
    /// Jogs.
    Jog(Jog),
    /// Appends a move to the path.
    Move,
    /// Appends an output to the path.
    PathOutput,
    /// Goes on along a paused path.
    Resume,
    /// Goes on to the next move.
    Step,
    /// Goes back along the path.
    Reverse,
    /// Goes forward along the path again.
    Forward,
    /// Changes a spindle: `drives` if its speed or brake changes, `turns` if it may turn by that, `powers` if it gets a speed.
    Spindle {
        /// True if the speed or the brake changes.
        drives: bool,
        /// True if the spindle may turn by that.
        turns: bool,
        /// True if the spindle gets a speed that is not 0.
        powers: bool,
    },
    /// Orients a spindle.
    Orient,
    /// Sets an output or a tool offset, or lets a joint leave a limit switch.
    Setting,
    /// Changes nothing that begins motion: a stop that has been obeyed already, the end of a jog, factors of the feed.
    Harmless,
}

impl OrderKind {
    /// Returns the stops after which this order comes too late: those of everything that begins motion, gives power or makes
    /// motion possible.
    #[must_use]
    pub const fn ends(self) -> Ends {
        match self {
            Self::Unhome | Self::Harmless | Self::Spindle { turns: false, .. } => Ends::Never,
            Self::Enable
            | Self::Mode(_)
            | Self::Move
            | Self::PathOutput
            | Self::Spindle { .. }
            | Self::Orient
            | Self::Setting => Ends::Stops,
            Self::Jog(_)
            | Self::Home
            | Self::Resume
            | Self::Step
            | Self::Reverse
            | Self::Forward => Ends::Pauses,
        }
    }

    /// Returns the mode that this order needs in this mode, if it needs one.
    #[must_use]
    pub const fn mode(self) -> Option<Mode> {
        match self {
            Self::Mode(mode) => Some(mode),
            Self::Home | Self::Unhome | Self::Jog(Jog::Joint) => Some(Mode::Free),
            Self::Jog(Jog::Axis) => Some(Mode::Teleop),
            Self::Move => Some(Mode::Coord),
            Self::Enable
            | Self::PathOutput
            | Self::Resume
            | Self::Step
            | Self::Reverse
            | Self::Forward
            | Self::Spindle { .. }
            | Self::Orient
            | Self::Setting
            | Self::Harmless => None,
        }
    }
}

/// Reaction to a fault that need not cut the power at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reaction {
    /// The power is cut in that cycle.
    #[default]
    Drop,
    /// The joints brake within their limits, and the power is cut when they rest.
    Ramp,
}

/// Cause that switches the machine off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The e-stop is active, the enable input is FALSE, an amplifier or a spindle has a fault, a command would jump, a joint
    /// broke its limits, a homing module erred, or the process stood still.
    Hard,
    /// A limit switch is closed.
    Limit(Reaction),
    /// A following error exceeds its limit; `twice`: it has reached twice that.
    Following {
        /// Configured reaction of the joint.
        by: Reaction,
        /// True if the error has reached twice its limit.
        twice: bool,
    },
}

impl Trouble {
    /// Returns how the machine goes off.
    const fn reaction(self) -> Reaction {
        match self {
            Self::Hard | Self::Following { twice: true, .. } => Reaction::Drop,
            Self::Limit(by) | Self::Following { by, .. } => by,
        }
    }

    /// Returns whether the power must be cut at once.
    pub(crate) const fn cuts(self) -> bool {
        matches!(self.reaction(), Reaction::Drop)
    }
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// An order of a source, given in this epoch.
    Order(OrderKind, OrderSource, Epoch),
    /// The machine is commanded to go off.
    Off,
    /// All motion is commanded to end.
    Abort,
    /// All motion is commanded to pause.
    Pause,
    /// The e-stop came, or the enable input fell; told also while the machine is off.
    Cut,
    /// There is a cause to switch off in this cycle.
    Trouble(Trouble),
    /// The process stood still.
    Gap,
    /// A jog wheel has turned.
    Wheel,
    /// The pin that stops jogs has risen; `at_once` without a ramp.
    JogStop {
        /// True if jogs stop without a ramp.
        at_once: bool,
    },
    /// The probe tripped.
    Probe,
    /// A joint could not be homed.
    HomingFailed,
    /// A spindle that was turned for the path was stopped, and a feed is in progress or due.
    SpindleStopped,
    /// The axes are back on the path that they had left.
    Back,
    /// The kinematics have no place for the joints in this mode, as the machine goes on or a joint joins.
    NoPlace,
    /// A cycle has passed.
    Cycle,
}

/// Facts that a machine knows of its joints, its path and its inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// The epoch in force.
    pub epoch: Epoch,
    /// True while the e-stop is active.
    pub estop: bool,
    /// True while the enable input is TRUE.
    pub enable: bool,
    /// True while jogs are inhibited.
    pub jog_inhibit: bool,
    /// True while homing is inhibited.
    pub homing_inhibit: bool,
    /// True if a joint takes part.
    pub configured: bool,
    /// True while joints or axes jog, or brake from it.
    pub jogs: bool,
    /// True while joints are being homed.
    pub homes: bool,
    /// True while moves are in progress or wait.
    pub path: bool,
    /// True while the path is paused, rests and is not over.
    pub rests_on_path: bool,
    /// Place of the axes relative to the path.
    pub parked: Parked,
    /// True while the owner of motion keeps other sources from beginning motion.
    pub claimed: bool,
    /// True if the object of the order can do what is ordered, beside all that is decided here.
    pub target: bool,
    /// True if axes or joints can move in the mode that the order needs, from where the joints are.
    pub place: bool,
    /// True while no joint moves.
    pub rests: bool,
    /// Joints that moved in the last cycle.
    pub moving: u32,
    /// Joints whose place is known only by what they were commanded.
    pub open_loop: u32,
    /// Joints whose home is lost without power.
    pub volatile: u32,
}

/// Stop that an event causes. Later ones are stronger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stop {
    /// Nothing.
    #[default]
    None,
    /// Jogs brake.
    Jogs,
    /// Jogs stop without a ramp.
    JogsAtOnce,
    /// Homing ends, and its joints brake.
    Homing,
    /// The path rests where it comes to a stop.
    Path,
    /// Jogs brake, homing ends, and the path rests where it comes to a stop.
    Pause,
    /// Jogs brake, homing ends, and the path brakes and ends.
    Motion,
    /// Motion stops as above, the spindles stop, and the owner's claim on motion ends.
    Abort,
    /// Motion ends as in an abort, and the machine goes off when all joints rest.
    Ramp,
    /// The power is cut at once, and everything ends.
    Drop,
}

/// Change of the mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shift {
    /// None.
    #[default]
    Stay,
    /// To this mode: planners begin again where the joints are.
    To(Mode),
    /// To teleop mode, beside a paused path that stays.
    Park,
}

/// Effect of an order to resume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Resume {
    /// None: nothing is paused, or the axes go back already.
    #[default]
    No,
    /// The path goes on.
    Path,
    /// The axes go back to their path first.
    Return,
}

/// Decision of a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// Reason why the order is refused; nothing is done then but the stop.
    pub refused: Option<Refused>,
    /// Stop of motion.
    pub stop: Stop,
    /// Change of the mode.
    pub shift: Shift,
    /// True if the machine goes on.
    pub powers: bool,
    /// Effect of an order to resume.
    pub resume: Resume,
    /// True if the path rests with this move, which was given before a pause.
    pub rests_late: bool,
    /// True if the stop epoch rises.
    pub raises: bool,
    /// True if the number of pauses in it rises.
    pub pauses: bool,
    /// Joints that are no longer homed.
    pub unhome: u32,
}

impl Answer {
    pub(crate) const OK: Self = Self {
        refused: None,
        stop: Stop::None,
        shift: Shift::Stay,
        powers: false,
        resume: Resume::No,
        rests_late: false,
        raises: false,
        pauses: false,
        unhome: 0,
    };

    pub(crate) const fn refuse(why: Refused) -> Self {
        Self { refused: Some(why), ..Self::OK }
    }

    pub(crate) const fn stop(stop: Stop) -> Self {
        Self { stop, ..Self::OK }
    }
}
