//! Reasons for refusing an order.

/// Makes [`Refused`] of rows: meaning, name, and the reason in the user's words; empty where the caller knows more.
macro_rules! reasons {
    ($($(#[doc = $doc:literal])+ $name:ident => $text:literal,)+) => {
        /// A reason.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Refused {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Refused {
            /// All reasons.
            pub const ALL: &[Self] = &[$(Self::$name),+];

            /// Returns the reason in the user's words; empty where the caller knows more.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)+
                }
            }
        }
    };
}

reasons! {
    /// A stop has come since the order was given.
    Stale => "a stop has come meanwhile: give the command again",
    /// The machine brakes after a fault, and goes off then.
    Stops => "the machine brakes after a fault and goes off: give the command again then",
    /// The e-stop is active.
    Estop => "",
    /// The enable input is FALSE.
    EnableInput => "can't enable motion, enable input is false",
    /// No joint takes part.
    NoJoint => "can't enable motion, no joint is configured, see motion.configure",
    /// A program has motion.
    Program => "a program is in progress: motion.abort ends it",
    /// A local source moves the machine.
    Local => "a local source moves the machine: motion.abort ends that",
    /// A remote source moves the machine.
    Remote => "a remote source moves the machine: motion.abort ends that",
    /// Remote motion was ended by this order.
    Ended => "remote motion was ended: give the command again when the machine is at rest",
    /// A jog of a machine that is off.
    JogOff => "cannot jog: the machine is not enabled",
    /// Jogs are inhibited.
    JogInhibit => "cannot jog while jog-inhibit is active",
    /// A jog during homing.
    JogHoming => "cannot jog while homing",
    /// A jog while the axes go back to their path.
    JogReturns => "cannot jog while the axes go back to their path",
    /// Homing of a machine that is off.
    HomeOff => "cannot home: the machine is not enabled",
    /// Homing is inhibited.
    HomingInhibit => "homing denied by motion.homing-inhibit",
    /// Homing is under way.
    Homing => "cannot home: homing is under way",
    /// A move of a machine that is off.
    MoveOff => "need to be enabled, in coord mode for linear move",
    /// A spindle of a machine that is off.
    SpindleOff => "the spindle cannot turn: the machine is not enabled",
    /// The mode changes while the path is paused and the axes are away from it.
    PathPaused => "the path is paused: motion.resume goes back to it, motion.abort ends it",
    /// The mode changes while the machine moves.
    ModeMoves => "the mode cannot change while the machine moves",
    /// A joint loses its place while the machine moves.
    UnhomeMoves => "cannot unhome while the machine moves",
    /// The axes have left the path.
    Away => "the axes have left the path: motion.resume goes back to it",
    /// There is no path.
    NoPath => "there is no path: it needs coordinated mode",
    /// The path resumes while an axis jogs.
    ResumeJogs => "cannot resume while an axis jogs",
    /// The object of the order cannot do it.
    Target => "",
    /// The axes or joints cannot move from where they are.
    Place => "",
}
