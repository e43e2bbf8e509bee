//! Samples of a number of channels.

use crate::{Channel, TimeBase, Times};
use hal_protocol::{Type, Value};

/// Lost samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// Number of the sample before which they are missing. Equal to the number of samples if they
    /// are missing at the end.
    pub sample: usize,
    /// Number of lost samples.
    pub lost: u64,
}

/// A text at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Marker {
    /// Time in ticks.
    pub at: i64,
    /// The text.
    pub text: String,
}

/// Reason why a trace refuses a sample or value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The sample is not later than the last one.
    Backwards {
        /// Time of the sample.
        at: i64,
        /// Time of the last sample.
        last: i64,
    },
    /// More than four billion samples.
    Full,
    /// The channel does not exist, or there is no sample yet.
    Nowhere,
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Backwards { at, last } => write!(f, "time goes from {last} to {at}"),
            Self::Full => write!(f, "a trace holds 4294967295 samples and no more"),
            Self::Nowhere => write!(f, "a value without a channel or a sample"),
        }
    }
}

impl core::error::Error for Refusal {}

/// Samples of a number of channels; see the crate documentation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trace {
    base: TimeBase,
    channels: Vec<Channel>,
    times: Times,
    gaps: Vec<Gap>,
    markers: Vec<Marker>,
}

impl Trace {
    /// Returns a trace without channels and samples.
    #[must_use]
    pub fn new(base: TimeBase) -> Self {
        Self { base, ..Self::default() }
    }

    /// Returns the length of a tick.
    #[must_use]
    pub const fn base(&self) -> TimeBase {
        self.base
    }

    /// Sets the length of a tick, before or after samples are added.
    pub(crate) const fn set_base(&mut self, base: TimeBase) {
        self.base = base;
    }

    /// Adds a channel and returns its number. Its values at existing samples are unknown.
    pub fn add(&mut self, name: &str, ty: Type) -> usize {
        self.channels.push(Channel::new(name, ty));
        self.channels.len() - 1
    }

    /// Adds another name to a channel.
    pub fn also(&mut self, channel: usize, name: &str) {
        if let Some(c) = self.channels.get_mut(channel) {
            c.also(name);
        }
    }

