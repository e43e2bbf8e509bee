//! Devices that are lost and come back.

use super::{
    events::is_down,
    fake::{FakeBus, MS, known, load, step, try_load},
};
use crate::show::DEAD_NS;
use hal_bench::Bench;

/// Lets a second pass, in which lost devices are looked for.
fn second(bench: &Bench) {
    for _ in 0..4 {
        bench.pass(250 * MS);
        step(bench);
    }
}

/// Returns the pins of the first X-Box pad: connected, fault, A, and two axes.
fn shown(bench: &Bench) -> (bool, bool, bool, f64, f64) {
    let get = |pin: &str| bench.get::<f64>(&format!("input.0.abs-{pin}-position"));
    let bit = |pin: &str| bench.get::<bool>(&format!("input.0.{pin}"));
    let a = is_down(bench, "input.0.btn-a");
    (bit("connected"), bit("fault"), a, get("x"), get("hat0y"))
}

const REST: (bool, bool, bool, f64, f64) = (true, false, false, 0.0, 0.0);
const LOST: (bool, bool, bool, f64, f64) = (false, true, false, 0.0, 0.0);

/// Each way to lose a device, by the error number of its accesses; 0 takes the device away.
#[test]
fn a_lost_device_holds_nothing_in_the_next_cycle() {
    for number in [0, 5, 19, 110] {
        let (bus, bench) = load(&["X-Box"]);
        bus.send(0, "btn-a 1, abs-x 32767, abs-hat0y -1");
        step(&bench);
        assert_eq!(shown(&bench), (true, false, true, 1.0, -1.0));
        drop(bench.said());
        if number == 0 {
            bus.unplug(0);
        } else {
            bus.with(0, |device| device.fails = Some(number));
        }
        step(&bench);
        assert_eq!(shown(&bench), LOST, "{number}");
        assert_eq!(bench.get::<i32>("input.0.abs-x-counts"), 0);
        second(&bench);
        assert_eq!(shown(&bench), LOST, "{number}");
        let said = bench.said();
        assert_eq!(said.len(), 1, "{said:?}");
        let text = "input.0: 'Microsoft X-Box 360 pad' is lost, because its node cannot be read: its buttons are \
                    FALSE, its axes at their centres";
        assert!(said[0].contains(text), "{said:?}");
    }
}

#[test]
fn what_is_held_when_a_device_comes_back_has_no_effect() {
    let (bus, bench) = load(&["X-Box"]);
    bus.send(0, "btn-a 1, abs-x 32767");
    step(&bench);
    let device = bus.unplug(0);
    step(&bench);
    // It comes back as it was held.
    bus.plug(0, device);
    step(&bench);
    assert_eq!(shown(&bench), LOST, "the loss is seen for a while");
    second(&bench);
    assert_eq!(shown(&bench), REST);
    for (events, want) in [
        ("btn-a 2", REST),
        ("abs-x 30000", REST),
        ("btn-b 1", REST),
        ("abs-x 3000", REST),
        ("abs-x 2000", (true, false, false, 2000.5 / 32_767.5, 0.0)),
        ("abs-x 32767", (true, false, false, 1.0, 0.0)),
        ("btn-a 0", (true, false, false, 1.0, 0.0)),
        ("btn-a 1", (true, false, true, 1.0, 0.0)),
        ("btn-a 0, abs-x 0, abs-hat0y 1", (true, false, false, 0.0, 1.0)),
    ] {
        bus.send(0, events);
        step(&bench);
        assert_eq!(shown(&bench), want, "{events}");
    }
    assert!(is_down(&bench, "input.0.btn-b"), "it was pressed after the device came back");
}

/// A key that is down at the load has no effect; axes have their values.
#[test]
fn the_first_state() {
    let bus = FakeBus::default();
    let mut pad = known("X-Box");
    super::fake::hold(&mut pad.held, super::fake::event_of("btn-a 1"));
    pad.held.abs[0] = -32_768;
    bus.plug(0, pad);
    let bench = try_load(&bus, &["X-Box"]).unwrap();
    assert_eq!(shown(&bench), (false, false, false, 0.0, 0.0), "before the first cycle");
    step(&bench);
    assert_eq!(shown(&bench), (true, false, false, -1.0, 0.0));
    bus.send(0, "btn-a 0 | btn-a 1");
    step(&bench);
    assert!(!is_down(&bench, "input.0.btn-a"), "no cycle has seen it released");
    bus.send(0, "btn-a 0");
    step(&bench);
    bus.send(0, "btn-a 1");
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-a"));
}

/// The loss and the return between two cycles of the function are seen, too.
#[test]
fn a_short_loss_is_a_loss() {
    let (bus, bench) = load(&["X-Box"]);
    bus.send(0, "btn-a 1");
    step(&bench);
    let device = bus.unplug(0);
    bench.work("hal_input", 1).unwrap();
    bus.plug(0, device);
    bench.pass(500 * MS);
    // The function was not called meanwhile; the worker's steps count as its life.
    bench.work("hal_input", 1).unwrap();
    bench.run("hal_input", MS);
    assert_eq!(shown(&bench), REST);
}

