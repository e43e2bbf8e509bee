//! Samples: what is asked for, and what comes of it.

use crate::Type;
use serde::{Deserialize, Serialize};

/// The most channels of a sample.
pub const MOST_CHANNELS: usize = 1024;

/// What is to be sampled, when, and how.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct SampleSpec {
    /// The thread after whose cycles values are taken; absent: the fastest.
    pub thread: Option<String>,
    /// After each n-th cycle; 0 and 1: after each.
    pub every: u32,
    /// How many samples the ring is to hold; 0: enough for a second, as far as memory allows.
    pub depth: u32,
    /// Pins, parameters and signals, in this order of search; `sig:NAME` is a signal for certain.
    /// Where a name has `*`, `?` or `[`, all that match are meant, by name.
    pub names: Vec<String>,
    /// On the virtual clock, time waits while the ring is full, as long as the client is
    /// connected, but no longer than 10 s on the wall without a sample taken. On the real one, and without this, samples for which there is no room are lost,
    /// and counted.
    pub wait: bool,
}

/// A channel of a sample.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelInfo {
    /// The name of the pin, parameter or signal.
    pub name: String,
    /// Its type.
    pub ty: Type,
}

/// A sample that has begun.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleInfo {
    /// Its number.
    pub id: u64,
    /// The thread.
    pub thread: String,
    /// The thread's period in nanoseconds.
    pub period: i64,
    /// After each n-th cycle.
    pub every: u32,
    /// How many samples the ring holds.
    pub depth: u32,
    /// Whether time waits while the ring is full.
    pub wait: bool,
    /// What each record has after its time.
    pub channels: Vec<ChannelInfo>,
}

/// How a sample is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleState {
    /// How many samples were taken, those included that were lost.
    pub samples: u64,
    /// How many of them were lost for want of room.
    pub lost: u64,
    /// Why it has ended, if it has.
    pub ended: Option<String>,
}
