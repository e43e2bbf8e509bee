//! Memory of the flight recorder: the latest changes of all values, and the names of each value
//! over time.

use hal_protocol::Type;
use hal_trace::{Refusal, TimeBase, Trace};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Change of a value.
#[derive(Clone, Copy, Debug)]
struct Change {
    time: i64,
    column: u32,
    bits: u64,
}

/// Size of one change in bytes.
pub(super) const CHANGE_BYTES: u64 = size_of::<Change>() as u64;

/// Value that may have several names: those of a signal and of its pins.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) ty: Type,
    pub(super) names: Vec<String>,
    /// Previous column of the value.
    pub(super) before: Option<u32>,
}

/// Column: one value over time.
#[derive(Clone, Copy, Debug)]
struct Column {
    ty: Type,
    /// Value at the begin of the history, and value now.
    base: Option<u64>,
    now: Option<u64>,
}

/// Columns of a name over time: the time from which each applies, in nanoseconds.
type Turns = Vec<(i64, Option<u32>)>;

/// Latest changes of all values.
#[derive(Clone, Debug)]
pub(super) struct History {
    changes: VecDeque<Change>,
    columns: Vec<Column>,
    /// Unused columns.
    free: Vec<u32>,
    /// Columns of each name over time.
    names: BTreeMap<String, Turns>,
    /// Begin of the history, in nanoseconds.
    from: i64,
    most: usize,
}

impl History {
    /// Creates an empty history with room for `bytes` bytes of changes.
    pub(super) fn new(bytes: u64, now: i64) -> Self {
        let most = usize::try_from(bytes / CHANGE_BYTES).unwrap_or(usize::MAX).max(1);
        let (changes, columns, free) = (VecDeque::new(), Vec::new(), Vec::new());
        Self { changes, columns, free, names: BTreeMap::new(), from: now, most }
    }

    /// Sets the values that exist from `now` on. Returns their columns.
    pub(super) fn regroup(&mut self, now: i64, groups: &[Group]) -> Vec<u32> {
        self.forget();
        let mut columns = Vec::with_capacity(groups.len());
        let mut all: BTreeMap<&str, u32> = BTreeMap::new();
        for group in groups {
            let same = |c: &u32| self.columns.get(*c as usize).is_some_and(|c| c.ty == group.ty);
            let column = match group.before.filter(same) {
                Some(column) => column,
                None => self.new_column(group.ty),
            };
            columns.push(column);
            for name in &group.names {
                all.entry(name).or_insert(column);
            }
        }
        for (name, was) in &mut self.names {
            if !all.contains_key(name.as_str()) && was.last().is_some_and(|w| w.1.is_some()) {
                was.push((now, None));
            }
        }
        for (name, column) in all {
            let was = self.names.entry(name.to_owned()).or_default();
            if was.last().is_none_or(|w| w.1 != Some(column)) {
                was.push((now, Some(column)));
            }
        }
        columns
    }

    fn new_column(&mut self, ty: Type) -> u32 {
        let new = Column { ty, base: None, now: None };
        if let Some(column) = self.free.pop()
            && let Some(place) = self.columns.get_mut(column as usize)
        {
            *place = new;
            return column;
        }
        self.columns.push(new);
        u32::try_from(self.columns.len() - 1).unwrap_or(u32::MAX)
    }

    /// Forgets names that ended before the history begins, and columns without names.
    fn forget(&mut self) {
        let from = self.from;
        self.names.retain(|_, was| {
            let over = was.iter().rposition(|(at, _)| *at <= from).unwrap_or(0);
            was.drain(..over);
            was.iter().any(|w| w.1.is_some())
        });
        let named: BTreeSet<u32> =
            self.names.values().flatten().filter_map(|(_, column)| *column).collect();
        let all = 0..u32::try_from(self.columns.len()).unwrap_or(u32::MAX);
        let changed: BTreeSet<u32> = self.changes.iter().map(|c| c.column).collect();
        self.free = all.filter(|c| !named.contains(c) && !changed.contains(c)).collect();
    }

    /// Returns the present column of a name, and its type.
    pub(super) fn column(&self, name: &str) -> Option<(u32, Type)> {
        let column = self.names.get(name)?.last()?.1?;
        Some((column, self.columns.get(column as usize)?.ty))
    }

    /// Returns the present value of a column, if known.
    pub(super) fn now(&self, column: u32) -> Option<u64> {
        self.columns.get(column as usize)?.now
    }

