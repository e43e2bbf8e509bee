//! Workers of components: longer work than a task's. On the real clock each worker has an ordinary
//! thread of its own, which may wait for files. On the virtual clock the control side runs one step
//! of each worker at multiples of its period.

use crate::{
    Error,
    ends::{self, Control, Doing, Stack},
    graph::Ix,
    load::code::Code,
    name::Name,
    os,
    realtime::shared::{Shared, next_multiple},
    realtime::thread::NOBODY,
    sync::{Arc, AtomicBool, AtomicU64, Ordering},
};
use hal_abi::Work;
use hal_protocol::{Patterns, WorkerInfo, WorkerState};
use std::{
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
    time::Duration,
};

/// Instruction of the control side to a worker's thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Hold,
    Run,
    End,
}

#[derive(Debug)]
struct Phase {
    order: Order,
    /// True while a step is in progress.
    inside: bool,
}

/// Declaration of a worker.
#[derive(Debug)]
pub(crate) struct Declared {
    pub(crate) name: Name,
    /// Name of the component.
    pub(crate) owner: Name,
    pub(crate) doc: Box<str>,
    pub(crate) period_ns: i64,
    /// Largest number of items in a step.
    pub(crate) items: u32,
    /// Description of the running worker, for reports of the end of the process.
    pub(crate) doing: Arc<Doing>,
}

/// The part of a worker that its thread uses.
#[derive(Debug)]
struct Inner {
    id: u32,
    declared: Declared,
    shared: Arc<Shared>,
    phase: Mutex<Phase>,
    changed: Condvar,
    steps: AtomicU64,
    items: AtomicU64,
    failed: AtomicBool,
    /// The last field: the library may close with it.
    code: Code<Work>,
}

/// A worker. Its thread is ended when this value is dropped.
#[derive(Debug)]
pub(crate) struct Worker {
    pub(crate) owner: Ix,
    inner: Arc<Inner>,
    thread: Option<JoinHandle<()>>,
    /// True from the end of the transaction that loads the component.
    begun: bool,
    /// Virtual clock: machine time of the next step, in nanoseconds.
    due: i64,
}

/// The workers of an instance, in order of loading.
#[derive(Debug, Default)]
pub(crate) struct Workers {
    list: Vec<Worker>,
    next_id: u32,
}

impl Inner {
    fn phase(&self) -> MutexGuard<'_, Phase> {
        self.phase.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the first multiple of the period after now.
    fn next_due(&self) -> i64 {
        next_multiple(self.shared.now(), self.declared.period_ns)
    }

    /// Makes one step and returns its number of items. If the worker panics, motion stops.
    fn step(&self) -> Option<u32> {
        let most = self.declared.items;
        let status = self.code.work(most);
        self.steps.fetch_add(1, Ordering::Relaxed);
        if !status.is_ok() {
            self.failed.store(true, Ordering::Relaxed);
            self.shared.fault.set(NOBODY, self.id, &self.shared.cause);
            return None;
        }
        let items = u32::try_from(status.0).unwrap_or(0).min(most);
        self.items.fetch_add(items.into(), Ordering::Relaxed);
        Some(items)
    }

