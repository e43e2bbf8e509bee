//! Transactions: the effects of requests are staged first, then carried out as a whole at one
//! boundary, or reverted as a whole. A single request is a transaction of one; `apply` is a
//! transaction of many.

use crate::{
    Engine, Error,
    change::apply::part,
    change::stores::{Change, MAX_STORES, Store},
    change::undo::{Index, Order, Undo},
    engine::Counts,
    graph::Ix,
    graph::arena::Mark,
    graph::ptr::Ptr,
    name::Name,
    sync::Arc,
};
use hal_abi::{Cell, Slot};
use hal_protocol::{Edit, Lock, Reply, Request};
use std::collections::{BTreeMap, BTreeSet};

/// A thing that is removed after the transaction has been carried out.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Going {
    /// A signal that has lost its name.
    Signal(Ix),
    /// A component that has lost its name.
    Component {
        /// The component's node.
        ix: Ix,
        /// True if its stop actions run first.
        stop: bool,
    },
}

impl Going {
    const fn component(&self) -> Option<Ix> {
        match *self {
            Self::Component { ix, .. } => Some(ix),
            Self::Signal(_) => None,
        }
    }
}

/// The staged effects of a transaction.
#[derive(Debug, Default)]
pub(crate) struct Transaction {
    /// True for a dry run: the transaction is only checked, and nothing is opened or started.
    pub(crate) dry: bool,
    /// Stores in the order of the lines.
    pub(crate) stores: Vec<Store>,
    pub(crate) going: Vec<Going>,
    /// New threads, which run from the end of the transaction on.
    pub(crate) begins: Vec<Ix>,
    /// Probes that watch something that is removed.
    pub(crate) parting: BTreeSet<u64>,
    /// True if threads are started at the end.
    pub(crate) starts: bool,
    undo: Vec<Undo>,
    orders: BTreeMap<Ix, Order>,
    before: Option<Before>,
    /// `seen`: addresses of new slots and cells that threads see before the boundary. `own`:
    /// addresses in the own memory of new components, which no thread uses yet.
    pub(crate) seen: BTreeSet<usize>,
    pub(crate) own: BTreeSet<usize>,
}

/// State that a reverted transaction simply restores.
#[derive(Debug)]
struct Before {
    counts: Counts,
    lock: Lock,
    next: (u32, u32),
    mark: Mark,
}

/// Numbers of stores and lists that a transaction carried out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    pub(crate) stores: usize,
    pub(crate) lists: usize,
}

impl Transaction {
    /// Records how to revert a step.
    pub(crate) fn undo_by(&mut self, undo: Undo) {
        self.undo.push(undo);
    }

    /// Returns whether this transaction unloads a component of this name.
    fn unloads(&self, name: &str) -> bool {
        let unnamed =
            |u: &Undo| matches!(u, Undo::Unnamed(Index::Components, n, _) if n.as_str() == name);
        self.undo.iter().any(unnamed)
    }
}

