//! Realtime. The e-stop of iocontrol: while it is active, the machine is off and stays off.

use crate::commands::refusal::Refusal;
use hal_component::{Builder, Error, InterlockRef, Touch};

/// The interlock; absent where a script keeps its own wiring.
#[derive(Debug, Touch)]
pub(crate) struct Interlock {
    found: Option<InterlockRef>,
}

/// Condition of the e-stop that keeps the machine off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lockout {
    /// The e-stop is commanded.
    Commanded,
    /// The e-stop chain is open.
    Open,
}

impl Interlock {
    /// Binds the interlock. A machine from an INI file is not loaded without one.
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

    /// Returns whether there is an interlock.
    pub(crate) const fn is_bound(&self) -> bool {
        self.found.is_some()
    }

    /// Reads the interlock, once in each cycle.
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
    /// Returns the cause for switching the machine off.
    pub(crate) const fn cause(self) -> &'static str {
        match self {
            Self::Commanded => "motion stopped by e-stop: it was commanded by iocontrol.estop",
            Self::Open => "motion stopped by e-stop: {iocontrol.0.emc-enable-in} is FALSE",
        }
    }

    /// Returns the refusal to switch the machine on.
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
