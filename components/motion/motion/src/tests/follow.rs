//! Moves that follow a spindle: threads and feeds per turn, with a spindle that turns as its motor can.

use super::{DT, Rig};
use hal_component::abi::TicketState;

/// A spindle with an encoder.
#[derive(Clone, Debug)]
pub(super) struct Turner {
    number: usize,
    /// Turns since the start, and at the last index that was asked for.
    pub(super) angle: f64,
    zero: f64,
    /// Turns per second, and per second squared.
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) has_index: bool,
    pub(super) is_stalled: bool,
    /// Factor of the commanded speed that it has in the end.
    pub(super) factor: f64,
    /// True while its encoder tells the last turns and no speed.
    pub(super) is_blind: bool,
    /// True if it always says that it is at speed.
    pub(super) is_always_at_speed: bool,
    shown: f64,
}

impl Turner {
    pub(super) const fn new(acceleration: f64) -> Self {
        Self::of(0, acceleration)
    }

    /// Returns the spindle with this number.
    pub(super) const fn of(number: usize, acceleration: f64) -> Self {
        Self {
            number,
            angle: 0.3,
            zero: 0.0,
            speed: 0.0,
            acceleration,
            has_index: true,
            is_stalled: false,
            factor: 1.0,
            is_blind: false,
            is_always_at_speed: false,
            shown: 0.0,
        }
    }

    /// Turns for a cycle, as the pins of the spindle command.
    pub(super) fn step(&mut self, rig: &Rig) {
        let pin = |name: &str| format!("spindle.{}.{name}", self.number);
        let commanded = rig.float(&pin("speed-out-rps"));
        let wanted = if self.is_stalled { 0.0 } else { self.factor * commanded };
        let by = self.acceleration * DT;
        let before = self.speed;
        self.speed = (self.speed + by).min(wanted.max(self.speed - by));
        let whole = self.angle.floor();
        self.angle += 0.5 * (before + self.speed) * DT;
        let passed = if self.speed < 0.0 { whole } else { self.angle.floor() };
        let is_index = self.angle.floor() != whole;
        let sees = !self.is_blind;
        if is_index && self.has_index && sees && rig.is(&pin("index-enable")) {
            self.zero = passed;
            rig.bench.set(&pin("index-enable"), false);
        }
        self.shown = if sees { self.revs() } else { self.shown };
        rig.bench.set(&pin("revs"), self.shown);
        rig.bench.set(&pin("speed-in"), if sees { self.speed } else { 0.0 });
        let is_at_speed = (self.speed - commanded).abs() < 0.1 || self.is_always_at_speed;
        rig.bench.set(&pin("at-speed"), is_at_speed);
    }

    pub(super) fn revs(&self) -> f64 {
        self.angle - self.zero
    }
}

/// A lathe: a machine with a spindle.
pub(super) struct Lathe {
    pub(super) rig: Rig,
    pub(super) turner: Turner,
    /// Largest distance of x from its place, in travels of a cycle at most `top`, since x was together with the spindle.
    worst: f64,
    is_together: bool,
}

/// Pitch of the tests.
pub(super) const PITCH: f64 = 1.5;

impl Lathe {
    pub(super) fn new(speed: f64, acceleration: f64) -> Self {
        Self::on(&[], speed, acceleration)
    }

    /// Returns a lathe with these kinematics.
    pub(super) fn on(kinematics: &[&str], speed: f64, acceleration: f64) -> Self {
        let mut rig = Rig::homed(kinematics);
        rig.say(&format!("motion.spindle speed={speed}"));
        rig.cycle();
        Self::of(rig, Turner::new(acceleration))
    }

    /// Returns a machine with a spindle.
    pub(super) const fn of(rig: Rig, turner: Turner) -> Self {
        Self { rig, turner, worst: 0.0, is_together: false }
    }

    pub(super) fn x(&self) -> f64 {
        self.rig.joint(0, "pos-cmd")
    }

    pub(super) fn cycle(&mut self) {
        self.turner.step(&self.rig);
        self.rig.cycle();
    }

    pub(super) fn cycles(&mut self, n: usize) {
        (0..n).for_each(|_| self.cycle());
    }

    pub(super) fn until(&mut self, is: impl Fn(&Self) -> bool) {
        for _ in 0..60_000 {
            if is(self) {
                return;
            }
            self.cycle();
        }
        panic!("never: x {} {:?} {:?}", self.x(), self.turner, self.rig.bench.said())
    }

