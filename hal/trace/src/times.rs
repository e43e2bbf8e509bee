//! Times of samples, stored as runs of equal steps.

/// Length of a tick, as a power of ten of seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimeBase(i8);

impl TimeBase {
    /// Nanoseconds, the engine's unit of time.
    pub const NANOSECONDS: Self = Self(-9);

    /// Returns the base with ticks of 10^`exponent` seconds, from -18 to 2.
    #[must_use]
    pub const fn power(exponent: i8) -> Option<Self> {
        if -18 <= exponent && exponent <= 2 { Some(Self(exponent)) } else { None }
    }

    /// Returns the power of ten.
    #[must_use]
    pub const fn exponent(self) -> i8 {
        self.0
    }

    /// Returns the unit, such as `ns` or `100 us`. The number is omitted if it is 1.
    #[must_use]
    pub fn name(self) -> String {
        let found = UNITS.iter().rev().find(|(e, _)| *e <= self.0);
        let (e, name) = found.copied().unwrap_or((-18, "as"));
        match self.0 - e {
            0 => name.to_owned(),
            more => format!("1{} {name}", "0".repeat(usize::from(more.unsigned_abs()))),
        }
    }

    /// Returns the base with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let (number, unit) = name.split_once(' ').unwrap_or(("1", name));
        let (e, _) = UNITS.iter().find(|(_, n)| *n == unit)?;
        let zeros = number.strip_prefix('1').filter(|z| z.bytes().all(|b| b == b'0'))?;
        Self::power(e.checked_add(i8::try_from(zeros.len()).ok()?)?)
    }

    /// Converts ticks to seconds.
    #[must_use]
    pub fn seconds(self, ticks: i64) -> f64 {
        let power = 10_f64.powi(i32::from(self.0).abs());
        if self.0 < 0 { ticks as f64 / power } else { ticks as f64 * power }
    }

    /// Converts ticks to microseconds.
    #[must_use]
    pub fn microseconds(self, ticks: i64) -> f64 {
        let power = 10_f64.powi(i32::from(self.0 + 6).abs());
        if self.0 < -6 { ticks as f64 / power } else { ticks as f64 * power }
    }

    /// Converts nanoseconds to ticks. Rounds down and saturates at the limits of `i64`.
    #[must_use]
    pub fn ticks(self, nanoseconds: i64) -> i64 {
        let by = 10_i128.pow(u32::from((self.0 + 9).unsigned_abs()));
        let ns = i128::from(nanoseconds);
        let exact = if self.0 < -9 { ns * by } else { ns.div_euclid(by) };
        i64::try_from(exact).unwrap_or(if exact < 0 { i64::MIN } else { i64::MAX })
    }

    /// Converts ticks to nanoseconds. Rounds down and saturates at the limits of `i64`.
    #[must_use]
    pub fn nanoseconds(self, ticks: i64) -> i64 {
        let by = 10_i128.pow(u32::from((self.0 + 9).unsigned_abs()));
        let ticks = i128::from(ticks);
        let exact = if self.0 < -9 { ticks.div_euclid(by) } else { ticks * by };
        i64::try_from(exact).unwrap_or(if exact < 0 { i64::MIN } else { i64::MAX })
    }
}

/// Units of time, and their powers of ten of seconds.
const UNITS: &[(i8, &str)] =
    &[(-18, "as"), (-15, "fs"), (-12, "ps"), (-9, "ns"), (-6, "us"), (-3, "ms"), (0, "s")];

impl Default for TimeBase {
    fn default() -> Self {
        Self::NANOSECONDS
    }
}

/// Samples at equal intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    /// Number of the first sample of the run.
    first: usize,
    at: i64,
    /// Interval in ticks. Zero while the run has one sample.
    step: i64,
}

/// Strictly increasing times of samples. Regular times take little memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Times {
    runs: Vec<Run>,
    len: usize,
}

impl Times {
    /// Returns the number of samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Returns whether there are no samples.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the time of a sample.
    #[must_use]
    pub fn get(&self, sample: usize) -> Option<i64> {
        if sample >= self.len {
            return None;
        }
        let after = self.runs.partition_point(|r| r.first <= sample);
        let run = self.runs.get(after.checked_sub(1)?)?;
        run.after(sample - run.first)
    }

    /// Returns the time of the first sample.
    #[must_use]
    pub fn first(&self) -> Option<i64> {
        self.runs.first().map(|r| r.at)
    }

    /// Returns the time of the last sample.
    #[must_use]
    pub fn last(&self) -> Option<i64> {
        let run = self.runs.last()?;
        run.after(self.len - 1 - run.first)
    }

