//! Numbers of leases: none comes back, whatever has been loaded again meanwhile.

use hal_component::Clock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Leases of a second that a process before this one may have given, on average, without a number that comes back.
const EACH_SECOND: u32 = 64;

/// Returns the number of the last lease that was given before this plugin was loaded. A library stays mapped, so a plugin that
/// is loaded again goes on behind the one before. A new process goes on behind the clock: on the real one, behind all
/// processes since the computer has started.
pub(crate) fn last(clock: Clock) -> u32 {
    // Relaxed: commands of one plugin at a time read and write it, and the engine executes them one after the other.
    match given().load(Relaxed) {
        0 => {
            let seconds = clock.now_ns() / 1_000_000_000;
            u32::try_from(seconds).unwrap_or(0).wrapping_mul(EACH_SECOND)
        }
        last => last,
    }
}

/// Notes that a lease was given.
pub(crate) fn note(number: u32) {
    given().store(number, Relaxed);
}

/// Returns the number of the last lease of this process; 0 before the first one.
#[cfg(not(test))]
const fn given() -> &'static AtomicU32 {
    static GIVEN: AtomicU32 = AtomicU32::new(0);
    &GIVEN
}

#[cfg(test)]
std::thread_local! {
    /// The number of each test: tests are processes of their own in this respect.
    static GIVEN: core::cell::Cell<&'static AtomicU32> = core::cell::Cell::new(fresh());
}

#[cfg(test)]
fn fresh() -> &'static AtomicU32 {
    Box::leak(Box::new(AtomicU32::new(0)))
}

#[cfg(test)]
fn given() -> &'static AtomicU32 {
    GIVEN.get()
}

/// Begins as a new process does.
#[cfg(test)]
pub(crate) fn begin_anew() {
    GIVEN.set(fresh());
}
