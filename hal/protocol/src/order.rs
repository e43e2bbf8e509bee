//! What `order` is made of: orders of functions, and how long values wait.

use crate::At;
use serde::{Deserialize, Serialize};

/// The order of functions in threads, as it is and as the data flow would have it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OrderInfo {
    /// Every thread, fastest first.
    pub threads: Vec<ThreadOrder>,
    /// From what comes in to what goes out.
    pub paths: Vec<PathInfo>,
    /// Whether there are more paths than these.
    pub more_paths: bool,
    /// The feedback loops.
    pub loops: Vec<LoopInfo>,
    /// Whether there are more loops than these.
    pub more_loops: bool,
    /// What goes from one thread to another.
    pub crossings: Vec<HopInfo>,
}

/// The order of functions in a thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ThreadOrder {
    /// Its name.
    pub name: String,
    /// Its period in nanoseconds.
    pub period: u64,
    /// Its functions in their order.
    pub functs: Vec<AddedInfo>,
    /// The names of the same functions in the order that costs least: their own, unless another
    /// costs less.
    pub better: Vec<String>,
    /// What is read a cycle late.
    pub late: Vec<LateInfo>,
    /// What makes the better order of theirs: all of these functions are taken out, and then put
    /// in one after the other.
    pub moves: Vec<MoveInfo>,
}

/// A function in a thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AddedInfo {
    /// Its name.
    pub name: String,
    /// The line that added it, if a script did.
    pub at: Option<At>,
    /// What it reads and writes is not known: nothing is said about what passes through it.
    pub unknown: bool,
}

/// A value that is read a cycle late.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LateInfo {
    /// From whom to whom.
    pub hop: HopInfo,
    /// It is late in the better order as well: it closes a feedback loop.
    pub remains: bool,
}

/// Where a function would have to be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MoveInfo {
    /// The function.
    pub funct: String,
    /// Its position, as `addf` counts.
    pub position: u64,
}

/// How long a value waits, in nanoseconds of machine time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DelayInfo {
    /// At best.
    pub least: u64,
    /// At worst.
    pub most: u64,
}

/// What goes from one function to another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HopInfo {
    /// The function that writes.
    pub from: String,
    /// The function that reads.
    pub to: String,
    /// The thread of the function that reads.
    pub thread: String,
    /// Whether the function that writes is in another thread.
    pub crosses: bool,
    /// The signals, and pins that both functions have; none: state within a component.
    pub by: Vec<String>,
    /// How long it waits.
    pub delay: DelayInfo,
    /// How long it would wait in the better order.
    pub better: DelayInfo,
}

/// The way of a value through functions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WayInfo {
    /// From function to function.
    pub hops: Vec<HopInfo>,
    /// How long it takes.
    pub delay: DelayInfo,
    /// How long it would take in the better order.
    pub better: DelayInfo,
}

/// How long it takes from what comes in to what goes out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PathInfo {
    /// The function that has values from outside.
    pub from: String,
    /// The function whose values go outside.
    pub to: String,
    /// The way on which a value is there first.
    pub quickest: WayInfo,
    /// The way on which it is there last, where that is another.
    pub slowest: Option<WayInfo>,
}

/// A feedback loop.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoopInfo {
    /// Around it; the last hop leads to the first function.
    pub way: WayInfo,
    /// Its values go to and fro through bidirectional pins: a handshake.
    pub handshake: bool,
}
