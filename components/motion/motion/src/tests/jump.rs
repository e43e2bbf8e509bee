//! Commands that would jump: no error inside motion reaches a motor.

use super::{DT, LIMITS, Rig, near};
use crate::{controller::Controller, joint::Joint, make};
use hal_bench::{Bench, Random};
use hal_component::{
    Builder, Component, Error, In, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// `motmod` with an error while `wrong.how` is not 0.
pub(super) struct Wrong;

/// The controller, and code that corrupts joint `wrong.joint` between planning and output.
#[derive(Touch)]
struct Spoilt {
    controller: Controller,
    how: In<i32>,
    joint: In<i32>,
    by: In<f64>,
}

impl Component for Wrong {
    const NAME: &'static str = "motmod";
    const DOC: &'static str = "motmod in which something is wrong.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = crate::setup::ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (handler, controller) = make(b)?;
        b.function("motion-command-handler", "As in motmod.", handler)?;
        let spoilt = Spoilt {
            controller,
            how: b.item("wrong.how", "What is wrong.", 0)?,
            joint: b.item("wrong.joint", "In which joint.", 0)?,
            by: b.item("wrong.by", "By how much, in units.", 0.0)?,
        };
        b.function("motion-controller", "As in motmod, but wrong.", spoilt)
    }
}

impl Update for Spoilt {
    fn update(&mut self, period: Period) {
        let (how, by, dt) = (self.how.get(), self.by.get(), period.secs());
        self.controller.advance(dt);
        let n = usize::try_from(self.joint.get()).unwrap();
        let joint = &mut self.controller.state.joints[n];
        match how {
            0 => {}
            1 => joint.pos_cmd += by,
            2 => {
                joint.free.tp.pos += by;
                joint.free.tp.target += by;
                joint.pos_cmd += by;
            }
            3 => joint.motor_offset += by,
            4 => joint.backlash.pos += by,
            5 => joint.pos_cmd = f64::NAN,
            6 => joint.pos_cmd = f64::INFINITY,
            7 => joint.motor_offset = f64::NAN,
            8 => joint.backlash.pos = f64::NAN,
            // Position and offset together: the position is redefined without motion.
            9 => rename(joint, by),
            how => panic!("wrong.how is {how}"),
        }
        self.controller.put_out(dt);
    }
}

fn rename(joint: &mut Joint, by: f64) {
    joint.pos_cmd += by;
    joint.free.tp.pos += by;
    joint.free.tp.target += by;
    joint.motor_offset -= by;
}

/// Returns a homed machine whose motion controller can fail.
pub(super) fn rig() -> Rig {
    let mut bench = Bench::new();
    bench.load::<trivkins::Trivkins>(&["kinstype=b"]).unwrap();
    let mut rig = Rig::of::<Wrong>(bench);
    rig.done("motion.enable");
    rig.done("motion.home joint=all");
    for n in 0..3 {
        rig.bench.set(&format!("joint.{n}.jog-scale"), 1.0);
        rig.bench.set(&format!("joint.{n}.jog-enable"), true);
    }
    for letter in ["x", "y", "z"] {
        rig.bench.set(&format!("axis.{letter}.jog-scale"), 1.0);
        rig.bench.set(&format!("axis.{letter}.jog-enable"), true);
        rig.bench.set(&format!("axis.{letter}.eoffset-scale"), 1.0);
        rig.bench.set(&format!("axis.{letter}.eoffset-enable"), true);
        rig.say(&format!("motion.configure axis={letter} offset-av-ratio=0.5"));
    }
    rig.cycle();
    rig
}

/// Corrupts one cycle.
fn spoil(rig: &mut Rig, how: i32, joint: i32, by: f64) {
    rig.bench.set("wrong.how", how);
    rig.bench.set("wrong.joint", joint);
    rig.bench.set("wrong.by", by);
    rig.cycle();
    rig.bench.set("wrong.how", 0);
}

const AMPS: [&str; 3] =
    ["joint.0.amp-enable-out", "joint.1.amp-enable-out", "joint.2.amp-enable-out"];

