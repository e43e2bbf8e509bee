//! Delays of values: between two functions, along paths, and around feedback loops.
//!
//! Times are machine time, from the start of one cycle to the start of another. Within a thread, a
//! value has no delay, or one cycle if it goes backwards in the order. Between two threads, it
//! waits until the reader's next cycle; the delay depends on the moment.

use super::{
    by_index::{ByIndex, Lists},
    flow_graph::{Flow, FlowGraph},
};
use core::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Maximum number of loops and of paths that are reported, and maximum number of search steps.
const MAX: usize = 200;
const STEPS: usize = 1_000_000;
/// Length of a flow that carries only bits, in functions. Among paths of equal delay, those with
/// such flows therefore come last.
const BITS: usize = 1 << 20;
/// Maximum number of start times that are examined one by one.
const STARTS: u64 = 2000;

/// Delay of a value, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Wait {
    pub(crate) most: u64,
    pub(crate) least: u64,
}

impl core::ops::Add for Wait {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            most: self.most.saturating_add(other.most),
            least: self.least.saturating_add(other.least),
        }
    }
}

/// Functions in the order in which a value passes through them. In a loop, the first function also
/// comes last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Chain {
    /// Indices into [`Machine::flows`].
    pub(crate) flows: Vec<usize>,
    pub(crate) wait: Wait,
}

/// Delay from an input to an output of the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Path {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Path on which a value arrives first.
    pub(crate) quickest: Chain,
    /// Path on which a value arrives last.
    pub(crate) slowest: Chain,
}

/// Results of a search, and whether the search stopped early.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found<T> {
    pub(crate) list: Vec<T>,
    pub(crate) more: bool,
}

/// A machine with an order for each thread.
#[derive(Debug)]
pub(crate) struct Timed<'m> {
    machine: &'m FlowGraph,
    /// Position of each function in its thread.
    place: ByIndex<usize>,
    waits: Vec<Wait>,
    /// Flows that leave each function.
    gives: Lists,
}

impl<'m> Timed<'m> {
    /// Computes the delays for threads that run their functions in these orders.
    pub(crate) fn new(machine: &'m FlowGraph, orders: &[Vec<usize>]) -> Self {
        let n = machine.functs.len();
        let mut place = ByIndex::of(n, 0);
        for order in orders {
            order.iter().enumerate().for_each(|(at, f)| place.set(*f, at));
        }
        let gives = machine.flows.iter().enumerate().map(|(i, flow)| (flow.from, i));
        let gives = Lists::sort(n, gives);
        let waits = machine.flows.iter().map(|flow| wait(machine, &place, flow)).collect();
        Self { machine, place, waits, gives }
    }

    /// Returns the position of a function in its thread.
    pub(crate) fn place(&self, funct: usize) -> usize {
        self.place.at(funct)
    }

    /// Returns whether a flow goes backwards in its thread, which costs a cycle.
    pub(crate) fn is_late(&self, flow: &Flow) -> bool {
        self.machine.is_inside(flow) && self.place.at(flow.from) >= self.place.at(flow.to)
    }

    /// Returns the delay of a flow.
    pub(crate) fn wait(&self, flow: usize) -> Wait {
        self.waits.get(flow).copied().unwrap_or_default()
    }

    /// Returns the smallest and the largest delay of a value along a chain, over the cycles in
    /// which it can start.
    pub(crate) fn along(&self, flows: &[usize]) -> Wait {
        let flow = |i: &usize| self.machine.flows.get(*i);
        let Some(first) = flows.first().and_then(flow) else { return Wait::default() };
        let begin = self.machine.period(self.machine.thread_of(first.from)).max(1);
        // The phase between the threads repeats after this time. It contains all different start
        // cycles.
        let all = flows
            .iter()
            .filter_map(flow)
            .map(|f| self.machine.period(self.machine.thread_of(f.to)));
        let again =
            all.fold(begin, |n, period| (n / common(n, period.max(1))).saturating_mul(period));
        if again / begin > STARTS {
            return flows.iter().fold(Wait::default(), |sum, i| sum + self.wait(*i));
        }
        let mut wait = Wait { least: u64::MAX, most: 0 };
        for start in 0..(again / begin).max(1) {
            let start = start.saturating_mul(begin);
            let end = flows.iter().fold(start, |now, i| self.arrival(*i, now));
            wait.least = wait.least.min(end.saturating_sub(start));
            wait.most = wait.most.max(end.saturating_sub(start));
        }
        wait
    }

    /// Returns the time at which the reader of a flow runs that gets a value written at time `now`.
    fn arrival(&self, flow: usize, now: u64) -> u64 {
        let Some(f) = self.machine.flows.get(flow) else { return now };
        let (a, b) = (self.machine.thread_of(f.from), self.machine.thread_of(f.to));
        if a == b {
            return now.saturating_add(self.wait(flow).most);
        }
        let period = self.machine.period(b).max(1);
        let earliest = if a < b { now } else { now.saturating_add(1) };
        earliest.div_ceil(period).saturating_mul(period)
    }

