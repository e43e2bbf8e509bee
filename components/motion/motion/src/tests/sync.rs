//! Threads and taps under limits of jerk, against closed forms of what the axes can do.

use super::{
    DT, LIMITS,
    follow::{Lathe, PITCH},
};
use hal_component::{
    MotionCommand, MotionRef, MotionToken, abi::TicketState, motion_flags as flags,
    motion_kind as kind,
};
use hal_trajectory::Limits;

/// Limits of jerk of the tests, in units/s³.
const JERKS: [f64; 4] = [f64::INFINITY, 3e5, 1e5, 5e4];

const FAR: &str = "the axes are farther from their place at the spindle than its sync-error";

impl Lathe {
    /// Returns a lathe whose x has this limit of jerk.
    fn with_jerk(jerk: f64, speed: f64, acceleration: f64) -> Self {
        let lathe = Self::new(speed, acceleration);
        if jerk.is_finite() {
            lathe.rig.say(&format!("motion.configure joint=0 max-jerk={jerk}"));
        }
        lathe
    }

    /// Runs a command for the spindle's move to its end. `at` is called with x in each cycle.
    fn pass(&mut self, text: &str, mut at: impl FnMut(&mut Self, f64)) -> TicketState {
        self.rig.say(text);
        let ticket = self.rig.bench.tickets().len() - 1;
        for _ in 0..60_000 {
            self.cycle();
            let x = self.x();
            at(self, x);
            if self.rig.bench.tickets()[ticket] != TicketState::Pending {
                return self.rig.bench.tickets()[ticket];
            }
        }
        panic!("{text}: never ends, at {}", self.x())
    }
}

/// Limits of x with this limit of jerk.
fn limits(jerk: f64) -> Limits {
    let (velocity, acceleration, ..) = LIMITS[0];
    Limits { velocity, acceleration, jerk }
}

/// Longest way to a spindle's place: a rise and a fall to √½ above its speed, and the time that the acceleration needs to
/// change.
fn lead_in(speed: f64, jerk: f64) -> f64 {
    let a = LIMITS[0].1;
    let change = 2.2 * f64::min(a / jerk, 2.2 * (speed / jerk).sqrt());
    speed * (2.6 * speed / a + change + 12.0 * DT)
}

/// Longest distance from a spindle whose acceleration steps by `step` units/s². With a limit of jerk the axes' acceleration rises
/// from there to twice the step before their velocity is that of the spindle: no motion does better than ⅔·step³/jerk². The pins
/// tell of the step a cycle later.
fn distance(travel: f64, step: f64, jerk: f64) -> f64 {
    f64::max(travel, 0.8 * step.powi(3) / (jerk * jerk) + 2.0 * step * DT * DT)
}

/// From the lead-in to the run-out the axes are within a cycle's travel of the spindle, at every speed, jerk and acceleration of
/// the spindle up to half of that of the axes.
#[test]
fn threads_stay_with_their_spindle_from_the_first_cut() {
    for jerk in JERKS {
        for (speed, acceleration) in
            [(1.0, 400.0), (10.0, 40.0), (10.0, 200.0), (10.0, 450.0), (25.0, 450.0), (40.0, 100.0)]
        {
            let what = format!("jerk {jerk}, {speed} turns/s, {acceleration} turns/s²");
            let mut lathe = Lathe::with_jerk(jerk, 60.0 * speed, acceleration);
            let top = PITCH * speed;
            let first = lead_in(top, jerk);
            assert!(limits(jerk).lead_in(top, DT) <= first, "{what}: the plan's lead-in");
            let last = 60.0 - limits(jerk).run_out(top, DT);
            let most = distance(top * DT, PITCH * acceleration, jerk);
            let (mut worst, mut scale) = (0.0_f64, 1.0);
            let end = lathe.pass(&format!("motion.move x=60 pitch={PITCH}"), |lathe, x| {
                let place = PITCH * lathe.turner.revs();
                if x > 0.0 && first <= place && place <= last {
                    worst = worst.max((x - place).abs());
                    let shown = lathe.rig.float("spindle.0.sync-error");
                    assert!((shown - (place - x)).abs() < 1e-9, "{what}: {shown} at {x}");
                }
                let wanted = if x > 30.0 && (x / 8.0).fract() >= 0.5 { 0.4 } else { 1.0 };
                if wanted != scale {
                    scale = wanted;
                    lathe.rig.say(&format!("motion.spindle override={scale}"));
                }
            });
            assert_eq!(end, TicketState::Done, "{what}");
            assert_eq!(lathe.x(), 60.0, "{what}");
            assert!(worst <= most, "{what}: {worst}, at most {most}");
            assert!(lathe.rig.bench.said().is_empty());
        }
    }
}