/// Asserts that the machine is off, that no new command was written to the motors, and that the cause is kept.
fn has_stopped(rig: &mut Rig, before: [f64; 3], by: &str) -> String {
    assert_eq!(rig.which(&AMPS), [""; 0], "{by}");
    assert!(!rig.is("motion.motion-enabled"), "{by}");
    assert_eq!([0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd")), before, "{by}");
    let said = rig.bench.said();
    assert_eq!(said.len(), 1, "{by}: {said:?}");
    assert!(said[0].ends_with(&format!(": {by}; the machine is switched off")), "{said:?}");
    let status = rig.say("motion.status");
    assert!(status[1].starts_with("jump joint="), "{status:?}");
    assert!(status[1].ends_with(&format!(" by {by}")), "{status:?}");
    // The motor stays in place, and the cause is shown until the machine is on again.
    rig.cycles(50);
    (0..3).for_each(|n| near(rig.joint(n, "motor-pos-cmd"), before[n]));
    assert!(rig.bench.said().is_empty());
    assert!(rig.which(&["joint.0.error", "joint.1.error", "joint.2.error"]).len() == 1);
    assert_eq!(rig.say("motion.status")[1], status[1]);
    said[0].clone()
}

/// Sets a joint in motion, and returns the name of the source of the motion.
type Begin = fn(&mut Rig) -> &'static str;

const WAYS: [Begin; 10] = [
    |rig| {
        rig.say("motion.jog joint=0 velocity=20");
        "a jog of the joint"
    },
    |rig| {
        rig.bench.set("joint.0.jog-counts", 30);
        "the joint's jog wheel"
    },
    |rig| {
        rig.say("motion.configure joint=0 home=60");
        rig.say("motion.home joint=0");
        rig.cycles(200);
        "homing"
    },
    |rig| {
        // Between two phases of homing: the joint rests for 0.1 s before the search.
        rig.say("motion.configure joint=0 home-search-vel=20 home-latch-vel=5");
        rig.say("motion.home joint=0");
        rig.cycles(20);
        assert!(rig.is("joint.0.homing") && rig.joint(0, "vel-cmd") == 0.0);
        "homing"
    },
    |rig| {
        rig.say("motion.jog axis=x velocity=20");
        "a jog of an axis"
    },
    |rig| {
        rig.done("motion.mode mode=teleop");
        rig.bench.set("axis.x.jog-counts", 30);
        "an axis's jog wheel"
    },
    |rig| {
        rig.say("motion.move x=30 y=20 velocity=40");
        "a coordinated move"
    },
    |rig| {
        rig.done("motion.mode mode=coord");
        rig.bench.set("axis.x.eoffset-counts", 30);
        "an external offset"
    },
    |rig| {
        rig.done("motion.mode mode=teleop");
        rig.bench.set("axis.x.eoffset-counts", 30);
        "an external offset"
    },
    |_| "nothing should move it",
];

#[test]
fn no_source_of_movement_can_make_a_joint_jump() {
    for begin in WAYS {
        for (how, by) in [
            (1, 0.1),
            (1, -0.2),
            (1, 450.0),
            (1, 1e300),
            (2, -7.0),
            (3, 5.0),
            (3, -1e9),
            (5, 0.0),
            (6, 0.0),
            (7, 0.0),
        ] {
            let mut rig = rig();
            let name = begin(&mut rig);
            rig.cycles(20);
            assert!(rig.is("motion.motion-enabled"), "{name}: {:?}", rig.bench.said());
            let before = [0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd"));
            rig.strict = false;
            spoil(&mut rig, how, 0, by);
            has_stopped(&mut rig, before, name);
        }
    }
}

#[test]
fn the_message_says_which_joint_from_where_to_where_and_how_far_it_may() {
    let mut rig = rig();
    rig.done("motion.move y=3 velocity=40");
    rig.strict = false;
    rig.say("motion.move y=5 velocity=40");
    rig.begin();
    let before = [0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd"));
    spoil(&mut rig, 1, 1, -450.0);
    let why = "a joint would have jumped: a coordinated move";
    assert_eq!(rig.end(), Err(why));
    let said = has_stopped(&mut rig, before, "a coordinated move");
    let (text, rest) = said.split_once(" to ").unwrap();
    assert!(text.starts_with("axis Y would jump from 3.00"), "{text}");
    let (to, rest) = rest.split_once(' ').unwrap();
    assert!((to.parse::<f64>().unwrap() + 447.0).abs() < 0.1, "{said}");
    assert!(rest.starts_with("in one cycle, where at most 0.09 is allowed: "), "{said}");
    let status = rig.say("motion.status");
    assert!(status[1].starts_with("jump joint=1 from=3.00"), "{status:?}");
    // The machine works again once it is switched on, and the cause is cleared.
    rig.cycle();
    rig.done("motion.enable");
    rig.done("motion.move x=1 y=1 velocity=40");
    assert!(!rig.say("motion.status")[1].starts_with("jump"));
    near(rig.joint(1, "pos-cmd"), 1.0);
}

#[test]
fn a_correction_does_not_jump_either() {
    for (how, by) in [(4, 3.0), (4, -0.2), (8, 0.0)] {
        let mut rig = rig();
        rig.strict = false;
        rig.say("motion.configure joint=0 backlash=0.5");
        rig.say("motion.jog joint=0 velocity=20");
        rig.cycles(20);
        let before = [0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd"));
        spoil(&mut rig, how, 0, by);
        has_stopped(&mut rig, before, "its backlash correction");
    }
}

#[test]
fn another_name_for_the_same_place_is_no_jump() {
    for by in [450.0, -1e6] {
        let mut rig = rig();
        rig.say("motion.configure joint=0 min-limit=-1e9 max-limit=1e9");
        rig.say("motion.jog joint=0 velocity=20");
        rig.cycles(100);
        let (motor, pos) = (rig.joint(0, "motor-pos-cmd"), rig.joint(0, "pos-cmd"));
        spoil(&mut rig, 9, 0, by);
        near(rig.joint(0, "motor-pos-cmd"), motor + 20.0 * DT);
        near(rig.joint(0, "pos-cmd"), pos + by + 20.0 * DT);
        rig.cycles(100);
        assert!(rig.is("motion.motion-enabled"));
    }
}

/// A start at full velocity from rest is no error for the guard.
#[test]
fn as_far_as_the_velocity_allows_is_no_jump() {
    for by in [0.09, -0.09] {
        let mut rig = rig();
        rig.strict = false;
        spoil(&mut rig, 2, 0, by);
        assert!(rig.is("motion.motion-enabled"));
        near(rig.joint(0, "motor-pos-cmd"), by);
        spoil(&mut rig, 2, 0, by * (1.0 + 1e-5));
        assert!(!rig.is("motion.motion-enabled"));
        near(rig.joint(0, "motor-pos-cmd"), by);
    }
}

#[test]
fn a_limit_that_is_lowered_in_motion_is_no_jump() {
    for begin in [
        "motion.jog joint=0 velocity=80",
        "motion.jog axis=x velocity=80",
        "motion.move x=190 z=-10 velocity=80",
        "motion.move x=190 velocity=80",
    ] {
        let mut rig = rig();
        rig.strict = false;
        rig.say("motion.configure joint=0 backlash=0.4");
        for letter in ["x", "y", "z"] {
            rig.say(&format!("motion.configure axis={letter} offset-av-ratio=0"));
        }
        rig.say(begin);
        rig.cycles(150);
        let fast = rig.joint(0, "vel-cmd");
        assert!(fast > 30.0, "{begin}: {fast}");
        rig.say("motion.configure joint=0 max-velocity=5");
        let mut last = fast;
        for n in 0..3000 {
            rig.cycle();
            let now = rig.joint(0, "vel-cmd");
            assert!(rig.is("motion.motion-enabled"), "{begin} after {n}: {:?}", rig.bench.said());
            // The joint brakes within its acceleration.
            assert!(last - now <= LIMITS[0].1 * DT * (1.0 + 1e-6), "{begin}: {last} {now}");
            assert!(now <= last * (1.0 + 1e-9) + 1e-9 || now <= 5.0 + 1e-9, "{begin}: {now}");
            last = now;
        }
        assert!((0.1..=5.0 + 1e-9).contains(&last), "{begin}: {last}");
        // From then on, the lower limit applies.
        let before = [0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd"));
        spoil(&mut rig, 1, 0, 0.006);
        assert!(!rig.is("motion.motion-enabled"), "{begin}");
        assert_eq!([0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd")), before);
    }
}

/// Above a limit that was lowered, a joint may not accelerate.
#[test]
fn a_lowered_limit_lets_nothing_new_pass() {
    let mut rig = rig();
    rig.strict = false;
    rig.say("motion.jog joint=0 velocity=40");
    rig.cycles(200);
    rig.say("motion.configure joint=0 max-velocity=5");
    spoil(&mut rig, 2, 0, 0.005);
    assert!(!rig.is("motion.motion-enabled"));
}

fn extra() -> Bench {
    let mut bench = Bench::new();
    bench.load::<trivkins::Trivkins>(&["coordinates=x", "kinstype=b"]).unwrap();
    bench.load::<crate::Motmod>(&["num_joints=2", "num_extrajoints=1"]).unwrap();
    for n in 0..2 {
        let args = [format!("joint={n}"), "max-velocity=50".to_owned()];
        bench.command("motion.configure", &[&args[0], &args[1]]).unwrap();
    }
    bench.command("motion.enable", &[]).unwrap();
    bench.command("motion.home", &["joint=all"]).unwrap();
    follow(&bench, 300);
    assert!(bench.get::<bool>("motion.is-all-homed"));
    bench
}

fn follow(bench: &Bench, cycles: usize) {
    for _ in 0..cycles {
        bench.run("motion-command-handler", 1_000_000);
        bench.run("motion-controller", 1_000_000);
        for n in 0..2 {
            let at: f64 = bench.get(&format!("joint.{n}.motor-pos-cmd"));
            bench.set(&format!("joint.{n}.motor-pos-fb"), at);
        }
    }
}

#[test]
fn a_jump_of_posthome_cmd_is_not_put_out() {
    for (to, said) in [(3.25, "3.25"), (-0.051, "-0.051"), (1e12, "1000000000000")] {
        let bench = extra();
        bench.set("joint.1.posthome-cmd", 0.05);
        follow(&bench, 1);
        bench.set("joint.1.posthome-cmd", 0.0);
        follow(&bench, 1);
        assert!(bench.get::<bool>("motion.motion-enabled"));
        bench.set("joint.1.posthome-cmd", to);
        follow(&bench, 1);
        assert!(!bench.get::<bool>("motion.motion-enabled"));
        assert!(bench.get::<bool>("joint.1.error"));
        assert_eq!(bench.get::<f64>("joint.1.motor-pos-cmd"), 0.0);
        assert_eq!(
            bench.said(),
            [format!(
                "joint 1 would jump from 0 to {said} in one cycle, where at most 0.05 is allowed: \
                 its posthome-cmd; the machine is switched off"
            )]
        );
        // The same applies when the machine is switched on again.
        follow(&bench, 5);
        bench.command("motion.enable", &[]).unwrap();
        follow(&bench, 3);
        assert!(!bench.get::<bool>("motion.motion-enabled"));
        assert_eq!(bench.get::<f64>("joint.1.motor-pos-cmd"), 0.0);
        assert_eq!(bench.said().len(), 1);
        bench.set("joint.1.posthome-cmd", 0.04);
        bench.command("motion.enable", &[]).unwrap();
        follow(&bench, 3);
        assert!(bench.get::<bool>("motion.motion-enabled"));
        assert_eq!(bench.get::<f64>("joint.1.motor-pos-cmd"), 0.04);
    }
}

/// For all commands and all faults: while the amplifier is on, no step is longer than the velocity allows, and the
/// guard never stops a machine without faults.
#[test]
fn random_machines_that_go_wrong() {
    let mut random = Random::new(11);
    let mut stopped = 0;
    for _ in 0..60 {
        let mut rig = rig();
        rig.strict = false;
        rig.say("motion.configure joint=1 backlash=0.3");
        let mut seen: Option<[[f64; 2]; 3]> = None;
        let mut wrong = false;
        for _ in 0..40 {
            drop(rig.try_say(&super::random::orderly(&mut random)));
            let letter = random.pick(&["x", "y", "z"]);
            rig.bench.set(&format!("axis.{letter}.eoffset-counts"), random.pick(&[-4, 0, 3]));
            rig.bench.set(&format!("axis.{letter}.jog-counts"), random.pick(&[-9, 0, 5]));
            for _ in 0..random.pick(&[3, 20, 90]) {
                if random.below(400) == 0 {
                    let by = random.pick(&[0.01, -0.05, 0.1, -0.3, 4.0, -1e6]);
                    let how = random.pick(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
                    rig.bench.set("wrong.how", how);
                    rig.bench.set("wrong.by", by);
                    rig.bench.set("wrong.joint", random.pick(&[0, 1, 2]));
                    wrong = true;
                } else {
                    rig.bench.set("wrong.how", 0);
                }
                rig.cycle();
                let on = rig.is("motion.motion-enabled");
                let now = [0, 1, 2].map(|n| {
                    let correction = rig.joint(n, "backlash-filt");
                    [rig.joint(n, "motor-pos-cmd") - correction, correction]
                });
                assert!(on || wrong, "{:?}", rig.bench.said());
                if let Some(last) = seen.filter(|_| on) {
                    for (n, (now, last)) in now.iter().zip(last).enumerate() {
                        let limit = LIMITS[n].0 * DT * (1.0 + 2e-6);
                        let step = (now[0] - last[0]).abs().max((now[1] - last[1]).abs());
                        assert!(step <= limit, "joint {n}: {step}");
                    }
                }
                seen = on.then_some(now);
                if !on {
                    stopped += 1;
                    rig.cycles(2);
                    drop(rig.try_say("motion.disable"));
                    rig = self::rig();
                    rig.strict = false;
                    wrong = false;
                    break;
                }
            }
        }
    }
    assert!(stopped > 50, "{stopped}");
}