    /// Waits until the step that is due at this machine time may begin. Returns false if the thread
    /// is to end.
    fn enter(&self, due: i64) -> bool {
        let mut phase = self.phase();
        loop {
            let left = due.saturating_sub(self.shared.now());
            phase = match phase.order {
                Order::End => return false,
                Order::Run if left <= 0 => {
                    phase.inside = true;
                    return true;
                }
                Order::Hold => self.changed.wait(phase).unwrap_or_else(PoisonError::into_inner),
                Order::Run => {
                    let left = Duration::from_nanos(left.unsigned_abs());
                    let waited = self.changed.wait_timeout(phase, left);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }

    fn leave(&self) {
        self.phase().inside = false;
        self.changed.notify_all();
    }

    /// Code of the worker's thread.
    fn run(&self) {
        let _stack = Stack::new();
        ends::run_worker(&self.declared.doing);
        let mut due = self.next_due();
        while self.enter(due) {
            let done = self.step();
            self.leave();
            match done {
                Some(items) if items == self.declared.items => due = self.shared.now(),
                Some(_) => due = self.next_due(),
                None => {
                    self.shared.wait_for_cycles();
                    self.shared.stop_outputs();
                    return;
                }
            }
        }
    }
}

impl Worker {
    /// Gives an order to the thread. No order follows [`Order::End`].
    fn order(&self, order: Order) {
        let mut phase = self.inner.phase();
        if phase.order != Order::End {
            phase.order = order;
        }
        drop(phase);
        self.inner.changed.notify_all();
    }

    /// Waits until no step is in progress. Returns false if one takes longer than `patience_ns`.
    fn is_outside(&self, patience_ns: i64) -> bool {
        let limit = os::monotonic_ns().saturating_add(patience_ns);
        let mut phase = self.inner.phase();
        while phase.inside {
            let left = limit.saturating_sub(os::monotonic_ns());
            if left <= 0 {
                return false;
            }
            let left = Duration::from_nanos(left.unsigned_abs());
            let waited = self.inner.changed.wait_timeout(phase, left);
            phase = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }

    /// Starts the thread of a worker; it makes no step until it is ordered to run.
    fn start_thread(&mut self) -> Result<(), Error> {
        let inner = self.inner.clone();
        let named = std::thread::Builder::new().name("hal-worker".into());
        let thread = named.spawn(move || inner.run()).map_err(|e| Error::System {
            what: "no thread of the system could be started",
            why: os::said(&e),
        })?;
        self.thread = Some(thread);
        Ok(())
    }

    fn stuck(&self) -> Error {
        let Declared { name, owner, .. } = &self.inner.declared;
        let (worker, component) = (name.as_str().into(), owner.as_str().into());
        Error::WorkerStuck { worker, component }
    }

    fn state(&self) -> WorkerState {
        if self.inner.failed.load(Ordering::Relaxed) {
            WorkerState::Failed
        } else if self.inner.phase().inside {
            WorkerState::Working
        } else {
            WorkerState::Idle
        }
    }

    fn info(&self) -> WorkerInfo {
        let declared = &self.inner.declared;
        WorkerInfo {
            name: declared.name.as_str().to_owned(),
            owner_name: declared.owner.as_str().to_owned(),
            period: declared.period_ns,
            most: declared.items,
            steps: self.inner.steps.load(Ordering::Relaxed),
            items: self.inner.items.load(Ordering::Relaxed),
            state: self.state(),
            doc: declared.doc.to_string(),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.order(Order::End);
        // A thread that is still in a step keeps the code and ends after it.
        if self.is_outside(0)
            && let Some(thread) = self.thread.take()
        {
            drop(thread.join());
        }
    }
}

impl Workers {
    /// Adds a worker, which makes no step before [`Workers::release`].
    pub(crate) fn add(
        &mut self,
        owner: Ix,
        declared: Declared,
        code: Code<Work>,
        shared: Arc<Shared>,
    ) {
        let inner = Arc::new(Inner {
            id: self.next_id,
            declared,
            shared,
            phase: Mutex::new(Phase { order: Order::Hold, inside: false }),
            changed: Condvar::new(),
            steps: AtomicU64::new(0),
            items: AtomicU64::new(0),
            failed: AtomicBool::new(false),
            code,
        });
        self.next_id = self.next_id.wrapping_add(1);
        self.list.push(Worker { owner, inner, thread: None, begun: false, due: i64::MAX });
    }

    /// Returns whether a component has a worker of this name.
    pub(crate) fn has(&self, name: &Name) -> bool {
        self.list.iter().any(|w| w.inner.declared.name == *name)
    }

    /// Returns the component and name of a worker, by its number.
    pub(crate) fn named(&self, id: u32) -> Option<(&Name, &Name)> {
        let worker = self.list.iter().find(|w| w.inner.id == id)?;
        Some((&worker.inner.declared.owner, &worker.inner.declared.name))
    }

    /// Returns the name of a worker that has failed and is still loaded.
    pub(crate) fn failed(&self) -> Option<&Name> {
        let failed = self.list.iter().find(|w| w.inner.failed.load(Ordering::Relaxed));
        failed.map(|w| &w.inner.declared.name)
    }

    /// Returns the descriptions of the workers.
    pub(crate) fn list(&self, p: &Patterns) -> Vec<WorkerInfo> {
        self.list.iter().map(Worker::info).filter(|w| p.matches(&w.name)).collect()
    }

    /// Virtual clock: returns the machine time of the next step.
    pub(crate) fn next_due(&self) -> i64 {
        self.list.iter().map(|w| w.due).min().unwrap_or(i64::MAX)
    }

    /// Returns the number of steps that each worker has made at least, and the number of items of all.
    pub(crate) fn progress(&self) -> (u64, u64) {
        let count = |of: &AtomicU64| of.load(Ordering::Relaxed);
        let steps = self.list.iter().map(|w| count(&w.inner.steps)).min().unwrap_or(0);
        (steps, self.list.iter().map(|w| count(&w.inner.items)).sum())
    }

    /// Returns whether there is no worker.
    pub(crate) const fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Starts the threads of new workers on the real clock. They make no step yet.
    pub(crate) fn start(&mut self) -> Result<(), Error> {
        let new = self.list.iter_mut().filter(|w| !w.begun && w.thread.is_none());
        let mut real = new.filter(|w| !w.inner.shared.is_virtual());
        real.try_for_each(Worker::start_thread)
    }

    /// Lets new workers run, at the end of the transaction that has loaded their components.
    pub(crate) fn release(&mut self) {
        for worker in self.list.iter_mut().filter(|w| !w.begun) {
            worker.begun = true;
            if worker.inner.shared.is_virtual() {
                worker.due = worker.inner.next_due();
            }
            worker.order(Order::Run);
        }
    }

    /// Virtual clock: makes one step of every worker that is due, in order of loading.
    pub(crate) fn run_due(&mut self, now: i64, control: &Control) {
        for worker in self.list.iter_mut().filter(|w| w.due <= now) {
            worker.due = worker.inner.next_due();
            let _within = control.run(worker.inner.declared.doing.clone());
            if worker.inner.step().is_none() {
                worker.due = i64::MAX;
            }
        }
    }

    /// Keeps the workers of a component from further steps, so that it can be unloaded. Waits for
    /// each step in progress for at most `patience_ns`.
    pub(crate) fn hold(&self, component: Ix, patience_ns: i64) -> Result<(), Error> {
        let own = || self.list.iter().filter(|w| w.owner == component);
        own().for_each(|w| w.order(Order::Hold));
        own().find(|w| !w.is_outside(patience_ns)).map_or(Ok(()), |w| Err(w.stuck()))
    }

    /// Resumes the workers of a component that stays loaded.
    pub(crate) fn resume(&self, component: Ix) {
        let held = self.list.iter().filter(|w| w.begun && w.owner == component);
        held.for_each(|w| w.order(Order::Run));
    }

    /// Frees the workers of a component, and returns their names.
    pub(crate) fn free(&mut self, component: Ix) -> Vec<Name> {
        let all = core::mem::take(&mut self.list);
        let (own, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|w| w.owner == component);
        self.list = others;
        own.iter().map(|w| w.inner.declared.name.clone()).collect()
    }

    /// Ends all workers with the instance, and returns an error for each that does not return
    /// within `patience_ns`: it still uses its component.
    pub(crate) fn end(&self, patience_ns: i64) -> Vec<Error> {
        self.list.iter().for_each(|w| w.order(Order::End));
        let stuck = self.list.iter().filter(|w| !w.is_outside(patience_ns));
        stuck.map(Worker::stuck).collect()
    }
}
