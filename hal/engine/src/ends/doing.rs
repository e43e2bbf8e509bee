//! The component code that runs in a thread, recorded when the code begins. A signal handler reads it.

use super::{
    board::{NOBODY, board},
    notes::note,
    text::Text,
};
use crate::{
    Error,
    load::args::Args,
    load::code::Code,
    name::Name,
    realtime::thread::Thread,
    sync::{Arc, AtomicU32, AtomicU64, Ordering},
};
use arc_swap::ArcSwapOption;
use core::{cell::Cell, marker::PhantomData, ptr::null};
use hal_abi::CommandRun;

/// Component code that the control side runs.
#[derive(Debug)]
pub(crate) struct Doing {
    component: Box<str>,
    what: Activity,
    /// Number by which the watcher knows it.
    number: u32,
}

/// Kind of component code.
#[derive(Debug)]
pub(crate) enum Activity {
    /// Everything that loading runs: a library's initialisation, `create`, opening.
    Load,
    /// A command, by its name.
    Command(Name),
    /// A background task, by its name.
    Task(Name),
    /// A worker, by its name.
    Worker(Name),
    /// A stop action.
    Stop,
    /// The code that frees a component.
    Unload,
}

impl Doing {
    pub(crate) fn new(component: &str, what: Activity) -> Arc<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let new = Self { component: component.into(), what, number };
        if board().is_some() {
            let mut text = Text::new();
            new.describe(&mut text);
            note(format_args!("d {number} {}", text.as_str()));
        }
        Arc::new(new)
    }

    /// Returns the component of a worker.
    pub(super) fn worker(&self) -> Option<&str> {
        match self.what {
            Activity::Worker(_) => Some(&self.component),
            _ => None,
        }
    }

    /// Appends the component and the kind of code.
    pub(crate) fn describe(&self, text: &mut Text) {
        text.add(format_args!("component '{}', ", self.component));
        match &self.what {
            Activity::Load => text.add(format_args!("as it is loaded")),
            Activity::Command(name) => text.add(format_args!("command '{name}'")),
            Activity::Task(name) => text.add(format_args!("task '{name}'")),
            Activity::Worker(name) => text.add(format_args!("worker '{name}'")),
            Activity::Stop => text.add(format_args!("stop action")),
            Activity::Unload => text.add(format_args!("as it is unloaded")),
        }
    }
}

thread_local! {
    /// Realtime thread whose cycle runs in this thread of the system.
    static CYCLE: Cell<*const Thread> = const { Cell::new(null()) };
    /// Other component code that runs in this thread.
    static DOING: Cell<*const Doing> = const { Cell::new(null()) };
    /// Stop action that runs in this thread.
    static STOP: Cell<*const Code<CommandRun>> = const { Cell::new(null()) };
}

/// Realtime. A cycle of this thread begins.
#[inline]
pub(crate) fn begin_cycle(thread: &Thread) {
    CYCLE.set(thread);
}

/// Realtime. The cycle of this thread has ended.
#[inline]
pub(crate) fn end_cycle() {
    CYCLE.set(null());
}

/// Runs a stop action in this thread. If it ends the process, it is not run a second time.
pub(crate) fn run_stop(stop: &Code<CommandRun>) -> Result<(), Error> {
    STOP.set(stop);
    let result = stop.call(Args::default());
    STOP.set(null());
    result.map(drop)
}

/// Returns whether this stop action runs in this thread.
pub(super) fn is_in(stop: &Code<CommandRun>) -> bool {
    core::ptr::eq(STOP.get(), stop)
}

/// Activity of the control side, as the guard sees it.
#[derive(Debug, Default)]
pub(crate) struct Control {
    /// Counter that increases with every step of the control side.
    beats: AtomicU64,
    doing: ArcSwapOption<Doing>,
    /// Number of waits in progress that end by themselves.
    patient: AtomicU32,
}

impl Control {
    /// Notes that the control side has made a step.
    pub(crate) fn beat(&self) {
        self.beats.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns the number of steps.
    pub(super) fn beats(&self) -> u64 {
        self.beats.load(Ordering::Relaxed)
    }

    /// Notes that the control side begins a wait that ends by itself soon.
    pub(crate) fn be_patient(&self) {
        self.patient.fetch_add(1, Ordering::Relaxed);
        self.beat();
    }

    /// Notes that such a wait is over.
    pub(crate) fn have_waited(&self) {
        self.beat();
        self.patient.fetch_sub(1, Ordering::Relaxed);
    }

    /// Returns whether the control side is in such a wait.
    pub(super) fn is_patient(&self) -> bool {
        self.patient.load(Ordering::Relaxed) > 0
    }

    /// Returns the component code that the control side is running.
    pub(super) fn doing(&self) -> Option<Arc<Doing>> {
        self.doing.load_full()
    }

    /// Notes that component code runs in the control side's thread, this one, until the returned
    /// value is dropped.
    pub(crate) fn run(&self, doing: Arc<Doing>) -> Within<'_> {
        self.beat();
        DOING.set(Arc::as_ptr(&doing));
        show(Some(&doing));
        let before = self.doing.swap(Some(doing));
        Within { control: self, before, thread: PhantomData }
    }
}

/// Notes that a worker runs in this thread, which is not the control side's, from here to the
/// thread's end.
pub(crate) fn run_worker(doing: &Arc<Doing>) {
    DOING.set(Arc::as_ptr(doing));
}

/// Publishes the running code for the watcher.
fn show(doing: Option<&Doing>) {
    if let Some(board) = board() {
        let number = doing.map_or(NOBODY, |d| d.number);
        board.doing.store(number, Ordering::Relaxed);
    }
}

/// Marks component code as running while it lives, and restores the code that ran around it.
#[derive(Debug)]
pub(crate) struct Within<'c> {
    control: &'c Control,
    before: Option<Arc<Doing>>,
    /// Makes the type `!Send`: the mark belongs to one thread.
    thread: PhantomData<*const ()>,
}

impl Drop for Within<'_> {
    fn drop(&mut self) {
        let before = self.before.take();
        DOING.set(before.as_ref().map_or(null(), Arc::as_ptr));
        show(before.as_deref());
        self.control.doing.store(before);
        self.control.beat();
    }
}

/// Origin of a component: its file, and the threads of its own that it began while it was loaded.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub(crate) file: Box<str>,
    pub(crate) component: Name,
    pub(crate) threads: Vec<i32>,
}

/// Returns the realtime thread whose cycle runs in this thread of the system.
pub(super) fn cycle<'t>() -> Option<&'t Thread> {
    // SAFETY: set for the time of a cycle, which the thread outlives.
    unsafe { CYCLE.get().as_ref() }
}

/// Returns the record of the other component code that runs in this thread.
pub(super) fn running<'d>() -> Option<&'d Doing> {
    // SAFETY: set for the time that the code runs, which the record outlives.
    unsafe { DOING.get().as_ref() }
}
