//! Tests of whole ports: several at once, their start and end, and what is refused.

use super::{MS, load, set, sim, writes};
use crate::{
    Parport,
    config::{Mode, PortConfig, PortLocation},
    hardware::{Hardware, Refused, System},
};
use hal_bench::Bench;
use std::fs;

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
    // The function that resets reports nothing of its own: it had nothing to reset.
    assert_eq!(bench.failed_hardware(), 2);
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
        (Refused::Absent(3), "sudo modprobe parport_pc"),
        (Refused::NoWay(0x278), "at 0x278"),
        (Refused::NoWay(0x278), "sudo modprobe parport_pc, sudo modprobe ppdev"),
        (Refused::NoWay(0x278), "sudo usermod -aG lp \"$USER\", then log in again"),
        (Refused::Nothing(0x278), "no port at 0x278"),
        (Refused::NoNode(3), "sudo modprobe ppdev"),
        (Refused::Forbidden(3), "sudo usermod -aG lp \"$USER\", then log in again"),
        (Refused::Broken(3, 5), "/dev/parport3"),
        (Refused::Taken(3), "sudo modprobe -r lp"),
        (Refused::ControlInputs(3), "--ambient-caps +sys_rawio halrun FILE"),
    ] {
        let text = why.to_string();
        assert!(text.contains(says) && text.ends_with("; or run with --simulate"), "{text}");
    }
}
