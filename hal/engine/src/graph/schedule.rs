//! Threads and the functions in them.

use crate::{
    Error,
    graph::model::Model,
    graph::{Component, Edge, Ix, Node, ThreadNode},
    name::Name,
    realtime::shared::Shared,
    realtime::thread::{Label, List, NOBODY, Thread},
    sync::{Arc, Ordering},
};
use hal_protocol::{ComponentState, Direction, Lock, Type};
use petgraph::{
    Direction::{Incoming, Outgoing},
    visit::EdgeRef,
};

/// Largest number of components. What the end of the process needs is renewed with each load, so that loads become
/// slower with their number.
const MAX_COMPONENTS: usize = 4096;
/// Shortest and longest period, in nanoseconds.
const PERIODS: core::ops::RangeInclusive<i64> = 1_000..=1_000_000_000_000;

impl Model {
    /// Creates a thread and its pseudo component. The thread starts to run at the end of the
    /// transaction.
    pub(crate) fn new_thread(
        &mut self,
        name: Name,
        (period, fp): (i64, bool),
        shared: &Shared,
    ) -> Result<Ix, Error> {
        if self.graph.threads.contains_key(&name) {
            return Err(Error::Duplicate { what: "thread", name: name.as_str().into() });
        }
        if !PERIODS.contains(&period) {
            return Err(Error::BadPeriod { name: name.as_str().into(), period });
        }
        let slowest = self.graph.threads.values().filter_map(|ix| self.graph.thread(*ix));
        let slowest = slowest.map(|t| t.thread.period_ns).max().unwrap_or(0);
        if period < slowest {
            let name = name.as_str().into();
            return Err(Error::PeriodTooShort { name, period, existing: slowest });
        }
        let pseudo = Name::parse("component", &format!("__{name}"))?;
        let component = self.new_component(pseudo, None, None, true)?;
        self.furnish_thread(component, &name, (period, fp), shared)
    }

    fn furnish_thread(
        &mut self,
        component: Ix,
        name: &Name,
        (period, fp): (i64, bool),
        shared: &Shared,
    ) -> Result<Ix, Error> {
        let account = self.new_account(component, name, false)?;
        let beat = crate::graph::new_item::NewItem {
            name: Name::parse("pin", &format!("{name}.threadbeat"))?,
            other: None,
            ty: Type::S64,
            direction: Direction::Out,
            initial: 0,
            storage: None,
            hidden: false,
            times: true,
            safety: false,
            measured: false,
            doc: self.graph.docs.number("Cycles run."),
        };
        let (_, beat) = self.new_item(component, beat)?;
        let due = shared.first_due(period);
        let timed = !shared.is_virtual();
        let beat = beat.map(crate::graph::ptr::Ptr).ok_or(Error::OutOfMemory)?;
        self.staged.sees(beat);
        self.staged.sees(account.time);
        let id = self.counters.next_thread;
        self.counters.next_thread += 1;
        let thread = Arc::new(Thread::new((id, name.clone()), period, account, beat, timed, due));
        let node = ThreadNode { name: name.clone(), thread, fp, next: 0, stale: false };
        let ix = self.graph.g.add_node(Node::Thread(Box::new(node)));
        self.graph.g.add_edge(component, ix, Edge::Owns);
        self.graph.threads.insert(name.clone(), ix);
        self.graph.sites.made(ix);
        Ok(ix)
    }

    /// Creates a component.
    pub(crate) fn new_component(
        &mut self,
        name: Name,
        pid: Option<i32>,
        args: Option<String>,
        realtime: bool,
    ) -> Result<Ix, Error> {
        if self.graph.components.contains_key(&name) {
            return Err(Error::Duplicate { what: "component name", name: name.as_str().into() });
        }
        if self.graph.components.len() >= MAX_COMPONENTS {
            let name = name.as_str().into();
            return Err(Error::TooManyComponents { name, most: MAX_COMPONENTS });
        }
        let component = Component {
            id: self.counters.next_component,
            name: name.clone(),
            pid,
            realtime,
            state: if realtime { ComponentState::Ready } else { ComponentState::Initializing },
            args,
            commands: Vec::new(),
            stops: Vec::new(),
            origin: None,
            services: Vec::new(),
            foreign: None,
        };
        self.counters.next_component += 1;
        let ix = self.graph.g.add_node(Node::Component(Box::new(component)));
        self.graph.components.insert(name, ix);
        self.graph.sites.made(ix);
        Ok(ix)
    }

