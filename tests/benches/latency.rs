//! Wakeup latency of a thread, compared with `cyclictest` on the same processor at the same priority.
//!
//! Ours and `cyclictest` run in turn (A B A B …), so that other load of the computer affects both. Each pair gives a
//! ratio at the median, at 99 % and at 99.9 %; the output has the medians over all pairs and the smallest and largest
//! ratio. Run it as root, or with the rights listed in the README's section "Real time":
//!
//! ```text
//! cargo bench -p hal-tests --bench latency
//! ```
//!
//! `LATENCY_CYCLES` (10000) and `LATENCY_PAIRS` (7) set the duration: cycles of 1 ms in each run, and pairs of runs.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints")]

use hal_component::{Builder, Clock, Component, Error, Period, Touch, Update};
use hal_engine::{ClockKind, Engine, Options, RealtimeOptions};
use hal_protocol::Place;
use hal_tests::{
    machine::{script, status},
    tools::report,
};
use std::{
    process::Command,
    sync::{
        OnceLock,
        atomic::{AtomicI64, AtomicUsize, Ordering::Relaxed},
    },
};

/// Period of both, in nanoseconds.
const PERIOD_NS: i64 = 1_000_000;
/// Number of wakeups at the beginning of each run that are ignored.
const WARM: usize = 100;
/// Percentiles that are compared, in thousandths.
const PER_MILLE: [(&str, usize); 3] = [("p50", 500), ("p99", 990), ("p99.9", 999)];

/// Start times of cycles, in machine time.
static BEGAN: OnceLock<Box<[AtomicI64]>> = OnceLock::new();
static COUNT: AtomicUsize = AtomicUsize::new(0);

/// Component that records the start of each cycle.
#[derive(Debug)]
struct Began;

#[derive(Debug, Touch)]
struct Note {
    clock: Clock,
}

impl Component for Began {
    const NAME: &'static str = "began";
    const DOC: &'static str = "Notes when each cycle begins.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let note = Note { clock: b.clock() };
        b.function("", "Notes the time.", note)
    }
}

impl Update for Note {
    fn update(&mut self, _: Period) {
        let now = self.clock.now_ns();
        let n = COUNT.load(Relaxed);
        if let Some(place) = BEGAN.get().and_then(|all| all.get(n)) {
            place.store(now, Relaxed);
            COUNT.store(n + 1, Relaxed);
        }
    }
}

hal_component::export!(Began);

/// Returns our sorted wakeup latencies in nanoseconds; `None` without the right to `SCHED_FIFO`.
fn ours(cycles: usize, cpu: usize) -> Option<Vec<i64>> {
    let places = BEGAN.get_or_init(|| (0..cycles + WARM).map(|_| AtomicI64::new(0)).collect());
    COUNT.store(0, Relaxed);
    let options = Options {
        hold: false,
        realtime: RealtimeOptions { cpu: Some(cpu), ..RealtimeOptions::default() },
        ..Options::simulated(Place::at("/nonexistent", "latency").unwrap(), ClockKind::Real)
    };
    let mut e = Engine::without_socket(options).unwrap();
    e.add_static(&threads::HAL_LIBRARY);
    e.add_static(&HAL_LIBRARY);
    let lines =
        format!("loadrt threads name1=t period1={PERIOD_NS}\nloadrt began\naddf began.0 t\nstart");
    script(&mut e, &lines);
    let scheduling = status(&mut e).scheduling;
    if !scheduling.starts_with("SCHED_FIFO") {
        println!("{scheduling}");
        report("nothing is measured without SCHED_FIFO");
        return None;
    }
    while COUNT.load(Relaxed) < places.len() {
        e.serve(Some(100_000_000));
    }
    e.close();
    let began: Vec<i64> = places.iter().map(|p| p.load(Relaxed)).collect();
    Some(lateness(&began))
}

