//! Speed of the parser for script lines: comments, variables, words, arguments.
//!
//! At the end, it prints the number of lines per second; the required minimum is 100,000.
#![expect(clippy::unwrap_used, reason = "a benchmark")]
#![expect(clippy::print_stdout, reason = "a benchmark prints")]
#![expect(clippy::disallowed_methods, reason = "a benchmark looks at the wall")]

use divan::{Bencher, counter::ItemsCount};
use halcmd::{ini::Ini, language::syntax::statements, language::vars::Values};
use std::time::Instant;

const INI: &str = "[JOINT_0]\nSCALE = 80\nMAXACCEL = 1500\n[HAL]\nNAME = stepgen\n";

/// Typical lines of machines.
const LINES: &str = "\
    # the base thread\n\
    loadrt threads name1=base period1=50000 name2=servo period2=1000000\n\
    addf stepgen.make-pulses base\n\
    setp stepgen.0.position-scale [JOINT_0]SCALE\n\
    setp [HAL](NAME).0.maxaccel [JOINT_0]MAXACCEL # steps\n\
    net x-pos-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd\n\
    net x-pos-fb stepgen.0.position-fb => joint.0.motor-pos-fb\n\
    \n\
    linkps and2.0.out <= estop\n\
    stepgen.0.dirhold = 35000\n";

fn text() -> Vec<u8> {
    LINES.repeat(1000).into_bytes()
}

/// Parses every line; returns the number of lines.
fn understand(text: &[u8], ini: &Ini) -> usize {
    let values = Values { environment: &|_| None, ini: Some(ini) };
    let mut lines = 0;
    for (_, statement) in statements(text, values) {
        let statement = statement.unwrap();
        if !statement.words().is_empty() {
            divan::black_box(statement.command().unwrap());
        }
        lines += 1;
    }
    lines
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn ten_thousand_lines(bencher: Bencher<'_, '_>) {
    let (text, ini) = (text(), Ini::parse("m.ini", INI.as_bytes()).unwrap());
    bencher.counter(ItemsCount::new(10_000_usize)).bench_local(|| understand(&text, &ini));
}

fn main() {
    divan::main();
    let (text, ini) = (text(), Ini::parse("m.ini", INI.as_bytes()).unwrap());
    let best = (0..5).map(|_| {
        let begin = Instant::now();
        let lines = understand(&text, &ini);
        lines as f64 / begin.elapsed().as_secs_f64()
    });
    println!("{:.0} lines a second", best.fold(0.0, f64::max));
}
