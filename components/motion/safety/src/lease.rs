//! The lease of remote operators, and the dead man of their jogs.
//!
//! Two threads share the [`Words`]: the servo thread judges the beats ([`Judge`]), and commands and a task follow what moves
//! ([`Desk`]). Each of their functions takes what it reads and returns what is to be written.

mod desk;

pub use desk::{ABORT_NS, Desk, Job, Refused, START_NS, Work};

/// Effect of a lost lease on a program that was started under it, which its start may say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OnLoss {
    /// The program is held.
    #[default]
    Hold,
    /// The program goes on.
    Continue,
    /// The program is held, and ended.
    Abort,
}

/// Settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Rules {
    /// Age of a beat up to which a held jog is permitted, in milliseconds.
    pub jog_ms: u32,
    /// Age of a beat up to which the lease lasts, in milliseconds.
    pub lease_ms: u32,
}

/// Kind of a remote jog that may be in progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Jog {
    /// None.
    #[default]
    None,
    /// By a distance or to a position: stops with the lease.
    Step,
    /// While a button is held: stops with the permit.
    Held,
}

/// State that the servo thread, the task and the commands share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Words {
    /// Number of the lease; 0 without one.
    pub number: u32,
    /// True while a held jog is permitted.
    pub permit: bool,
    /// True while the wiring allows motion.
    pub allowed: bool,
    /// Kind of the jog in progress.
    pub jog: Jog,
    /// Number of the lease under which the jog began.
    pub jog_lease: u32,
    /// True while a program is in progress that was started under the lease.
    pub job: bool,
    /// True while that program is held.
    pub hold: bool,
    /// True if a lost lease holds the program in progress, or the next one.
    pub holds: bool,
}

impl OnLoss {
    const ALL: [Self; 3] = [Self::Hold, Self::Continue, Self::Abort];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Continue => "continue",
            Self::Abort => "abort",
        }
    }

    /// Returns the effect of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|loss| loss.name() == name)
    }

    /// Returns whether the program is held. What ends holds too, until it has ended.
    #[must_use]
    pub const fn holds(self) -> bool {
        !matches!(self, Self::Continue)
    }
}

impl Words {
    /// Returns whether the loss of the lease holds a program.
    #[must_use]
    pub const fn loses(&self) -> bool {
        self.job && self.holds
    }
}

/// Judgement of the beats, in the servo thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Judge {
    /// Number of the lease in the cycle before.
    pub lease: u32,
    /// Machine time at which this lease was first seen, in milliseconds.
    pub taken: u32,
    /// Beat in the cycle before.
    pub beat: u32,
    /// True once a beat has arrived under this lease.
    pub beats: bool,
    /// Value of `allow-motion` in the cycle before.
    pub allowed: bool,
    /// Value of `jog-stop` in the cycle before: motion acts on its edges.
    pub stops: bool,
}

/// Result of judging the beats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// True if the lease ends.
    pub ends: bool,
    /// True while beats keep the lease.
    pub beats: bool,
    /// True while a held jog is permitted.
    pub permit: bool,
}

impl Judge {
    /// Judges the beats of the lease `number` at a machine time. Of the two beats the younger one counts: a page answers by the
    /// pin, another program by a command.
    pub fn beats(
        &mut self,
        now: u32,
        beats: [u32; 2],
        allowed: bool,
        number: u32,
        rules: &Rules,
    ) -> Judgement {
        let [pin, command] = beats;
        let is_pin = now.wrapping_sub(pin) <= now.wrapping_sub(command);
        let beat = if is_pin { pin } else { command };
        if number != self.lease {
            (self.lease, self.taken, self.beats) = (number, now, false);
        }
        if beat != self.beat {
            self.beat = beat;
            // A pulse of this lease's first millisecond, or an older one, may have left under the lease before.
            self.beats |= beat.wrapping_sub(self.taken).cast_signed() > 0;
        }
        // A number from the future has a great age.
        let age = now.wrapping_sub(beat);
        let beats = self.beats && age <= rules.lease_ms;
        let permit = number != 0 && allowed && beats && age <= rules.jog_ms;
        let awaits_first = !self.beats && now.wrapping_sub(self.taken) <= rules.lease_ms;
        Judgement { ends: number != 0 && !beats && !awaits_first, beats, permit }
    }

    /// Notes whether the wiring allows motion; returns whether that has ended, under a lease or with a job.
    pub const fn forbids(&mut self, allowed: bool, number: u32, job: bool) -> bool {
        let falls = self.allowed && !allowed && (number != 0 || job);
        self.allowed = allowed;
        falls
    }

    /// Returns the value of `jog-stop`. It has edges again and again, because a jog may still be on its way to motion.
    pub fn jog_stop(
        &mut self,
        jog: Jog,
        of: u32,
        number: u32,
        allowed: bool,
        permit: bool,
    ) -> bool {
        let lasts = number != 0 && number == of && allowed;
        let ends = match jog {
            Jog::None => false,
            Jog::Step => !lasts,
            Jog::Held => !(lasts && permit),
        };
        self.stops = ends && !self.stops;
        self.stops
    }
}
