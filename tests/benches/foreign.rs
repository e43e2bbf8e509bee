//! Cost of a function in C, compared with the same one in Rust, and with the same file in LinuxCNC's halrun.
//!
//! A chain of 800 gates, each fed by the previous one: first in this process on the virtual clock, without time
//! measurements of functions; then on the real clock, as the thread's own time pins show, where LinuxCNC is installed
//! with the very same `and2.so` in both programs, in turn. Run it with
//! `cargo build --release && cargo bench -p hal-tests --bench foreign`.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark measures the wall clock and prints"
)]

mod beside;

use beside::{CHAIN, account, chain_script, peer, programs, while_running};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{Link, Place, Request};
use hal_tests::foreign::installed;
use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

/// Number of measurements of each, in turn.
const ROUNDS: usize = 5;

const GATE: &str = "component gate;\npin in bit in0;\npin in bit in1;\npin out bit out;\n\
                    function _ nofp;\nlicense \"MIT\";\n;;\nout = in0 && in1;\n";

/// Compiles the gate in C with halcompile.
fn gate(folder: &Path) {
    std::fs::write(folder.join("gate.comp"), GATE).unwrap();
    let mut halcompile = Command::new(programs().join("halcompile"));
    let made = halcompile.current_dir(folder).args(["--compile", "gate.comp"]).status().unwrap();
    assert!(made.success(), "halcompile");
}

/// Returns the nanoseconds per function on the virtual clock: the minimum over several seconds of machine time.
fn in_process(lines: &str, path: Vec<PathBuf>) -> f64 {
    let mut engine = Engine::without_socket(Options {
        path,
        ..Options::simulated(Place::at("/nonexistent", "bench").unwrap(), ClockKind::Virtual)
    })
    .unwrap();
    for line in lines.lines() {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let (verb, rest) = words.split_first().unwrap();
        let rest = |i: usize| rest.get(i..).unwrap_or_default().to_vec();
        let at = |i: usize| rest(i).first().cloned().unwrap_or_default();
        let request = match verb.as_str() {
            "loadrt" if at(0) == "--c" => {
                Request::LoadForeign { module: at(1), args: rest(2), prefix: String::new() }
            }
            "loadrt" => Request::Load { module: at(0), args: rest(1) },
            "addf" => Request::AddFunct { funct: at(0), thread: at(1), position: -1, init: false },
            "net" => Request::Net { signal: at(0), pins: rest(1) },
            _ => Request::Start,
        };
        engine.call(request).unwrap();
    }
    engine.call(Request::Timing { thread: None, on: false }).unwrap();
    let second = |engine: &mut Engine| {
        let begin = Instant::now();
        engine.call(Request::Run { ns: 1_000_000_000 }).unwrap();
        begin.elapsed().as_secs_f64() * 1e9 / (1000.0 * CHAIN as f64)
    };
    (0..10).map(|_| second(&mut engine)).fold(f64::INFINITY, f64::min)
}

/// Returns the median.
fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

fn row(what: &str, each: &[f64]) {
    let least = each.iter().copied().fold(f64::INFINITY, f64::min);
    let most = each.iter().copied().fold(0.0, f64::max);
    println!("{what:<60} {:>7.2} ns   {least:.2} to {most:.2}", median(each.to_vec()));
}

fn ratio(what: &str, a: &[f64], b: &[f64]) {
    println!("{what:<60} {:>7.2}", median(a.to_vec()) / median(b.to_vec()));
}

fn main() {
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    let bin = programs();
    let folder = std::env::temp_dir().join(format!("hal-bench-c-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let open = <std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o777);
    std::fs::set_permissions(&folder, open).unwrap();
    gate(&folder);
    println!(
        "nanoseconds per function in a chain of {CHAIN}, median of {ROUNDS} rounds, and the range"
    );

    let path = vec![bin.clone(), folder.clone()];
    let (mut rust, mut c) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        rust.push(in_process(&chain_script("loadrt and2", "and2"), path.clone()));
        c.push(in_process(&chain_script("loadrt --c gate", "gate"), path.clone()));
    }
    println!("\nvirtual clock, without accounts");
    row("Rust (and2)", &rust);
    row("C, from .comp by halcompile", &c);
    ratio("C over Rust", &c, &rust);

    let peers = installed();
    let module = if peers.is_some() { "and2" } else { "gate" };
    std::fs::write(folder.join("rust.hal"), chain_script("loadrt and2", "and2")).unwrap();
    let loads = format!("loadrt --c {module}");
    std::fs::write(folder.join("c.hal"), chain_script(&loads, module)).unwrap();
    let ours = |program: &str| {
        let mut command = Command::new(bin.join(program));
        let mut folders = vec![folder.clone()];
        folders.extend(peers.clone());
        command.env("HAL_RUNTIME_DIR", &folder).env_remove("HAL_INSTANCE");
        command.env("HAL_RTMOD_DIR", std::env::join_paths(folders).unwrap());
        command
    };
    let measured = |script: &str| {
        let mut halrun = ours("halrun");
        halrun.current_dir(&folder).arg(script);
        let end = || {
            let mut halcmd = ours("halcmd");
            halcmd.arg("shutdown");
            halcmd
        };
        while_running(halrun, &end, || account(&|| ours("halcmd"))).flatten()
    };
    let theirs = || {
        peers.as_ref()?;
        let mut halrun = peer("halrun", &folder);
        halrun.args(["-I", "rust.hal"]);
        let end = || {
            let mut halrun = peer("halrun", &folder);
            halrun.arg("-U");
            halrun
        };
        while_running(halrun, &end, || account(&|| peer("halcmd", &folder))).flatten()
    };
    let (mut rust, mut c, mut peer) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        rust.extend(measured("rust.hal"));
        c.extend(measured("c.hal"));
        peer.extend(theirs());
    }
    println!("\nreal clock, as the thread's account has it");
    row("Ferrule, Rust (and2)", &rust);
    row(&format!("Ferrule, C ({module}.so)"), &c);
    ratio("C over Rust", &c, &rust);
    if peer.is_empty() {
        println!("LinuxCNC is not installed: not compared");
    } else {
        row("LinuxCNC's halrun, C (and2.so)", &peer);
        ratio("Ferrule over LinuxCNC, the same file", &c, &peer);
    }
    drop(std::fs::remove_dir_all(&folder));
}
