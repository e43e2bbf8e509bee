//! Coordinated moves.

use super::{DT, LIMITS, Rig};
use hal_bench::Bench;
use hal_component::{
    Builder, Component, Error, Kinematics, KinematicsKind, Pose, Solution, Solved, Touch, Unsolved,
    abi::component_flags,
};

/// Returns the distance of a point from the line between two others.
fn off_line(p: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let way = [0, 1, 2].map(|i| to[i] - from[i]);
    let at = [0, 1, 2].map(|i| p[i] - from[i]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let share = dot(at, way) / dot(way, way);
    let off = [0, 1, 2].map(|i| at[i] - share * way[i]);
    dot(off, off).sqrt()
}

#[test]
fn straight_within_limits_and_exactly_there() {
    for kinematics in [&[][..], &["kinstype=b"]] {
        let mut rig = Rig::homed(kinematics);
        let mut from = [0.0; 3];
        for (to, velocity) in [
            ([100.0, 60.0, 0.0], 50.0),
            ([-50.0, 200.0, 0.0], 1000.0),
            ([10.0, 20.0, 30.0], 1000.0),
            ([10.001, 20.0, 30.001], 10.0),
            ([10.0, 20.0, -100.0], 5.0),
            ([200.0, -50.0, 100.0], 90.0),
        ] {
            let [x, y, z] = to;
            rig.say(&format!("motion.move x={x} y={y} z={z} velocity={velocity}"));
            let mut fastest = 0.0_f64;
            while rig.end_or_cycle() {
                let p = rig.places();
                assert!(off_line(p, from, to) < 1e-9, "{p:?} is off the line to {to:?}");
                fastest = fastest.max(rig.float("motion.current-vel"));
                assert!(rig.float("motion.current-vel") <= velocity * (1.0 + 1e-9));
            }
            assert_eq!(rig.places(), to);
            assert_eq!(rig.end(), Ok(()));
            from = to;
        }
        assert!(rig.is("motion.coord-mode") && rig.is("motion.in-position"));
    }
}

impl Rig {
    /// Runs cycles until the path moves.
    pub(super) fn begin(&mut self) {
        for _ in 0..50 {
            if self.float("motion.current-vel") > 0.0 {
                return;
            }
            self.cycle();
        }
        panic!("never begins")
    }

    /// Runs one cycle while the last command is in progress.
    fn end_or_cycle(&mut self) -> bool {
        let pending = self.bench.ticket() == Some(hal_component::abi::TicketState::Pending);
        if pending {
            self.cycle();
            self.waited += 1;
            assert!(self.waited < 1_000_000, "never ends");
        }
        pending
    }
}

#[test]
fn as_fast_as_the_slowest_joint_lets_it() {
    for (to, velocity, requested, acceleration) in [
        // Along x alone: the joint's own limits.
        ([100.0, 0.0, 0.0], 1000.0, 90.0, 1350.0),
        // Along x and y at once: a little more along the path.
        ([30.0, 40.0, 0.0], 1000.0, 90.0 / 0.8, 1350.0 / 0.8),
        // z is slow.
        ([30.0, 0.0, 40.0], 1000.0, 10.0 / 0.8, 35.0 / 0.8),
        // Slower on request.
        ([30.0, 0.0, 40.0], 3.0, 3.0, 35.0 / 0.8),
    ] {
        let mut rig = Rig::homed(&[]);
        let [x, y, z] = to;
        rig.say(&format!("motion.move x={x} y={y} z={z} velocity={velocity}"));
        rig.begin();
        rig.cycles(1);
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-7, "{a} is not {b}");
        near(rig.float("motion.requested-vel"), requested);
        near(rig.float("motion.current-vel"), 1.5 * acceleration * DT);
        assert_eq!(rig.bench.get::<i32>("motion.motion-type"), 2);
        assert_eq!(rig.end(), Ok(()));
        assert_eq!(rig.bench.get::<i32>("motion.motion-type"), 0);
        assert_eq!(rig.places(), to);
    }
}

#[test]
fn takes_the_time_of_a_trapezoid() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=90 velocity=90");
    let mut cycles = 0;
    while rig.end_or_cycle() {
        cycles += 1;
    }
    let ideal = (1.0 + 90.0 / LIMITS[0].1) / DT;
    let cycles = f64::from(cycles);
    assert!(ideal <= cycles && cycles < ideal + 20.0, "{cycles} cycles, ideal {ideal}");
}

