//! Phases of motion by events: what stops, how, with which cause; that no position is lost, that nothing restarts by
//! itself, and that the machine can go on afterwards.

use super::*;

/// Reactions: `-` none; `hold` rests until the event is over, and goes on; `brake` brakes within the limits, and the
/// machine stays on; `after` ends the thread or tap, and rests until the event is over; `off` switches the machine off
/// in this cycle; `fail` homing fails, and the machine goes off; `trip` brakes or ends homing, and says so; `found` ends the
/// probe move well. `starved` is a planner that does not run.
const TABLE: &str = "
phase         hold  door  abort  limit  ferror  amp  spindle  enable  misc  estop  unhome  starved  probe
rest          -     -     -      off    off     off  off      off     off   off    .       -        -
accelerating  hold  hold  brake  off    off     off  off      off     off   off    -       -        -
cruising      hold  hold  brake  off    off     off  off      off     off   off    -       -        -
decelerating  hold  hold  brake  off    off     off  off      off     off   off    -       -        -
held          hold  hold  brake  off    off     off  off      off     off   off    -       -        -
joint-jog     -     -     brake  off    off     off  off      off     off   off    -       -        trip
axis-jog      -     -     brake  off    off     off  off      off     off   off    -       -        trip
blend         hold  hold  brake  off    off     off  off      off     off   off    -       hold     -
arc           hold  hold  brake  off    off     off  off      off     off   off    -       -        -
reversing     hold  hold  brake  off    off     off  off      off     off   off    -       -        -
paused        hold  hold  brake  off    off     off  off      off     off   off    -       -        -
probing       hold  hold  brake  off    off     off  off      off     off   off    -       -        found
wheel-jog     -     -     brake  off    off     off  off      off     off   off    -       -        trip
search        -     -     brake  fail   off     off  off      off     off   off    -       -        trip
latch         -     -     brake  fail   off     off  off      off     off   off    -       -        trip
threading     after after brake  off    off     off  off      off     off   off    -       -        -
tapping       after after brake  off    off     off  off      off     off   off    -       after    -
retracting    after after brake  off    off     off  off      off     off   off    -       after    -
";

struct Event {
    name: &'static str,
    begin: fn(&mut Rig),
    end: fn(&mut Rig),
    /// Cause in the ticket and message to the operator, if it stops something.
    cause: &'static str,
    said: &'static str,
}

/// An event that is a pin with this value.
macro_rules! pin {
    ($name:literal, $pin:literal, $value:literal, $cause:literal, $said:literal) => {
        Event {
            name: $name,
            begin: |rig| rig.bench.set($pin, $value),
            end: |rig| rig.bench.set($pin, !$value),
            cause: $cause,
            said: $said,
        }
    };
}

const EVENTS: &[Event] = &[
    pin!("hold", "motion.feed-hold", true, "", ""),
    pin!("door", "motion.feed-inhibit", true, "", ""),
    Event {
        name: "abort",
        begin: |rig| drop(rig.say("motion.abort")),
        end: |_| (),
        cause: "aborted",
        said: "",
    },
    pin!(
        "limit",
        "joint.0.pos-lim-sw-in",
        true,
        "joint on limit switch error",
        "axis X on limit switch error"
    ),
    Event {
        name: "ferror",
        begin: |rig| {
            rig.stuck[0] = true;
            rig.bench.set("joint.0.motor-pos-fb", rig.joint(0, "motor-pos-cmd") - 3.0);
        },
        end: |rig| rig.stuck[0] = false,
        cause: "joint following error",
        said: "axis X following error",
    },
    pin!("amp", "joint.1.amp-fault-in", true, "joint amplifier fault", "axis Y amplifier fault"),
    pin!(
        "spindle",
        "spindle.0.amp-fault-in",
        true,
        "spindle amplifier fault",
        "spindle 0 amplifier fault"
    ),
    pin!(
        "enable",
        "motion.enable",
        false,
        "motion stopped by enable input",
        "motion stopped by enable input"
    ),
    pin!(
        "misc",
        "motion.misc-error-01",
        true,
        "motion stopped by misc error",
        "Motion Stopped by misc error 1"
    ),
    Event {
        name: "estop",
        begin: |rig| rig.bench.set("iocontrol.0.emc-enable-in", false),
        end: Rig::release,
        cause: "motion stopped by e-stop: {iocontrol.0.emc-enable-in} is FALSE",
        said: "motion stopped by e-stop: {iocontrol.0.emc-enable-in} is FALSE",
    },
    Event {
        name: "unhome",
        begin: |rig| drop(rig.say("motion.unhome joint=1")),
        end: |_| (),
        cause: "cannot unhome while the machine moves",
        said: "cannot unhome while the machine moves",
    },
    pin!("probe", "motion.probe-input", true, "", ""),
    Event {
        name: "starved",
        begin: |rig| rig.is_starved = true,
        end: |rig| rig.is_starved = false,
        cause: "",
        said: "",
    },
];

