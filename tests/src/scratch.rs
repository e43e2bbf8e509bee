//! A folder for each test: its programs run there, and no instance sees another one.

use crate::{guard, lasting, programs::programs};
use hal_protocol::Place;
use rustix::{
    process::{Pid, Signal},
    thread::nanosleep,
    time::Timespec,
};
use std::{
    collections::BTreeMap,
    fs::{self, File},
    os::unix::fs::PermissionsExt as _,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::atomic::{AtomicU32, Ordering},
};

/// Number of polls before a wait fails; 10 ms apart, so five minutes. Only what hangs reaches it: a computer that is busy with
/// other tests takes a minute for all machines.
const LOOKS: u32 = 30_000;

/// A temporary folder that contains a folder for sockets.
#[derive(Debug)]
pub struct Scratch {
    path: PathBuf,
}

/// Beginning of every message about real time.
pub(crate) const REALTIME: &str = "realtime: ";

/// Result of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Standard output, except messages about real time.
    pub stdout: String,
    /// Standard error, except messages about real time.
    pub stderr: String,
    /// Messages about real time. Wakeup latency depends on this computer.
    pub realtime: String,
    /// Exit status; `None` if a signal ended the program.
    pub status: Option<i32>,
}

/// A running program. It is killed if the test drops it, and if the test is killed.
#[derive(Debug)]
pub struct Running {
    child: Child,
    said: PathBuf,
}

impl Scratch {
    /// Creates an empty folder.
    pub fn new(name: &str) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("hal-test-{}-{n}-{name}", std::process::id()));
        fs::create_dir_all(path.join(".run")).unwrap();
        Self { path }
    }

    /// Copies the files of a folder.
    pub fn copy_of(folder: &Path) -> Self {
        let scratch = Self::new(&folder.file_name().unwrap().to_string_lossy());
        for (name, bytes) in files(folder) {
            scratch.write(&name, bytes);
        }
        scratch
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path.join(name), bytes).unwrap();
    }

    /// Returns the name of a file in a folder that nobody else reaches, which is made if necessary.
    pub fn private(&self, name: &str) -> String {
        let folder = self.path.join(".private");
        fs::create_dir_all(&folder).unwrap();
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o700)).unwrap();
        format!(".private/{name}")
    }

    /// Returns the place of an instance that runs in this folder.
    pub fn place(&self, instance: &str) -> Place {
        Place::at(self.path.join(".run/ferrule"), instance).unwrap()
    }

    /// Reads a file.
    pub fn read(&self, name: &str) -> String {
        let path = self.path.join(name);
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// Returns the files in the folder, by name.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        files(&self.path)
    }

    /// Returns the files that instances have left in their folder of sockets and locks.
    pub fn left(&self) -> Vec<String> {
        files(&self.path.join(".run/ferrule")).into_keys().collect()
    }

    /// Returns a command that runs a program under test here. `before` is a command line that runs the program. A function of
    /// its threads may take up to 60 s, unless the test removes `HAL_STUCK_TIME`, and nothing may run for as long, unless it removes
    /// `HAL_MAX_GAP`.
    pub fn command(&self, before: &[&str], program: &str) -> Command {
        let own = programs().join(program);
        let own = if own.is_file() { own } else { PathBuf::from(program) };
        let mut command = match before {
            [] => Command::new(own),
            [first, rest @ ..] => {
                let mut command = Command::new(first);
                command.args(rest).arg(own);
                command
            }
        };
        for (name, _) in std::env::vars_os() {
            if name.to_string_lossy().starts_with("HAL_") {
                command.env_remove(name);
            }
        }
        let path = std::env::var("PATH").unwrap_or_default();
        command
            .env("HAL_RUNTIME_DIR", self.path.join(".run"))
            // On a busy computer that is itself a virtual machine, a thread seems to run while another machine has the
            // processor. That must stop no machine here.
            .env("HAL_STUCK_TIME", "60s")
            // Nor must a computer that ran nothing for half a second, though it was not busy.
            .env("HAL_MAX_GAP", "60s")
            .env("PATH", format!("{}:{path}", programs().display()))
            .current_dir(&self.path)
            .stdin(Stdio::null());
        command
    }

    /// Starts a program and captures its output.
    pub fn start(&self, command: &mut Command) -> Running {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let said = self.path.join(format!(".run/{n}"));
        fs::create_dir_all(&said).unwrap();
        // Files, because a pipe would stay open in processes that the program leaves behind.
        let file = |name| Stdio::from(File::create(said.join(name)).unwrap());
        let child = command.stdout(file("out")).stderr(file("err")).spawn();
        let child = child.unwrap_or_else(|e| panic!("{command:?}: {e}"));
        guard::note('+', child.id());
        Running { child, said }
    }

    /// Runs a program to its end.
    pub fn run(&self, command: &mut Command) -> Output {
        self.start(command).wait()
    }

    /// Runs halrun with these arguments to its end.
    pub fn halrun(&self, words: &[&str]) -> Output {
        self.run(self.command(&[], "halrun").args(words))
    }

    /// Runs halcmd with these arguments.
    pub fn halcmd(&self, words: &[&str]) -> Output {
        self.run(self.command(&[], "halcmd").args(words))
    }

    /// Runs a command of halcmd, with blanks between its words, and returns its output.
    ///
    /// # Panics
    /// The command fails.
    pub fn told(&self, line: &str) -> String {
        let output = self.halcmd(&line.split(' ').collect::<Vec<_>>());
        assert_eq!(output.status, Some(0), "{line}: {output:?}");
        output.stdout
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A failed test may leave a process that still writes here.
        drop(fs::remove_dir_all(&self.path));
    }
}

