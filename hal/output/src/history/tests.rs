//! Tests of kept states: what stays, and what a process that ends in the middle of a write leaves.

use super::{MAX_BYTES, MAX_STATES, STATES_FOLDER, keep, states, write_kept};
use nix::{
    errno::Errno,
    sys::{
        ptrace,
        signal::{Signal, kill},
        wait::{WaitPidFlag, WaitStatus, waitpid},
    },
    unistd::{Pid, gettid},
};
use std::{
    env, fs,
    io::{self, BufRead as _, BufReader, Write as _},
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};

/// A temporary folder, removed when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("hal-history-{}-{name}", std::process::id()));
        drop(fs::remove_dir_all(&path));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self) -> PathBuf {
        self.0.join("tool.tbl")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

fn texts(file: &Path) -> Vec<String> {
    let states = states(file).unwrap();
    states.iter().map(|state| String::from_utf8(state.read().unwrap()).unwrap()).collect()
}

#[test]
fn the_last_states_stay_in_their_order() {
    let folder = Folder::new("order");
    let file = folder.file();
    for n in 0..MAX_STATES + 7 {
        write_kept(&file, format!("{n}").as_bytes()).unwrap();
        let first = n.saturating_sub(MAX_STATES);
        let expected: Vec<String> = (first..n).map(|n| format!("{n}")).collect();
        assert_eq!(texts(&file), expected);
    }
    let names = fs::read_dir(folder.0.join(STATES_FOLDER).join("tool.tbl")).unwrap().count();
    assert_eq!(names, MAX_STATES, "nothing else is left beside the states");
}

#[test]
fn a_write_of_the_same_contents_makes_no_state() {
    let folder = Folder::new("same");
    let file = folder.file();
    for text in ["a", "a", "b", "b", "a", "a"] {
        write_kept(&file, text.as_bytes()).unwrap();
        keep(&file).unwrap();
        keep(&file).unwrap();
    }
    assert_eq!(texts(&file), ["a", "b", "a"]);
}

#[test]
fn contents_that_a_person_wrote_between_two_writes_stay() {
    let folder = Folder::new("person");
    let file = folder.file();
    write_kept(&file, b"ours").unwrap();
    fs::write(&file, "a person's").unwrap();
    let time = fs::metadata(&file).unwrap().modified().unwrap();
    write_kept(&file, b"ours again").unwrap();
    assert_eq!(texts(&file), ["a person's"]);
    assert_eq!(states(&file).unwrap()[0].time, time);
}

#[test]
fn states_are_beside_the_file_that_a_link_means() {
    let folder = Folder::new("link");
    fs::create_dir(folder.0.join("own")).unwrap();
    let link = folder.0.join("own/link.tbl");
    symlink(folder.file(), &link).unwrap();
    write_kept(&link, b"1").unwrap();
    write_kept(&link, b"2").unwrap();
    assert_eq!(texts(&link), ["1"]);
    assert_eq!(texts(&folder.file()), ["1"]);
    assert_eq!(fs::read(folder.file()).unwrap(), b"2");
    assert!(!folder.0.join("own").join(STATES_FOLDER).exists());
}

#[test]
fn files_that_are_too_large_and_devices_have_no_states() {
    let folder = Folder::new("large");
    let file = folder.file();
    let large = vec![b'x'; usize::try_from(MAX_BYTES).unwrap() + 1];
    write_kept(&file, &large).unwrap();
    write_kept(&file, b"small").unwrap();
    assert_eq!(texts(&file), [""; 0]);
    write_kept(Path::new("/dev/null"), b"1").unwrap();
    assert!(states(Path::new("/dev/null")).unwrap().is_empty());
}

#[test]
fn an_error_names_the_folder_and_leaves_the_file() {
    let folder = Folder::new("error");
    let file = folder.file();
    write_kept(&file, b"1").unwrap();
    fs::write(folder.0.join(STATES_FOLDER), "no folder").unwrap();
    let why = write_kept(&file, b"2").unwrap_err().to_string();
    assert!(why.contains(STATES_FOLDER), "{why}");
    assert_eq!(fs::read(&file).unwrap(), b"1");
    assert!(states(&file).unwrap().is_empty());
}

/// Variable with the file that [`writer`] writes in a process of its own.
const FILE: &str = "HAL_HISTORY_FILE";
const NEW: &str = "the new contents";

/// The part of a process that another test ends in the middle of a write.
#[test]
fn writer() {
    let Some(file) = env::var_os(FILE) else { return };
    writeln!(io::stdout(), "\nthread {}", gettid()).unwrap();
    let mut line = String::new();
    io::stdin().read_line(&mut line).unwrap();
    write_kept(Path::new(&file), NEW.as_bytes()).unwrap();
}

/// Record of a process up to a stop: whether it came to its end, and its calls that store something.
struct Run {
    is_whole: bool,
    stores: Vec<&'static str>,
}

/// Starts a process that writes `file`, and kills it at the `stop`-th begin or end of a system call. Returns `None` where
/// no process may trace another.
fn killed_at(file: &Path, stop: usize) -> Option<Run> {
    let mut child: Child = Command::new(env::current_exe().unwrap())
        .args(["--exact", "history::tests::writer", "--nocapture"])
        .env(FILE, file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let thread = lines.find_map(|line| line.strip_prefix("thread ")?.parse().ok()).unwrap();
    let thread = Pid::from_raw(thread);
    let process = Pid::from_raw(child.id().cast_signed());
    if ptrace::attach(thread) == Err(Errno::EPERM) {
        child.kill().unwrap();
        child.wait().unwrap();
        return None;
    }
    let all = Some(WaitPidFlag::__WALL);
    waitpid(thread, all).unwrap();
    ptrace::setoptions(thread, ptrace::Options::PTRACE_O_TRACESYSGOOD).unwrap();
    child.stdin.take().unwrap().write_all(b"go\n").unwrap();
    let mut run = Run { is_whole: true, stores: Vec::new() };
    let mut stops = 0;
    let mut passed = None;
    loop {
        ptrace::syscall(thread, passed.take()).unwrap();
        match waitpid(thread, all).unwrap() {
            WaitStatus::PtraceSyscall(_) => {
                if stops == stop {
                    run.is_whole = false;
                    break;
                }
                if stops % 2 == 0 {
                    run.stores.extend(store(thread));
                }
                stops += 1;
            }
            WaitStatus::Stopped(_, Signal::SIGSTOP) => {}
            WaitStatus::Stopped(_, signal) => passed = Some(signal),
            WaitStatus::Exited(..) | WaitStatus::Signaled(..) => break,
            other => panic!("{other:?}"),
        }
    }
    if !run.is_whole {
        kill(process, Signal::SIGKILL).unwrap();
        waitpid(thread, all).unwrap();
    }
    child.wait().unwrap();
    Some(run)
}

/// Returns the name of the call that a thread begins, if it changes or stores files.
fn store(thread: Pid) -> Option<&'static str> {
    let call = ptrace::getregs(thread).unwrap().orig_rax;
    match call {
        74 => Some("fsync"),
        82 | 264 | 316 => Some("rename"),
        83 | 258 => Some("mkdir"),
        87 | 263 => Some("unlink"),
        _ => None,
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn a_process_that_ends_at_any_point_of_a_write_loses_at_most_that_write() {
    let folder = Folder::new("killed");
    let file = folder.file();
    let mut points = 0;
    for before in [0, 1, 2, MAX_STATES, MAX_STATES + 1] {
        for stop in 0.. {
            drop(fs::remove_dir_all(&folder.0));
            fs::create_dir_all(&folder.0).unwrap();
            let old: Vec<String> = (0..before).map(|n| format!("{n}")).collect();
            for text in &old {
                write_kept(&file, text.as_bytes()).unwrap();
            }
            let Some(run) = killed_at(&file, stop) else { return };
            let at = format!("{before} writes before, stop {stop}");
            let now = fs::read_to_string(&file).ok();
            let last = old.last().cloned();
            let is_new = now.as_deref() == Some(NEW);
            assert!(is_new || now == last, "{at}: {now:?}");
            // The states are those of before, whole and in order; the newest old contents are a state or still the file.
            let found = texts(&file);
            let end = old.len().saturating_sub(usize::from(!is_new));
            let end = end.max(if found.last() == last.as_ref() { old.len() } else { 0 });
            let first = end.saturating_sub(found.len());
            assert_eq!(found, old.get(first..end).unwrap_or_default(), "{at}");
            assert!(found.len() >= (before.max(1) - 1).min(MAX_STATES), "{at}: {}", found.len());
            // Another write goes through, and puts right what was left over.
            write_kept(&file, b"after").unwrap();
            assert!(states(&file).unwrap().len() <= MAX_STATES, "{at}");
            assert_eq!(fs::read(&file).unwrap(), b"after", "{at}");
            if run.is_whole {
                assert!(is_new, "{at}");
                assert_eq!(run.stores, order(before), "{at}");
                break;
            }
            points += 1;
        }
    }
    assert!(points >= 200, "{points} points");
}

/// The order in which a write must store things, so that a loss of power between two of them leaves the file of before
/// or the new one, and never less states than before: each file is stored before it takes its name, and the name before
/// the next step. (`target.rs` tests what a loss of power leaves of such a step.)
#[cfg(target_arch = "x86_64")]
fn order(before: usize) -> Vec<&'static str> {
    let place = ["fsync", "rename", "fsync"];
    let mut out = Vec::new();
    if before == 1 {
        out.extend(["mkdir", "fsync", "mkdir", "fsync"]);
    } else if before > 1 {
        // The folders are there already.
        out.extend(["mkdir", "mkdir"]);
    }
    if before > 0 {
        out.extend(place);
    }
    if before > MAX_STATES {
        out.push("unlink");
    }
    out.extend(place);
    out
}
