//! Pins and functions on simulated lines.

use super::MS;
use crate::{
    gpio::HalGpio,
    pi::{HEADER, PiGpio},
};
use hal_bench::{Bench, trace::replay};

#[test]
fn inputs_outputs_and_their_inverses() {
    let rows = replay::<HalGpio>(
        "load hal_gpio inputs=A,B activelow=B
         run hal_gpio.read
         in hal_gpio.sim.A hal_gpio.sim.B
         out hal_gpio.A-in hal_gpio.A-in-not hal_gpio.B-in hal_gpio.B-in-not
         0 0 | 0 1 1 0
         1 0 | 1 0 1 0
         0 1 | 0 1 0 1
         1 1 | 1 0 0 1
         load hal_gpio outputs=A,B,C,D invert=B opendrain=C opensource=D
         expect hal_gpio.sim.A 0
         expect hal_gpio.sim.B 1
         run hal_gpio.write
         in hal_gpio.A-out hal_gpio.B-out hal_gpio.C-out hal_gpio.D-out
         out hal_gpio.sim.A hal_gpio.sim.B hal_gpio.sim.C hal_gpio.sim.D
         0 0 0 0 | 0 1 0 0
         1 0 0 1 | 1 1 0 1
         0 1 1 0 | 0 0 1 0
         1 1 1 1 | 1 0 1 1",
    );
    assert_eq!(rows, 8);
}

/// In virtual time the reset does not wait; outputs without it keep their levels.
#[test]
fn a_step_pulse_in_every_period() {
    let rows = replay::<HalGpio>(
        "load hal_gpio outputs=STEP,DIR,LOW reset=STEP,LOW invert=LOW
         set hal_gpio.reset_ns 5000
         run hal_gpio.write
         in hal_gpio.STEP-out hal_gpio.DIR-out hal_gpio.LOW-out
         out hal_gpio.sim.STEP hal_gpio.sim.DIR hal_gpio.sim.LOW
         1 1 1 | 1 1 0
         run hal_gpio.reset
         . . . | 0 1 1
         run hal_gpio.write hal_gpio.reset
         1 0 0 | 0 0 1
         run hal_gpio.write
         . . . | 1 0 1
         run hal_gpio.reset
         set hal_gpio.STEP-out-reset 0
         . . . | 1 0 1
         set hal_gpio.STEP-out-reset 1
         . . . | 0 0 1",
    );
    assert_eq!(rows, 6);
}

/// Returns the nanoseconds of a reset with this time, in a period of 20 us, and the time that it sets.
fn reset_takes(mut bench: Bench, asked: u32) -> (i64, u32) {
    bench.load::<HalGpio>(&["outputs=A", "reset=A"]).unwrap();
    bench.set("hal_gpio.reset_ns", asked);
    bench.set("hal_gpio.A-out", true);
    bench.run("hal_gpio.write", 20_000);
    let written = bench.now_ns();
    bench.run("hal_gpio.reset", 20_000);
    assert!(!bench.get::<bool>("hal_gpio.sim.A"));
    (bench.now_ns() - written, bench.get("hal_gpio.reset_ns"))
}

#[test]
fn a_reset_waits_for_its_time_of_at_most_a_quarter_of_the_period() {
    for (asked, kept) in [(0, 0), (3000, 3000), (5000, 5000), (5001, 5000), (u32::MAX, 5000)] {
        // Besides the wait, the clock is read at most four times: 100 ns each.
        let (took, set) = reset_takes(Bench::real_time(100), asked);
        let wait = i64::from(kept);
        assert!(wait <= took.max(200) && took <= wait + 400, "{asked}: {took}");
        assert_eq!(set, kept);
        assert_eq!(reset_takes(Bench::new(), asked), (0, kept), "virtual time does not wait");
        assert_eq!(reset_takes(Bench::real_time(0), asked), (0, kept), "a clock that stands still");
    }
}

