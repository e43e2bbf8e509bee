//! Records that `show`, `list`, `save` and `status` print.

use crate::{ArgInfo, Direction, Lock, Type, Value, WorkerInfo};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Progress of a component's set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ComponentState {
    /// The component may still create pins.
    Initializing,
    /// Set-up is complete.
    Ready,
}

/// A component.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComponentInfo {
    /// Number of the component (its id, not a count).
    pub id: u32,
    /// Name of the component.
    pub name: String,
    /// True for a plugin, false for a program.
    pub realtime: bool,
    /// Process id of the program.
    pub pid: Option<i32>,
    /// Progress of set-up.
    pub state: ComponentState,
    /// Arguments of its `loadrt`. Absent for components that `loadrt` did not create (threads).
    pub args: Option<String>,
    /// Origin of a component that is not a plugin. The pins that such a component reads and writes
    /// are unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreign: Option<ForeignInfo>,
}

/// A component from a file that is not a plugin, such as a component in C.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ForeignInfo {
    /// Kind of the file, such as `component in C`.
    pub kind: String,
    /// Module name, as in `loadrt --c NAME`.
    pub module: String,
    /// Prefix of all its names, as in `--prefix P`.
    pub prefix: String,
    /// Path of the file.
    pub file: String,
    /// Memory that the component allocated for itself, in bytes.
    pub memory: u64,
    /// Description in the file.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub doc: String,
}

/// A component that is not a plugin, as `status` lists it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ForeignPart {
    /// Name of the component.
    pub component: String,
    /// Kind of the file, such as `component in C`.
    pub kind: String,
    /// Memory that the component allocated for itself, in bytes.
    pub memory: u64,
}

/// A pin or parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ItemInfo {
    /// Id of the owning component.
    pub owner: u32,
    /// Name of the owning component.
    pub owner_name: String,
    /// Direction. The type is that of `value`.
    pub direction: Direction,
    /// Value of the item, or of its signal if it is linked.
    pub value: Value,
    /// Alias if the item has one, otherwise its own name.
    pub name: String,
    /// Own name of the item, if it has an alias.
    pub original: Option<String>,
    /// Signal that the item is linked to.
    pub signal: Option<String>,
    /// Description.
    pub doc: String,
}

/// A signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalInfo {
    /// Value. The type of the signal is the type of the value.
    pub value: Value,
    /// Name of the signal.
    pub name: String,
    /// Linked pins, by name.
    pub pins: Vec<(Direction, String)>,
}

/// A function.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FunctInfo {
    /// Id of the owning component.
    pub owner: u32,
    /// Name of the owning component.
    pub owner_name: String,
    /// Address of the function's code.
    pub code: u64,
    /// Address of the function's state.
    pub arg: u64,
    /// Number of threads that run the function.
    pub users: u32,
    /// Name of the function.
    pub name: String,
    /// True if the pins that it reads and writes are unknown (a component in C).
    #[serde(default, skip_serializing_if = "is_false")]
    pub foreign: bool,
    /// Description.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub doc: String,
    /// True if the function belongs in a fast thread.
    #[serde(default, skip_serializing_if = "is_false")]
    pub fast: bool,
    /// True if the function computes with floating-point numbers.
    #[serde(default, skip_serializing_if = "is_false")]
    pub fp: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
const fn is_false(value: &bool) -> bool {
    !*value
}

/// A thread.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ThreadInfo {
    /// Period in nanoseconds.
    pub period: i64,
    /// Name of the thread.
    pub name: String,
    /// True if functions that compute with floating-point numbers can be added.
    pub fp: bool,
    /// Functions in the order in which they run.
    pub functs: Vec<String>,
    /// Duration of the last cycle, in nanoseconds.
    pub time: i32,
    /// Duration of the longest cycle, in nanoseconds.
    pub tmax: i32,
    /// Number of cycles run.
    pub cycles: u64,
    /// Number of cycles that began late because the previous cycle took too long.
    pub overruns: u64,
    /// Number of cycles that never began, because earlier cycles took their time or the process was
    /// stopped.
    #[serde(default)]
    pub missed: u64,
    /// Function that took longest in the last overrun. Absent if that cycle began late.
    pub overrun_by: Option<String>,
    /// Largest delay of a wake-up, in nanoseconds, on the real clock.
    pub latency_max: i64,
    /// Histogram of wake-up delays: number of wake-ups late by less than 1 µs, 2 µs, 4 µs, and so
    /// on. The last entry counts the longer ones.
    pub latency: Vec<u64>,
}

/// An alias of a pin or parameter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AliasInfo {
    /// Name that the item is listed under.
    pub alias: String,
    /// Own name of the item.
    pub original: String,
}

/// A command that a component offers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CommandInfo {
    /// Name of the command.
    pub name: String,
    /// Description.
    pub doc: String,
    /// Arguments of the command.
    pub args: Vec<ArgInfo>,
}