    /// Follows a thread from `start`, and measures its distance from the spindle until `end`, where it brakes.
    fn measure(&mut self, start: f64, end: f64) {
        let travel = (PITCH * self.turner.speed * DT).abs();
        let error = self.x() - start - PITCH * self.turner.revs();
        assert!(
            !self.is_together
                || end <= self.x()
                || (self.rig.float("spindle.0.sync-error") + error).abs() < 1e-6,
            "{} {error}",
            self.rig.float("spindle.0.sync-error")
        );
        let is_near = error.abs() <= travel;
        self.is_together |= is_near && self.x() > start + 0.5 && self.x() < end;
        if self.is_together && self.x() < end {
            self.worst = self.worst.max(error.abs() / travel.max(1e-6));
        }
    }

    pub(super) fn ticket(&self) -> TicketState {
        self.rig.bench.ticket().unwrap()
    }

    /// Runs to the end of the last command.
    pub(super) fn end(&mut self) -> Result<(), &'static str> {
        self.until(|l| l.ticket() != TicketState::Pending);
        match self.ticket() {
            TicketState::Failed(why) => Err(why),
            _ => Ok(()),
        }
    }

    /// Runs a thread of 40 from 0, and measures it. `at` is called with x in each cycle.
    fn thread(&mut self, mut at: impl FnMut(&mut Self, f64)) {
        self.rig.say(&format!("motion.move x=40 spindle=0 pitch={PITCH}"));
        let ticket = self.rig.bench.tickets().len() - 1;
        while self.rig.bench.tickets()[ticket] == TicketState::Pending {
            self.cycle();
            let x = self.x();
            if x > 0.0 {
                // x brakes from 30 units/s for the end within a third of a unit.
                self.measure(0.0, 39.6);
            }
            at(self, x);
        }
        assert_eq!(self.rig.bench.tickets()[ticket], TicketState::Done);
        assert_eq!(self.x(), 40.0);
        assert!(self.is_together);
    }
}

#[test]
fn a_thread_follows_a_spindle_of_constant_speed() {
    for speed in [60.0, 600.0, 1100.0, -600.0] {
        let mut lathe = Lathe::new(speed, 400.0);
        if speed < 0.0 {
            // The place goes forward although the turns go back.
            lathe.rig.say(&format!("motion.move x=40 spindle=0 pitch={PITCH}"));
            lathe.until(|l| l.x() > 20.0);
            let error = lathe.x() + PITCH * lathe.turner.revs();
            assert!(error.abs() < PITCH * 10.0 * DT, "{error}");
            assert_eq!(lathe.end(), Ok(()));
            continue;
        }
        lathe.thread(|lathe, x| {
            // It has settled.
            if 20.0 < x && x < 39.0 {
                assert!((x - PITCH * lathe.turner.revs()).abs() < 1e-6, "{speed} at {x}");
            }
        });
        assert!(lathe.worst <= 1.0, "{speed}: {} travels", lathe.worst);
        assert_eq!(lathe.rig.float("spindle.0.sync-error"), 0.0);
    }
}

#[test]
fn a_thread_follows_a_spindle_that_changes_its_speed() {
    // Half of the acceleration of x: 675 units/s².
    for acceleration in [40.0, 200.0, 0.5 * 1350.0 / PITCH] {
        let mut lathe = Lathe::new(600.0, acceleration);
        let mut scale = 1.0;
        lathe.thread(|lathe, x| {
            let wanted = if (x / 8.0).rem_euclid(1.0) >= 0.5 { 0.4 } else { 1.0 };
            if wanted != scale {
                scale = wanted;
                lathe.rig.say(&format!("motion.spindle override={scale}"));
                lathe.rig.bench.set("motion.adaptive-feed", 0.1);
            }
        });
        assert!(0.0 < lathe.worst && lathe.worst <= 1.0, "{acceleration}: {} travels", lathe.worst);
    }
}

#[test]
fn passes_begin_at_the_same_phase_at_any_speed() {
    let mut lathe = Lathe::new(600.0, 400.0);
    let mut phases = Vec::new();
    for speed in [600, 600, 300, 900] {
        lathe.rig.say(&format!("motion.spindle speed={speed}"));
        lathe.cycles(137 + phases.len() * 41);
        lathe.is_together = false;
        let mut phase = f64::NAN;
        lathe.thread(|lathe, x| {
            if 20.0 < x && phase.is_nan() {
                phase = (lathe.turner.angle - x / PITCH).rem_euclid(1.0);
                phase = (phase + 0.5).rem_euclid(1.0) - 0.5;
            }
        });
        phases.push(phase);
        lathe.rig.say("motion.move x=0 rapid=1");
        assert_eq!(lathe.end(), Ok(()));
    }
    assert!(phases.iter().all(|p| p.abs() < 1e-4), "{phases:?}");
}

