//! An engine that runs elsewhere.

use crate::options::Opt;
use hal_protocol::{At, Client, Failure, Folder, FolderError, Link, Place, Reply, Request};
use rustix::{thread::NanosleepRelativeResult, time::Timespec};

/// How often it is looked whether an instance whose socket is closed has ended, and how many
/// milliseconds lie between.
const LOOKS_FOR_END: u32 = 100;
const LOOK_MS: u32 = 2;

/// A connection that is made when it is first needed.
#[derive(Debug)]
pub struct Remote {
    place: Place,
    name: String,
    client: Option<Client>,
    at: Option<At>,
}

impl Remote {
    /// To the instance at `place`, as component `name`.
    #[must_use]
    pub fn new(place: Place, name: &str) -> Self {
        Self { place, name: name.to_owned(), client: None, at: None }
    }

    /// The connection.
    ///
    /// # Errors
    /// Nobody listens.
    pub fn client(&mut self) -> Result<&mut Client, Failure> {
        let client = match self.client.take() {
            Some(client) => client,
            None => Client::connect(&self.place, &self.name)?,
        };
        Ok(self.client.insert(client))
    }
}

impl Link for Remote {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        let at = self.at.take();
        let client = self.client()?;
        if let Some(at) = at {
            client.at(&at.file, at.line);
        }
        client.call(request)
    }

    fn at(&mut self, file: &str, line: u32) {
        match &mut self.client {
            Some(client) => client.at(file, line),
            None => At::keep(&mut self.at, file, line),
        }
    }
}

/// `--instance`, which every program has.
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

/// Sleeps, or returns early when a signal comes. For programs that wait for what others do to
/// shared memory, where no machine time is at hand.
pub fn pause(ms: u32) {
    let nanoseconds = i64::from(ms % 1000) * 1_000_000;
    let time = Timespec { tv_sec: i64::from(ms / 1000), tv_nsec: nanoseconds };
    match rustix::thread::nanosleep(&time) {
        NanosleepRelativeResult::Ok
        | NanosleepRelativeResult::Interrupted(_)
        | NanosleepRelativeResult::Err(_) => {}
    }
}

/// Whether the instance's process is gone: nobody holds its lock.
#[must_use]
pub fn is_gone(place: &Place) -> bool {
    match Folder::open(place) {
        Ok(folder) => folder.is_free(place),
        Err(e) => matches!(e, FolderError::Missing { .. }),
    }
}

/// Returns what is said of an instance that does not answer any more. Its socket may be closed a
/// little before its lock.
pub(crate) fn lost_words(place: &Place) -> &'static str {
    for _ in 0..LOOKS_FOR_END {
        if is_gone(place) {
            return "the machine has ended";
        }
        pause(LOOK_MS);
    }
    "the connection to the machine is lost"
}
