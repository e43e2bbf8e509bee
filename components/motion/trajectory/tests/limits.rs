//! Random programs of every kind, at random overrides, judged by the watchman.
#![expect(clippy::print_stdout, reason = "tests")]

mod judge;

use hal_corpus::shrink;
use hal_trajectory::Trivial;
use judge::{Outcome, case, run};

fn judged(seed: u64, count: usize) -> Outcome {
    let (machine, program, conduct) = case(seed, count);
    let out = run(&program, &machine, &Trivial, &conduct);
    if out.violations > 0 {
        let small = shrink(&program, |p| run(p, &machine, &Trivial, &conduct).violations > 0);
        println!(
            "seed {seed} {}: {} violations in {} cycles, worst {:?}\n{}\n{conduct:?}\n{machine:?}\nshrunk to {:#?}",
            program.name, out.violations, out.cycles, out.worst, out.place, small.steps
        );
    }
    out
}

/// Runs many seeds and prints the sum.
fn many(seeds: core::ops::Range<u64>, count: usize) {
    let (mut cycles, mut segments, mut bad, mut rejected, mut refused) = (0, 0, 0, 0, 0);
    let (mut worst, mut events, mut memory) = ([0.0_f64; 4], 0, 0);
    for seed in seeds {
        let out = judged(seed, count);
        cycles += out.cycles;
        segments += case(seed, count).1.steps.len();
        bad += u64::from(out.violations > 0);
        rejected += out.rejected;
        refused += out.refused;
        events = events.max(out.events);
        memory = memory.max(out.memory);
        for (w, r) in worst.iter_mut().zip(out.worst) {
            *w = w.max(r);
        }
    }
    println!(
        "{segments} segments, {cycles} cycles: worst v {:.9} a {:.9} j {:.9} path {:.6}; {bad} bad programs; \
         {rejected} rejected cells, {refused} refused moves, {events} events, track {memory} bytes",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert_eq!(bad, 0);
    assert_eq!(rejected, 0);
    assert_eq!(refused, 0);
}

#[test]
fn random_programs_keep_every_limit() {
    many(0..210, 40);
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
