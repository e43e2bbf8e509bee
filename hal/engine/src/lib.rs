//! The Ferrule engine.

use hal_protocol::{Failure, Link, Place, Reply, Request};
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

/// A running instance.
#[derive(Debug)]
pub struct Engine {}

/// Why [`Engine::serve`] returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// There is no thread (any more).
    NoThreads,
    /// A client asked for it.
    Shutdown,
    /// SIGINT, SIGTERM or SIGHUP came.
    Signal,
    /// The time is over.
    Time,
}

impl Engine {
    /// Makes an instance and takes its socket.
    ///
    /// # Errors
    /// Another one of this name is running, or the system refuses.
    pub fn new(_: Options) -> Result<Self, Failure> {
        Ok(Self {})
    }
    /// Serves clients until something ends it; `for_ns` bounds machine time.
    pub fn serve(&mut self, _for_ns: Option<u64>) -> Ended {
        Ended::NoThreads
    }
    /// Whether a signal or a client has asked the instance to end (a script then stops).
    pub fn is_ending(&self) -> bool {
        false
    }
    /// Messages of components and notices of the engine since the last call, for the terminal.
    pub fn take_messages(&mut self) -> Vec<String> {
        Vec::new()
    }
    /// Stops the threads, runs every stop action, ends programs, unloads everything and gives the
    /// socket back.
    pub fn close(self) {}
}

impl Link for Engine {
    fn call(&mut self, _: Request) -> Result<Reply, Failure> {
        Ok(Reply::Done)
    }
    fn is_local(&self) -> bool {
        true
    }
}
