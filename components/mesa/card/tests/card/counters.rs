//! Encoder counters and the clock that follows the controller.

use crate::bench::Bench;
use hal_firmware::registers as r;

const MS: u64 = 1_000_000;

fn count(bench: &mut Bench) -> i16 {
    bench.read(r::ENCODER_COUNT, 0) as i16
}

fn stamp(bench: &mut Bench) -> u16 {
    (bench.read(r::ENCODER_COUNT, 0) >> 16) as u16
}

#[test]
fn a_shaft_is_counted_in_both_directions() {
    let mut bench = Bench::new("7i92");
    let mut at = 0_i64;
    for way in [1, 100, -37, -1000, 5000] {
        at += way;
        bench.card.set_counts(0, at);
        bench.card.advance(10 * MS);
        assert_eq!(i64::from(count(&mut bench)), at, "{way}");
    }
    // 16 bits, and on.
    for _ in 0..20 {
        bench.card.turn(0, 5000);
        bench.card.advance(10 * MS);
        at += 5000;
    }
    assert_eq!(count(&mut bench), at as i16);
}

#[test]
fn stamps_are_the_times_of_counts() {
    let mut bench = Bench::new("7i92");
    // A stamp each 50 periods: 500 ns.
    bench.write(r::ENCODER_STAMP_DIVISOR, 0, 48);
    bench.card.advance(MS);
    assert_eq!(bench.read(r::ENCODER_STAMP, 0), 2000);
    // Four counts in 1 ms: the last is at its end.
    bench.card.turn(0, 4);
    bench.card.advance(MS);
    assert_eq!((count(&mut bench), stamp(&mut bench)), (4, 4000));
    bench.card.advance(MS);
    assert_eq!((count(&mut bench), stamp(&mut bench)), (4, 4000));
    bench.card.turn(0, -1);
    bench.card.advance(MS / 2);
    assert_eq!((count(&mut bench), stamp(&mut bench)), (3, 7000));
}

#[test]
fn an_index_latches_once_and_clears_its_order() {
    let mut bench = Bench::new("7i92");
    bench.card.set_index(0, 400);
    bench.card.turn(0, 10);
    bench.card.advance(MS);
    // Latch on a rising index, once.
    bench.write(r::ENCODER_CONTROL, 0, 1 << 3 | 1 << 4 | 1 << 6);
    for nth in 1..=7 {
        bench.card.turn(0, 100);
        bench.card.advance(MS);
        let control = bench.read(r::ENCODER_CONTROL, 0);
        let armed = control >> 4 & 1 == 1;
        // The edge of the count comes with that of the index: the latch has the count before it.
        let latch = (control >> 16) as u16;
        assert_eq!((armed, latch), if nth < 4 { (true, 0) } else { (false, 399) }, "{nth}");
    }
    assert_eq!(count(&mut bench), 710);
    // Without "once" it latches at each, and clearing begins the count again.
    bench.write(r::ENCODER_CONTROL, 0, 1 << 3 | 1 << 4 | 1 << 5);
    bench.card.turn(0, 100);
    bench.card.advance(MS);
    let control = bench.read(r::ENCODER_CONTROL, 0);
    assert_eq!((control >> 16, control >> 4 & 3), (799, 3));
    assert_eq!(count(&mut bench), 10);
    // Backwards the index rises at the same place.
    bench.card.turn(0, -20);
    bench.card.advance(MS);
    assert_eq!(bench.read(r::ENCODER_CONTROL, 0) >> 16, 1);
    assert_eq!(count(&mut bench), -10);
}

#[test]
fn a_mask_stops_the_index() {
    let mut bench = Bench::new("7i92");
    bench.card.set_index(0, 100);
    bench.card.turn(0, 50);
    bench.card.advance(MS);
    // Mask used, with the line high; the line is low.
    bench.write(r::ENCODER_CONTROL, 0, 1 << 3 | 1 << 4 | 1 << 6 | 1 << 8 | 1 << 9);
    bench.card.turn(0, 100);
    bench.card.advance(MS);
    assert_eq!(bench.read(r::ENCODER_CONTROL, 0) >> 4 & 1, 1);
    // Mask used, with the line low.
    bench.write(r::ENCODER_CONTROL, 0, 1 << 3 | 1 << 4 | 1 << 6 | 1 << 9);
    bench.card.turn(0, 100);
    bench.card.advance(MS);
    assert_eq!(bench.read(r::ENCODER_CONTROL, 0) >> 4 & 1, 0);
    assert_eq!(bench.read(r::ENCODER_CONTROL, 0) >> 16, 199);
}

#[test]
fn a_probe_latches_the_count() {
    let mut bench = Bench::new("7i92");
    bench.card.turn(0, 123);
    bench.card.advance(MS);
    for (polarity, first, second) in [(1 << 12, false, true), (0, true, false)] {
        bench.card.set_probe(0, first);
        bench.write(r::ENCODER_CONTROL, 0, polarity | 1 << 13 | 1 << 6);
        bench.card.set_probe(0, first);
        assert_eq!(bench.read(r::ENCODER_CONTROL, 0) >> 13 & 1, 1);
        bench.card.set_probe(0, second);
        let control = bench.read(r::ENCODER_CONTROL, 0);
        assert_eq!((control >> 16, control >> 13 & 1), (123, 0));
    }
}