#[test]
fn pins_parameters_and_functions() {
    let mut bench = Bench::new();
    bench.load::<HalGpio>(&["inputs=A", "outputs=B", "reset=B", "encoders=C:D"]).unwrap();
    let mut names = bench.names();
    names.retain(|name| !name.contains(".sim.") && !name.contains(".encoder."));
    assert_eq!(
        names,
        [
            "hal_gpio.A-in bit OUT",
            "hal_gpio.A-in-not bit OUT",
            "hal_gpio.B-out bit IN",
            "hal_gpio.B-out-reset bit RW",
            "hal_gpio.fault bit OUT",
            "hal_gpio.reset_ns u32 RW",
        ]
    );
    assert_eq!(
        bench.functs(),
        ["hal_gpio.capture-position", "hal_gpio.read", "hal_gpio.reset", "hal_gpio.write"]
    );
    let mut bench = Bench::new();
    bench.load::<HalGpio>(&["outputs=B"]).unwrap();
    assert_eq!(bench.functs(), ["hal_gpio.read", "hal_gpio.write"]);
}

/// Of 128 lines in two requests each reaches its own pin and no other.
#[test]
fn each_line_reaches_its_pin() {
    let names: Vec<String> = (0..64).map(|n| format!("L{n}")).collect();
    let (inputs, outputs): (Vec<_>, Vec<_>) =
        names.iter().map(|n| (format!("I{n}"), format!("O{n}"))).unzip();
    let mut bench = Bench::new();
    let args = [format!("inputs={}", inputs.join(",")), format!("outputs={}", outputs.join(","))];
    bench.load::<HalGpio>(&[&args[0], &args[1]]).unwrap();
    for line in 0..64 {
        bench.set(&format!("hal_gpio.sim.IL{line}"), true);
        bench.set(&format!("hal_gpio.OL{line}-out"), true);
        bench.run("hal_gpio.read", MS);
        bench.run("hal_gpio.write", MS);
        for other in 0..64 {
            let (level, driven): (bool, bool) = (
                bench.get(&format!("hal_gpio.IL{other}-in")),
                bench.get(&format!("hal_gpio.sim.OL{other}")),
            );
            assert_eq!((level, driven), (line == other, line == other), "{line} {other}");
        }
        bench.set(&format!("hal_gpio.sim.IL{line}"), false);
        bench.set(&format!("hal_gpio.OL{line}-out"), false);
    }
}

/// The level counts once it has lasted for 2 ms; a shorter one does not.
#[test]
fn a_debounced_input_waits() {
    let mut bench = Bench::new();
    bench.load::<HalGpio>(&["inputs=A,B", "debounce=A:2000", "activelow=B"]).unwrap();
    let read = |level: bool| {
        bench.set("hal_gpio.sim.A", level);
        bench.run("hal_gpio.read", MS);
        bench.pass(MS);
        bench.get::<bool>("hal_gpio.A-in")
    };
    let levels = [0, 1, 0, 1, 1, 1, 1, 0, 1, 0, 0, 0].map(|level| u8::from(read(level != 0)));
    assert_eq!(levels, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 0]);
}

#[test]
fn a_stop_makes_the_outputs_inactive() {
    let mut bench = Bench::new();
    bench.load::<HalGpio>(&["outputs=A,B", "invert=B"]).unwrap();
    bench.set("hal_gpio.A-out", true);
    bench.set("hal_gpio.B-out", true);
    bench.run("hal_gpio.write", MS);
    let wires = |bench: &Bench| ["A", "B"].map(|n| bench.get::<bool>(&format!("hal_gpio.sim.{n}")));
    assert_eq!(wires(&bench), [true, false]);
    for _ in 0..2 {
        bench.stop();
        assert_eq!(wires(&bench), [false, true]);
        assert!(bench.get::<bool>("hal_gpio.A-out"), "pins keep their values");
    }
    bench.run("hal_gpio.write", MS);
    assert_eq!(wires(&bench), [true, false]);
}

#[test]
fn a_chip_that_vanishes_is_a_fault_until_it_answers() {
    let rows = replay::<HalGpio>(
        "load hal_gpio inputs=A outputs=B
         run hal_gpio.read hal_gpio.write
         in hal_gpio.sim.A hal_gpio.B-out hal_gpio.sim.vanished
         out hal_gpio.A-in hal_gpio.sim.B hal_gpio.fault
         1 1 0 | 1 1 0
         0 0 1 | 1 1 1
         . . 1 | 1 1 1
         . . 0 | 0 0 0",
    );
    assert_eq!(rows, 4);
    let mut bench = Bench::new();
    bench.load::<HalGpio>(&["outputs=B"]).unwrap();
    bench.set("hal_gpio.sim.vanished", true);
    bench.run("hal_gpio.write", MS);
    assert!(
        bench.said()[0].starts_with("the simulated chip is gone: nothing drives its outputs B;")
    );
}

