//! The side of commands and of the task: who has the lease, which jobs were started under it, and what ends them.

use super::{Jog, OnLoss, Words};

/// Longest time from the command that starts a program to its start, in nanoseconds.
pub const START_NS: i64 = 2_000_000_000;
/// Time for which an abort lasts and then rests, in nanoseconds: the task acts on its edges.
pub const ABORT_NS: i64 = 100_000_000;

/// Progress of a program that was started under the lease.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Job {
    /// There is none.
    #[default]
    None,
    /// Commanded at this machine time, not begun yet.
    Commanded(i64),
    /// The job runs.
    Runs,
}

/// Work of motion and of the task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Something moves, or is about to.
    pub moves: bool,
    /// A program has motion, or moves wait.
    pub waits: bool,
    /// Joints are being homed.
    pub homes: bool,
    /// A job is in progress, also while it is paused.
    pub job: bool,
}

/// Reason for refusing a command of the lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// Another operator has the lease.
    Taken,
    /// The number is not that of the lease.
    NoLease,
    /// The wiring allows no remote motion.
    Forbidden,
    /// No beat is young enough for a held jog.
    NoBeat,
    /// A jog of the lease before has not ended.
    OtherJog,
    /// The job of a lost lease is being aborted.
    Aborting,
    /// A program is held.
    Held,
    /// The wiring allows no remote motion, so that a hold lasts.
    HoldLasts,
}

impl Refused {
    /// Returns the reason in the user's words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Taken => "another operator has the control lease",
            Self::NoLease => {
                "this is not the number of the control lease: it has ended, or another has it"
            }
            Self::Forbidden => "remote.allow-motion is FALSE: the machine permits no remote motion",
            Self::NoBeat => "no beat is young enough for a held jog",
            Self::OtherJog => "a jog of the lease before has not ended: wait until it has",
            Self::Aborting => "the job of a lost lease is being aborted: wait until it has ended",
            Self::Held => "a program is held since the lease was lost: remote.release ends that",
            Self::HoldLasts => "remote.allow-motion is FALSE: the hold lasts",
        }
    }
}

/// State of leases and jobs, as commands and the task know it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Desk {
    /// Number of the last lease.
    pub last: u32,
    /// Progress of the job.
    pub job: Job,
    /// Effect of a lost lease on a program whose start says nothing.
    pub preset: OnLoss,
    /// Effect on the program in progress, or on the next one.
    pub on_loss: OnLoss,
    /// True after the lease of the job was lost: what begins later ends too.
    pub orphaned: bool,
    /// True while the abort of an orphaned job lasts, false while it rests.
    pub ends: bool,
    /// Machine time at which the abort changes, in nanoseconds.
    pub ends_next: i64,
}

impl Desk {
    /// Returns a desk without a lease.
    #[must_use]
    pub fn new(preset: OnLoss) -> Self {
        Self { preset, on_loss: preset, ..Self::default() }
    }

    /// Begins a lease and returns its number. `from` is the lease that its holder hands over.
    ///
    /// # Errors
    /// [`Refused::Taken`] or [`Refused::NoLease`].
    pub fn take(&mut self, number: u32, from: Option<u32>) -> Result<u32, Refused> {
        if number != 0 && from != Some(number) {
            return Err(Refused::Taken);
        }
        if from.is_some_and(|from| from != number) {
            return Err(Refused::NoLease);
        }
        self.last = self.last.checked_add(1).unwrap_or(1);
        Ok(self.last)
    }

    /// Refuses a number that is not that of the lease.
    ///
    /// # Errors
    /// [`Refused::NoLease`].
    pub const fn check(given: u32, number: u32) -> Result<(), Refused> {
        if given != 0 && given == number { Ok(()) } else { Err(Refused::NoLease) }
    }

    /// Admits a jog, and returns its kind.
    ///
    /// # Errors
    /// The reason.
    pub fn jog(given: u32, is_held: bool, words: &Words) -> Result<Jog, Refused> {
        Self::check(given, words.number)?;
        if !words.allowed {
            return Err(Refused::Forbidden);
        }
        if is_held && !words.permit {
            return Err(Refused::NoBeat);
        }
        if words.jog != Jog::None && words.jog_lease != given {
            return Err(Refused::OtherJog);
        }
        Ok(if is_held { Jog::Held } else { Jog::Step })
    }

    /// Admits a program, a line or homing that is about to start under the lease, or to go on; returns what a lost lease does to
    /// it: what is given here, else what its start said.
    ///
    /// # Errors
    /// The reason.
    pub fn start(
        &self,
        given: u32,
        release: bool,
        on_loss: Option<OnLoss>,
        words: &Words,
    ) -> Result<OnLoss, Refused> {
        Self::check(given, words.number)?;
        if !words.allowed {
            return Err(Refused::Forbidden);
        }
        if self.orphaned && self.on_loss == OnLoss::Abort {
            return Err(Refused::Aborting);
        }
        if words.hold && !release {
            return Err(Refused::Held);
        }
        let said = if self.job == Job::None { self.preset } else { self.on_loss };
        Ok(on_loss.unwrap_or(said))
    }

    /// Returns whether a job was started under the lease.
    #[must_use]
    pub fn has_job(&self) -> bool {
        self.job != Job::None
    }

    /// Notes that the admitted program is about to be commanded.
    pub fn announced(&mut self, now_ns: i64) {
        if self.job == Job::None {
            self.job = Job::Commanded(now_ns);
        }
    }

    /// Notes that the job has a lease.
    pub const fn started(&mut self) {
        self.orphaned = false;
    }

    /// Ends a hold.
    ///
    /// # Errors
    /// [`Refused::HoldLasts`].
    pub fn release(&mut self, allowed: bool) -> Result<(), Refused> {
        if !allowed {
            return Err(Refused::HoldLasts);
        }
        self.orphaned &= self.on_loss == OnLoss::Abort;
        Ok(())
    }

    /// Notes that the lease was lost.
    pub fn lost(&mut self) {
        self.orphaned = self.job != Job::None;
    }

    /// Ends a job without a lease; returns whether motion is aborted now. Homing and the job may begin later: they wait in
    /// queues, where an abort misses them.
    pub fn end_orphan(&mut self, now_ns: i64, work: Work) -> bool {
        let aborts = self.on_loss == OnLoss::Abort;
        let works = work.job || work.waits;
        if !(self.orphaned && (work.homes || aborts && works)) {
            self.ends = false;
            self.ends_next = now_ns;
        } else if self.ends_next <= now_ns {
            self.ends = !self.ends;
            self.ends_next = now_ns + ABORT_NS;
            return self.ends;
        }
        false
    }

    /// Follows the job until its end; returns true once it is over, so that there is nothing left to hold.
    pub fn follow(&mut self, now_ns: i64, work: Work) -> bool {
        // A paused job has no claim on motion.
        let is_over = !work.moves && !work.job;
        self.job = match self.job {
            Job::None => return false,
            Job::Commanded(at) if is_over => {
                if now_ns - at <= START_NS {
                    return false;
                }
                Job::None
            }
            Job::Runs if is_over => Job::None,
            Job::Commanded(_) | Job::Runs => Job::Runs,
        };
        let has_ended = self.job == Job::None;
        if has_ended {
            (self.orphaned, self.on_loss) = (false, self.preset);
        }
        has_ended
    }

    /// Forgets a program that was announced and has not begun; returns whether there was one.
    pub const fn refuse(&mut self) -> bool {
        let is_announced = matches!(self.job, Job::Commanded(_));
        if is_announced {
            self.job = Job::None;
        }
        is_announced
    }
}