/// Converts start times of cycles to latencies: after a cycle that began later than the next one's due time, the
/// following cycle is the first that was not yet due, or just due.
fn lateness(began: &[i64]) -> Vec<i64> {
    let first = began.first().copied().unwrap_or_default();
    let mut due = first.div_euclid(PERIOD_NS) * PERIOD_NS;
    let mut late = Vec::with_capacity(began.len());
    for now in began {
        late.push(now - due);
        due += PERIOD_NS;
        if *now > due {
            due += (now - due).div_euclid(PERIOD_NS) * PERIOD_NS;
        }
    }
    let mut late = late.split_off(WARM);
    late.sort_unstable();
    late
}

/// Returns the same for `cyclictest`; `None` if it is not installed.
fn theirs(cycles: usize, cpu: usize) -> Option<Vec<i64>> {
    let us = PERIOD_NS / 1000;
    let output = Command::new("cyclictest")
        .args(["--mlockall", "--priority=90", "--threads=1", "--verbose", "--nsecs"])
        .args([format!("--affinity={cpu}"), format!("--interval={us}")])
        .arg(format!("--loops={}", cycles + WARM))
        .output()
        .ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let value = |line: &str| -> Option<i64> {
        let mut parts = line.split(':').map(str::trim);
        let (_thread, n, late) = (parts.next()?, parts.next()?, parts.next()?);
        let n: usize = n.parse().ok()?;
        late.parse().ok().filter(|_| n >= WARM)
    };
    let mut late: Vec<i64> = text.lines().filter_map(value).collect();
    late.sort_unstable();
    (late.len() > cycles / 2).then_some(late)
}

/// Returns the percentile, given in thousandths, in microseconds.
fn at(sorted: &[i64], per_mille: usize) -> f64 {
    let i = (sorted.len() * per_mille).div_ceil(1000).saturating_sub(1);
    sorted.get(i).map_or(f64::NAN, |ns| *ns as f64 / 1000.0)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn number(variable: &str, usual: usize) -> usize {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

fn main() {
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    let (cycles, pairs) = (number("LATENCY_CYCLES", 10_000), number("LATENCY_PAIRS", 7));
    let cpus = std::thread::available_parallelism().map_or(1, usize::from);
    let cpu = cpus - 1;
    let model = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let is_virtual = model.lines().any(|l| l.starts_with("flags") && l.contains(" hypervisor"));
    println!("wake-ups each millisecond on processor {cpu}, SCHED_FIFO 90: {pairs} x {cycles}");
    if is_virtual {
        println!("a virtual machine: only the ratios say something, its host decides the rest");
    }
    let mut all: Vec<(Vec<i64>, Option<Vec<i64>>)> = Vec::new();
    for _ in 0..pairs {
        let Some(own) = ours(cycles, cpu) else { return };
        all.push((own, theirs(cycles, cpu)));
    }
    if all.iter().all(|(_, other)| other.is_none()) {
        println!("cyclictest is not installed (apt-get install rt-tests): ours alone");
    }
    println!("{:<8} {:>12} {:>12} {:>8}   of each pair", "", "Ferrule", "cyclictest", "ratio");
    for (name, per_mille) in PER_MILLE {
        let mut own: Vec<f64> = all.iter().map(|(own, _)| at(own, per_mille)).collect();
        let mut other: Vec<f64> =
            all.iter().filter_map(|(_, t)| Some(at(t.as_ref()?, per_mille))).collect();
        let ratio = |(own, t): &(Vec<i64>, Option<Vec<i64>>)| {
            Some(at(own, per_mille) / at(t.as_ref()?, per_mille))
        };
        let mut ratios: Vec<f64> = all.iter().filter_map(ratio).collect();
        let middle = median(&mut ratios);
        let spread = match (ratios.first(), ratios.last()) {
            (Some(least), Some(most)) => format!("{least:.2} to {most:.2}"),
            _ => "-".to_owned(),
        };
        println!(
            "{name:<8} {:>9.1} us {:>9.1} us {middle:>8.2}   {spread}",
            median(&mut own),
            median(&mut other)
        );
    }
    let most = |late: &[i64]| late.last().map_or(f64::NAN, |ns| *ns as f64 / 1000.0);
    let own = all.iter().map(|(own, _)| most(own)).fold(0.0, f64::max);
    let other = all.iter().filter_map(|(_, t)| t.as_deref().map(most)).fold(0.0, f64::max);
    println!("{:<8} {own:>9.1} us {other:>9.1} us", "latest");
}