    /// Switches the timing of functions on or off, for one thread or for all.
    pub(crate) fn time_functs(&self, thread: Option<&str>, on: bool) -> Result<(), Error> {
        let threads = match thread {
            Some(name) => vec![self.graph.find_thread(name)?],
            None => self.graph.threads.values().copied().collect(),
        };
        for t in threads.into_iter().filter_map(|ix| self.graph.thread(ix)) {
            t.thread.timed.store(on, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Returns the functions that a thread has to run, without probes.
    pub(crate) fn list_of(&self, thread: Ix) -> List {
        let mut labels = Vec::new();
        let mut entries = |init: bool| {
            let mut entries = Vec::new();
            for ix in self.graph.runs(thread, init) {
                let Some(f) = self.graph.funct(ix) else { continue };
                let id = u32::try_from(ix.index()).unwrap_or(NOBODY);
                let owner = self.graph.owner(ix).map_or(&f.name, |c| &c.name);
                let (name, component) = (f.name.clone(), owner.clone());
                let label = Label { id, name, component, code: f.code.clone() };
                entries.push(label.entry(f.account));
                labels.push(label);
            }
            entries
        };
        let (init, entries) = (entries(true), entries(false));
        List { init, entries, labels, ..List::default() }
    }

    /// Executes `addf` and `initf`.
    pub(crate) fn add_funct(
        &mut self,
        funct: &str,
        thread: &str,
        position: i64,
        init: bool,
    ) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "add_funct_to_thread")?;
        if position == 0 {
            return Err(Error::BadPosition(position));
        }
        let f = self.graph.find_funct(funct)?;
        let t = self.graph.find_thread(thread)?;
        let reentrant = self.graph.funct(f).is_some_and(|node| node.reentrant);
        if !reentrant && self.graph.is_in_use(f) {
            return Err(Error::OneThreadOnly { funct: funct.into() });
        }
        let needs_fp = self.graph.funct(f).is_some_and(|node| node.fp);
        if needs_fp && self.graph.thread(t).is_some_and(|node| !node.fp) {
            return Err(Error::NeedsFp(funct.into(), thread.into()));
        }
        let done = |node: &ThreadNode| node.thread.init_done.load(Ordering::Relaxed);
        if init && self.graph.thread(t).is_some_and(done) {
            return Err(Error::InitDone { thread: thread.into(), funct: funct.into() });
        }
        // Positions are renumbered after 2^32 additions.
        if position != -1 || self.graph.thread(t).is_some_and(|node| node.next == u32::MAX) {
            self.touch_thread(t);
            return self.insert_at(t, f, position, init);
        }
        self.extend_thread(t);
        if let Some(node) = self.graph.thread_mut(t) {
            node.next += 1;
            let at = node.next;
            let edge = if init { Edge::Begins(at) } else { Edge::Runs(at) };
            let added = self.graph.g.add_edge(t, f, edge);
            self.graph.sites.joined(added);
        }
        Ok(())
    }

    /// Inserts the edge at a position counted from the start or the end, and renumbers the others.
    fn insert_at(&mut self, t: Ix, f: Ix, position: i64, init: bool) -> Result<(), Error> {
        let order = self.graph.runs(t, init);
        let at = place_in(order.len(), position)?;
        let mut edges: Vec<_> = self
            .graph
            .g
            .edges_directed(t, Outgoing)
            .filter_map(|e| match (*e.weight(), init) {
                (Edge::Runs(p), false) | (Edge::Begins(p), true) => Some((p, e.id())),
                _ => None,
            })
            .collect();
        edges.sort_unstable();
        let edge = |at| if init { Edge::Begins(at) } else { Edge::Runs(at) };
        for (i, (_, id)) in edges.iter().enumerate() {
            let place = place(if i < at { i + 1 } else { i + 2 });
            if let Some(w) = self.graph.g.edge_weight_mut(*id) {
                *w = edge(place);
            }
        }
        if let Some(node) = self.graph.thread_mut(t) {
            node.next = node.next.max(place(edges.len() + 1));
        }
        let added = self.graph.g.add_edge(t, f, edge(place(at + 1)));
        self.graph.sites.joined(added);
        Ok(())
    }

    /// Executes `delf`.
    pub(crate) fn remove_funct(&mut self, funct: &str, thread: Option<&str>) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "del_funct_from_thread")?;
        let f = self.graph.find_funct(funct)?;
        let mut threads = self.graph.threads_of(f);
        let t = thread.map(|name| self.graph.find_thread(name)).transpose()?;
        if threads.is_empty() {
            return Err(Error::NotInUse { funct: funct.into() });
        }
        if let (Some(name), Some(t)) = (thread, t) {
            if !threads.contains(&t) {
                let thread = name.into();
                return Err(Error::NotInThread { funct: funct.into(), thread });
            }
            threads = vec![t];
        }
        threads.into_iter().for_each(|t| self.take_out(f, t));
        Ok(())
    }

    /// Removes a function from a thread.
    pub(crate) fn take_out(&mut self, funct: Ix, thread: Ix) {
        self.touch_thread(thread);
        // Searches from the function, because it is in few threads, while a thread may run
        // thousands of functions.
        let runs = self.graph.g.edges_directed(funct, Incoming);
        let runs = runs.filter(|e| e.source() == thread && e.weight().place().is_some());
        let edges: Vec<_> = runs.map(|e| e.id()).collect();
        for edge in edges {
            self.graph.g.remove_edge(edge);
            self.graph.sites.parted(edge);
        }
    }
}

