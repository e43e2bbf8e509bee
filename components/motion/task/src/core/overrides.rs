//! Overrides of feeds, rapid moves and spindles: those of operators, unless the program forbids them.

use super::Core;
use crate::outside::{Order, Outside, Progress, Refusal};

/// Overrides of feeds and of rapid moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Feed {
    pub(crate) scale: f64,
    pub(crate) rapid: f64,
    /// True while the program lets both count.
    pub(crate) counts: bool,
}

impl Default for Feed {
    fn default() -> Self {
        Self { scale: 1.0, rapid: 1.0, counts: true }
    }
}

/// Overrides that one order sends.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scale {
    Feed,
    Rapid,
    FeedAndRapid,
    Spindle(u8),
}

/// Orders of overrides in progress.
#[derive(Clone, Debug, Default)]
pub(super) struct Orders {
    ids: Vec<u64>,
    /// Cycle of motion at which the last one was in progress, or had just ended.
    cycle: u64,
}

impl Orders {
    /// Returns whether motion's status shows the effect of all of them.
    fn are_shown(&mut self, out: &mut impl Outside) -> bool {
        let cycle = out.motion().cycle;
        if !self.ids.is_empty() {
            self.ids.retain(|id| out.ordered(*id) == Progress::Pending);
            self.cycle = cycle;
        }
        // The status may be of the cycle before the one in which the last order ended.
        self.ids.is_empty() && cycle >= self.cycle.saturating_add(2)
    }

    fn add(&mut self, sent: Result<u64, Refusal>) -> Result<bool, String> {
        match sent {
            Ok(id) => {
                self.ids.push(id);
                Ok(true)
            }
            Err(Refusal::Full) => Ok(false),
            Err(Refusal::Why(why)) => Err(why.into()),
        }
    }
}

impl Core {
    /// Makes the overrides of motion those of the task. A knob of an operator acts on motion alone, also
    /// without a task; while the program forbids overrides, it counts only after that.
    pub(super) fn follow_overrides(&mut self, out: &mut impl Outside) {
        if !self.overriding.are_shown(out) {
            return;
        }
        let motion = out.motion();
        if motion.feed_override != self.feed_in_force() {
            self.feed.scale = motion.feed_override;
            if !self.feed.counts {
                // One that is refused is sent again in the next step.
                drop(self.send_scale(Scale::Feed, out));
            }
        }
        if motion.rapid_override != self.rapid_in_force() {
            self.feed.rapid = motion.rapid_override;
            if !self.feed.counts {
                drop(self.send_scale(Scale::Rapid, out));
            }
        }
        let count = self.interpreter.state.modal.spindles.len();
        for (n, spindle) in (0..count).zip(0u8..) {
            let is = motion.spindle_override.get(n).copied().unwrap_or(1.0);
            if is == self.speed_in_force(n) {
                continue;
            }
            if let Some(scale) = self.spindle_scale.get_mut(n) {
                *scale = is;
            }
            if self.spindle_counts.get(n) == Some(&false) {
                drop(self.send_scale(Scale::Spindle(spindle), out));
            }
        }
    }

    fn feed_in_force(&self) -> f64 {
        if self.feed.counts { self.feed.scale } else { 1.0 }
    }

    /// Returns the override of rapid moves in force. What forbids the feed override forbids it too.
    fn rapid_in_force(&self) -> f64 {
        if self.feed.counts { self.feed.rapid } else { 1.0 }
    }

    fn speed_in_force(&self, spindle: usize) -> f64 {
        let counts = self.spindle_counts.get(spindle).copied().unwrap_or(true);
        self.spindle_scale.get(spindle).copied().filter(|_| counts).unwrap_or(1.0)
    }

    /// Sends overrides in force. Returns false if motion accepts no more orders now.
    pub(super) fn send_scale(
        &mut self,
        scale: Scale,
        out: &mut impl Outside,
    ) -> Result<bool, String> {
        let (feed, rapid) = (Some(self.feed_in_force()), Some(self.rapid_in_force()));
        let order = match scale {
            Scale::Feed => Order::FeedScale { feed, rapid: None },
            Scale::Rapid => Order::FeedScale { feed: None, rapid },
            Scale::FeedAndRapid => Order::FeedScale { feed, rapid },
            Scale::Spindle(spindle) => {
                Order::SpindleScale { spindle, scale: self.speed_in_force(spindle.into()) }
            }
        };
        self.overriding.add(out.order(&order, out.epoch()))
    }
}
