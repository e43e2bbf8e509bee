//! Time for which a client holds the virtual clock.

/// Checks of a hold that are further apart than this, in nanoseconds, are unrelated: in between,
/// nothing needed the clock to move.
const GAP_NS: i64 = 1_000_000_000;
/// Time between two looks at the client's process, in nanoseconds.
const LOOK_NS: i64 = 50_000_000;

/// Time for which a client has held the virtual clock, in wall-clock time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold {
    held_ns: i64,
    /// Part of it at the last look at the client's process.
    looked_ns: i64,
    last: Option<i64>,
}

impl Hold {
    /// A hold that has not begun.
    pub(crate) const NONE: Self = Self { held_ns: 0, looked_ns: 0, last: None };

    /// Adds the time since the last check. Returns whether the sum is now more than `patience_ns`.
    pub(crate) fn outlasts(&mut self, patience_ns: i64, now: i64) -> bool {
        let since = self.last.replace(now).map_or(0, |last| now.saturating_sub(last));
        if since <= GAP_NS {
            self.held_ns = self.held_ns.saturating_add(since);
        }
        self.held_ns > patience_ns
    }

    /// Returns whether it is time to look whether the client's process is stopped: now and then, while the clock waits.
    pub(crate) const fn looks(&mut self) -> bool {
        let is_time = self.held_ns - self.looked_ns >= LOOK_NS;
        if is_time {
            self.looked_ns = self.held_ns;
        }
        is_time
    }
}

#[cfg(test)]
mod tests {
    use super::{GAP_NS, Hold};

    const TIMEOUT_NS: i64 = 10_000_000_000;

    /// Returns the number of checks, each `step_ns` after the one before, until a hold outlasts its time.
    fn checks(step_ns: i64) -> Option<i64> {
        let mut hold = Hold::NONE;
        (1..=1000).find(|n| hold.outlasts(TIMEOUT_NS, n * step_ns))
    }

    #[test]
    fn a_hold_lasts_from_its_first_check_on_and_its_time_adds_up() {
        // The first check begins the hold, and the time itself is still allowed.
        assert_eq!(checks(GAP_NS), Some(12));
        assert_eq!(checks(GAP_NS / 10), Some(102));
        let mut hold = Hold::NONE;
        assert!(!hold.outlasts(TIMEOUT_NS, i64::MAX - 1), "however late the first check is");
    }

    #[test]
    fn the_process_is_looked_at_now_and_then_while_the_clock_waits() {
        let mut hold = Hold::NONE;
        let mut looks = |ms: i64| {
            hold.outlasts(TIMEOUT_NS, ms * 1_000_000);
            hold.looks()
        };
        let at = [0, 10, 49, 50, 51, 99, 100, 240, 241, 300].map(&mut looks);
        assert_eq!(at, [false, false, false, true, false, false, true, true, false, true]);
        // Nothing needed the clock for a while.
        assert!(!looks(60_000));
    }

    /// In between, nothing needed the clock to move.
    #[test]
    fn checks_that_are_far_apart_do_not_add_up() {
        assert_eq!(checks(GAP_NS + 1), None);
        assert_eq!(checks(100 * TIMEOUT_NS), None);
        // What was counted before is kept.
        let mut hold = Hold::NONE;
        let mut now = 0;
        let mut after = |ns| {
            now += ns;
            hold.outlasts(TIMEOUT_NS, now)
        };
        assert!((0..=10).all(|_| !after(GAP_NS)));
        assert!(!after(60 * GAP_NS));
        assert!(after(1));
    }
}