    /// Returns the feedback loops: for every flow that is part of a loop, the quickest one. If
    /// delays are equal, the one with the fewest functions.
    pub(crate) fn loops(&self) -> Found<Chain> {
        let (n, flows) = (self.machine.functs.len(), &self.machine.flows);
        let circle = circles(n, flows);
        let (mut steps, mut more) = (0, false);
        let mut seen: BTreeMap<Vec<usize>, Chain> = BTreeMap::new();
        let mut covered = ByIndex::of(flows.len(), false);
        for (i, flow) in flows.iter().enumerate() {
            if covered.at(i) || circle.at(flow.from) != circle.at(flow.to) {
                continue;
            }
            if steps > STEPS || seen.len() >= MAX {
                more = true;
                break;
            }
            let inside = |f: &Flow| {
                circle.at(f.from) == circle.at(flow.from) && circle.at(f.to) == circle.at(flow.from)
            };
            let ways = self.quickest(flow.to, Some(flow.from), &inside, &mut steps);
            let Some(mut back) = self.way(&ways, flow.to, flow.from) else { continue };
            back.push(i);
            back.iter().for_each(|f| covered.set(*f, true));
            self.turn(&mut back);
            seen.entry(back.clone())
                .or_insert_with(|| Chain { wait: self.along(&back), flows: back });
        }
        let mut list: Vec<Chain> = seen.into_values().collect();
        list.sort_by_key(|chain| chain.flows.first().copied());
        Found { list, more }
    }

    /// Returns the paths from every function that receives values from outside to every function
    /// whose values leave the machine.
    pub(crate) fn paths(&self) -> Found<Path> {
        let (sources, sinks) = self.ends();
        let one_way = |flow: &Flow| flow.is_one_way();
        let (mut list, mut steps, mut more) = (Vec::new(), 0, false);
        'sources: for from in sources {
            if steps > STEPS {
                more = true;
                break;
            }
            let quickest = self.quickest(from, None, &one_way, &mut steps);
            let slowest = self.slowest(from, &mut steps);
            for to in sinks.iter().copied().filter(|to| *to != from) {
                let quickest = self.way(&quickest, from, to);
                let slowest = self.way(&slowest, from, to);
                let (Some(quickest), Some(slowest)) = (quickest, slowest) else { continue };
                if list.len() >= MAX {
                    more = true;
                    break 'sources;
                }
                let chain = |flows: Vec<usize>| Chain { wait: self.along(&flows), flows };
                let (quickest, slowest) = (chain(quickest), chain(slowest));
                let slowest = if quickest.wait < slowest.wait { slowest } else { quickest.clone() };
                list.push(Path { from, to, quickest, slowest });
            }
        }
        Found { list, more }
    }

    /// Returns the functions at which paths begin and end.
    ///
    /// A path begins at a function that takes nothing from another component, not even through its
    /// own component, and at a function that takes commands. A path ends at a function that gives
    /// no values to another component, and either drives outputs or gives no values to its own
    /// component.
    fn ends(&self) -> (Vec<usize>, Vec<usize>) {
        let n = self.machine.functs.len();
        let ways: Vec<&Flow> = self.machine.flows.iter().filter(|f| f.is_one_way()).collect();
        let (mut fed, mut gives, mut heard) =
            (ByIndex::of(n, false), ByIndex::of(n, false), ByIndex::of(n, false));
        let mut taken = ByIndex::of(n, false);
        for flow in &ways {
            taken.set(flow.to, true);
            heard.set(flow.from, true);
            if !self.machine.are_kin(flow.from, flow.to) {
                fed.set(flow.to, true);
                gives.set(flow.from, true);
            }
        }
        let mut next: Vec<usize> = (0..n).filter(|i| fed.at(*i)).collect();
        while let Some(i) = next.pop() {
            for flow in self.gives.at(i).iter().filter_map(|x| self.machine.flows.get(*x)) {
                if flow.is_one_way() && !fed.at(flow.to) && self.machine.are_kin(i, flow.to) {
                    fed.set(flow.to, true);
                    next.push(flow.to);
                }
            }
        }
        let functs = || self.machine.functs.iter().enumerate();
        let sources = functs().filter(|(i, f)| heard.at(*i) && (f.told || !fed.at(*i)));
        let sinks =
            functs().filter(|(i, f)| taken.at(*i) && !gives.at(*i) && (f.drives || !heard.at(*i)));
        (sources.map(|(i, _)| i).collect(), sinks.map(|(i, _)| i).collect())
    }

    /// Returns, for each function, the flow by which a value from `from` reaches it first. Stops
    /// early at `goal`.
    fn quickest(
        &self,
        from: usize,
        goal: Option<usize>,
        takes: &dyn Fn(&Flow) -> bool,
        steps: &mut usize,
    ) -> BTreeMap<usize, usize> {
        let mut by = BTreeMap::new();
        let mut best: BTreeMap<usize, (Wait, usize)> = BTreeMap::new();
        best.insert(from, (Wait::default(), 0));
        let mut heap = BinaryHeap::from([Reverse((Wait::default(), 0_usize, from))]);
        while let Some(Reverse((wait, hops, i))) = heap.pop() {
            if best.get(&i).is_some_and(|b| *b < (wait, hops)) {
                continue;
            }
            if goal == Some(i) {
                break;
            }
            for x in self.gives.at(i) {
                *steps += 1;
                let Some(flow) = self.machine.flows.get(*x).filter(|f| takes(f)) else { continue };
                let hop = if flow.numbers { 1 } else { BITS };
                let reached = (wait + self.wait(*x), hops + hop);
                if best.get(&flow.to).is_none_or(|b| reached < *b) {
                    best.insert(flow.to, reached);
                    by.insert(flow.to, *x);
                    heap.push(Reverse((reached.0, reached.1, flow.to)));
                }
            }
        }
        by
    }

    /// Returns, for each function, the flow by which a value from `from` reaches it last, without
    /// loops.
    fn slowest(&self, from: usize, steps: &mut usize) -> BTreeMap<usize, usize> {
        // In depth-first order, a flow that leads back to a function on the current path closes a
        // loop.
        let n = self.machine.functs.len();
        let (mut state, mut done) = (ByIndex::of(n, 0_u8), Vec::new());
        let mut kept: Vec<usize> = Vec::new();
        let mut stack = vec![(from, 0)];
        state.set(from, 1);
        while let Some((i, next)) = stack.pop() {
            let Some(x) = self.gives.at(i).get(next).copied() else {
                state.set(i, 2);
                done.push(i);
                continue;
            };
            *steps += 1;
            stack.push((i, next + 1));
            let Some(flow) = self.machine.flows.get(x).filter(|f| f.is_one_way()) else { continue };
            if state.at(flow.to) != 1 {
                kept.push(x);
            }
            if state.at(flow.to) == 0 {
                state.set(flow.to, 1);
                stack.push((flow.to, 0));
            }
        }
        let leaving = kept.iter().filter_map(|x| Some((self.machine.flows.get(*x)?.from, *x)));
        let leaving = Lists::sort(n, leaving);
        let mut by = BTreeMap::new();
        let mut worst: BTreeMap<usize, Wait> = BTreeMap::from([(from, Wait::default())]);
        for i in done.into_iter().rev() {
            let wait = worst.get(&i).copied().unwrap_or_default();
            for x in leaving.at(i) {
                let Some(flow) = self.machine.flows.get(*x) else { continue };
                let reached = wait + self.wait(*x);
                if worst.get(&flow.to).is_none_or(|w| reached > *w) {
                    worst.insert(flow.to, reached);
                    by.insert(flow.to, *x);
                }
            }
        }
        by
    }

    /// Returns the flows of the path to a function, in order.
    fn way(&self, by: &BTreeMap<usize, usize>, from: usize, to: usize) -> Option<Vec<usize>> {
        let mut way = Vec::new();
        let mut at = to;
        while at != from {
            let x = *by.get(&at)?;
            way.push(x);
            at = self.machine.flows.get(x)?.from;
        }
        way.reverse();
        Some(way)
    }

    /// Rotates a loop so that it starts in its slowest thread, where its value has waited longest.
    /// It then reads in the order in which the machine runs. If several flows qualify, the first
    /// one counts.
    fn turn(&self, flows: &mut [usize]) {
        let key = |x: usize| {
            let to = self.machine.flows.get(x).map_or(0, |f| f.to);
            (self.machine.thread_of(to), self.wait(x), Reverse(x))
        };
        let last = flows.iter().enumerate().max_by_key(|(_, x)| key(**x));
        let last = last.map_or(0, |(at, _)| at);
        if !flows.is_empty() {
            flows.rotate_left((last + 1) % flows.len());
        }
    }
}