/// Returns the position of the nth function. A graph has fewer than 2^32 nodes.
fn place(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// Returns the index for a position in a list of `n` functions: 1 is before the first, -1 after the
/// last.
fn place_in(n: usize, position: i64) -> Result<usize, Error> {
    let too_far = || {
        let most = i64::try_from(n).unwrap_or(i64::MAX).saturating_add(1);
        Error::PositionTooFar { position, most }
    };
    let from_end = usize::try_from(position.unsigned_abs()).map_err(|_| too_far())?;
    if from_end == 0 {
        return Err(Error::BadPosition(position));
    }
    let at = if position > 0 { Some(from_end - 1) } else { (n + 1).checked_sub(from_end) };
    at.filter(|at| *at <= n).ok_or_else(too_far)
}

#[cfg(test)]
mod tests {
    use super::place_in;

    fn check(n: usize, position: i64, want: Result<usize, &str>) {
        let got = place_in(n, position).map_err(|e| e.to_string());
        assert_eq!(got, want.map_err(str::to_owned), "{position} of {n}");
    }

    #[test]
    fn positions_in_a_list_and_out_of_it() {
        for (n, position, at) in
            [(0, 1, 0), (0, -1, 0), (2, 1, 0), (2, 3, 2), (2, -1, 2), (2, -2, 1), (2, -3, 0)]
        {
            check(n, position, Ok(at));
        }
        check(2, 4, Err("position '4' is too high"));
        check(2, -4, Err("position '-4' is too low"));
        check(0, i64::MAX, Err("position '9223372036854775807' is too high"));
        check(0, i64::MIN, Err("position '-9223372036854775808' is too low"));
        check(2, i64::MIN + 1, Err("position '-9223372036854775807' is too low"));
        check(2, 0, Err("bad position: 0"));
    }
}
