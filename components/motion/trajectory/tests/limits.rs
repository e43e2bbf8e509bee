//! Random programs of every kind on every robot, at random overrides, judged by the watchman.
#![expect(clippy::print_stdout, reason = "tests")]

mod judge;

use hal_corpus::{NAMES, named, shrink};
use hal_trajectory::{Limits, Machine, Trivial};
use judge::{Conduct, Outcome, PLAIN, case, run};

fn judged(seed: u64, count: usize) -> (Outcome, usize) {
    let c = case(seed, count);
    let out = run(&c.program, &c.machine, &c.robot, &c.conduct);
    if out.violations > 0 || out.rejected > 0 {
        let fails = |o: &Outcome| o.violations > 0 || o.rejected > 0;
        let small = shrink(&c.program, |p| fails(&run(p, &c.machine, &c.robot, &c.conduct)));
        println!(
            "seed {seed} {} {:?}: {} violations in {} cycles, {} cells rejected, worst {:?}\n{}\n{:?}\n{:?}\n\
             shrunk to {:#?}",
            c.program.name,
            c.robot,
            out.violations,
            out.cycles,
            out.rejected,
            out.worst,
            out.place,
            c.conduct,
            c.machine,
            small.steps
        );
    }
    (out, c.program.steps.len())
}

/// Runs many seeds and prints the sum.
fn many(seeds: core::ops::Range<u64>, count: usize) {
    println!("seeds {seeds:?}");
    let (mut cycles, mut segments, mut bad, mut rejected, mut refused) = (0, 0, 0, 0, 0);
    let (mut worst, mut events, mut memory, mut unfinished) = ([0.0_f64; 4], 0, 0, 0);
    for seed in seeds {
        let (out, steps) = judged(seed, count);
        cycles += out.cycles;
        segments += steps;
        bad += u64::from(out.violations > 0);
        rejected += out.rejected;
        refused += out.refused;
        unfinished += out.unfinished;
        events = events.max(out.events);
        memory = memory.max(out.memory);
        for (w, r) in worst.iter_mut().zip(out.worst) {
            *w = w.max(r);
        }
    }
    println!(
        "{segments} segments, {cycles} cycles: worst v {:.9} a {:.9} j {:.9} path {:.6}; {bad} bad programs; \
         {rejected} rejected cells; {refused} programs ended at a refused move, {unfinished} after their time; \
         {events} events, track {memory} bytes",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert_eq!(bad, 0);
    assert_eq!(rejected, 0);
    assert!(events < 96, "a period was cut short");
}

#[test]
fn random_programs_keep_every_limit() {
    many(0..231, 40);
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
            println!("{name} P {tolerance}: {} cycles, worst {:.9?}", out.cycles, out.worst);
            assert_eq!(
                (out.violations, out.rejected, out.refused),
                (0, 0, 0),
                "{name} {}",
                out.place
            );
        }
    }
}

/// Cases that a million random segments found: a rest a rounding away from a stop, and crawls whose output had drifted
/// away from the input.
#[test]
fn cases_of_the_past_keep_every_limit() {
    for seed in [2853, 12_170, 12_337, 12_739, 16_049] {
        let (out, _) = judged(seed, 60);
        assert_eq!((out.violations, out.rejected), (0, 0), "seed {seed}");
    }
}

#[test]
#[ignore = "long: cargo test -p hal-trajectory --release --test limits -- --ignored --nocapture"]
fn a_million_random_segments_keep_every_limit() {
    let parts: Vec<_> = (0..2)
        .map(|k| std::thread::spawn(move || many(1000 + k * 10_500..11_500 + k * 10_500, 60)))
        .collect();
    for part in parts {
        part.join().unwrap();
    }
}