#[test]
fn moves_wait_and_stop_at_each_corner() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=10 velocity=50");
    rig.say("motion.move y=10 velocity=50");
    rig.say("motion.move x=0 velocity=50");
    rig.say("motion.move y=0 velocity=50");
    let mut corners = Vec::new();
    rig.begin();
    while rig.end_or_cycle() {
        let [x, y, _] = rig.places();
        assert!([0.0, 10.0].contains(&x) || [0.0, 10.0].contains(&y), "{x} {y}");
        if [0.0, 10.0].contains(&x) && [0.0, 10.0].contains(&y) {
            corners.push((x, y));
        }
    }
    corners.dedup();
    assert_eq!(corners, [(10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)]);
    // A move to the current position, and one move after another.
    rig.done("motion.move x=0 velocity=50");
    rig.done("motion.move x=1 velocity=50");
}

#[test]
fn only_so_many_wait() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=100 velocity=1");
    rig.cycles(1);
    for n in 0..1999 {
        rig.say(&format!("motion.move y={} velocity=90", n % 2));
        rig.cycles(1);
    }
    assert_eq!(rig.failed("motion.move y=0 velocity=90"), "2000 moves are waiting already");
    assert!(rig.is("motion.coord-error"));
    rig.done("motion.abort");
    rig.done("motion.move y=0 velocity=90");
    assert!(!rig.is("motion.coord-error"));
}

#[test]
fn abort_brakes_along_the_line() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.move x=100 y=50 velocity=80");
    rig.cycles(500);
    let at = rig.places();
    rig.say("motion.move x=0 y=0 velocity=80");
    rig.say("motion.abort");
    rig.cycles(2);
    assert!(!rig.is("motion.in-position"), "it brakes and does not stop at once");
    assert_eq!(rig.end(), Ok(()));
    let end = rig.places();
    assert!(off_line(end, [0.0; 3], [100.0, 50.0, 0.0]) < 1e-9);
    let way = (end[0] - at[0]).hypot(end[1] - at[1]);
    let acceleration = 1350.0 * 1.25_f64.sqrt();
    let ideal = 80.0 * 80.0 / 2.0 / acceleration;
    assert!((way - ideal).abs() < 3.0 * 80.0 * DT, "{way}, ideal {ideal}");
    rig.cycles(100);
    assert_eq!(rig.places(), end);
    rig.done("motion.move x=0 y=0 velocity=80");
    assert_eq!(rig.places(), [0.0; 3]);
}

#[test]
fn feed_is_scaled_and_held() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.configure max-feed-override=1.5");
    rig.say("motion.move x=150 velocity=20");
    let steady = |rig: &mut Rig, velocity: f64| {
        rig.cycles(100);
        let now = rig.float("motion.current-vel");
        assert!((now - velocity).abs() < 1e-6, "{now} is not {velocity}");
        assert_eq!(rig.float("motion.requested-vel"), 20.0);
        assert!(!rig.is("motion.in-position"));
    };
    steady(&mut rig, 20.0);
    // Adaptive feed counts only if it is switched on.
    rig.bench.set("motion.adaptive-feed", 0.5);
    steady(&mut rig, 20.0);
    rig.say("motion.feed adaptive=1");
    steady(&mut rig, 10.0);
    assert_eq!(rig.float("motion.feed-upm"), 600.0);
    assert_eq!(rig.float("motion.feed-mm-per-second"), 10.0);
    assert!((rig.float("motion.feed-inches-per-minute") - 600.0 / 25.4).abs() < 1e-9);
    for (adaptive, velocity) in [(7.0, 30.0), (f64::NAN, 0.0), (f64::INFINITY, 30.0), (1.0, 20.0)] {
        rig.bench.set("motion.adaptive-feed", adaptive);
        steady(&mut rig, velocity);
    }
    // A path is planned for the highest override that is configured.
    rig.say("motion.feed adaptive=0 override=100");
    steady(&mut rig, 30.0);
    rig.say("motion.feed override=0.5");
    steady(&mut rig, 10.0);
    rig.bench.set("motion.feed-hold", true);
    steady(&mut rig, 0.0);
    rig.say("motion.feed hold=0 override=1");
    steady(&mut rig, 20.0);
    rig.bench.set("motion.feed-inhibit", true);
    steady(&mut rig, 0.0);
    rig.bench.set("motion.feed-inhibit", false);
    rig.say("motion.move x=0 velocity=90");
    assert_eq!(rig.end(), Ok(()));
    assert_eq!(rig.places(), [0.0; 3]);
}

