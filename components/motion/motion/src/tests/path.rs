//! Paths: arcs, blends, outputs on the way, pauses, steps, reverse motion, and refusals before anything moves.

use super::{DT, LIMITS, Rig};
use hal_component::MotionStatus;
use hal_component::abi::TicketState;

impl Rig {
    pub(super) fn status(&self) -> MotionStatus {
        self.bench.snapshot("motion.status")
    }

    /// Runs cycles until nothing waits; returns their number.
    fn finish(&mut self) -> usize {
        for n in 0..200_000 {
            if n > 1 && self.is("motion.in-position") {
                return n;
            }
            self.cycle();
        }
        panic!("never ends: {:?}", self.status())
    }
}

#[test]
fn pins_and_snapshot_tell_about_the_current_move() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.arc center-x=20 velocity=30 line=7");
    rig.say("motion.tool-offset z=-12.5 x=0.25");
    rig.begin();
    rig.cycles(5);
    let (slow, up) = (rig.float("tc.0.vel"), rig.float("tc.0.acc"));
    rig.cycle();
    assert!(
        up > 100.0 && (rig.float("tc.0.acc") - (rig.float("tc.0.vel") - slow) / DT).abs() < 1e-6
    );
    rig.cycles(494);
    assert!(rig.is("motion.interp.iscircle") && rig.float("tc.0.acc").abs() < 1e-6);
    assert_eq!(rig.float("motion.interp.feedrate"), 30.0);
    assert_eq!(rig.bench.get::<i32>("motion.interp.line-number"), 7);
    assert_eq!(rig.bench.get::<i32>("motion.interp.motion-type"), 3);
    assert_eq!(rig.bench.get::<u32>("traj.active_tc"), 1);
    let center = ["x", "y", "z"].map(|l| rig.float(&format!("motion.interp.arc-center-{l}")));
    assert_eq!((center, rig.float("motion.interp.arc-radius")), ([20.0, 0.0, 0.0], 20.0));
    let [x, y, _] = rig.places();
    let along = (x - 20.0).atan2(-y).to_degrees();
    let off = (rig.float("motion.interp.heading") - along).rem_euclid(360.0);
    assert!(!(0.1..=359.9).contains(&off), "{off}");
    let left = rig.float("motion.interp.normal-heading") - rig.float("motion.interp.heading");
    assert!((left.rem_euclid(360.0) - 90.0).abs() < 1e-9 && along.abs() > 1.0);
    let (gone, left) = (rig.float("tc.0.pos"), rig.float("motion.distance-to-go"));
    assert!(gone > 10.0 && (gone + left - 40.0 * core::f64::consts::PI).abs() < 1e-6);
    assert_eq!(rig.float("traj.pos_out"), gone);
    assert!((rig.float("traj.vel_out") - 30.0).abs() < 1e-6);
    assert_eq!(rig.float("motion.tooloffset.z"), 0.0);
    rig.finish();
    assert_eq!((rig.float("motion.tooloffset.z"), rig.float("motion.tooloffset.x")), (-12.5, 0.25));
    assert_eq!(rig.status().tool_offset[2], -12.5);
    assert!(!rig.is("motion.interp.iscircle") && rig.float("tc.0.vel") == 0.0);
}

/// A square of 20 mm in the plane, from 0 back to 0.
const SQUARE: [&str; 4] = ["x=20 y=0", "x=20 y=20", "x=0 y=20", "x=0 y=0"];

