//! A thousand loads and unloads: nothing grows. Alone in its process, because it measures the memory of the process.
#![expect(clippy::unwrap_used, unsafe_code, reason = "a test that asks the C library")]

use hal_engine::ClockKind;
use hal_protocol::Usage;
use hal_tests::machine::{Machine, cycles, status};
use std::{collections::BTreeSet, fs, process::Command};

/// Sizes that could grow.
#[derive(Debug, PartialEq, Eq)]
struct Size {
    arena: u64,
    counts: [Usage; 6],
    files: usize,
    libraries: BTreeSet<String>,
    threads: usize,
}

fn entries(folder: &str) -> usize {
    fs::read_dir(folder).unwrap().count()
}

fn size(m: &mut Machine) -> Size {
    let s = status(m);
    let maps = fs::read_to_string("/proc/self/maps").unwrap();
    let file = |l: &str| l.split_whitespace().nth(5).map(str::to_owned);
    Size {
        arena: s.memory.0,
        counts: [s.components, s.pins, s.params, s.signals, s.functs, s.threads],
        files: entries("/proc/self/fd"),
        libraries: maps.lines().filter_map(file).filter(|f| f.ends_with(".so")).collect(),
        threads: entries("/proc/self/task"),
    }
}

/// Returns the number of bytes that the process has allocated and not freed.
fn allocated() -> usize {
    // SAFETY: only reads the allocator's statistics.
    unsafe { libc::mallinfo2() }.uordblks
}

/// Creates, links, runs and unloads one of everything.
fn round(m: &mut Machine, clock: ClockKind) {
    m.script(
        "loadrt threads name1=fast period1=500000 name2=slow period2=1000000
         loadrt boom count=3
         loadrt person personality=8
         loadrt talker
         loadrt listener
         loadrt tap
         loadrt feed
         loadrt lazy
         loadrt chatty
         loadrt doomed
         loadrt and2 count=4
         net bits and2.0.out and2.1.in0 and2.2.in0 person.0.in-00
         net line talker.0.line listener.0.line
         sets line 64
         newsig alone float
         alias pin and2.3.out the-gate
         addf and2.0 fast
         addf boom.0 fast
         addf talker.0 slow
         addf listener.0 slow
         addf tap.0 slow
         addf feed.0 fast
         addf chatty slow
         addf doomed.copy doomed-thread
         initf boom.1 slow
         setp chatty.times 2
         start",
    );
    match clock {
        ClockKind::Virtual => m.script("run 5000000"),
        ClockKind::Real => cycles(m, "fast", 1),
    }
    m.script(
        "delf and2.0 fast
         unloadrt boom
         unlinkp and2.1.in0
         stop
         delsig alone
         unloadrt all
         delsig bits
         delsig line",
    );
    // Refused and reverted.
    for by in ["error", "panic", "open", "stream"] {
        let load = hal_tests::machine::says(m, &format!("loadrt doomed by={by}"));
        assert_ne!(load, "ok");
    }
    drop(m.engine.take_messages());
}

fn nothing_grows(clock: ClockKind, warm: u32, rounds: u32) {
    let mut m = Machine::new(clock);
    (0..warm).for_each(|_| round(&mut m, clock));
    let (before, bytes) = (size(&mut m), allocated());
    (warm..rounds).for_each(|_| round(&mut m, clock));
    let now = allocated();
    assert_eq!(size(&mut m), before);
    match clock {
        ClockKind::Virtual => assert_eq!(now, bytes, "not a byte in {} rounds", rounds - warm),
        // Depends on how far the last thread has come with its exit.
        ClockKind::Real => assert!(now < bytes + 4096, "{bytes} bytes became {now}"),
    }
}

#[test]
fn a_thousand_loads_and_unloads() {
    // The statistics include memory that the allocator keeps for each thread's next call: it must keep none.
    let (name, keep_nothing) =
        ("GLIBC_TUNABLES", "glibc.malloc.tcache_count=0:glibc.malloc.mxfast=0");
    if std::env::var(name).is_ok_and(|v| v == keep_nothing) {
        nothing_grows(ClockKind::Virtual, 100, 1000);
        nothing_grows(ClockKind::Real, 20, 120);
    } else {
        let mut again = Command::new(std::env::current_exe().unwrap());
        again.args([
            "--exact",
            &hal_tests::programs::own_test(module_path!(), "a_thousand_loads_and_unloads"),
        ]);
        hal_tests::programs::passes(again.env(name, keep_nothing));
    }
}
