//! Erosion: the limits of each cell act as far beyond its ends as the jerk filter can look.
//!
//! The filter averages the path coordinate over the time T. While the output is inside a cell, the input is no
//! further away than the cell's own speed times T + 3 periods, because the input moves at most at that speed there.
//! Inside that distance the limits of the cell must therefore hold for the input. The result is the lower envelope of
//! all widened limits, cut where it changes.

use std::{
    cmp::{Ordering, Reverse},
    collections::{BinaryHeap, VecDeque},
};

use crate::speed::Allowed;

/// A piece of a curve with its own limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Raw {
    pub(crate) curve: u64,
    pub(crate) from: f64,
    pub(crate) length: f64,
    pub(crate) allowed: Allowed,
    /// Programmed speeds along the path, as [`Cell`](crate::track::Cell) has them.
    pub(crate) feed: f64,
    pub(crate) rapid: f64,
    pub(crate) lead: f32,
    pub(crate) linear: f32,
    pub(crate) line: u32,
    /// Start in the coordinate of the run.
    pub(crate) start: f64,
}

impl Raw {
    pub(crate) fn end(&self) -> f64 {
        self.start + self.length
    }

    /// Distance by which the limits act beyond the ends.
    pub(crate) fn reach(&self, time: f64) -> f64 {
        self.allowed.speed * time * (1.0 + 1e-9) + 1e-8
    }
}

/// Erosion of one run, from rest to rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Erosion {
    /// Limits that do not act yet, by the start of their interval: speed, acceleration at rest and at full speed.
    pending: BinaryHeap<Reverse<Entry<[f64; 3]>>>,
    /// The same three of the limits that act, each lowest first.
    lowest: [BinaryHeap<Reverse<Entry<()>>>; 3],
    raws: VecDeque<Raw>,
    /// End of the run so far.
    end: f64,
    /// Start of the part that has not been given out.
    done: f64,
}

/// A limit, ordered by `key`.
#[derive(Clone, Copy, Debug)]
struct Entry<T> {
    key: f64,
    /// End of the interval in which it acts.
    until: f64,
    limits: T,
}

impl Erosion {
    /// Adds the next cell of the run, and returns it with its place. `time` is the reach in seconds.
    pub(crate) fn push(&mut self, mut raw: Raw, time: f64) -> Raw {
        self.shed();
        raw.start = self.end;
        self.end = raw.end();
        let reach = raw.reach(time);
        let limits = [raw.allowed.speed, raw.allowed.rest, raw.allowed.top()];
        let (key, until) = (raw.start - reach, raw.end() + reach);
        self.pending.push(Reverse(Entry { key, until, limits }));
        self.raws.push_back(raw);
        raw
    }

    /// Removes limits that act no longer from heaps that have grown.
    fn shed(&mut self) {
        let x = self.done;
        for heap in &mut self.lowest {
            if heap.len() >= 4096 && heap.len() == heap.capacity() {
                heap.retain(|e| e.0.until > x);
            }
        }
    }

    /// Number of cells that have not been given out.
    pub(crate) fn waiting(&self) -> usize {
        self.raws.len()
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn memory(&self) -> usize {
        let lowest: usize = self.lowest.iter().map(BinaryHeap::capacity).sum();
        lowest * size_of::<Entry<()>>()
            + self.pending.capacity() * size_of::<Entry<[f64; 3]>>()
            + self.raws.capacity() * size_of::<Raw>()
    }

    /// Returns the length of the run that is known.
    pub(crate) const fn known(&self) -> f64 {
        self.end
    }

    /// Gives out cells up to `frontier`, a coordinate beyond whose reach nothing is unknown. Cells shorter than
    /// `shortest` seconds at their speed are merged with a slower neighbour on the same curve.
    pub(crate) fn drain(&mut self, frontier: f64, shortest: f64, mut give: impl FnMut(Raw)) {
        while let Some(raw) = self.raws.front().copied() {
            if raw.end() > frontier {
                return;
            }
            let mut x = raw.start.max(self.done);
            let mut open: Option<Raw> = None;
            while x < raw.end() {
                let (allowed, next) = self.limits_at(x, raw.end());
                let last = next >= raw.end();
                let from = raw.from + (x - raw.start);
                let to = if last { raw.from + raw.length } else { raw.from + (next - raw.start) };
                let allowed = lower(&allowed, &raw.allowed);
                open = Some(match open {
                    Some(before) => {
                        let (p, q) = (&before.allowed, &allowed);
                        let same = p == q;
                        let tiny = |a: &Allowed, l: f64| l <= shortest * a.speed + 1e-9;
                        let below = |a: &Allowed, b: &Allowed| {
                            a.speed <= b.speed && a.rest <= b.rest && a.top() <= b.top()
                        };
                        let (first, second) = (tiny(p, before.length), tiny(q, to - from));
                        // A short cell joins its neighbour only if a long one does not become slower by it.
                        if same || first && second || first && below(q, p) || second && below(p, q)
                        {
                            Raw { length: to - before.from, allowed: lower(p, q), ..before }
                        } else {
                            give(before);
                            Raw { from, length: to - from, allowed, start: x, ..raw }
                        }
                    }
                    None => Raw { from, length: to - from, allowed, start: x, ..raw },
                });
                x = next;
            }
            if let Some(open) = open {
                give(open);
            }
            self.done = raw.end();
            self.raws.pop_front();
        }
    }

    /// Gives out the oldest cell as it is: without a filter nothing reaches beyond its own cell.
    pub(crate) fn pass(&mut self) -> Option<Raw> {
        self.pending.clear();
        self.raws.pop_front()
    }

    /// Ends the run: the next cell begins a new one.
    pub(crate) fn restart(&mut self) {
        self.pending.clear();
        self.lowest.iter_mut().for_each(BinaryHeap::clear);
        self.raws.clear();
        self.end = 0.0;
        self.done = 0.0;
    }

    /// Returns the lowest limits at `x`, and the coordinate up to which they hold.
    fn limits_at(&mut self, x: f64, end: f64) -> (Allowed, f64) {
        while let Some(Reverse(entry)) = self.pending.peek().copied() {
            if entry.key > x {
                break;
            }
            self.pending.pop();
            let until = entry.until;
            for (heap, key) in self.lowest.iter_mut().zip(entry.limits) {
                // A limit that is higher, and acts no longer, than another one decides nothing.
                if heap.peek().is_some_and(|Reverse(e)| e.key <= key && e.until >= until) {
                    continue;
                }
                while heap.peek().is_some_and(|Reverse(e)| e.key >= key && e.until <= until) {
                    heap.pop();
                }
                heap.push(Reverse(Entry { key, until, limits: () }));
            }
        }
        let mut next = end;
        if let Some(Reverse(entry)) = self.pending.peek() {
            next = next.min(entry.key);
        }
        let [speed, rest, top] = self.lowest.each_mut().map(|heap| {
            while let Some(Reverse(entry)) = heap.peek() {
                if entry.until > x {
                    next = next.min(entry.until);
                    return entry.key;
                }
                heap.pop();
            }
            f64::INFINITY
        });
        (Allowed::between(speed, rest, top), next)
    }
}

/// Returns the lower of two limits: speed, acceleration at rest and at full speed, each by itself. As acceleration only
/// falls with speed, the result is below both at every speed.
fn lower(a: &Allowed, b: &Allowed) -> Allowed {
    Allowed::between(a.speed.min(b.speed), a.rest.min(b.rest), a.top().min(b.top()))
}

impl<T> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Entry<T> {}

impl<T> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Entry<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.total_cmp(&other.key).then(self.until.total_cmp(&other.until))
    }
}
