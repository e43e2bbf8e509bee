//! Measurements of a channel between two times: edges, frequency, duty cycle, extremes.

use crate::Trace;
use hal_protocol::{Type, Value};

/// Shortest, mean and longest of several times, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Shortest time.
    pub min: f64,
    /// Mean time.
    pub mean: f64,
    /// Longest time.
    pub max: f64,
}

/// Results of a measurement.
///
/// For a numeric channel, an edge is a crossing of the midpoint between its smallest and largest
/// value. Times are those of samples, so their resolution is the sample period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Number of changes.
    pub changes: usize,
    /// Number of rising edges.
    pub rises: usize,
    /// Number of falling edges.
    pub falls: usize,
    /// Times between successive rising edges.
    pub period: Option<Spread>,
    /// Durations of complete pulses (high).
    pub high: Option<Spread>,
    /// Durations of complete pauses (low).
    pub low: Option<Spread>,
    /// Rising edges per second: the inverse of the mean period.
    pub frequency: Option<f64>,
    /// Fraction of time that the channel was high, from 0 to 1, between the first and the last
    /// rising edge.
    pub duty: Option<f64>,
    /// Smallest finite value. A bit counts as 0 or 1.
    pub min: Option<f64>,
    /// Largest finite value.
    pub max: Option<f64>,
    /// Time-weighted mean of the finite values.
    pub mean: Option<f64>,
}

/// An interval in which the value held.
#[derive(Clone, Copy)]
struct Stretch {
    from: i64,
    to: i64,
    value: Option<f64>,
}

/// Returns a value as a number. Returns `None` for a port and for a float that is not finite.
#[must_use]
pub fn number(value: Value) -> Option<f64> {
    value.as_number().filter(|number| number.is_finite())
}

/// Measures a channel between two times. A change exactly at `from` counts as the initial value. No
/// value is known after the last sample.
#[must_use]
pub fn measure(trace: &Trace, channel: usize, from: i64, to: i64) -> Measures {
    let stretches = stretches(trace, channel, from, to);
    let mut m = Measures { changes: stretches.len().saturating_sub(1), ..Measures::default() };
    let known = || stretches.iter().filter_map(|s| Some((s, s.value?)));
    m.min = known().map(|(_, v)| v).reduce(f64::min);
    m.max = known().map(|(_, v)| v).reduce(f64::max);
    let seconds = |from: i64, to: i64| trace.base().seconds(to.saturating_sub(from));
    let time: f64 = known().map(|(s, _)| seconds(s.from, s.to)).sum();
    if time > 0.0 {
        m.mean = Some(known().map(|(s, v)| v * seconds(s.from, s.to)).sum::<f64>() / time);
    }
    let (Some(min), Some(max)) = (m.min, m.max) else { return m };
    let is_bit = trace.channels().get(channel).is_some_and(|c| c.ty() == Type::Bit);
    let middle = if is_bit { 0.5 } else { min / 2.0 + max / 2.0 };
    let edges = edges(&stretches, middle);
    m.rises = edges.iter().filter(|e| e.1).count();
    m.falls = edges.len() - m.rises;
    let apart = |pairs: &mut dyn Iterator<Item = (i64, i64)>| {
        spread(&mut pairs.map(|(a, b)| seconds(a, b)))
    };
    let rises: Vec<i64> = edges.iter().filter(|e| e.1).map(|e| e.0).collect();
    m.period = apart(&mut rises.iter().copied().zip(rises.iter().skip(1).copied()));
    let pulses = |high: bool| {
        let pairs = edges.iter().zip(edges.iter().skip(1));
        pairs.filter(move |(a, _)| a.1 == high).map(|(a, b)| (a.0, b.0))
    };
    m.high = apart(&mut pulses(true));
    m.low = apart(&mut pulses(false));
    m.frequency = m.period.filter(|p| p.mean > 0.0).map(|p| 1.0 / p.mean);
    if let (Some(first), Some(last)) = (rises.first(), rises.last())
        && first < last
    {
        let whole = pulses(true).filter(|(a, _)| a < last);
        let high: f64 = whole.map(|(a, b)| seconds(a, b)).sum();
        m.duty = Some(high / seconds(*first, *last));
    }
    m
}

