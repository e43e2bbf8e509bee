//! Records that `order` prints: orders of functions, and delays of values between them.

use crate::At;
use serde::{Deserialize, Serialize};

/// Order of the functions in the threads: the current order and the one that the data flow
/// suggests.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct OrderInfo {
    /// All threads, fastest first.
    pub threads: Vec<ThreadOrder>,
    /// Paths from inputs of the machine to outputs.
    pub paths: Vec<PathInfo>,
    /// True if there are more paths than those listed.
    pub more_paths: bool,
    /// Feedback loops.
    pub loops: Vec<LoopInfo>,
    /// True if there are more loops than those listed.
    pub more_loops: bool,
    /// Values that pass from one thread to another.
    pub crossings: Vec<HopInfo>,
}

/// Order of the functions in a thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ThreadOrder {
    /// Name of the thread.
    pub name: String,
    /// Period in nanoseconds.
    pub period: u64,
    /// Functions in their current order.
    pub functs: Vec<AddedInfo>,
    /// Names of the same functions in the order with the least delay. Equal to the current order
    /// unless another one has less delay.
    pub better: Vec<String>,
    /// Values that are read one cycle late.
    pub late: Vec<LateInfo>,
    /// Values that are read one cycle late in the better order alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub later: Vec<HopInfo>,
    /// Changes that lead to the better order: remove all of these functions first, then add them
    /// one after the other.
    pub moves: Vec<MoveInfo>,
}

/// A function in a thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AddedInfo {
    /// Name of the function.
    pub name: String,
    /// Script line that added it, if a script did.
    pub at: Option<At>,
    /// True if the pins that it reads and writes are unknown. Values that pass through it are then
    /// not analysed.
    pub unknown: bool,
}

/// A value that is read one cycle late.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LateInfo {
    /// Writer and reader of the value.
    pub hop: HopInfo,
    /// True if the value is late in the better order too, because it closes a feedback loop.
    pub remains: bool,
}

/// New position of a function.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MoveInfo {
    /// Name of the function.
    pub funct: String,
    /// Position, counted as in `addf`.
    pub position: u64,
}

/// Delay of a value, in nanoseconds of machine time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DelayInfo {
    /// Smallest delay.
    pub least: u64,
    /// Largest delay.
    pub most: u64,
}

/// Flow of values from one function to another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HopInfo {
    /// Function that writes.
    pub from: String,
    /// Function that reads.
    pub to: String,
    /// Thread of the function that reads.
    pub thread: String,
    /// True if the function that writes runs in another thread.
    pub crosses: bool,
    /// Signals, and pins that both functions use. Empty if the value is internal state of a
    /// component.
    pub by: Vec<String>,
    /// Delay in the current order.
    pub delay: DelayInfo,
    /// Delay in the better order.
    pub better: DelayInfo,
}

/// Path of a value through functions.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WayInfo {
    /// Steps from function to function.
    pub hops: Vec<HopInfo>,
    /// Total delay in the current order.
    pub delay: DelayInfo,
    /// Total delay in the better order.
    pub better: DelayInfo,
}

/// Delay from an input of the machine to an output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PathInfo {
    /// Function that receives values from outside.
    pub from: String,
    /// Function whose values leave the machine.
    pub to: String,
    /// Path on which a value arrives first.
    pub quickest: WayInfo,
    /// Path on which a value arrives last, if that is a different one.
    pub slowest: Option<WayInfo>,
}

/// A feedback loop.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoopInfo {
    /// Steps around the loop. The last step leads back to the first function.
    pub way: WayInfo,
    /// True if values pass in both directions through bidirectional pins (a handshake).
    pub handshake: bool,
}