/// Feed override scales feeds, and the override of rapid moves scales these; adaptive feed and holds count for both.
#[test]
fn rapid_moves_have_an_override_of_their_own() {
    let mut rig = Rig::homed(&[]);
    let steady = |rig: &mut Rig, text: &str, velocity: f64| {
        rig.cycles(100);
        let now = rig.float("motion.current-vel");
        assert!((now - velocity).abs() < 1e-6, "{text}: {now} is not {velocity}");
        let asked = rig.float("motion.feed-mm-per-second");
        assert!((asked - velocity).abs() < 1e-6, "{text}: {asked} is not {velocity}");
    };
    for (kind, full, own, other) in [
        ("rapid=1", 90.0, "rapid-override", "override"),
        ("velocity=20", 20.0, "override", "rapid-override"),
    ] {
        rig.say(&format!("motion.move x=150 {kind}"));
        steady(&mut rig, kind, full);
        rig.say(&format!("motion.feed {own}=0.25"));
        steady(&mut rig, kind, 0.25 * full);
        for scale in [0.0, 0.5] {
            rig.say(&format!("motion.feed {other}={scale}"));
            steady(&mut rig, kind, 0.25 * full);
        }
        rig.bench.set("motion.adaptive-feed", 0.5);
        rig.say("motion.feed adaptive=1");
        steady(&mut rig, kind, 0.125 * full);
        rig.say("motion.feed adaptive=0");
        rig.bench.set("motion.feed-hold", true);
        steady(&mut rig, kind, 0.0);
        rig.bench.set("motion.feed-hold", false);
        steady(&mut rig, kind, 0.25 * full);
        rig.say(&format!("motion.feed {own}=0"));
        steady(&mut rig, kind, 0.0);
        assert!(!rig.is("motion.in-position"));
        rig.say(&format!("motion.feed {own}=1 {other}=1"));
        assert_eq!(rig.end(), Ok(()));
        rig.done("motion.move x=0 velocity=90");
    }
    for (scale, why) in [("1.01", "1.01"), ("-0.5", "-0.5")] {
        let refused = rig.try_say(&format!("motion.feed rapid-override={scale}"));
        assert_eq!(refused, Err(format!("rapid-override is {why}, must be 0 to 1")));
    }
    assert!(rig.try_say("motion.feed rapid-override=nan").is_err());
    assert_eq!(
        rig.bench.snapshot::<hal_component::MotionStatus>("motion.status").rapid_override,
        1.0
    );
}

#[test]
fn targets_beyond_a_limit_are_refused() {
    let mut rig = Rig::homed(&[]);
    assert_eq!(rig.bench.said(), [""; 0]);
    for (text, why, said) in [
        (
            "motion.move x=201 velocity=1",
            "linear move on line {} would exceed X's positive limit, {}, by {}",
            "linear move on line 0 would exceed X's positive limit, 200, by 1",
        ),
        (
            "motion.move x=10 z=-100.1 velocity=1",
            "linear move on line {} would exceed Z's negative limit, {}, by {}",
            "linear move on line 0 would exceed Z's negative limit, -100, by 0.1",
        ),
    ] {
        assert_eq!(rig.failed(text), why);
        assert_eq!(rig.bench.said(), [said]);
        assert!(rig.is("motion.coord-error"));
        assert_eq!(rig.places(), [0.0; 3]);
    }
    rig.done("motion.move x=200 z=-100 velocity=100");
    rig.say("motion.configure axis=x max-limit=150");
    let why = "linear move on line {} would exceed X's positive limit, {}, by {}";
    assert_eq!(rig.failed("motion.move x=160 velocity=1"), why);
    rig.done("motion.move x=150 velocity=100");
    // A limit that is moved inwards while moves wait ends the path before the first move beyond it.
    rig.say("motion.move x=0 velocity=90");
    rig.say("motion.move x=140 velocity=90");
    rig.cycles(100);
    rig.say("motion.configure axis=x max-limit=100");
    assert_eq!(rig.end(), Err(why));
    assert!(rig.places()[0] > 100.0);
    rig.cycles(4000);
    assert_eq!(rig.places()[0], 0.0);
    assert!(rig.is("motion.in-position"));
}

