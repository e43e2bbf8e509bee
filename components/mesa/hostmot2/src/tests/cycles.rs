//! Effects of commands at a simulated card's terminals, and of its terminals on pins.

use super::{PERIOD, Rig};

#[test]
fn a_step_generator_goes_where_it_shall() {
    for kind in ["7i92", "7i76e", "7i96s", "7i95t"] {
        let rig = Rig::new(kind);
        rig.stepgen(1000.0, 500.0);
        rig.set("stepgen.00.position-cmd", 3.0);
        rig.cycles(1000);
        let steps = rig.float("sim.stepgen.00.steps");
        assert!((steps - 3000.0).abs() < 1.0, "{kind}: {steps}");
        assert!((rig.float("stepgen.00.position-fb") - 3.0).abs() < 0.001, "{kind}");
        assert!([2999, 3000].contains(&rig.int("stepgen.00.counts")), "{kind}");
        assert!(rig.float("stepgen.00.velocity-fb").abs() < 1e-3, "{kind}");
        assert!(!rig.bit("watchdog.has_bit") && !rig.bit("io_error"), "{kind}");
    }
}

/// The pulses keep the acceleration and the speed: measured at the card, not at the driver's pins.
#[test]
fn a_step_generator_keeps_its_limits() {
    let rig = Rig::new("7i92");
    rig.stepgen(1000.0, 500.0);
    rig.set("stepgen.00.maxvel", 20.0);
    rig.set("stepgen.00.position-cmd", 5.0);
    let (mut last, mut speed) = (0.0, 0.0);
    let mut fastest = 0.0_f64;
    for n in 0..2000 {
        if n == 700 {
            rig.set("stepgen.00.position-cmd", -5.0);
        }
        rig.cycle();
        let now = rig.float("sim.stepgen.00.steps") / 1000.0;
        let next = (now - last) / 0.001;
        assert!((next - speed).abs() <= 500.0 * 0.001 * 1.01, "{n}: {speed} to {next}");
        assert!(next.abs() <= 20.01, "{n}: {next}");
        fastest = fastest.max(next.abs());
        (last, speed) = (now, next);
    }
    assert!(fastest > 19.9, "{fastest}");
    assert!((last + 5.0).abs() < 0.001, "{last}");
}

#[test]
fn a_step_generator_turns_at_the_speed_that_it_shall() {
    let rig = Rig::new("7i92");
    rig.stepgen(-400.0, 0.0);
    rig.set("stepgen.00.control-type", true);
    rig.set("stepgen.00.velocity-cmd", 25.0);
    rig.cycles(2);
    let before = rig.float("sim.stepgen.00.steps");
    rig.cycles(1000);
    let turned = rig.float("sim.stepgen.00.steps") - before;
    assert!((turned + 10_000.0).abs() < 0.1, "{turned}");
    assert!((rig.float("stepgen.00.velocity-fb") - 25.0).abs() < 1e-9);
    // Disabled, it stands at once.
    rig.set("stepgen.00.enable", false);
    rig.cycle();
    let before = rig.float("sim.stepgen.00.steps");
    rig.cycles(100);
    assert_eq!(rig.float("sim.stepgen.00.steps").to_bits(), before.to_bits());
    rig.set("stepgen.00.position-reset", true);
    rig.cycle();
    assert_eq!(rig.int("stepgen.00.counts"), 0);
}

