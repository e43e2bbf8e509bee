//! The watcher: a small process that outlives the instance's process. It reports how that process
//! ended when that process could not: after SIGKILL, or after a component ended it by a direct
//! system call.

use super::{
    apart,
    board::{self, Board, NOBODY},
    signals, sys,
};
use crate::{os, sync::Ordering};
use core::ffi::c_int;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs::File,
    os::{
        fd::OwnedFd,
        unix::fs::{MetadataExt, OpenOptionsExt},
    },
    path::{Path, PathBuf},
};

/// Handle in the instance's process. While that process runs this program, this end of the pipe
/// stays open.
#[derive(Debug)]
pub(super) struct Watcher {
    leash: OwnedFd,
}

/// Command on the pipe: detach from standard error.
const QUIET: u8 = b'q';

impl Watcher {
    /// Begins to watch this process. Returns `None` if the system refuses, or if the process has
    /// more than one thread.
    pub(super) fn begin(program: &str) -> Option<Self> {
        if apart::threads().len() != 1 {
            return None;
        }
        let me = sys::process();
        let pidfd = apart::pidfd(me)?;
        let (end, leash) = rustix::pipe::pipe_with(rustix::pipe::PipeFlags::CLOEXEC).ok()?;
        match apart::fork_away() {
            apart::Fork::Here => Some(Self { leash }),
            apart::Fork::There => {
                drop(leash);
                apart::be_apart(&[&pidfd, &end]);
                watch(program, me, &pidfd, &end);
                sys::leave(0)
            }
            apart::Fork::Failed => None,
        }
    }

    /// Detaches the watcher from standard error, so that a reader of this process's output sees its
    /// end.
    pub(super) fn be_quiet(&self) {
        // If the watcher has ended, there is nothing to detach.
        rustix::io::write(&self.leash, &[QUIET]).unwrap_or_default();
    }
}

/// Result of an ended process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    Exit(c_int),
    Signal(c_int),
    /// Continues as another program (exec).
    Replaced,
    Unknown,
}

impl Status {
    /// Decodes a status of `wait`.
    pub(super) const fn of(code: c_int) -> Self {
        match code & 0x7f {
            0 => Self::Exit((code >> 8) & 0xff),
            signal => Self::Signal(signal),
        }
    }
}

/// Main function of the watcher: waits until the process has ended, then cleans up and reports.
fn watch(program: &str, process: c_int, pidfd: &OwnedFd, end: &OwnedFd) {
    let own = apart::program_of(process);
    // A process that is ending runs no program.
    let is_same = || apart::program_of(process).is_none_or(|now| Some(now) == own);
    let status = loop {
        match apart::wait_for(pidfd, end, is_same) {
            apart::Came::Byte(QUIET) => {
                let log = board::board().and_then(|board| Known::read(board).log);
                apart::print_elsewhere(log.as_deref());
            }
            apart::Came::Byte(_) => {}
            apart::Came::Closed => break Status::Replaced,
            apart::Came::Ended => break apart::status_of(process, pidfd),
        }
    };
    let Some(board) = board::board() else { return };
    let known = Known::read(board);
    // A crash may end the process while one of its threads writes.
    known.cut_recording(board);
    let lost = board.lost.load(Ordering::Relaxed);
    if let (true, Some((_, path))) = (lost > 0, &known.recording) {
        let path = path.display();
        sys::report(&format!("{program}: {path}: {lost} changes were lost for want of room\n"));
    }
    if board.untold.load(Ordering::Relaxed) == 0 {
        return;
    }
    known.leave_nothing(board);
    sys::report(&format!("{program}: {}\n", known.say(board, status)));
}

/// Contents of the text on the board.
#[derive(Debug, Default)]
struct Known {
    instance: String,
    files: Vec<PathBuf>,
    recording: Option<(u64, PathBuf)>,
    /// Log file of an instance in the background.
    log: Option<PathBuf>,
    threads: BTreeMap<usize, String>,
    functs: BTreeMap<u32, String>,
    doings: BTreeMap<u32, String>,
    /// Components with threads of their own.
    own: BTreeSet<String>,
}

impl Known {
    fn read(board: &Board) -> Self {
        let mut known = Self::default();
        let bytes: Vec<u8> = (0..).map_while(|at| board.byte(at)).collect();
        for line in String::from_utf8_lossy(&bytes).lines() {
            let mut words = line.splitn(3, ' ');
            let mut word = || words.next().unwrap_or_default();
            let (kind, number, rest) = (word(), word(), word());
            match kind {
                "i" => rest.clone_into(&mut known.instance),
                "l" => known.log = Some(rest.into()),
                "s" => known.files.push(rest.into()),
                "r" => known.recording = number.parse().ok().map(|inode| (inode, rest.into())),
                "t" => drop(number.parse().map(|n| known.threads.insert(n, rest.to_owned()))),
                "f" => drop(number.parse().map(|n| known.functs.insert(n, rest.to_owned()))),
                "o" if number == "1" => drop(known.own.insert(rest.to_owned())),
                "o" => drop(known.own.remove(rest)),
                "d" => drop(number.parse().map(|n| known.doings.insert(n, rest.to_owned()))),
                _ => {}
            }
        }
        known
    }

