//! Rigid taps.

use super::{
    DT,
    follow::{Lathe, PITCH},
};
use hal_component::abi::TicketState;

/// Runs a tap to its end; returns the deepest x, and the worst distance from the spindle in travels at full speed.
fn tap(lathe: &mut Lathe, speed: f64, mut at: impl FnMut(&mut Lathe)) -> (f64, f64) {
    let (mut deepest, mut worst) = (0.0_f64, 0.0_f64);
    let ticket = lathe.rig.bench.tickets().len() - 1;
    let travel = PITCH * speed * DT;
    let mut is_together = false;
    while lathe.rig.bench.tickets()[ticket] == TicketState::Pending {
        lathe.cycle();
        let x = lathe.x() - 20.0;
        let error = (x - PITCH * lathe.turner.revs()).abs();
        is_together |= x > 1.0 && error < travel;
        if is_together && x > 0.0 {
            worst = worst.max(error / travel);
        }
        deepest = deepest.max(x);
        at(lathe);
    }
    (deepest, worst)
}

#[test]
fn a_tap_goes_in_and_out_with_the_spindle() {
    for (speed, back) in [(10.0, 1.0), (3.0, 2.0)] {
        let mut lathe = Lathe::new(60.0 * speed, 80.0);
        lathe.rig.say("motion.move x=20 velocity=50");
        lathe.rig.say(&format!("motion.tap x=35 pitch={PITCH} return={back}"));
        lathe.until(|l| l.x() > 20.01);
        let mut turned = Vec::new();
        let (deepest, worst) = tap(&mut lathe, speed, |lathe| {
            turned.push(lathe.rig.float("spindle.0.speed-out") / 60.0);
        });
        assert_eq!(lathe.ticket(), TicketState::Done);
        assert_eq!(lathe.rig.places(), [20.0, 0.0, 0.0]);
        turned.dedup();
        assert_eq!(turned, [speed, -speed * back, speed]);
        // The spindle needs v²/2a turns to come to rest.
        let overrun = PITCH * speed * speed / 160.0;
        assert!((deepest - 15.0 - overrun).abs() < 0.1, "{deepest}, {overrun}");
        assert!(worst <= 1.0, "{worst} travels");
        // A second one, and a move behind it.
        lathe.rig.say(&format!("motion.tap x=30 pitch={PITCH}"));
        lathe.rig.say("motion.move x=21 velocity=30");
        assert_eq!(lathe.end(), Ok(()));
        assert_eq!(lathe.x(), 21.0);
        assert!(lathe.rig.bench.said().is_empty());
    }
}

#[test]
fn an_aborted_tap_leaves_its_hole() {
    for depth in [3.0, 10.0, 15.1] {
        let mut lathe = Lathe::new(600.0, 80.0);
        lathe.rig.say("motion.move x=20 velocity=50");
        lathe.rig.say("motion.tap x=35 pitch=1.5");
        lathe.rig.say("motion.move x=50 velocity=50");
        lathe.until(|l| l.x() > 20.0 + depth);
        lathe.rig.say("motion.abort");
        let tap = lathe.rig.bench.tickets().len() - 3;
        let mut deepest = 0.0_f64;
        while lathe.rig.bench.tickets()[tap] == TicketState::Pending {
            lathe.cycle();
            let x = lathe.x() - 20.0;
            deepest = deepest.max(x);
            if x > 0.0 {
                let error = (x - PITCH * lathe.turner.revs()).abs();
                assert!(error < 15.0 * DT, "{error} at {x}");
            }
        }
        let states = lathe.rig.bench.tickets();
        assert!(states[tap..tap + 2].iter().all(|t| *t == TicketState::Failed("aborted")));
        assert!(deepest < 17.0 && lathe.x() <= 20.0 && lathe.x() > 17.0, "{}", lathe.x());
        lathe.cycles(200);
        assert_eq!((lathe.rig.float("spindle.0.speed-out"), lathe.turner.speed), (0.0, 0.0));
        assert!(lathe.rig.is("motion.in-position") && lathe.rig.is("motion.motion-enabled"));
        assert_eq!(lathe.ticket(), TicketState::Done, "the abort");
        lathe.rig.say("motion.move x=0 velocity=50");
        assert_eq!(lathe.end(), Ok(()));
    }
}

/// A tap whose axes lose their spindle goes out of the hole, and the spindle turns with it.
#[test]
fn a_tap_too_far_from_its_spindle_leaves_its_hole() {
    let mut lathe = Lathe::new(600.0, 4000.0);
    lathe.rig.say("motion.configure spindle=0 sync-error=0.4");
    lathe.rig.say("motion.tap x=60 pitch=6");
    lathe.until(|l| l.x() > 20.0);
    lathe.rig.say("motion.spindle override=0.1");
    let tap = lathe.rig.bench.tickets().len() - 2;
    let mut error = 0.0;
    while lathe.rig.bench.tickets()[tap] == TicketState::Pending {
        lathe.cycle();
        if lathe.turner.speed < 0.0 {
            error = f64::max(error, (lathe.x() - 6.0 * lathe.turner.revs()).abs());
        }
        assert!(lathe.x() <= 0.0 || lathe.rig.float("spindle.0.speed-out") != 0.0);
    }
    let why = "the axes are farther from their place at the spindle than its sync-error";
    assert_eq!(lathe.rig.bench.tickets()[tap], TicketState::Failed(why));
    assert_eq!(lathe.rig.bench.said(), [why]);
    assert!(lathe.x() <= 0.0 && lathe.x() > -6.0, "{}", lathe.x());
    assert!(error < 3.0, "{error}");
    lathe.cycles(200);
    assert_eq!((lathe.rig.float("spindle.0.speed-out"), lathe.turner.speed), (0.0, 0.0));
    assert!(lathe.rig.is("motion.motion-enabled"));
}

#[test]
fn a_tap_whose_spindle_does_not_reverse_ends_in_its_place() {
    for (second, why) in [
        (false, "the spindle still turned ten turns beyond the end of the tap, or at a limit"),
        (true, "aborted"),
    ] {
        let mut lathe = Lathe::new(600.0, 80.0);
        lathe.rig.say("motion.tap x=15 pitch=1.5");
        lathe.until(|l| l.x() > 14.0);
        // It goes on as it turns.
        lathe.turner.acceleration = 0.0;
        let tap = lathe.rig.bench.tickets().len() - 1;
        if second {
            lathe.rig.say("motion.abort");
            lathe.cycles(50);
            assert_eq!(lathe.rig.bench.tickets()[tap], TicketState::Pending);
            lathe.rig.say("motion.abort");
        }
        lathe.until(|l| l.rig.bench.tickets()[tap] != TicketState::Pending);
        assert_eq!(lathe.rig.bench.tickets()[tap], TicketState::Failed(why));
        assert!(lathe.x() <= 30.0 && lathe.rig.is("motion.motion-enabled"), "{}", lathe.x());
        assert_eq!(lathe.rig.float("spindle.0.speed-out"), 0.0);
    }
}