#[test]
fn wheels_keep_their_counts_and_rings_do_not() {
    let (bus, bench) = load(&["PRO v2"]);
    let counts = || {
        let get = |pin: &str| bench.get::<i32>(&format!("input.0.rel-{pin}-counts"));
        (get("dial"), get("wheel"))
    };
    bus.send(0, "rel-dial 10 | rel-dial 15, rel-wheel 4");
    step(&bench);
    assert_eq!(counts(), (5, 4));
    let device = bus.unplug(0);
    step(&bench);
    assert_eq!(counts(), (5, 0));
    bus.plug(0, device);
    second(&bench);
    for (events, want) in [
        ("rel-dial 200, rel-wheel 4", (5, 0)),
        ("rel-dial 201, rel-wheel 5", (6, 0)),
        ("rel-dial 202, rel-wheel -1", (7, 0)),
        ("rel-dial 202", (7, 0)),
        ("rel-dial 202, rel-wheel 1", (7, 1)),
    ] {
        bus.send(0, events);
        step(&bench);
        assert_eq!(counts(), want, "{events}");
    }
}

#[test]
fn a_worker_that_does_not_work_is_a_loss_of_all_devices() {
    let (bus, bench) = load(&["X-Box"]);
    bus.send(0, "btn-a 1, abs-x 32767");
    step(&bench);
    drop(bench.said());
    bench.pass(DEAD_NS - MS);
    bench.run("hal_input", MS);
    assert_eq!(shown(&bench), (true, false, true, 1.0, 0.0));
    bench.pass(2 * MS);
    bench.run("hal_input", MS);
    assert_eq!(shown(&bench), LOST);
    bench.run("hal_input", MS);
    let said = bench.said();
    let text =
        "the worker of hal_input does not work: all buttons are FALSE, all axes at their centres";
    assert!(said.len() == 1 && said[0].contains(text), "{said:?}");
    step(&bench);
    assert_eq!(shown(&bench), REST, "what is held has no effect");
}

#[test]
fn a_required_device_switches_motion_off() {
    let (bus, bench) = load(&["X-Box", "Mouse"]);
    let device = bus.unplug(0);
    step(&bench);
    assert_eq!(bench.failed_hardware(), 0);
    bench.set("input.0.required", true);
    step(&bench);
    assert_eq!(bench.failed_hardware(), 1);
    bus.plug(0, device);
    second(&bench);
    assert_eq!(bench.failed_hardware(), 0);
}

/// Two devices of a make: each is found again where it was, and nowhere else.
#[test]
fn devices_of_one_make_do_not_take_each_others_place() {
    let (bus, bench) = load(&["X-Box", "X-Box", "Mouse"]);
    let connected = || [0, 1, 2].map(|n| bench.get::<bool>(&format!("input.{n}.connected")));
    let first = bus.unplug(0);
    let second_pad = bus.unplug(1);
    step(&bench);
    assert_eq!(connected(), [false, false, true]);
    // The second comes back with another number, in its own place.
    bus.plug(5, second_pad.clone());
    second(&bench);
    assert_eq!(connected(), [false, true, true]);
    // The first is plugged in elsewhere, which could be any pad.
    let mut elsewhere = first.clone();
    elsewhere.identity.phys = "usb-9".to_owned();
    bus.plug(6, elsewhere);
    second(&bench);
    assert_eq!(connected(), [false, true, true]);
    bus.unplug(6);
    bus.plug(7, first);
    second(&bench);
    assert_eq!(connected(), [true, true, true]);
    bus.send(7, "btn-a 1");
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-a") && !is_down(&bench, "input.1.btn-a"));
    // A device without another one of its make may be plugged in anywhere.
    let mut mouse = bus.unplug(2);
    step(&bench);
    mouse.identity.phys = "usb-11".to_owned();
    bus.plug(8, mouse);
    second(&bench);
    assert_eq!(connected(), [true, true, true]);
}

/// A device of the same make that lacks a button does not take its place.
#[test]
fn a_device_that_lacks_something_is_another_one() {
    let (bus, bench) = load(&["X-Box"]);
    let mut device = bus.unplug(0);
    step(&bench);
    let last = device.abilities.keys.pop().unwrap();
    bus.plug(0, device.clone());
    second(&bench);
    assert!(!bench.get::<bool>("input.0.connected"));
    device.abilities.keys.push(last);
    bus.plug(0, device);
    second(&bench);
    assert!(bench.get::<bool>("input.0.connected"));
}

/// Returns the numbers of the devices that are connected.
fn connected(bench: &Bench, count: usize) -> Vec<usize> {
    let is = |n: &usize| bench.get::<bool>(&format!("input.{n}.connected"));
    (0..count).filter(is).collect()
}

