//! Tests of ports on the bench: pins and bits here, the rest in `tests/`.

mod ports;
mod reset;

use crate::Parport;
use hal_bench::Bench;

const MS: i64 = 1_000_000;

fn load(cfg: &str) -> Bench {
    let mut bench = Bench::new();
    bench.load::<Parport>(&[&format!("cfg={cfg}")]).unwrap();
    bench
}

fn sim(bench: &Bench, name: &str) -> u32 {
    bench.get(&format!("parport.0.sim.{name}"))
}

fn set(bench: &Bench, pins: &[&str], to: bool) {
    for pin in pins {
        bench.set(&format!("parport.0.{pin}"), to);
    }
}

fn writes(bench: &Bench) -> u32 {
    let before = sim(bench, "writes");
    bench.run("parport.0.write", MS);
    sim(bench, "writes") - before
}

/// Pins of the connector with their bits; true for a pin that is the inverse of its bit.
const DATA: &[(u8, u8, bool)] = &[
    (2, 0, false),
    (3, 1, false),
    (4, 2, false),
    (5, 3, false),
    (6, 4, false),
    (7, 5, false),
    (8, 6, false),
    (9, 7, false),
];
const STATUS: &[(u8, u8, bool)] =
    &[(15, 3, false), (13, 4, false), (12, 5, false), (10, 6, false), (11, 7, true)];
const CONTROL: &[(u8, u8, bool)] = &[(1, 0, true), (14, 1, true), (16, 2, false), (17, 3, true)];

#[test]
fn every_mode_has_its_pins() {
    for (mode, outputs, inputs, parameters) in [
        ("", [DATA, CONTROL], [STATUS, &[], &[]], 3),
        (" out", [DATA, CONTROL], [STATUS, &[], &[]], 3),
        (" epp", [DATA, CONTROL], [STATUS, &[], &[]], 3),
        (" in", [CONTROL, &[]], [STATUS, DATA, &[]], 0),
        (" x", [DATA, &[]], [STATUS, CONTROL, &[]], 3),
    ] {
        let bench = load(&format!("0x378{mode}"));
        let mut wanted = Vec::new();
        for (pin, ..) in outputs.concat() {
            wanted.push(format!("parport.0.pin-{pin:02}-out bit IN"));
            wanted.push(format!("parport.0.pin-{pin:02}-out-invert bit RW"));
            wanted.push(format!("parport.0.pin-{pin:02}-out-reset bit RW"));
        }
        for (pin, ..) in inputs.concat() {
            wanted.push(format!("parport.0.pin-{pin:02}-in bit OUT"));
            wanted.push(format!("parport.0.pin-{pin:02}-in-not bit OUT"));
        }
        for name in ["debug1", "debug2", "reset-time"].iter().take(parameters) {
            wanted.push(format!("parport.0.{name} u32 RW"));
        }
        let mut names = bench.names();
        names.retain(|n| !n.contains(".sim."));
        wanted.sort();
        names.sort();
        assert_eq!(names, wanted, "mode{mode}");
        assert_eq!(
            bench.functs(),
            [
                "parport.0.read",
                "parport.0.reset",
                "parport.0.write",
                "parport.read-all",
                "parport.write-all"
            ]
        );
    }
}

