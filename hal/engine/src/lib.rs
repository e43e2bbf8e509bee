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
mod engine;
mod error;
mod fault;
mod flight;
mod foreign;
mod graph;
mod handover;
mod hint;
mod item;
mod listing;
mod load;
mod loader;
mod name;
mod near;
mod node;
mod offer;
mod order;
mod os;
mod polls;
mod probe;
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
mod wiring;

pub use engine::{Ended, Engine};
pub use error::Error;
pub use hal_protocol::Offer;
pub use load::Loading;
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
    /// Folders with plugins, searched in order.
    pub path: Vec<PathBuf>,
}
