//! The trigger as a machine: it is fed samples and says when a capture fires and is complete.

use super::When;

/// What happens when no trigger comes, and after one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mode {
    /// One capture, and no more until it is armed again.
    #[default]
    Single,
    /// One after the other, each at its trigger.
    Normal,
    /// One after the other; if none triggers for so long (nanoseconds), one without.
    Auto(i64),
}

/// For how long after a trigger there is no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldOff {
    /// So many samples.
    Samples(u64),
    /// So many nanoseconds.
    Time(i64),
}

/// How a capture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// How many samples it has.
    pub length: u64,
    /// How many of them come before the one that triggers, which is therefore the one with this number.
    pub before: u64,
    /// What happens when no trigger comes, and after one.
    pub mode: Mode,
    /// For how long after a trigger there is no other. The samples of a capture trigger nothing anyway.
    pub hold_off: HoldOff,
}

impl Default for Setup {
    fn default() -> Self {
        Self { length: 1000, before: 0, mode: Mode::Single, hold_off: HoldOff::Samples(0) }
    }
}

impl Setup {
    /// A share of the length, from 0 to 1, comes before the trigger; at least the trigger itself does not.
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

/// Why a capture fired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Its condition holds; or it has none.
    Condition,
    /// Somebody asked for it.
    Force,
    /// No trigger came for long.
    Auto,
}

/// What a sample did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// It triggered.
    pub fired: Option<Cause>,
    /// It belongs to a capture that has fired.
    pub kept: bool,
    /// It is the last of a capture.
    pub complete: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Nothing is waited for.
    Idle,
    /// A trigger is waited for; since when, if that is known.
    Armed(Option<i64>),
    /// It came, and so many samples are still to come.
    After(u64),
}

/// A trigger. It is armed from the beginning.
#[derive(Clone, Debug)]
pub struct Trigger {
    when: Option<When>,
    setup: Setup,
    state: State,
    /// How many samples have been seen.
    seen: u64,
    /// The last trigger: how many samples had been seen, and when it was.
    last: Option<(u64, i64)>,
    is_forced: bool,
    /// The record before; room for one is there from the start.
    before: Vec<u64>,
}

impl Trigger {
    /// A trigger over records of so many values. Without a condition it fires at once.
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

    /// How it is set up.
    #[must_use]
    pub const fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The condition.
    #[must_use]
    pub const fn when(&self) -> Option<&When> {
        self.when.as_ref()
    }

    /// Waits for a trigger; a capture that is under way is given up. Samples that came before still count as those
    /// before the trigger.
    pub const fn arm(&mut self) {
        self.state = State::Armed(None);
        self.is_forced = false;
    }

    /// Waits for another condition; what was seen before stays.
    pub fn arm_for(&mut self, when: Option<When>) {
        self.when = when;
        self.arm();
    }

    /// Waits for nothing.
    pub const fn disarm(&mut self) {
        self.state = State::Idle;
        self.is_forced = false;
    }

    /// The next sample triggers, or the first that has enough before it; hold-off does not matter.
    pub const fn force(&mut self) {
        self.is_forced = true;
    }

    /// Whether a trigger is waited for.
    #[must_use]
    pub const fn is_armed(&self) -> bool {
        matches!(self.state, State::Armed(_))
    }

    /// Whether nothing is waited for.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        matches!(self.state, State::Idle)
    }

    /// The next sample: its time in nanoseconds, and the value of each channel as cells hold them.
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

    /// Counts one sample of those that are left: whether it is the last.
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