#[test]
fn arcs_and_helices_stay_on_their_circle() {
    let mut rig = Rig::homed(&[]);
    for (text, turns, rise) in [
        ("motion.arc center-x=20 velocity=30 line=7", 1.0, 0.0),
        ("motion.arc center-x=20 center-y=0 x=40 velocity=30 clockwise=1", 0.5, 0.0),
        ("motion.arc center-x=20 x=0 z=3 turns=1 velocity=30", 1.5, 3.0),
        ("motion.arc center-x=20 z=0 time=9", 1.0, -3.0),
    ] {
        let ([x0, ..], z0) = (rig.places(), rig.places()[2]);
        let mut angle = 0.0_f64;
        let mut last = 0.0_f64.atan2(x0 - 20.0);
        rig.say(text);
        let mut cycles = 0;
        while rig.bench.ticket() == Some(TicketState::Pending) {
            rig.cycle();
            cycles += 1;
            assert!(cycles < 30_000, "{text} never ends");
            let [x, y, z] = rig.places();
            let off = (x - 20.0).hypot(y) - 20.0;
            assert!(off.abs() < 1e-9, "{text}: {off} off the circle");
            let now = y.atan2(x - 20.0);
            let by = now - last;
            angle += by - (by / core::f64::consts::TAU).round() * core::f64::consts::TAU;
            last = now;
            let share = angle.abs() / core::f64::consts::TAU / turns;
            assert!((z - z0 - rise * share).abs() < 1e-6, "{text}: z {z} at {share}");
            if rig.is("motion.motion-enabled") && rig.float("motion.current-vel") > 1.0 {
                assert_eq!(rig.bench.get::<i32>("motion.motion-type"), 3);
            }
        }
        assert_eq!(rig.end(), Ok(()), "{text}");
        let all = angle.abs() / core::f64::consts::TAU;
        assert!((all - turns).abs() < 1e-9, "{text}: {all} turns");
        assert_eq!(angle < 0.0, text.contains("clockwise=1"), "{text}");
        if text.contains("time=9") {
            let took = f64::from(cycles) * DT;
            assert!((9.0..9.3).contains(&took), "{took} s");
        }
    }
}

/// Blends are faster than stops, stay within their tolerance of the corner, and do not come to rest.
#[test]
fn corners_are_blended_within_their_tolerance() {
    let mut times = Vec::new();
    for (mode, tolerance) in [("stop", 0.0), ("exact", 0.002), ("blend tolerance=0.5", 0.5)] {
        let mut rig = Rig::homed(&[]);
        for (n, to) in SQUARE.iter().enumerate() {
            rig.say(&format!("motion.move {to} velocity=80 line={n} mode={mode}"));
        }
        let mut slowest = f64::INFINITY;
        let (mut nearest, mut seen) = (f64::INFINITY, 0);
        let mut lines = Vec::new();
        rig.begin();
        let cycles = {
            let mut n = 0;
            while !rig.is("motion.in-position") {
                rig.cycle();
                n += 1;
                let [x, y, _] = rig.places();
                let inside = |v: f64| (-1e-9..=20.0 + 1e-9).contains(&v);
                assert!(inside(x) && inside(y), "{mode}: {x} {y}");
                // Distance from the square.
                let off = x.min(20.0 - x).min(y).min(20.0 - y);
                assert!(off <= tolerance + 1e-9, "{mode}: {off} off the path");
                let corner = (x - 20.0).hypot(y - 20.0);
                nearest = nearest.min(corner);
                if corner < 5.0 {
                    slowest = slowest.min(rig.float("motion.current-vel"));
                    seen += 1;
                }
                lines.push(rig.bench.get::<i32>("motion.program-line"));
                assert!(n < 20_000, "{mode} never ends");
            }
            n
        };
        lines.dedup();
        assert_eq!(lines, [0, 1, 2, 3, 0], "{mode}");
        assert!(seen > 10 && nearest < 2.0 * tolerance + 1e-9, "{mode}: {nearest}");
        // An exact stop passes the corner itself, and what moves in the cycles beside it only begins or ends.
        assert_eq!(nearest < 1e-9, mode == "stop", "{mode}: {nearest}");
        assert!(mode != "stop" || slowest < 0.5 * LIMITS[0].1 * DT, "{mode}: {slowest}");
        assert_eq!(rig.places(), [0.0; 3]);
        times.push(cycles);
    }
    assert!(times[2] < times[1] && times[1] < times[0], "{times:?}");
}