#[test]
fn the_machine_and_its_axes_have_limits_too() {
    let mut rig = Rig::homed(&[]);
    rig.say("motion.configure max-velocity=60 max-acceleration=500 default-velocity=9");
    rig.say("motion.move x=100");
    rig.cycles(50);
    assert_eq!(rig.float("motion.requested-vel"), 9.0);
    rig.done("motion.abort");
    rig.say("motion.feed override=50");
    rig.say("motion.move x=100 velocity=80 acceleration=300");
    rig.begin();
    rig.cycles(9);
    assert!((rig.float("motion.current-vel") - 9.5 * 300.0 * DT).abs() < 1e-6);
    rig.cycles(300);
    assert!((rig.float("motion.current-vel") - 60.0).abs() < 1e-6);
    rig.done("motion.abort");
    rig.say("motion.configure axis=y max-velocity=7 max-acceleration=70");
    rig.say("motion.move y=100 velocity=80");
    rig.begin();
    rig.cycles(9);
    assert!((rig.float("motion.current-vel") - 9.5 * 70.0 * DT).abs() < 1e-6);
    rig.cycles(300);
    assert!((rig.float("motion.current-vel") - 7.0).abs() < 1e-6);
}

#[test]
fn joints_that_share_a_letter_move_together() {
    let mut rig = Rig::homed(&["coordinates=xyy"]);
    rig.say("motion.move x=5 y=20 velocity=90");
    while rig.end_or_cycle() {
        assert_eq!(rig.joint(1, "pos-cmd"), rig.joint(2, "pos-cmd"));
    }
    assert_eq!(rig.places(), [5.0, 20.0, 20.0]);
}

/// An arm that turns (joint 1, in degrees), extends (joint 0), and rises (joint 2).
struct Polar;

#[derive(Touch)]
struct Arm {}

impl Kinematics for Arm {
    fn joints(&self) -> usize {
        3
    }
    fn kind(&self) -> KinematicsKind {
        KinematicsKind::Both
    }
    fn joint_of(&self, _: usize) -> Option<usize> {
        None
    }
    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        let (sin, cos) = joints[1].to_radians().sin_cos();
        (pose[0], pose[1], pose[2]) = (joints[0] * cos, joints[0] * sin, joints[2]);
        Ok(Solved::Regular)
    }
    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        let reach = pose[0].hypot(pose[1]);
        (joints[0], joints[2]) = (reach, pose[2]);
        joints[1] = pose[1].atan2(pose[0]).to_degrees();
        if reach > 1.0 { Ok(Solved::Regular) } else { Err(Unsolved::Unreachable) }
    }
}

impl Component for Polar {
    const NAME: &'static str = "polar";
    const DOC: &'static str = "An arm.";
    const FLAGS: u32 = component_flags::ONCE;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        b.offer_kinematics(Arm {})
    }
}

#[test]
fn lines_are_straight_where_joints_are_not() {
    let mut bench = Bench::new();
    bench.load::<Polar>(&[]).unwrap();
    let mut rig = Rig::with(bench);
    rig.say("motion.configure joint=0 home=100 home-offset=100");
    rig.done("motion.enable");
    rig.done("motion.home joint=all");
    let place = |rig: &Rig| {
        let [reach, turn, z] = rig.places();
        let (sin, cos) = turn.to_radians().sin_cos();
        [reach * cos, reach * sin, z]
    };
    let mut from = place(&rig);
    for (to, velocity) in
        [([60.0, 60.0, 0.0], 1000.0), ([30.0, -30.0, 5.0], 40.0), ([150.0, 20.0, 0.0], 1000.0)]
    {
        let [x, y, z] = to;
        rig.say(&format!("motion.move x={x} y={y} z={z} velocity={velocity}"));
        while rig.end_or_cycle() {
            let p = place(&rig);
            assert!(off_line(p, from, to) < 1e-9, "{p:?} is off the line to {to:?}");
        }
        assert_eq!(rig.end(), Ok(()));
        from = place(&rig);
        for i in 0..3 {
            assert!((from[i] - to[i]).abs() < 1e-9);
        }
    }
    // The joints' limits apply, not those of a box.
    assert_eq!(
        rig.failed("motion.move x=20 y=199.5 velocity=9"),
        "linear move on line {} would exceed joint {}'s positive limit, {}, by {}"
    );
    let unreachable = "move on line {}: the kinematics cannot go there: x {} y {} z {}";
    assert_eq!(rig.failed("motion.move x=0 y=0 velocity=9"), unreachable);
    rig.done("motion.move x=20 y=10 velocity=1000");
    // Across a position that the arm cannot reach.
    assert_eq!(rig.failed("motion.move x=-20 y=-10 velocity=9"), unreachable);
    // Jogs of an axis move both.
    rig.done("motion.jog axis=x velocity=20 distance=10");
    assert!((place(&rig)[0] - 30.0).abs() < 1e-4 && (place(&rig)[1] - 10.0).abs() < 1e-9);
}
