//! The Ferrule engine: names, arena, graph, threads, clocks, loader, recorder and server.
//!
//! One [`Engine`] is one instance. Its control side is single-threaded: whoever owns the `Engine`
//! carries out requests ([`hal_protocol::Link`]) and, while it waits, serves the socket, runs
//! background tasks and turns the virtual clock. Realtime threads share with it only what
//! `shared.rs` holds. See `hal/README.md` for the map.

#![expect(unsafe_code, reason = "one of the crates that keep the binary contract")]

mod apply;
mod arena;
mod args;
mod callback;
mod change;
mod check;
mod client;
mod clock;
mod code;
mod control;
mod create;
mod elf;
mod ending;
mod ends;
mod engine;
mod error;
mod fault;
mod flight;
mod foreign;
mod graph;
mod handover;
mod hint;
mod item;
mod join;
mod listing;
mod load;
mod loader;
mod mailbox;
mod messages;
mod name;
mod near;
mod node;
mod offer;
mod opening;
mod order;
mod os;
mod overruns;
mod plugin_error;
mod plugin_file;
mod polls;
mod probe;
mod realtime;
mod record;
mod request;
mod ring;
mod runners;
mod sample;
mod schedule;
mod server;
mod session;
mod shared;
mod sites;
mod stuck;
mod sync;
mod task;
mod thread;
mod transaction;
mod trial;
mod undo;
mod unload;
mod value;
mod watch;
mod watch_error;
mod watchdog;
mod wired;
mod wiring;

pub use ends::Ends;
pub use engine::{Ended, Engine};
pub use error::Error;
pub use hal_protocol::Offer;
pub use load::Loading;
pub use plugin_error::PluginError;
pub use watch_error::WatchError;

use hal_protocol::Place;
use std::path::PathBuf;

/// Which clock an instance runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockKind {
    /// The processor's.
    Real,
    /// Turned by hand.
    Virtual,
}

/// How an instance is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Its name and files.
    pub place: Place,
    /// Its clock.
    pub clock: ClockKind,
    /// Whether the virtual clock moves only in `run T` (and while a script waits).
    pub hold: bool,
    /// Whether hardware is simulated; the virtual clock implies it.
    pub simulate: bool,
    /// Whether items carry their old names (an INI of the old kind).
    pub old_names: bool,
    /// Whether the instance is a machine from an INI file: motion then refuses to load without
    /// the interlock that stops it in e-stop.
    pub interlock: bool,
    /// Folders with plugins, searched in order.
    pub path: Vec<PathBuf>,
    /// What is asked of the system for realtime threads.
    pub realtime: RealtimeOptions,
}

/// What is asked of the system for realtime threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RealtimeOptions {
    /// The processor that all threads run on; absent: an isolated one, or the last.
    pub cpu: Option<usize>,
    /// How long processors may take to wake while threads run under `SCHED_FIFO`, in microseconds;
    /// absent: as the system has it.
    pub idle_us: Option<u32>,
    /// The time in one call of a function after which its thread is stuck, in nanoseconds (see
    /// [`STUCK_NS`]); absent: two of the slowest periods.
    pub stuck_ns: Option<u64>,
}

impl Default for RealtimeOptions {
    fn default() -> Self {
        Self { cpu: None, idle_us: Some(0), stuck_ns: None }
    }
}

/// The range of [`RealtimeOptions::stuck_ns`]: from a millisecond to an hour.
pub const STUCK_NS: core::ops::RangeInclusive<u64> = 1_000_000..=3_600_000_000_000;
