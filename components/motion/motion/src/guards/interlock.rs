//! Realtime. The e-stop of iocontrol, and hardware that a driver has lost: meanwhile the machine is off and stays off.

use crate::commands::refusal::Refusal;
use hal_component::{Builder, Error, Failures, Hardware, InterlockRef, Touch};

/// The interlock; absent where a script keeps its own wiring.
#[derive(Debug, Touch)]
pub(crate) struct Interlock {
    found: Option<InterlockRef>,
    hardware: Hardware,
}

/// Condition of the e-stop that keeps the machine off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lockout {
    /// The e-stop is commanded.
    Commanded,
    /// The e-stop chain is open.
    Open,
    /// A driver has lost its hardware.
    Hardware,
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
        Ok(Self { found, hardware: b.hardware() })
    }

    /// Returns whether there is an interlock.
    pub(crate) const fn is_bound(&self) -> bool {
        self.found.is_some()
    }

    /// Returns the failures of the drivers' hardware, once in each cycle.
    pub(crate) fn failures(&self) -> Failures {
        self.hardware.failures()
    }

    /// Reads the interlock, once in each cycle. `is_lost` is true if hardware has failed since the last one.
    pub(crate) fn read(&self, is_lost: bool) -> Option<Lockout> {
        let estop = self.found.as_ref().map(InterlockRef::state);
        match estop.map(|estop| (estop.commanded, estop.open)) {
            Some((true, _)) => Some(Lockout::Commanded),
            Some((false, true)) => Some(Lockout::Open),
            _ if is_lost => Some(Lockout::Hardware),
            _ => None,
        }
    }
}

impl Lockout {
    /// Returns whether the e-stop keeps the machine off.
    pub(crate) const fn is_estop(self) -> bool {
        matches!(self, Self::Commanded | Self::Open)
    }

    /// Returns the cause for switching the machine off.
    pub(crate) const fn cause(self) -> &'static str {
        match self {
            Self::Commanded => "motion stopped by e-stop: it was commanded by iocontrol.estop",
            Self::Open => "motion stopped by e-stop: {iocontrol.0.emc-enable-in} is FALSE",
            Self::Hardware => {
                "motion stopped: a driver has lost its hardware, which its own message names"
            }
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
            Self::Hardware => {
                "can't enable motion, a driver has lost its hardware: its own message names it and \
                 what to do"
            }
        })
    }
}
