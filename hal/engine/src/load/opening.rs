//! First opening of a library, in a separate process: the library's initialisers may do anything,
//! even end the process that they run in.
//!
//! The separate process is this program once more. The name under which it was started ([`MARK`])
//! makes it open libraries and end, before its `main`. It shares no memory with this process, whose
//! threads run on meanwhile; a copy of this process (`fork`) would make every page that they write
//! fault.

use crate::{
    PluginError,
    load::plugin_file::{Identity, PluginFile},
    os::{self, process},
};
use core::ffi::{CStr, c_char, c_int};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    pipe::{PipeFlags, pipe_with},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs::File,
    io::Read,
    os::unix::process::{CommandExt, ExitStatusExt},
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// The name under which the separate process is started.
const MARK: &CStr = c"ferrule-opens-a-library";
/// Prefixes of a library's path: symbols are visible to later libraries, or they are not.
const GLOBAL: u8 = b'g';
const LOCAL: u8 = b'l';
/// Answers of the separate process: all libraries are open, or the system's loader has refused one.
/// This process then gets the same refusal when it opens that library itself.
const OPENED: u8 = b'o';
const REFUSED: u8 = b'r';
/// Longest time that opening may take, in nanoseconds.
const TIMEOUT_NS: i64 = 10_000_000_000;
/// Interval at which this process checks for a termination signal meanwhile, in nanoseconds.
const LOOK_NS: i64 = 20_000_000;

/// End of the message to a program that was started with rights that its user lacks.
const PRIVILEGED: &str = "cannot be judged: the program has rights that its user lacks, and opens \
                          nothing with them; take them away with 'sudo chmod u-s' and 'sudo \
                          setcap -r' and the program's path";

/// Result for each file that was opened in a separate process: `None` if nothing was wrong,
/// otherwise how the process ended. Shared by all engines of this process, because a library that
/// has been opened stays mapped.
static TRIED: Mutex<BTreeMap<Identity, Option<Box<str>>>> = Mutex::new(BTreeMap::new());

/// A library to be opened.
#[derive(Clone, Debug)]
pub(crate) struct ToOpen {
    /// Path of the library, without links.
    pub(crate) path: PathBuf,
    /// True if libraries that are opened later may use its symbols.
    pub(crate) global: bool,
}

/// Opens the last of these libraries, after the others, in a separate process, unless that has been
/// done before.
///
/// # Errors
/// The separate process did not get that far: this process must not open `file`.
pub(crate) fn try_first(
    file: &Path,
    identity: Identity,
    libraries: &[ToOpen],
) -> Result<(), PluginError> {
    let shown = || file.display().to_string().into();
    let known = all().get(&identity).cloned();
    let verdict = match known {
        Some(verdict) => verdict,
        None => match tried(libraries) {
            Ok(Tried::Opened | Tried::Refused) => None,
            Ok(Tried::Ended(how)) => Some(how),
            Ok(Tried::Signalled) => return Err(PluginError::Ending { file: shown() }),
            Err(e) => {
                // Without a separate process nothing can be tried; the load continues without the
                // trial.
                let why = os::said(&e);
                tracing::warn!(
                    "{}: not opened in a process of its own first: {why}",
                    file.display()
                );
                return Ok(());
            }
        },
    };
    all().insert(identity, verdict.clone());
    verdict.map_or(Ok(()), |how| Err(PluginError::Dies { file: shown(), how }))
}

/// Does the same for many plugins that are to be opened one by one: in one process, if nothing is
/// wrong with any of them. Otherwise each is tried later by itself.
pub(crate) fn try_together(paths: &BTreeSet<&PathBuf>) {
    let found = paths.iter().filter_map(|path| {
        let file = PluginFile::find(path).ok()??;
        Some((file.identity(), ToOpen { path: file.openable().ok()?, global: false }))
    });
    let new = |(identity, _): &(Identity, ToOpen)| !all().contains_key(identity);
    let (identities, libraries): (Vec<_>, Vec<_>) = found.filter(new).unzip();
    if libraries.len() > 1 && matches!(tried(&libraries), Ok(Tried::Opened)) {
        all().extend(identities.into_iter().map(|identity| (identity, None)));
    }
}

fn all() -> MutexGuard<'static, BTreeMap<Identity, Option<Box<str>>>> {
    TRIED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Result of opening libraries in a separate process.
