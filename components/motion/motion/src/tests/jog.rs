//! Jogs: by command and by wheel, of joints and of axes.

use super::{LIMITS, Rig, near};
use hal_component::abi::TicketState;

#[test]
fn reaches_its_target_within_its_limits() {
    let mut rig = Rig::homed(&[]);
    for (text, joint, target) in [
        ("motion.jog joint=0 velocity=50 position=100", 0, 100.0),
        ("motion.jog joint=0 velocity=1000 distance=-20", 0, 80.0),
        ("motion.jog joint=1 velocity=0.5 distance=0.01", 1, 0.01),
        ("motion.jog joint=2 velocity=12 position=-30", 2, -30.0),
    ] {
        rig.done(text);
        near(rig.joint(joint, "pos-cmd"), target);
        assert!(rig.is("motion.in-position"));
        assert!(!rig.is("motion.jog-is-active"));
    }
    assert!(!rig.is("motion.teleop-mode") && !rig.is("motion.coord-mode"));
}

#[test]
fn goes_as_fast_as_it_is_told() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.jog joint=0 velocity=-50");
    rig.cycles(100);
    assert_eq!(rig.joint(0, "vel-cmd"), -50.0);
    assert_eq!(rig.joint(0, "acc-cmd"), 0.0);
    assert_eq!(rig.joint(0, "free-vel-lim"), 50.0);
    assert_eq!(rig.float("motion.current-vel"), 50.0);
    // Not homed: as far as the whole range from its starting position.
    near(rig.joint(0, "free-pos-cmd"), -250.0);
    let pins = ["joint.0.kb-jog-active", "joint.0.wheel-jog-active", "joint.0.free-tp-enable"];
    assert_eq!(rig.which(&pins), ["joint.0.kb-jog-active", "joint.0.free-tp-enable"]);
    assert!(!rig.is("joint.0.in-position") && !rig.is("motion.in-position"));
    assert!(rig.is("motion.jog-is-active") && rig.is("joint.1.in-position"));
    rig.done("motion.jog-stop joint=0");
    assert_eq!(rig.joint(0, "vel-cmd"), 0.0);
    assert!(rig.is("motion.in-position"));
    assert_eq!(rig.joint(0, "free-pos-cmd"), rig.joint(0, "pos-cmd"));
}

#[test]
fn soft_limits_hold_when_homed() {
    let mut rig = Rig::homed(&[]);
    for (text, joint, target) in [
        ("motion.jog joint=0 velocity=90", 0, LIMITS[0].3),
        ("motion.jog joint=1 velocity=-90", 1, LIMITS[1].2),
        ("motion.jog joint=2 velocity=10 position=1000", 2, LIMITS[2].3),
        ("motion.jog joint=2 velocity=10 distance=-5000", 2, LIMITS[2].2),
    ] {
        rig.say(text);
        rig.cycles(30_000);
        near(rig.joint(joint, "pos-cmd"), target);
        assert!(rig.is("motion.in-position"));
    }
    assert_eq!(
        rig.bench.said(),
        ["jog of axis Z ends at its limit, 100", "jog of axis Z ends at its limit, -100"]
    );
    // At the limit, motion beyond is not possible, and motion back is.
    rig.done("motion.jog joint=0 velocity=90 distance=10");
    near(rig.joint(0, "pos-cmd"), 200.0);
    rig.done("motion.jog joint=0 velocity=90 distance=-10");
    near(rig.joint(0, "pos-cmd"), 190.0);
    // A joint that is unhomed has no soft limits.
    rig.done("motion.unhome joint=0");
    rig.done("motion.jog joint=0 velocity=90 position=210");
    near(rig.joint(0, "pos-cmd"), 210.0);
}

#[test]
fn distances_add_up_and_directions_turn() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.jog joint=0 velocity=50 distance=-5");
    rig.cycles(30);
    rig.done("motion.jog joint=0 velocity=50 distance=-5");
    near(rig.joint(0, "pos-cmd"), -10.0);
    rig.say("motion.jog joint=0 velocity=80");
    rig.cycles(500);
    rig.done("motion.jog joint=0 velocity=80 position=-20");
    near(rig.joint(0, "pos-cmd"), -20.0);
}

