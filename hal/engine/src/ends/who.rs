//! Which code of which component runs in a thread: noted as it begins, and found again by a signal
//! handler.

use super::{
    board::{NOBODY, board},
    maps, sys,
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

/// Code of a component that the control side runs.
#[derive(Debug)]
pub(crate) struct Doing {
    component: Box<str>,
    what: What,
    /// By which those who look on know it.
    number: u32,
}

/// The kind of that code.
#[derive(Debug)]
pub(crate) enum What {
    /// All that a load runs: a library's own start, `create`, opening.
    Load,
    /// A command, by its name.
    Command(Name),
    /// A background task, by its name.
    Task(Name),
    /// A stop action.
    Stop,
    /// What frees a component.
    Unload,
}

impl Doing {
    pub(crate) fn new(component: &str, what: What) -> Arc<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let new = Self { component: component.into(), what, number };
        if board().is_some() {
            let mut text = Text::new();
            new.describe(&mut text);
            super::note(format_args!("d {number} {}", text.as_str()));
        }
        Arc::new(new)
    }

    /// The component, and which code of it.
    pub(crate) fn describe(&self, text: &mut Text) {
        text.add(format_args!("component '{}', ", self.component));
        match &self.what {
            What::Load => text.add(format_args!("as it is loaded")),
            What::Command(name) => text.add(format_args!("command '{name}'")),
            What::Task(name) => text.add(format_args!("task '{name}'")),
            What::Stop => text.add(format_args!("stop action")),
            What::Unload => text.add(format_args!("as it is unloaded")),
        }
    }
}

thread_local! {
    /// The thread whose cycle runs in this thread of the system.
    static CYCLE: Cell<*const Thread> = const { Cell::new(null()) };
    /// The other code that runs in it.
    static DOING: Cell<*const Doing> = const { Cell::new(null()) };
    /// The stop action that runs in it.
    static STOP: Cell<*const Code<CommandRun>> = const { Cell::new(null()) };
}

/// Realtime. A cycle of this thread begins.
#[inline]
pub(crate) fn begin_cycle(thread: &Thread) {
    CYCLE.set(thread);
}

/// Realtime. It has ended.
#[inline]
pub(crate) fn end_cycle() {
    CYCLE.set(null());
}

/// Runs a stop action in this thread. If the process ends in it, it is not run once more.
pub(crate) fn run_stop(stop: &Code<CommandRun>) -> Result<(), Error> {
    STOP.set(stop);
    let result = stop.call(Args::default());
    STOP.set(null());
    result.map(drop)
}

/// Whether this stop action runs in this thread.
pub(super) fn is_in(stop: &Code<CommandRun>) -> bool {
    core::ptr::eq(STOP.get(), stop)
}

/// What the control side does, for those who look on.
#[derive(Debug, Default)]
pub(crate) struct Control {
    /// Goes on with every step of the control side.
    beats: AtomicU64,
    doing: ArcSwapOption<Doing>,
    /// How many waits are under way that come to an end by themselves.
    patient: AtomicU32,
}

impl Control {
    /// The control side has come on by a step.
    pub(crate) fn beat(&self) {
        self.beats.fetch_add(1, Ordering::Relaxed);
    }

    /// How many steps it has made.
    pub(super) fn beats(&self) -> u64 {
        self.beats.load(Ordering::Relaxed)
    }

    /// From here on it waits for something, and not for long.
    pub(crate) fn be_patient(&self) {
        self.patient.fetch_add(1, Ordering::Relaxed);
        self.beat();
    }

    /// That wait is over.
    pub(crate) fn have_waited(&self) {
        self.beat();
        self.patient.fetch_sub(1, Ordering::Relaxed);
    }

    /// Whether it waits so.
    pub(super) fn is_patient(&self) -> bool {
        self.patient.load(Ordering::Relaxed) > 0
    }

    /// The code of a component that it runs now.
    pub(super) fn doing(&self) -> Option<Arc<Doing>> {
        self.doing.load_full()
    }

    /// Code of a component runs in this thread, the control side's, until the answer is dropped.
    pub(crate) fn run(&self, doing: Arc<Doing>) -> Within<'_> {
        self.beat();
        DOING.set(Arc::as_ptr(&doing));
        show(Some(&doing));
        let before = self.doing.swap(Some(doing));
        Within { control: self, before, thread: PhantomData }
    }
}

/// For the watcher.
fn show(doing: Option<&Doing>) {
    if let Some(board) = board() {
        let number = doing.map_or(NOBODY, |d| d.number);
        board.doing.store(number, Ordering::Relaxed);
    }
}

/// Code of a component runs while this lives, and what ran around it.
#[derive(Debug)]
pub(crate) struct Within<'c> {
    control: &'c Control,
    before: Option<Arc<Doing>>,
    /// It is the note of one thread.
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