#[test]
fn segments_in_a_row_are_one_thread() {
    let mut lathe = Lathe::new(600.0, 400.0);
    for to in ["x=20", "x=28 y=1", "x=32 y=5"] {
        lathe.rig.say(&format!("motion.move {to} pitch=1.5 mode=blend tolerance=0.1"));
    }
    lathe.rig.say("motion.move x=0 velocity=80");
    let mut slowest = f64::INFINITY;
    lathe.until(|l| l.x() > 2.0);
    while lathe.x() < 31.0 && lathe.rig.float("spindle.0.sync-error").abs() < 0.5 {
        lathe.cycle();
        slowest = slowest.min(lathe.rig.float("motion.current-vel"));
    }
    assert!(lathe.x() >= 31.0 && slowest > 8.0, "{slowest}");
    assert_eq!(lathe.end(), Ok(()));
    assert_eq!((lathe.x(), lathe.rig.joint(1, "pos-cmd")), (0.0, 5.0));
    // What follows did not begin before the thread had ended, and a thread cannot be run backwards.
    assert!(lathe.rig.bench.said().is_empty());
}

/// A thread that is given while another one brakes goes on with it; one that is given later begins at the index.
#[test]
fn a_thread_that_is_given_later_begins_at_the_index() {
    for is_late in [false, true] {
        let mut lathe = Lathe::new(600.0, 400.0);
        lathe.rig.say("motion.move x=40 pitch=1.5");
        let start = if is_late {
            assert_eq!(lathe.end(), Ok(()));
            40.0
        } else {
            lathe.until(|l| l.x() >= 39.9);
            0.0
        };
        lathe.rig.say("motion.move x=80 pitch=1.5");
        let ticket = lathe.rig.bench.tickets().len() - 1;
        let mut has_sought = false;
        while lathe.rig.bench.tickets()[ticket] == TicketState::Pending {
            lathe.cycle();
            has_sought |= lathe.rig.is("spindle.0.index-enable");
            if lathe.x() > 45.0 {
                lathe.measure(start, 79.6);
            }
        }
        assert_eq!(has_sought, is_late);
        assert!(lathe.is_together && lathe.worst <= 1.0, "{}", lathe.worst);
        assert_eq!((lathe.ticket(), lathe.x()), (TicketState::Done, 80.0));
        assert!(lathe.rig.bench.said().is_empty());
    }
}

/// A refused move behind a thread ends what comes after it, and the thread itself goes on.
#[test]
fn a_refused_move_of_a_thread_leaves_the_thread_before_it() {
    let limit = "linear move on line {} would exceed Y's positive limit, {}, by {}";
    for is_late in [false, true] {
        let mut lathe = Lathe::new(600.0, 400.0);
        lathe.rig.say("motion.move x=40 pitch=1.5");
        let first = lathe.rig.bench.tickets().len() - 1;
        if is_late {
            lathe.until(|l| l.x() > 20.0);
        }
        lathe.rig.say("motion.move y=300 pitch=1.5");
        lathe.rig.say("motion.move y=5 pitch=1.5");
        lathe.until(|l| l.rig.bench.tickets()[first + 2] != TicketState::Pending);
        let states = lathe.rig.bench.tickets();
        assert_eq!(states[first + 1], TicketState::Failed(limit));
        assert_eq!(states[first + 2], TicketState::Failed("a move before this one was refused"));
        lathe.until(|l| l.rig.bench.tickets()[first] != TicketState::Pending);
        assert_eq!(lathe.rig.bench.tickets()[first], TicketState::Done);
        assert_eq!(lathe.rig.places(), [40.0, 0.0, 0.0]);
        lathe.rig.say("motion.move y=10 pitch=1.5");
        assert_eq!(lathe.end(), Ok(()));
        assert_eq!(lathe.rig.places(), [40.0, 10.0, 0.0]);
    }
}