/// A tap is as deep as its spindle turns, and its way back is with it too.
#[test]
fn taps_are_as_deep_as_their_spindle_turns() {
    for jerk in JERKS {
        for (speed, acceleration) in [(3.0, 40.0), (10.0, 80.0), (10.0, 450.0), (20.0, 200.0)] {
            for back in [1.0, 2.0] {
                let what = format!("jerk {jerk}, {speed} turns/s, {acceleration} turns/s², {back}");
                let mut lathe = Lathe::with_jerk(jerk, 60.0 * speed, acceleration);
                let first = lead_in(PITCH * speed, jerk);
                // The acceleration of the spindle changes its sign nowhere, but begins and ends.
                let most = distance(PITCH * speed * DT, PITCH * acceleration, jerk);
                let (mut worst, mut deepest, mut turned) = (0.0_f64, 0.0_f64, 0.0_f64);
                let text = format!("motion.tap x=12 pitch={PITCH} return={back}");
                let (mut is_in, mut is_out) = (false, false);
                let end = lathe.pass(&text, |lathe, x| {
                    let place = PITCH * lathe.turner.revs();
                    is_in |= x > 0.0 && place >= first;
                    is_out |= is_in && x <= 0.0;
                    if is_in && !is_out {
                        worst = worst.max((x - place).abs());
                        turned = turned.max(place);
                    }
                    deepest = deepest.max(x);
                });
                assert_eq!(end, TicketState::Done, "{what}");
                assert_eq!(lathe.x(), 0.0, "{what}");
                assert!(worst <= most, "{what}: {worst}, at most {most}");
                assert!((deepest - turned).abs() <= most, "{what}: {deepest} of {turned}");
                let overrun = PITCH * speed * speed / (2.0 * acceleration);
                let off = deepest - 12.0 - overrun;
                assert!(off.abs() <= most + 4.0 * PITCH * speed * DT, "{what}: {off}");
            }
        }
    }
}

/// Trouble of a spindle in a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trouble {
    Slows,
    Stops,
    Reverses,
    Jumps,
}

