//! Realtime. The e-stop as iocontrol has it: while it lasts, the machine is off and stays off.

use crate::refusal::Refusal;
use hal_component::{Builder, Error, InterlockRef, Touch};

/// The interlock; none where a script keeps its own wiring.
#[derive(Debug, Touch)]
pub(crate) struct Interlock {
    found: Option<InterlockRef>,
}

/// The part of the e-stop that keeps the machine off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lockout {
    /// It is commanded.
    Commanded,
    /// The chain of contacts is open.
    Open,
}

impl Interlock {
    /// Finds the interlock. A machine from an INI file is not loaded without one.
    pub(crate) fn bind(b: &mut Builder<'_>) -> Result<Self, Error> {
        let found = b.interlock()?;
        if found.is_none() && b.needs_interlock() {
            return Err(Error::new(
                "a machine from an INI file needs the e-stop of iocontrol, which is not loaded: \
                 loadrt iocontrol first",
            ));
        }
        Ok(Self { found })
    }

    /// Reads it, once in each cycle.
    pub(crate) fn read(&self) -> Option<Lockout> {
        let estop = self.found.as_ref()?.state();
        match (estop.commanded, estop.open) {
            (true, _) => Some(Lockout::Commanded),
            (false, true) => Some(Lockout::Open),
            (false, false) => None,
        }
    }
}

impl Lockout {
    /// Why the machine goes off.
    pub(crate) const fn cause(self) -> &'static str {
        match self {
            Self::Commanded => "motion stopped by e-stop: it was commanded by iocontrol.estop",
            Self::Open => "motion stopped by e-stop: {iocontrol.0.emc-enable-in} is FALSE",
        }
    }

    /// Why the machine is not switched on.
    pub(crate) const fn refusal(self) -> Refusal {
        Refusal::new(match self {
            Self::Commanded => {
                "can't enable motion, the machine is in e-stop: iocontrol.estop-reset ends it, \
                 and {iocontrol.0.emc-enable-in} must then be TRUE"
            }
            Self::Open => {
                "can't enable motion, the machine is in e-stop: {iocontrol.0.emc-enable-in} is \
                 FALSE. It ends when that is TRUE; iocontrol.estop-reset resets a latch in the \
                 chain"
            }
        })
    }
}
