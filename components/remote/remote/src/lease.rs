//! Realtime. State that the servo thread, the task and the commands share: the words on which `hal_safety::lease` decides.

pub(crate) use hal_safety::lease::OnLoss as Loss;
use hal_safety::lease::{Jog, Rules, Words};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

/// The lease. Each value stands alone: none publishes another.
#[derive(Debug)]
pub(crate) struct Lease {
    /// Number of the lease; 0 without one.
    pub(crate) number: AtomicU32,
    /// True while a held jog is permitted.
    pub(crate) permit: AtomicBool,
    /// True while the wiring allows motion.
    pub(crate) allowed: AtomicBool,
    /// Number of a pulse that `remote.beat` has sent back.
    pub(crate) beat: AtomicU32,
    /// Number of the last pulse.
    pub(crate) pulse: AtomicU32,
    /// Kind of the jog in progress, as the number of a [`Jog`]. It is set before the jog is sent to motion.
    pub(crate) jog: AtomicU32,
    /// Number of the lease under which the jog began.
    pub(crate) jog_lease: AtomicU32,
    /// True while a program is in progress that was started under the lease.
    pub(crate) job: AtomicBool,
    /// True while that program is held.
    pub(crate) hold: AtomicBool,
    /// True after the lease was lost, until the task has told it.
    pub(crate) lost: AtomicBool,
    /// Settings.
    pub(crate) rules: Rules,
    /// True if a lost lease holds the program in progress, or the next one.
    pub(crate) holds: AtomicBool,
}

impl Lease {
    pub(crate) const fn new(rules: Rules) -> Self {
        Self {
            number: AtomicU32::new(0),
            permit: AtomicBool::new(false),
            allowed: AtomicBool::new(false),
            beat: AtomicU32::new(0),
            pulse: AtomicU32::new(0),
            jog: AtomicU32::new(Jog::None as u32),
            jog_lease: AtomicU32::new(0),
            job: AtomicBool::new(false),
            hold: AtomicBool::new(false),
            lost: AtomicBool::new(false),
            rules,
            holds: AtomicBool::new(true),
        }
    }

    /// Returns the kind of the jog in progress.
    pub(crate) fn jog(&self) -> Jog {
        let kind = self.jog.load(Relaxed);
        let known = [Jog::None, Jog::Step];
        // Of a jog of which nothing else is known, the strictest rule holds.
        known.into_iter().find(|jog| *jog as u32 == kind).unwrap_or(Jog::Held)
    }

    /// Returns the words.
    pub(crate) fn words(&self) -> Words {
        Words {
            number: self.number.load(Relaxed),
            permit: self.permit.load(Relaxed),
            allowed: self.allowed.load(Relaxed),
            jog: self.jog(),
            jog_lease: self.jog_lease.load(Relaxed),
            job: self.job.load(Relaxed),
            hold: self.hold.load(Relaxed),
            holds: self.holds.load(Relaxed),
        }
    }

    /// Notes that the lease was lost: a program that was started under it is held, if its start said so.
    pub(crate) fn lose(&self) {
        self.lost.store(true, Relaxed);
        if self.words().loses() {
            self.hold.store(true, Relaxed);
        }
    }
}