/// A spindle that leaves the axes behind: the limits hold, the pin has the distance, and sync-error ends the pass.
#[test]
fn a_spindle_in_trouble_ends_the_pass_or_is_followed() {
    for jerk in JERKS {
        for trouble in [Trouble::Slows, Trouble::Stops, Trouble::Reverses, Trouble::Jumps] {
            for limit in [None, Some(0.4)] {
                let what = format!("jerk {jerk}, {trouble:?}, {limit:?}");
                let mut lathe = Lathe::with_jerk(jerk, 600.0, 4000.0);
                if let Some(limit) = limit {
                    lathe.rig.say(&format!("motion.configure spindle=0 sync-error={limit}"));
                }
                let (mut since, mut most, mut farthest) = (0, 0.0_f64, 0.0_f64);
                let text = format!("motion.move x=40 pitch={PITCH}");
                let end = lathe.pass(&text, |lathe, x| {
                    assert!(x >= farthest, "{what}: back from {farthest} to {x}");
                    farthest = x;
                    most = most.max(lathe.rig.float("spindle.0.sync-error").abs());
                    since += i32::from(x > 20.0);
                    let is_over = since > 400;
                    match trouble {
                        Trouble::Slows if since == 1 => {
                            lathe.rig.say("motion.spindle override=0.1");
                        }
                        Trouble::Stops => lathe.turner.is_stalled = since > 0 && !is_over,
                        Trouble::Reverses if since == 1 => {
                            lathe.rig.say("motion.spindle speed=-600");
                        }
                        Trouble::Reverses if since == 401 && limit.is_none() => {
                            lathe.rig.say("motion.spindle speed=600");
                        }
                        Trouble::Jumps if since == 1 => lathe.turner.angle += 7.0,
                        Trouble::Slows | Trouble::Reverses | Trouble::Jumps => {}
                    }
                });
                let why = match (trouble, limit) {
                    (Trouble::Jumps, _) => Some(
                        "the turns of the spindle jumped: its encoder has lost the place of its index",
                    ),
                    (Trouble::Reverses, Some(_)) => Some(FAR),
                    _ => None,
                };
                match why {
                    Some(why) => {
                        assert_eq!(end, TicketState::Failed(why), "{what}");
                        assert_eq!(lathe.rig.bench.said(), [why], "{what}");
                        assert!(lathe.x() < 30.0, "{what}");
                        lathe.cycles(3);
                        assert_eq!(lathe.rig.float("spindle.0.speed-out"), 0.0);
                    }
                    None => {
                        assert_eq!((end, lathe.x()), (TicketState::Done, 40.0), "{what}");
                        assert!(most < 0.4 || trouble == Trouble::Reverses, "{what}: {most}");
                    }
                }
                assert!(lathe.rig.is("motion.motion-enabled"));
            }
        }
    }
}

/// Passes that the axes cannot follow are refused before anything moves: the speed, and a way that is no longer than lead-in and run-out.
#[test]
fn what_cannot_be_followed_is_refused_before_it_moves() {
    const FAST: &str =
        "a pitch of {} at {} turns/min needs {} units/s along the path, and the axes allow {}";
    const SHORT: &str = "the thread is {} long, and at {} turns/min it needs a lead-in of {} and a run-out of {}: begin it \
                         farther from the cut, or turn slower";
    const SHALLOW: &str = "the tap is {} long, and at {} turns/min it needs a lead-in of {}: begin it farther from the hole, \
                           or turn slower";
    const PER_TURN: &str = "move on line {}: a feed of {} per turn at {} turns/min is faster than the axes allow, {} units/s";
    for jerk in JERKS {
        for (text, speed, why) in [
            ("motion.move x=60 per-turn=9.1", 600.0, Some(PER_TURN)),
            ("motion.move x=60 y=60 per-turn=9.1", 600.0, None),
            ("motion.move z=6 per-turn=1.1", -600.0, Some(PER_TURN)),
            ("motion.move z=6 per-turn=0.9", 600.0, None),
            ("motion.arc x=20 center-x=10 center-y=0 per-turn=9.1", 600.0, Some(PER_TURN)),
            ("motion.arc x=20 center-x=10 center-y=0 per-turn=0.9", 600.0, None),
            ("motion.move x=60 pitch=9.1", 600.0, Some(FAST)),
            ("motion.move x=60 pitch=9", -600.0, Some(FAST)),
            ("motion.move x=60 pitch=8", 600.0, None),
            ("motion.move z=60 pitch=1.1", 600.0, Some(FAST)),
            ("motion.tap x=60 pitch=9.1", 600.0, Some(FAST)),
            ("motion.tap x=60 pitch=5 return=2", 600.0, Some(FAST)),
            ("motion.move x=0.4 pitch=1.5", 600.0, Some(SHORT)),
            ("motion.move x=3 pitch=1.5", 600.0, None),
            ("motion.tap x=0.3 pitch=1.5", 600.0, Some(SHALLOW)),
            ("motion.tap x=3 pitch=1.5", 600.0, None),
        ] {
            let mut lathe = Lathe::with_jerk(jerk, speed, 400.0);
            let mut has_moved = false;
            let end = lathe.pass(text, |lathe, _| {
                has_moved |= lathe.rig.places().iter().any(|place| place.abs() > 1e-9);
            });
            match why {
                Some(why) => {
                    assert_eq!(end, TicketState::Failed(why), "{text} {jerk}");
                    assert!(!has_moved, "{text} {jerk}");
                }
                None => assert_eq!(end, TicketState::Done, "{text} {jerk}"),
            }
        }
    }
}

