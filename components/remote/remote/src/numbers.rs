//! Numbers of leases: none comes back, whatever has been loaded again meanwhile.

use hal_component::Clock;
use std::sync::atomic::{AtomicI64, AtomicU32, Ordering::Relaxed};

/// Leases of a second that a process before this one may have given, on average, without a number that comes back.
const EACH_SECOND: u32 = 64;

/// The last lease that this process has given.
#[derive(Debug, Default)]
struct Given {
    /// Number of the lease; 0 before the first one.
    number: AtomicU32,
    /// Machine time of the lease's beginning, in nanoseconds.
    at: AtomicI64,
}

/// Returns the number of the last lease that was given before this plugin was loaded. A library stays mapped, so a plugin that
/// is loaded again goes on behind the one before. A new process goes on behind the clock: on the real one, behind all
/// processes since the computer has started. So does a new engine of the same process, whose virtual clock is behind
/// that of the engine before: its numbers are those of a process of its own.
pub(crate) fn last(clock: Clock) -> u32 {
    let now = clock.now_ns();
    // Relaxed: commands of one plugin at a time read and write them, and the engine executes them one after the other.
    match given().number.load(Relaxed) {
        last if last != 0 && now >= given().at.load(Relaxed) => last,
        _ => u32::try_from(now / 1_000_000_000).unwrap_or(0).wrapping_mul(EACH_SECOND),
    }
}

/// Notes that a lease was given.
pub(crate) fn note(clock: Clock, number: u32) {
    given().number.store(number, Relaxed);
    given().at.store(clock.now_ns(), Relaxed);
}

/// Returns the last lease of this process.
#[cfg(not(test))]
const fn given() -> &'static Given {
    static GIVEN: Given = Given { number: AtomicU32::new(0), at: AtomicI64::new(0) };
    &GIVEN
}

#[cfg(test)]
std::thread_local! {
    /// The last lease of each test: tests are processes of their own in this respect.
    static GIVEN: core::cell::Cell<&'static Given> = core::cell::Cell::new(fresh());
}

#[cfg(test)]
fn fresh() -> &'static Given {
    Box::leak(Box::default())
}

#[cfg(test)]
fn given() -> &'static Given {
    GIVEN.get()
}

/// Begins as a new process does.
#[cfg(test)]
pub(crate) fn begin_anew() {
    GIVEN.set(fresh());
}
