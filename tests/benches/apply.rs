//! Effect of changes on threads that run on the real clock: runs with and without changes, in turn.
//!
//! A fast thread of 250 µs and a slow one of 1 ms run 40 functions each, for some seconds. In every other run, a change
//! of twelve lines is applied every two milliseconds: values, links, and functions in both threads.
//! `cargo bench -p hal-tests --bench apply` prints the median of ten pairs, with the spread, of the fast thread's mean
//! run time, its missed cycles, and its wakeup latency.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark measures the wall clock and prints"
)]

use hal_engine::{ClockKind, Engine};
use hal_protocol::{Edit, Link, Reply, Request, ThreadInfo, Value};
use hal_tests::machine::plain;
use std::time::{Duration, Instant};

const PAIRS: usize = 10;
const SECONDS: u64 = 3;

fn request(line: &str) -> Request {
    let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
    let at = |i: usize| words.get(i).cloned().unwrap_or_default();
    match at(0).as_str() {
        "loadrt" => {
            Request::Load { module: at(1), args: words.get(2..).unwrap_or_default().to_vec() }
        }
        "net" => Request::Net { signal: at(1), pins: words.get(2..).unwrap().to_vec() },
        "unlinkp" => Request::Unlink { pin: at(1) },
        "setp" => Request::Set { name: at(1), value: at(2) },
        "addf" => Request::AddFunct { funct: at(1), thread: at(2), position: 1, init: false },
        "delf" => Request::RemoveFunct { funct: at(1), thread: Some(at(2)) },
        "start" => Request::Start,
        _ => panic!("{line}"),
    }
}

fn apply(e: &mut Engine, lines: &str) {
    let lines = lines.lines().map(str::trim).filter(|l| !l.is_empty());
    let edits = lines.map(|line| Edit { file: 0, line: 0, request: request(line) }).collect();
    match e.call(Request::Apply { files: vec!["bench".to_owned()], edits, dry: false }) {
        Ok(Reply::Applied { .. }) => {}
        other => panic!("{other:?}"),
    }
}

fn machine() -> Engine {
    let mut e = plain(ClockKind::Real);
    let mut lines = String::from(
        "loadrt threads name1=fast period1=250000 name2=slow period2=1000000\n\
         loadrt and2 count=80\nloadrt or2 count=4\n",
    );
    for i in 0..80 {
        lines += &format!("addf and2.{i} {}\n", if i < 40 { "fast" } else { "slow" });
    }
    lines +=
        "addf or2.0 fast\naddf or2.2 slow\nnet a and2.0.out and2.1.in0\nnet b and2.2.out\nstart";
    apply(&mut e, &lines);
    e
}

/// Returns one change: values, a pin that moves to another signal, and a function replaced in each thread.
fn change(n: usize) -> String {
    let (new, old, to) = if n.is_multiple_of(2) { (1, 0, "b") } else { (0, 1, "a") };
    let (new2, old2) = (new + 2, old + 2);
    format!(
        "setp and2.3.in0 {}\nsetp and2.3.in1 1\nsetp and2.43.in0 1\nsetp and2.43.in1 {}\n\
         unlinkp and2.1.in0\nnet {to} and2.1.in0\nsetp or2.{new}.in0 1\n\
         delf or2.{old} fast\naddf or2.{new} fast\ndelf or2.{old2} slow\naddf or2.{new2} slow\n\
         setp or2.{old}.in0 0",
        n % 2,
        n % 2
    )
}

fn fast(e: &mut Engine) -> ThreadInfo {
    let kind = hal_protocol::Kind::Threads;
    match e.call(Request::List { kind, patterns: vec!["fast".to_owned()], ty: None }) {
        Ok(Reply::Threads(list)) => list.into_iter().next().unwrap(),
        other => panic!("{other:?}"),
    }
}

/// Result of a run: mean sampled time in ns, share of due cycles that were missed, latest wakeup in µs, number of
/// changes.
struct Run {
    time: f64,
    missed: f64,
    late: f64,
    changes: usize,
}

fn run(with_changes: bool) -> Run {
    let mut e = machine();
    e.call(Request::Idle { ms: 200, flow: false }).unwrap();
    let before = fast(&mut e);
    let begin = Instant::now();
    let (mut changes, mut sum, mut looks) = (0, 0.0, 0.0);
    while begin.elapsed() < Duration::from_secs(SECONDS) {
        if with_changes {
            changes += 1;
            apply(&mut e, &change(changes - 1));
        }
        e.call(Request::Idle { ms: 2, flow: false }).unwrap();
        if let Ok(Reply::Value(Value::S32(ns))) = e.call(Request::Get { name: "fast.time".into() })
        {
            sum += f64::from(ns);
            looks += 1.0;
        }
    }
    let due = begin.elapsed().as_nanos() as f64 / 250_000.0;
    let after = fast(&mut e);
    e.close();
    let ran = (after.cycles - before.cycles) as f64;
    let late = after.latency_max as f64 / 1000.0;
    Run { time: sum / looks, missed: (due - ran).max(0.0), late, changes }
}

fn median(mut all: Vec<f64>) -> (f64, f64, f64) {
    all.sort_by(f64::total_cmp);
    let at = |i: usize| all.get(i).copied().unwrap_or_default();
    let (half, last) = (all.len() / 2, all.len() - 1);
    let middle = if all.len() % 2 == 1 { at(half) } else { f64::midpoint(at(half - 1), at(half)) };
    (middle, at(0), at(last))
}

fn main() {
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for n in 0..PAIRS {
        // Each kind is first in every other pair.
        if n.is_multiple_of(2) {
            without.push(run(false));
            with.push(run(true));
        } else {
            with.push(run(true));
            without.push(run(false));
        }
    }
    let changes: usize = with.iter().map(|r| r.changes).sum();
    println!(
        "{PAIRS} pairs of {SECONDS} s, {changes} changes of twelve lines in all; median (least to most)"
    );
    println!("{:<36} {:>32} {:>32}", "fast thread of 250 µs", "without changes", "with changes");
    let row = |what: &str, of: &dyn Fn(&Run) -> f64| {
        let column = |runs: &[Run]| {
            let (middle, least, most) = median(runs.iter().map(of).collect());
            format!("{middle:.1} ({least:.1} to {most:.1})")
        };
        println!("{what:<36} {:>32} {:>32}", column(&without), column(&with));
        let pairs = with.iter().zip(&without).map(|(a, b)| of(a) - of(b)).collect();
        let (middle, least, most) = median(pairs);
        println!(
            "{:<36} {:>65}",
            "  difference within a pair",
            format!("{middle:.1} ({least:.1} to {most:.1})")
        );
    };
    row("run time of a cycle, ns", &|r| r.time);
    row("cycles missed of 12,000", &|r| r.missed);
    row("latest wake-up, µs", &|r| r.late);
}
