//! Runs, directions, speeds and values.

use super::{MS, Rig};
use hal_bench::Bench;

#[test]
fn a_run_has_the_values_of_the_inverter() {
    let rig = Rig::new(&[]);
    for (pin, wanted) in [
        ("max-freq", 400.0),
        ("base-freq", 400.0),
        ("freq-lower-limit", 100.0),
        ("rated-motor-voltage", 220.0),
        ("rated-motor-current", 7.0),
        ("rated-motor-rev", 24_000.0),
        ("frequency-command", 20_000.0),
        ("CNTR", 8.0),
        ("sim.frequency", 0.0),
    ] {
        assert!((rig.get(pin) - wanted).abs() < 1e-9, "{pin}: {}", rig.get(pin));
    }
    assert_eq!(rig.count("motor-poles"), 2);
    rig.set("spindle-on", true);
    assert!(!rig.is("spindle-at-speed"));
    rig.pass(3000);
    for (pin, wanted) in [
        ("SetF", 200.0),
        ("OutF", 200.0),
        ("OutA", 1.0),
        ("Rott", 12_000.0),
        ("DCV", 3110.0),
        ("ACV", 1000.0),
        ("Tmp", 31.0),
        ("CNTR", 1.0),
        ("CNST", 9.0),
        ("spindle-speed-fb", 12_000.0),
        ("sim.frequency", 200.0),
    ] {
        assert!((rig.get(pin) - wanted).abs() < 1e-9, "{pin}: {}", rig.get(pin));
    }
    assert!(rig.is("spindle-at-speed") && rig.is("CNST-run") && rig.is("CNST-running"));
    rig.set("spindle-forward", false);
    rig.set("spindle-reverse", true);
    rig.pass(100);
    assert!(!rig.is("spindle-at-speed"), "it still turns forward, and slows down");
    rig.pass(5000);
    assert_eq!((rig.get("CNTR"), rig.get("sim.frequency")), (17.0, -200.0));
    assert!(rig.is("CNST-command-rf") && rig.is("CNST-running-rf") && rig.is("spindle-at-speed"));
    rig.set("spindle-forward", true);
    rig.pass(3000);
    assert_eq!((rig.get("CNTR"), rig.get("sim.frequency")), (8.0, 0.0), "both directions");
    assert!(!rig.is("spindle-at-speed"));
}

/// A request takes about 20 ms, and a stop waits for the end of one.
#[test]
fn a_stop_goes_before_measurements() {
    for wait in 0..60 {
        let rig = Rig::running(&[]);
        rig.pass(wait);
        rig.set("spindle-on", false);
        let ms = rig.until("sim.running", false);
        assert!(ms <= 60, "{ms} ms");
    }
}

#[test]
fn a_stop_behind_a_start_that_is_not_answered_goes_first_too() {
    for wait in 0..60 {
        let rig = Rig::new(&[]);
        rig.set("sim.half", 1.0);
        rig.set("spindle-on", true);
        rig.pass(wait);
        rig.set("spindle-on", false);
        rig.pass(250);
        assert!(!rig.is("sim.running"), "after {wait} ms");
    }
}

#[test]
fn speeds_that_are_none_stop_and_limits_are_kept() {
    let rig = Rig::running(&[]);
    for speed in [0.0, -0.0, f64::NAN, f64::INFINITY] {
        rig.set("speed-command", speed);
        rig.pass(3000);
        assert_eq!((rig.get("sim.frequency"), rig.is("spindle-at-speed")), (0.0, false), "{speed}");
        rig.set("speed-command", 12_000.0);
        rig.pass(3000);
        assert!(rig.is("spindle-at-speed"));
    }
    rig.set("speed-command", -12_000.0);
    rig.pass(100);
    assert!(rig.is("spindle-at-speed"), "the sign has no effect");
    rig.forget();
    for (speed, hz) in [(1000.0, 100.0), (30_000.0, 400.0)] {
        rig.set("speed-command", speed);
        rig.pass(6000);
        assert_eq!((rig.get("sim.frequency"), rig.is("spindle-at-speed")), (hz, false));
        let said = rig.0.said();
        let wanted = "is outside the inverter's limits";
        assert_eq!(said.iter().filter(|text| text.contains(wanted)).count(), 1, "{said:?}");
        rig.set("speed-command", 12_000.0);
        rig.pass(3000);
    }
    rig.set("spindle-at-speed-tolerance", f64::NAN);
    rig.pass(100);
    assert!(!rig.is("spindle-at-speed"));
}