/// Where a component comes from: its file, and the threads of its own that it began as it was
/// loaded.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub(crate) file: Box<str>,
    pub(crate) component: Name,
    pub(crate) threads: Vec<i32>,
}

/// Where code was when something happened: the address of the code, and where its stack ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) code: usize,
    pub(super) stack: usize,
}

/// The thread in whose cycle this thread of the system is.
pub(super) fn cycle<'t>() -> Option<&'t Thread> {
    // SAFETY: set for the time of a cycle, which the thread outlives.
    unsafe { CYCLE.get().as_ref() }
}

/// Names who runs in this thread.
pub(super) fn describe(text: &mut Text, place: Place, origins: &[Origin]) {
    if let Some(thread) = cycle() {
        describe_cycle(text, thread);
        return;
    }
    // SAFETY: set for the time that the code runs, which the record outlives.
    if let Some(doing) = unsafe { DOING.get().as_ref() } {
        doing.describe(text);
        return;
    }
    let mut room = [0; 16];
    let name = sys::thread_name(&mut room);
    let me = sys::thread();
    let own = origins.iter().find(|o| o.threads.contains(&me));
    match own.or_else(|| origin(place, origins)) {
        Some(found) => {
            text.add(format_args!("component '{}'", found.component));
            // A library has several components, and any of them may have begun the thread later.
            let origins = if own.is_some() { &[] } else { origins };
            let same = |o: &&Origin| o.file == found.file && o.component != found.component;
            for other in origins.iter().filter(same) {
                text.add(format_args!(" or '{}'", other.component));
            }
            text.add(format_args!(", a thread of its own ('{name}')"));
        }
        None => text.add(format_args!("thread '{name}' of this process")),
    }
}

/// Names the function that a thread is in.
pub(super) fn describe_cycle(text: &mut Text, thread: &Thread) {
    let current = thread.current.load(Ordering::Relaxed);
    let list = thread.list.load();
    let mut entries = list.init.iter().chain(&list.entries);
    match entries.find(|e| e.id == current && current != NOBODY) {
        Some(e) => text.add(format_args!(
            "component '{}', function '{}', thread '{}'",
            e.component, e.name, thread.name
        )),
        None => text.add(format_args!("thread '{}', between its functions", thread.name)),
    }
}

/// The library that code belongs to: that of the address, or that of the innermost caller that is
/// still on the stack.
fn origin(place: Place, origins: &[Origin]) -> Option<&Origin> {
    const MOST_RANGES: usize = 64;
    const MOST_WORDS: usize = 4096;
    const AT_ONCE: usize = 64;
    let mut ranges = [(maps::Code::default(), 0_usize); MOST_RANGES];
    let mut used = 0;
    maps::each(|code, path| {
        if let Some(i) = origins.iter().position(|o| *o.file == *path)
            && let Some(range) = ranges.get_mut(used)
        {
            *range = (code, i);
            used += 1;
        }
        used == MOST_RANGES
    });
    let ranges = ranges.get(..used).unwrap_or_default();
    let found = |address: usize| {
        let range = ranges.iter().find(|(code, _)| code.holds(address));
        range.and_then(|(_, i)| origins.get(*i))
    };
    if let Some(origin) = found(place.code) {
        return Some(origin);
    }
    let mut words = [0_usize; AT_ONCE];
    let mut at = place.stack & !(align_of::<usize>() - 1);
    for _ in 0..MOST_WORDS / AT_ONCE {
        let n = sys::peek(at, &mut words);
        let read = words.get(..n).unwrap_or_default();
        if let Some(origin) = read.iter().find_map(|word| found(*word)) {
            return Some(origin);
        }
        if n < AT_ONCE {
            return None;
        }
        at = at.saturating_add(size_of_val(&words));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{Control, Doing, Place, Text, What, describe};
    use crate::name::Name;

    #[test]
    fn what_runs_is_known_while_it_runs() {
        let name = |text| Name::parse("command", text).unwrap();
        let said = || {
            let mut text = Text::new();
            describe(&mut text, Place { code: 0, stack: 0 }, &[]);
            text.as_str().to_owned()
        };
        let control = Control::default();
        assert!(said().starts_with("thread '"), "{}", said());
        let outer = control.run(Doing::new("mine", What::Load));
        assert_eq!(said(), "component 'mine', as it is loaded");
        let before = control.beats();
        drop(control.run(Doing::new("other", What::Command(name("other.go")))));
        assert!(control.beats() > before);
        assert_eq!(said(), "component 'mine', as it is loaded");
        assert!(control.doing().is_some());
        drop(outer);
        assert!(said().starts_with("thread '") && control.doing().is_none());
    }
}