#[test]
fn the_filter_swallows_what_is_too_fast() {
    let mut bench = Bench::new("7i92");
    // Samples each 100 periods, 3 or 15 of them: a line must stay for 3 or 15 us, two counts.
    bench.write(r::ENCODER_FILTER_RATE, 0, 98);
    for (control, least) in [(0, 1_500_u64), (1 << 11, 7_500)] {
        bench.write(r::ENCODER_CONTROL, 0, control);
        let before = count(&mut bench);
        bench.card.turn(0, 100);
        bench.card.advance(100 * least);
        assert_eq!(count(&mut bench) - before, 100, "{control:x}");
        bench.card.turn(0, 100);
        bench.card.advance(100 * least - 100);
        assert_eq!(count(&mut bench) - before, 100, "{control:x}");
    }
}

/// Lines by hand: pins 16, 15 and 14 are A, B and the index.
#[test]
fn lines_by_hand_count_too() {
    let mut bench = Bench::new("7i92");
    for (a, b) in [(true, false), (true, true), (false, true)] {
        bench.card.set_input(16, a);
        bench.card.set_input(15, b);
    }
    assert_eq!(count(&mut bench), 3);
    let control = bench.read(r::ENCODER_CONTROL, 0);
    assert_eq!(control & 3, 2, "A is low, B is high");
    assert_eq!(bench.read(r::PORT_DATA, 0) >> 15 & 3, 1);
    // Step and direction: a rising A counts, forward with B high.
    bench.write(r::ENCODER_CONTROL, 0, 1 << 10);
    for _ in 0..5 {
        bench.card.set_input(16, true);
        bench.card.set_input(16, false);
    }
    assert_eq!(count(&mut bench), 8);
    bench.card.set_input(15, false);
    bench.card.set_input(16, true);
    assert_eq!(count(&mut bench), 7);
    assert_eq!(bench.read(r::ENCODER_CONTROL, 0) >> 15 & 1, 0, "no error yet");
}

/// Sets the clock for periods of 1 ms: 100,000 periods, 24 for one of its ticks.
fn set_clock(bench: &mut Bench, limit: u32) {
    bench.write(r::DPLL_CONTROL_0, 0, 24 << 24 | limit);
    bench.write(r::DPLL_BASE_RATE, 0, 0x3EEA_209A);
    bench.write(r::DPLL_CONTROL_1, 0, 2000 << 16);
    assert_eq!(bench.read(r::DPLL_CONTROL_1, 0), 2000 << 16 | 42);
}

#[test]
fn timers_latch_what_the_accumulators_had() {
    let mut bench = Bench::new("7i92");
    set_clock(&mut bench, 0);
    // Timer 1 a quarter of the period before the turn, and timer 2 a tenth.
    bench.write(r::DPLL_TIMERS_12, 0, 6554 << 16 | 16384);
    bench.write(r::STEP_TIMER, 0, 0x9000);
    bench.write(r::ENCODER_TIMER, 0, 0xA000);
    bench.write(r::STEP_RATE, 0, 1 << 20);
    bench.card.turn(0, 100);
    bench.card.advance(MS);
    // Rates of 2^20 for 75,000 ticks; an event is within one tick of the clock, 24 periods.
    let read = f64::from(bench.read(r::STEP_ACCUMULATOR, 0)) / 65536.0;
    let due = 75_000.0 / 4096.0;
    assert!((read - due).abs() <= 24.0 / 4096.0, "{read} of {due}");
    assert_eq!(count(&mut bench), 90);
    bench.write(r::STEP_TIMER, 0, 0);
    bench.write(r::ENCODER_TIMER, 0, 0);
    let read = f64::from(bench.read(r::STEP_ACCUMULATOR, 0)) / 65536.0;
    assert!((read - 100_000.0 / 4096.0).abs() < 0.001, "{read}");
    assert_eq!(count(&mut bench), 100);
}

/// Reads in periods that are 200 ppm longer than the clock's: it follows, until its phase is within 2 us.
#[test]
fn the_clock_follows_the_reads() {
    let mut bench = Bench::new("7i92");
    set_clock(&mut bench, 0x0040_0000);
    let mut worst = 0_i32;
    for nth in 0..20_000 {
        bench.card.advance(MS + 200);
        let phase = bench.read(r::DPLL_SYNC, 0).cast_signed();
        if 15_000 < nth {
            worst = worst.max(phase.abs());
        }
    }
    let us = f64::from(worst) / 4_294_967_296.0 * 1000.0;
    assert!(us < 2.0, "{us} us");
    // Without a limit it runs alone, and drifts.
    set_clock(&mut bench, 0);
    let first = bench.read(r::DPLL_SYNC, 0).cast_signed();
    for _ in 0..1000 {
        bench.card.advance(MS + 200);
        bench.read(r::DPLL_SYNC, 0);
    }
    let drift = f64::from(bench.read(r::DPLL_SYNC, 0).cast_signed().wrapping_sub(first));
    let us = drift / 4_294_967_296.0 * 1000.0;
    assert!((us - 200.0).abs() < 5.0, "{us} us");
}
