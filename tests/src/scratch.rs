//! A folder of its own for each test: programs run in it, and no instance sees another.

use crate::programs::programs;
use rustix::{
    process::{Pid, Signal},
    thread::nanosleep,
    time::Timespec,
};
use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::atomic::{AtomicU32, Ordering},
};

/// How often something is looked at before it is given up: 10 ms lie between, so a minute.
const LOOKS: u32 = 6_000;

/// A temporary folder, with one for sockets in it.
#[derive(Debug)]
pub struct Scratch {
    path: PathBuf,
}

/// How every message about real time begins.
pub(crate) const REALTIME: &str = "realtime: ";

/// What a program did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// What it printed.
    pub stdout: String,
    /// What it complained about, but for real time.
    pub stderr: String,
    /// What it said of real time. How late threads wake is this computer's matter.
    pub realtime: String,
    /// Its exit status; none when a signal ended it.
    pub status: Option<i32>,
}

/// A program under way. It is killed if a test leaves it behind.
#[derive(Debug)]
pub struct Running {
    child: Child,
    said: PathBuf,
}

impl Scratch {
    /// An empty folder.
    pub fn new(name: &str) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("hal-test-{}-{n}-{name}", std::process::id()));
        fs::create_dir_all(path.join(".run")).unwrap();
        Self { path }
    }

    /// A copy of a folder's files.
    pub fn copy_of(folder: &Path) -> Self {
        let scratch = Self::new(&folder.file_name().unwrap().to_string_lossy());
        for (name, bytes) in files(folder) {
            scratch.write(&name, bytes);
        }
        scratch
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path.join(name), bytes).unwrap();
    }

    /// Reads a file.
    pub fn read(&self, name: &str) -> String {
        let path = self.path.join(name);
        fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// The files in it, by name.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        files(&self.path)
    }

    /// What instances have left in their folder of sockets and locks.
    pub fn left(&self) -> Vec<String> {
        files(&self.path.join(".run/ferrule")).into_keys().collect()
    }

    /// A program under test, to be run here. Words before it are a program that runs it.
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
            .env("PATH", format!("{}:{path}", programs().display()))
            .current_dir(&self.path)
            .stdin(Stdio::null());
        command
    }

    /// Starts a program; what it prints is kept.
    pub fn start(&self, command: &mut Command) -> Running {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let said = self.path.join(format!(".run/{n}"));
        fs::create_dir_all(&said).unwrap();
        // Files, since a pipe would stay open in whatever the program leaves behind.
        let file = |name| Stdio::from(File::create(said.join(name)).unwrap());
        let child = command.stdout(file("out")).stderr(file("err")).spawn();
        Running { child: child.unwrap_or_else(|e| panic!("{command:?}: {e}")), said }
    }

    /// Runs a program to its end.
    pub fn run(&self, command: &mut Command) -> Output {
        self.start(command).wait()
    }

    /// Runs halrun with these words to its end.
    pub fn halrun(&self, words: &[&str]) -> Output {
        self.run(self.command(&[], "halrun").args(words))
    }

    /// Runs halcmd with these words.
    pub fn halcmd(&self, words: &[&str]) -> Output {
        self.run(self.command(&[], "halcmd").args(words))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A test that fails may leave something that still writes here.
        drop(fs::remove_dir_all(&self.path));
    }
}

impl Running {
    /// Its number.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Sends it a signal.
    pub fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(i32::try_from(self.child.id()).unwrap()).unwrap();
        rustix::process::kill_process(pid, signal).unwrap();
    }

    /// Whether it runs still.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// What it has said so far: printed, and complained about, but for real time.
    pub fn said(&self) -> (String, String) {
        let (out, err, _) = self.all();
        (out, err)
    }

    /// What it has said so far of real time.
    pub fn realtime(&self) -> String {
        self.all().2
    }

    fn all(&self) -> (String, String, String) {
        let text = |name| {
            let bytes = fs::read(self.said.join(name)).unwrap_or_default();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        let err = text("err");
        let (realtime, other) =
            err.split_inclusive('\n').partition(|line| line.starts_with(REALTIME));
        (text("out"), other, realtime)
    }

    /// Waits until it ends: how it did; none for one that never does.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        let mut status = None;
        try_until(|| {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        status
    }

    /// Waits until it ends. One that never does is killed, and that is among its complaints.
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
    }
}

/// Looks until something is so; fails when it never is.
pub fn until(what: &str, look: impl FnMut() -> bool) {
    assert!(try_until(look), "given up: {what}");
}

fn try_until(mut look: impl FnMut() -> bool) -> bool {
    (0..LOOKS).any(|_| {
        look() || {
            drop(nanosleep(&Timespec { tv_sec: 0, tv_nsec: 10_000_000 }));
            false
        }
    })
}

/// The plain files of a folder, by name; none if there is no such folder.
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