/// A component type that a plugin offers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Offer {
    /// Name of the component type, as in `loadrt NAME`.
    pub component: String,
    /// Library that contains it.
    pub library: String,
    /// Description. The first line is a summary.
    pub doc: String,
    /// Arguments that `loadrt` accepts for it.
    pub args: Vec<ArgInfo>,
}

/// Progress of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TicketInfo {
    /// The command is still executing.
    Pending,
    /// The command has completed.
    Done,
    /// The command was aborted, for this reason.
    Failed(String),
}

/// A shared ring.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamInfo {
    /// Name of the ring.
    pub name: String,
    /// True if a component writes the ring and a program reads it; false for the opposite
    /// direction.
    pub out: bool,
    /// Number of slots, of which one always stays empty.
    pub depth: u32,
    /// Type of each value of a record.
    pub types: Vec<Type>,
    /// True if a program is attached.
    pub attached: bool,
    /// True for a ring between two programs, each of which may write or read it.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub both: bool,
}

/// Number of objects of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Usage {
    /// Number in use.
    pub active: u32,
    /// Number freed and kept for reuse.
    pub recycled: u32,
}

/// Fault that stopped the threads.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultInfo {
    /// Component at fault.
    pub component: String,
    /// Function or worker at fault.
    pub funct: String,
    /// Thread that ran it. Empty for a worker, which has its own.
    pub thread: String,
    /// Cause, as a text.
    pub cause: String,
}

/// Realtime properties of an instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RealtimeInfo {
    /// Locked memory and resident memory, in bytes.
    pub memory: (u64, u64),
    /// Longest permitted wake-up latency of the processors, in microseconds, while the engine holds
    /// that limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub idle_us: Option<u32>,
    /// Reason why the limit is not held although it was requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub idle_refusal: Option<String>,
    /// Duration of one call of a function, in nanoseconds, after which its thread counts as stuck.
    pub stuck_ns: u64,
}

/// Times in which nothing ran although threads were to run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GapInfo {
    /// Number of gaps so far.
    pub count: u32,
    /// Duration of the last one in nanoseconds.
    pub ns: u64,
    /// Machine time at its end, in nanoseconds.
    pub time: u64,
    /// Cause of the gap, as a text.
    pub cause: String,
}

/// State of the instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatusInfo {
    /// Name of the instance.
    pub instance: String,
    /// Process id.
    pub pid: i32,
    /// Lock level.
    pub lock: Lock,
    /// Memory in use and memory reserved, in bytes.
    pub memory: (u64, u64),
    /// Number of components.
    pub components: Usage,
    /// Number of pins.
    pub pins: Usage,
    /// Number of parameters.
    pub params: Usage,
    /// Number of aliases.
    pub aliases: Usage,
    /// Number of signals.
    pub signals: Usage,
    /// Number of functions.
    pub functs: Usage,
    /// Number of threads.
    pub threads: Usage,
    /// Clock: `real` or `virtual`.
    pub clock: String,
    /// Machine time in nanoseconds.
    pub time: u64,
    /// Scheduling of the threads, described in a sentence.
    pub scheduling: String,
    /// Realtime properties. Absent on the virtual clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeInfo>,
    /// Gaps in time. Absent if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gaps: Option<GapInfo>,
    /// True if hardware is simulated.
    pub simulated: bool,
    /// True while the scripts with which the instance starts are in progress: components may still be loaded.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub starting: bool,
    /// True if threads run their functions.
    pub running: bool,
    /// Fault that stopped the threads.
    pub fault: Option<FaultInfo>,
    /// Function that has not returned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stuck: Option<FaultInfo>,
    /// Loaded components that are not plugins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foreign: Vec<ForeignPart>,
    /// Workers of the loaded components.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub workers: Vec<WorkerInfo>,
    /// Recording in progress: the file, and the number of records lost because the queue was full.
    pub recording: Option<(String, u64)>,
    /// The recording that has stopped because it could not be written, until `record` is given again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording_stopped: Option<StoppedRecording>,
}

/// A recording that could not be written any further.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoppedRecording {
    /// The file.
    pub file: String,
    /// Reason for which the system refused to write.
    pub reason: String,
    /// When it did, in nanoseconds of machine time.
    pub time: u64,
    /// The size of what is kept in the file, in bytes: whole records.
    pub bytes: u64,
    /// The last instant in the file, in nanoseconds of machine time; none when nothing is kept.
    pub kept_to: Option<u64>,
}

impl StoppedRecording {
    /// Returns the message about it without the name of its file.
    #[must_use]
    pub fn words(&self) -> String {
        let kept = match self.kept_to {
            Some(to) => format!("{} bytes are kept, up to {}", self.bytes, seconds(to)),
            None => "nothing of it is kept".to_owned(),
        };
        format!("{}: the recording stopped at {}; {kept}", self.reason, seconds(self.time))
    }
}

impl fmt::Display for StoppedRecording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file, self.words())
    }
}

/// Returns a time in seconds, without needless zeros.
fn seconds(ns: u64) -> String {
    let text = format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000);
    format!("{} s", text.trim_end_matches('0').trim_end_matches('.'))
}