    /// Adds the value of a column at a time. Returns whether it differs from the previous one.
    pub(super) fn push(&mut self, time: i64, column: u32, bits: u64) -> bool {
        let Some(place) = self.columns.get_mut(column as usize) else { return false };
        let bits = match place.ty {
            Type::Bit => u64::from(bits & 0xff != 0),
            Type::S32 | Type::U32 => bits & 0xffff_ffff,
            _ => bits,
        };
        if place.now.replace(bits) == Some(bits) {
            return false;
        }
        // A sample that was taken while threads are stopped may have a slightly later time.
        let time = time.max(self.latest());
        self.changes.push_back(Change { time, column, bits });
        while self.changes.len() > self.most {
            self.drop_oldest();
        }
        true
    }

    fn drop_oldest(&mut self) {
        let Some(old) = self.changes.pop_front() else { return };
        self.from = self.from.max(old.time);
        if let Some(column) = self.columns.get_mut(old.column as usize) {
            column.base = Some(old.bits);
        }
    }

    /// Drops changes before `time`.
    pub(super) fn keep_from(&mut self, time: i64) {
        while self.changes.front().is_some_and(|c| c.time < time) {
            self.drop_oldest();
        }
        self.from = self.from.max(time);
    }

    /// Returns the begin of the history, in nanoseconds.
    pub(super) const fn from(&self) -> i64 {
        self.from
    }

    /// Returns the time of the latest change, in nanoseconds.
    pub(super) fn latest(&self) -> i64 {
        self.changes.back().map_or(self.from, |c| c.time)
    }

    /// Returns the present names, with their types.
    pub(super) fn present(&self) -> Vec<(String, Type)> {
        let all = self.names.keys();
        all.filter_map(|name| Some((name.clone(), self.column(name)?.1))).collect()
    }

    /// Returns the size of the changes in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.changes.len() as u64 * CHANGE_BYTES
    }

    /// Returns the history as a trace that ends at `to`. Names that always had the same value share
    /// one channel.
    pub(super) fn trace(&self, to: i64) -> Result<Trace, Refusal> {
        let mut trace = Trace::new(TimeBase::NANOSECONDS);
        // Channels by type and columns over time.
        let mut channels: BTreeMap<(u8, Turns), usize> = BTreeMap::new();
        for (name, was) in &self.names {
            let over = was.iter().rposition(|(at, _)| *at <= self.from).unwrap_or(0);
            let mut was: Vec<_> = was.get(over..).unwrap_or_default().to_vec();
            was.iter_mut().for_each(|w| w.0 = w.0.max(self.from));
            let last =
                was.iter().rev().find_map(|w| w.1).and_then(|c| self.columns.get(c as usize));
            let Some(ty) = last.map(|c| c.ty) else { continue };
            // If a name was reused for a value of another type, only the latest type counts.
            let same = |c: u32| self.columns.get(c as usize).is_some_and(|c| c.ty == ty);
            was.iter_mut().for_each(|w| w.1 = w.1.filter(|c| same(*c)));
            match channels.get(&(ty.code(), was.clone())) {
                Some(channel) => trace.also(*channel, name),
                None => {
                    let channel = trace.add(name, ty);
                    channels.insert((ty.code(), was), channel);
                }
            }
        }
        let mut turns: Vec<(i64, usize, Option<u32>)> = Vec::new();
        for ((_, was), channel) in &channels {
            turns.extend(was.iter().map(|(at, column)| (*at, *channel, *column)));
        }
        turns.sort_by_key(|t| t.0);
        Replay::new(&self.columns).run(&mut trace, &turns, &self.changes, to)?;
        Ok(trace)
    }
}

/// Conversion of changes of columns into changes of channels.
struct Replay {
    values: Vec<Option<u64>>,
    /// Present channels of each column.
    heard: Vec<Vec<usize>>,
    is: BTreeMap<usize, u32>,
}

impl Replay {
    fn new(columns: &[Column]) -> Self {
        let values = columns.iter().map(|c| c.base).collect();
        Self { values, heard: vec![Vec::new(); columns.len()], is: BTreeMap::new() }
    }

    fn run(
        mut self,
        trace: &mut Trace,
        turns: &[(i64, usize, Option<u32>)],
        changes: &VecDeque<Change>,
        to: i64,
    ) -> Result<(), Refusal> {
        let mut at = i64::MIN;
        let mut turns = turns.iter().peekable();
        let mut changes = changes.iter().filter(|c| c.time <= to).peekable();
        loop {
            let next = [turns.peek().map(|t| t.0), changes.peek().map(|c| c.time)];
            let Some(time) = next.into_iter().flatten().min() else { break };
            at = time;
            trace.sample(time)?;
            while let Some((_, channel, column)) = turns.next_if(|t| t.0 <= time) {
                self.turn(trace, *channel, *column)?;
            }
            while let Some(change) = changes.next_if(|c| c.time <= time) {
                let column = change.column as usize;
                if let Some(value) = self.values.get_mut(column) {
                    *value = Some(change.bits);
                }
                for channel in self.heard.get(column).into_iter().flatten() {
                    trace.set_bits(*channel, Some(change.bits))?;
                }
            }
        }
        // Adds a sample at the end, unless the last change is at the end.
        if at < to { trace.sample(to) } else { Ok(()) }
    }

