//! A channel reduced to columns of equal duration, for a picture of that width.

use crate::{Trace, measure::number};

/// Values of a channel within one column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// First known value in the column.
    pub first: f64,
    /// Last value in the column.
    pub last: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Number of changes within the column.
    pub changes: usize,
}

/// Divides the time from `from` to `to` into `count` columns. A column is `None` if no value is
/// known in it: before the first sample, after the last one, and where the value is not finite. A
/// bit counts as 0 or 1.
#[must_use]
pub fn columns(
    trace: &Trace,
    channel: usize,
    from: i64,
    to: i64,
    count: usize,
) -> Vec<Option<Column>> {
    let mut list: Vec<Option<Column>> = vec![None; count];
    let (times, Some(c)) = (trace.times(), trace.channels().get(channel)) else { return list };
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return list };
    let (width, n) = (i128::from(to) - i128::from(from), i128::try_from(count).unwrap_or(0));
    if width <= 0 || n == 0 {
        return list;
    }
    // Returns the index of the column that contains a time.
    let place = |at: i64| {
        usize::try_from((i128::from(at) - i128::from(from)) * n / width).unwrap_or(0).min(count - 1)
    };
    let mut hold = |begin: i64, end: i64, value: Option<f64>, is_change: bool| {
        let Some(v) = value else { return };
        let (a, b) = (place(begin), place(end));
        for (i, slot) in list.iter_mut().enumerate().take(b + 1).skip(a) {
            let changes = usize::from(is_change && i == a);
            *slot = Some(match *slot {
                None => Column { first: v, last: v, min: v, max: v, changes },
                Some(s) => Column {
                    last: v,
                    min: s.min.min(v),
                    max: s.max.max(v),
                    changes: s.changes + changes,
                    ..s
                },
            });
        }
    };
    let (begin, end) = (from.max(first), to.saturating_sub(1).min(last));
    if begin > end {
        return list;
    }
    let (mut at, mut value) = (begin, trace.at(channel, begin).and_then(number));
    let mut is_change = false;
    let after = c.changes_before(times.from(begin.saturating_add(1)));
    for change in (after..c.len()).filter_map(|n| c.change(n)) {
        let Some(time) = times.get(change.sample).filter(|t| *t <= end) else { break };
        // A column that begins at the change does not include the previous value.
        hold(at, time.saturating_sub(1).max(at), value, is_change);
        (at, value, is_change) = (time, change.value.and_then(number), true);
    }
    hold(at, end, value, is_change);
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_protocol::Type;

    #[test]
    fn columns_see_every_change() {
        let mut t = Trace::default();
        t.add("b", Type::Bit);
        t.add("f", Type::Float);
        for i in 0..100_u32 {
            let f = if i < 10 { f64::NAN } else { f64::from(i) };
            t.push(i64::from(i) * 10, &[u64::from(i % 25 == 3), f.to_bits()]).unwrap();
        }
        let bits = columns(&t, 0, 0, 1000, 4);
        let one = Some(Column { first: 0.0, last: 0.0, min: 0.0, max: 1.0, changes: 2 });
        assert_eq!(bits, [one, one, one, one]);
        let floats = columns(&t, 1, 0, 1000, 10);
        assert_eq!(floats[0], None, "not known");
        let column = |first: f64, last: f64, changes| {
            Some(Column { first, last, min: first, max: last, changes })
        };
        assert_eq!(floats[1], column(10.0, 19.0, 10));
        assert_eq!(floats[9], column(90.0, 99.0, 10));
        // No value is known before the first sample or after the last one.
        let around = columns(&t, 0, -1000, 2000, 3);
        assert_eq!((around[0], around[2]), (None, None));
        assert_eq!(around[1].map(|c| c.changes), Some(8));
        // Columns shorter than the sample period: each has the same value.
        assert_eq!(columns(&t, 1, 500, 510, 3), vec![column(50.0, 50.0, 0); 3]);
        assert_eq!(columns(&t, 1, 505, 515, 2), [column(50.0, 50.0, 0), column(51.0, 51.0, 1)]);
        assert_eq!(columns(&t, 7, 0, 10, 2), [None, None]);
        assert_eq!(columns(&t, 0, 10, 10, 2), [None, None]);
        assert_eq!(columns(&t, 0, i64::MIN, i64::MAX, 1)[0].map(|c| c.changes), Some(8));
    }
}