/// Runs a cycle of a machine whose joint 0 has its home switch from 30 on.
fn step(rig: &mut Rig) {
    let is_on = rig.joint(0, "motor-pos-cmd") > 30.0;
    rig.bench.set("joint.0.home-sw-in", is_on);
    rig.cycle();
}

fn until(rig: &mut Rig, is: impl Fn(&Rig) -> bool) {
    for _ in 0..20_000 {
        if is(rig) {
            return;
        }
        step(rig);
    }
    panic!("never: joints at {:?}, {:?}", rig.places(), rig.bench.said())
}

fn state(rig: &Rig) -> i32 {
    rig.bench.get("joint.0.home-state")
}

/// Returns a machine in a phase, with the number of the ticket that waits for its motion, and where joint 0 ends if nothing
/// happens.
fn begin(phase: &str) -> (Rig, Option<usize>, f64) {
    let mut rig = Rig::released();
    let speed = |rig: &Rig| rig.joint(0, "vel-cmd");
    let (text, end) = match phase {
        "rest" => return (rig, None, 0.0),
        "wheel-jog" => {
            rig.bench.set("joint.0.jog-enable", true);
            rig.bench.set("joint.0.jog-scale", 1.0);
            rig.cycle();
            rig.bench.set("joint.0.jog-counts", 100);
            until(&mut rig, |rig| speed(rig) >= 45.0);
            return (rig, None, 100.0);
        }
        "joint-jog" => ("motion.jog joint=0 velocity=45 position=100", 100.0),
        "axis-jog" => ("motion.jog axis=x velocity=45 position=100", 100.0),
        "search" | "latch" => {
            let config = "home-search-vel=20 home-latch-vel=2 home=5 home-offset=30";
            rig.say(&format!("motion.configure joint=0 {config}"));
            ("motion.home joint=0", 5.0)
        }
        "blend" => {
            rig.say("motion.move x=25 velocity=45 mode=blend tolerance=2");
            ("motion.move x=70 y=60 velocity=45 mode=blend", 70.0)
        }
        "arc" => ("motion.arc center-x=30 x=60 velocity=45", 60.0),
        "threading" | "tapping" | "retracting" => {
            rig.turner = Some(follow::Turner::new(80.0));
            rig.say("motion.spindle speed=900");
            match phase {
                "threading" => ("motion.move x=100 y=30 pitch=3", 100.0),
                "tapping" => ("motion.tap x=90 pitch=3", 0.0),
                _ => ("motion.tap x=60 pitch=3", 0.0),
            }
        }
        "probing" => ("motion.probe x=90 velocity=45 optional=1", 90.0),
        _ => ("motion.move x=100 y=30 velocity=45", 100.0),
    };
    rig.say(text);
    let ticket = rig.bench.tickets().len() - 1;
    match phase {
        "accelerating" => until(&mut rig, |rig| speed(rig) > 20.0),
        "decelerating" => {
            // At the end of a move, a hold would change nothing.
            until(&mut rig, |rig| speed(rig) > 40.0);
            rig.say("motion.feed override=0.4");
            until(&mut rig, |rig| speed(rig) < 30.0);
        }
        "search" => until(&mut rig, |rig| state(rig) == 7 && speed(rig) == 20.0),
        "latch" => until(&mut rig, |rig| state(rig) == 12 && speed(rig) == 2.0),
        "blend" => until(&mut rig, |rig| rig.joint(1, "vel-cmd") > 5.0),
        "reversing" => {
            until(&mut rig, |rig| rig.joint(0, "pos-cmd") > 60.0);
            rig.say("motion.reverse");
            until(&mut rig, |rig| speed(rig) < -42.0);
        }
        "retracting" => until(&mut rig, |rig| speed(rig) < -44.0),
        "paused" => {
            until(&mut rig, |rig| speed(rig) > 42.0);
            rig.say("motion.pause");
            until(&mut rig, |rig| speed(rig) == 0.0);
        }
        "held" => {
            until(&mut rig, |rig| speed(rig) > 40.0);
            rig.bench.set("motion.feed-hold", true);
            until(&mut rig, |rig| speed(rig) == 0.0);
        }
        _ => until(&mut rig, |rig| speed(rig) > 42.0 && rig.joint(0, "pos-cmd") > 20.0),
    }
    (rig, Some(ticket), end)
}

