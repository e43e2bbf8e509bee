//! Two spindles at different speeds: each move follows its own one, and the other one does not matter.

use super::{
    DT, Rig,
    follow::{Lathe, PITCH, Turner},
};
use crate::Motmod;
use hal_bench::Bench;
use hal_component::{MotionStatus, Wait, abi::TicketState};
use trivkins::Trivkins;

/// Returns a lathe whose moves follow spindle 1; spindle 0 turns at another speed, in turns per minute.
fn lathe(first: f64, second: f64) -> Lathe {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    let mut rig = Rig::load::<Motmod>(bench, &["num_spindles=2"]);
    rig.done("motion.enable");
    rig.done("motion.home joint=all");
    rig.say(&format!("motion.spindle spindle=0 speed={first}"));
    rig.say(&format!("motion.spindle spindle=1 speed={second}"));
    rig.cycle();
    rig.turner = Some(Turner::of(0, 400.0));
    let mut lathe = Lathe::of(rig, Turner::of(1, 80.0));
    lathe.cycles(400);
    lathe
}

fn index(lathe: &Lathe) -> [bool; 2] {
    [0, 1].map(|n| lathe.rig.is(&format!("spindle.{n}.index-enable")))
}

/// Runs a move that follows the place of spindle 1, forwards in x at first. Returns the worst distance from it once `from` is passed,
/// in travels of a cycle at `turns` per second, up to `until`.
fn worst(lathe: &mut Lathe, text: &str, turns: f64, [from, until]: [f64; 2]) -> f64 {
    lathe.rig.say(text);
    let ticket = lathe.rig.bench.tickets().len() - 1;
    let sign = turns.signum();
    let (mut worst, mut is_in, mut seeks) = (0.0_f64, false, false);
    while lathe.rig.bench.tickets()[ticket] == TicketState::Pending {
        lathe.cycle();
        let [other, own] = index(lathe);
        assert!(!other, "{text}: the index of the other spindle");
        seeks |= own;
        assert_eq!(lathe.rig.float("spindle.0.sync-error"), 0.0, "{text}");
        let x = lathe.x();
        is_in |= x > from;
        is_in &= x > 0.0 && x < until;
        if is_in {
            worst = worst.max((x - sign * PITCH * lathe.turner.revs()).abs());
        }
    }
    assert!(seeks, "{text}");
    assert_eq!(lathe.rig.bench.tickets()[ticket], TicketState::Done, "{text}");
    worst / (PITCH * turns.abs() * DT)
}

#[test]
fn threads_and_taps_follow_their_own_spindle() {
    for (first, second) in
        [(300.0, 600.0), (-1200.0, 600.0), (0.0, 600.0), (600.0, -600.0), (2000.0, 180.0)]
    {
        let what = format!("{first} and {second} turns/min");
        let turns = second / 60.0;
        let mut lathe = lathe(first, second);
        let text = format!("motion.move x=40 spindle=1 pitch={PITCH}");
        let off = worst(&mut lathe, &text, turns, [5.0, 39.0]);
        assert!(off <= 1.0, "{what}: {off} travels from the spindle");
        assert_eq!(lathe.x(), 40.0, "{what}");
        lathe.rig.say("motion.move x=0 rapid=1");
        assert_eq!(lathe.end(), Ok(()), "{what}");

        let text = format!("motion.tap x=15 spindle=1 pitch={PITCH}");
        let off = worst(&mut lathe, &text, turns, [5.0, 100.0]);
        assert!(off <= 1.0, "{what}: {off} travels from the spindle in the tap");
        assert_eq!(lathe.x(), 0.0, "{what}");
        let speeds = [0, 1].map(|n| lathe.rig.float(&format!("spindle.{n}.speed-out")));
        assert_eq!(speeds, [first, second], "{what}");

        lathe.cycles(600);
        lathe.rig.say("motion.move x=20 spindle=1 per-turn=2");
        lathe.cycles(300);
        let speed = lathe.rig.float("motion.current-vel");
        assert!((speed - 2.0 * turns.abs()).abs() < 1e-6, "{what}: {speed}");
        assert_eq!(lathe.end(), Ok(()), "{what}");
        assert!(lathe.rig.bench.said().is_empty(), "{what}");
    }
}

/// In a pass, trouble of the other spindle does not matter, and a wait has the number of its own.
#[test]
fn only_its_own_spindle_stops_a_pass() {
    for text in [
        format!("motion.move x=30 spindle=1 pitch={PITCH}"),
        format!("motion.tap x=30 spindle=1 pitch={PITCH}"),
        format!("motion.move x=30 spindle=1 per-turn={PITCH}"),
    ] {
        for is_own in [false, true] {
            let mut lathe = lathe(300.0, 600.0);
            lathe.rig.say(&text);
            lathe.until(|l| l.x() > 10.0);
            let other = lathe.rig.turner.as_mut().unwrap();
            if is_own { &mut lathe.turner } else { other }.is_stalled = true;
            let ticket = lathe.rig.bench.tickets().len() - 1;
            if is_own {
                lathe.cycles(2000);
                let status: MotionStatus = lathe.rig.bench.snapshot("motion.status");
                assert_eq!(
                    (Wait::of(status.wait), status.wait_number),
                    (Wait::AtSpeed, 1),
                    "{text}"
                );
                assert_eq!(lathe.rig.bench.tickets()[ticket], TicketState::Pending, "{text}");
                lathe.turner.is_stalled = false;
            } else {
                // Only a move that begins waits for all spindles.
                lathe.until(|l| l.x() > 25.0);
                lathe.rig.turner.as_mut().unwrap().is_stalled = false;
            }
            lathe.until(|l| l.rig.bench.tickets()[ticket] != TicketState::Pending);
            assert_eq!(lathe.rig.bench.tickets()[ticket], TicketState::Done, "{text} {is_own}");
        }
    }
}
