//! Tests of the double step: `write` sets a pin, `reset` takes it back within the period.

use super::{MS, load, set, sim};
use crate::Parport;
use hal_bench::Bench;

/// Makes a step in every period: high in write, low in reset.
#[test]
fn reset_makes_double_steps() {
    for (invert, high, low) in [(false, 2, 0), (true, 0, 2)] {
        let bench = load("378");
        set(&bench, &["pin-03-out", "pin-03-out-reset"], true);
        set(&bench, &["pin-03-out-invert"], invert);
        let other = 0x80;
        set(&bench, &["pin-09-out"], true);
        for period in 0..5 {
            bench.run("parport.0.write", MS);
            assert_eq!(sim(&bench, "data"), high | other, "{period}");
            bench.run("parport.0.reset", MS);
            assert_eq!(sim(&bench, "data"), low | other, "{period}");
        }
        assert_eq!(sim(&bench, "writes"), 11);
        set(&bench, &["pin-03-out"], false);
        bench.run("parport.0.write", MS);
        bench.run("parport.0.reset", MS);
        assert_eq!((sim(&bench, "data"), sim(&bench, "writes")), (low | other, 11));
    }
}

#[test]
fn reset_knows_control_lines() {
    for mode in ["out", "in"] {
        let bench = load(&format!("378 {mode}"));
        let rest = if mode == "in" { 0x2B } else { 0x0B };
        set(&bench, &["pin-01-out", "pin-16-out", "pin-17-out"], true);
        set(&bench, &["pin-01-out-reset", "pin-16-out-reset", "pin-14-out-reset"], true);
        set(&bench, &["pin-14-out-invert"], true);
        bench.run("parport.0.write", MS);
        assert_eq!(sim(&bench, "control"), rest ^ 0x0F, "{mode}");
        bench.run("parport.0.reset", MS);
        assert_eq!(sim(&bench, "control"), rest ^ 0x0A, "{mode}");
    }
}

#[test]
fn reset_without_a_write_does_nothing() {
    let bench = load("378");
    set(&bench, &["pin-03-out-reset", "pin-03-out-invert"], true);
    bench.run("parport.0.reset", MS);
    assert_eq!(sim(&bench, "writes"), 0);
    bench.run("parport.0.write", MS);
    bench.stop();
    let stopped = sim(&bench, "writes");
    bench.run("parport.0.reset", MS);
    assert_eq!(sim(&bench, "writes"), stopped);
}

#[test]
fn reset_time_is_a_quarter_period_at_most() {
    let bench = load("378");
    for (given, period, kept) in [
        (5_000, 100_000, 5_000),
        (25_000, 100_000, 25_000),
        (25_001, 100_000, 25_000),
        (u32::MAX, MS, 250_000),
        (7, 3, 0),
        (7, -1, 0),
        (u32::MAX, i64::MAX, u32::MAX),
    ] {
        bench.set("parport.0.reset-time", given);
        bench.run("parport.0.reset", period);
        assert_eq!(bench.get::<u32>("parport.0.reset-time"), kept, "{given} in {period}");
    }
}

/// Returns the duration of a reset that comes `later` than its write, for a pin that is high or idle.
fn reset_takes(mut bench: Bench, later: i64, high: bool) -> i64 {
    bench.load::<Parport>(&["cfg=378"]).unwrap();
    set(&bench, &["pin-02-out"], high);
    set(&bench, &["pin-02-out-reset"], true);
    bench.set("parport.0.reset-time", 5_000_u32);
    bench.pass(1_000_000);
    bench.run("parport.0.write", 100_000);
    let written = bench.now_ns();
    bench.pass(later);
    assert_eq!(sim(&bench, "data"), u32::from(high));
    bench.run("parport.0.reset", 100_000);
    assert_eq!(sim(&bench, "data"), 0);
    bench.now_ns() - written
}

#[test]
fn reset_waits_on_a_real_clock_only() {
    // Besides the wait, the clock is read at most four times: 100 ns each.
    let short = reset_takes(Bench::real_time(100), 0, true);
    assert!((5_000..=5_400).contains(&short), "{short}");
    let late = reset_takes(Bench::real_time(100), 9_000, true);
    assert!((9_000..=9_400).contains(&late), "{late}");
    let idle = reset_takes(Bench::real_time(100), 0, false);
    assert!((0..=400).contains(&idle), "{idle}: nothing to wait for");
    assert_eq!(reset_takes(Bench::new(), 0, true), 0);
    assert_eq!(reset_takes(Bench::real_time(0), 0, true), 0, "a clock that stands still ends it");
}
