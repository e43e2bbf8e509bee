//! Random programs of every kind on every robot, at random overrides, judged by the watchman.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "tests")]

use crate::judge;

use hal_corpus::{NAMES, Program, named, shrink};
use hal_trajectory::{Limits, Machine, Trivial};
use judge::{Case, Conduct, Outcome, PLAIN, Robot, case, run};
use std::{
    collections::BTreeMap,
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
};

/// Runs the program of a seed. A failing one is shrunk and printed.
fn judged(seed: u64, count: usize) -> (Outcome, Robot) {
    let c = case(seed, count);
    let out = run(&c.program, &c.machine, &c.robot, &c.conduct);
    let fails = |o: &Outcome| o.violations > 0 || o.rejected > 0;
    if fails(&out) {
        println!("{}", described(&c, &out, fails).0);
    }
    (out, c.robot)
}

/// Describes a run that fails, with its seed and the smallest program that still fails; returns that too.
fn described(c: &Case, out: &Outcome, fails: impl Fn(&Outcome) -> bool) -> (String, Program) {
    let small = shrink(&c.program, |p| fails(&run(p, &c.machine, &c.robot, &c.conduct)));
    let text = format!(
        "seed {} {} {:?}: {} violations in {} cycles, {} rejections (last: {}), worst {:?}\n{}\n{:?}\n{:?}\n\
         shrunk to {:#?}",
        c.program.seed,
        c.program.name,
        c.robot,
        out.violations,
        out.cycles,
        out.rejected,
        out.rejection.map_or_else(|| "none".to_owned(), |r| r.to_string()),
        out.worst,
        out.place,
        c.conduct,
        c.machine,
        small.steps
    );
    (text, small)
}

/// Findings about many programs.
#[derive(Debug, Default)]
struct Sum {
    programs: usize,
    /// Moves that the motion has reached, and splines among them.
    segments: usize,
    splines: usize,
    cycles: u64,
    /// Programs with a violation.
    bad: usize,
    rejected: u64,
    refused: BTreeMap<String, usize>,
    unfinished: usize,
    worst: [f64; 4],
    events: u32,
    memory: usize,
    /// Segments on each kind of machine.
    robots: BTreeMap<String, usize>,
}

impl Sum {
    fn add(&mut self, out: &Outcome, robot: Robot) {
        self.programs += 1;
        self.segments += out.reached;
        self.splines += out.splines;
        self.cycles += out.cycles;
        self.bad += usize::from(out.violations > 0);
        self.rejected += out.rejected;
        if let Some(why) = &out.refusal {
            let why = why.to_string();
            let (_, reason) = why.split_once(": ").unwrap_or_default();
            *self.refused.entry(reason.to_owned()).or_default() += 1;
        }
        self.unfinished += out.unfinished;
        self.events = self.events.max(out.events);
        self.memory = self.memory.max(out.memory);
        for (w, r) in self.worst.iter_mut().zip(out.worst) {
            *w = w.max(r);
        }
        *self.robots.entry(format!("{robot:?}")).or_default() += out.reached;
    }
}

/// Runs many seeds in two threads, and prints the sum.
fn many(seeds: core::ops::Range<u64>, count: usize) -> Sum {
    println!("seeds {seeds:?}");
    let next = AtomicU64::new(seeds.start);
    let sum = Mutex::new(Sum::default());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Relaxed);
                    if seed >= seeds.end {
                        break;
                    }
                    let (out, robot) = judged(seed, count);
                    let mut sum = sum.lock().unwrap();
                    sum.add(&out, robot);
                    if sum.programs % 1000 == 0 {
                        println!(
                            "{} programs, {} segments, {} cycles, {} bad",
                            sum.programs, sum.segments, sum.cycles, sum.bad
                        );
                    }
                }
            });
        }
    });
    let sum = sum.into_inner().unwrap();
    let [v, a, j, path] = sum.worst;
    println!(
        "{} segments, {} of them splines, in {} programs, {} cycles: worst v {v:.9} a {a:.9} j {j:.9} path {path:.6}; {} bad programs; \
         {} rejected cells; programs that ended at a refused move: {:?}; {} after their time; {} events, track {} bytes; \
         segments by machine: {:?}",
        sum.segments,
        sum.splines,
        sum.programs,
        sum.cycles,
        sum.bad,
        sum.rejected,
        sum.refused,
        sum.unfinished,
        sum.events,
        sum.memory,
        sum.robots
    );
    assert_eq!((sum.bad, sum.rejected), (0, 0));
    assert!(sum.events < 96, "a period was cut short");
    // About one in 25; none would be left if splines were refused.
    assert!(50 * sum.splines > sum.segments, "{} splines", sum.splines);
    sum
}

