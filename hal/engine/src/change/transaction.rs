//! Transactions: the effects of requests are staged first, then carried out as a whole at one
//! boundary, or reverted as a whole. A single request is a transaction of one; `apply` is a
//! transaction of many.

use crate::{
    Engine, Error,
    change::staged::PendingRemoval,
    change::stores::{Change, Store},
    change::undo::Undo,
    graph::Ix,
    realtime::runtime::TIMEOUT_NS,
    sync::Arc,
};
use hal_protocol::{ByClass, Edit, EditRequest, Lock, Reply};

/// Numbers of stores and lists that a transaction carried out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    pub(crate) stores: usize,
    pub(crate) lists: usize,
}

impl Engine {
    /// Runs an edit as a transaction: it takes effect completely or not at all.
    pub(crate) fn transact(
        &mut self,
        edit: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<Taken, Error> {
        self.model.begin();
        let done = edit(self).and_then(|()| self.commit());
        if done.is_err() {
            self.roll_back();
        }
        done
    }

    /// `apply`: carries out every edit or none.
    pub(crate) fn apply(
        &mut self,
        files: &[String],
        edits: Vec<Edit>,
        dry: bool,
    ) -> Result<Reply, Error> {
        let mut at = 0;
        let mut refused = false;
        let stood = self.model.visit(None);
        let done = self.transact(|e| {
            if dry {
                e.model.staged_mut().only_check();
            }
            refused = true;
            for (i, edit) in edits.into_iter().enumerate() {
                at = i;
                if let Some(file) = files.get(edit.file as usize) {
                    e.model.stand(file, edit.line);
                }
                let ByClass::Edit(request) = edit.request.by_class() else {
                    return Err(Error::Protocol { why: "this does not change the graph".into() });
                };
                e.stage(&request)?;
            }
            refused = false;
            Ok(())
        });
        self.model.resume(stood);
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

    /// Stages an edit.
    pub(crate) fn stage(&mut self, request: &EditRequest) -> Result<(), Error> {
        match request {
            EditRequest::Load { module, args } => {
                self.load_again(module).and_then(|()| self.load(module, args))
            }
            EditRequest::LoadForeign { module, args, prefix } => self
                .load_again(&format!("{prefix}{module}"))
                .and_then(|()| self.load_foreign(module, args, prefix)),
            EditRequest::Unload { name } => self.model.unload(name),
            EditRequest::UnloadAll => self.model.unload_all(),
            EditRequest::NewSignal { name, ty } => self.model.new_signal(name, *ty).map(|_| ()),
            EditRequest::DeleteSignal { name: Some(name) } => self.model.delete_signal(name),
            EditRequest::DeleteSignal { name: None } => self.model.delete_all_signals(),
            EditRequest::Net { signal, pins } => self.model.net(signal, pins),
            EditRequest::Link { pin, signal } => self.model.link(pin, signal),
            EditRequest::Unlink { pin } => self.model.unlink(pin),
            EditRequest::Set { name, value } => self.model.set_item(name, value),
            EditRequest::SetSignal { name, value } => self.model.set_signal(name, value),
            EditRequest::AddFunct { funct, thread, position, init } => {
                self.model.add_funct(funct, thread, *position, *init)
            }
            EditRequest::RemoveFunct { funct, thread } => {
                self.model.remove_funct(funct, thread.as_deref())
            }
            EditRequest::Start => self.start_threads(),
            EditRequest::Alias { param, name, alias } => self.model.alias(*param, name, alias),
            EditRequest::Unalias { param, name } => self.model.unalias(*param, name),
            EditRequest::SetLock { level } => {
                self.model.set_lock(*level);
                Ok(())
            }
            EditRequest::ClearLock { bits } => {
                self.model.set_lock(Lock(self.model.lock().0 & !bits.0));
                Ok(())
            }
        }
    }

    /// Refuses to load a component that this transaction unloads: until the commit it is still
    /// there, with its devices.
    fn load_again(&self, module: &str) -> Result<(), Error> {
        if !self.model.staged().unloads(module) {
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

    /// Carries out the staged effects.
    fn commit(&mut self) -> Result<Taken, Error> {
        self.end_probes(&self.model.removed_nodes());
        let staged = self.model.staged();
        let (dry, starts) = (staged.is_dry(), staged.starts());
        let faulty = starts && self.runtime.fault().is_some();
        if faulty && !dry {
            self.runtime.stop()?;
        }
        let stale = self.model.stale_threads(self.runtime.is_running());
        let mut change =
            Change { stores: self.model.staged_mut().take_stores(), lists: Vec::new() };
        for ix in &stale {
            if let Some(t) = self.model.graph().thread(*ix) {
                change.lists.push((t.thread.clone(), Arc::new(self.list_of(*ix))));
            }
        }
        let threads = self.runtime.has_threads() || self.model.staged().has_new_threads();
        let is_visible = threads && self.runtime.is_running() && !self.runtime.is_virtual();
        let (early, change) =
            if is_visible { self.model.split(change)? } else { (Vec::new(), change) };
        let taken = Taken { stores: change.stores.len(), lists: change.lists.len() };
        if dry {
            self.roll_back();
            return Ok(taken);
        }
        self.hold_workers()?;
        for ix in self.model.staged_mut().take_new_threads() {
            self.begin_thread(ix)?;
        }
        if !self.runtime.is_dry_run() {
            self.workers.start()?;
        }
        early.iter().for_each(Store::apply);
        self.runtime.commit(&change)?;
        if !self.runtime.is_dry_run() {
            self.workers.release();
        }
        self.model.have_lists(stale);
        if faulty {
            self.runtime.clear_fault();
        }
        self.has_committed();
        Ok(taken)
    }

    /// Keeps the workers of components that are about to be unloaded from further steps. If one of
    /// them does not return, nothing is unloaded.
    fn hold_workers(&self) -> Result<(), Error> {
        let leaving =
            self.model.staged().pending_removal().iter().filter_map(PendingRemoval::component);
        let leaving: Vec<Ix> = leaving.collect();
        if self.workers.is_empty() || leaving.is_empty() {
            return Ok(());
        }
        self.runtime.control().be_patient();
        let held = leaving.iter().try_for_each(|ix| self.workers.hold(*ix, TIMEOUT_NS));
        self.runtime.control().have_waited();
        held
    }

    /// Completes a transaction whose stores and lists are in effect.
    fn has_committed(&mut self) {
        let mut done = self.model.take_staged();
        if done.changes_graph() {
            self.model.answer_measured();
            self.flight_is_stale();
        }
        if done.opens() {
            self.runtime.lock_more();
        }
        if done.starts() {
            self.run_threads();
        }
        let (pending_removal, ended_probes) =
            (done.take_pending_removal(), done.take_ended_probes());
        let (_log, _orders, before) = done.into_log();
        self.model.keep(before);
        if !pending_removal.is_empty() {
            self.model.has_left(pending_removal.iter().filter_map(PendingRemoval::component));
            self.remove_probes(ended_probes);
            pending_removal.iter().for_each(|removal| self.release(*removal));
            self.reap();
            if !self.runtime.is_virtual() && self.runtime.is_running() {
                // Before the memory of removed things is reused.
                self.refresh_flight();
            }
        }
        if let Err(e) = self.follow_fastest() {
            self.notice(e.to_string());
        }
    }

    /// Reverts everything, the last step first. If a new thread cannot be ended, everything it uses
    /// is kept until it ends.
    fn roll_back(&mut self) {
        let mut staged = self.model.take_staged();
        let pending_removal = staged.take_pending_removal();
        let (log, orders, before) = staged.into_log();
        let Some(before) = before else { return };
        pending_removal
            .iter()
            .filter_map(PendingRemoval::component)
            .for_each(|ix| self.workers.resume(ix));
        let mut clean = true;
        self.model.empty(&orders);
        for step in log.into_iter().rev() {
            match self.model.revert(step) {
                Some(Undo::Made(component)) => clean &= self.discard(component),
                Some(Undo::Opened(component)) => self.run_stops(&[component]),
                _ => {}
            }
        }
        self.model.refill(&orders);
        self.model.restore(before, clean);
        self.reap();
    }
}