#[test]
fn each_output_drives_its_bit() {
    for (mode, lines, register, rest, unused) in [
        ("out", DATA, "data", 0x00, None),
        ("x", DATA, "data", 0x00, None),
        ("epp", DATA, "data", 0x00, None),
        ("out", CONTROL, "control", 0x0B, Some(("data", 0x00))),
        ("epp", CONTROL, "control", 0x0B, Some(("data", 0x00))),
        ("in", CONTROL, "control", 0x2B, None),
    ] {
        for (pin, bit, _) in lines {
            for (value, invert) in [(false, false), (true, false), (false, true), (true, true)] {
                let bench = load(&format!("378 {mode}"));
                bench.set(&format!("parport.0.pin-{pin:02}-out"), value);
                bench.set(&format!("parport.0.pin-{pin:02}-out-invert"), invert);
                bench.run("parport.0.write", MS);
                let changed = if value == invert { 0 } else { 1 << bit };
                let case = format!("{mode} pin {pin} {value} {invert}");
                assert_eq!(sim(&bench, register), rest ^ changed, "{case}");
                for n in 0..8 {
                    // Bit 4 belongs to no line, and the direction bit is not inverted.
                    if register == "data" || n < 4 || n == 5 {
                        let shown: bool = bench.get(&format!("parport.0.sim.{register}-{n}"));
                        assert_eq!(shown, (rest ^ changed) >> n & 1 == 1, "{case} bit {n}");
                    }
                }
                if let Some((other, level)) = unused {
                    assert_eq!(sim(&bench, other), level, "{case}");
                }
            }
        }
    }
}

#[test]
fn each_bit_reaches_its_input() {
    for (mode, lines, register) in [
        ("out", STATUS, "status"),
        ("in", STATUS, "status"),
        ("x", STATUS, "status"),
        ("in", DATA, "data"),
        ("x", CONTROL, "control"),
    ] {
        for (_, driven, _) in lines {
            let bench = load(&format!("378 {mode}"));
            bench.set(&format!("parport.0.sim.{register}-{driven}"), true);
            bench.run("parport.0.read", MS);
            for (pin, bit, opposite) in lines {
                let high = (bit == driven) != *opposite;
                let level: bool = bench.get(&format!("parport.0.pin-{pin:02}-in"));
                let not: bool = bench.get(&format!("parport.0.pin-{pin:02}-in-not"));
                assert_eq!((level, not), (high, !high), "{mode} {register}-{driven} pin {pin}");
            }
        }
    }
}

#[test]
fn a_whole_status_byte_can_be_set() {
    let bench = load("378");
    bench.set("parport.0.sim.status", 0x48_u32);
    bench.run("parport.0.read", MS);
    let high = |pin| bench.get::<bool>(&format!("parport.0.pin-{pin}-in"));
    assert_eq!([10, 11, 12, 13, 15].map(high), [true, true, false, false, true]);
}

#[test]
fn modes_with_inputs_say_so_when_opened() {
    for (mode, control, count) in [("out", 0, 0), ("epp", 0, 0), ("in", 0x2B, 1), ("x", 0x04, 1)] {
        let bench = load(&format!("378 {mode}"));
        assert_eq!((sim(&bench, "control"), sim(&bench, "writes")), (control, count), "{mode}");
    }
    let bench = load("378 x");
    bench.run("parport.0.write", MS);
    assert_eq!(sim(&bench, "control"), 0x04, "lines that are inputs stay high");
}

#[test]
fn only_changes_are_written() {
    let bench = load("378");
    assert_eq!(writes(&bench), 2, "the first write always outputs");
    assert_eq!(writes(&bench), 0);
    for (pin, count) in [("pin-02-out", 1), ("pin-09-out", 1), ("pin-16-out", 1)] {
        set(&bench, &[pin], true);
        assert_eq!((writes(&bench), writes(&bench)), (count, 0), "{pin}");
    }
    set(&bench, &["pin-03-out", "pin-17-out", "pin-04-out"], true);
    assert_eq!((writes(&bench), writes(&bench)), (2, 0));
    set(&bench, &["pin-02-out", "pin-02-out-invert"], false);
    assert_eq!(writes(&bench), 1);
    set(&bench, &["pin-02-out", "pin-02-out-invert"], true);
    assert_eq!(writes(&bench), 0, "inverted twice is the same level");
    let bench = load("378 in");
    assert_eq!((writes(&bench), writes(&bench)), (1, 0), "nothing is written to inputs");
}

#[test]
fn the_first_write_repeats_what_opening_wrote() {
    let bench = load("378 x");
    assert_eq!((writes(&bench), writes(&bench)), (2, 0));
}