/// A program that pauses its moves while enough of them wait does not slow the axes down, in a bend that takes all of
/// the acceleration either.
#[test]
fn moves_that_come_in_batches_are_one_path() {
    let mut rig = Rig::homed(&[]);
    let (mut sent, mut slowest, mut travelled) = (0, f64::INFINITY, 0.0);
    while travelled < 80.0 {
        let status: MotionStatus = rig.bench.snapshot("motion.status");
        if status.queue < 200 {
            for n in 0..200 {
                sent += 1;
                if n % 20 == 0 {
                    rig.cycle();
                    travelled += rig.float("motion.current-vel") * DT;
                }
                let (sin, cos) = (f64::from(sent) * 0.02).sin_cos();
                let (x, y) = (5.0 * sin, 5.0 - 5.0 * cos);
                rig.say(&format!("motion.move x={x} y={y} velocity=90 mode=blend tolerance=0.01"));
            }
        }
        rig.cycles(5);
        let speed = rig.float("motion.current-vel");
        travelled += speed * 5.0 * DT;
        if travelled > 10.0 {
            slowest = f64::min(slowest, speed);
        }
    }
    // All of the acceleration gives 82 units/s.
    assert!(slowest > 70.0, "{slowest}");
}

/// Q of G64: short lines are joined within the larger of both tolerances.
#[test]
fn a_cam_tolerance_widens_a_small_tolerance() {
    let mut cycles = Vec::new();
    for text in ["tolerance=0.01", "tolerance=0.01 cam-tolerance=0.2", "tolerance=0.2"] {
        let mut rig = Rig::homed(&[]);
        for n in 1..30 {
            // A zigzag of 0.3 mm, which joins to a line.
            let y = if n % 2 == 0 { 0.0 } else { 0.15 };
            let x = f64::from(n);
            rig.say(&format!("motion.move x={x} y={y} velocity=80 mode=blend {text}"));
        }
        cycles.push(rig.finish());
    }
    assert!(cycles[1] == cycles[2] && cycles[1] < cycles[0] * 9 / 10, "{cycles:?}");
    let rig = Rig::homed(&[]);
    assert!(rig.try_say("motion.move x=1 mode=blend tolerance=1 cam-tolerance=-1").is_err());
}

#[test]
fn outputs_change_when_the_motion_gets_there_without_a_stop() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.digital-out index=0 value=1 sync=1");
    rig.say("motion.move x=10 velocity=40 mode=blend tolerance=0.1");
    rig.say("motion.digital-out index=1 value=1 sync=1");
    rig.say("motion.analog-out index=2 value=2.5 sync=1");
    rig.say("motion.move x=20 velocity=40 mode=blend tolerance=0.1");
    rig.say("motion.digital-out index=1 value=0 sync=1");
    rig.cycles(2);
    assert!(rig.is("motion.digital-out-00"));
    assert!(!rig.is("motion.digital-out-01"));
    let mut at = f64::NAN;
    for _ in 0..10_000 {
        rig.cycle();
        if rig.is("motion.digital-out-01") {
            at = rig.places()[0];
            break;
        }
    }
    assert!((at - 10.0).abs() < 0.2, "{at}");
    assert!(rig.float("motion.current-vel") > 39.0, "no stop");
    assert_eq!(rig.float("motion.analog-out-02"), 2.5);
    assert_eq!((rig.status().digital_out, rig.status().analog_out[2]), (0b11, 2.5));
    rig.finish();
    assert!(!rig.is("motion.digital-out-01"));
    assert_eq!(rig.places()[0], 20.0);
}

#[test]
fn pause_resume_and_single_steps() {
    let mut rig = Rig::homed(&[]);
    for (n, to) in SQUARE.iter().enumerate() {
        rig.say(&format!("motion.move {to} velocity=40 line={n} mode=blend tolerance=1"));
    }
    rig.begin();
    rig.cycles(100);
    rig.say("motion.pause");
    rig.cycles(200);
    let held = rig.places();
    assert!(held[0] > 1.0 && rig.float("motion.current-vel") == 0.0);
    assert!(rig.status().paused && !rig.is("motion.in-position"));
    assert_eq!(
        rig.failed("motion.mode mode=free"),
        "the mode cannot change while the machine moves"
    );
    rig.cycles(500);
    assert_eq!(rig.places(), held);
    // Each step ends shortly after the next line has begun.
    for line in 1..4 {
        rig.say("motion.step");
        rig.cycles(1500);
        assert_eq!(rig.bench.get::<i32>("motion.program-line"), line);
        assert_eq!(rig.float("motion.current-vel"), 0.0, "line {line}");
        assert!(!rig.is("motion.in-position"));
    }
    rig.say("motion.resume");
    rig.finish();
    assert_eq!(rig.places(), [0.0; 3]);
    assert!(rig.failed("motion.step").contains("no move waits"));
}

