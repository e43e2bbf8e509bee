//! Losses: the line, answers, the worker, the function, the instance.

use super::{MS, Rig};

/// Faults of the line for a time, in which the inverter is lost and stops.
const LOST: &[(&str, &str, f64)] = &[
    ("noise", "what comes is no answer", 1.0),
    ("half", "what comes is no answer", 1.0),
    ("other", "another device answers: check its number, PD163", 1.0),
    ("delay", "nothing comes", 2.0),
];

#[test]
fn a_line_that_is_cut_is_a_fault_and_nothing_starts_when_it_returns() {
    let rig = Rig::running(&[]);
    rig.forget();
    rig.set("sim.cut", true);
    let ms = rig.until("fault", true);
    assert!((480..=600).contains(&ms), "{ms}");
    assert_eq!(rig.0.failed_hardware(), 1, "motion is off");
    assert!(!rig.is("hycomm-ok") && !rig.is("spindle-at-speed"));
    assert!(rig.is("sim.running"), "no stop reaches an inverter without its own time-out");
    rig.pass(5000);
    assert!(rig.is("fault") && rig.is("sim.running"));
    rig.set("sim.cut", false);
    let ms = rig.until("sim.running", false);
    assert!(ms <= 200, "the first that it hears is a stop: {ms} ms");
    assert_eq!(rig.0.failed_hardware(), 1);
    rig.until("fault", false);
    assert_eq!(rig.0.failed_hardware(), 0);
    let said = rig.0.said().join("\n");
    assert!(said.contains("the inverter does not answer (nothing comes"), "{said}");
    assert!(said.contains("the inverter answers again: it stands until a person"), "{said}");
    rig.starts_by_a_person_alone();
}

#[test]
fn a_spindle_that_is_commanded_while_the_line_is_cut_does_not_start() {
    let rig = Rig::running(&[]);
    rig.set("sim.cut", true);
    rig.pass(1000);
    rig.set("spindle-on", false);
    rig.pass(100);
    rig.set("spindle-on", true);
    rig.pass(100);
    rig.set("sim.cut", false);
    rig.starts_by_a_person_alone();
}

#[test]
fn answers_that_are_none_for_too_long_are_a_fault() {
    for (pin, why, share) in LOST {
        let rig = Rig::running(&[]);
        rig.forget();
        rig.set(&format!("sim.{pin}"), *share);
        let ms = rig.until("fault", true);
        assert!((480..=650).contains(&ms), "{pin}: {ms}");
        rig.pass(300);
        assert!(!rig.is("sim.running"), "{pin}: it hears the stop");
        let said = rig.0.said().join("\n");
        assert!(said.contains(why), "{pin}: {said}");
        rig.pass(2000);
        assert!(0 < rig.0.get::<i32>("hy_vfd.error-count"));
        assert!(rig.get("retval") <= -12.0);
        rig.set(&format!("sim.{pin}"), 0.0);
        rig.until("fault", false);
        rig.starts_by_a_person_alone();
    }
}

#[test]
fn errors_are_counted_by_their_kind() {
    for (pin, counter) in [
        ("noise", "errors-noise"),
        ("half", "errors-noise"),
        ("other", "errors-other"),
        ("delay", "errors-silent"),
    ] {
        let rig = Rig::new(&[]);
        rig.set(&format!("sim.{pin}"), 1.0);
        rig.pass(3000);
        for kind in ["errors-noise", "errors-other", "errors-silent", "errors-wrong"] {
            // A late answer may come while something else is asked.
            let is_any = pin == "delay" && kind == "errors-wrong";
            assert!(
                is_any || (0 < rig.count(kind)) == (kind == counter),
                "{pin}: {kind} {}",
                rig.count(kind)
            );
        }
        rig.0.set("hy_vfd.error-count", 0);
        rig.pass(500);
        assert!((1..20).contains(&rig.0.get::<i32>("hy_vfd.error-count")), "it may be set");
    }
}

#[test]
fn single_losses_stop_nothing() {
    let rig = Rig::running(&[]);
    rig.set("sim.noise", 0.1);
    rig.set("sim.half", 0.1);
    rig.set("sim.other", 0.05);
    for _ in 0..60_000 {
        rig.pass(1);
        assert!(!rig.is("fault") && rig.is("sim.running"));
    }
    assert_eq!(rig.count("sim.starts"), 1);
    assert!(100 < rig.0.get::<i32>("hy_vfd.error-count"));
}

#[test]
fn the_function_stops_an_inverter_whose_worker_is_stuck() {
    for wait in 0..40 {
        let rig = Rig::running(&[]);
        rig.pass(wait);
        rig.stall(500);
        assert!(rig.is("sim.running") && !rig.is("fault"));
        rig.stall(200);
        assert!(!rig.is("sim.running") && rig.is("fault"), "after {wait} ms");
        assert_eq!(rig.0.failed_hardware(), 1, "motion is off");
        assert!(!rig.is("spindle-at-speed") && !rig.is("hycomm-ok"));
        rig.starts_by_a_person_alone();
    }
}

#[test]
fn the_worker_stops_an_inverter_whose_function_does_not_run() {
    let rig = Rig::running(&[]);
    rig.forget();
    rig.idle(300);
    rig.0.run("hy_vfd", MS);
    assert!(!rig.is("sim.running"));
    assert!(
        rig.0.said().iter().any(|text| text.contains("the function of the inverter does not run"))
    );
    rig.starts_by_a_person_alone();
}