/// Pads over Bluetooth: their place is the address of the computer's adapter. With addresses of their own they are told
/// apart; without, they come back together.
#[test]
fn pads_in_one_place_do_not_take_each_others_place() {
    for uniq in [["", ""], ["1c:66:6d:00:00:01", "1c:66:6d:00:00:02"]] {
        for phys in ["", "00:1a:7d:da:71:13"] {
            let bus = FakeBus::default();
            for (at, uniq) in uniq.iter().enumerate() {
                let mut pad = known("X-Box");
                (pad.identity.phys, pad.identity.uniq) = (phys.to_owned(), (*uniq).to_owned());
                bus.plug(at, pad);
            }
            let bench = try_load(&bus, &["-K X-Box:0", "X-Box:1", "-A X-Box:0"]).unwrap();
            step(&bench);
            let first = bus.unplug(0);
            second(&bench);
            assert_eq!(connected(&bench, 3), [1], "the second pad stays that of its pins");
            bus.plug(4, first.clone());
            second(&bench);
            assert_eq!(connected(&bench, 3), [0, 1, 2]);
            bus.send(4, "btn-a 1");
            bus.send(1, "btn-b 1");
            step(&bench);
            assert!(is_down(&bench, "input.0.btn-a") && is_down(&bench, "input.1.btn-b"));
            assert!(!is_down(&bench, "input.0.btn-b") && !is_down(&bench, "input.1.btn-a"));
            // Both are lost, and one comes back.
            drop((bus.unplug(4), bus.unplug(1)));
            step(&bench);
            bus.plug(6, first.clone());
            second(&bench);
            let alone: &[usize] = if uniq[0].is_empty() { &[] } else { &[0, 2] };
            assert_eq!(connected(&bench, 3), alone, "{uniq:?}");
            let mut other = first;
            uniq[1].clone_into(&mut other.identity.uniq);
            bus.plug(5, other);
            second(&bench);
            assert_eq!(connected(&bench, 3), [0, 1, 2]);
        }
    }
}

/// Each row: the specification, the error number of the opening, that of the accesses, whether a button is missing, and the
/// text. A device that is there again and cannot be used is named once for each loss, however often it is refused.
#[test]
fn a_device_that_is_refused_after_a_loss_is_named_once() {
    const GROUP: &str = "the user may not open its node: run as a user in group input (usermod -aG input NAME, then \
                         log in again)";
    const KEPT: &str = "another program, or another word of devices=, keeps its events for itself: end that program, \
                        or leave out the +";
    const BUSY: &str = "its node cannot be read (Device or resource busy (os error 16))";
    const BROKEN: &str = "its node cannot be read (Input/output error (os error 5))";
    for (spec, refuses, breaks, lacks, why) in [
        ("X-Box", Some(13), None, false, GROUP),
        ("+X-Box", Some(1), None, false, GROUP),
        ("+X-Box", Some(16), None, false, KEPT),
        ("X-Box", Some(16), None, false, BUSY),
        ("X-Box", None, Some(5), false, BROKEN),
        ("+X-Box", None, None, true, "it lacks a button or an axis that has a pin"),
    ] {
        let bus = FakeBus::default();
        bus.plug(0, known("X-Box"));
        let bench = try_load(&bus, &[spec]).unwrap();
        step(&bench);
        for _ in 0..2 {
            drop(bench.said());
            let pad = bus.unplug(0);
            step(&bench);
            let mut refused = pad.clone();
            (refused.refuses, refused.breaks) = (refuses, breaks);
            if lacks {
                refused.abilities.keys.pop();
            }
            bus.plug(0, refused);
            for _ in 0..5 {
                second(&bench);
            }
            let said = bench.said();
            assert_eq!(said.len(), 2, "{said:?}");
            assert!(said[0].contains("input.0: 'Microsoft X-Box 360 pad' is lost"), "{said:?}");
            let text = format!(
                "input.0: 'Microsoft X-Box 360 pad' is there again, but cannot be used: {why}"
            );
            assert!(said[1].ends_with(&text), "{said:?}");
            bus.plug(0, pad);
            second(&bench);
            let said = bench.said();
            let back = "input.0: 'Microsoft X-Box 360 pad' is back; what is held on it has no effect until it is let go";
            assert!(said.len() == 1 && said[0].ends_with(back), "{said:?}");
        }
    }
}

/// The right to open a node comes a moment after the node.
#[test]
fn a_device_that_is_refused_for_a_moment_is_not_named() {
    let (bus, bench) = load(&["X-Box"]);
    let pad = bus.unplug(0);
    step(&bench);
    drop(bench.said());
    let mut refused = pad.clone();
    refused.refuses = Some(13);
    bus.plug(0, refused);
    bench.pass(500 * MS);
    step(&bench);
    bus.plug(0, pad);
    second(&bench);
    let said = bench.said();
    assert!(said.len() == 1 && said[0].contains("is back"), "{said:?}");
}
