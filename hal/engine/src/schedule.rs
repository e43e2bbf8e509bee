//! Threads and the functions in them.

use crate::{
    Engine, Error,
    change::Change,
    graph::{Component, Edge, Ix, Node, ThreadNode},
    name::Name,
    os,
    sync::Arc,
    thread::{Entry, List, Thread},
};
use hal_protocol::{ComponentState, Direction, Lock, Type};
use petgraph::{Direction::Outgoing, visit::EdgeRef};

/// The shortest and the longest period, in nanoseconds.
const PERIODS: core::ops::RangeInclusive<i64> = 1_000..=1_000_000_000_000;

impl Engine {
    /// Makes a thread with its pseudo component; it begins to tick in [`Self::begin_thread`].
    pub(crate) fn new_thread(&mut self, name: Name, period: i64) -> Result<Ix, Error> {
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
        let made = self.furnish_thread(component, &name, period);
        if made.is_err() {
            self.remove_component(component);
        }
        made
    }

    fn furnish_thread(&mut self, component: Ix, name: &Name, period: i64) -> Result<Ix, Error> {
        let account = self.new_account(component, name, false)?;
        let beat = crate::item::NewItem {
            name: Name::parse("pin", &format!("{name}.threadbeat"))?,
            other: None,
            ty: Type::S64,
            direction: Direction::Out,
            initial: 0,
            storage: None,
            hidden: false,
            times: true,
            doc: self.graph.doc("Cycles run."),
        };
        let (_, beat) = self.new_item(component, beat)?;
        let due = if self.shared.is_virtual() {
            (self.shared.now() / period + 1) * period
        } else {
            // A millisecond is left for the thread to come up.
            let soon = self.shared.now() + 1_000_000;
            self.shared.origin() + (soon / period + 1) * period
        };
        let timed = !self.shared.is_virtual();
        let beat = beat.map(crate::code::Ptr).ok_or(Error::OutOfMemory)?;
        let id = self.next_thread;
        self.next_thread += 1;
        let thread = Arc::new(Thread::new(id, period, account, beat, timed, due));
        let node = ThreadNode { name: name.clone(), thread, next: 0, stale: false };
        let ix = self.graph.g.add_node(Node::Thread(node));
        self.graph.g.add_edge(component, ix, Edge::Owns);
        self.graph.threads.insert(name.clone(), ix);
        Ok(ix)
    }

