//! Cost of a cycle of nine joints, at rest and along a path.

use crate::Motmod;
use hal_bench::{Bench, Random};
use hal_component::MotionStatus;
use std::time::Instant;
use trivkins::Trivkins;

const PERIOD: i64 = 1_000_000;
const CYCLES: usize = 60_000;
const LETTERS: [&str; 9] = ["x", "y", "z", "a", "b", "c", "u", "v", "w"];

/// Cycles between two looks of the test at the machine, which take the caches from the controller.
const BETWEEN: usize = 50;

/// Runs a cycle and returns the time of the controller, in nanoseconds.
#[expect(clippy::disallowed_methods, reason = "the cost is a time of the processor")]
fn cycle(bench: &Bench) -> u128 {
    bench.pass(PERIOD);
    bench.run("motion-command-handler", PERIOD);
    let start = Instant::now();
    bench.run("motion-controller", PERIOD);
    start.elapsed().as_nanos()
}

/// Moves the motors to their commands.
fn follow(bench: &Bench) {
    for n in 0..9 {
        let at: f64 = bench.get(&format!("joint.{n}.motor-pos-cmd"));
        bench.set(&format!("joint.{n}.motor-pos-fb"), at);
    }
}

/// Returns the time of a call of a function that has nothing to do, in nanoseconds.
#[expect(clippy::disallowed_methods, reason = "the cost is a time of the processor")]
fn idle(bench: &Bench) -> u128 {
    let start = Instant::now();
    bench.run("motion-command-handler", PERIOD);
    start.elapsed().as_nanos()
}

/// Prints mean and rare times of the controller, and of a function that does nothing.
#[expect(clippy::print_stdout, reason = "figures for the reader of the test")]
#[test]
#[ignore = "prints times, which depend on the machine: cargo test -p motion --release speed -- --ignored --nocapture"]
fn the_cost_of_a_cycle_of_nine_joints() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&["coordinates=xyzabcuvw"]).unwrap();
    bench.load::<Motmod>(&["num_joints=9"]).unwrap();
    let say = |text: &str| {
        let words: Vec<&str> = text.split_whitespace().collect();
        bench.command(words[0], &words[1..]).unwrap()
    };
    for n in 0..9 {
        say(&format!(
            "motion.configure joint={n} max-velocity=100 max-acceleration=1000 min-limit=-500 \
             max-limit=500 ferror=10 min-ferror=10"
        ));
    }
    say("motion.enable");
    say("motion.home joint=all");
    for _ in 0..100 {
        let _ = cycle(&bench);
        follow(&bench);
    }
    let mut random = Random::new(5);
    let mut times = |moves: bool| {
        let mut all = Vec::new();
        let mut reached = 0;
        for n in 0..CYCLES {
            if n % BETWEEN == 0 {
                let s: MotionStatus = bench.snapshot("motion.status");
                reached = reached.max(s.segment);
                for _ in s.queue..if moves { 20 } else { 0 } {
                    let mut text = String::from("motion.move mode=blend tolerance=0.1 velocity=60");
                    for letter in LETTERS {
                        text += &format!(" {letter}={}", random.between(-20.0, 20.0));
                    }
                    say(&text);
                }
                drop(bench.work("motmod.planner", 64));
                follow(&bench);
            }
            all.push(cycle(&bench));
        }
        assert_eq!(reached > 0, moves, "{reached} segments");
        all.sort_unstable();
        let mean = all.iter().sum::<u128>() / all.len() as u128;
        (mean, all[all.len() / 10], all[all.len() / 2], all[all.len() - all.len() / 1000], reached)
    };
    let empty = {
        let mut all: Vec<u128> = (0..60_000).map(|_| idle(&bench)).collect();
        all.sort_unstable();
        (all[all.len() / 10], all[all.len() / 2])
    };
    println!("a function that does nothing, p10 and median in ns, part of each figure: {empty:?}");
    println!("at rest: mean, p10, median, p99.9 in ns, segments {:?}", times(false));
    println!("on a path: mean, p10, median, p99.9 in ns, segments {:?}", times(true));
}
