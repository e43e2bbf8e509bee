//! Soft faults: with fault-stop=ramp, a limit switch and a following error end by a ramp, and the machine goes off at rest.

use super::{DT, LIMITS, Rig};
use hal_component::abi::TicketState;

const LIMIT: &str = "joint on limit switch error";
const FERROR: &str = "joint following error";

/// Returns a homed machine whose joints ramp, and whose following error may be 1 unit.
fn rig() -> Rig {
    let mut rig = Rig::on(&[]);
    for n in 0..3 {
        rig.say(&format!("motion.configure joint={n} fault-stop=ramp ferror=1 min-ferror=1"));
    }
    rig.done("motion.home joint=all");
    rig
}

fn velocity(rig: &Rig) -> f64 {
    rig.joint(0, "vel-cmd")
}

/// Returns the stops that motion.status tells, without their times.
fn stops(rig: &Rig) -> Vec<String> {
    let lines = rig.say("motion.status");
    let stops = lines.iter().filter_map(|line| line.strip_prefix("stop time="));
    stops.map(|line| line.split_once(": ").unwrap().1.to_owned()).collect()
}

/// Runs until the machine is off; returns the positions of joint 0, one for each cycle in which it was on.
fn until_off(rig: &mut Rig) -> Vec<f64> {
    let mut places = Vec::new();
    for _ in 0..5000 {
        rig.cycle();
        if !rig.is("motion.motion-enabled") {
            return places;
        }
        assert!(rig.is("joint.0.amp-enable-out"));
        places.push(rig.joint(0, "pos-cmd"));
    }
    panic!("never off: {:?}", rig.bench.said())
}

#[test]
fn a_jog_ramps_as_the_closed_form_says() {
    for (target, text) in [("joint", "joint=0"), ("axis", "axis=x")] {
        let mut rig = rig();
        rig.done("motion.spindle speed=600");
        rig.say(&format!("motion.jog {text} velocity=45 distance=150"));
        rig.cycles(200);
        let (from, v, a) = (rig.joint(0, "pos-cmd"), velocity(&rig), LIMITS[0].1);
        assert!((v - 45.0).abs() < 1e-9, "{target}");
        rig.bench.set("joint.0.pos-lim-sw-in", true);
        let places = until_off(&mut rig);
        // v/a seconds; the last cycle, at rest, is the one in which the machine is off.
        assert_eq!(places.len(), 33, "{target}");
        let mut at = from;
        for (k, place) in places.iter().enumerate() {
            at += (v - a * DT * (k + 1) as f64) * DT;
            assert!((place - at).abs() < 1e-9, "{target}, cycle {k}: {place}, not {at}");
        }
        assert_eq!(rig.bench.said(), ["axis X on limit switch error"], "{target}");
        assert_eq!(rig.bench.ticket(), Some(TicketState::Failed(LIMIT)), "{target}");
        assert_eq!(stops(&rig), [LIMIT], "{target}");
        assert!(rig.is("joint.0.error") && !rig.is("joint.1.error"));
        // Nothing restarts.
        rig.bench.set("joint.0.pos-lim-sw-in", false);
        rig.strict = false;
        rig.done("motion.enable");
        let places = rig.places();
        rig.cycles(300);
        assert_eq!(rig.places(), places);
        assert!(!rig.is("joint.0.error") && !rig.is("spindle.0.on"));
    }
}

/// While it brakes because of a following error, an amplifier fails.
#[test]
fn a_fault_of_an_amplifier_ends_a_ramp_at_once() {
    let mut rig = rig();
    rig.say("motion.jog joint=0 velocity=45 distance=150");
    rig.cycles(200);
    rig.strict = false;
    rig.stuck[0] = true;
    while !rig.is("joint.0.f-errored") {
        rig.cycle();
    }
    rig.cycle();
    assert!(rig.is("motion.motion-enabled"), "it brakes");
    rig.bench.set("joint.0.amp-fault-in", true);
    rig.cycle();
    assert!(!rig.is("motion.motion-enabled") && !rig.is("joint.0.amp-enable-out"));
    assert_eq!(stops(&rig), [FERROR, "joint amplifier fault"]);
}

#[test]
fn spindles_stop_and_orders_are_refused_as_a_ramp_begins() {
    let mut rig = rig();
    rig.done("motion.spindle speed=600");
    rig.say("motion.move x=100 velocity=45");
    rig.say("motion.move x=0 velocity=45");
    rig.cycles(300);
    rig.bench.set("joint.0.pos-lim-sw-in", true);
    rig.cycle();
    assert!(rig.is("motion.motion-enabled") && !rig.is("spindle.0.on"));
    for text in [
        "motion.jog joint=0 velocity=5",
        "motion.move x=1 velocity=5",
        "motion.home joint=all",
        "motion.enable",
        "motion.spindle speed=100",
        "motion.resume",
    ] {
        rig.say(text);
        rig.cycle();
        let why = "the machine brakes after a fault and goes off: give the command again then";
        assert_eq!(rig.bench.ticket(), Some(TicketState::Failed(why)), "{text}");
    }
    until_off(&mut rig);
}