    /// A new component.
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
        let component = Component {
            id: self.next_component,
            name: name.clone(),
            pid,
            realtime,
            state: if realtime { ComponentState::Ready } else { ComponentState::Initializing },
            args,
            commands: Vec::new(),
            stops: Vec::new(),
            services: Vec::new(),
        };
        self.next_component += 1;
        let ix = self.graph.g.add_node(Node::Component(component));
        self.graph.components.insert(name, ix);
        Ok(ix)
    }

    /// From now on the thread ticks.
    pub(crate) fn begin_thread(&mut self, ix: Ix) -> Result<(), Error> {
        let Some(thread) = self.graph.thread(ix).map(|t| t.thread.clone()) else { return Ok(()) };
        let mut all = self.shared.threads.load().to_vec();
        let rank = all.len();
        all.push(thread.clone());
        let old = self.shared.threads.swap(Arc::new(all));
        self.retire_threads(old);
        if self.shared.is_virtual() {
            return Ok(());
        }
        self.runners.begin(&thread, rank).map_err(|e| Error::System {
            what: "no thread of the system could be started",
            why: os::said(&e),
        })
    }

    /// Ends threads: they tick no more when this returns.
    pub(crate) fn end_threads(&mut self, nodes: &[Ix]) -> Result<(), Error> {
        let ids: Vec<u32> =
            nodes.iter().filter_map(|ix| self.graph.thread(*ix)).map(|t| t.thread.id).collect();
        let mut all = self.shared.threads.load().to_vec();
        for t in all.iter().filter(|t| ids.contains(&t.id)) {
            t.end.store(true, crate::sync::Ordering::Relaxed);
        }
        all.retain(|t| !ids.contains(&t.id));
        let old = self.shared.threads.swap(Arc::new(all));
        self.retire_threads(old.clone());
        if self.shared.is_virtual() {
            return Ok(());
        }
        let longest = old.iter().map(|t| t.period_ns).max().unwrap_or(0);
        let patience = longest.saturating_mul(2).saturating_add(2_000_000_000);
        let limit = os::monotonic_ns() + patience;
        for t in old.iter().filter(|t| ids.contains(&t.id)) {
            while t.gate.is_inside() && os::monotonic_ns() < limit {
                os::sleep_until(os::monotonic_ns() + 20_000);
            }
        }
        if self.runners.end(&ids, false, patience) { Ok(()) } else { Err(self.stuck()) }
    }

    /// Whether functions of a thread, or of all, are timed.
    pub(crate) fn time_functs(&self, thread: Option<&str>, on: bool) -> Result<(), Error> {
        let threads = match thread {
            Some(name) => vec![self.graph.find_thread(name)?],
            None => self.graph.threads.values().copied().collect(),
        };
        for t in threads.into_iter().filter_map(|ix| self.graph.thread(ix)) {
            t.thread.timed.store(on, crate::sync::Ordering::Relaxed);
        }
        Ok(())
    }

    /// What a thread is to run, without the functions that go.
    pub(crate) fn list_of(&self, thread: Ix, without: &[Ix]) -> List {
        let entries = |init: bool| {
            let functs = self.graph.runs(thread, init);
            let functs = functs.into_iter().filter(|ix| !without.contains(ix));
            functs
                .filter_map(|ix| {
                    let f = self.graph.funct(ix)?;
                    let id = u32::try_from(ix.index()).ok()?;
                    Some(Entry::new(id, f.code.clone(), f.account))
                })
                .collect()
        };
        List { init: entries(true), entries: entries(false) }
    }

    /// Gives threads the lists that their edges say.
    pub(crate) fn renew_lists(&mut self) -> Result<(), Error> {
        let mut change = Change::default();
        let stale: Vec<Ix> = self
            .graph
            .threads
            .values()
            .copied()
            .filter(|ix| self.graph.thread(*ix).is_some_and(|t| t.stale))
            .collect();
        for ix in &stale {
            if let Some(t) = self.graph.thread(*ix) {
                change.lists.push((t.thread.clone(), Arc::new(self.list_of(*ix, &[]))));
            }
        }
        self.carry_out(change)?;
        for ix in stale {
            if let Some(t) = self.graph.thread_mut(ix) {
                t.stale = false;
            }
        }
        Ok(())
    }

    /// `addf`, `initf`.
    pub(crate) fn add_funct(
        &mut self,
        funct: &str,
        thread: &str,
        position: i64,
        init: bool,
    ) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "add_funct_to_thread")?;
        if position == 0 {
            return Err(Error::BadPosition { position });
        }
        let f = self.graph.find_funct(funct)?;
        let t = self.graph.find_thread(thread)?;
        if let Some(node) = self.graph.funct(f)
            && node.users > 0
            && !node.reentrant
        {
            return Err(Error::OneThreadOnly { funct: funct.into() });
        }
        let done = |node: &ThreadNode| node.thread.init_done.load(crate::sync::Ordering::Relaxed);
        if init && self.graph.thread(t).is_some_and(done) {
            return Err(Error::InitDone { thread: thread.into(), funct: funct.into() });
        }
        let edge = |at| if init { Edge::Begins(at) } else { Edge::Runs(at) };
        let added = if position == -1 {
            let Some(node) = self.graph.thread_mut(t) else { return Ok(()) };
            node.next += 1;
            let at = node.next;
            self.graph.g.add_edge(t, f, edge(at))
        } else {
            self.insert_at(t, f, position, init)?
        };
        if let Some(node) = self.graph.funct_mut(f) {
            node.users += 1;
        }
        if let Err(e) = self.changed(t) {
            self.graph.g.remove_edge(added);
            if let Some(node) = self.graph.funct_mut(f) {
                node.users -= 1;
            }
            return Err(e);
        }
        Ok(())
    }

    /// Draws the edge at a position counted from the start or the end; the others move.
    fn insert_at(
        &mut self,
        t: Ix,
        f: Ix,
        position: i64,
        init: bool,
    ) -> Result<petgraph::stable_graph::EdgeIndex<u32>, Error> {
        let order = self.graph.runs(t, init);
        let n = i64::try_from(order.len()).unwrap_or(i64::MAX);
        let at = if position > 0 {
            if position > n + 1 {
                return Err(Error::PositionTooHigh { position, most: n + 1 });
            }
            position - 1
        } else {
            if -position > n + 1 {
                return Err(Error::PositionTooLow { position, most: n + 1 });
            }
            n + 1 + position
        };
        let at = usize::try_from(at).unwrap_or(0);
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
            let place = if i < at { i + 1 } else { i + 2 } as u64;
            if let Some(w) = self.graph.g.edge_weight_mut(*id) {
                *w = edge(place);
            }
        }
        if let Some(node) = self.graph.thread_mut(t) {
            node.next = node.next.max(edges.len() as u64 + 1);
        }
        Ok(self.graph.g.add_edge(t, f, edge(at as u64 + 1)))
    }

    /// A thread's edges have changed: its list follows now, or at the next `start`.
    fn changed(&mut self, t: Ix) -> Result<(), Error> {
        if let Some(node) = self.graph.thread_mut(t) {
            node.stale = true;
        }
        if self.shared.boundary.is_running() { self.renew_lists() } else { Ok(()) }
    }

    /// `delf`.
    pub(crate) fn remove_funct(&mut self, funct: &str, thread: Option<&str>) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "del_funct_from_thread")?;
        let f = self.graph.find_funct(funct)?;
        let mut threads = self.graph.threads_of(f);
        if let Some(name) = thread {
            let t = self.graph.find_thread(name)?;
            if !threads.contains(&t) {
                let thread = name.into();
                return Err(Error::NotInThread { funct: funct.into(), thread });
            }
            threads = vec![t];
        }
        if threads.is_empty() {
            return Err(Error::NotInUse { funct: funct.into() });
        }
        for t in threads {
            let edges: Vec<_> = self
                .graph
                .g
                .edges_connecting(t, f)
                .filter(|e| matches!(e.weight(), Edge::Runs(_) | Edge::Begins(_)))
                .map(|e| (e.id(), *e.weight()))
                .collect();
            for (id, _) in &edges {
                self.graph.g.remove_edge(*id);
            }
            if let Err(e) = self.changed(t) {
                for (_, w) in edges {
                    self.graph.g.add_edge(t, f, w);
                }
                return Err(e);
            }
            if let Some(node) = self.graph.funct_mut(f) {
                node.users =
                    node.users.saturating_sub(u32::try_from(edges.len()).unwrap_or(u32::MAX));
            }
        }
        Ok(())
    }
}