    /// Ends the instance's programs, and removes its socket.
    fn leave_nothing(&self, board: &Board) {
        let programs = board.programs.iter().map(|p| p.load(Ordering::Relaxed));
        programs.filter(|p| *p > 1).for_each(|p| os::end_process(p, false));
        self.remove_files();
    }

    /// Ends the recording at its last whole record.
    fn cut_recording(&self, board: &Board) {
        if let Some((inode, path)) = &self.recording {
            let recorded = board.recorded.load(Ordering::Relaxed);
            cut(path, *inode, recorded, board.recording.load(Ordering::Relaxed));
        }
    }

    /// Removes the socket and the lock file, unless another instance has taken them.
    fn remove_files(&self) {
        let Some(lock) = self.files.last() else { return };
        let Ok(file) = File::options().read(true).write(true).open(lock) else { return };
        let flock = rustix::fs::FlockOperation::NonBlockingLockExclusive;
        if rustix::fs::flock(&file, flock).is_ok() && is_at(&file, lock) {
            for file in &self.files {
                // A file that is already gone is no error.
                drop(std::fs::remove_file(file));
            }
        }
    }

    /// Returns the message about how the process ended and which code was running.
    fn say(&self, board: &Board, status: Status) -> String {
        let how = match status {
            Status::Signal(signal) => format!("was ended by {}", signals::Named(signal)),
            Status::Exit(status) => format!(
                "was ended with status {status} by a system call that bypassed the C library"
            ),
            Status::Replaced => "was replaced by another program (exec)".to_owned(),
            Status::Unknown => "was ended by SIGKILL or by a system call that bypassed the C \
                                library"
                .to_owned(),
        };
        let mut under_way = Vec::new();
        for (i, row) in board.rows.iter().enumerate() {
            let funct = row.funct.load(Ordering::Relaxed);
            if funct != NOBODY {
                let known = self.functs.get(&funct).map_or("a function", String::as_str);
                let thread = self.threads.get(&i).map_or("?", String::as_str);
                under_way.push(format!("{known}, thread '{thread}'"));
            }
        }
        under_way.extend(self.doings.get(&board.doing.load(Ordering::Relaxed)).cloned());
        let own = self.own.iter();
        under_way.extend(own.map(|name| format!("component '{name}' in threads of its own")));
        let under_way = match under_way.as_slice() {
            [] => "no component's code was running".to_owned(),
            list => format!("under way: {}", list.join("; ")),
        };
        format!(
            "instance '{}' {how}; {under_way}; its outputs are as they were, since no stop action \
             could run",
            self.instance
        )
    }
}

/// Truncates a file to `recorded` bytes, unless it is another one or the write that was to make it
/// `recording` bytes long is complete.
fn cut(path: &Path, inode: u64, recorded: u64, recording: u64) {
    // A pipe without a reader is refused at once.
    if let Ok(file) = File::options().write(true).custom_flags(libc::O_NONBLOCK).open(path)
        && let Ok(found) = file.metadata()
        && found.ino() == inode
        && found.is_file()
        && found.len() > recorded
        && found.len() != recording
    {
        // If the system refuses, part of a record remains.
        drop(file.set_len(recorded));
    }
}

/// Returns whether a path still leads to an open file.
fn is_at(file: &File, path: &Path) -> bool {
    let (Ok(open), Ok(there)) = (file.metadata(), std::fs::metadata(path)) else { return false };
    (open.dev(), open.ino()) == (there.dev(), there.ino())
}

#[cfg(test)]
mod tests {
    use super::{Status, cut};
    use std::{fs, os::unix::fs::MetadataExt};

    #[test]
    fn a_status_is_that_of_wait() {
        assert_eq!(Status::of(0x300), Status::Exit(3));
        assert_eq!(Status::of(9), Status::Signal(9));
        assert_eq!(Status::of(0x8b), Status::Signal(11));
    }

    #[test]
    fn a_recording_ends_at_a_whole_record() {
        let path = std::env::temp_dir().join(format!("hal-cut-{}", std::process::id()));
        for (length, is_same, want) in [
            // Nothing of the write has come, part of it, all of it.
            (10, true, 10),
            (13, true, 10),
            (16, true, 16),
            (7, true, 7),
            // Another file has its name now.
            (13, false, 13),
        ] {
            fs::write(&path, vec![b' '; length]).unwrap();
            let inode = fs::metadata(&path).unwrap().ino();
            cut(&path, if is_same { inode } else { inode + 1 }, 10, 16);
            assert_eq!(fs::metadata(&path).unwrap().len(), want, "{length}");
        }
        fs::remove_file(&path).unwrap();
    }
}