#[test]
fn a_path_ramps_along_itself() {
    for (text, joint) in
        [("motion.move x=150 velocity=45", 0), ("motion.move x=150 y=75 velocity=45", 1)]
    {
        let mut rig = rig();
        rig.say(text);
        rig.cycles(300);
        let [x, y, _] = rig.places();
        let v = rig.float("motion.current-vel");
        assert!((v - 45.0).abs() < 1e-9);
        rig.bench.set(&format!("joint.{joint}.neg-lim-sw-in"), true);
        let mut last = [x, y];
        let (mut way, mut cycles) = (0.0, 0);
        loop {
            rig.cycle();
            if !rig.is("motion.motion-enabled") {
                break;
            }
            let [x, y, _] = rig.places();
            let step = (x - last[0]).hypot(y - last[1]);
            if joint == 1 {
                assert!((y - x / 2.0).abs() < 1e-9, "{text}: off the path at {x}, {y}");
            }
            (last, way, cycles) = ([x, y], way + step, cycles + 1);
        }
        // The slower joint bounds the acceleration along the path.
        let share = if joint == 1 { 2.0 / 5.0_f64.sqrt() } else { 1.0 };
        let a = LIMITS[0].1 / share;
        let (time, ideal) = (v / a / DT, v * v / (2.0 * a));
        assert!(f64::from(cycles) <= time + 2.0, "{text}: {cycles} cycles, ideal {time}");
        assert!(
            way <= ideal + 2.0 * v * DT && ideal - v * DT <= way,
            "{text}: {way}, ideal {ideal}"
        );
        assert_eq!(rig.bench.ticket(), Some(TicketState::Failed(LIMIT)), "{text}");
    }
}

#[test]
fn a_ramp_keeps_the_jerk() {
    const JERK: f64 = 30_000.0;
    for text in ["motion.jog joint=0 velocity=45 distance=150", "motion.move x=150 velocity=45"] {
        let mut rig = rig();
        rig.say(&format!("motion.configure joint=0 max-jerk={JERK}"));
        rig.say(text);
        rig.cycles(400);
        let from = rig.joint(0, "pos-cmd");
        let v = velocity(&rig);
        assert!((v - 45.0).abs() < 1e-6, "{text}: {v}");
        rig.bench.set("joint.0.pos-lim-sw-in", true);
        let places = until_off(&mut rig);
        let a = LIMITS[0].1;
        let (time, ideal) = ((v / a + a / JERK) / DT, v * v / (2.0 * a) + v * a / (2.0 * JERK));
        let (cycles, way) = (places.len() as f64, places.last().unwrap() - from);
        assert!(cycles <= time + 3.0, "{text}: {cycles} cycles, ideal {time}");
        assert!((way - ideal).abs() <= 3.0 * v * DT, "{text}: {way}, ideal {ideal}");
        assert_eq!(rig.bench.get::<u32>("motion.watch.violations"), 0, "{text}");
        assert!(rig.float("joint.0.watch-jerk") <= 1.0, "{text}");
    }
}

/// Lets the feedback of joint 0 lag by a distance.
fn lag(rig: &mut Rig, by: f64) {
    rig.stuck[0] = true;
    rig.bench.set("joint.0.motor-pos-fb", rig.joint(0, "motor-pos-cmd") - by);
}

#[test]
fn a_following_error_ramps_below_twice_its_limit_and_drops_at_it() {
    // In parts of the limit.
    let rows = [(1.9, false), (2.0, true), (f64::NAN, true)];
    for (limit, (later, drops)) in
        [1.0, 0.5, 3.0].into_iter().flat_map(|l| rows.map(|row| (l, row)))
    {
        let mut rig = rig();
        rig.say(&format!("motion.configure joint=0 ferror={limit} min-ferror={limit}"));
        rig.say("motion.jog joint=0 velocity=45 distance=150");
        rig.cycles(200);
        let lag = |rig: &mut Rig, parts: f64| lag(rig, parts * limit);
        lag(&mut rig, 1.5);
        rig.cycle();
        assert!(rig.is("motion.motion-enabled") && rig.is("joint.0.error"), "{later}");
        for cycle in 1..33 {
            lag(&mut rig, if cycle < 10 { 1.5 } else { later });
            rig.strict = !(drops && cycle == 10);
            rig.cycle();
            assert_eq!(
                rig.is("motion.motion-enabled"),
                !(drops && cycle >= 10),
                "{later}, {cycle}"
            );
            if drops && cycle == 10 {
                break;
            }
        }
        lag(&mut rig, 0.0);
        rig.strict = false;
        rig.cycles(3);
        assert!(!rig.is("motion.motion-enabled"));
        let told = if drops { 2 } else { 1 };
        assert_eq!(rig.bench.said(), vec!["axis X following error"; told], "{later}");
        assert_eq!(stops(&rig), vec![FERROR; told], "{later}");
    }
}