/// Returns the delay of a value between two functions. Threads that are due at the same moment run
/// in the order of their numbers, and all threads start at the same moment.
fn wait(machine: &FlowGraph, place: &ByIndex<usize>, flow: &Flow) -> Wait {
    let (a, b) = (machine.thread_of(flow.from), machine.thread_of(flow.to));
    let period = machine.period(b);
    if a == b {
        let late = place.at(flow.from) >= place.at(flow.to);
        let ns = if late { period } else { 0 };
        return Wait { most: ns, least: ns };
    }
    // All time differences between cycles of the two threads are multiples of this.
    let common = common(machine.period(a), period);
    if a < b {
        Wait { least: 0, most: period.saturating_sub(common) }
    } else {
        Wait { least: common, most: period }
    }
}

/// Returns the greatest common divisor.
const fn common(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Returns the number of the loop to which each function belongs. A function outside all loops has
/// its own number.
fn circles(n: usize, flows: &[Flow]) -> ByIndex<usize> {
    let number = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
    let pairs = flows.iter().map(|f| (number(f.from), number(f.to)));
    let g: petgraph::graph::DiGraph<(), ()> = petgraph::graph::DiGraph::from_edges(pairs);
    let mut circle = ByIndex::of(n, usize::MAX);
    (0..n).for_each(|i| circle.set(i, n + i));
    for (number, members) in petgraph::algo::kosaraju_scc(&g).iter().enumerate() {
        members.iter().for_each(|m| circle.set(m.index(), number));
    }
    circle
}