#[test]
fn back_along_the_path_and_forward_again() {
    let mut rig = Rig::homed(&[]);
    for to in SQUARE {
        rig.say(&format!("motion.move {to} velocity=40 mode=blend tolerance=1"));
    }
    rig.begin();
    let mut went = Vec::new();
    while rig.bench.get::<i32>("motion.motion-type") == 2 && rig.status().segment < 3 {
        rig.cycle();
        went.push(rig.places());
    }
    rig.say("motion.reverse");
    rig.cycles(3);
    assert!(rig.is("motion.tp-reverse"));
    rig.cycles(4000);
    assert!(rig.places().iter().all(|p| p.abs() < 1e-9), "back at the start: {:?}", rig.places());
    assert!(!rig.is("motion.in-position"), "the moves still wait");
    rig.say("motion.forward");
    rig.cycles(300);
    assert!(rig.places()[0] > 1.0);
    // Adaptive feed below 0 does the same.
    rig.say("motion.feed adaptive=1");
    rig.bench.set("motion.adaptive-feed", -0.5);
    rig.cycles(4000);
    assert!(rig.places().iter().all(|p| p.abs() < 1e-9), "{:?}", rig.places());
    rig.bench.set("motion.adaptive-feed", 1.0);
    // All the way, on the same path.
    let mut off = 0.0_f64;
    while !rig.is("motion.in-position") {
        rig.cycle();
        let [x, y, _] = rig.places();
        let near = went.iter().map(|w| (w[0] - x).hypot(w[1] - y)).fold(f64::INFINITY, f64::min);
        if rig.status().segment < 3 {
            off = off.max(near);
        }
    }
    assert!(off < 0.05, "{off} beside the way of the first time");
    assert_eq!(rig.places(), [0.0; 3]);
}

/// A refused move takes those behind it along; those before it are carried out, and later ones begin where these end.
#[test]
fn what_cannot_be_is_refused_before_it_begins() {
    let mut rig = Rig::homed(&[]);
    for (text, why) in [
        ("motion.arc center-x=60 velocity=9 line=4", "X's"),
        ("motion.arc center-x=110 x=220 velocity=9", "Y's"),
        ("motion.arc center-x=10 x=12 velocity=9", "radius"),
        ("motion.arc center-x=0 velocity=9", "no radius"),
        ("motion.move x=201 velocity=9 mode=blend", "X's"),
    ] {
        if text.ends_with("line=4") {
            rig.say("motion.configure axis=x max-limit=100");
        }
        let text = rig.failed(text);
        assert!(text.contains(why), "{text}");
        assert_eq!(rig.places(), [0.0; 3]);
        assert!(rig.is("motion.coord-error"));
        rig.say("motion.configure axis=x max-limit=1000");
        rig.cycles(2);
    }
    let said = rig.bench.said();
    let first = "circular move on line 4 would exceed X's positive limit, 100, by 20";
    assert_eq!(said.first().map(String::as_str), Some(first), "{said:?}");
    rig.say("motion.move x=10 velocity=40 mode=blend");
    rig.say("motion.move z=101 velocity=40 mode=blend");
    rig.say("motion.move x=30 velocity=40 mode=blend");
    rig.say("motion.digital-out index=0 value=1 sync=1");
    rig.finish();
    assert_eq!(rig.places(), [10.0, 0.0, 0.0]);
    assert!(!rig.is("motion.digital-out-00"));
    let states = rig.bench.tickets();
    let [.., before, refused, behind, _] = states.as_slice() else { panic!("{states:?}") };
    assert_eq!(*before, TicketState::Done);
    assert!(matches!(refused, TicketState::Failed(t) if t.contains("Z's positive limit")));
    assert_eq!(*behind, TicketState::Failed("a move before this one was refused"));
    rig.done("motion.move y=5 velocity=40");
    assert_eq!(rig.places(), [10.0, 5.0, 0.0]);
    for (text, why) in [
        ("motion.move x=nan velocity=1", "x is NaN, must be a finite number"),
        ("motion.move x=1 velocity=1 time=2", "velocity=, time= and rapid= exclude each other"),
        (
            "motion.move x=1 mode=stop tolerance=1",
            "tolerance= belongs to mode=blend, not to mode=stop",
        ),
        ("motion.move x=1 mode=loose", "mode 'loose' is none of stop, exact and blend"),
        ("motion.arc center-x=1 turns=-1", "turns is -1, must be 0 to 1000000"),
    ] {
        assert_eq!(rig.try_say(text).unwrap_err(), why);
    }
}

