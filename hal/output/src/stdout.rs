//! Writing to standard output.

use crate::reason;
use rustix::{
    event::{PollFd, PollFlags, poll},
    io::Errno,
    stdio::stdout,
};
use std::{
    io,
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

/// Set once the reader of this process's output has closed its end.
static READER_GONE: AtomicBool = AtomicBool::new(false);

/// Reason why a text was not written to standard output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unwritten {
    /// The reader has closed its end, as `head` does.
    ReaderGone,
    /// The system returned an error, with this text.
    Refused(Box<str>),
}

impl core::fmt::Display for Unwritten {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::ReaderGone => f.write_str("standard output: its reader has closed it"),
            Self::Refused(why) => write!(f, "standard output: {why}"),
        }
    }
}

impl core::error::Error for Unwritten {}

impl From<Unwritten> for String {
    fn from(unwritten: Unwritten) -> Self {
        unwritten.to_string()
    }
}

/// Writes a text to standard output without buffering: when this returns, the system has it.
///
/// # Errors
/// The reader has closed its end, or the system returned an error.
pub fn print(text: &str) -> Result<(), Unwritten> {
    let mut rest = text.as_bytes();
    while !rest.is_empty() {
        // `std` is not used here, because it reports success if the descriptor is not open for
        // writing.
        match rustix::io::write(stdout(), rest) {
            Ok(0) => return Err(unwritten(Errno::IO)),
            Ok(n) => rest = rest.get(n..).unwrap_or_default(),
            Err(Errno::INTR) => {}
            Err(Errno::AGAIN) => wait(),
            Err(error) => return Err(unwritten(error)),
        }
    }
    Ok(())
}

/// Returns whether the reader of this process's output has closed its end.
#[must_use]
pub fn reader_is_gone() -> bool {
    // Relaxed: this flag guards no other memory.
    READER_GONE.load(Relaxed)
}

/// Records that the reader has closed its end. For code that writes to a pipe without this module.
pub fn lose_reader() {
    // Relaxed, as above.
    READER_GONE.store(true, Relaxed);
}

/// Returns the error that closing standard output would report. Network file systems report there
/// what they could not store.
pub(crate) fn close() -> Result<(), Unwritten> {
    // Closes a copy, so that the process can still write to the descriptor until it ends.
    let Ok(copy) = rustix::io::dup(stdout()) else { return Ok(()) };
    nix::unistd::close(copy).map_err(|e| unwritten(Errno::from_raw_os_error(e as i32)))
}

fn unwritten(error: Errno) -> Unwritten {
    if error == Errno::PIPE {
        lose_reader();
        return Unwritten::ReaderGone;
    }
    Unwritten::Refused(reason(&io::Error::from(error)).into())
}

/// Waits until the reader makes space, in case another program has made the pipe non-blocking.
fn wait() {
    let out = stdout();
    // A signal or a failure is detected at the next attempt to write.
    let _ = poll(&mut [PollFd::new(&out, PollFlags::OUT)], None);
}
