//! Cost of the engine: functions, virtual time, loading, pins, and whole programs.
//!
//! The first part measures inside this process; the second measures whole programs and, where LinuxCNC is installed,
//! compares its programs with ours in the same run. Run it with `cargo build --release && cargo bench -p hal-tests`.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark measures the wall clock and prints"
)]

mod beside;

use beside::{CHAIN, account, chain_script, peer, programs, while_running};
use divan::{Bencher, counter::ItemsCount};
use hal_engine::{ClockKind, Engine};
use hal_protocol::{Link, Reply, Request};
use hal_tests::machine::plain;
use std::{
    fmt::Write,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

fn load(e: &mut Engine, module: &str, args: &[&str]) {
    let args = args.iter().map(|a| (*a).to_owned()).collect();
    e.call(Request::Load { module: module.to_owned(), args }).unwrap();
}

/// 800 gates in one thread of 1 ms, each fed by the previous one.
fn chain(timed: bool) -> Engine {
    let mut e = plain(ClockKind::Virtual);
    load(&mut e, "threads", &["name1=t", "period1=1000000"]);
    load(&mut e, "and2", &[&format!("count={CHAIN}")]);
    for i in 0..CHAIN {
        let (funct, thread) = (format!("and2.{i}"), "t".to_owned());
        e.call(Request::AddFunct { funct, thread, position: -1, init: false }).unwrap();
    }
    for i in 1..CHAIN {
        let pins =
            vec![format!("and2.{}.out", i - 1), format!("and2.{i}.in0"), format!("and2.{i}.in1")];
        e.call(Request::Net { signal: format!("s{i}"), pins }).unwrap();
    }
    e.call(Request::Start).unwrap();
    e.call(Request::Run { ns: 10_000_000 }).unwrap();
    e.call(Request::Timing { thread: None, on: timed }).unwrap();
    e
}

/// Runs one second of machine time: 1000 cycles of 800 functions.
#[divan::bench(args = [false, true], sample_count = 20, sample_size = 1)]
fn function_in_a_chain_of_800(bencher: Bencher<'_, '_>, timed: bool) {
    let mut e = chain(timed);
    bencher
        .counter(ItemsCount::new(1000 * CHAIN))
        .bench_local(|| e.call(Request::Run { ns: 1_000_000_000 }).unwrap());
}

/// Loads 250,000 gates with their time pins: a million pins exist at once.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn a_million_pins(bencher: Bencher<'_, '_>) {
    bencher.counter(ItemsCount::new(1_000_000_usize)).bench_local(|| {
        let mut e = plain(ClockKind::Virtual);
        load(&mut e, "and2", &["count=250000"]);
        let Reply::Status(s) = e.call(Request::Status).unwrap() else { panic!() };
        assert_eq!(s.pins.active, 1_000_000);
        e
    });
}

/// Numbers of instances: the time per instance must be the same for all.
const INSTANCES: [usize; 3] = [1000, 10_000, 100_000];

/// `loadrt and2 count=N`.
#[divan::bench(args = INSTANCES, sample_count = 5, sample_size = 1)]
fn instance_that_is_loaded(bencher: Bencher<'_, '_>, n: usize) {
    let e = || plain(ClockKind::Virtual);
    bencher.counter(ItemsCount::new(n)).with_inputs(e).bench_local_values(|mut e| {
        load(&mut e, "and2", &[&format!("count={n}")]);
        e
    });
}

/// `loadrt and2 names=…`.
#[divan::bench(args = INSTANCES, sample_count = 5, sample_size = 1)]
fn instance_that_is_loaded_by_name(bencher: Bencher<'_, '_>, n: usize) {
    let names: Vec<String> = (0..n).map(|i| format!("gate-{i}")).collect();
    let names = format!("names={}", names.join(","));
    let e = || plain(ClockKind::Virtual);
    bencher.counter(ItemsCount::new(n)).with_inputs(e).bench_local_values(|mut e| {
        load(&mut e, "and2", &[&names]);
        e
    });
}

fn loaded(n: usize) -> Engine {
    let mut e = plain(ClockKind::Virtual);
    load(&mut e, "threads", &["name1=t", "period1=1000000"]);
    load(&mut e, "and2", &[&format!("count={n}")]);
    e
}

fn add(mut e: Engine, n: usize) -> Engine {
    for i in 0..n {
        let (funct, thread) = (format!("and2.{i}"), "t".to_owned());
        e.call(Request::AddFunct { funct, thread, position: -1, init: false }).unwrap();
    }
    e.call(Request::Start).unwrap();
    e
}

/// Runs a line `addf` for each, and `start`.
#[divan::bench(args = INSTANCES, sample_count = 5, sample_size = 1)]
fn instance_that_is_added_to_a_thread(bencher: Bencher<'_, '_>, n: usize) {
    let e = || loaded(n);
    bencher.counter(ItemsCount::new(n)).with_inputs(e).bench_local_values(|e| add(e, n));
}

