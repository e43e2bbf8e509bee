//! Events to pins.

use super::fake::{FakeBus, event_of, hold, known, load, step, try_load};
use hal_bench::Bench;

/// Returns whether a button is down; its opposite must be that.
pub(super) fn is_down(bench: &Bench, pin: &str) -> bool {
    let down = bench.get::<bool>(pin);
    assert_eq!(bench.get::<bool>(&format!("{pin}-not")), !down, "{pin}");
    down
}

#[test]
fn buttons() {
    let (bus, bench) = load(&["X-Box"]);
    for (events, a, b) in [
        ("", false, false),
        ("btn-a 1", true, false),
        ("btn-b 1", true, true),
        // A repetition is no second press.
        ("btn-a 2", true, true),
        ("btn-a 0", false, true),
        ("btn-a 1 | btn-a 0", false, true),
        ("btn-b 0 | btn-b 1", false, true),
        ("btn-b 0, btn-a 1", true, false),
    ] {
        bus.send(0, events);
        step(&bench);
        let is = (is_down(&bench, "input.0.btn-a"), is_down(&bench, "input.0.btn-b"));
        assert_eq!(is, (a, b), "{events}");
    }
    assert!(bench.get::<bool>("input.0.connected") && !bench.get::<bool>("input.0.fault"));
}

/// The kernel's answer counts, not the rest of the events.
#[test]
fn lost_events_make_the_driver_ask_for_the_state() {
    let (bus, bench) = load(&["X-Box"]);
    let down = |pin: &str| is_down(&bench, &format!("input.0.{pin}"));
    bus.send(0, "btn-a 1, btn-b 1, abs-hat0x 1");
    step(&bench);
    bus.with(0, |device| {
        // Meanwhile, A was released and X pressed; the events are a part of what came.
        for event in ["btn-a 0", "btn-x 1", "abs-hat0x 0"] {
            hold(&mut device.held, event_of(event));
        }
        device.waiting.extend(["btn-b 0", "dropped", "btn-y 1"].map(event_of));
    });
    step(&bench);
    // The packet has no end yet: nothing of it counts but what came before.
    assert_eq!(
        [down("btn-a"), down("btn-b"), down("btn-x"), down("btn-y")],
        [true, false, false, false]
    );
    bus.with(0, |device| device.waiting.push_back(crate::event::InputEvent::REPORT));
    step(&bench);
    assert_eq!(
        [down("btn-a"), down("btn-b"), down("btn-x"), down("btn-y")],
        [false, true, true, false]
    );
    assert_eq!(bench.get::<f64>("input.0.abs-hat0x-position"), 0.0);
    bus.send(0, "btn-y 1");
    step(&bench);
    assert!(down("btn-y"), "events count again");
}

#[test]
fn lights_are_switched_when_they_change_and_when_the_device_comes_back() {
    let (bus, bench) = load(&["keyboard"]);
    let lit = |bus: &FakeBus| bus.with(0, |device| core::mem::take(&mut device.lit));
    assert_eq!(lit(&bus), [(0, false), (1, false), (2, false)]);
    bench.set("input.0.led-numl", true);
    for _ in 0..3 {
        step(&bench);
    }
    assert_eq!(lit(&bus), [(0, true)]);
    bench.set("input.0.led-numl-invert", true);
    bench.set("input.0.led-capsl-invert", true);
    step(&bench);
    step(&bench);
    assert_eq!(lit(&bus), [(0, false), (1, true)]);
    let device = bus.unplug(0);
    step(&bench);
    bus.plug(0, device);
    bench.pass(1_000_000_000);
    step(&bench);
    step(&bench);
    assert_eq!(lit(&bus), [(0, false), (1, true), (2, false)]);
}

/// Lights that cannot be switched are named when one is to be on, once for each change; all are switched when they can be.
#[test]
fn lights_that_cannot_be_switched() {
    let bus = FakeBus::default();
    let mut keyboard = known("keyboard");
    keyboard.is_dark = true;
    bus.plug(0, keyboard);
    let bench = try_load(&bus, &["keyboard"]).unwrap();
    let warned = |bench: &Bench| {
        step(bench);
        step(bench);
        let said = bench.said();
        let text = "input.0: 'AT Translated Set 2 keyboard': its lights cannot be switched: may the user write to its \
                    node?";
        assert!(said.iter().all(|line| line.contains(text)), "{said:?}");
        said.len()
    };
    assert_eq!(warned(&bench), 0, "no light is to be on");
    bench.set("input.0.led-numl", true);
    assert_eq!(warned(&bench), 1);
    bench.set("input.0.led-capsl", true);
    assert_eq!(warned(&bench), 1);
    bus.with(0, |device| device.is_dark = false);
    bench.set("input.0.led-scrolll", true);
    assert_eq!(warned(&bench), 0);
    bus.with(0, |device| assert_eq!(device.lit, [(0, true), (1, true), (2, true)]));
    // A light that stays on is named as well.
    bus.with(0, |device| device.is_dark = true);
    bench.set("input.0.led-numl", false);
    assert_eq!(warned(&bench), 1);
}

/// A step takes a bounded number of events; the others wait.
#[test]
fn a_flood_of_events_does_not_hold_a_step() {
    let (bus, bench) = load(&["PowerMate"]);
    for _ in 0..2000 {
        bus.send(0, "rel-dial 1");
    }
    step(&bench);
    let first = bench.get::<i32>("input.0.rel-dial-counts");
    assert!(0 < first && first < 2000, "{first}");
    for _ in 0..10 {
        step(&bench);
    }
    assert_eq!(bench.get::<i32>("input.0.rel-dial-counts"), 2000);
}