#[test]
fn what_cuts_the_power_cuts_a_ramp() {
    type Cuts = fn(&Rig);
    let ways: [(&str, Cuts); 5] = [
        ("motion stopped by enable input", |rig| rig.bench.set("motion.enable", false)),
        ("joint amplifier fault", |rig| rig.bench.set("joint.2.amp-fault-in", true)),
        ("spindle amplifier fault", |rig| rig.bench.set("spindle.0.amp-fault-in", true)),
        ("motion stopped by misc error", |rig| rig.bench.set("motion.misc-error-00", true)),
        ("the machine was switched off", |rig| drop(rig.say("motion.disable"))),
    ];
    for (cause, cuts) in ways {
        let mut rig = rig();
        rig.say("motion.jog joint=0 velocity=45 distance=150");
        rig.cycles(200);
        rig.bench.set("joint.0.pos-lim-sw-in", true);
        rig.cycles(10);
        assert!(rig.is("motion.motion-enabled"), "{cause}");
        rig.strict = false;
        cuts(&rig);
        rig.cycle();
        assert!(!rig.is("motion.motion-enabled"), "{cause}");
        let mut kept = vec![LIMIT, cause];
        kept.truncate(if cause.contains("switched") { 1 } else { 2 });
        assert_eq!(stops(&rig), kept, "{cause}");
    }
    // An e-stop always drops, also as the first cause.
    let mut rig = Rig::released();
    rig.say("motion.configure joint=0 fault-stop=ramp");
    rig.say("motion.jog joint=0 velocity=45 distance=150");
    rig.cycles(200);
    rig.strict = false;
    rig.bench.set("joint.0.pos-lim-sw-in", true);
    rig.bench.set("iocontrol.0.emc-enable-in", false);
    rig.cycle();
    assert!(!rig.is("motion.motion-enabled"));
}

#[test]
fn a_joint_that_drops_drops_beside_one_that_ramps() {
    let mut rig = rig();
    rig.say("motion.configure joint=1 fault-stop=drop");
    rig.say("motion.jog joint=0 velocity=45 distance=150");
    rig.cycles(200);
    rig.bench.set("joint.0.pos-lim-sw-in", true);
    rig.cycles(5);
    // Another soft fault changes nothing, and is reported once.
    rig.bench.set("joint.2.neg-lim-sw-in", true);
    rig.cycles(5);
    assert!(rig.is("motion.motion-enabled") && rig.is("joint.2.error"));
    rig.strict = false;
    rig.bench.set("joint.1.neg-lim-sw-in", true);
    rig.cycle();
    assert!(!rig.is("motion.motion-enabled"));
    assert_eq!(stops(&rig), [LIMIT, LIMIT]);
    let said = ['X', 'Z', 'Y'].map(|axis| format!("axis {axis} on limit switch error"));
    assert_eq!(rig.bench.said(), said);
}

#[test]
fn homing_and_offsets_ramp_too() {
    let mut rig = rig();
    rig.say("motion.configure joint=0 home-search-vel=20 home-latch-vel=2");
    rig.say("motion.home joint=0");
    rig.cycles(300);
    assert_eq!(velocity(&rig), 20.0);
    rig.bench.set("joint.1.pos-lim-sw-in", true);
    let places = until_off(&mut rig);
    assert_eq!(places.len(), 14);
    assert_eq!(rig.bench.ticket(), Some(TicketState::Failed(LIMIT)));
    // An external offset brakes within its share.
    let mut rig = self::rig();
    rig.say("motion.configure axis=x offset-av-ratio=0.5");
    rig.done("motion.mode mode=coord");
    rig.bench.set("axis.x.eoffset-scale", 1.0);
    rig.bench.set("axis.x.eoffset-enable", true);
    rig.bench.set("axis.x.eoffset-counts", 100);
    rig.cycles(200);
    assert!(velocity(&rig) > 40.0);
    rig.bench.set("joint.1.pos-lim-sw-in", true);
    let places = until_off(&mut rig);
    assert!((30..75).contains(&places.len()), "{}", places.len());
}

#[test]
fn nothing_but_drop_and_ramp_is_a_fault_stop() {
    let rig = Rig::off(&[]);
    let why = rig.try_say("motion.configure joint=0 fault-stop=coast").unwrap_err();
    assert_eq!(why, "fault-stop is 'coast', must be drop or ramp");
    rig.say("motion.configure joint=0 fault-stop=RAMP");
}