    fn turn(
        &mut self,
        trace: &mut Trace,
        channel: usize,
        column: Option<u32>,
    ) -> Result<(), Refusal> {
        if let Some(before) = self.is.remove(&channel)
            && let Some(heard) = self.heard.get_mut(before as usize)
        {
            heard.retain(|c| *c != channel);
        }
        let value = column.and_then(|c| self.values.get(c as usize).copied().flatten());
        trace.set_bits(channel, value)?;
        if let Some(column) = column
            && let Some(heard) = self.heard.get_mut(column as usize)
        {
            heard.push(channel);
            self.is.insert(channel, column);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{CHANGE_BYTES, Group, History};
    use hal_protocol::{Type, Value};

    fn group(names: &[&str], before: Option<u32>) -> Group {
        Group { ty: Type::S32, names: names.iter().map(|n| (*n).to_owned()).collect(), before }
    }

    fn values(h: &History, name: &str, to: i64) -> Vec<(i64, Option<Value>)> {
        let t = h.trace(to).unwrap();
        let channel = t.find(name).unwrap();
        let times: Vec<i64> = (h.from()..=to).collect();
        times.into_iter().map(|at| (at, t.at(channel, at))).collect()
    }

    const fn n(n: i32) -> Option<Value> {
        Some(Value::S32(n))
    }

    #[test]
    fn what_is_too_old_goes_and_what_it_left_stays() {
        let mut h = History::new(3 * CHANGE_BYTES, 0);
        let columns = h.regroup(0, &[group(&["a", "b"], None), group(&["c"], None)]);
        for (time, column, bits) in
            [(0, 0, 1), (0, 1, 10), (1, 0, 2), (1, 0, 2), (2, 1, 20), (3, 0, 3)]
        {
            h.push(time, columns[column], bits);
        }
        assert_eq!((h.bytes(), h.from()), (3 * CHANGE_BYTES, 0));
        h.push(4, columns[1], 30);
        assert_eq!(h.from(), 1);
        assert_eq!(values(&h, "a", 5), [(1, n(2)), (2, n(2)), (3, n(3)), (4, n(3)), (5, n(3))]);
        assert_eq!(values(&h, "c", 4), [(1, n(10)), (2, n(20)), (3, n(20)), (4, n(30))]);
        assert_eq!(h.trace(5).unwrap().channels().len(), 2);
        assert_eq!(h.trace(5).unwrap().channels()[0].names(), ["a", "b"]);
        h.keep_from(4);
        assert_eq!(values(&h, "b", 5), [(4, n(3)), (5, n(3))]);
        assert_eq!(values(&h, "c", 5), [(4, n(30)), (5, n(30))]);
    }

    #[test]
    fn a_pin_follows_its_signal_and_names_come_and_go() {
        let mut h = History::new(1 << 16, 0);
        let c = h.regroup(0, &[group(&["s", "p"], None), group(&["t", "q"], None)]);
        h.push(0, c[0], 1);
        h.push(0, c[1], 7);
        // The pins change places, then one is removed.
        let c = h.regroup(2, &[group(&["s", "q"], Some(c[0])), group(&["t", "p"], Some(c[1]))]);
        h.push(3, c[0], 2);
        let c = h.regroup(4, &[group(&["s"], Some(c[0])), group(&["t", "p"], Some(c[1]))]);
        assert_eq!(values(&h, "p", 4), [(0, n(1)), (1, n(1)), (2, n(7)), (3, n(7)), (4, n(7))]);
        assert_eq!(values(&h, "q", 4), [(0, n(7)), (1, n(7)), (2, n(1)), (3, n(2)), (4, None)]);
        assert_eq!(values(&h, "s", 4), [(0, n(1)), (1, n(1)), (2, n(1)), (3, n(2)), (4, n(2))]);
        // A removed value is forgotten, and its column is reused.
        h.keep_from(10);
        h.regroup(10, &[group(&["t", "p"], Some(c[1]))]);
        h.keep_from(11);
        let d = h.regroup(11, &[group(&["t", "p"], Some(c[1])), group(&["new"], None)]);
        assert_eq!(d[1], c[0]);
        assert!(
            h.trace(12).unwrap().find("q").is_none() && h.trace(12).unwrap().find("new").is_some()
        );
        assert_eq!(values(&h, "new", 11), [(11, None)]);
    }
}
