//! Reasons for refusing an order.

/// A reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// A stop has come since the order was given.
    Stale,
    /// The machine brakes after a fault, and goes off then.
    Stops,
    /// The e-stop is active.
    Estop,
    /// The enable input is FALSE.
    EnableInput,
    /// No joint takes part.
    NoJoint,
    /// A program has motion.
    Program,
    /// A local source moves the machine.
    Local,
    /// A remote source moves the machine.
    Remote,
    /// Remote motion was ended by this order.
    Ended,
    /// A jog of a machine that is off.
    JogOff,
    /// Jogs are inhibited.
    JogInhibit,
    /// A jog during homing.
    JogHoming,
    /// A jog while the axes go back to their path.
    JogReturns,
    /// Homing of a machine that is off.
    HomeOff,
    /// Homing is inhibited.
    HomingInhibit,
    /// Homing is under way.
    Homing,
    /// A move of a machine that is off.
    MoveOff,
    /// A spindle of a machine that is off.
    SpindleOff,
    /// The mode changes while the path is paused and the axes are away from it.
    PathPaused,
    /// The mode changes while the machine moves.
    ModeMoves,
    /// A joint loses its place while the machine moves.
    UnhomeMoves,
    /// The axes have left the path.
    Away,
    /// There is no path.
    NoPath,
    /// The path resumes while an axis jogs.
    ResumeJogs,
    /// The object of the order cannot do it.
    Target,
    /// The axes or joints cannot move from where they are.
    Place,
}

impl Refused {
    /// Returns the reason in the user's words; empty where the caller knows more.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Estop | Self::Target | Self::Place => "",
            Self::Stale => "a stop has come meanwhile: give the command again",
            Self::Stops => {
                "the machine brakes after a fault and goes off: give the command again then"
            }
            Self::EnableInput => "can't enable motion, enable input is false",
            Self::NoJoint => "can't enable motion, no joint is configured, see motion.configure",
            Self::Program => "a program is in progress: motion.abort ends it",
            Self::Local => "a local source moves the machine: motion.abort ends that",
            Self::Remote => "a remote source moves the machine: motion.abort ends that",
            Self::Ended => {
                "remote motion was ended: give the command again when the machine is at rest"
            }
            Self::JogOff => "cannot jog: the machine is not enabled",
            Self::JogInhibit => "cannot jog while jog-inhibit is active",
            Self::JogHoming => "cannot jog while homing",
            Self::JogReturns => "cannot jog while the axes go back to their path",
            Self::HomeOff => "cannot home: the machine is not enabled",
            Self::HomingInhibit => "homing denied by motion.homing-inhibit",
            Self::Homing => "cannot home: homing is under way",
            Self::MoveOff => "need to be enabled, in coord mode for linear move",
            Self::SpindleOff => "the spindle cannot turn: the machine is not enabled",
            Self::PathPaused => {
                "the path is paused: motion.resume goes back to it, motion.abort ends it"
            }
            Self::ModeMoves => "the mode cannot change while the machine moves",
            Self::UnhomeMoves => "cannot unhome while the machine moves",
            Self::Away => "the axes have left the path: motion.resume goes back to it",
            Self::NoPath => "there is no path: it needs coordinated mode",
            Self::ResumeJogs => "cannot resume while an axis jogs",
        }
    }
}
