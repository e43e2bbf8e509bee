//! The trigger state machine: it receives samples and reports when a capture fires and is complete.

use super::When;

/// Behaviour without a trigger and after one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mode {
    /// A single capture. The trigger must be armed again for the next.
    #[default]
    Single,
    /// Successive captures, each at its trigger.
    Normal,
    /// Successive captures. If no trigger comes for this time (nanoseconds), a capture starts
    /// without one.
    Auto(i64),
}

/// Minimum distance between triggers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldOff {
    /// Number of samples.
    Samples(u64),
    /// Time in nanoseconds.
    Time(i64),
}

/// Settings of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// Number of samples in a capture.
    pub length: u64,
    /// Number of samples before the one that triggers. It is therefore also the index of the
    /// triggering sample.
    pub before: u64,
    /// Behaviour without a trigger and after one.
    pub mode: Mode,
    /// Minimum distance between triggers. The samples of a capture trigger nothing in any case.
    pub hold_off: HoldOff,
}

impl Default for Setup {
    fn default() -> Self {
        Self { length: 1000, before: 0, mode: Mode::Single, hold_off: HoldOff::Samples(0) }
    }
}

impl Setup {
    /// Places a share of the length (0 to 1) before the trigger. At most all samples except the
    /// triggering one come before it.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the share is between 0 and 1"
    )]
    pub fn with_share(self, share: f64) -> Self {
        let share = if (0.0..=1.0).contains(&share) { share } else { 0.0 };
        let before = (self.length as f64 * share).floor() as u64;
        Self { before: before.min(self.length.saturating_sub(1)), ..self }
    }
}

/// Reason why a capture fired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The condition holds, or there is no condition.
    Condition,
    /// The user forced it.
    Force,
    /// No trigger came for the time of [`Mode::Auto`].
    Auto,
}

/// Effect of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// The sample fired the trigger, for this reason.
    pub fired: Option<Cause>,
    /// The sample belongs to a capture that has fired.
    pub kept: bool,
    /// The sample is the last one of a capture.
    pub complete: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Not armed.
    Idle,
    /// Waiting for a trigger since this time, if it is known.
    Armed(Option<i64>),
    /// The trigger has fired; this number of samples is still to come.
    After(u64),
}

/// A trigger. It is initially armed.
#[derive(Clone, Debug)]
pub struct Trigger {
    when: Option<When>,
    setup: Setup,
    state: State,
    /// Number of samples received.
    seen: u64,
    /// Last trigger: number of samples received before it, and its time.
    last: Option<(u64, i64)>,
    is_forced: bool,
    /// Previous record. Memory for one record is allocated at the start.
    before: Vec<u64>,
}

impl Trigger {
    /// Returns a trigger for records of `width` values. Without a condition it fires at once.
    #[must_use]
    pub fn new(when: Option<When>, setup: Setup, width: usize) -> Self {
        let setup = Setup { length: setup.length.max(1), ..setup };
        let setup = Setup { before: setup.before.min(setup.length - 1), ..setup };
        Self {
            when,
            setup,
            state: State::Armed(None),
            seen: 0,
            last: None,
            is_forced: false,
            before: Vec::with_capacity(width),
        }
    }

    /// Returns the settings.
    #[must_use]
    pub const fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Returns the condition.
    #[must_use]
    pub const fn when(&self) -> Option<&When> {
        self.when.as_ref()
    }

    /// Arms the trigger and aborts the current capture. Earlier samples still count as samples
    /// before the trigger.
    pub const fn arm(&mut self) {
        self.state = State::Armed(None);
        self.is_forced = false;
    }

    /// Arms the trigger for another condition. Earlier samples still count.
    pub fn arm_for(&mut self, when: Option<When>) {
        self.when = when;
        self.arm();
    }

    /// Disarms the trigger.
    pub const fn disarm(&mut self) {
        self.state = State::Idle;
        self.is_forced = false;
    }

    /// Fires at the next sample, or at the first one that has enough samples before it. Ignores
    /// hold-off.
    pub const fn force(&mut self) {
        self.is_forced = true;
    }

    /// Returns whether the trigger is waiting for its condition.
    #[must_use]
    pub const fn is_armed(&self) -> bool {
        matches!(self.state, State::Armed(_))
    }

    /// Returns whether the trigger is disarmed.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        matches!(self.state, State::Idle)
    }

    /// Processes the next sample: its time in nanoseconds, and the value of each channel as bits of
    /// cells.
    pub fn feed(&mut self, time: i64, record: &[u64]) -> Step {
        let step = self.step(time, record);
        self.seen = self.seen.saturating_add(1);
        self.before.clear();
        self.before.extend_from_slice(record);
        step
    }

    fn step(&mut self, time: i64, record: &[u64]) -> Step {
        let left = match self.state {
            State::Idle => return Step::default(),
            State::After(left) => {
                let complete = self.count(left, time);
                return Step { fired: None, kept: true, complete };
            }
            State::Armed(since) => {
                let since = since.unwrap_or(time);
                self.state = State::Armed(Some(since));
                let Some(cause) = self.cause(since, time, record) else { return Step::default() };
                self.last = Some((self.seen, time));
                self.is_forced = false;
                (cause, self.setup.length - self.setup.before)
            }
        };
        let (cause, left) = left;
        let complete = self.count(left, time);
        Step { fired: Some(cause), kept: true, complete }
    }

    /// Counts one of the remaining samples. Returns whether it is the last one.
    const fn count(&mut self, left: u64, time: i64) -> bool {
        if left > 1 {
            self.state = State::After(left - 1);
            return false;
        }
        self.state = match self.setup.mode {
            Mode::Single => State::Idle,
            Mode::Normal | Mode::Auto(_) => State::Armed(Some(time)),
        };
        true
    }

    fn cause(&self, since: i64, time: i64, record: &[u64]) -> Option<Cause> {
        if self.seen < self.setup.before {
            return None;
        }
        if self.is_forced {
            return Some(Cause::Force);
        }
        let is_held = self.last.is_some_and(|(seen, at)| match self.setup.hold_off {
            HoldOff::Samples(n) => self.seen - seen < n,
            HoldOff::Time(ns) => time.saturating_sub(at) < ns,
        });
        if is_held {
            return None;
        }
        let before = (self.seen > 0).then_some(self.before.as_slice());
        if self.when.as_ref().is_none_or(|w| w.holds(before, record)) {
            return Some(Cause::Condition);
        }
        match self.setup.mode {
            Mode::Auto(ns) if time.saturating_sub(since) >= ns => Some(Cause::Auto),
            Mode::Single | Mode::Normal | Mode::Auto(_) => None,
        }
    }
}
