//! A machine as its functions see it: which thread runs each, and whose values go to whom.

use crate::graph::Ix;
use petgraph::stable_graph::EdgeIndex;

/// Functions in threads, and what goes from one to the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Machine {
    /// In the order in which they run when several are due at one moment.
    pub(crate) threads: Vec<Thread>,
    /// Every function that a thread runs in each cycle.
    pub(crate) functs: Vec<Funct>,
    /// At most one from one function to another, in order of both.
    pub(crate) flows: Vec<Flow>,
    /// Pairs in the thread's order that must stay so, because nobody knows what the one of them
    /// touches.
    pub(crate) fixed: Vec<(usize, usize)>,
}

/// A thread.
#[derive(Clone, Debug)]
pub(crate) struct Thread {
    pub(crate) ix: Ix,
    /// In nanoseconds.
    pub(crate) period: u64,
    /// Its functions, in the order of the user's `addf` lines.
    pub(crate) order: Vec<usize>,
}

/// A function in a thread.
#[derive(Clone, Debug)]
pub(crate) struct Funct {
    pub(crate) ix: Ix,
    /// The edge from its thread.
    pub(crate) edge: Option<EdgeIndex<u32>>,
    /// Its component.
    pub(crate) owner: Option<Ix>,
    /// Its thread's number.
    pub(crate) thread: usize,
    /// What it reads and writes is not known, or it runs in more than one place.
    pub(crate) unknown: bool,
    /// It belongs in a fast thread and has outputs: what it makes, such as steps, leaves the machine
    /// even where no function reads it.
    pub(crate) drives: bool,
    /// It takes commands.
    pub(crate) told: bool,
}

/// What a function writes and another reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Flow {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// What carries it; never empty.
    pub(crate) by: Vec<By>,
    /// It carries more than bits: of ways that take equally long, this is the one to tell.
    pub(crate) numbers: bool,
}

/// What carries a value from one function to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum By {
    /// A signal with one writer.
    Signal(Ix),
    /// A signal that bidirectional pins write, both ways.
    Shared(Ix),
    /// A pin that both functions hold, both ways.
    Pin(Ix),
    /// State that no pin shows, within a component.
    Hidden,
}

impl Flow {
    /// Whether values go this way only: a handshake through a bidirectional pin is no path.
    pub(crate) fn is_one_way(&self) -> bool {
        self.by.iter().any(|by| matches!(by, By::Signal(_) | By::Hidden))
    }

    /// What a cycle's delay of it costs: how many values are late.
    pub(crate) fn weight(&self) -> u64 {
        self.by.len() as u64
    }
}

impl Machine {
    /// The period of a thread, in nanoseconds.
    pub(crate) fn period(&self, thread: usize) -> u64 {
        self.threads.get(thread).map_or(1, |t| t.period)
    }

    /// The thread of a function.
    pub(crate) fn thread_of(&self, funct: usize) -> usize {
        self.functs.get(funct).map_or(0, |f| f.thread)
    }

    /// Whether two functions are of the same component.
    pub(crate) fn are_kin(&self, a: usize, b: usize) -> bool {
        let owner = |i: usize| self.functs.get(i).and_then(|f| f.owner);
        owner(a).is_some() && owner(a) == owner(b)
    }

    /// Whether a flow stays in a thread.
    pub(crate) fn is_inside(&self, flow: &Flow) -> bool {
        self.thread_of(flow.from) == self.thread_of(flow.to)
    }
}