#[test]
fn commands_without_a_path_are_refused() {
    let mut rig = Rig::homed(&[]);
    let why = "there is no path: it needs coordinated mode";
    for text in ["motion.step", "motion.reverse"] {
        assert_eq!(rig.failed(text), why, "{text}");
    }
    // A stop is never refused.
    rig.done("motion.pause");
    rig.done("motion.mode mode=coord");
    assert_eq!(rig.failed("motion.step"), "no move waits that a step could begin");
    assert_eq!(rig.failed("motion.reverse"), "there is no path to go back along");
    // No new path begins while the last one brakes.
    rig.say("motion.move x=100 velocity=80");
    rig.begin();
    rig.cycles(200);
    rig.say("motion.abort");
    rig.cycle();
    let why = "the machine is still coming to a stop";
    assert_eq!(rig.failed("motion.move x=0 velocity=80"), why);
    rig.finish();
    rig.done("motion.move x=0 velocity=80");
}

/// Limits that become tighter in motion: the path brakes, and its rest keeps the new limits.
#[test]
fn the_rest_of_a_path_is_planned_again_for_tighter_limits() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.arc center-x=30 turns=2 velocity=80 mode=blend tolerance=0.1");
    rig.say("motion.move y=50 velocity=80");
    rig.begin();
    rig.cycles(3500);
    let angle = |rig: &Rig| rig.places()[1].atan2(rig.places()[0] - 30.0);
    let (mut last, mut turned) = (angle(&rig), 0.0);
    rig.say("motion.configure joint=0 max-velocity=20 max-acceleration=300");
    let mut settled = 0;
    let mut fastest = 0.0_f64;
    while rig.status().segment == 1 || settled < 300 {
        rig.cycle();
        settled += 1;
        let by = angle(&rig) - last;
        turned += by - (by / core::f64::consts::TAU).round() * core::f64::consts::TAU;
        last = angle(&rig);
        if settled > 300 {
            fastest = fastest.max(rig.joint(0, "vel-cmd").abs());
        }
        assert!(settled < 100_000);
    }
    // 3 turns are 565 mm; 3.5 s at 80 mm/s are 280 mm of them, less the start.
    let all = turned / core::f64::consts::TAU;
    assert!((1.3..1.7).contains(&all), "{all} turns were left");
    assert!(fastest > 19.0 && fastest <= 20.0 + 1e-6, "{fastest}");
    rig.finish();
    assert_eq!(rig.places(), [0.0, 50.0, 0.0]);
}

