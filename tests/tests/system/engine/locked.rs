//! Memory that realtime threads use stays resident, processors are kept out of sleep states for them, and missed cycles
//! are counted: verified through the kernel.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, unsafe_code, reason = "tests")]

use hal_protocol::{Reply, ThreadInfo};
use hal_tests::{
    plugins::plugins,
    programs::programs,
    scratch::{Running, Scratch, until},
    tools::{Tool, report},
};
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open};
use std::{fs, os::fd::AsRawFd, path::Path, process::Command};

const MACHINE: &str = "loadrt threads name1=t period1=1000000
loadrt deep
addf deep.0 t
setp deep.0.kib 8
start
";

/// A mapping of a process, as the kernel shows it.
#[derive(Debug)]
struct Mapping {
    start: usize,
    end: usize,
    name: String,
    resident_kib: u64,
    locked: bool,
}

fn mappings(pid: u32) -> Vec<Mapping> {
    let text = fs::read_to_string(format!("/proc/{pid}/smaps")).unwrap();
    let mut all: Vec<Mapping> = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let range = words[0]
            .split_once('-')
            .map(|(a, b)| (usize::from_str_radix(a, 16).ok(), usize::from_str_radix(b, 16).ok()));
        if let Some((Some(start), Some(end))) = range {
            let name = words.get(5..).unwrap_or_default().join(" ");
            all.push(Mapping { start, end, name, resident_kib: 0, locked: false });
        } else if let Some(last) = all.last_mut() {
            match words[0] {
                "Rss:" => last.resident_kib = words[1].parse().unwrap(),
                "VmFlags:" => last.locked = words.contains(&"lo"),
                _ => {}
            }
        }
    }
    // Mappings of the kernel, in every process.
    all.retain(|m| !["[vvar]", "[vvar_vclock]", "[vdso]", "[vsyscall]"].contains(&m.name.as_str()));
    all
}

/// Returns the KiB that are resident and not locked.
fn unlocked(pid: u32) -> u64 {
    mappings(pid).iter().filter(|m| !m.locked).map(|m| m.resident_kib).sum()
}

fn resident(pid: u32) -> u64 {
    mappings(pid).iter().map(|m| m.resident_kib).sum()
}

/// Returns the minor and major page faults of the HAL threads.
fn faults(pid: u32) -> (u64, u64) {
    let mut sum = (0, 0);
    let mut seen = 0;
    for task in fs::read_dir(format!("/proc/{pid}/task")).unwrap() {
        let stat = fs::read_to_string(task.unwrap().path().join("stat")).unwrap_or_default();
        let Some((before, after)) = stat.rsplit_once(')') else { continue };
        if before.ends_with("(hal-thread") {
            let words: Vec<u64> =
                after.split_whitespace().map(|w| w.parse().unwrap_or(0)).collect();
            // Counted from the state, which is the third field: the 10th and the 12th field.
            sum = (sum.0 + words[7], sum.1 + words[9]);
            seen += 1;
        }
    }
    assert_eq!(seen, 1, "one thread of the system runs the HAL thread");
    sum
}

/// Asks the kernel to page out every page of a process that may be paged out.
fn push_out(pid: u32) {
    let process = pidfd_open(Pid::from_raw(pid.cast_signed()).unwrap(), PidfdFlags::empty());
    let process = process.unwrap();
    for m in mappings(pid) {
        let part = libc::iovec {
            iov_base: std::ptr::without_provenance_mut(m.start),
            iov_len: m.end - m.start,
        };
        // SAFETY: advice for another process; the contents of its memory stay unchanged.
        unsafe {
            libc::syscall(
                libc::SYS_process_madvise,
                process.as_raw_fd(),
                &raw const part,
                1,
                libc::MADV_PAGEOUT,
                0,
            )
        };
    }
}