#[test]
fn a_jog_that_is_replaced_or_stopped_says_so() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.jog joint=0 velocity=10 position=100");
    rig.cycles(50);
    let first = rig.bench.ticket();
    assert_eq!(first, Some(TicketState::Pending));
    rig.bench.set("motion.jog-stop", true);
    assert_eq!(rig.end(), Err("stopped by motion.jog-stop"));
    rig.cycles(100);
    assert!(rig.is("motion.in-position"));
    rig.say("motion.jog joint=0 velocity=10 position=100");
    rig.cycles(50);
    rig.strict = false;
    let before = rig.joint(0, "pos-cmd");
    rig.bench.set("motion.jog-stop-immediate", true);
    assert_eq!(rig.end(), Err("stopped by motion.jog-stop-immediate"));
    assert_eq!(rig.joint(0, "pos-cmd"), before);
    rig.bench.set("motion.jog-inhibit", true);
    assert_eq!(
        rig.failed("motion.jog joint=0 velocity=1"),
        "cannot jog while jog-inhibit is active"
    );
}

#[test]
fn axes_move_in_teleop_mode() {
    for kinematics in [&[][..], &["kinstype=b"]] {
        let mut rig = Rig::homed(kinematics);
        rig.say("motion.jog axis=x velocity=1000");
        rig.cycles(300);
        assert!(rig.is("motion.teleop-mode"));
        assert_eq!(rig.float("axis.x.teleop-vel-cmd"), 90.0);
        near(rig.float("axis.x.teleop-pos-cmd"), 200.0);
        assert_eq!(rig.float("axis.x.pos-cmd"), rig.joint(0, "pos-cmd"));
        // Another axis at the same time.
        rig.done("motion.jog axis=Z velocity=5 distance=2");
        near(rig.joint(2, "pos-cmd"), 2.0);
        rig.done("motion.jog-stop");
        assert!(rig.is("motion.in-position"));
        rig.say("motion.jog axis=x velocity=50");
        rig.cycles(20_000);
        near(rig.joint(0, "pos-cmd"), 200.0);
        assert!(!rig.is("motion.on-soft-limit"));
    }
}

#[test]
fn an_axis_obeys_the_slowest_of_its_joints() {
    // Joints 1 and 2 both follow y; joint 2 is the slow one.
    let mut rig = Rig::homed(&["coordinates=xyy"]);
    rig.done("motion.jog axis=y velocity=90 position=20");
    near(rig.joint(1, "pos-cmd"), 20.0);
    assert_eq!(rig.joint(1, "pos-cmd"), rig.joint(2, "pos-cmd"));
    assert_eq!(rig.float("axis.y.teleop-vel-lim"), 10.0);
    // The narrowest limits apply as well: y ends at 100 above, at -50 below.
    rig.done("motion.jog axis=y velocity=90 position=500");
    near(rig.joint(1, "pos-cmd"), 100.0);
    rig.done("motion.jog axis=y velocity=90 position=-500");
    near(rig.joint(1, "pos-cmd"), -50.0);
    // The limits of the axis, where they are narrower.
    rig.say("motion.configure axis=y max-limit=30 max-velocity=4");
    rig.done("motion.jog axis=y velocity=90 position=500");
    near(rig.joint(1, "pos-cmd"), 30.0);
    assert_eq!(rig.float("axis.y.teleop-vel-lim"), 4.0);
}

#[test]
fn a_wheel_moves_a_joint() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("joint.0.jog-scale", 0.1);
    rig.bench.set("joint.0.jog-counts", i32::MAX);
    rig.cycles(2);
    // Not enabled: counts are discarded. They may wrap.
    assert_eq!(rig.joint(0, "pos-cmd"), 0.0);
    rig.bench.set("joint.0.jog-enable", true);
    rig.cycles(1);
    rig.bench.set("joint.0.jog-counts", i32::MIN + 9);
    rig.cycles(10);
    assert!(rig.is("joint.0.wheel-jog-active") && !rig.is("joint.0.kb-jog-active"));
    rig.cycles(1000);
    near(rig.joint(0, "pos-cmd"), 1.0);
    // Lower acceleration; values out of range count as 1, zero disables motion.
    rig.bench.set("joint.0.jog-accel-fraction", 0.5);
    rig.bench.set("joint.0.jog-counts", i32::MIN + 509);
    rig.cycles(2);
    near(rig.joint(0, "acc-cmd"), 675.0);
    rig.cycles(3000);
    near(rig.joint(0, "pos-cmd"), 51.0);
    for (fraction, scale, moved) in
        [(f64::NAN, 0.1, 1.0), (0.0, 0.1, 0.0), (1.0, f64::INFINITY, 0.0), (7.0, -0.1, -1.0)]
    {
        let before = rig.joint(0, "pos-cmd");
        let counts: i32 = rig.bench.get("joint.0.jog-counts");
        rig.bench.set("joint.0.jog-accel-fraction", fraction);
        rig.bench.set("joint.0.jog-scale", scale);
        rig.bench.set("joint.0.jog-counts", counts + 10);
        rig.cycles(1000);
        near(rig.joint(0, "pos-cmd") - before, moved);
    }
    // At the limit it stays.
    rig.bench.set("joint.0.jog-scale", 1.0);
    let counts: i32 = rig.bench.get("joint.0.jog-counts");
    rig.bench.set("joint.0.jog-counts", counts + 100_000);
    rig.cycles(5000);
    near(rig.joint(0, "pos-cmd"), 200.0);
}