fn ticket(rig: &Rig, n: Option<usize>) -> Option<TicketState> {
    n.map(|n| rig.bench.tickets()[n])
}

/// Waits for the end of the motion of a phase, at its place.
fn ends_well(rig: &mut Rig, waits: Option<usize>, end: f64, what: &str) {
    rig.bench.set("motion.feed-hold", false);
    if what.starts_with("reversing") {
        rig.say("motion.forward");
    } else if what.starts_with("paused") {
        nothing_moves_on(rig, what);
        rig.say("motion.resume");
    }
    until(rig, |rig| rig.is("motion.in-position"));
    assert!(ticket(rig, waits).is_none_or(|t| t == TicketState::Done), "{what}");
    near(rig.joint(0, "pos-cmd"), end);
}

/// Asserts that no joint moves for a while, in the middle of a path.
fn nothing_moves_on(rig: &mut Rig, what: &str) {
    let places = rig.places();
    for _ in 0..100 {
        step(rig);
        assert_eq!(rig.places(), places, "{what}");
    }
}

/// Asserts that the machine stays as it is, without a motion, for a while.
fn nothing_moves(rig: &mut Rig, what: &str) {
    let places = rig.places();
    for _ in 0..100 {
        step(rig);
        assert_eq!(rig.places(), places, "{what}");
        assert!(rig.is("motion.in-position"), "{what}");
    }
}

/// Returns the cause of a stop by a probe that trips while nothing probes.
fn tripped(phase: &str) -> &'static str {
    if matches!(phase, "search" | "latch") {
        "the probe tripped during homing"
    } else {
        "the probe tripped during a jog"
    }
}

