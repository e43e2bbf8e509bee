//! The Ferrule engine: names, arena, graph, threads, clocks, loader, recorder and server.
//!
//! One [`Engine`] is one instance. Its control side is single-threaded: the thread that owns the
//! `Engine` executes requests ([`hal_protocol::Link`]) and, while it waits, serves the socket, runs
//! background tasks and advances the virtual clock. It shares with the realtime threads only the
//! contents of `shared.rs`. See `hal/README.md` for the map.

#![expect(unsafe_code, reason = "one of the crates that keep the binary contract")]

mod analyse;
mod change;
mod ends;
mod engine;
mod error;
mod graph;
mod load;
mod messages;
mod name;
mod observe;
mod os;
mod realtime;
mod serve;
mod sync;

pub use ends::Ends;
pub use engine::{Ended, Engine};
pub use error::loading::Loading;
pub use error::plugin::PluginError;
pub use error::watch::WatchError;
pub use error::{Error, Guard};
pub use hal_protocol::Offer;

use hal_protocol::Place;
use std::path::PathBuf;

/// The clock that an instance runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockKind {
    /// The processor's monotonic clock.
    Real,
    /// A clock that the control side advances.
    Virtual,
}

/// Configuration of a new instance.
#[derive(Clone, Debug)]
pub struct Options {
    /// Name and files of the instance.
    pub place: Place,
    /// Clock of the instance.
    pub clock: ClockKind,
    /// True if the virtual clock moves only in `run T` (and while a script waits).
    pub hold: bool,
    /// Seconds of machine time in each second of wall-clock time while the virtual clock moves by
    /// itself. `None` means no limit.
    pub pace: Option<f64>,
    /// True if hardware is simulated; the virtual clock implies it.
    pub simulate: bool,
    /// True if items carry their old names (an INI file of the old kind).
    pub old_names: bool,
    /// True if the instance is a machine from an INI file: motion then refuses to load without the
    /// interlock that stops it in e-stop.
    pub interlock: bool,
    /// True if items begin with the values of LinuxCNC 2.9, where those of 2.10 are others.
    pub earlier_values: bool,
    /// Folders with plugins, searched in order.
    pub path: Vec<PathBuf>,
    /// Settings of the realtime threads.
    pub realtime: RealtimeOptions,
}

impl Options {
    /// Returns the options of a machine with simulated hardware, whose virtual clock moves only in
    /// `run T`, and that finds no plugins.
    #[must_use]
    pub const fn simulated(place: Place, clock: ClockKind) -> Self {
        Self {
            place,
            clock,
            hold: true,
            pace: None,
            simulate: true,
            old_names: false,
            interlock: false,
            earlier_values: false,
            path: Vec::new(),
            realtime: RealtimeOptions::DEFAULT,
        }
    }
}

/// Settings that the engine requests from the system for realtime threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RealtimeOptions {
    /// The processor that all threads run on; absent: an isolated one, or else the last one.
    pub cpu: Option<usize>,
    /// Longest time that processors may take to wake while threads run under `SCHED_FIFO`, in
    /// microseconds; absent: the system's setting.
    pub idle_us: Option<u32>,
    /// Time in one call of a function after which its thread counts as stuck, in nanoseconds (see
    /// [`STUCK_NS`]); absent: twice the period of the slowest thread.
    pub stuck_ns: Option<u64>,
    /// Longest time for which nothing of the instance may run, unless the computer is busy, in nanoseconds
    /// (see [`MAX_GAP_NS`]); absent: half a second.
    pub max_gap_ns: Option<u64>,
}

impl RealtimeOptions {
    /// Default settings.
    const DEFAULT: Self = Self { cpu: None, idle_us: Some(0), stuck_ns: None, max_gap_ns: None };
}

impl Default for RealtimeOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Range of [`RealtimeOptions::stuck_ns`]: from a millisecond to an hour.
pub const STUCK_NS: core::ops::RangeInclusive<u64> = 1_000_000..=3_600_000_000_000;

/// Range of [`RealtimeOptions::max_gap_ns`]: from ten milliseconds to an hour.
pub const MAX_GAP_NS: core::ops::RangeInclusive<u64> = 10_000_000..=3_600_000_000_000;

/// Starts a program. Signals reach it as they reach this process, but for those that an instance keeps for itself.
///
/// # Errors
/// The program cannot be started.
pub fn spawn(command: &mut std::process::Command) -> std::io::Result<std::process::Child> {
    os::process::with_continue(|| command.spawn())
}