enum Tried {
    Opened,
    /// The system's loader does not open one of them; this process gets the same refusal later.
    Refused,
    /// The process did not return; with a description of its end.
    Ended(Box<str>),
    /// A termination signal has been sent to this process.
    Signalled,
}

fn tried(libraries: &[ToOpen]) -> std::io::Result<Tried> {
    if process::is_privileged() {
        // The separate process would not open anything: it could not know who asks for it.
        return Ok(Tried::Ended(PRIVILEGED.into()));
    }
    let (from, to) = pipe_with(PipeFlags::CLOEXEC)?;
    let words = libraries.iter().map(|l| {
        let letter = if l.global { GLOBAL } else { LOCAL };
        let mut word = vec![letter];
        word.extend_from_slice(l.path.as_os_str().as_encoded_bytes());
        // SAFETY: ASCII before bytes that came from a path.
        unsafe { std::ffi::OsString::from_encoded_bytes_unchecked(word) }
    });
    let mut child = Command::new("/proc/self/exe")
        .arg0(MARK.to_str().unwrap_or_default())
        .args(words)
        // The answer comes through this pipe, so that no output of a library can be mistaken for
        // it.
        .stdin(Stdio::from(to))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        // A Ctrl-C at the terminal must reach only this process.
        .process_group(0)
        .spawn()?;
    let heard = listen(File::from(from));
    if !matches!(heard, Heard::End(None)) {
        // Includes every process that it has started. Harmless if it has already ended.
        process::end_group(child.id());
    }
    let status = child.wait()?;
    Ok(match heard {
        Heard::End(Some(OPENED)) => Tried::Opened,
        Heard::End(Some(REFUSED)) => Tried::Refused,
        Heard::End(_) => Tried::Ended(ended(status)),
        Heard::Nothing => {
            let seconds = TIMEOUT_NS / 1_000_000_000;
            Tried::Ended(format!("did not come back within {seconds} s").into())
        }
        Heard::Signalled => Tried::Signalled,
    })
}

enum Heard {
    /// The answer, or the end of the process without one.
    End(Option<u8>),
    Nothing,
    Signalled,
}

fn listen(mut from: File) -> Heard {
    let limit = os::monotonic_ns().saturating_add(TIMEOUT_NS);
    loop {
        if crate::ends::is_asked() {
            return Heard::Signalled;
        }
        if os::monotonic_ns() > limit {
            return Heard::Nothing;
        }
        let look = Timespec { tv_sec: 0, tv_nsec: LOOK_NS };
        let mut fds = [PollFd::new(&from, PollFlags::IN)];
        if !matches!(poll(&mut fds, Some(&look)), Ok(1..)) {
            continue;
        }
        let mut byte = [0];
        if let Ok(n) = from.read(&mut byte) {
            return Heard::End(byte.first().copied().filter(|_| n == 1));
        }
    }
}

/// Describes how a process ended that should have returned.
fn ended(status: ExitStatus) -> Box<str> {
    match (status.signal(), status.code()) {
        (Some(signal), _) => format!("ended by {}", process::signal_name(signal)).into(),
        (None, Some(code)) => format!("ended the process, with status {code}").into(),
        (None, None) => "ended the process".into(),
    }
}

/// Runs before `main` in every program with an engine: a process that was started to open libraries
/// opens them and ends here.
extern "C" fn before_main(n: c_int, words: *const *const c_char, _: *const *const c_char) {
    let word = |i: usize| {
        // SAFETY: within the words of this program, `n` of them.
        let at = unsafe { words.add(i) };
        // SAFETY: the C library keeps them.
        let word = unsafe { at.read() };
        // SAFETY: each is a text.
        unsafe { CStr::from_ptr(word) }
    };
    let n = usize::try_from(n).unwrap_or(0);
    if n < 2 || word(0) != MARK || process::is_privileged() {
        return;
    }
    process::die_with_parent();
    for word in (1..n).map(word) {
        let Some((letter, path)) = word.to_bytes_with_nul().split_first() else { continue };
        let Ok(path) = CStr::from_bytes_with_nul(path) else { continue };
        if !process::open_library(path, *letter == GLOBAL) {
            process::tell(0, REFUSED);
            os::end_with(0);
        }
    }
    process::tell(0, OPENED);
    os::end_with(0)
}

#[cfg(all(target_env = "gnu", not(any(miri, loom))))]
#[used]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn(c_int, *const *const c_char, *const *const c_char) = before_main;