fn check(phase: &str, event: &Event, reaction: &str) {
    let what = format!("{phase}, {}: {reaction}", event.name);
    let (mut rig, waits, end) = begin(phase);
    let homed = rig.which(&["joint.0.homed", "joint.1.homed", "joint.2.homed"]);
    let offsets = [0, 1, 2].map(|n| rig.joint(n, "motor-offset"));
    assert!(rig.bench.said().is_empty(), "{what}");
    (event.begin)(&mut rig);
    match reaction {
        "-" => {
            step(&mut rig);
            assert!(rig.is("motion.motion-enabled"), "{what}");
            let refused = event.name == "unhome";
            let said = rig.bench.said();
            assert_eq!(said, if refused { vec![event.said] } else { vec![] }, "{what}");
            ends_well(&mut rig, waits, end, &what);
            return (event.end)(&mut rig);
        }
        "hold" => {
            until(&mut rig, |rig| rig.joint(0, "vel-cmd") == 0.0 && rig.joint(1, "vel-cmd") == 0.0);
            nothing_moves_on(&mut rig, &what);
            assert!(rig.is("motion.motion-enabled"), "{what}");
            assert!(rig.joint(0, "pos-cmd") < 100.0, "{what}");
            (event.end)(&mut rig);
            return ends_well(&mut rig, waits, end, &what);
        }
        "after" => {
            let mut rested = 0;
            until(&mut rig, |rig| rig.joint(0, "vel-cmd") == 0.0 && rig.joint(0, "pos-cmd") != 0.0);
            while rested < 100 {
                step(&mut rig);
                rested = if rig.joint(0, "vel-cmd") == 0.0 { rested + 1 } else { 0 };
            }
            // A tap is outside its hole.
            let place = rig.joint(0, "pos-cmd");
            assert!(
                if phase == "threading" { place == end } else { place <= end },
                "{what}: {place}"
            );
            (event.end)(&mut rig);
            return ends_well(&mut rig, waits, end, &what);
        }
        "found" => {
            until(&mut rig, |rig| rig.is("motion.in-position"));
            assert!(rig.is("motion.motion-enabled") && rig.is("motion.probe-input"), "{what}");
            assert!(rig.joint(0, "pos-cmd") < end, "{what}");
            assert_eq!(ticket(&rig, waits), Some(TicketState::Done), "{what}");
            assert!(rig.bench.said().is_empty(), "{what}");
            (event.end)(&mut rig);
            return nothing_moves(&mut rig, &what);
        }
        "trip" => {
            until(&mut rig, |rig| rig.is("motion.in-position"));
            assert!(rig.is("motion.motion-enabled"), "{what}");
            assert!(rig.joint(0, "pos-cmd") < 100.0, "{what}");
            assert_eq!(rig.bench.said(), [tripped(phase)], "{what}");
        }
        "brake" => {
            until(&mut rig, |rig| rig.is("motion.in-position"));
            assert!(rig.is("motion.motion-enabled"), "{what}");
            assert!(rig.joint(0, "pos-cmd") < 100.0, "{what}");
            assert!(rig.bench.said().is_empty(), "{what}");
        }
        "off" => {
            rig.strict = false;
            let before = rig.places();
            step(&mut rig);
            assert!(!rig.is("motion.motion-enabled"), "{what}");
            let amps = ["joint.0.amp-enable-out", "joint.1.amp-enable-out"];
            assert_eq!(rig.which(&amps), [""; 0], "{what}");
            assert_eq!(rig.bench.said(), [event.said], "{what}");
            // No farther than the motor was, or was measured to be.
            assert!((rig.joint(0, "pos-cmd") - before[0]).abs() <= 3.0 + 0.1, "{what}");
        }
        "fail" => {
            rig.strict = false;
            step(&mut rig);
            step(&mut rig);
            assert!(!rig.is("motion.motion-enabled"), "{what}");
            let state = if phase == "search" { 7 } else { 12 };
            let homing = format!("j0 hit limit in home state {state}");
            assert_eq!(rig.bench.said(), [homing.as_str(), event.said], "{what}");
        }
        other => panic!("{other}"),
    }
    let cause = match reaction {
        "fail" => "hit limit while homing",
        "trip" => tripped(phase),
        _ => event.cause,
    };
    assert!(ticket(&rig, waits).is_none_or(|t| t == TicketState::Failed(cause)), "{what}");
    nothing_moves(&mut rig, &what);
    // The cause is kept until it is read.
    let kept = |rig: &Rig| {
        let lines = rig.say("motion.status");
        lines.into_iter().filter(|l| l.starts_with("stop ")).collect::<Vec<_>>()
    };
    let stops = kept(&rig);
    if matches!(reaction, "brake" | "trip") {
        assert!(stops.is_empty(), "{what}: the machine stays on");
    } else {
        let text = cause.replace(['{', '}'], "");
        assert!(stops[0].starts_with("stop time=") && stops[0].ends_with(&text), "{stops:?}");
        assert_eq!(stops.len(), if reaction == "fail" { 2 } else { 1 }, "{stops:?}");
    }
    assert!(kept(&rig).is_empty());
    (event.end)(&mut rig);
    rig.bench.set("motion.feed-hold", false);
    nothing_moves(&mut rig, &what);
    // No position is lost.
    assert_eq!(rig.which(&["joint.0.homed", "joint.1.homed", "joint.2.homed"]), homed, "{what}");
    if !matches!(phase, "search" | "latch") {
        assert_eq!([0, 1, 2].map(|n| rig.joint(n, "motor-offset")), offsets, "{what}");
    }
    for n in 0..3 {
        near(rig.joint(n, "pos-cmd") + rig.joint(n, "motor-offset"), rig.joint(n, "motor-pos-fb"));
    }
    // The machine goes on.
    rig.done("motion.enable");
    nothing_moves(&mut rig, &what);
    let before = rig.places();
    rig.done("motion.jog joint=0 velocity=20 distance=-1");
    assert!((rig.joint(0, "pos-cmd") - (before[0] - 1.0)).abs() < 1e-5, "{what}");
    assert_eq!(rig.places()[1..], before[1..], "{what}");
    assert!(rig.is("motion.motion-enabled"), "{what}: {:?}", rig.bench.said());
}

#[test]
fn every_phase_by_every_event() {
    let mut rows = TABLE.lines().filter(|l| !l.is_empty()).map(|l| l.split_whitespace());
    let names: Vec<&str> = rows.next().unwrap().skip(1).collect();
    let mut cells = 0;
    for mut row in rows {
        let phase = row.next().unwrap();
        for (name, reaction) in names.iter().zip(row).filter(|(_, r)| *r != ".") {
            let event = EVENTS.iter().find(|e| e.name == *name).unwrap();
            check(phase, event, reaction);
            cells += 1;
        }
    }
    assert_eq!(cells, 233);
    assert_eq!(names.len(), EVENTS.len());
}