impl Running {
    /// Returns the process id.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Lets every wait of this test fail at once if the process ends before the test ends it or waits for its end. `name` is
    /// the program in the report.
    #[must_use]
    pub fn lasting(self, name: &'static str) -> Self {
        lasting::add(name, self.pid(), self.said.join("err"));
        self
    }

    /// Sends a signal to the process.
    pub fn signal(&self, signal: Signal) {
        lasting::remove(self.pid());
        let pid = Pid::from_raw(i32::try_from(self.child.id()).unwrap()).unwrap();
        rustix::process::kill_process(pid, signal).unwrap();
    }

    /// Returns whether the process still runs.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Returns the output so far: standard output and standard error, without messages about real time.
    pub fn said(&self) -> (String, String) {
        let (out, err, _) = self.all();
        (out, err)
    }

    /// Returns the messages about real time so far.
    pub fn realtime(&self) -> String {
        self.all().2
    }

    fn all(&self) -> (String, String, String) {
        let text = |name| {
            let bytes = fs::read(self.said.join(name)).unwrap_or_default();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        let (out, err) = (text("out"), text("err"));
        let (late, err) = without_realtime(&err);
        // A script that joins the two streams has messages about real time in its output.
        let (joined, out) = without_realtime(&out);
        (out, err, late + &joined)
    }

    /// Waits until the process ends; returns its status, or `None` at the timeout.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        lasting::remove(self.pid());
        let mut status = None;
        // Without an end there is no status.
        drop(try_until(|| {
            status = self.child.try_wait().unwrap();
            status.is_some()
        }));
        status
    }

    /// Waits until the process ends. After the timeout it is killed, and `stderr` says so.
    pub fn wait(mut self) -> Output {
        let status = self.ended();
        let ended = status.is_some();
        let (stdout, mut stderr, realtime) = self.all();
        if !ended {
            stderr.push_str("(it did not end and was killed)\n");
        }
        Output { stdout, stderr, realtime, status: status.and_then(|s| s.code()) }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            drop(self.child.kill());
            drop(self.child.wait());
        }
        lasting::remove(self.pid());
        guard::note('-', self.child.id());
    }
}

/// Polls until a condition holds.
///
/// # Panics
/// The condition does not hold before the timeout, or a program that the test needs has ended.
pub fn until(what: &str, look: impl FnMut() -> bool) {
    try_until(look).unwrap_or_else(|why| panic!("{what}: {why}"));
}

/// Polls until a condition holds, or returns why it cannot any more.
pub(crate) fn try_until(mut look: impl FnMut() -> bool) -> Result<(), String> {
    for _ in 0..LOOKS {
        if look() {
            return Ok(());
        }
        if let Some(why) = lasting::ended() {
            return Err(why);
        }
        drop(nanosleep(&Timespec { tv_sec: 0, tv_nsec: 10_000_000 }));
    }
    Err("timed out".to_owned())
}

/// Returns the regular files of a folder, by name; empty if the folder does not exist.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    let Ok(entries) = fs::read_dir(folder) else { return out };
    for entry in entries {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_file() {
            out.insert(name, fs::read(path).unwrap());
        } else if !path.is_dir() {
            out.insert(name, Vec::new());
        }
    }
    out
}

/// Takes the messages about real time out of what a program wrote. Returns them, and the rest.
fn without_realtime(said: &str) -> (String, String) {
    said.split_inclusive('\n').partition(|line| line.starts_with(REALTIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_about_real_time_are_in_neither_stream_even_if_a_script_joins_them() {
        let say = "echo 'realtime: a'; echo out; { echo 'realtime: b'; echo err; } >&2; \
                   { echo 'realtime: c'; echo joined; } 2>&1 >&1; echo 'not realtime: d'";
        let scratch = Scratch::new("joined");
        let output = scratch.run(scratch.command(&[], "sh").args(["-c", say]));
        assert_eq!(output.stdout, "out\njoined\nnot realtime: d\n");
        assert_eq!(output.stderr, "err\n");
        assert_eq!(output.realtime, "realtime: b\nrealtime: a\nrealtime: c\n");
    }
}
