//! A thousand loads and unloads: nothing grows. Alone in its process, because it measures the memory of the process.
#![expect(clippy::unwrap_used, unsafe_code, reason = "a test that asks the C library")]

use hal_engine::ClockKind;
use hal_protocol::Usage;
use hal_tests::{
    machine::{Machine, cycles, says, status},
    programs,
    scratch::Scratch,
    tools,
};
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

/// The C library's allocator, with a count of the blocks that are in use. Bytes would not do: a block is up to 16 bytes
/// larger where it fills a hole, and threads that allocate at the same time make it keep books of its own.
const COUNTING: &str = "\
#include <errno.h>
#include <stddef.h>
void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t), *__libc_memalign(size_t, size_t);
void __libc_free(void *);
static long blocks;
long blocks_in_use(void) { return __atomic_load_n(&blocks, __ATOMIC_SEQ_CST); }
static void *made(void *p) { if (p) __atomic_add_fetch(&blocks, 1, __ATOMIC_SEQ_CST); return p; }
void *malloc(size_t n) { return made(__libc_malloc(n)); }
void *calloc(size_t n, size_t each) { return made(__libc_calloc(n, each)); }
void *memalign(size_t to, size_t n) { return made(__libc_memalign(to, n)); }
void *aligned_alloc(size_t to, size_t n) { return made(__libc_memalign(to, n)); }
int posix_memalign(void **p, size_t to, size_t n) { *p = made(__libc_memalign(to, n)); return *p ? 0 : ENOMEM; }
void free(void *p) { if (p) __atomic_sub_fetch(&blocks, 1, __ATOMIC_SEQ_CST); __libc_free(p); }
void *realloc(void *p, size_t n) {
    if (!p) return malloc(n);
    if (!n) { free(p); return NULL; }
    return __libc_realloc(p, n);
}
";

/// Returns the number of blocks of memory that the process has allocated and not freed; `None` without [`COUNTING`].
fn blocks() -> Option<i64> {
    type Count = unsafe extern "C" fn() -> libc::c_long;
    // SAFETY: looks for a name.
    let found = unsafe { libc::dlsym(libc::RTLD_DEFAULT, c"blocks_in_use".as_ptr()) };
    // SAFETY: the function of `COUNTING`, or null.
    let count = unsafe { std::mem::transmute::<*mut libc::c_void, Option<Count>>(found) }?;
    // SAFETY: only reads.
    Some(unsafe { count() })
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
        let load = says(m, &format!("loadrt doomed by={by}"));
        assert_ne!(load, "ok");
    }
    drop(m.engine.take_messages());
}

fn nothing_grows(clock: ClockKind, warm: u32, rounds: u32) {
    let mut m = Machine::new(clock);
    (0..warm).for_each(|_| round(&mut m, clock));
    let (before, count) = (size(&mut m), blocks());
    (warm..rounds).for_each(|_| round(&mut m, clock));
    let after = blocks();
    assert_eq!(size(&mut m), before);
    // On the real clock the engine may remember that the last thread was late.
    let most = count.map(|n| n + i64::from(clock == ClockKind::Real) * 4);
    assert!(after <= most, "{count:?} blocks became {after:?} in {} rounds", rounds - warm);
}

#[test]
fn a_thousand_loads_and_unloads() {
    if blocks().is_some() {
        nothing_grows(ClockKind::Virtual, 100, 1000);
        nothing_grows(ClockKind::Real, 20, 120);
        return;
    }
    let Some(cc) = tools::compiler() else { return };
    let scratch = Scratch::new("growth");
    scratch.write("counting.c", COUNTING);
    let mut made = Command::new(cc);
    made.args(["-O2", "-fno-builtin", "-shared", "-fPIC", "-o", "counting.so", "counting.c"]);
    assert!(made.current_dir(scratch.path()).status().unwrap().success());
    let mut again = Command::new(std::env::current_exe().unwrap());
    again.args(["--exact", &programs::own_test(module_path!(), "a_thousand_loads_and_unloads")]);
    again.env("LD_PRELOAD", scratch.path().join("counting.so"));
    // The C library keeps the stacks of threads that have ended for the next ones.
    programs::passes(again.env("GLIBC_TUNABLES", "glibc.pthread.stack_cache_size=0"));
}
