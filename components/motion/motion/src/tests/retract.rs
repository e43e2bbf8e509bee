//! Holds in threads: the move behind the thread goes on, and nothing else.

use super::{Rig, follow::Lathe};

const THREAD: &str = "motion.move x=40 pitch=1.5";

/// Sets or ends a hold of this kind.
fn hold(rig: &Rig, kind: &str, on: bool) {
    match kind {
        "pause" => drop(rig.say(if on { "motion.pause" } else { "motion.resume" })),
        "override" => {
            let scale = u8::from(!on);
            drop(rig.say(&format!("motion.feed override={scale} rapid-override={scale}")));
        }
        pin => rig.bench.set(pin, on),
    }
}

/// Speed of the quickest axis.
fn speed(lathe: &Lathe) -> f64 {
    (0..3).map(|n| lathe.rig.joint(n, "vel-cmd").abs()).fold(0.0, f64::max)
}

/// Runs for so many cycles, and returns the highest speed of y.
fn top_of_y(lathe: &mut Lathe, cycles: usize) -> f64 {
    (0..cycles).fold(0.0, |top, _| {
        lathe.cycle();
        top.max(lathe.rig.joint(1, "vel-cmd").abs())
    })
}

/// Begins a thread with a retract behind it, and holds in it.
fn held(kind: &str, retract: &str) -> Lathe {
    let mut lathe = Lathe::new(600.0, 400.0);
    lathe.cycles(200);
    lathe.rig.say(THREAD);
    lathe.rig.say(retract);
    lathe.rig.say("motion.move x=0 rapid=1");
    lathe.until(|l| l.x() > 20.0);
    hold(&lathe.rig, kind, true);
    lathe
}

/// The axes rest at the end of the retract, also where it would blend into the next move.
#[test]
fn a_hold_takes_effect_after_the_thread_and_its_retract() {
    for retract in [
        "motion.move y=6 rapid=1 mode=exact",
        "motion.move y=6 rapid=1 mode=blend tolerance=2",
        "motion.move y=6 per-turn=2 mode=blend tolerance=2",
    ] {
        for kind in ["motion.feed-hold", "pause", "override", "motion.feed-inhibit"] {
            let mut lathe = held(kind, retract);
            lathe.cycles(3000);
            let y = if kind == "motion.feed-inhibit" { 0.0 } else { 6.0 };
            assert_eq!(lathe.rig.places(), [40.0, y, 0.0], "{kind} {retract}");
            lathe.cycles(500);
            assert_eq!(lathe.rig.places(), [40.0, y, 0.0], "{kind} {retract}");
            hold(&lathe.rig, kind, false);
            lathe.until(|l| l.rig.is("motion.in-position"));
            assert_eq!(lathe.rig.places(), [0.0, 6.0, 0.0], "{kind} {retract}");
            assert!(lathe.rig.bench.said().is_empty());
        }
    }
}

/// Nothing moves on under a hold that a thread has outlived but the retract: neither a probe move, nor what comes later,
/// nor another thread.
#[test]
fn a_hold_after_a_thread_holds_all_but_its_retract() {
    for next in [
        "motion.probe x=60 velocity=20",
        "",
        "motion.move y=6 velocity=20\nmotion.move x=60 pitch=1.5",
    ] {
        let mut lathe = Lathe::new(600.0, 400.0);
        lathe.rig.say(THREAD);
        next.lines().for_each(|line| drop(lathe.rig.say(line)));
        lathe.until(|l| l.x() > 20.0);
        lathe.rig.bench.set("motion.feed-hold", true);
        lathe.cycles(3000);
        if next.is_empty() {
            lathe.rig.say("motion.move y=6");
            lathe.cycles(500);
        }
        let place = [40.0, if next.contains("pitch") { 6.0 } else { 0.0 }, 0.0];
        assert_eq!(lathe.rig.places(), place, "{next}");
        lathe.rig.bench.set("motion.feed-hold", false);
        lathe.cycles(500);
        assert_ne!(lathe.rig.places(), place, "{next}");
    }
}