#[test]
fn limits_win_over_a_spindle_that_is_too_quick() {
    for limit in [None, Some(0.4)] {
        let mut lathe = Lathe::new(600.0, 4000.0);
        if let Some(limit) = limit {
            lathe.rig.say(&format!("motion.configure spindle=0 sync-error={limit}"));
        }
        lathe.rig.say("motion.move x=40 pitch=6");
        lathe.until(|l| l.x() > 10.0);
        lathe.rig.say("motion.spindle override=0.1");
        let thread = lathe.rig.bench.tickets().len() - 2;
        let (mut most, mut seen) = (0.0_f64, false);
        while lathe.rig.bench.tickets()[thread] == TicketState::Pending {
            lathe.cycle();
            let error = lathe.rig.float("spindle.0.sync-error");
            most = most.max(error.abs());
            seen |= error < -0.1;
        }
        assert!(seen, "{most}");
        match limit {
            None => {
                assert_eq!(lathe.rig.bench.tickets()[thread], TicketState::Done);
                assert!(most > 0.5, "{most}");
            }
            Some(limit) => {
                let why =
                    "the axes are farther from their place at the spindle than its sync-error";
                assert_eq!(lathe.rig.bench.tickets()[thread], TicketState::Failed(why));
                assert_eq!(lathe.rig.bench.said(), [why]);
                assert!(most < limit + 0.1, "{most}");
                assert_eq!(lathe.rig.float("spindle.0.speed-out"), 0.0);
                assert!(lathe.x() < 30.0);
            }
        }
    }
}

/// Causes that keep a thread from beginning, and the end of the wait.
#[test]
fn a_thread_waits_for_its_spindle() {
    let no_index = "the spindle turned three times without its index";
    for (what, why) in [("index", no_index), ("speed", "aborted"), ("turns", "aborted")] {
        let mut lathe = Lathe::new(600.0, 400.0);
        match what {
            "index" => lathe.turner.has_index = false,
            _ => lathe.turner.is_stalled = true,
        }
        if what == "turns" {
            lathe.rig.say("motion.spindle speed=0");
        }
        lathe.cycles(200);
        lathe.rig.say("motion.move x=40 pitch=1.5");
        lathe.cycles(200);
        assert_eq!(lathe.ticket(), TicketState::Pending);
        assert_eq!(lathe.rig.is("spindle.0.index-enable"), what != "speed", "{what}");
        let ticket = lathe.rig.bench.tickets().len() - 1;
        if why == "aborted" {
            lathe.cycles(1000);
            lathe.rig.say("motion.abort");
        }
        lathe.until(|l| l.rig.bench.tickets()[ticket] != TicketState::Pending);
        assert_eq!(lathe.rig.bench.tickets()[ticket], TicketState::Failed(why), "{what}");
        lathe.cycles(2);
        assert!(!lathe.rig.is("spindle.0.index-enable"), "{what}");
        assert_eq!(lathe.x(), 0.0);
        assert!(lathe.rig.is("motion.motion-enabled"));
        // The next move goes on.
        lathe.rig.say("motion.spindle speed=0");
        lathe.turner.is_stalled = false;
        lathe.cycles(300);
        lathe.rig.say("motion.move x=3 velocity=20");
        assert_eq!(lathe.end(), Ok(()), "{what}");
    }
}

#[test]
fn a_spindle_that_stands_still_stops_the_thread_until_it_turns() {
    let mut lathe = Lathe::new(600.0, 100.0);
    let mut stood = 0;
    lathe.thread(|lathe, x| {
        lathe.turner.is_stalled = 20.0 < x && stood < 500;
        if lathe.turner.is_stalled && lathe.turner.speed == 0.0 {
            stood += 1;
            assert!(lathe.rig.float("motion.current-vel") < 0.7);
        }
    });
    assert_eq!(stood, 500);
}

#[test]
fn turns_that_are_no_number_end_the_thread() {
    // At the index, before the axes move.
    let mut lathe = Lathe::new(600.0, 400.0);
    lathe.rig.say("motion.move x=40 pitch=1.5");
    lathe.until(|l| l.rig.is("spindle.0.index-enable"));
    lathe.rig.bench.set("spindle.0.revs", f64::NAN);
    lathe.rig.bench.set("spindle.0.index-enable", false);
    lathe.rig.cycles(2);
    let why = "the pin revs of the spindle is not a number";
    assert_eq!((lathe.ticket(), lathe.x()), (TicketState::Failed(why), 0.0));
    assert!(lathe.rig.is("motion.motion-enabled"));
    // In the thread.
    let mut lathe = Lathe::new(600.0, 400.0);
    lathe.rig.say("motion.move x=40 pitch=1.5");
    lathe.until(|l| l.x() > 10.0);
    lathe.turner.angle = f64::NAN;
    assert_eq!(lathe.end(), Err("the pin revs of the spindle is not a number"));
    assert!(lathe.x() < 12.0 && lathe.rig.is("motion.motion-enabled"));
}

