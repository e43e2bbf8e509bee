//! A process that ends in the middle of a write, at each of its system calls.

use super::{Folder, texts};
use crate::history::{MAX_STATES, states, write_kept};
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
    path::Path,
    process::{Child, Command, Stdio},
};

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
        .args(["--exact", "history::tests::killed::writer", "--nocapture"])
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