    /// Returns the channels in order of their numbers.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Returns the number of the channel with this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|c| c.names().iter().any(|n| n == name))
    }

    /// Returns the times of the samples.
    #[must_use]
    pub const fn times(&self) -> &Times {
        &self.times
    }

    /// Returns the number of samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.times.len()
    }

    /// Returns whether there are no samples.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Returns the gaps, in order of their samples.
    #[must_use]
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// Returns the total number of lost samples.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.gaps.iter().fold(0, |n, g| n.saturating_add(g.lost))
    }

    /// Returns the markers in order of time.
    #[must_use]
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// Returns the value of a channel at a sample.
    #[must_use]
    pub fn value(&self, channel: usize, sample: usize) -> Option<Value> {
        if sample >= self.len() {
            return None;
        }
        self.channels.get(channel)?.value(sample)
    }

    /// Returns the value of a channel at a time, which is its value at the last sample at or before
    /// that time.
    #[must_use]
    pub fn at(&self, channel: usize, time: i64) -> Option<Value> {
        self.value(channel, self.times.until(time)?)
    }

    /// Adds a sample at which every channel keeps its value.
    ///
    /// # Errors
    /// The sample is not later than the last one, or there are too many samples.
    pub fn sample(&mut self, time: i64) -> Result<(), Refusal> {
        if let Some(last) = self.times.last().filter(|last| time <= *last) {
            return Err(Refusal::Backwards { at: time, last });
        }
        if self.times.len() >= u32::MAX as usize {
            return Err(Refusal::Full);
        }
        self.times.push(time);
        Ok(())
    }

    /// Sets the value of a channel from the last sample on.
    ///
    /// # Errors
    /// The channel does not exist, or there is no sample yet.
    pub fn set(&mut self, channel: usize, value: Value) -> Result<(), Refusal> {
        self.set_bits(channel, Some(value.bits()))
    }

    /// Sets the value from the bits of a cell of the channel's type. `None` means unknown.
    ///
    /// # Errors
    /// The channel does not exist, or there is no sample yet.
    pub fn set_bits(&mut self, channel: usize, bits: Option<u64>) -> Result<(), Refusal> {
        let last = self.times.len().checked_sub(1).and_then(|n| u32::try_from(n).ok());
        match (last, self.channels.get_mut(channel)) {
            (Some(sample), Some(c)) => {
                c.set(sample, bits);
                Ok(())
            }
            _ => Err(Refusal::Nowhere),
        }
    }

    /// Adds a sample with the value of every channel, as bits of cells.
    ///
    /// # Errors
    /// The sample is not later than the last one, or there are too many samples.
    pub fn push(&mut self, time: i64, record: &[u64]) -> Result<(), Refusal> {
        self.sample(time)?;
        for (channel, bits) in record.iter().enumerate() {
            self.set_bits(channel, Some(*bits))?;
        }
        Ok(())
    }

    /// Records that `lost` samples are missing before the next one.
    pub fn lose(&mut self, lost: u64) {
        let sample = self.len();
        match self.gaps.last_mut() {
            _ if lost == 0 => {}
            Some(g) if g.sample == sample => g.lost = g.lost.saturating_add(lost),
            _ => self.gaps.push(Gap { sample, lost }),
        }
    }

    /// Records that `lost` samples are missing before the sample with this number.
    pub(crate) fn lost_before(&mut self, sample: usize, lost: u64) {
        let place = self.gaps.partition_point(|g| g.sample <= sample);
        self.gaps.insert(place, Gap { sample, lost });
    }

    /// Adds a marker. An empty text is ignored.
    pub fn mark(&mut self, at: i64, text: &str) {
        if text.is_empty() {
            return;
        }
        let place = self.markers.partition_point(|m| m.at <= at);
        self.markers.insert(place, Marker { at, text: text.to_owned() });
    }

    /// Returns the part from `from` up to but not including `to`. If no sample was taken at `from`,
    /// the part begins with a sample that has the values held at that time.
    #[must_use]
    pub fn between(&self, from: i64, to: i64) -> Self {
        let mut part = Self::new(self.base);
        let held = self.times.until(from).filter(|_| from < to);
        let first = self.times.from(from);
        let end = self.times.from(to).max(first);
        // Maps a sample number of the whole trace to the part.
        let is_early = held.is_some_and(|h| h < first);
        let moved = |sample: usize| sample - first + usize::from(is_early);
        if is_early {
            part.times.push(from);
        }
        (first..end).filter_map(|s| self.times.get(s)).for_each(|t| part.times.push(t));
        for c in &self.channels {
            let mut copy = Channel::new(c.name(), c.ty());
            c.names().iter().skip(1).for_each(|name| copy.also(name));
            let mut set = |sample: usize, value: Option<Value>| {
                if let Ok(sample) = u32::try_from(sample) {
                    copy.set(sample, value.map(|v| v.bits()));
                }
            };
            if !part.times.is_empty() {
                set(0, c.value(held.unwrap_or(first)));
            }
            let changes = c.changes_before(first)..c.changes_before(end);
            changes.filter_map(|n| c.change(n)).for_each(|c| set(moved(c.sample), c.value));
            part.channels.push(copy);
        }
        let last = if end == self.len() { end } else { end.saturating_sub(1) };
        let inside =
            |g: &&Gap| first <= g.sample && g.sample <= last && (moved(g.sample) > 0 || first == 0);
        let gaps = self.gaps.iter().filter(inside);
        part.gaps.extend(gaps.map(|g| Gap { sample: moved(g.sample), lost: g.lost }));
        part.markers.extend(self.markers.iter().filter(|m| from <= m.at && m.at < to).cloned());
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_keeps_its_changes() {
        let mut t = Trace::default();
        let (b, f) = (t.add("b", Type::Bit), t.add("f", Type::Float));
        assert_eq!(t.set(b, Value::Bit(true)), Err(Refusal::Nowhere));
        t.sample(10).unwrap();
        t.set(b, Value::Bit(true)).unwrap();
        assert_eq!((t.value(b, 0), t.value(f, 0)), (Some(Value::Bit(true)), None));
        assert_eq!((t.at(b, 9), t.at(b, 10)), (None, Some(Value::Bit(true))));
        assert_eq!(t.sample(10), Err(Refusal::Backwards { at: 10, last: 10 }));
        t.push(20, &[256, (-f64::NAN).to_bits()]).unwrap();
        assert_eq!(t.value(b, 1), Some(Value::Bit(false)), "the low byte is the bit");
        assert_eq!(t.value(f, 1), Some(Value::Float(f64::NAN)));
        t.push(30, &[0, f64::NAN.to_bits()]).unwrap();
        assert_eq!((t.channels()[b].len(), t.channels()[f].len()), (2, 1));
        t.set(b, Value::Bit(true)).unwrap();
        t.set(b, Value::Bit(false)).unwrap();
        assert_eq!(t.channels()[b].len(), 2, "what is taken back is no change");
        t.set_bits(f, None).unwrap();
        assert_eq!((t.value(f, 1).is_some(), t.value(f, 2)), (true, None));
        t.sample(40).unwrap();
        assert_eq!(t.value(f, 3), None);
        t.set(f, Value::Float(-0.0)).unwrap();
        let changes: Vec<_> = t.channels()[f].changes().map(|c| (c.sample, c.value)).collect();
        let want = [(1, Some(Value::Float(f64::NAN))), (2, None), (3, Some(Value::Float(-0.0)))];
        assert_eq!(changes, want);
        assert_eq!(t.value(f, 4), None);
    }

    #[test]
    fn a_part_begins_with_what_held() {
        let mut t = Trace::default();
        let n = t.add("n", Type::S32);
        t.also(n, "m");
        for i in 0..10_u32 {
            t.push(i64::from(i) * 10, &[u64::from(i)]).unwrap();
            if i == 4 {
                t.lose(3);
            }
            t.mark(i64::from(i) * 10 + 1, "x");
        }
        let part = t.between(35, 70);
        assert_eq!(part.times().iter().collect::<Vec<_>>(), [35, 40, 50, 60]);
        let values: Vec<_> = (0..4).map(|s| part.value(0, s)).collect();
        assert_eq!(values, [3, 4, 5, 6].map(|v| Some(Value::S32(v))));
        assert_eq!(part.gaps(), [Gap { sample: 2, lost: 3 }]);
        assert_eq!(part.markers().len(), 3);
        assert_eq!(part.find("m"), Some(0));
        t.lose(9);
        assert_eq!(t.between(i64::MIN, i64::MAX), t);
        assert!(t.between(50, 50).is_empty());
    }
}
