//! Each test in a process of its own, so that a failure in one does not affect another.

use super::{
    outcome::{Complaint, Outcome, Spot},
    stage::{RUNTIME, Stage},
};
use crate::{ini::plain, session::remote::pause};
use rustix::process::{Pid, Signal, kill_process_group};
use std::{
    fs::{self, File},
    io,
    os::unix::process::{CommandExt, ExitStatusExt},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::atomic::{AtomicU32, Ordering},
};

/// File in which a test's process leaves its outcome.
pub(super) const OUTCOME: &str = "outcome.json";
/// Name of the recording in the same folder.
pub(super) const RECORDING: &str = "recording.vcd";
/// Interval in milliseconds between two checks for the end of a test.
const LOOK_MS: u32 = 2;

/// Options of a test run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Path of the program haltest. Without it, haltest is looked for beside this program, then on
    /// the path.
    pub program: Option<PathBuf>,
    /// Wall-clock limit in nanoseconds.
    pub patience_ns: u64,
    /// File that receives the recording.
    pub recording: Option<PathBuf>,
}

impl Default for Options {
    fn default() -> Self {
        Self { program: None, patience_ns: super::TIMEOUT_NS, recording: None }
    }
}

/// Runs one test in a process of its own.
///
/// A test that cannot run has an outcome too: its complaints state the reason. Waveforms are
/// compared with the files beside the test; nothing is written to those files.
pub fn run(path: impl AsRef<Path>) -> Outcome {
    run_with(path, &Options::default())
}

/// Like [`run`], with options.
pub fn run_with(path: impl AsRef<Path>, options: &Options) -> Outcome {
    let shown = path.as_ref().display().to_string();
    let mut outcome = begun(&shown, options).unwrap_or_else(|error| {
        let spot = Spot { file: shown.clone(), line: 1 };
        let text = format!("the test cannot be begun: {}", plain(&error));
        Outcome { complaints: vec![Complaint::new(&spot, text)], ..Outcome::default() }
    });
    outcome.file = shown;
    outcome.complaints.extend(super::picture::differences(&mut outcome.pictures));
    outcome.complaints.sort_by(|a, b| a.spot.cmp(&b.spot));
    outcome
}

fn begun(shown: &str, options: &Options) -> io::Result<Outcome> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let stage = Stage::new(NEXT.fetch_add(1, Ordering::Relaxed))?;
    let folder = stage.path();
    let said = folder.join("said");
    let mut command = Command::new(options.program.clone().map_or_else(program, Ok)?);
    // The test does not depend on the caller's HAL variables.
    let own = std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("HAL_"));
    for (name, _) in own.filter(|(name, _)| name != "HAL_RTMOD_DIR") {
        command.env_remove(name);
    }
    let child = command
        .args(["--one", shown, "--to"])
        .arg(folder)
        .env("HAL_RUNTIME_DIR", folder.join(RUNTIME))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&said)?)
        .process_group(0)
        .spawn()?;
    let status = wait(child, options.patience_ns)?;
    let spot = Spot { file: shown.to_owned(), line: 1 };
    let kept = options.recording.as_ref().and_then(|to| {
        let error = keep(&folder.join(RECORDING), to).err()?;
        let text = format!("{}: {}", to.display(), plain(&error));
        Some(Complaint::new(&spot, text))
    });
    let read = fs::read(folder.join(OUTCOME)).ok();
    if let Some(outcome) = read.and_then(|text| serde_json::from_slice::<Outcome>(&text).ok()) {
        let complaints = outcome.complaints.into_iter().chain(kept).collect();
        return Ok(Outcome { complaints, ..outcome });
    }
    let text = match status {
        None => {
            let limit = crate::language::units::duration(options.patience_ns);
            format!("aborted: the test did not end within {limit} of wall-clock time")
        }
        Some(status) => match status.signal() {
            Some(signal) => format!("the process of the test was ended by signal {signal}"),
            None => {
                format!("the process of the test ended with status {}", status.code().unwrap_or(-1))
            }
        },
    };
    let words = fs::read(&said).unwrap_or_default();
    let words = String::from_utf8_lossy(&words);
    let complaint = words.lines().fold(Complaint::new(&spot, text), Complaint::with);
    Ok(Outcome { complaints: vec![complaint], ..Outcome::default() })
}

/// Copies a recording to another file. A test that was refused has no recording.
fn keep(recording: &Path, to: &Path) -> io::Result<()> {
    let mut from = match File::open(recording) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        opened => opened?,
    };
    let mut file = hal_output::Whole::create(to)?;
    io::copy(&mut from, &mut file)?;
    file.finish()
}

/// Waits for a process. If it exceeds the limit, kills its process group and returns `None`.
fn wait(mut child: Child, patience_ns: u64) -> io::Result<Option<ExitStatus>> {
    let looks = patience_ns / (u64::from(LOOK_MS) * 1_000_000);
    for _ in 0..=looks {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        pause(LOOK_MS);
    }
    if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        kill_process_group(group, Signal::KILL)?;
    }
    child.wait()?;
    Ok(None)
}

/// Returns the path of haltest: this program, the one beside it, the one a folder further up (Rust
/// tests are in `deps`), or else the name alone, which is looked up on the path.
fn program() -> io::Result<PathBuf> {
    let own = std::env::current_exe()?;
    if own.file_name().is_some_and(|name| name == super::NAME) {
        return Ok(own);
    }
    let beside = own.ancestors().skip(1).take(2).map(|folder| folder.join(super::NAME));
    let found = beside.into_iter().find(|path| path.is_file());
    Ok(found.unwrap_or_else(|| PathBuf::from(super::NAME)))
}