/// Every bit of the masks with the pin that it has, as an output and as an input.
#[test]
fn each_bit_of_the_masks_is_a_pin_of_the_header() {
    for (bit, (line, pin)) in HEADER.into_iter().enumerate() {
        let exclude = format!("exclude={}", 0x3FF_FFFF & !(1_u32 << bit));
        for (dir, suffix, funct) in
            [(1_u32 << bit, "out", "write"), (!(1_u32 << bit), "in", "read")]
        {
            let mut bench = Bench::new();
            bench.load::<PiGpio>(&[&format!("dir={dir:#x}"), &exclude]).unwrap();
            let names: Vec<String> =
                bench.names().into_iter().filter(|n| n.starts_with("hal_pi_gpio.pin-")).collect();
            let (name, wire) = (
                format!("hal_pi_gpio.pin-{pin:02}-{suffix}"),
                format!("hal_pi_gpio.sim.pin-{pin:02}"),
            );
            assert_eq!(names.len(), 1, "GPIO{line}: {names:?}");
            let (from, to) = if suffix == "out" { (&name, &wire) } else { (&wire, &name) };
            bench.set(from, true);
            bench.run(&format!("hal_pi_gpio.{funct}"), MS);
            assert!(bench.get::<bool>(to), "GPIO{line} is pin {pin}");
        }
    }
}

#[test]
fn the_header_without_arguments_is_all_outputs() {
    let mut bench = Bench::new();
    bench.load::<PiGpio>(&[]).unwrap();
    let names = bench.names();
    assert_eq!(names.iter().filter(|n| n.ends_with("-out bit IN")).count(), 26);
    assert_eq!(bench.functs(), ["hal_pi_gpio.read", "hal_pi_gpio.write"]);
}

#[test]
fn functions_say_what_they_touch() {
    let mut bench = Bench::new();
    bench.load::<HalGpio>(&["inputs=A", "outputs=B", "reset=B", "encoders=C"]).unwrap();
    for (funct, touched, not) in [
        (
            "read",
            &[
                "hal_gpio.A-in w",
                "hal_gpio.A-in-not w",
                "hal_gpio.sim.A r",
                "hal_gpio.fault w",
                "# w",
            ][..],
            &["hal_gpio.B", "sim.B", "sim.C", "encoder"][..],
        ),
        (
            "capture-position",
            &["hal_gpio.sim.C r", "hal_gpio.encoder.0.counts w", "hal_gpio.fault w", "# w"],
            &["hal_gpio.A", "sim.A", "sim.B"],
        ),
        (
            "write",
            &["hal_gpio.B-out r", "hal_gpio.sim.B w", "hal_gpio.fault w", "# w"],
            &["hal_gpio.A", "sim.A", "encoder"],
        ),
        (
            "reset",
            &["hal_gpio.reset_ns r", "hal_gpio.B-out-reset r", "hal_gpio.sim.B w", "# r"],
            &["hal_gpio.A", "B-out r"],
        ),
    ] {
        let touches = bench.touches(&format!("hal_gpio.{funct}"));
        for item in touched {
            assert!(touches.iter().any(|t| t == item), "{funct} {item}: {touches:?}");
        }
        for item in not {
            assert!(!touches.iter().any(|t| t.contains(item)), "{funct} {item}: {touches:?}");
        }
    }
}

/// The two bits that are not in order, as LinuxCNC has them.
#[test]
fn bits_19_and_20_are_exchanged() {
    for (bit, pin) in [(18, "38"), (19, "15"), (20, "40"), (21, "16")] {
        let mut bench = Bench::new();
        let exclude = format!("exclude={}", 0x3FF_FFFF & !(1_u32 << bit));
        bench.load::<PiGpio>(&[&exclude]).unwrap();
        let name = format!("hal_pi_gpio.pin-{pin}-out bit IN");
        assert!(bench.names().contains(&name), "bit {bit} is pin {pin}");
    }
}