#[test]
fn an_encoder_counts_and_its_index_is_the_place() {
    for (kind, encoder) in [("7i92", "encoder.00"), ("7i95t", "encoder.03")] {
        let rig = Rig::new(kind);
        let at = |pin: &str| format!("{encoder}.{pin}");
        rig.set(&at("scale"), 4000.0);
        rig.set(&format!("sim.{encoder}.counts-per-index"), 4000_u32);
        rig.cycles(2);
        let mut counts = 0;
        let mut turn = |n: i32| {
            for _ in 0..n {
                counts += 7;
                rig.set(&format!("sim.{encoder}.counts"), counts);
                rig.cycle();
            }
            counts
        };
        let now = turn(300);
        // The card counts in the cycle that passes next.
        assert!((now - rig.int(&at("count"))).abs() <= 7, "{kind}");
        let velocity = rig.float(&at("velocity"));
        assert!((velocity - 1.75).abs() < 0.02, "{kind}: {velocity}");
        assert!((rig.float(&at("velocity-rpm")) - velocity * 60.0).abs() < 1e-9);
        rig.set(&at("index-enable"), true);
        let now = turn(400);
        assert!(!rig.bit(&at("index-enable")), "{kind}");
        let seen = rig.int(&at("count"));
        assert!((now - 4000 - seen).abs() <= 7, "{kind}: {now} {seen}");
        assert!((rig.float(&at("position")) - f64::from(seen) / 4000.0).abs() < 1e-12);
        // It stands: the speed is 0 after the time-out.
        rig.cycles(600);
        assert_eq!(rig.float(&at("velocity")).to_bits(), 0, "{kind}");
        rig.set(&at("reset"), true);
        rig.cycle();
        assert_eq!(rig.int(&at("count")), 0);
    }
}

#[test]
fn inputs_and_outputs_are_those_of_the_terminals() {
    let rig = Rig::new("7i92");
    rig.cycles(2);
    for level in [false, true, false] {
        rig.set("sim.in-010", level);
        rig.cycle();
        assert_eq!((rig.bit("gpio.010.in"), rig.bit("gpio.010.in_not")), (level, !level));
    }
    rig.set("gpio.010.is_output", true);
    for (out, invert, level) in
        [(true, false, true), (false, false, false), (false, true, true), (true, true, false)]
    {
        rig.set("gpio.010.out", out);
        rig.set("gpio.010.invert_output", invert);
        rig.cycle();
        assert_eq!(rig.bit("sim.out-010"), level, "{out} {invert}");
    }
    // An open drain pulls down, or lets go.
    rig.set("gpio.010.invert_output", false);
    rig.set("gpio.010.is_opendrain", true);
    rig.set("sim.in-010", true);
    for out in [true, false] {
        rig.set("gpio.010.out", out);
        rig.cycle();
        assert_eq!(rig.bit("sim.out-010"), out);
    }
}

#[test]
fn relays_scanned_inputs_filtered_inputs_and_lights() {
    let rig = Rig::new("7i95t");
    rig.set("ssr.00.out-02", true);
    rig.set("sim.inmux.00.in-05", true);
    rig.set("led.CR02", true);
    rig.cycles(20);
    assert!(rig.bit("sim.ssr.00.closed-02") && !rig.bit("sim.ssr.00.closed-01"));
    assert!(rig.bit("inmux.00.input-05") && !rig.bit("inmux.00.input-05-not"));
    assert!(rig.bit("inmux.00.raw-input-05") && !rig.bit("inmux.00.input-04"));
    assert!(rig.bit("sim.led.CR02") && !rig.bit("sim.led.CR01"));
    rig.set("ssr.00.invert-02", true);
    rig.cycle();
    assert!(!rig.bit("sim.ssr.00.closed-02"));
    // The long filter of 500 scans at 20 kHz takes 25 ms, the short one 5 scans.
    rig.set("inmux.00.input-06-slow", true);
    rig.cycles(5);
    rig.set("sim.inmux.00.in-06", true);
    rig.set("sim.inmux.00.in-07", true);
    rig.cycles(10);
    assert!(!rig.bit("inmux.00.input-06") && rig.bit("inmux.00.input-07"));
    rig.cycles(30);
    assert!(rig.bit("inmux.00.input-06"));
}