#[test]
fn without_enable_nothing_is_said_after_the_stop() {
    let mut bench = Bench::new();
    bench.load::<super::HyVfd>(&[]).unwrap();
    let rig = Rig(bench);
    rig.set("spindle-on", true);
    rig.pass(2000);
    // The stop of the load.
    assert_eq!((rig.count("sim.frames"), rig.is("fault")), (1, false));
    let rig = Rig::running(&[]);
    rig.set("enable", false);
    rig.pass(100);
    assert!(!rig.is("sim.running"));
    let frames = rig.count("sim.frames");
    rig.pass(2000);
    assert_eq!(
        (rig.count("sim.frames"), rig.is("fault"), rig.get("sim.frequency")),
        (frames, false, 0.0)
    );
    rig.set("enable", true);
    rig.starts_by_a_person_alone();
}

#[test]
fn a_spindle_that_is_on_at_the_load_does_not_start() {
    let mut bench = Bench::new();
    bench.load::<super::HyVfd>(&[]).unwrap();
    let rig = Rig(bench);
    for pin in ["enable", "spindle-on", "spindle-forward"] {
        rig.set(pin, true);
    }
    rig.set("speed-command", 12_000.0);
    rig.starts_by_a_person_alone();
    assert!(rig.0.said().iter().any(|text| text.contains("once spindle-on was FALSE")));
}

#[test]
fn a_clean_line_has_no_error_and_each_frame_keeps_the_silence() {
    let rig = Rig::running(&[]);
    // A frame that came too soon would not be heard, and have no answer.
    rig.pass(20_000);
    let (answers, frames) = (rig.count("answers"), rig.count("sim.frames"));
    assert!(500 < answers && frames - answers <= 1, "{answers} of {frames}");
    assert_eq!((rig.0.get::<i32>("hy_vfd.error-count"), rig.get("retval")), (0, 0.0));
    assert!(rig.get("since-answer") < 0.05);
}

#[test]
fn arguments_become_settings_of_the_inverter() {
    let rig = Rig::new(&[
        "max_frequency=300",
        "min_frequency=50",
        "motor_speed=18000",
        "motor_voltage=110",
        "motor_current=4.5",
        "motor_poles=4",
        "base_frequency=300",
        "register=PD014=10",
    ]);
    for (pin, wanted) in [
        ("max-freq", 300.0),
        ("freq-lower-limit", 50.0),
        ("base-freq", 300.0),
        ("rated-motor-rev", 18_000.0),
        ("rated-motor-voltage", 110.0),
        ("rated-motor-current", 4.5),
    ] {
        assert!((rig.get(pin) - wanted).abs() < 1e-9, "{pin}: {}", rig.get(pin));
    }
    assert_eq!(rig.count("motor-poles"), 4);
    rig.set("spindle-on", true);
    rig.pass(900);
    assert!(rig.is("spindle-at-speed"), "PD014 is 1 s");
}

#[test]
fn arguments_that_are_wrong_are_refused_in_words() {
    for (arg, words) in [
        ("rate=57600", "rate=57600: the inverter has one of 4800, 9600, 19200, 38400 (PD164)"),
        ("parity=some", "parity=some: must be none, even or odd"),
        ("device=%", "device=%: must be a path"),
        ("name=a b", "name=a b: 1 to 24 letters"),
        ("register=PD300=1", "register=PD300=1: PDnnn=VALUE is needed"),
        ("register=14", "register=14: PDnnn=VALUE is needed"),
        ("motor_speed=24000", "motor_speed= needs max_frequency="),
    ] {
        let refused = Bench::new().load::<super::HyVfd>(&[arg]).unwrap_err();
        assert!(refused.contains(words), "{arg}: {refused}");
    }
    let mut bench = Bench::new().with_hardware();
    let refused = bench.load::<super::HyVfd>(&["device=/dev/nowhere"]).unwrap_err();
    assert!(refused.contains("/dev/nowhere: No such file"), "{refused}");
    assert!(refused.contains("ls /dev/serial/by-id"), "{refused}");
    let refused = bench_refusal("/dev/null");
    assert!(refused.contains("it is no serial line"), "{refused}");
}

fn bench_refusal(device: &str) -> String {
    let mut bench = Bench::new().with_hardware();
    bench.load::<super::HyVfd>(&[&format!("device={device}")]).unwrap_err()
}

#[test]
fn another_name_is_before_all_pins() {
    let mut bench = Bench::new();
    bench.load::<super::HyVfd>(&["name=spindle.0.vfd"]).unwrap();
    assert_eq!(bench.functs(), ["spindle.0.vfd"]);
    bench.set("spindle.0.vfd.enable", true);
    for _ in 0..1000 {
        bench.pass(MS);
        bench.run("spindle.0.vfd", MS);
        bench.work("spindle.0.vfd", 1).unwrap();
    }
    assert!(bench.get::<bool>("spindle.0.vfd.hycomm-ok"));
}
