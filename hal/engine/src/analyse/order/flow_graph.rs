//! Machine model: the thread of each function, and the flows of values between functions.

use crate::graph::Ix;
use petgraph::stable_graph::EdgeIndex;

/// Functions in threads, and the flows between them.
#[derive(Clone, Debug, Default)]
pub(crate) struct FlowGraph {
    /// Threads in the order in which they run when several are due at the same moment.
    pub(crate) threads: Vec<Thread>,
    /// Functions that a thread runs in each cycle.
    pub(crate) functs: Vec<Funct>,
    /// Flows, at most one from one function to another, sorted by both.
    pub(crate) flows: Vec<Flow>,
    /// Pairs of functions of a thread whose order must not change, because the pins that one of
    /// them accesses are unknown.
    pub(crate) fixed: Vec<(usize, usize)>,
}

/// A thread.
#[derive(Clone, Debug)]
pub(crate) struct Thread {
    pub(crate) ix: Ix,
    /// Period in nanoseconds.
    pub(crate) period: u64,
    /// Functions of the thread, in the order of the user's `addf` lines.
    pub(crate) order: Vec<usize>,
}

/// A function in a thread.
#[derive(Clone, Debug)]
pub(crate) struct Funct {
    pub(crate) ix: Ix,
    /// Edge from its thread.
    pub(crate) edge: Option<EdgeIndex<u32>>,
    /// Component of the function.
    pub(crate) owner: Option<Ix>,
    /// Index of its thread.
    pub(crate) thread: usize,
    /// True if the pins that it reads and writes are unknown, or if it runs in more than one place.
    pub(crate) unknown: bool,
    /// True if it belongs in a fast thread and has outputs. Its output, such as steps, leaves the
    /// machine even if no function reads it.
    pub(crate) drives: bool,
    /// True if it takes commands.
    pub(crate) told: bool,
}

/// Values that one function writes and another reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Flow {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Carriers of the values; never empty.
    pub(crate) by: Vec<By>,
    /// True if the flow carries more than bits. Among paths with equal delay, one through such
    /// flows is preferred.
    pub(crate) numbers: bool,
}

/// Carrier of a value from one function to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum By {
    /// A signal with one writer.
    Signal(Ix),
    /// A signal that bidirectional pins write, in both directions.
    Shared(Ix),
    /// A pin that both functions access, in both directions.
    Pin(Ix),
    /// State within a component that no pin shows.
    Hidden,
}

impl Flow {
    /// Returns whether values flow only in this direction. A handshake through a bidirectional pin
    /// is not a path.
    pub(crate) fn is_one_way(&self) -> bool {
        self.by.iter().any(|by| matches!(by, By::Signal(_) | By::Hidden))
    }

    /// Returns the cost of a one-cycle delay of this flow: the number of values that are late.
    pub(crate) fn weight(&self) -> u64 {
        self.by.len() as u64
    }
}

impl FlowGraph {
    /// Returns the period of a thread, in nanoseconds.
    pub(crate) fn period(&self, thread: usize) -> u64 {
        self.threads.get(thread).map_or(1, |t| t.period)
    }

    /// Returns the thread of a function.
    pub(crate) fn thread_of(&self, funct: usize) -> usize {
        self.functs.get(funct).map_or(0, |f| f.thread)
    }

    /// Returns whether two functions belong to the same component.
    pub(crate) fn are_kin(&self, a: usize, b: usize) -> bool {
        let owner = |i: usize| self.functs.get(i).and_then(|f| f.owner);
        owner(a).is_some() && owner(a) == owner(b)
    }

    /// Returns whether a flow stays within a thread.
    pub(crate) fn is_inside(&self, flow: &Flow) -> bool {
        self.thread_of(flow.from) == self.thread_of(flow.to)
    }
}