#[test]
fn random_programs_keep_every_limit() {
    let sum = many(0..231, 40);
    assert!(sum.refused.is_empty(), "{:?}", sum.refused);
}

/// A program that fails, here by a speed that it is not to reach, is shrunk to a move or two and printed with its seed.
#[test]
fn a_failure_is_shrunk_and_has_its_seed() {
    let c = case(70, 40);
    let out = run(&c.program, &c.machine, &c.robot, &c.conduct);
    let most = 0.8 * out.worst[0];
    let fails = |o: &Outcome| o.worst[0] > most;
    let (text, small) = described(&c, &out, fails);
    assert!(c.program.steps.len() >= 40 && small.steps.len() <= 3, "{text}");
    assert!(fails(&run(&small, &c.machine, &c.robot, &c.conduct)), "{text}");
    assert!(text.starts_with("seed 70 ") && text.contains("shrunk to ["), "{text}");
}

/// Programs by name, from exact paths to wide blends, with and without a limit of jerk.
#[test]
fn programs_by_name_keep_every_limit() {
    for name in NAMES {
        for (k, tolerance) in [0.0, 0.01, 0.1, 2.0].into_iter().enumerate() {
            let jerk = if k % 2 == 0 { 1e5 } else { f64::INFINITY };
            let machine = Machine::uniform(Limits { velocity: 200.0, acceleration: 1750.0, jerk });
            let program = named(name, tolerance, 150.0).unwrap();
            let conduct = Conduct { seed: 1, change: if k < 2 { 0.0 } else { 0.003 }, ..PLAIN };
            let out = run(&program, &machine, &Trivial, &conduct);
            println!(
                "{name} P {tolerance}: {} cycles, {} events in one, worst {:.9?}",
                out.cycles, out.events, out.worst
            );
            assert_eq!(
                (out.violations, out.rejected, out.refused),
                (0, 0, 0),
                "{name} {}",
                out.place
            );
            // Eight borders of cells, and a few changes of acceleration.
            assert!(out.events <= 16, "{name}: {} events in a period", out.events);
        }
    }
}

/// Cases that a million random segments found: a rest a rounding away from a stop, crawls whose output had drifted away
/// from the input, a cell without joint bounds that allowed no acceleration, and an arc in nine axes whose distance was judged
/// at the nearest point in XYZ alone.
#[test]
fn cases_of_the_past_keep_every_limit() {
    for seed in [2853, 3610, 9007, 12_170, 12_337, 12_739, 14_275, 16_049] {
        let (out, _) = judged(seed, 60);
        assert_eq!((out.violations, out.rejected), (0, 0), "seed {seed}");
    }
}

#[test]
#[ignore = "a million segments take minutes; every run has `random_programs_keep_every_limit`: cargo test -p hal-trajectory --release --test it limits -- --ignored --nocapture"]
fn a_million_random_segments_keep_every_limit() {
    let sum = many(1000..26_000, 60);
    assert!(sum.segments >= 1_000_000, "{} segments", sum.segments);
    assert!(sum.cycles <= 2_000_000_000, "{} cycles", sum.cycles);
}
