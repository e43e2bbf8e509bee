//! The flight recorder: what it is to keep, and what it has kept.

use serde::{Deserialize, Serialize};

/// What the flight recorder is to keep.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FlightSpec {
    /// How much memory changes may take, in bytes; 0: 16 MiB.
    pub bytes: u64,
    /// How long before an event is kept, in nanoseconds; absent: as much as there is.
    pub before_ns: Option<u64>,
    /// How long after an event is kept, in nanoseconds.
    pub after_ns: u64,
    /// Where an event is written to, with its number before the ending, which says how (`.vcd`,
    /// `.fst`, `.csv`, `.json`); absent: it is kept in memory until the next.
    pub file: Option<String>,
    /// What is an event beside faults and e-stops: `PIN`, `!PIN`, `PIN > 5`.
    pub when: Vec<String>,
}

/// What has become of an event.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KeptState {
    /// What comes after it is still being kept.
    Awaited,
    /// It is in memory.
    InMemory,
    /// It is being written.
    Writing,
    /// It is in its file.
    Written,
    /// It could not be written, for this reason, and is in memory.
    Failed(String),
}

/// An event, or what a user wanted to have.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptInfo {
    /// Its number, from 1.
    pub number: u32,
    /// Machine time in nanoseconds.
    pub time: i64,
    /// Why.
    pub why: String,
    /// Its file.
    pub file: Option<String>,
    /// What has become of it.
    pub state: KeptState,
}

/// How the flight recorder is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlightInfo {
    /// How much memory changes may take, in bytes.
    pub bytes: u64,
    /// How much they take.
    pub used: u64,
    /// How many values are watched.
    pub values: u32,
    /// Machine time from which on everything is kept.
    pub from: i64,
    /// Machine time now.
    pub to: i64,
    /// Changes lost because they came faster than they were kept.
    pub lost: u64,
    /// The latest events, oldest first.
    pub kept: Vec<KeptInfo>,
}