/// A probe move ends where the probe changes; the pose of that cycle is kept.
#[test]
fn probe_moves_of_all_four_kinds() {
    for (away, optional) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut rig = Rig::homed(&[]);
        let text =
            |to: f64| format!("motion.probe x={to} velocity=20 away={away} optional={optional}");
        // The surface is at 30; the probe trips within the cycle, and the motors are one cycle behind.
        rig.bench.set("motion.probe-input", away);
        rig.say(&text(60.0));
        rig.say("motion.move x=70 velocity=20");
        let mut measured = f64::NAN;
        for n in 0..20_000 {
            let at = rig.joint(0, "motor-pos-fb");
            let beyond = at >= 30.0;
            rig.bench.set("motion.probe-input", beyond != away);
            rig.cycle();
            if beyond && measured.is_nan() {
                measured = at;
                assert!(rig.status().probe_found && rig.status().probe_commanded[0] >= 30.0);
            }
            if n > 50 && rig.is("motion.in-position") {
                break;
            }
        }
        let s = rig.status();
        assert_eq!((s.probe_measured[0], s.probe_found), (measured, true));
        let states = rig.bench.tickets();
        let [.., probe, behind] = states.as_slice() else { panic!("{states:?}") };
        assert_eq!(*probe, TicketState::Done);
        assert_eq!(*behind, TicketState::Failed("the path ended where the probe changed"));
        let [x, ..] = rig.places();
        let braking = 20.0 * 20.0 / 2.0 / 1350.0 + 2.0 * 20.0 * DT;
        assert!(30.0 < x && x < 30.0 + braking + 0.05, "{x}");
        // It begins where the probe is already.
        let state = if away { "not tripped" } else { "tripped already" };
        let why = format!("the probe is {state} as the probe move begins");
        let stood = rig.places();
        assert_eq!(rig.failed(&text(60.0)), why);
        assert_eq!(rig.places(), stood, "it moves nothing");
        // Nothing changes on the way.
        rig.bench.set("motion.probe-input", away);
        let end = rig.wait(&text(70.0));
        let no_contact = "the probe move ended without a change of the probe";
        assert_eq!(end, if optional { Ok(()) } else { Err(no_contact) });
        assert_eq!(rig.places()[0], 70.0);
        assert!(!rig.status().probe_found);
    }
}

/// A probe move whose probe is already as at its end moves nothing, and the move before it ends in its place.
#[test]
fn a_probe_that_is_closed_already_moves_nothing() {
    for jerk in [0.0, 3e5, 3e4] {
        for away in [false, true] {
            let mut rig = Rig::homed(&[]);
            rig.say(&format!("motion.configure joint=0 max-jerk={jerk}"));
            rig.bench.set("motion.probe-input", !away);
            rig.say("motion.move x=7 velocity=20 mode=blend tolerance=0.1");
            let state = if away { "not tripped" } else { "tripped already" };
            let why = format!("the probe is {state} as the probe move begins");
            assert_eq!(rig.failed(&format!("motion.probe x=60 velocity=20 away={away}")), why);
            assert_eq!(rig.places(), [7.0, 0.0, 0.0]);
            let states = rig.bench.tickets();
            let [.., before, _] = states.as_slice() else { panic!("{states:?}") };
            assert_eq!(*before, TicketState::Done);
            rig.cycles(100);
            assert_eq!(rig.places(), [7.0, 0.0, 0.0]);
            // A probe that changes on the way is none that was closed before.
            rig.bench.set("motion.probe-input", away);
            rig.say(&format!("motion.probe x=60 velocity=20 away={away}"));
            while rig.places()[0] == 7.0 {
                rig.cycle();
            }
            rig.bench.set("motion.probe-input", !away);
            assert_eq!(rig.end(), Ok(()));
        }
    }
}

/// The machine goes off in the cycle after the contact: the pose of the contact stays when it is on again.
#[test]
fn the_pose_of_a_contact_outlives_a_stop() {
    let mut rig = Rig::homed(&[]);
    rig.strict = false;
    rig.say("motion.probe x=60 velocity=20");
    while rig.joint(0, "motor-pos-fb") < 30.0 {
        rig.cycle();
    }
    rig.bench.set("motion.probe-input", true);
    rig.cycle();
    let contact = rig.status();
    assert!(contact.probe_found && contact.probe_measured[0] >= 30.0);
    rig.bench.set("motion.enable", false);
    rig.cycle();
    assert!(!rig.is("motion.motion-enabled"));
    rig.bench.set("motion.enable", true);
    rig.done("motion.enable");
    rig.cycles(10);
    let later = rig.status();
    assert_eq!((later.probe_found, later.probe_measured), (true, contact.probe_measured));
    assert_ne!(rig.joint(0, "motor-pos-fb"), contact.probe_measured[0]);
}

#[test]
fn a_probe_that_trips_ends_jogs_and_homing() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.jog joint=0 velocity=20 position=100");
    rig.cycles(100);
    rig.bench.set("motion.probe-input", true);
    assert_eq!(rig.end(), Err("the probe tripped during a jog"));
    rig.cycles(100);
    assert_eq!(rig.joint(0, "vel-cmd"), 0.0);
    assert_eq!(rig.bench.said(), ["the probe tripped during a jog"]);
    // While it stays tripped, one jogs away.
    rig.done("motion.jog joint=0 velocity=20 distance=-1");
    rig.bench.set("motion.probe-input", false);
    rig.say("motion.configure joint=1 home=40");
    rig.say("motion.home joint=1");
    rig.cycles(200);
    rig.bench.set("motion.probe-input", true);
    assert!(rig.end().is_err());
    assert_eq!(rig.bench.said(), ["the probe tripped during homing"]);
    assert!(rig.is("motion.motion-enabled"));
}

