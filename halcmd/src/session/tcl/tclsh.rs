//! The interpreter `tclsh`, which executes the Tcl files of a machine, and the pipes to it.

use super::wire;
use rustix::{
    event::{PollFd, PollFlags, poll},
    fd::OwnedFd,
    io::{Errno, FdFlags, fcntl_setfd, read, write},
    pipe::{PipeFlags, pipe_with},
    process::{Pid, Resource, Rlimit, prlimit},
    time::Timespec,
};
use std::{
    io,
    os::fd::AsRawFd,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
};

/// Name of the interpreter.
pub(crate) const TCLSH: &str = "tclsh";
/// Script that executes a Tcl file.
const START: &str = "haltcl.tcl";
/// Environment variable with the numbers of the pipes.
const PIPES: &str = "FERRULE_TCL";
/// Environment variable with the folders of Tcl packages.
pub(crate) const PACKAGES: &str = "TCLLIBPATH";
/// Environment variable with the folder of HAL files that Tcl files source.
const LIBRARY: &str = "HALLIB_DIR";
/// Address space of an interpreter in a dry run.
const MOST_BYTES: u64 = 1 << 30;
/// Time that a request is waited for before the engine serves its clients.
const WAIT_NS: i64 = 5_000_000;

/// A Tcl file and its arguments.
#[derive(Clone, Debug)]
pub(crate) struct TclFile<'a> {
    /// Name for messages.
    pub(crate) shown: &'a str,
    /// Path of the file.
    pub(crate) path: &'a Path,
    /// Arguments, as `argv`.
    pub(crate) args: &'a [String],
    /// Folders with HAL files, the first of which is `HALLIB_DIR`.
    pub(crate) libraries: &'a [PathBuf],
}

/// A running interpreter.
#[derive(Debug)]
pub(crate) struct Tclsh {
    child: Child,
    /// Pipe of answers.
    to: OwnedFd,
    /// Pipe of requests.
    from: OwnedFd,
}

/// Event of an interpreter of Tcl.
pub(crate) enum TclshEvent {
    /// Bytes of requests have arrived.
    Bytes(Vec<u8>),
    /// Nothing has arrived.
    Nothing,
    /// The interpreter has ended.
    Ended(ExitStatus),
}

impl Tclsh {
    /// Starts an interpreter that sends requests.
    pub(crate) fn start(mut command: Command, reads_input: bool) -> io::Result<Self> {
        let (theirs_in, to) = pipe_with(PipeFlags::CLOEXEC)?;
        let (from, theirs_out) = pipe_with(PipeFlags::CLOEXEC)?;
        command.env(PIPES, format!("{} {}", theirs_in.as_raw_fd(), theirs_out.as_raw_fd()));
        if !reads_input {
            command.stdin(Stdio::null());
        }
        // The interpreter inherits its ends of the pipes; programs that are started later do not.
        for end in [&theirs_in, &theirs_out] {
            fcntl_setfd(end, FdFlags::empty())?;
        }
        let child = command.spawn()?;
        Ok(Self { child, to, from })
    }

    /// Limits the memory of the interpreter.
    pub(crate) fn limit(&self) {
        let limit = Rlimit { current: Some(MOST_BYTES), maximum: Some(MOST_BYTES) };
        // Without the limit the file is executed all the same.
        prlimit(Some(Pid::from_child(&self.child)), Resource::As, limit).ok();
    }

    /// Waits a short time for requests.
    pub(crate) fn event(&mut self) -> io::Result<TclshEvent> {
        let wait = Timespec { tv_sec: 0, tv_nsec: WAIT_NS };
        let ready = {
            let mut fds = [PollFd::new(&self.from, PollFlags::IN)];
            match poll(&mut fds, Some(&wait)) {
                Ok(_) => fds.iter().fold(PollFlags::empty(), |all, fd| all | fd.revents()),
                Err(Errno::INTR) => PollFlags::empty(),
                Err(error) => return Err(error.into()),
            }
        };
        if ready.contains(PollFlags::IN) {
            let mut chunk = [0; 65536];
            let n = read(&self.from, &mut chunk)?;
            return Ok(TclshEvent::Bytes(chunk.get(..n).unwrap_or_default().to_vec()));
        }
        if !ready.is_empty() {
            // It has closed the pipe, as it does when it ends.
            return self.child.wait().map(TclshEvent::Ended);
        }
        let ended = self.child.try_wait()?;
        Ok(ended.map_or(TclshEvent::Nothing, TclshEvent::Ended))
    }

    /// Sends an answer. An interpreter that has ended meanwhile needs none.
    pub(crate) fn answer(&mut self, texts: &[String]) {
        let text = wire::sent(texts);
        let mut rest = text.as_bytes();
        while let Ok(n) = write(&self.to, rest) {
            rest = rest.get(n..).unwrap_or_default();
            if rest.is_empty() {
                return;
            }
        }
    }

    /// Ends the interpreter.
    pub(crate) fn end(mut self) {
        // It may have ended already.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Returns the command that starts a Tcl file, to which its name and its arguments are added. The first of the folders with
/// HAL files that exists is that of `HALLIB_DIR`, unless the user has named another one.
pub(crate) fn command(folder: &Path, libraries: &[PathBuf]) -> Command {
    let mut command = Command::new(TCLSH);
    command.arg(folder.join(START));
    command.envs(packages(folder).map(|path| (PACKAGES, path)));
    if std::env::var_os(LIBRARY).is_none() {
        command.envs(libraries.iter().find(|l| l.is_dir()).map(|l| (LIBRARY, l)));
    }
    command
}

/// Returns the folder with Ferrule's Tcl packages: beside the running program, or where they are installed with it. The
/// error is the folder in which they should be.
pub(crate) fn folder() -> Result<PathBuf, PathBuf> {
    let bin = std::env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_path_buf));
    let bin = bin.unwrap_or_default();
    let folders = [bin.join("tcl"), bin.join("../share/ferrule/tcl")];
    folders.iter().find(|f| f.join(START).is_file()).cloned().ok_or_else(|| bin.join("tcl"))
}

/// Returns the list of folders of Tcl packages, with Ferrule's first. `None` if its name cannot be part of the list.
pub(crate) fn packages(folder: &Path) -> Option<String> {
    let own = folder.to_str().filter(|name| !name.contains(['{', '}', '\\']))?;
    let before = std::env::var(PACKAGES).unwrap_or_default();
    Some(format!("{{{own}}} {before}").trim_end().to_owned())
}
