//! Standard output.

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

/// Why a text is not on standard output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unwritten {
    /// The reader has closed its end, as `head` does.
    ReaderGone,
    /// The system refused, with its reason.
    Refused(Box<str>),
}

impl core::fmt::Display for Unwritten {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::ReaderGone => f.write_str("standard output: its reader has gone"),
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

/// Writes a text to standard output. Nothing is held back: when this returns, the system has it.
///
/// # Errors
/// The reader has gone, or the system refuses.
pub fn print(text: &str) -> Result<(), Unwritten> {
    let mut rest = text.as_bytes();
    while !rest.is_empty() {
        // Not through `std`, which takes a descriptor that is not open for writing as a success.
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

/// Whether the reader of this process's output has closed its end.
#[must_use]
pub fn reader_is_gone() -> bool {
    // Lone: it says nothing about other memory.
    READER_GONE.load(Relaxed)
}

/// Notes that the reader has closed its end, for those who write to a pipe by another way.
pub fn lose_reader() {
    // Lone, as above.
    READER_GONE.store(true, Relaxed);
}

/// Learns what the file system says when standard output is closed: network file systems report
/// there what they could not store.
pub(crate) fn close() -> Result<(), Unwritten> {
    // A copy: the descriptor itself stays open for whatever the process still writes at its end.
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

/// Waits until a reader makes room, where another program has made the pipe not wait by itself.
fn wait() {
    let out = stdout();
    // A signal or a failure shows at the next attempt to write.
    let _ = poll(&mut [PollFd::new(&out, PollFlags::OUT)], None);
}
