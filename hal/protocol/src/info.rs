//! What `show`, `list`, `save` and `status` are made of.

use crate::{Direction, Lock, Type, Value};
use serde::{Deserialize, Serialize};

/// How far a component's set-up has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ComponentState {
    /// It may still make pins.
    Initializing,
    /// It is complete.
    Ready,
}

/// A component.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComponentInfo {
    /// Its number.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// Whether it is a plugin (otherwise a program).
    pub realtime: bool,
    /// The program's process.
    pub pid: Option<i32>,
    /// How far it is.
    pub state: ComponentState,
    /// The arguments of its `loadrt`; absent for what `loadrt` did not make (threads).
    pub args: Option<String>,
    /// What it came from, when that is no plugin: what it reads and writes is then unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreign: Option<ForeignInfo>,
}

/// A file that is no plugin, such as a component in C.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ForeignInfo {
    /// What it is, such as `component in C`.
    pub kind: String,
    /// Its name, as in `loadrt --c NAME`.
    pub module: String,
    /// What its names begin with, as in `--prefix P`.
    pub prefix: String,
    /// The file.
    pub file: String,
    /// Memory of its own, in bytes.
    pub memory: u64,
}

/// A component that is no plugin, for the state of the instance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ForeignPart {
    /// Its name.
    pub component: String,
    /// What it is, such as `component in C`.
    pub kind: String,
    /// Memory of its own, in bytes.
    pub memory: u64,
}

/// A pin or parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ItemInfo {
    /// The number of its component.
    pub owner: u32,
    /// The name of its component.
    pub owner_name: String,
    /// Its direction; its type is that of the value.
    pub direction: Direction,
    /// Its value, or its signal's.
    pub value: Value,
    /// Its name, or its alias.
    pub name: String,
    /// Its own name when it has an alias.
    pub original: Option<String>,
    /// The signal it is linked to.
    pub signal: Option<String>,
    /// What it means.
    pub doc: String,
}

/// A signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalInfo {
    /// Its value; its type is that of the value.
    pub value: Value,
    /// Its name.
    pub name: String,
    /// Its pins by name.
    pub pins: Vec<(Direction, String)>,
}

/// A function.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FunctInfo {
    /// The number of its component.
    pub owner: u32,
    /// The name of its component.
    pub owner_name: String,
    /// Where its code is.
    pub code: u64,
    /// Where its state is.
    pub arg: u64,
    /// In how many threads it is.
    pub users: u32,
    /// Its name.
    pub name: String,
    /// Whether what it reads and writes is unknown: a component in C.
    #[serde(default, skip_serializing_if = "is_false")]
    pub foreign: bool,
    /// What it does.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub doc: String,
    /// Whether it belongs in a fast thread.
    #[serde(default, skip_serializing_if = "is_false")]
    pub fast: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
const fn is_false(value: &bool) -> bool {
    !*value
}

/// A thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ThreadInfo {
    /// Its period in nanoseconds.
    pub period: i64,
    /// Its name.
    pub name: String,
    /// Its functions in order.
    pub functs: Vec<String>,
    /// How long its last cycle took, in nanoseconds.
    pub time: i32,
    /// How long its longest cycle took, in nanoseconds.
    pub tmax: i32,
    /// Cycles run.
    pub cycles: u64,
    /// Cycles that began late because the one before took too long.
    pub overruns: u64,
    /// Cycles that never began: their time passed in others, or while the process was stopped.
    #[serde(default)]
    pub missed: u64,
    /// The function that took longest in the last overrun; absent when that cycle began late.
    pub overrun_by: Option<String>,
    /// Latest wake-up in nanoseconds, on the real clock.
    pub latency_max: i64,
    /// How many wake-ups were late by less than 1 µs, 2 µs, 4 µs, … (the last: more).
    pub latency: Vec<u64>,
}

/// A second name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AliasInfo {
    /// The name it is listed under.
    pub alias: String,
    /// Its own.
    pub original: String,
}

/// An argument of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArgInfo {
    /// As in `NAME=VALUE`.
    pub name: String,
    /// `int`, `float`, `text`, `ints`, `texts` or `bit`.
    pub ty: String,
    /// What it means.
    pub doc: String,
    /// Whether it must be given.
    pub required: bool,
    /// Its value when it is not given.
    pub default: Option<String>,
}

/// A command that a component offers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CommandInfo {
    /// Its name.
    pub name: String,
    /// What it does.
    pub doc: String,
    /// Its arguments.
    pub args: Vec<ArgInfo>,
}

/// A component type that a plugin offers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Offer {
    /// Its name, as in `loadrt NAME`.
    pub component: String,
    /// The library that offers it.
    pub library: String,
    /// What it is; the first line is a summary.
    pub doc: String,
    /// What `loadrt` may give it.
    pub args: Vec<ArgInfo>,
}

/// How far a command has come.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TicketInfo {
    /// Under way.
    Pending,
    /// Carried out.
    Done,
    /// Given up, with the reason.
    Failed(String),
}

/// A shared ring.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamInfo {
    /// Its name.
    pub name: String,
    /// Whether a component writes it (otherwise a program does).
    pub out: bool,
    /// How many slots; one less is usable.
    pub depth: u32,
    /// The type of each value of a record.
    pub types: Vec<Type>,
    /// Whether a program is attached.
    pub attached: bool,
}

/// How many of a thing there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Usage {
    /// In use.
    pub active: u32,
    /// Given back and kept for the next.
    pub recycled: u32,
}

/// Why the threads have stopped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultInfo {
    /// The component.
    pub component: String,
    /// The function.
    pub funct: String,
    /// The thread.
    pub thread: String,
    /// What it said.
    pub cause: String,
}

/// What an instance has of real time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RealtimeInfo {
    /// Memory that is locked, and that is present, in bytes.
    pub memory: (u64, u64),
    /// How long processors may take to wake, in microseconds, while that is held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub idle_us: Option<u32>,
    /// Why it is not held although it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub idle_refusal: Option<String>,
    /// The time in one call of a function after which its thread is stuck, in nanoseconds.
    pub stuck_ns: u64,
}

/// The state of the instance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatusInfo {
    /// Its name.
    pub instance: String,
    /// Its process.
    pub pid: i32,
    /// The lock level.
    pub lock: Lock,
    /// Memory in use and reserved for use, in bytes.
    pub memory: (u64, u64),
    /// Components.
    pub components: Usage,
    /// Pins.
    pub pins: Usage,
    /// Parameters.
    pub params: Usage,
    /// Aliases.
    pub aliases: Usage,
    /// Signals.
    pub signals: Usage,
    /// Functions.
    pub functs: Usage,
    /// Threads.
    pub threads: Usage,
    /// `real` or `virtual`.
    pub clock: String,
    /// Machine time in nanoseconds.
    pub time: u64,
    /// How threads are scheduled, in a sentence.
    pub scheduling: String,
    /// What there is of real time; absent on the virtual clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeInfo>,
    /// Whether hardware is simulated.
    pub simulated: bool,
    /// Whether threads run their functions.
    pub running: bool,
    /// Why they have stopped.
    pub fault: Option<FaultInfo>,
    /// Who does not come back from a function.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stuck: Option<FaultInfo>,
    /// What is loaded that is no plugin.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foreign: Vec<ForeignPart>,
    /// What is being recorded: the file, and records lost for want of room.
    pub recording: Option<(String, u64)>,
}