#[test]
fn raw_pins_read_and_write_any_register() {
    let rig = Rig { bench: super::card("7i92", "enable_raw"), name: "hm2_7i92.0".to_owned() };
    rig.set("raw.read_address", 0x100_u32);
    rig.cycles(2);
    assert_eq!(rig.bench.get::<u32>(&rig.at("raw.read_data")), 0x55AA_CAFE);
    // The lights, of which the second is lit.
    rig.set("raw.write_address", 0x200_u32);
    rig.set("raw.write_data", 0x4000_0000_u32);
    rig.set("raw.write_strobe", true);
    rig.cycle();
    assert!(rig.bit("sim.led.CR02") && !rig.bit("raw.write_strobe"));
    // No register: nothing happens.
    rig.set("raw.read_address", 0x102_u32);
    rig.cycles(2);
    assert_eq!(rig.bench.get::<u32>(&rig.at("raw.read_data")), 0x55AA_CAFE);
}

#[test]
fn pulse_width_has_the_duty_of_its_value() {
    let rig = Rig::new("7i96s");
    rig.set("pwmgen.00.scale", 24_000.0);
    rig.set("pwmgen.00.enable", true);
    for (value, duty) in [
        (0.0, 0.0),
        (12_000.0, 0.5),
        (24_000.0, 1.0),
        (-6000.0, -0.25),
        (99_000.0, 1.0),
        (f64::NAN, 0.0),
    ] {
        rig.set("pwmgen.00.value", value);
        rig.cycles(2);
        let out = rig.float("sim.pwmgen.00.duty");
        assert!((out - duty).abs() < 0.001, "{value}: {out}");
    }
    // Half a step above 1365 of 4096: only with dither it is seen.
    rig.set("pwmgen.00.value", 1365.5 / 4095.0 * 24_000.0);
    for (dither, steps) in [(false, 1365.0), (true, 1365.5)] {
        rig.set("pwmgen.00.dither", dither);
        rig.cycles(2);
        let out = rig.float("sim.pwmgen.00.duty") * 4096.0;
        assert!((out - steps).abs() < 1.0 / 16.0, "{dither}: {out}");
    }
    rig.set("pwmgen.00.dither", false);
    rig.set("pwmgen.00.value", 12_000.0);
    rig.set("pwmgen.00.enable", false);
    rig.cycles(2);
    assert_eq!(rig.float("sim.pwmgen.00.duty").to_bits(), 0);
}

/// The index is wanted again before the cycle that it came in has written.
#[test]
fn an_index_that_is_armed_again_at_once_is_the_next_one() {
    let rig = Rig::new("7i92");
    rig.set("sim.encoder.00.counts-per-index", 100_u32);
    rig.cycles(2);
    rig.set("encoder.00.index-enable", true);
    let mut zeros = Vec::new();
    for n in 0..60 {
        rig.set("sim.encoder.00.counts", 7 * n);
        rig.bench.pass(PERIOD);
        rig.bench.run(&rig.at("read"), PERIOD);
        if !rig.bit("encoder.00.index-enable") {
            zeros.push(rig.int("encoder.00.rawcounts") - rig.int("encoder.00.count"));
            rig.set("encoder.00.index-enable", true);
        }
        rig.bench.run(&rig.at("write"), PERIOD);
    }
    let apart: Vec<i32> = zeros.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(zeros.len() >= 4 && apart.iter().all(|way| *way == 100), "{zeros:?}");
}

/// Before the first write the rate of the time stamps is not known; a speed must be a number all the same.
#[test]
fn an_encoder_that_turns_before_the_first_write_has_a_speed() {
    let rig = Rig::new("7i92");
    for n in 1..5 {
        rig.set("sim.encoder.00.counts", 5 * n);
        rig.bench.pass(PERIOD);
        rig.bench.run(&rig.at("read"), PERIOD);
        assert!(rig.float("encoder.00.velocity").is_finite(), "{n}");
    }
}

/// The register of enables has a bit for each of 32 generators.
#[test]
fn more_generators_than_the_register_has_bits_are_left_alone() {
    let rig = Rig::new("7i92 pwmgen=40");
    let is_there = |pin| rig.bench.names().iter().any(|line| line.starts_with(&rig.at(pin)));
    assert!(is_there("pwmgen.31.") && !is_there("pwmgen.32."));
    rig.set("pwmgen.31.enable", true);
    rig.cycles(3);
}