/// Runs `unloadrt and2` while the thread runs them all.
#[divan::bench(args = INSTANCES, sample_count = 5, sample_size = 1)]
fn instance_that_is_unloaded(bencher: Bencher<'_, '_>, n: usize) {
    let e = || add(loaded(n), n);
    bencher.counter(ItemsCount::new(n)).with_inputs(e).bench_local_values(|mut e| {
        e.call(Request::Unload { name: "and2".to_owned() }).unwrap();
        e
    });
}

/// Returns the shortest of several runs of a program.
fn least(runs: u32, make: impl Fn() -> Command) -> Option<Duration> {
    let mut best: Option<Duration> = None;
    for _ in 0..runs {
        let mut command = make();
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let begin = Instant::now();
        let ok = command.status().ok()?.success();
        let took = begin.elapsed();
        if !ok {
            return None;
        }
        best = Some(best.map_or(took, |b| b.min(took)));
    }
    best
}

fn row(what: &str, ours: &str, theirs: &str, aim: &str) {
    println!("{what:<52} {ours:>14} {theirs:>14}   {aim}");
}

fn ms(t: Option<Duration>) -> String {
    t.map_or_else(|| "-".to_owned(), |t| format!("{:.2} ms", t.as_secs_f64() * 1e3))
}

fn wholes() {
    let bin = programs();
    let folder = std::env::temp_dir().join(format!("hal-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let open = <std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o777);
    std::fs::set_permissions(&folder, open).unwrap();
    if !bin.join("halrun").is_file() {
        println!("no halrun in {}: run `cargo build --release` first", bin.display());
        return;
    }
    let installed = std::path::Path::new("/usr/lib/linuxcnc/modules/and2.so").is_file();
    let ours = |program: &str| {
        let mut c = Command::new(bin.join(program));
        c.env("HAL_RUNTIME_DIR", &folder).env_remove("HAL_INSTANCE");
        c
    };
    println!();
    row("whole programs", "Ferrule", "LinuxCNC", "aim");

    let script = folder.join("chain.hal");
    std::fs::write(&script, chain_script("loadrt and2", "and2")).unwrap();
    let mut halrun = ours("halrun");
    halrun.arg(&script);
    let end = || {
        let mut c = ours("halcmd");
        c.arg("shutdown");
        c
    };
    let measured = while_running(halrun, &end, || {
        let each = account(&|| ours("halcmd"));
        let get = least(50, || {
            let mut c = ours("halcmd");
            c.args(["getp", "and2.0.out"]);
            c
        });
        (each, get)
    });
    let theirs = installed.then(|| {
        let mut halrun = peer("halrun", &folder);
        halrun.args(["-I", "chain.hal"]);
        let end = || {
            let mut c = peer("halrun", &folder);
            c.arg("-U");
            c
        };
        while_running(halrun, &end, || {
            let each = account(&|| peer("halcmd", &folder));
            // Without the cost of changing the user.
            let get = least(50, || {
                let mut c = peer("halcmd", &folder);
                c.args(["getp", "and2.0.out"]);
                c
            });
            let change = least(50, || peer("true", &folder));
            (each, get.map(|g| g.saturating_sub(change.unwrap_or_default())))
        })
    });
    let theirs = theirs.flatten();
    let ns = |m: &Option<(Option<f64>, Option<Duration>)>| {
        m.and_then(|m| m.0).map_or_else(|| "-".to_owned(), |ns| format!("{ns:.1} ns"))
    };
    let get = |m: &Option<(Option<f64>, Option<Duration>)>| ms(m.and_then(|m| m.1));
    row(
        "function in a chain of 800, with accounts",
        &ns(&measured),
        &ns(&theirs),
        "half of LinuxCNC's",
    );
    row("halcmd getp, a whole process", &get(&measured), &get(&theirs), "beside LinuxCNC's");

    let mut big =
        String::from("loadrt threads name1=t period1=1000000\nloadrt and2 count=100000\n");
    for i in 1..100_000 {
        writeln!(big, "net s{i} and2.{}.out and2.{i}.in0", i - 1).unwrap();
    }
    let file = folder.join("big.hal");
    std::fs::write(&file, big).unwrap();
    let took = least(3, || {
        let mut c = ours("halrun");
        c.args(["--virtual", "-f"]).arg(&file);
        c
    });
    row("script of 100,000 and2 and as many nets", &ms(took), "", "under 5000 ms");

    let printer = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/printer");
    let run = |t: &'static str| {
        let (bin, printer) = (ours("halrun"), printer.clone());
        let name = bin.get_program().to_owned();
        let runtime = folder.clone();
        least(3, move || {
            let mut c = Command::new(&name);
            c.env("HAL_RUNTIME_DIR", &runtime).current_dir(&printer);
            c.args(["--virtual", "--for", t, "printer.ini"]);
            c
        })
    };
    let ratio = run("1ms").zip(run("30s")).map(|(short, long)| {
        let virt = Duration::from_millis(29_999).as_secs_f64();
        virt / long.saturating_sub(short).as_secs_f64()
    });
    let ratio = ratio.map_or_else(|| "-".to_owned(), |r| format!("{r:.0} times"));
    row("the printer in virtual time, against real time", &ratio, "", "300 times or more");
    drop(std::fs::remove_dir_all(&folder));
}

fn main() {
    divan::main();
    if !std::env::args().any(|a| a == "--test" || a == "--list") {
        wholes();
    }
}