fn scratch(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    scratch.write("m.hal", MACHINE);
    // Copies of its own: the kernel keeps pages that several processes use.
    let copy = |from: &Path, to: &str| {
        let to = scratch.path().join(to);
        fs::copy(from, &to).unwrap();
        // A page that has not been written to disk is not paged out.
        fs::File::open(to).unwrap().sync_all().unwrap();
    };
    copy(&plugins().join("libfaulty.so"), "libfaulty.so");
    copy(&programs().join("libthreads.so"), "libthreads.so");
    copy(&programs().join("liblogic.so"), "liblogic.so");
    copy(&programs().join("halrun"), "halrun");
    scratch
}

fn machine(scratch: &Scratch, before: &[&str], words: &[&str]) -> Running {
    let halrun = scratch.path().join("halrun").display().to_string();
    let mut command: Command = scratch.command(before, &halrun);
    command.env("HAL_RTMOD_DIR", scratch.path()).args(words).arg("m.hal");
    let mut running = scratch.start(&mut command);
    until("it runs", || {
        assert!(running.is_running(), "it ended, and said {:?}", running.said());
        thread(scratch).is_some_and(|t| t.cycles > 5)
    });
    running
}

fn thread(scratch: &Scratch) -> Option<ThreadInfo> {
    let output = scratch.halcmd(&["--json", "show", "thread", "t"]);
    match serde_json::from_str(&output.stdout) {
        Ok(Reply::Threads(list)) => list.into_iter().find(|t| t.name == "t"),
        _ => None,
    }
}

/// Waits for cycles.
fn cycles(scratch: &Scratch, n: u64) {
    let end = thread(scratch).unwrap().cycles + n;
    until("cycles", || thread(scratch).unwrap().cycles >= end);
}

/// Makes each cycle use this much stack.
fn use_stack(scratch: &Scratch, kib: &str) {
    assert_eq!(scratch.halcmd(&["setp", "deep.0.kib", kib]).status, Some(0));
    until("it is used", || scratch.halcmd(&["getp", "deep.0.used"]).stdout.trim() == kib);
    cycles(scratch, 5);
}

fn status(scratch: &Scratch) -> String {
    scratch.halcmd(&["status", "instance"]).stdout
}

fn end(scratch: &Scratch, running: Running) {
    assert_eq!(scratch.halrun(&["-U"]).status, Some(0));
    let output = running.wait();
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
}

/// Returns whether this user may use `SCHED_FIFO` and lock memory; the test is skipped otherwise.
fn has_rights(status: &str, needs_memory: bool) -> bool {
    let fifo = status.contains("threads:    running; SCHED_FIFO");
    let may = fifo && (!needs_memory || !status.contains("may be pushed out"));
    if !may {
        report("this user may not use SCHED_FIFO or lock memory");
    }
    may
}

