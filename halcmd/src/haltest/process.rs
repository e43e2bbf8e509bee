//! Each test in a process of its own: what goes wrong in one does not touch another.

use super::{
    outcome::{Complaint, Outcome, Spot},
    stage::{RUNTIME, Stage},
};
use crate::{ini::plain, remote::pause};
use rustix::process::{Pid, Signal, kill_process_group};
use std::{
    fs::{self, File},
    io,
    os::unix::process::{CommandExt, ExitStatusExt},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::atomic::{AtomicU32, Ordering},
};

/// What a test's process leaves its outcome in.
pub(super) const OUTCOME: &str = "outcome.json";
/// What the recording is called there.
pub(super) const RECORDING: &str = "recording.vcd";
/// How often it is looked whether a test is done.
const LOOK_MS: u32 = 2;

/// How a test is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program haltest; else the one beside this program, or on the path.
    pub program: Option<PathBuf>,
    /// How long it may take on the wall, in nanoseconds.
    pub patience_ns: u64,
    /// Where its recording is kept.
    pub recording: Option<PathBuf>,
}

impl Default for Options {
    fn default() -> Self {
        Self { program: None, patience_ns: super::PATIENCE_NS, recording: None }
    }
}

/// Runs one test in a process of its own.
///
/// What cannot be run is an outcome, too: its complaints say why. Waveforms are compared with the
/// files beside the test and not written.
pub fn run(path: impl AsRef<Path>) -> Outcome {
    run_with(path, &Options::default())
}

/// The same, with these options.
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
    // What the caller's environment asks of halrun is no part of the test.
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
            let limit = crate::units::duration(options.patience_ns);
            format!("given up: the test did not end within {limit} on the wall")
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

/// Keeps a recording under another name. A test that was refused has none.
fn keep(recording: &Path, to: &Path) -> io::Result<()> {
    let mut from = match File::open(recording) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        opened => opened?,
    };
    let mut file = hal_output::Whole::create(to)?;
    io::copy(&mut from, &mut file)?;
    file.finish()
}

/// Waits for a process; nothing when it takes too long, and then it is ended with all that it began.
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

/// The program haltest: this one, the one beside it, the one a folder further up (where tests of
/// Rust are, in `deps`), or that on the path.
fn program() -> io::Result<PathBuf> {
    let own = std::env::current_exe()?;
    if own.file_name().is_some_and(|name| name == super::NAME) {
        return Ok(own);
    }
    let beside = own.ancestors().skip(1).take(2).map(|folder| folder.join(super::NAME));
    let found = beside.into_iter().find(|path| path.is_file());
    Ok(found.unwrap_or_else(|| PathBuf::from(super::NAME)))
}
