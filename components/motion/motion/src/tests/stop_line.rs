//! The stop line: stops before everything that waits, and orders from before a stop.

use super::Rig;
use hal_component::{MotionRef, StopEpoch, abi::TicketState};

const STALE: &str = "a stop has come meanwhile: give the command again";

/// Orders, and whether one that was given before a stop, or before a pause, is refused.
const ORDERS: &[(&str, bool, bool)] = &[
    ("motion.enable", true, false),
    ("motion.mode mode=free", true, false),
    ("motion.home joint=all", true, true),
    ("motion.jog joint=0 velocity=5 distance=1", true, true),
    ("motion.jog axis=x velocity=5 distance=1", true, true),
    ("motion.move x=1 velocity=50", true, false),
    ("motion.arc x=2 center-x=1 velocity=50", true, false),
    ("motion.probe z=-1 velocity=5 optional=1", true, false),
    ("motion.spindle speed=100", true, false),
    ("motion.spindle-orient angle=10", true, false),
    ("motion.resume", true, true),
    ("motion.step", true, true),
    ("motion.reverse", true, true),
    ("motion.forward", true, true),
    ("motion.digital-out index=0 value=1", true, false),
    ("motion.analog-out index=0 value=1", true, false),
    ("motion.override-limits", true, false),
];

/// A stop: its name, what commands it, and whether it is a pause.
type Stop = (&'static str, fn(&mut Rig), bool);

/// Stops.
const STOPS: &[Stop] = &[
    ("abort", |rig| rig.done("motion.abort"), false),
    ("disable", |rig| rig.done("motion.disable"), false),
    ("pause", |rig| rig.done("motion.pause"), true),
    (
        "enable input",
        |rig| {
            rig.bench.set("motion.enable", false);
            rig.cycle();
            rig.bench.set("motion.enable", true);
            rig.cycle();
        },
        false,
    ),
    (
        "fault",
        |rig| {
            rig.bench.set("joint.0.amp-fault-in", true);
            rig.cycle();
            rig.bench.set("joint.0.amp-fault-in", false);
            rig.cycle();
        },
        false,
    ),
    (
        "limit switch",
        |rig| {
            rig.bench.set("joint.1.pos-lim-sw-in", true);
            rig.cycle();
            rig.bench.set("joint.1.pos-lim-sw-in", false);
            rig.cycle();
        },
        false,
    ),
];

fn epoch(rig: &mut Rig) -> StopEpoch {
    rig.bench.find::<MotionRef>().epoch()
}

/// A machine on which an order can be given, at rest in coordinated mode.
fn rig() -> Rig {
    let mut rig = Rig::homed(&[]);
    rig.strict = false;
    rig.done("motion.move x=5 velocity=50");
    rig
}

#[test]
fn an_order_from_before_a_stop_begins_nothing() {
    for (stop, give, is_pause) in STOPS {
        for (order, after_stop, after_pause) in ORDERS {
            let mut rig = rig();
            let given = epoch(&mut rig).number();
            give(&mut rig);
            if !rig.is("motion.motion-enabled") {
                rig.done("motion.enable");
            }
            let before = rig.places();
            rig.say(&format!("{order} epoch={given}"));
            rig.cycles(2);
            let end = rig.bench.ticket().unwrap();
            let is_stale = end == TicketState::Failed(STALE);
            let expected = if *is_pause { *after_pause } else { *after_stop };
            assert_eq!(is_stale, expected, "{stop}, {order}: {end:?}");
            if expected {
                rig.cycles(200);
                assert_eq!(rig.places(), before, "{stop}, {order}: something moves");
            }
        }
    }
}

#[test]
fn an_order_of_now_is_taken_after_every_stop() {
    for (stop, give, _) in STOPS {
        let mut rig = rig();
        give(&mut rig);
        if !rig.is("motion.motion-enabled") {
            rig.done("motion.enable");
        }
        let now = epoch(&mut rig).number();
        rig.done(&format!("motion.jog joint=1 velocity=5 distance=0.01 epoch={now}"));
        assert_ne!(rig.places()[1], 0.0, "{stop}");
    }
}

#[test]
fn a_stop_does_not_wait_behind_what_was_commanded_before() {
    for (stop, rests_at) in [("abort", 0.0), ("disable", 0.0), ("pause", 0.0)] {
        let mut rig = Rig::homed(&[]);
        for n in 0..200 {
            rig.say(&format!("motion.move x={} velocity=50", 1 + n % 2));
        }
        rig.say(&format!("motion.{stop}"));
        rig.cycles(300);
        assert_eq!(rig.places()[0], rests_at, "{stop}: nothing has moved");
        if stop == "pause" {
            // The moves were given, and go on when they may.
            rig.say("motion.resume");
            rig.cycles(300);
            assert_ne!(rig.places()[0], 0.0);
        } else if stop == "abort" {
            rig.done("motion.move x=3 velocity=50");
            assert_eq!(rig.places()[0], 3.0);
        }
    }
}

#[test]
fn a_move_brakes_in_the_cycle_after_the_stop_whatever_waits() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=100 velocity=80");
    rig.cycles(500);
    for n in 0..200 {
        rig.say(&format!("motion.move x={} velocity=80", 90 + n % 2));
    }
    let speed = |rig: &mut Rig| {
        let before = rig.places()[0];
        rig.cycle();
        rig.places()[0] - before
    };
    let before = speed(&mut rig);
    rig.say("motion.abort");
    assert!(speed(&mut rig) < before, "it brakes in the next cycle");
    rig.cycles(500);
    let at = rig.places();
    rig.cycles(500);
    assert_eq!(rig.places(), at, "and stays");
}

#[test]
fn a_pause_ends_jogs_and_homing_and_keeps_the_path() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.jog joint=0 velocity=50");
    rig.cycles(100);
    rig.done("motion.pause");
    rig.cycles(200);
    assert!(rig.is("joint.0.in-position"));
    let at = rig.places();
    rig.say("motion.resume");
    rig.cycles(200);
    assert_eq!(rig.places(), at, "a resume brings no jog back");
    rig.say("motion.move x=10 velocity=50");
    rig.done("motion.pause");
    rig.cycles(300);
    assert_eq!(rig.places(), at, "a move that was on its way rests");
    rig.say("motion.resume");
    rig.cycles(3000);
    assert_eq!(rig.places()[0], 10.0);
    // It rests in the middle of a path, goes on, and ends with an abort.
    rig.say("motion.move x=100 velocity=50");
    rig.cycles(300);
    rig.done("motion.pause");
    rig.cycles(300);
    let at = rig.places();
    rig.say("motion.move x=0 velocity=50");
    rig.cycles(300);
    assert_eq!(rig.places(), at);
    rig.done("motion.abort");
    rig.say("motion.resume");
    rig.cycles(300);
    assert_eq!(rig.places(), at, "the path is gone");
}

#[test]
fn a_flood_of_stops_is_a_stop() {
    let mut rig = Rig::homed(&[]);
    let before = epoch(&mut rig).stops;
    rig.say("motion.jog joint=0 velocity=50");
    rig.cycles(100);
    let mut full = 0;
    for _ in 0..10_000 {
        full += u32::from(rig.try_say("motion.abort").is_err());
    }
    assert_eq!(epoch(&mut rig).stops - before, 10_000);
    assert!(full > 0, "the queue is bounded");
    rig.cycles(1000);
    assert!(rig.is("joint.0.in-position"));
    rig.done("motion.jog joint=0 velocity=5 distance=1");
}
