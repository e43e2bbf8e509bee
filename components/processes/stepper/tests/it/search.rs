//! Search for the speed and acceleration that an axis can bear, as done on a machine: moves back and forth, harder each
//! time, until the axis does not return to its mark.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test that shows a table")]

use axis::Steptest;
use hal_bench::Bench;
use stepgen::Stepgen;
use stepper::Stepper;

const BASE_NS: i64 = 100_000;
const SERVO_NS: i64 = 1_000_000;

/// Axis of the printer: limits of its motor, and the values to try.
struct Axis {
    name: &'static str,
    scale: f64,
    amplitude: f64,
    /// Speed and acceleration at which the motor stalls.
    stall: (f64, f64),
    /// Acceleration during the search for the speed.
    gentle: f64,
    /// Increments of the search, for speed and acceleration.
    tries: (f64, f64),
    /// Expected result of the search.
    last_good: (f64, f64),
}

const AXES: [Axis; 3] = [
    X,
    Axis { name: "Y", ..X },
    Axis {
        name: "Z",
        scale: 285.714285714,
        amplitude: 45.0,
        stall: (13.5, 42.5),
        gentle: 20.0,
        tries: (3.0, 5.0),
        last_good: (12.0, 40.0),
    },
];
const X: Axis = Axis {
    name: "X",
    scale: 4.0,
    amplitude: 95.0,
    stall: (95.0, 1550.0),
    gentle: 500.0,
    tries: (10.0, 100.0),
    last_good: (90.0, 1500.0),
};

/// Result of a trial.
struct Outcome {
    top_speed: f64,
    top_accel: f64,
    steps: u32,
    lost: i32,
    off: f64,
}

/// Runs one trial: steptest drives stepgen, stepgen the motor, back and forth once, and home.
fn trial(axis: &Axis, speed: f64, accel: f64) -> Outcome {
    let mut bench = Bench::new();
    bench.load::<Steptest>(&[]).unwrap();
    bench.load::<Stepgen>(&["step_type=0"]).unwrap();
    bench.load::<Stepper>(&[]).unwrap();
    for (name, value) in [
        ("steptest.0.amplitude", axis.amplitude),
        ("stepgen.0.position-scale", axis.scale),
        ("stepgen.0.maxvel", speed),
        ("stepgen.0.maxaccel", accel),
        ("stepper.0.scale", axis.scale),
        ("stepper.0.max-vel", axis.stall.0),
        ("stepper.0.max-accel", axis.stall.1),
    ] {
        bench.set(name, value);
    }
    bench.set("stepgen.0.stepspace", 0_u32);
    bench.set("stepgen.0.dirhold", 31_732_u32);
    bench.set("stepgen.0.dirsetup", 31_732_u32);
    bench.set("stepgen.0.enable", true);
    bench.set("steptest.0.run", true);

    let mut out = Outcome { top_speed: 0.0, top_accel: 0.0, steps: 0, lost: 0, off: 0.0 };
    let (mut counts, mut ends) = (0, 0);
    let mut target = -axis.amplitude;
    for _ in 0..1_000_000 {
        bench.run("stepgen.capture-position", SERVO_NS);
        bench.set("steptest.0.position-fb", bench.get::<f64>("stepgen.0.position-fb"));
        bench.run("steptest.0", SERVO_NS);
        let command: f64 = bench.get("steptest.0.position-cmd");
        bench.set("stepgen.0.position-cmd", command);
        bench.run("stepgen.update-freq", SERVO_NS);
        if command != target {
            target = command;
            ends += 1;
            bench.set("steptest.0.run", ends < 2);
        }
        for _ in 0..SERVO_NS / BASE_NS {
            bench.run("stepgen.make-pulses", BASE_NS);
            bench.set("stepper.0.step", bench.get::<bool>("stepgen.0.step"));
            bench.set("stepper.0.dir", bench.get::<bool>("stepgen.0.dir"));
            bench.run("stepper.0", BASE_NS);
        }
        let now: i32 = bench.get("stepper.0.counts");
        out.steps += now.abs_diff(counts);
        counts = now;
        out.top_speed = out.top_speed.max(bench.get::<f64>("stepper.0.speed").abs());
        out.top_accel = out.top_accel.max(bench.get::<f64>("stepper.0.accel").abs());
        if !bench.get::<bool>("steptest.0.running") {
            break;
        }
    }
    assert!(!bench.get::<bool>("steptest.0.running"), "the test never came home");
    assert_eq!(counts, bench.get("stepgen.0.counts"), "the motor saw other steps than were made");
    out.lost = bench.get("stepper.0.lost");
    out.off = bench.get("stepper.0.position");
    out
}

/// Increases the value until steps are lost. Returns the last value that lost none.
fn search(axis: &Axis, what: &str, step: f64, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut good = 0.0;
    loop {
        let next = good + step;
        let (speed, accel) = at(next);
        let o = trial(axis, speed, accel);
        println!(
            "{} {what:5} {speed:5.1} {accel:6.1} | {:6.2} {:7.1} | {:6} {:5} {:8.3}",
            axis.name, o.top_speed, o.top_accel, o.steps, o.lost, o.off
        );
        let off = o.off.abs() * axis.scale >= 1.0;
        assert_eq!(off, o.lost != 0, "{}: what is lost shows at the mark", axis.name);
        if off {
            return good;
        }
        assert!(next < 1e4, "it never stalls");
        good = next;
    }
}

#[test]
fn ends_at_what_the_printer_could_bear() {
    println!("axis search tried (v, a) | seen (v, a) | steps, lost, off the mark");
    for axis in &AXES {
        let speed = search(axis, "speed", axis.tries.0, |v| (v, axis.gentle));
        let accel = search(axis, "accel", axis.tries.1, |a| (speed, a));
        assert_eq!((speed, accel), axis.last_good, "axis {}", axis.name);
    }
}
