//! A connection to an engine in another process.

use crate::programs::options::Opt;
use hal_protocol::{
    At, Client, Failure, Folder, FolderError, INTERRUPTED, Link, Place, Reply, Request,
};
use rustix::{thread::NanosleepRelativeResult, time::Timespec};
use std::sync::{Arc, atomic::AtomicBool};

/// Number of checks for the end of an instance whose socket is closed, and the milliseconds between
/// them.
const LOOKS_FOR_END: u32 = 100;
const LOOK_MS: u32 = 2;

/// A connection that is made when it is first needed.
#[derive(Debug)]
pub struct Remote {
    place: Place,
    name: String,
    client: Option<Client>,
    at: Option<At>,
    given_up: Option<Arc<AtomicBool>>,
}

impl Remote {
    /// Makes a connection to the instance at `place`, as component `name`.
    #[must_use]
    pub fn new(place: Place, name: &str) -> Self {
        Self { place, name: name.to_owned(), client: None, at: None, given_up: None }
    }

    /// Waits for no answer any more once this flag is set.
    #[must_use]
    pub fn unless(self, given_up: Arc<AtomicBool>) -> Self {
        Self { given_up: Some(given_up), ..self }
    }

    /// Returns the connection.
    ///
    /// # Errors
    /// No instance listens at the place.
    pub fn client(&mut self) -> Result<&mut Client, Failure> {
        let client = match self.client.take() {
            Some(client) => client,
            None => Client::connect_unless(&self.place, &self.name, self.given_up.clone())?,
        };
        Ok(self.client.insert(client))
    }

    /// Returns the connection, with the script position for its next request.
    fn placed(&mut self) -> Result<&mut Client, Failure> {
        let at = self.at.take();
        let client = self.client()?;
        if let Some(at) = at {
            client.at(&at.file, at.line);
        }
        Ok(client)
    }
}

impl Link for Remote {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        self.placed()?.call(request)
    }

    fn call_while(
        &mut self,
        request: Request,
        wanted: &mut dyn FnMut() -> bool,
    ) -> Result<Reply, Failure> {
        let reply = self.placed()?.call_while(request, wanted);
        if reply.as_ref().is_err_and(|failure| failure.code == INTERRUPTED) {
            // The answer may still come; the next request has a connection of its own.
            self.client = None;
        }
        reply
    }

    fn at(&mut self, file: &str, line: u32) {
        match &mut self.client {
            Some(client) => client.at(file, line),
            None => At::keep(&mut self.at, file, line),
        }
    }
}

/// Returns the option `--instance`, which every program has.
pub const fn instance_option<T: Copy>(id: T) -> Opt<T> {
    Opt {
        id,
        short: None,
        long: Some("instance"),
        value: Some("NAME"),
        variable: Some("HAL_INSTANCE"),
        help: "the instance of that name",
    }
}

/// Sleeps, or returns early on a signal. For programs that wait for changes in shared memory, where
/// no machine time is available.
pub fn pause(ms: u32) {
    let nanoseconds = i64::from(ms % 1000) * 1_000_000;
    let time = Timespec { tv_sec: i64::from(ms / 1000), tv_nsec: nanoseconds };
    match rustix::thread::nanosleep(&time) {
        NanosleepRelativeResult::Ok
        | NanosleepRelativeResult::Interrupted(_)
        | NanosleepRelativeResult::Err(_) => {}
    }
}

/// Returns whether the instance's process is gone, that is, whether no process holds its lock.
#[must_use]
pub fn is_gone(place: &Place) -> bool {
    match Folder::open(place) {
        Ok(folder) => folder.is_free(place),
        Err(e) => matches!(e, FolderError::Missing { .. }),
    }
}

/// Returns the message for an instance that no longer answers. Its socket may close shortly before
/// its lock is released.
pub(crate) fn lost_words(place: &Place) -> &'static str {
    for _ in 0..LOOKS_FOR_END {
        if is_gone(place) {
            return "the machine has ended";
        }
        pause(LOOK_MS);
    }
    "the connection to the machine is lost"
}
