//! Settings and state of the flight recorder.

use serde::{Deserialize, Serialize};

/// Settings of the flight recorder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FlightSpec {
    /// Memory for recorded changes, in bytes. 0 means 16 MiB.
    pub bytes: u64,
    /// Time before an event that is kept, in nanoseconds. If absent, everything recorded is kept.
    pub before_ns: Option<u64>,
    /// Time after an event that is kept, in nanoseconds.
    pub after_ns: u64,
    /// File that events are written to. The event number is inserted before the extension, and the
    /// extension selects the format (`.vcd`, `.fst`, `.csv`, `.json`). If absent, an event stays in
    /// memory until the next one.
    pub file: Option<String>,
    /// Conditions that count as events in addition to faults and e-stops: `PIN`, `!PIN`, `PIN > 5`.
    pub when: Vec<String>,
}

/// Progress of keeping an event.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KeptState {
    /// The time after the event is still being recorded.
    Awaited,
    /// The event is in memory.
    InMemory,
    /// The event is being written to its file.
    Writing,
    /// The event is in its file.
    Written,
    /// Writing failed for this reason; the event is still in memory.
    Failed(String),
}

/// A kept event, or a recording that a user asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptInfo {
    /// Number, from 1.
    pub number: u32,
    /// Machine time of the event, in nanoseconds.
    pub time: i64,
    /// Cause of the event.
    pub why: String,
    /// File of the event.
    pub file: Option<String>,
    /// Progress of keeping it.
    pub state: KeptState,
}

/// State of the flight recorder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlightInfo {
    /// Memory available for recorded changes, in bytes.
    pub bytes: u64,
    /// Memory in use, in bytes.
    pub used: u64,
    /// Number of watched values.
    pub values: u32,
    /// Machine time from which the recording is complete, in nanoseconds.
    pub from: i64,
    /// Current machine time, in nanoseconds.
    pub to: i64,
    /// Number of changes lost because they arrived faster than the recorder could store them.
    pub lost: u64,
    /// Latest events, oldest first.
    pub kept: Vec<KeptInfo>,
}
