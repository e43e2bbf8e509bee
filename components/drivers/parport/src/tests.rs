//! Tests of ports on the bench.

use crate::{
    Parport,
    config::{Mode, PortConfig, PortLocation},
    hardware::{Hardware, Refused, System},
};
use hal_component::{Builder, Clock, Component, Error, Out, Period, Touch, Update, bench::Bench};
use std::fs;

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

/// Component that copies the clock to a pin.
#[derive(Touch)]
struct Stamp {
    clock: Clock,
    now: Out<i64>,
}

impl Update for Stamp {
    fn update(&mut self, _: Period) {
        self.now.set(self.clock.now_ns());
    }
}

impl Component for Stamp {
    const NAME: &'static str = "stamp";
    const DOC: &'static str = "Machine time.";
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let stamp = Self { clock: b.clock(), now: b.item("now", "Nanoseconds.", 0)? };
        b.function("", "Reads the clock.", stamp)
    }
}

/// Returns the duration of a reset that comes `later` than its write, for a pin that is high or idle.
fn reset_takes(mut bench: Bench, later: i64, high: bool) -> i64 {
    bench.load::<Parport>(&["cfg=378"]).unwrap();
    bench.create::<Stamp>(&[]).unwrap();
    let now = || {
        bench.run("stamp.0", MS);
        bench.get::<i64>("stamp.0.now")
    };
    set(&bench, &["pin-02-out"], high);
    set(&bench, &["pin-02-out-reset"], true);
    bench.set("parport.0.reset-time", 5_000_u32);
    bench.pass(1_000_000);
    bench.run("parport.0.write", 100_000);
    let written = now();
    bench.pass(later);
    assert_eq!(sim(&bench, "data"), u32::from(high));
    bench.run("parport.0.reset", 100_000);
    assert_eq!(sim(&bench, "data"), 0);
    now() - written
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

#[test]
fn a_stop_rests_the_outputs() {
    for (mode, data, control) in [("out", 0x10, 0x0F), ("in", 0, 0x2F), ("x", 0x10, 0x04)] {
        let bench = load(&format!("378 {mode}"));
        let (outputs, resting): (&[_], &[_]) = match mode {
            "in" => (&["pin-01-out", "pin-17-out"], &["pin-16-out-invert"]),
            "x" => (&["pin-02-out", "pin-09-out"], &["pin-06-out-invert"]),
            _ => (
                &["pin-02-out", "pin-06-out", "pin-17-out"],
                &["pin-06-out-invert", "pin-16-out-invert"],
            ),
        };
        set(&bench, outputs, true);
        set(&bench, resting, true);
        bench.run("parport.0.write", MS);
        let running = (sim(&bench, "data"), sim(&bench, "control"));
        for _ in 0..2 {
            bench.stop();
            assert_eq!((sim(&bench, "data"), sim(&bench, "control")), (data, control), "{mode}");
            assert!(bench.get::<bool>(&format!("parport.0.{}", outputs[0])), "pins keep values");
        }
        let all = if mode == "in" { 1 } else { 2 };
        assert_eq!((writes(&bench), writes(&bench)), (all, 0), "{mode}: all written again, once");
        assert_eq!((sim(&bench, "data"), sim(&bench, "control")), running, "{mode}");
    }
}

#[test]
fn several_ports_keep_apart() {
    let bench = load("0x378 out_0x278 in 0x3bc_x");
    bench.set("parport.0.pin-02-out", true);
    bench.set("parport.1.pin-01-out", true);
    bench.set("parport.2.pin-09-out", true);
    bench.set("parport.1.sim.data-7", true);
    bench.set("parport.2.sim.control-2", true);
    bench.run("parport.write-all", MS);
    bench.run("parport.read-all", MS);
    let raw = |name| bench.get::<u32>(&format!("parport.{name}"));
    assert_eq!(
        ["0.sim.data", "0.sim.control", "1.sim.control", "2.sim.data"].map(raw),
        [0x01, 0x0B, 0x2A, 0x80]
    );
    let high = |name| bench.get::<bool>(&format!("parport.{name}"));
    assert_eq!(
        ["1.pin-09-in", "1.pin-08-in", "2.pin-16-in", "2.pin-01-in"].map(high),
        [true, false, true, true]
    );
    let before = raw("1.sim.writes");
    bench.run("parport.0.write", MS);
    bench.run("parport.write-all", MS);
    assert_eq!(raw("0.sim.writes"), 2, "both functions know what the other wrote");
    assert_eq!(raw("1.sim.writes"), before);
    bench.set("parport.0.pin-02-out", false);
    bench.run("parport.0.write", MS);
    assert_eq!((raw("0.sim.data"), raw("2.sim.data")), (0, 0x80));
}

#[test]
fn functions_say_what_they_touch() {
    let bench = load("378");
    let touches = |name: &str| bench.touches(&format!("parport.{name}"));
    let write = touches("0.write");
    for item in ["parport.0.pin-02-out r", "parport.0.pin-02-out-invert r", "# w"] {
        assert!(write.iter().any(|t| t == item), "{item}");
    }
    assert!(write.iter().any(|t| t == "parport.0.sim.data-0 w"));
    assert!(!write.iter().any(|t| t.contains("-reset")));
    assert_eq!(write, touches("write-all"));
    let reset = touches("0.reset");
    assert!(reset.iter().any(|t| t == "# r") && !reset.iter().any(|t| t == "# w"));
    assert!(reset.iter().any(|t| t == "parport.0.pin-17-out-reset r"));
    let read = touches("0.read");
    assert!(!read.iter().any(|t| t.starts_with('#') || t.contains("sim.data")));
    assert!(read.iter().any(|t| t == "parport.0.pin-10-in-not w"));
    assert!(read.iter().any(|t| t == "parport.0.sim.status-6 r"));
}

#[test]
fn bad_strings_load_nothing() {
    for (args, says) in [
        (&[][..], "PARPORT: ERROR: no config string: "),
        (&["cfg="], "PARPORT: ERROR: no ports configured: "),
        (&["cfg=0x378 down"], "PARPORT: ERROR: bad port address 'down': "),
    ] {
        let mut bench = Bench::new();
        let why = bench.load::<Parport>(args).unwrap_err();
        assert!(why.starts_with(says), "{why}");
        assert!(bench.names().is_empty() && bench.functs().is_empty());
    }
}

#[test]
fn a_machine_without_the_port_says_what_to_do() {
    let mut bench = Bench::real_time(1).with_hardware();
    bench.create::<Parport>(&["cfg=f"]).unwrap();
    assert!(bench.names().iter().all(|n| !n.contains(".sim.")));
    let why = bench.open().unwrap_err();
    assert!(why.starts_with("parport.0: Linux parallel port 15 not found: "), "{why}");
    assert!(why.ends_with("or run with --simulate"), "{why}");
    // Nothing is open, and the functions have no effect.
    bench.run("parport.0.write", MS);
    bench.run("parport.0.write", MS);
    bench.run("parport.0.read", MS);
    bench.run("parport.0.reset", MS);
    bench.stop();
    assert_eq!(
        bench.said(),
        [
            "error 6 when writing parport.0: it is tried again",
            "error 6 when reading parport.0: its inputs keep their values",
        ],
        "once each"
    );
}

/// Returns a system whose kernel knows port 3 at 0x378; the test makes its device node.
fn system(name: &str) -> System {
    let root = std::env::temp_dir().join(format!("parport-{}-{name}", std::process::id()));
    let system = System { ports: root.join("ports"), nodes: root.join("dev"), direct: false };
    fs::create_dir_all(system.ports.join("parport3")).unwrap();
    fs::create_dir_all(&system.nodes).unwrap();
    fs::write(system.ports.join("parport3/base-addr"), "888\t1912\n").unwrap();
    system
}

#[test]
fn refusals_of_real_ports() {
    let at = |place, mode| PortConfig { place, mode };
    let known = at(PortLocation::Address(0x378), Mode::Out);
    let system = system("refused");
    let open = |config| Hardware::open(&system, 0, config).unwrap_err();

    assert_eq!(open(at(PortLocation::Address(0x278), Mode::Out)), Refused::NoWay(0x278));
    assert_eq!(open(at(PortLocation::Kernel(2), Mode::Out)), Refused::Absent(2));
    assert_eq!(open(known), Refused::NoNode(3));
    assert_eq!(open(at(PortLocation::Kernel(3), Mode::X)), Refused::NoNode(3));
    // A regular file fails every request, like a port that another program has claimed.
    fs::write(system.nodes.join("parport3"), "").unwrap();
    assert_eq!(open(known), Refused::Taken(3));
    fs::remove_dir_all(system.ports.parent().unwrap()).unwrap();

    for (why, says) in [
        (Refused::NoWay(0x278), "at 0x278"),
        (Refused::Nothing(0x278), "no port at 0x278"),
        (Refused::NoNode(3), "modprobe ppdev"),
        (Refused::Forbidden(3), "group lp"),
        (Refused::Broken(3, 5), "/dev/parport3"),
        (Refused::Taken(3), "rmmod lp"),
        (Refused::ControlInputs(3), "run as root"),
    ] {
        let text = why.to_string();
        assert!(text.contains(says) && text.ends_with("; or run with --simulate"), "{text}");
    }
}
