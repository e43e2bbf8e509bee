//! Realtime. Waiting of functions that end pulses.

use hal_component::{Clock, ParamRw, Period};

/// Returns the nanoseconds between a write and its reset, at most a quarter of the period; sets the parameter to that if it
/// is longer.
#[must_use]
pub fn reset_time(time: ParamRw<u32>, period: Period) -> u32 {
    let quarter = period.ns() / 4;
    let most = u32::try_from(quarter).unwrap_or(if quarter < 0 { 0 } else { u32::MAX });
    if time.get() > most {
        time.set(most);
    }
    time.get()
}

/// Waits on a real clock until `wait` nanoseconds after `since`. Each reading of the clock takes at least a nanosecond,
/// so the loop is bounded even if the clock stands still.
pub fn pause(clock: Clock, since: i64, wait: u32) {
    if clock.is_virtual() {
        return;
    }
    for _ in 0..wait {
        if clock.now_ns().wrapping_sub(since) >= i64::from(wait) {
            return;
        }
        core::hint::spin_loop();
    }
}