/// A retract that has to wait at the end of the thread, or that stops on its way, does not begin under the hold once the
/// cause is over.
#[test]
fn a_retract_that_rests_does_not_begin_by_itself() {
    for kind in ["motion.feed-hold", "pause"] {
        for cause in ["inhibit", "spindle", "reverse", "adaptive"] {
            for (retract, is_late) in
                [("rapid=1", false), ("velocity=5", true), ("per-turn=0.4", true)]
            {
                let what = format!("{kind} {cause} {retract}");
                // A spindle that stands keeps a thread from its end, and a move that has begun goes on without it.
                if cause == "spindle" && retract == "velocity=5" {
                    continue;
                }
                let mut lathe = Lathe::new(600.0, 400.0);
                lathe.rig.say("motion.feed adaptive=1");
                lathe.cycles(200);
                lathe.rig.say(THREAD);
                lathe.rig.say(&format!("motion.move y=6 {retract}"));
                lathe.rig.say("motion.move x=0 rapid=1");
                lathe.until(|l| l.x() > 20.0);
                hold(&lathe.rig, kind, true);
                // The thread ends at 40.
                lathe.until(|l| if is_late { l.rig.places()[1] > 2.0 } else { l.x() > 39.5 });
                let set = |lathe: &mut Lathe, on: bool| match cause {
                    "inhibit" => lathe.rig.bench.set("motion.feed-inhibit", on),
                    "spindle" if is_late => lathe.turner.is_stalled = on,
                    "spindle" => lathe.turner.acceleration = if on { 0.1 } else { 400.0 },
                    "reverse" => {
                        drop(lathe.rig.say(if on { "motion.reverse" } else { "motion.forward" }));
                    }
                    _ => lathe.rig.bench.set("motion.adaptive-feed", if on { -1.0 } else { 1.0 }),
                };
                set(&mut lathe, true);
                if cause == "spindle" && !is_late {
                    // The spindle turns, but slower than its command.
                    lathe.rig.say("motion.spindle override=0.8");
                }
                lathe.cycles(2000);
                let place = lathe.rig.places();
                let [x, y, _] = place;
                assert_eq!((x, is_late), (40.0, y != 0.0), "{what}: {y}");
                assert!(y < 6.0, "{what}: {y}");
                set(&mut lathe, false);
                lathe.cycles(2000);
                assert_eq!(lathe.rig.places(), place, "{what}");
                hold(&lathe.rig, kind, false);
                lathe.until(|l| l.rig.is("motion.in-position"));
                assert_eq!(lathe.rig.places(), [0.0, 6.0, 0.0], "{what}");
            }
        }
    }
}

/// Axes that jog away from the end of a thread, and come back, stay under another hold.
#[test]
fn a_retract_is_over_after_a_jog_away() {
    let mut lathe = held("pause", "motion.move y=6 rapid=1");
    lathe.rig.bench.set("motion.feed-inhibit", true);
    lathe.cycles(3000);
    for text in ["motion.mode mode=teleop", "motion.jog axis=z distance=1 velocity=20"] {
        lathe.rig.say(text);
        assert_eq!(lathe.end(), Ok(()), "{text}");
    }
    assert!((lathe.rig.places()[2] - 1.0).abs() < 1e-5);
    lathe.rig.bench.set("motion.feed-hold", true);
    lathe.rig.bench.set("motion.feed-inhibit", false);
    lathe.rig.say("motion.resume");
    lathe.cycles(1500);
    assert_eq!(lathe.rig.places(), [40.0, 0.0, 0.0]);
    lathe.rig.bench.set("motion.feed-hold", false);
    lathe.until(|l| l.rig.is("motion.in-position"));
    assert_eq!(lathe.rig.places(), [0.0, 6.0, 0.0]);
}

/// A retract is as quick as override and adaptive feed were last, above 0.
#[test]
fn a_retract_keeps_the_last_factor_of_the_feed() {
    for (kind, then, most) in [
        ("motion.feed-hold", "", 0.2),
        ("pause", "", 0.2),
        ("override", "", 0.2),
        ("motion.feed-hold", "slower", 0.1),
        ("motion.feed-hold", "zero", 0.2),
        ("pause", "nan", 0.2),
        ("pause", "many", 0.4),
    ] {
        for (retract, full) in [("velocity=20", 20.0), ("per-turn=2", 20.0)] {
            let mut lathe = Lathe::new(600.0, 400.0);
            lathe.rig.say("motion.feed adaptive=1 override=0.4");
            lathe.rig.bench.set("motion.adaptive-feed", 0.5);
            lathe.cycles(200);
            lathe.rig.say(THREAD);
            lathe.rig.say(&format!("motion.move y=6 {retract}"));
            lathe.until(|l| l.x() > 20.0);
            hold(&lathe.rig, kind, true);
            let adaptive = match then {
                "slower" => 0.25,
                "zero" => 0.0,
                "nan" => f64::NAN,
                "many" => 1.0,
                _ => 0.5,
            };
            lathe.rig.bench.set("motion.adaptive-feed", adaptive);
            let top = top_of_y(&mut lathe, 6000);
            assert!((top - most * full).abs() < 1e-6, "{kind} {then} {retract}: {top}");
            assert_eq!(lathe.rig.places(), [40.0, 6.0, 0.0], "{kind} {then} {retract}");
            assert_eq!(speed(&lathe), 0.0);
        }
    }
}

/// A retract that is a rapid move is as quick as the override of rapid moves was last, above 0, also if that is the hold.
#[test]
fn a_rapid_retract_keeps_the_last_override_of_rapid_moves() {
    for (kind, at_once) in [("motion.feed-hold", false), ("pause", false), ("none", true)] {
        let mut lathe = Lathe::new(600.0, 400.0);
        lathe.rig.say("motion.feed override=0.4 rapid-override=0.1");
        lathe.cycles(200);
        lathe.rig.say(THREAD);
        lathe.rig.say("motion.move y=6 rapid=1");
        lathe.until(|l| l.x() > 20.0);
        if at_once {
            lathe.rig.say("motion.feed rapid-override=0");
        } else {
            hold(&lathe.rig, kind, true);
        }
        let top = top_of_y(&mut lathe, 6000);
        assert!((top - 0.1 * 90.0).abs() < 1e-6, "{kind}: {top}");
        assert_eq!(lathe.rig.places(), [40.0, 6.0, 0.0], "{kind}");
        assert_eq!(speed(&lathe), 0.0);
    }
}
