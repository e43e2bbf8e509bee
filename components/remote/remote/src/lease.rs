//! Realtime. State that the servo thread, the task and the commands share.

use std::sync::atomic::{AtomicBool, AtomicU32};

/// Kind of a remote jog that may be in progress.
pub(crate) mod jog {
    /// None.
    pub(crate) const NONE: u32 = 0;
    /// By a distance or to a position: stops with the lease.
    pub(crate) const STEP: u32 = 1;
    /// While a button is held: stops with the permit.
    pub(crate) const HELD: u32 = 2;
}

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
    /// Kind of the jog in progress, of [`jog`]. It is set before the jog is sent to motion.
    pub(crate) jog: AtomicU32,
    /// Number of the lease under which the jog began.
    pub(crate) jog_lease: AtomicU32,
    /// True while a program is in progress that was started under the lease.
    pub(crate) job: AtomicBool,
    /// True while that program is held.
    pub(crate) hold: AtomicBool,
    /// True after the lease was lost, until the task has told it.
    pub(crate) lost: AtomicBool,
    /// Age of a beat up to which a held jog is permitted, in milliseconds.
    pub(crate) jog_ms: u32,
    /// Age of a beat up to which the lease lasts, in milliseconds.
    pub(crate) lease_ms: u32,
    /// True if a lost lease holds a program.
    pub(crate) holds: bool,
}

impl Lease {
    pub(crate) const fn new(jog_ms: u32, lease_ms: u32, holds: bool) -> Self {
        Self {
            number: AtomicU32::new(0),
            permit: AtomicBool::new(false),
            allowed: AtomicBool::new(false),
            beat: AtomicU32::new(0),
            pulse: AtomicU32::new(0),
            jog: AtomicU32::new(jog::NONE),
            jog_lease: AtomicU32::new(0),
            job: AtomicBool::new(false),
            hold: AtomicBool::new(false),
            lost: AtomicBool::new(false),
            jog_ms,
            lease_ms,
            holds,
        }
    }
}