#[test]
fn a_wheel_in_velocity_mode_stops_when_it_does() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("joint.0.jog-enable", true);
    rig.bench.set("joint.0.jog-vel-mode", true);
    rig.bench.set("joint.0.jog-scale", 1.0);
    rig.cycles(1);
    rig.bench.set("joint.0.jog-counts", 150_i32);
    rig.cycles(2000);
    // Only the braking distance from full speed.
    near(rig.joint(0, "pos-cmd"), 90.0 * 90.0 / 2.0 / 1350.0);
}

#[test]
fn a_wheel_moves_an_axis_in_teleop_mode_only() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("axis.x.jog-enable", true);
    rig.bench.set("axis.x.jog-scale", 0.5);
    rig.cycles(1);
    rig.bench.set("axis.x.jog-counts", 4_i32);
    rig.cycles(500);
    assert_eq!(rig.joint(0, "pos-cmd"), 0.0);
    rig.done("motion.mode mode=teleop");
    rig.bench.set("axis.x.jog-counts", 14_i32);
    rig.cycles(5);
    assert!(rig.is("axis.x.wheel-jog-active"));
    rig.cycles(500);
    near(rig.joint(0, "pos-cmd"), 5.0);
}

#[test]
fn limits_that_change_on_the_way_are_obeyed_by_braking() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.jog joint=0 velocity=90");
    rig.cycles(500);
    rig.say("motion.configure joint=0 max-velocity=10");
    rig.cycles(100);
    // The current jog keeps its speed; the next one uses the new speed.
    rig.done("motion.jog-stop joint=0");
    rig.say("motion.jog joint=0 velocity=90");
    rig.cycles(500);
    assert_eq!(rig.joint(0, "vel-cmd"), 10.0);
}

#[test]
fn backlash_is_taken_up_softly() {
    let mut rig = Rig::homed(&[]);
    // Jog and correction together keep the joint's limits.
    rig.say("motion.configure joint=0 backlash=0.2");
    rig.done("motion.jog joint=0 velocity=10 position=5");
    near(rig.joint(0, "motor-pos-cmd"), 5.1);
    near(rig.joint(0, "pos-fb"), 5.0);
    rig.say("motion.jog joint=0 velocity=10 position=0");
    for _ in 0..1000 {
        rig.cycle();
        assert!(rig.joint(0, "backlash-vel").abs() <= 0.1 * LIMITS[0].0);
        assert!(rig.joint(0, "f-error").abs() < 0.05);
    }
    assert_eq!(rig.joint(0, "backlash-corr"), -0.1);
    near(rig.joint(0, "backlash-filt"), -0.1);
    near(rig.joint(0, "motor-pos-cmd"), -0.1);
}

#[test]
fn a_later_jog_or_stop_supersedes_an_earlier_one() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.jog joint=0 velocity=50 distance=100");
    let jog = rig.bench.tickets().len() - 1;
    rig.cycles(100);
    rig.say("motion.jog joint=0 velocity=50 distance=-100");
    rig.cycles(5);
    assert_eq!(rig.bench.tickets()[jog], TicketState::Failed("superseded by another jog"));
    rig.say("motion.jog-stop");
    let stop = rig.bench.tickets().len() - 1;
    rig.cycles(1);
    assert_eq!(rig.bench.tickets()[stop], TicketState::Pending);
    rig.done("motion.abort");
    let why = "superseded by another stop command";
    assert_eq!(rig.bench.tickets()[stop], TicketState::Failed(why));
}