#[test]
fn moves_that_cannot_follow_are_refused() {
    let mut lathe = Lathe::new(0.0, 80.0);
    for (text, why) in [
        ("motion.tap x=15 pitch=1.5", "a tap needs a spindle that turns"),
        (
            "motion.tap pitch=1.5 y=0",
            "a move that follows a spindle needs its longest part in x y z",
        ),
        (
            "motion.tap y=300 pitch=1.5",
            "linear move on line {} would exceed Y's positive limit, {}, by {}",
        ),
    ] {
        lathe.rig.say(text);
        assert_eq!(lathe.end(), Err(why), "{text}");
        lathe.rig.say("motion.move x=1 velocity=20");
        assert_eq!(lathe.end(), Ok(()), "{text}");
        lathe.rig.say("motion.move x=0 velocity=20");
        assert_eq!(lathe.end(), Ok(()), "{text}");
    }
    for text in [
        "motion.move x=1 pitch=0",
        "motion.move x=1 pitch=1 per-turn=1",
        "motion.move x=1 pitch=1 velocity=3",
        "motion.move x=1 pitch=1 spindle=1",
        "motion.tap x=1 pitch=1 return=0",
    ] {
        assert!(lathe.rig.try_say(text).is_err(), "{text}");
    }
}

#[test]
fn a_feed_per_turn_scales_with_the_spindle_and_the_override() {
    let mut lathe = Lathe::new(600.0, 400.0);
    lathe.cycles(200);
    lathe.rig.say("motion.move x=100 per-turn=2");
    lathe.cycles(300);
    let speed = |lathe: &Lathe| lathe.rig.float("motion.current-vel");
    assert!((speed(&lathe) - 20.0).abs() < 1e-6, "{}", speed(&lathe));
    lathe.rig.say("motion.spindle override=0.5");
    lathe.cycles(300);
    assert!((speed(&lathe) - 10.0).abs() < 1e-6, "{}", speed(&lathe));
    lathe.rig.say("motion.feed override=0.5");
    lathe.cycles(300);
    assert!((speed(&lathe) - 5.0).abs() < 1e-6, "{}", speed(&lathe));
    lathe.rig.bench.set("motion.feed-hold", true);
    lathe.cycles(300);
    assert_eq!(speed(&lathe), 0.0);
    lathe.rig.bench.set("motion.feed-hold", false);
    lathe.rig.say("motion.feed override=1");
    assert_eq!(lathe.end(), Ok(()));
}

/// A feed per turn governs X, also beside an axis that goes farther, and A where A alone moves: to a place at a closed form of its
/// time, and with that velocity on the pins.
#[test]
fn a_feed_per_turn_is_that_of_its_lead_group() {
    for ([x, a], feed) in
        [([1.0_f64, 30.0_f64], 0.05), ([4.0, 0.0], 0.2), ([0.0, 30.0], 2.0), ([-1.0, -30.0], 0.02)]
    {
        let text = format!("motion.move x={x} a={a} per-turn={feed}");
        let mut lathe = Lathe::on(&["coordinates=xay"], 600.0, 400.0);
        // The highest velocity of lengths does not count for angles.
        lathe.rig.say("motion.configure max-velocity=10");
        lathe.cycles(300);
        lathe.rig.say(&text);
        lathe.until(|l| l.rig.float("motion.current-vel") > 0.0);
        let (mut cycles, mut top, mut fastest) = (0_u32, 0.0_f64, 0.0_f64);
        let mut before = lathe.rig.joint(1, "pos-cmd");
        while lathe.ticket() == TicketState::Pending {
            lathe.cycle();
            cycles += 1;
            top = top.max(lathe.rig.float("motion.current-vel"));
            let at = lathe.rig.joint(1, "pos-cmd");
            fastest = fastest.max((at - before).abs() / DT);
            before = at;
        }
        let (speed, way) = (10.0 * feed, if x == 0.0 { a } else { x }.abs());
        assert!((top - speed).abs() < 1e-6 * speed, "{text}: {top}");
        let of_a = speed * a.abs() / way;
        assert!((fastest - of_a).abs() < 1e-6, "{text}: {fastest}, not {of_a}");
        let (took, wanted) = (f64::from(cycles) * DT, way / speed);
        assert!((took - wanted).abs() < 0.02 * wanted + 0.02, "{text}: {took} of {wanted}");
    }
}