/// The distance is judged from the planned lead-in on, also where the axes never come together with their spindle.
#[test]
fn a_spindle_that_gains_speed_in_the_lead_in_is_judged() {
    for jerk in JERKS {
        let mut lathe = Lathe::with_jerk(jerk, 60.0, 1e5);
        lathe.rig.say("motion.configure spindle=0 sync-error=0.5");
        let mut is_fast = false;
        let end = lathe.pass("motion.move x=60 pitch=8", |lathe, x| {
            if x > 0.0 && !is_fast {
                is_fast = true;
                lathe.rig.say("motion.spindle speed=900");
            }
        });
        assert_eq!(end, TicketState::Failed(FAR), "{jerk}");
        assert!(lathe.x() < 20.0, "{jerk}: {}", lathe.x());
    }
}

/// Moves of one thread with pitches of their own: the spindle has not jumped where the pitch changes, and the largest one is
/// judged before anything moves.
#[test]
fn a_thread_of_several_pitches_is_one_thread() {
    const FAST: &str =
        "a pitch of {} at {} turns/min needs {} units/s along the path, and the axes allow {}";
    for jerk in JERKS {
        for (pitches, why) in [([2.0, 0.1], None), ([0.1, 2.0], None), ([1.0, 9.1], Some(FAST))] {
            let mut lathe = Lathe::with_jerk(jerk, 600.0, 400.0);
            let [first, second] = pitches;
            lathe.rig.say(&format!("motion.move x=20 pitch={first}"));
            let mut has_moved = false;
            let end = lathe.pass(&format!("motion.move x=30 pitch={second}"), |_, x| {
                has_moved |= x.abs() > 1e-9;
            });
            match why {
                Some(_) => {
                    assert!(end != TicketState::Done && !has_moved, "{pitches:?} {jerk}: {end:?}");
                }
                None => {
                    assert_eq!((end, lathe.x()), (TicketState::Done, 30.0), "{pitches:?} {jerk}");
                }
            }
        }
    }
}

/// A thread of many short moves has the length of all of them.
#[test]
fn a_thread_of_many_short_moves_is_long_enough() {
    for jerk in JERKS {
        let mut lathe = Lathe::with_jerk(jerk, 600.0, 400.0);
        // Less than the lead-in and the run-out in all those whose length is looked at.
        for n in 1..200 {
            lathe.rig.say(&format!("motion.move x={} pitch={PITCH}", 0.02 * f64::from(n)));
        }
        let end = lathe.pass(&format!("motion.move x=4 pitch={PITCH}"), |_, _| {});
        assert_eq!((end, lathe.x()), (TicketState::Done, 4.0), "{jerk}");
    }
}

/// A feed per turn that the axes do not reach is refused, but at constant surface speed, where the turns at the move are known
/// only then: there the axes move as fast as they can.
#[test]
fn a_feed_per_turn_at_constant_surface_speed_is_not_judged_beforehand() {
    for (surface, moves) in [(0, false), (flags::SURFACE, true)] {
        let mut lathe = Lathe::with_jerk(f64::INFINITY, 600.0, 400.0);
        let motion: MotionRef = lathe.rig.bench.find();
        let mut pose = [0.0; 9];
        pose[0] = 20.0;
        let flags = flags::VELOCITY_MODE | surface;
        let per_turn = MotionCommand {
            letters: 1,
            pose,
            pitch: 100.0,
            flags,
            ..MotionCommand::new(kind::MOVE)
        };
        motion.push(MotionToken::LOCAL, &per_turn).unwrap();
        lathe.cycles(3000);
        assert_eq!(lathe.x(), if moves { 20.0 } else { 0.0 });
    }
}
