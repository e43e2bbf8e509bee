//! Time for which a client holds the virtual clock.

/// Checks of a hold that are further apart than this, in nanoseconds, are unrelated: in between,
/// nothing needed the clock to move.
const GAP_NS: i64 = 1_000_000_000;

/// Time for which a client has held the virtual clock, in wall-clock time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold {
    held_ns: i64,
    last: Option<i64>,
}

impl Hold {
    /// A hold that has not begun.
    pub(crate) const NONE: Self = Self { held_ns: 0, last: None };

    /// Adds the time since the last check. Returns whether the sum is now more than `patience_ns`.
    pub(crate) fn outlasts(&mut self, patience_ns: i64, now: i64) -> bool {
        let since = self.last.replace(now).map_or(0, |last| now.saturating_sub(last));
        if since <= GAP_NS {
            self.held_ns = self.held_ns.saturating_add(since);
        }
        self.held_ns > patience_ns
    }
}
