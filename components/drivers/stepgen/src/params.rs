//! Realtime. Timing parameters of the pulses, rounded to multiples of the fast thread's period.

use crate::{handover::ASSUMED_NS, stepgen::Channel, types::StepType};
use hal_component::{Error, ParamRw, Touch, Uses};

/// Timing parameters of one channel's pulses, in nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct Params {
    len: ParamRw<u32>,
    space: Option<ParamRw<u32>>,
    hold: ParamRw<u32>,
    setup: Option<ParamRw<u32>>,
    /// True if a change of direction needs a delay.
    delayed: bool,
}

/// Values of [`Params`], in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Timing {
    /// Length of a pulse, or minimum duration of a state.
    pub(crate) len: u32,
    /// Gap between pulses.
    pub(crate) space: u32,
    /// Time for which the direction is held after a pulse.
    pub(crate) hold: u32,
    /// Time for which the direction is set before a pulse.
    pub(crate) setup: u32,
}

const LEN: &str = "Length of a step pulse, or least duration of a state where there is no pulse, \
    in ns; at least 1, and rounded up to a multiple of the period of make-pulses";
const SPACE: &str = "Least gap between two step pulses, in ns, rounded up to a multiple of the \
    period of make-pulses; 0 allows a pulse in every period, for ports that reset their pins";
const HOLD: &str = "Least time from the end of a step pulse to a change of direction, in ns, \
    rounded up to a multiple of the period of make-pulses";
const SETUP: &str = "Least time from a change of direction to the next step pulse, in ns, \
    rounded up to a multiple of the period of make-pulses";
const DELAY: &str = "Least time between a step and the next one in the other direction, in ns, \
    beyond steplen; rounded up to a multiple of the period of make-pulses";

impl Params {
    pub(crate) fn new(c: &mut Channel<'_, '_>, kind: &StepType) -> Result<Self, Error> {
        let mut item = |name, doc| c.item(name, doc, 1);
        let (delayed, directed) = match kind {
            StepType::StepDir => (true, true),
            StepType::UpDown => (true, false),
            StepType::Phases { .. } => (false, false),
        };
        Ok(Self {
            len: item("steplen", LEN)?,
            space: if delayed { Some(item("stepspace", SPACE)?) } else { None },
            hold: if directed { item("dirhold", HOLD)? } else { item("dirdelay", DELAY)? },
            setup: if directed { Some(item("dirsetup", SETUP)?) } else { None },
            delayed,
        })
    }

    /// Returns the present values.
    pub(crate) fn get(&self) -> Timing {
        Timing {
            len: self.len.get(),
            space: self.space.map_or(0, |p| p.get()),
            hold: self.hold.get(),
            setup: self.setup.map_or(0, |p| p.get()),
        }
    }

    fn set(&self, t: Timing) {
        self.len.set(t.len);
        self.hold.set(t.hold);
        if let Some(space) = &self.space {
            space.set(t.space);
        }
        if let Some(setup) = &self.setup {
            setup.set(t.setup);
        }
    }

    /// Returns rounded values. `held` says that the hold time is unchanged: then a hold time of 0 stays 0 even if the
    /// setup time has become 0 as well.
    fn rounded(&self, t: Timing, base_ns: i64, held: bool) -> Timing {
        let bare = self.delayed && t.hold == 0 && t.setup == 0 && !held;
        Timing {
            len: round_up(if t.len == 0 { 1 } else { t.len }, base_ns),
            space: round_up(t.space, base_ns),
            hold: round_up(if bare { 1 } else { t.hold }, base_ns),
            setup: round_up(t.setup, base_ns),
        }
    }
}

impl Touch for Params {
    fn touch(&self, uses: &mut Uses) {
        self.len.touch(uses);
        self.space.touch(uses);
        self.hold.touch(uses);
        self.setup.touch(uses);
    }
}

/// Rounds the parameters of one channel whenever they change.
#[derive(Debug)]
pub(crate) struct Rounder {
    params: Params,
    base_ns: Option<i64>,
    last: Timing,
}

impl Rounder {
    pub(crate) fn new(params: Params) -> Self {
        Self { params, base_ns: None, last: Timing::default() }
    }

    /// Returns the rounded values. The parameters are written only once the fast thread's period is known, so that the
    /// user's values are not rounded to a wrong period.
    pub(crate) fn check(&mut self, base_ns: Option<i64>) -> Timing {
        let now = self.params.get();
        if now != self.last || base_ns != self.base_ns {
            let held = now.hold == self.last.hold && base_ns == self.base_ns;
            self.last = self.params.rounded(now, base_ns.unwrap_or(ASSUMED_NS), held);
            self.base_ns = base_ns;
            if base_ns.is_some() {
                self.params.set(self.last);
            }
        }
        self.last
    }
}

impl Touch for Rounder {
    fn touch(&self, uses: &mut Uses) {
        self.params.touch(uses);
    }
}

/// Returns the smallest multiple of `step` that is not less than `ns`. If that does not fit, returns the largest
/// multiple that does; if none fits, returns the maximum.
fn round_up(ns: u32, step: i64) -> u32 {
    let step = if step < 1 { 1 } else { step };
    let up = i64::from(ns).saturating_add(step - 1) / step * step;
    let most = i64::from(u32::MAX) / step * step;
    let fits = if up <= most { up } else { most };
    if ns != 0 && fits == 0 { u32::MAX } else { u32::try_from(fits).unwrap_or(u32::MAX) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_up_and_fits() {
        for (ns, step, up) in [
            (0, 100, 0),
            (1, 100, 100),
            (100, 100, 100),
            (101, 100, 200),
            (31_732, 26_732, 53_464),
            (7, 1, 7),
            (7, 0, 7),
            (7, -5, 7),
            (u32::MAX, 100_000, 4_294_900_000),
            (u32::MAX, 1, u32::MAX),
            (1, 5_000_000_000, u32::MAX),
            (0, i64::MAX, 0),
        ] {
            assert_eq!(round_up(ns, step), up, "{ns} by {step}");
        }
    }
}