/// Returns the command line that limits the number of bytes that a program may lock; the test is skipped if the
/// programs for it are missing.
fn limited(memlock: &'static str) -> Option<Vec<&'static str>> {
    let mut words = vec!["prlimit", memlock];
    if rustix::process::geteuid().is_root() {
        words.extend(["setpriv", "--bounding-set=-ipc_lock"]);
    }
    if !["prlimit", "setpriv"].into_iter().all(|tool| Tool::of(tool).is_installed()) {
        return None;
    }
    Some(words)
}

#[test]
fn all_memory_is_locked_and_what_is_loaded_later_too() {
    let scratch = scratch("locked");
    let running = machine(&scratch, &[], &[]);
    let shown = status(&scratch);
    if !has_rights(&shown, true) {
        return;
    }
    let pid = running.pid();
    assert_eq!(unlocked(pid), 0, "{:#?}", mappings(pid));
    assert!(resident(pid) > 1024);
    let line = shown.lines().find(|l| l.contains("memory:")).unwrap();
    assert!(line.ends_with(" MiB stay in RAM"), "{line}");
    let lib = |name: &str| -> Vec<Mapping> {
        mappings(pid).into_iter().filter(|m| m.name.ends_with(name)).collect()
    };
    assert!(lib("liblogic.so").is_empty());
    assert_eq!(scratch.halcmd(&["loadrt", "and2", "count=10000"]).status, Some(0));
    let parts = lib("liblogic.so");
    assert!(parts.len() > 2);
    for m in parts {
        let all = (m.end - m.start) as u64 / 1024;
        assert_eq!((m.resident_kib, m.locked), (all, true), "{m:?}");
    }
    assert_eq!(unlocked(pid), 0, "10,000 components later: {:#?}", mappings(pid));
    end(&scratch, running);
}

#[test]
fn the_stack_of_a_thread_is_there_before_its_first_cycle() {
    // With every right, and as a user who may lock nothing.
    let Some(limited) = limited("--memlock=0") else { return };
    for before in [&[][..], &limited] {
        let scratch = scratch("stack");
        let running = machine(&scratch, before, &[]);
        if !has_rights(&status(&scratch), before.is_empty()) {
            return;
        }
        use_stack(&scratch, "9");
        let (minor, major) = faults(running.pid());
        use_stack(&scratch, "900");
        assert_eq!(faults(running.pid()), (minor, major), "900 KiB of stack later: {before:?}");
        end(&scratch, running);
    }
}

#[test]
fn what_cannot_be_locked_is_said_once_with_the_right_that_is_missing() {
    let scratch = scratch("limited");
    let Some(limited) = limited("--memlock=4194304") else { return };
    let running = machine(&scratch, &limited, &[]);
    let shown = status(&scratch);
    if !has_rights(&shown, false) {
        return;
    }
    for words in [["stop"], ["start"]] {
        assert_eq!(scratch.halcmd(&words).status, Some(0));
    }
    let said = running.realtime();
    let lines: Vec<&str> = said.lines().filter(|l| l.contains("memory")).collect();
    let [line] = lines[..] else { panic!("{said}") };
    let right = "the rest may be pushed out: RLIMIT_MEMLOCK is 4.0 MiB and must be unlimited; see \
                 \"Real time\" in README.md";
    assert!(line.ends_with(right), "{line}");
    // As much as the limit permits is locked: the thread's stack, the values, and as much of the rest as fits.
    let pid = running.pid();
    let locked: u64 = mappings(pid).iter().filter(|m| m.locked).map(|m| m.resident_kib).sum();
    assert!(2048 < locked && locked <= 4096, "{locked} KiB");
    assert!(shown.contains("MiB may be pushed out\n"), "{shown}");
    end(&scratch, running);
}

#[test]
fn no_page_of_a_running_machine_can_be_pushed_out() {
    let scratch = scratch("pushed");
    // Without locks, pages are removed: the request to the kernel has an effect.
    let mut command = scratch.command(&[], &scratch.path().join("halrun").display().to_string());
    command.env("HAL_RTMOD_DIR", scratch.path()).env("HAL_NO_FIFO", "1").arg("m.hal");
    let loose = scratch.start(&mut command);
    until("it runs", || thread(&scratch).is_some_and(|t| t.cycles > 5));
    let before = resident(loose.pid());
    push_out(loose.pid());
    let after = resident(loose.pid());
    assert_eq!(scratch.halcmd(&["shutdown"]).status, Some(0));
    let output = loose.wait();
    let no_fifo = "realtime: no SCHED_FIFO, threads may be late: HAL_NO_FIFO is set; see \"Real \
                   time\" in README.md\n";
    assert!(output.realtime.starts_with(no_fifo), "{}", output.realtime);
    if after >= before {
        return report("this kernel pushes no pages out on demand");
    }

    let running = machine(&scratch, &[], &[]);
    if !has_rights(&status(&scratch), true) {
        return;
    }
    let (pid, faulted) = (running.pid(), faults(running.pid()));
    let before = resident(pid);
    push_out(pid);
    assert!(resident(pid) >= before);
    cycles(&scratch, 50);
    assert_eq!(faults(pid), faulted);
    end(&scratch, running);
}

/// Returns whether the process holds the file open that keeps processors out of sleep states.
fn holds_processors_awake(pid: u32) -> bool {
    let open = fs::read_dir(format!("/proc/{pid}/fd")).unwrap();
    let mut targets = open.filter_map(|fd| fs::read_link(fd.unwrap().path()).ok());
    targets.any(|to| to == Path::new("/dev/cpu_dma_latency"))
}

#[test]
fn processors_are_kept_awake_while_fifo_threads_run_unless_they_are_to_sleep() {
    let scratch = scratch("idle");
    for (words, says) in [
        (
            &["--dma-latency", "20"][..],
            "/dev/cpu_dma_latency is held: processors wake within 20 us",
        ),
        (&["--dma-latency", "off"], "processors sleep as the system lets them"),
    ] {
        let running = machine(&scratch, &[], words);
        let shown = status(&scratch);
        if !has_rights(&shown, false) || shown.contains("processors may sleep deeply: ") {
            return report("this user may not write /dev/cpu_dma_latency");
        }
        assert!(shown.contains(&format!("  idle:       {says}\n")), "{shown}");
        let pid = running.pid();
        assert_eq!(holds_processors_awake(pid), words[1] == "20");
        // Without threads, nothing is held open.
        for words in [&["stop"][..], &["delf", "deep.0", "t"], &["unloadrt", "threads"]] {
            assert_eq!(scratch.halcmd(words).status, Some(0), "{words:?}");
        }
        assert!(!holds_processors_awake(pid));
        drop(running);
    }
}

#[test]
fn a_stopped_process_counts_every_cycle_that_it_missed_and_is_not_stuck() {
    let scratch = scratch("stopped");
    let running = machine(&scratch, &[], &["--stuck-time", "1ms"]);
    let counted = || thread(&scratch).map(|t| t.cycles + t.missed).unwrap();
    let before = counted();
    let mut stood_ns = 0;
    for _ in 0..5 {
        running.signal(Signal::STOP);
        until("it is stopped", || {
            let stat = fs::read_to_string(format!("/proc/{}/stat", running.pid())).unwrap();
            stat.rsplit(')').next().unwrap().trim_start().starts_with('T')
        });
        let now = || {
            let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
            t.tv_sec * 1_000_000_000 + t.tv_nsec
        };
        let begin = now();
        until("50 ms have passed", || now() - begin > 50_000_000);
        stood_ns += now() - begin;
        running.signal(Signal::CONT);
        cycles(&scratch, 5);
    }
    let stood = u64::try_from(stood_ns / 1_000_000).unwrap();
    let t = thread(&scratch).unwrap();
    assert!(t.missed + 5 >= stood, "{} of {stood} ms", t.missed);
    // Each period is a cycle that ran or one that was missed.
    assert!(counted() - before >= stood);
    let shown = status(&scratch);
    assert!(!shown.contains("fault:") && shown.contains(" cycles missed"), "{shown}");
    let said = running.realtime();
    let first = said.lines().find(|l| l.starts_with("realtime: thread 't' ")).unwrap();
    assert!(first.contains(" woke ") || first.contains(" took "), "{first}");
    end(&scratch, running);
}

#[test]
fn threads_run_on_a_processor_that_the_process_was_not_started_on() {
    let online = fs::read_to_string("/sys/devices/system/cpu/online").unwrap();
    if online.trim() == "0" {
        return report("this computer has one processor");
    }
    // Like an isolated processor: it is not among those that the process may use.
    let scratch = scratch("isolated");
    let running = machine(&scratch, &["taskset", "-c", "0"], &["--cpu", "1"]);
    let tasks = fs::read_dir(format!("/proc/{}/task", running.pid())).unwrap();
    let mut seen = 0;
    for task in tasks {
        let task = task.unwrap().path();
        let name = fs::read_to_string(task.join("comm")).unwrap();
        let status = fs::read_to_string(task.join("status")).unwrap();
        let on = status.lines().find_map(|l| l.strip_prefix("Cpus_allowed_list:")).unwrap();
        let own = name.trim() == "hal-thread";
        seen += usize::from(own);
        // The thread that looks for stuck threads moves to this processor when it suspects one.
        if name.trim() != "hal-stuck" {
            assert_eq!(on.trim(), if own { "1" } else { "0" }, "{name}");
        }
    }
    assert_eq!(seen, 1);
    assert!(status(&scratch).contains(" processor 1"), "{}", status(&scratch));
    end(&scratch, running);
}