impl Engine {
    /// Runs an edit as a transaction: it takes effect completely or not at all.
    pub(crate) fn whole(
        &mut self,
        edit: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<Taken, Error> {
        self.begin();
        let done = edit(self).and_then(|()| self.commit());
        if done.is_err() {
            self.roll_back();
        }
        done
    }

    fn begin(&mut self) {
        let before = Before {
            counts: self.counts,
            lock: self.lock,
            next: (self.next_component, self.next_thread),
            mark: self.arena.mark(),
        };
        self.staged = Transaction { before: Some(before), ..Transaction::default() };
    }

    /// `apply`: carries out every edit or none.
    pub(crate) fn apply(
        &mut self,
        files: &[String],
        edits: &[Edit],
        dry: bool,
    ) -> Result<Reply, Error> {
        let mut at = 0;
        let mut refused = false;
        let stood = self.graph.sites.visit(None);
        let done = self.whole(|e| {
            e.staged.dry = dry;
            refused = true;
            for (i, edit) in edits.iter().enumerate() {
                at = i;
                if let Some(file) = files.get(edit.file as usize) {
                    e.graph.sites.stand(file, edit.line);
                }
                e.stage(&edit.request).unwrap_or_else(|| {
                    Err(Error::Protocol { why: "this does not change the graph".into() })
                })?;
            }
            refused = false;
            Ok(())
        });
        self.graph.sites.resume(stood);
        match done {
            Err(e) if refused => {
                let edit = u32::try_from(at).unwrap_or(u32::MAX);
                Ok(Reply::Refused { edit, failure: e.into() })
            }
            Err(e) => Err(e),
            Ok(taken) => {
                let n = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
                Ok(Reply::Applied { stores: n(taken.stores), lists: n(taken.lists) })
            }
        }
    }

    /// Stages a request. Returns `None` if the request does not change the graph, its names or its
    /// values.
    pub(crate) fn stage(&mut self, request: &Request) -> Option<Result<(), Error>> {
        Some(match request {
            Request::Load { module, args } => {
                self.load_again(module).and_then(|()| self.load(module, args))
            }
            Request::LoadForeign { module, args, prefix } => self
                .load_again(&format!("{prefix}{module}"))
                .and_then(|()| self.load_foreign(module, args, prefix)),
            Request::Unload { name } => self.unload(name),
            Request::UnloadAll => self.unload_all(),
            Request::NewSignal { name, ty } => self.new_signal(name, *ty).map(|_| ()),
            Request::DeleteSignal { name: Some(name) } => self.delete_signal(name),
            Request::DeleteSignal { name: None } => self.delete_all_signals(),
            Request::Net { signal, pins } => self.net(signal, pins),
            Request::Link { pin, signal } => self.link(pin, signal),
            Request::Unlink { pin } => self.unlink(pin),
            Request::Set { name, value } => self.set_item(name, value),
            Request::SetSignal { name, value } => self.set_signal(name, value),
            Request::AddFunct { funct, thread, position, init } => {
                self.add_funct(funct, thread, *position, *init)
            }
            Request::RemoveFunct { funct, thread } => self.remove_funct(funct, thread.as_deref()),
            Request::Start => self.start_threads(),
            Request::Alias { param, name, alias } => self.alias(*param, name, alias),
            Request::Unalias { param, name } => self.unalias(*param, name),
            Request::SetLock { level } => {
                self.lock = *level;
                Ok(())
            }
            Request::ClearLock { bits } => {
                self.lock = Lock(self.lock.0 & !bits.0);
                Ok(())
            }
            _ => return None,
        })
    }

    /// Refuses to load a component that this transaction unloads: until the commit it is still
    /// there, with its devices.
    fn load_again(&self, module: &str) -> Result<(), Error> {
        if !self.staged.unloads(module) {
            return Ok(());
        }
        Err(Error::InitFailed {
            name: module.into(),
            why: "unloaded and loaded again at once: the old one still has its devices; do it in \
                  two files"
                .into(),
            code: -16,
        })
    }

    /// Gives a node a name.
    pub(crate) fn name_node(&mut self, index: Index, name: Name, ix: Ix) {
        self.graph.index_mut(index).insert(name.clone(), ix);
        self.staged.undo_by(Undo::Named(index, name));
    }

    /// Removes a node's name, if the name belongs to the node.
    pub(crate) fn unname(&mut self, index: Index, name: &Name, ix: Ix) {
        let names = self.graph.index_mut(index);
        if names.get(name) == Some(&ix)
            && let Some((name, ix)) = names.remove_entry(name)
        {
            self.staged.undo_by(Undo::Unnamed(index, name, ix));
        }
    }

    /// Records the functions of a thread before they change.
    pub(crate) fn touch_thread(&mut self, thread: Ix) {
        self.extend_thread(thread);
        if let Some(order) = self.staged.orders.get_mut(&thread) {
            self.graph.note_order(thread, order);
        }
    }

    /// Records the end of a thread before a function is added there.
    pub(crate) fn extend_thread(&mut self, thread: Ix) {
        if !self.staged.orders.contains_key(&thread)
            && let Some(end) = self.graph.end_of(thread)
        {
            self.staged.orders.insert(thread, end);
        }
        if let Some(node) = self.graph.thread_mut(thread) {
            node.stale = true;
        }
    }

    /// Marks a new slot as visible, because its own thread writes it from the first cycle on.
    pub(crate) fn sees(&mut self, slot: Ptr<Slot>) {
        let cell: Ptr<Cell> = crate::graph::ptr::own_cell(slot);
        self.staged.seen.extend([slot.0.addr().get(), cell.0.addr().get()]);
    }

    /// Carries out the staged effects.
    fn commit(&mut self) -> Result<Taken, Error> {
        let faulty = self.staged.starts && self.fault.is_some();
        if faulty && !self.staged.dry {
            self.shared.boundary.stop();
            self.settle()?;
        }
        let stale = self.stale_threads();
        let mut change =
            Change { stores: core::mem::take(&mut self.staged.stores), lists: Vec::new() };
        for ix in &stale {
            if let Some(t) = self.graph.thread(*ix) {
                change.lists.push((t.thread.clone(), Arc::new(self.list_of(*ix))));
            }
        }
        let (early, change) = self.weigh(change)?;
        let taken = Taken { stores: change.stores.len(), lists: change.lists.len() };
        if self.staged.dry {
            self.roll_back();
            return Ok(taken);
        }
        for ix in core::mem::take(&mut self.staged.begins) {
            self.begin_thread(ix)?;
        }
        early.iter().for_each(Store::carry_out);
        self.carry_out(&change)?;
        for ix in stale {
            if let Some(t) = self.graph.thread_mut(ix) {
                t.stale = false;
            }
        }
        if faulty {
            self.fault = None;
            self.shared.fault.clear();
        }
        let done = core::mem::take(&mut self.staged);
        if done.undo.iter().any(|u| !matches!(u, Undo::Assigned(..))) {
            self.flight_is_stale();
        }
        if done.undo.iter().any(|u| matches!(u, Undo::Opened(_))) {
            self.lock_more();
        }
        if done.starts {
            self.run_threads();
        }
        if let Some(before) = done.before {
            self.arena.keep(before.mark);
        }
        if !done.going.is_empty() {
            self.left.extend(done.going.iter().filter_map(Going::component));
            self.have_parted(done.parting);
            done.going.iter().for_each(|going| self.release(*going));
            self.reap();
            if !self.shared.is_virtual() && self.shared.boundary.is_running() {
                // Before the memory of removed things is reused.
                self.refresh_flight();
            }
        }
        if let Err(e) = self.follow_fastest() {
            self.notice(e.to_string());
        }
        Ok(taken)
    }

    /// Splits a change into stores to places that no thread can see, which need no boundary, and
    /// the rest.
    fn weigh(&self, change: Change) -> Result<(Vec<Store>, Change), Error> {
        let threads = !self.shared.threads.load().is_empty() || !self.staged.begins.is_empty();
        if !threads || !self.shared.boundary.is_running() || self.shared.is_virtual() {
            return Ok((Vec::new(), change));
        }
        let (new, again) = self
            .staged
            .before
            .as_ref()
            .map_or_else(|| (0..0, BTreeSet::new()), |before| self.arena.since(&before.mark));
        let fresh = |place: usize| {
            let is_new = new.contains(&place) || again.contains(&place);
            is_new && !self.staged.seen.contains(&place) || self.staged.own.contains(&place)
        };
        let (early, late) = part(change.stores, fresh);
        if late.len() > MAX_STORES {
            return Err(Error::TooManyStores { stores: late.len() });
        }
        Ok((early, Change { stores: late, lists: change.lists }))
    }

    /// Returns the threads whose lists must be rebuilt from their edges now. While threads are
    /// stopped, lists are rebuilt at the next `start`, unless something is removed that an old list
    /// may hold.
    fn stale_threads(&self) -> Vec<Ix> {
        let now = self.shared.boundary.is_running()
            || self.staged.starts
            || (!self.staged.orders.is_empty() && !self.staged.going.is_empty());
        if !now || (self.staged.orders.is_empty() && !self.staged.starts) {
            return Vec::new();
        }
        let touched = self.staged.orders.keys().copied();
        let mut all: Vec<Ix> = self.graph.threads.values().copied().chain(touched).collect();
        all.retain(|ix| self.graph.thread(*ix).is_some_and(|t| t.stale));
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Reverts everything.
    fn roll_back(&mut self) {
        let staged = core::mem::take(&mut self.staged);
        let Some(before) = staged.before else { return };
        let clean = self.take_back(staged.undo, staged.orders);
        self.lock = before.lock;
        self.counts = before.counts;
        if clean {
            (self.next_component, self.next_thread) = before.next;
            self.arena.roll_back(before.mark);
        } else {
            self.arena.keep(before.mark);
        }
        self.reap();
    }
}
