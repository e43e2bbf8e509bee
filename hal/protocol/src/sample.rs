//! Samples: their specification, description and state.

use crate::Type;
use serde::{Deserialize, Serialize};

/// Maximum number of channels of a sample.
pub const MAX_CHANNELS: usize = 1024;

/// Specification of a sample: values, thread and ring size.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct SampleSpec {
    /// Thread after whose cycles values are taken. If absent, the fastest thread.
    pub thread: Option<String>,
    /// Take values after every n-th cycle. 0 and 1 mean every cycle.
    pub every: u32,
    /// Number of samples that the ring must hold. 0 means enough for one second, as far as memory
    /// allows.
    pub depth: u32,
    /// Names of pins, parameters and signals, searched in this order. `sig:NAME` always names a
    /// signal. A name with `*`, `?` or `[` selects all that match it, ordered by name.
    pub names: Vec<String>,
    /// On the virtual clock, stop time while the ring is full, as long as the client is connected,
    /// but for at most 10 s of wall-clock time without a sample taken. On the real clock, and
    /// without this option, samples that find the ring full are lost and counted.
    pub wait: bool,
}

/// A channel of a sample.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelInfo {
    /// Name of the pin, parameter or signal.
    pub name: String,
    /// Type of the value.
    pub ty: Type,
}

/// Description of a running sample.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleInfo {
    /// Id of the sample.
    pub id: u64,
    /// Thread after whose cycles values are taken.
    pub thread: String,
    /// Period of the thread in nanoseconds.
    pub period: i64,
    /// Values are taken after every n-th cycle.
    pub every: u32,
    /// Number of samples that the ring holds.
    pub depth: u32,
    /// True if virtual time stops while the ring is full.
    pub wait: bool,
    /// Values of each record, after its time.
    pub channels: Vec<ChannelInfo>,
}

/// State of a sample.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleState {
    /// Number of samples, including those that were lost.
    pub samples: u64,
    /// Number of samples lost because the ring was full.
    pub lost: u64,
    /// Reason why the sample ended, if it has ended.
    pub ended: Option<String>,
}