#[test]
fn the_stop_action_of_the_instance_needs_neither_function_nor_worker() {
    for wait in 0..40 {
        let rig = Rig::running(&[]);
        rig.pass(wait);
        rig.0.stop();
        // One frame may meet an answer that is under way: a worker that lives says it again.
        rig.idle(200);
        rig.0.run("hy_vfd", MS);
        assert!(!rig.is("sim.running"), "after {wait} ms");
        rig.starts_by_a_person_alone();
    }
    // Without the worker the frame of the stop action is heard too, whatever was under way.
    for wait in 0..40 {
        let rig = Rig::running(&[]);
        rig.pass(wait);
        rig.0.stop();
        rig.stall(60);
        assert!(!rig.is("sim.running"), "after {wait} ms");
    }
}

#[test]
fn answers_that_are_late_are_taken_and_a_stop_arrives() {
    let rig = Rig::running(&[]);
    rig.set("sim.delay", 0.3);
    rig.pass(10_000);
    assert!(!rig.is("fault") && rig.is("sim.running"));
    assert_eq!(rig.count("sim.starts"), 1);
    rig.set("spindle-on", false);
    let ms = rig.until("sim.running", false);
    assert!(ms <= 300, "{ms} ms");
    rig.pass(5000);
    assert!(!rig.is("sim.running"));
}

#[test]
fn an_inverter_with_its_own_time_out_stops_by_its_own_clock() {
    let rig = Rig::running(&[]);
    rig.set("sim.timeout", 1.0);
    rig.pass(5000);
    assert!(rig.is("sim.running"), "the command is sent anew in each round");
    rig.set("sim.cut", true);
    rig.pass(900);
    assert!(rig.is("sim.running"));
    rig.pass(300);
    assert!(!rig.is("sim.running"));
    rig.set("sim.cut", false);
    rig.starts_by_a_person_alone();
}

#[test]
fn a_gap_in_time_stops_the_spindle() {
    let rig = Rig::running(&[]);
    rig.0.gap();
    rig.pass(100);
    assert!(!rig.is("sim.running"));
    rig.starts_by_a_person_alone();
}

#[test]
fn an_inverter_that_trips_stands_also_after_its_reset() {
    for wait in 0..40 {
        let rig = Rig::running(&[]);
        rig.forget();
        rig.pass(5 * wait);
        rig.set("sim.trip", true);
        rig.pass(250);
        let said = rig.0.said().join("\n");
        assert!(said.contains("the inverter has stopped by itself, as after a trip"), "{said}");
        rig.pass(500);
        assert_eq!((rig.get("OutF"), rig.is("spindle-at-speed")), (0.0, false));
        assert!(!rig.is("fault"), "it answers");
        rig.set("sim.trip", false);
        rig.starts_by_a_person_alone();
    }
}

#[test]
fn a_turn_into_the_other_direction_is_no_trip() {
    let rig = Rig::running(&[]);
    rig.forget();
    for (forward, reverse) in [(false, true), (true, false)] {
        rig.set("spindle-forward", forward);
        rig.set("spindle-reverse", reverse);
        rig.pass(6000);
        assert!(rig.is("spindle-at-speed") && rig.is("CNST-running-rf") == reverse);
    }
    assert_eq!(rig.0.said(), [""; 0]);
}

/// The inverter runs by the command of a process that was killed.
#[test]
fn the_first_that_an_inverter_hears_after_the_load_is_a_stop() {
    let mut bench = hal_bench::Bench::new();
    bench.load::<super::HyVfd>(&[]).unwrap();
    let rig = Rig(bench);
    rig.set("sim.cut", true);
    rig.pass(2000);
    assert_eq!((rig.count("sim.frames"), rig.is("fault")), (0, false));
    rig.set("sim.cut", false);
    rig.pass(2000);
    assert_eq!((rig.count("sim.frames"), rig.is("fault")), (1, false), "one that is answered");
}

/// Nothing is asked of the inverter while its worker stands still.
#[test]
fn a_worker_that_goes_on_is_no_fault_of_the_inverter() {
    let rig = Rig::new(&[]);
    rig.forget();
    for _ in 0..20 {
        for _ in 0..490 {
            rig.0.pass(MS);
        }
        rig.pass(20);
        rig.0.pass(600 * MS);
        rig.0.work("hy_vfd", 1).unwrap();
        rig.pass(1);
        assert!(!rig.is("fault"));
    }
    assert!(!rig.0.said().join("\n").contains("does not answer"));
}

#[test]
fn an_inverter_that_was_never_there_is_a_fault_only_while_it_is_enabled() {
    let mut bench = hal_bench::Bench::new();
    bench.load::<super::HyVfd>(&[]).unwrap();
    let rig = Rig(bench);
    rig.set("sim.cut", true);
    rig.pass(3000);
    assert!(!rig.is("fault"));
    rig.set("enable", true);
    let ms = rig.until("fault", true);
    assert!((500..=510).contains(&ms), "{ms}");
    assert!(rig.0.said().join("\n").contains("does not answer (nothing comes"));
    rig.set("enable", false);
    rig.pass(10);
    assert_eq!((rig.is("fault"), rig.0.failed_hardware()), (false, 0));
    // One that may turn is a fault whatever is enabled.
    let rig = Rig::running(&[]);
    rig.set("sim.cut", true);
    rig.set("enable", false);
    rig.pass(700);
    assert!(rig.is("fault") && rig.is("sim.running"));
    rig.set("sim.cut", false);
    rig.pass(300);
    assert!(!rig.is("fault") && !rig.is("sim.running"));
}