/// Returns the intervals of constant value of a channel between two times.
fn stretches(trace: &Trace, number_of: usize, from: i64, to: i64) -> Vec<Stretch> {
    let mut list = Vec::new();
    let (times, Some(channel)) = (trace.times(), trace.channels().get(number_of)) else {
        return list;
    };
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return list };
    let (from, to) = (from.max(first), to.min(last));
    if from > to {
        return list;
    }
    list.push(Stretch { from, to, value: trace.at(number_of, from).and_then(number) });
    let after = channel.changes_before(times.from(from.saturating_add(1)));
    for change in (after..channel.len()).filter_map(|n| channel.change(n)) {
        let Some(at) = times.get(change.sample).filter(|at| *at <= to) else { break };
        if let Some(before) = list.last_mut() {
            before.to = at;
        }
        list.push(Stretch { from: at, to, value: change.value.and_then(number) });
    }
    list
}

/// Returns the time of each crossing of the midpoint, and whether the edge rises. A value at the
/// midpoint counts as high.
fn edges(stretches: &[Stretch], middle: f64) -> Vec<(i64, bool)> {
    let mut edges = Vec::new();
    let mut was = None;
    for s in stretches {
        let is = s.value.map(|v| v >= middle);
        if let (Some(was), Some(is)) = (was, is)
            && was != is
        {
            edges.push((s.from, is));
        }
        was = is;
    }
    edges
}

fn spread(times: &mut dyn Iterator<Item = f64>) -> Option<Spread> {
    let first = times.next()?;
    let (mut min, mut max, mut sum, mut n) = (first, first, first, 1.0);
    for t in times {
        min = t.min(min);
        max = t.max(max);
        sum += t;
        n += 1.0;
    }
    Some(Spread { min, mean: sum / n, max })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 200 Hz square wave, high for a fifth of the time, sampled every 100 µs.
    fn square() -> Trace {
        let mut t = Trace::default();
        t.add("step", Type::Bit);
        t.add("ramp", Type::Float);
        t.add("gone", Type::Float);
        for i in 0..1000_u32 {
            let ramp = f64::from(i % 50) - 10.0;
            let gone = if i == 5 { 3.0 } else { f64::NAN };
            let record = [u64::from((i + 7) % 50 < 10), ramp.to_bits(), gone.to_bits()];
            t.push(i64::from(i) * 100_000, &record).unwrap();
        }
        t
    }

    #[test]
    fn a_square_wave_is_measured() {
        let m = measure(&square(), 0, 0, i64::MAX);
        assert_eq!((m.rises, m.falls, m.changes), (20, 20, 40));
        let close = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-9, "{a:?} {b}");
        close(m.frequency, 200.0);
        close(m.duty, 0.2);
        let high = m.high.unwrap();
        close(Some(high.min), 0.001);
        close(Some(high.max), 0.001);
        close(m.low.map(|l| l.mean), 0.004);
        assert_eq!((m.min, m.max), (Some(0.0), Some(1.0)));
    }

    #[test]
    fn a_number_has_a_frequency_and_extremes() {
        let m = measure(&square(), 1, 0, i64::MAX);
        assert_eq!((m.min, m.max), (Some(-10.0), Some(39.0)));
        assert!((m.frequency.unwrap() - 200.0).abs() < 1e-9);
        assert!((m.mean.unwrap() - 14.5).abs() < 0.1, "{m:?}");
        let part = measure(&square(), 1, 1_000_000, 1_900_000);
        assert_eq!((part.min, part.max, part.changes), (Some(0.0), Some(9.0), 9));
        assert!((part.mean.unwrap() - 4.0).abs() < 1e-12, "the last holds for no time: {part:?}");
        assert_eq!(part.frequency, None);
    }

    #[test]
    fn what_is_not_there_is_not_measured() {
        let t = square();
        let gone = measure(&t, 2, 0, i64::MAX);
        assert_eq!((gone.min, gone.max, gone.rises), (Some(3.0), Some(3.0), 0));
        assert_eq!(measure(&t, 3, 0, 10), Measures::default());
        assert_eq!(measure(&t, 0, 10, -10), Measures::default());
        assert_eq!(measure(&Trace::default(), 0, 0, 10), Measures::default());
        let none = measure(&t, 0, i64::MIN, -1);
        assert_eq!(none, Measures::default());
    }
}
