//! A single channel of a picture: its line, its scale, and its labels.

use crate::programs::halscope::names::Chosen;
use hal_protocol::Type;
use hal_trace::{
    Trace,
    columns::columns,
    measure::{Measures, measure, number},
};

/// A line: points in ticks and values, in several pieces where the value is unknown in between.
pub(super) type Pieces = Vec<Vec<(i64, f64)>>;

/// A channel as it is drawn.
#[derive(Clone, Debug)]
pub(super) struct Lane {
    pub(super) name: String,
    /// Another name of the same channel, if there is one.
    pub(super) other: Option<String>,
    pub(super) is_bit: bool,
    /// Minimum and maximum of the scale.
    pub(super) scale: (f64, f64),
    pub(super) pieces: Pieces,
    pub(super) measures: Measures,
}

impl Lane {
    /// Makes the lane of a channel between two times, for a picture `width` columns wide.
    pub(super) fn new(trace: &Trace, chosen: &Chosen, from: i64, to: i64, width: usize) -> Self {
        let channel = chosen.channel;
        let c = trace.channels().get(channel);
        let name = chosen.name.clone();
        let other = c.and_then(|c| c.names().iter().find(|n| **n != name)).cloned();
        let is_bit = c.is_some_and(|c| c.ty() == Type::Bit);
        let measures = measure(trace, channel, from, to);
        let scale = if is_bit { (-0.15, 1.15) } else { scale(measures.min, measures.max) };
        let pieces = pieces(trace, channel, from, to, width);
        Self { name, other, is_bit, scale, pieces, measures }
    }
}

/// Returns a scale slightly larger than the range of the values.
fn scale(min: Option<f64>, max: Option<f64>) -> (f64, f64) {
    let (min, max) = min.zip(max).unwrap_or((0.0, 1.0));
    let room = (max / 2.0 - min / 2.0) * 0.16;
    if room > 0.0 && room.is_finite() {
        (min - room, max + room)
    } else {
        let room = (max.abs() * 0.1).max(1e-3);
        (min - room, max + room)
    }
}

/// Returns the line through every change or, if there are more than two changes per column, through
/// the first, minimum, maximum and last value of each column.
fn pieces(trace: &Trace, channel: usize, from: i64, to: i64, width: usize) -> Pieces {
    let (times, Some(c)) = (trace.times(), trace.channels().get(channel)) else {
        return Vec::new();
    };
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Vec::new() };
    let (begin, end) = (from.max(first), to.min(last));
    let after = c.changes_before(times.from(begin.saturating_add(1)));
    let before = c.changes_before(times.from(end.saturating_add(1)));
    if before.saturating_sub(after) > 2 * width {
        return by_columns(trace, channel, from, to, width);
    }
    let mut pieces = Pieces::new();
    let mut open: Vec<(i64, f64)> = Vec::new();
    let mut held = trace.at(channel, begin).and_then(number);
    open.extend(held.map(|v| (begin, v)));
    for change in (after..before).filter_map(|n| c.change(n)) {
        let Some(at) = times.get(change.sample) else { break };
        open.extend(held.map(|v| (at, v)));
        held = change.value.and_then(number);
        match held {
            Some(v) => open.push((at, v)),
            None => pieces.push(std::mem::take(&mut open)),
        }
    }
    open.extend(held.map(|v| (end, v)));
    pieces.push(open);
    pieces.retain(|p| p.len() > 1);
    pieces
}

fn by_columns(trace: &Trace, channel: usize, from: i64, to: i64, width: usize) -> Pieces {
    let mut pieces = vec![Vec::new()];
    let span = i128::from(to) - i128::from(from);
    for (i, column) in columns(trace, channel, from, to, width).into_iter().enumerate() {
        let (i, n) = (i128::try_from(i).unwrap_or(0), i128::try_from(width).unwrap_or(1));
        // Middle of the column, in ticks.
        let at = i128::from(from) + span * (2 * i + 1) / (2 * n);
        let at = i64::try_from(at).unwrap_or(from);
        match (column, pieces.last_mut()) {
            (Some(c), Some(open)) => {
                open.extend([c.first, c.min, c.max, c.last].map(|v| (at, v)));
            }
            _ => pieces.push(Vec::new()),
        }
    }
    pieces.retain(|p| p.len() > 1);
    pieces
}

#[cfg(test)]
mod tests {
    use super::{Lane, scale};
    use crate::programs::halscope::names::Chosen;
    use hal_protocol::Type;
    use hal_trace::Trace;

    fn chosen(channel: usize) -> Chosen {
        Chosen { channel, name: "x".to_owned() }
    }

    #[test]
    fn a_line_has_its_edges_where_they_are() {
        let mut t = Trace::default();
        t.add("b", Type::Bit);
        t.add("f", Type::Float);
        for (at, b, f) in [(0, 0, f64::NAN), (10, 1, 2.0), (20, 0, 3.0), (30, 0, f64::NAN)] {
            t.push(at, &[b, f.to_bits()]).unwrap();
        }
        let bit = Lane::new(&t, &chosen(0), 5, 25, 100);
        let line = [(5, 0.0), (10, 0.0), (10, 1.0), (20, 1.0), (20, 0.0), (25, 0.0)];
        assert_eq!(bit.pieces, [line.to_vec()]);
        let float = Lane::new(&t, &chosen(1), 0, 100, 100);
        assert_eq!(float.pieces, [vec![(10, 2.0), (20, 2.0), (20, 3.0), (30, 3.0)]]);
        assert_eq!(Lane::new(&t, &chosen(7), 0, 100, 100).pieces.len(), 0);
    }

    #[test]
    fn more_changes_than_columns_still_show_their_extremes() {
        let mut t = Trace::default();
        t.add("f", Type::Float);
        for i in 0..10_000_u32 {
            let f = if i == 5_003 { 9.0 } else { f64::from(i % 2) };
            t.push(i64::from(i), &[f.to_bits()]).unwrap();
        }
        let lane = Lane::new(&t, &chosen(0), 0, 10_000, 100);
        assert_eq!(lane.pieces.len(), 1);
        assert!(lane.pieces[0].len() <= 400);
        let top: Vec<_> = lane.pieces[0].iter().filter(|p| p.1 == 9.0).collect();
        assert_eq!(top, [&(5_050, 9.0)]);
        assert!(lane.scale.1 > 9.0);
    }

    #[test]
    fn a_scale_always_has_room() {
        for (min, max) in [(0.0, 0.0), (5.0, 5.0), (-1e308, 1e308), (0.0, 1e-300), (-3.0, 4.0)] {
            let (low, high) = scale(Some(min), Some(max));
            assert!(low < high && low <= min && max <= high, "{min} {max}: {low} {high}");
        }
        assert!(scale(None, None).0 < scale(None, None).1);
    }
}