/// A paused job: axes jog away, and resume returns them to the very place before the path goes on.
#[test]
fn a_paused_path_is_left_by_jogs_and_found_again() {
    let mut rig = Rig::homed(&[]);
    for to in SQUARE {
        rig.say(&format!("motion.move {to} velocity=40 mode=blend tolerance=1"));
    }
    rig.begin();
    rig.cycles(700);
    rig.say("motion.pause");
    rig.cycles(200);
    let place = rig.places();
    assert!(rig.failed("motion.jog joint=2 velocity=5").contains("the machine moves"));
    rig.done("motion.jog axis=z velocity=9 distance=10");
    rig.done("motion.jog axis=x velocity=50 distance=33");
    assert!(rig.status().away && rig.is("motion.teleop-mode"));
    near(rig.places(), [place[0] + 33.0, place[1], 10.0]);
    let refused = "the path is paused: motion.resume goes back to it, motion.abort ends it";
    assert_eq!(rig.failed("motion.move x=1 velocity=5"), refused);
    assert_eq!(
        rig.failed("motion.reverse"),
        "the axes have left the path: motion.resume goes back to it"
    );
    rig.say("motion.jog axis=y velocity=20");
    rig.cycles(100);
    assert_eq!(rig.failed("motion.resume"), "cannot resume while an axis jogs");
    rig.done("motion.jog-stop");
    rig.done("motion.resume");
    rig.cycles(5);
    assert_eq!(
        rig.failed("motion.jog axis=y velocity=5"),
        "cannot jog while the axes go back to their path"
    );
    let mut found = false;
    for _ in 0..5000 {
        let was = rig.is("motion.teleop-mode");
        rig.cycle();
        if was && rig.is("motion.coord-mode") {
            near(rig.places(), place);
            rig.cycle();
            let [x, y, z] = rig.places();
            assert!(z == 0.0 && (x - place[0]).hypot(y - place[1]) < 1e-2);
            found = true;
        }
    }
    assert!(found && rig.is("motion.in-position"));
    assert_eq!(rig.places(), [0.0; 3]);
    // Away from the path, an abort ends it where the axes are.
    rig.say("motion.move x=50 velocity=40");
    rig.begin();
    rig.cycles(300);
    rig.say("motion.pause");
    rig.cycles(200);
    rig.done("motion.jog axis=y velocity=20 distance=5");
    rig.done("motion.abort");
    let place = rig.places();
    rig.cycles(100);
    assert!(rig.is("motion.in-position") && !rig.status().away);
    assert_eq!(rig.places(), place);
    rig.done("motion.move x=0 y=0 velocity=40");
    assert_eq!(rig.places(), [0.0; 3]);
}

fn near(at: [f64; 3], to: [f64; 3]) {
    (0..3).for_each(|n| super::near(at[n], to[n]));
}

/// The jog back may end within a deadband that grows with the acceleration.
#[test]
fn axes_of_a_fast_machine_come_back_to_their_path() {
    let mut rig = Rig::homed(&[]);
    rig.strict = false;
    for n in 0..3 {
        rig.say(&format!("motion.configure joint={n} max-acceleration=50000"));
    }
    rig.say("motion.move x=150 velocity=5");
    for k in 1..20 {
        rig.cycles(100);
        rig.done("motion.pause");
        rig.cycles(200);
        rig.done(&format!("motion.jog axis=y velocity=30 distance={}", 0.37 * f64::from(k)));
        rig.done("motion.resume");
        rig.cycles(1500);
        assert!(rig.is("motion.coord-mode"), "{k}: {:?}", rig.places());
        assert!((rig.joint(0, "vel-cmd") - 5.0).abs() < 1e-6, "{k}");
    }
}
