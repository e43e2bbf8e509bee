//! Realtime. Time for which a worker has stood still.

/// Watch over a worker by the number of its steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct StillWatch(Option<(u32, i64)>);

impl StillWatch {
    /// Returns a watch that has not looked yet.
    #[must_use]
    pub const fn new() -> Self {
        Self(None)
    }

    /// Returns the time since the number of steps last changed, in nanoseconds; 0 at the first look.
    pub const fn still_ns(&mut self, steps: u32, now_ns: i64) -> i64 {
        match self.0 {
            Some((seen, since)) if seen == steps => now_ns.saturating_sub(since),
            _ => {
                self.0 = Some((steps, now_ns));
                0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::StillWatch;

    #[test]
    fn time_counts_from_the_last_step() {
        let mut watch = StillWatch::default();
        // (steps, now, still for)
        for (steps, now, still) in
            [(7, 100, 0), (7, 150, 50), (8, 160, 0), (8, 161, 1), (7, 170, 0), (7, 169, -1)]
        {
            assert_eq!(watch.still_ns(steps, now), still, "{now}");
        }
    }
}