    /// Returns the last sample at or before this time.
    #[must_use]
    pub fn until(&self, time: i64) -> Option<usize> {
        let after = self.runs.partition_point(|r| r.at <= time);
        let number = after.checked_sub(1)?;
        let run = self.runs.get(number)?;
        let end = self.runs.get(after).map_or(self.len, |next| next.first);
        let passed = i128::from(time) - i128::from(run.at);
        let steps = passed.checked_div(i128::from(run.step)).unwrap_or(0);
        let steps = usize::try_from(steps).unwrap_or(usize::MAX);
        Some(run.first + steps.min(end - 1 - run.first))
    }

    /// Returns the first sample at or after this time, or the number of samples if there is none.
    #[must_use]
    pub fn from(&self, time: i64) -> usize {
        match self.until(time) {
            None => 0,
            Some(s) if self.get(s) == Some(time) => s,
            Some(s) => s + 1,
        }
    }

    /// Returns an iterator over all times.
    pub fn iter(&self) -> impl Iterator<Item = i64> + '_ {
        let ends = self.runs.iter().skip(1).map(|r| r.first).chain([self.len]);
        self.runs
            .iter()
            .zip(ends)
            .flat_map(|(run, end)| (0..end.saturating_sub(run.first)).filter_map(|n| run.after(n)))
    }

    /// Appends a time. The caller guarantees that it is later than the last one.
    pub(crate) fn push(&mut self, time: i64) {
        let number = self.len;
        self.len += 1;
        if let Some(run) = self.runs.last_mut() {
            let n = number - run.first;
            if n == 1 && run.step == 0 {
                if let Some(step) = time.checked_sub(run.at) {
                    run.step = step;
                    return;
                }
            } else if run.after(n) == Some(time) {
                return;
            }
        }
        self.runs.push(Run { first: number, at: time, step: 0 });
    }
}

impl Run {
    /// Returns the time of the sample with this index in the run, from zero.
    fn after(self, n: usize) -> Option<i64> {
        self.step.checked_mul(i64::try_from(n).ok()?)?.checked_add(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_time_is_found_again() {
        let mut times = Times::default();
        let list = [i64::MIN, -3, 0, 25, 50, 75, 80, 100, 120, 140, 141, i64::MAX - 1, i64::MAX];
        for t in list {
            times.push(t);
        }
        assert_eq!(times.iter().collect::<Vec<_>>(), list);
        for (i, t) in list.iter().enumerate() {
            assert_eq!(times.get(i), Some(*t));
            assert_eq!((times.until(*t), times.from(*t)), (Some(i), i));
        }
        assert_eq!((times.until(49), times.from(49)), (Some(3), 4));
        assert_eq!((times.until(1000), times.from(1000)), (Some(10), 11));
        assert_eq!((times.len(), times.get(13)), (13, None));
        assert_eq!((times.first(), times.last()), (Some(i64::MIN), Some(i64::MAX)));
    }

    #[test]
    fn regular_times_take_no_room() {
        let mut times = Times::default();
        for t in 0..1_000_000 {
            times.push(t * 25_000);
        }
        assert_eq!(times.runs.len(), 1);
        assert_eq!(times.get(999_999), Some(999_999 * 25_000));
        assert_eq!(times.from(i64::MAX), 1_000_000);
        assert_eq!(times.until(-1), None);
    }

    #[test]
    fn ticks_are_seconds() {
        assert_eq!(TimeBase::NANOSECONDS.seconds(1_500_000_000), 1.5);
        assert_eq!(TimeBase::power(1).map(|b| b.seconds(3)), Some(30.0));
        assert_eq!(TimeBase::power(-12).map(|b| b.nanoseconds(-1)), Some(-1));
        assert_eq!(TimeBase::power(-3).map(|b| b.nanoseconds(7)), Some(7_000_000));
        assert_eq!(TimeBase::power(-3).map(|b| b.ticks(-7_000_001)), Some(-8));
        assert_eq!(TimeBase::power(-12).map(|b| b.ticks(i64::MIN)), Some(i64::MIN));
        assert_eq!(TimeBase::power(2).map(|b| b.nanoseconds(i64::MIN)), Some(i64::MIN));
        assert_eq!(TimeBase::power(3), None);
        for exponent in -18..=2 {
            let base = TimeBase::power(exponent).unwrap();
            assert_eq!(TimeBase::parse(&base.name()), Some(base));
        }
        assert_eq!(TimeBase::power(-4).unwrap().name(), "100 us");
        assert_eq!(
            ["", "2 s", "1x ns", "10000000000000000000000000 s"].map(TimeBase::parse),
            [None; 4]
        );
    }
}
