//! Commands: replies and refusals, modes, homing, spindles.

use super::{Rig, near};
use crate::Motmod;
use hal_bench::Bench;
use hal_component::abi::TicketState;
use trivkins::Trivkins;

#[test]
fn refusals_name_what_is_wrong() {
    let rig = Rig::off(&["coordinates=xyz"]);
    for (text, why) in [
        ("motion.configure joint=3 home=0", "there is no joint 3, they are 0 to 2"),
        ("motion.configure joint=-1 home=0", "there is no joint -1, they are 0 to 2"),
        ("motion.configure joint=0 axis=x", "joint= and axis= exclude each other"),
        ("motion.configure axis=q max-limit=1", "axis 'q' is none of x y z a b c u v w"),
        ("motion.configure axis=x ferror=1", "ferror= does not belong to axis="),
        (
            "motion.configure joint=0 default-velocity=1",
            "default-velocity= does not belong to joint=",
        ),
        ("motion.configure joint=0 linear-units=mm", "linear-units= does not belong to joint="),
        (
            "motion.configure min-limit=1",
            "min-limit= does not belong to a configuration without joint=, axis= and spindle=",
        ),
        ("motion.configure joint=0 max-velocity=0", "max-velocity is 0, must be above 0"),
        ("motion.configure joint=0 max-velocity=inf", "max-velocity is inf, must be above 0"),
        (
            "motion.configure joint=0 max-acceleration=NaN",
            "max-acceleration is NaN, must be above 0",
        ),
        ("motion.configure joint=0 ferror=-1", "ferror is -1, must be 0 or more"),
        ("motion.configure joint=0 min-limit=NaN", "min-limit is NaN, must be a number"),
        ("motion.configure joint=0 min-limit=300", "min-limit 300 is above max-limit 200"),
        (
            "motion.configure linear-units=ell",
            "linear-units 'ell' is none of mm, inch, and a number of units per millimetre",
        ),
        ("motion.jog joint=0 velocity=0", "velocity is 0, a jog needs one"),
        ("motion.jog velocity=1", "joint= or axis= is missing"),
        ("motion.jog joint=9 velocity=1", "there is no joint 9, they are 0 to 2"),
        ("motion.jog axis=a velocity=1", "axis a has no joint in these kinematics"),
        (
            "motion.jog joint=0 velocity=-1 distance=1",
            "velocity is -1, must be above 0: distance= or position= is the direction",
        ),
        (
            "motion.jog joint=0 velocity=1 distance=1 position=1",
            "distance= and position= exclude each other",
        ),
        ("motion.jog joint=0 velocity=NaN", "velocity is NaN, must be a finite number"),
        ("motion.move velocity=1", "a move needs at least one of x= y= z= a= b= c= u= v= w="),
        ("motion.move x=1 velocity=0", "velocity is 0, must be above 0"),
        ("motion.move x=inf velocity=1", "x is inf, must be a finite number"),
        ("motion.move b=1 velocity=1", "axis b has no joint in these kinematics"),
        ("motion.mode mode=quick", "mode 'quick' is none of free, teleop and coord"),
        ("motion.home joint=x", "joint 'x' is neither a number nor all"),
        ("motion.spindle spindle=1 speed=1", "there is no spindle 1, there are 1"),
        ("motion.feed override=-1", "override is -1, must be 0 or more"),
    ] {
        assert_eq!(rig.try_say(text).unwrap_err(), why, "{text}");
    }
}

/// Programs of a lathe name Y, which has no joint, in every move.
#[test]
fn an_axis_without_a_joint_may_be_named_at_its_place() {
    let mut rig = Rig::off(&["coordinates=xz"]);
    let off = "need to be enabled, in coord mode for linear move";
    assert_eq!(rig.failed("motion.move x=1 y=0 z=0 velocity=1"), off);
    let why = "axis y has no joint in these kinematics";
    assert_eq!(rig.try_say("motion.move x=1 y=0.1 z=0 velocity=1").unwrap_err(), why);
    assert_eq!(rig.try_say("motion.jog axis=y velocity=1").unwrap_err(), why);
}

#[test]
fn nothing_moves_a_machine_that_is_off() {
    let mut rig = Rig::off(&[]);
    for (text, why) in [
        ("motion.jog joint=0 velocity=1", "cannot jog: the machine is not enabled"),
        ("motion.jog axis=x velocity=1", "cannot jog: the machine is not enabled"),
        ("motion.move x=1 velocity=1", "need to be enabled, in coord mode for linear move"),
        ("motion.home joint=all", "cannot home: the machine is not enabled"),
    ] {
        assert_eq!(rig.failed(text), why);
        assert_eq!(rig.bench.said(), [why]);
    }
    rig.done("motion.disable");
    rig.done("motion.abort");
    rig.done("motion.jog-stop");
    rig.done("motion.jog-stop joint=0");
}

#[test]
fn a_joint_that_was_never_configured_takes_no_part() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    bench.load::<Motmod>(&["num_joints=3"]).unwrap();
    let ask = |name: &str, args: &[&str]| {
        bench.command(name, args).unwrap();
        for _ in 0..3 {
            bench.run("motion-command-handler", 1_000_000);
            bench.run("motion-controller", 1_000_000);
            bench.work("motmod.planner", 64).unwrap();
        }
        bench.ticket()
    };
    assert_eq!(
        ask("motion.enable", &[]),
        Some(TicketState::Failed(
            "can't enable motion, no joint is configured, see motion.configure"
        ))
    );
    assert!(bench.get::<bool>("motion.is-all-homed"));
    assert!(!bench.get::<bool>("joint.0.active"));
    bench.command("motion.configure", &["joint=0"]).unwrap();
    assert_eq!(ask("motion.enable", &[]), Some(TicketState::Done));
    let failed = Some(TicketState::Failed("the joint is not configured, see motion.configure"));
    assert_eq!(ask("motion.jog", &["joint=1", "velocity=1"]), failed);
    assert_eq!(ask("motion.home", &["joint=1"]), failed);
    let failed =
        Some(TicketState::Failed("move on line {} needs joint {}, which is not configured"));
    assert_eq!(ask("motion.move", &["x=1", "y=1"]), failed);
    let failed = Some(TicketState::Failed("a joint of this axis is not configured"));
    assert_eq!(ask("motion.jog", &["axis=z", "velocity=1"]), failed);
}

#[test]
fn a_motor_that_is_somewhere_is_where_it_starts() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    bench.load::<Motmod>(&["num_joints=1"]).unwrap();
    bench.set("joint.0.motor-pos-fb", 7.5);
    bench.command("motion.configure", &["joint=0"]).unwrap();
    bench.command("motion.enable", &[]).unwrap();
    for _ in 0..3 {
        bench.run("motion-command-handler", 1_000_000);
        bench.run("motion-controller", 1_000_000);
        assert_eq!(bench.get::<f64>("joint.0.motor-pos-cmd"), 7.5);
        assert_eq!(bench.get::<f64>("axis.x.pos-cmd"), 7.5);
        assert!(bench.get::<bool>("joint.0.amp-enable-out"));
    }
}

#[test]
fn commands_wait_for_the_thread() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    bench.load::<Motmod>(&["num_joints=1"]).unwrap();
    for _ in 0..256 {
        bench.command("motion.configure", &["joint=0", "home=1"]).unwrap();
    }
    let full = "too many commands wait: is motion-command-handler in a running thread?";
    assert_eq!(bench.command("motion.enable", &[]).unwrap_err(), full);
    assert_eq!(bench.ticket(), Some(TicketState::Failed("too many commands wait")));
    assert_eq!(bench.command("motion.configure", &["joint=0", "home=2"]).unwrap_err(), full);
    // Sixteen commands per cycle.
    bench.run("motion-command-handler", 1_000_000);
    (0..16).for_each(|_| {
        bench.command("motion.configure", &["joint=0", "home=1"]).unwrap();
    });
    assert_eq!(bench.command("motion.enable", &[]).unwrap_err(), full);
}

#[test]
fn modes_change_when_the_machine_stands() {
    let mut rig = Rig::on(&[]);
    let modes = ["motion.coord-mode", "motion.teleop-mode"];
    rig.done("motion.mode mode=coord");
    assert_eq!(rig.which(&modes), ["motion.coord-mode"]);
    rig.done("motion.mode mode=teleop");
    assert_eq!(rig.which(&modes), ["motion.teleop-mode"]);
    rig.done("motion.mode mode=free");
    assert_eq!(rig.which(&modes), [""; 0]);
    let moving = "the mode cannot change while the machine moves";
    rig.say("motion.jog joint=0 velocity=50");
    rig.cycles(10);
    assert_eq!(rig.failed("motion.mode mode=coord"), moving);
    assert_eq!(rig.failed("motion.move x=0 velocity=9"), moving);
    rig.done("motion.jog-stop");
    let at = rig.joint(0, "pos-cmd");
    // Moves and jogs change the mode themselves, and continue from the current position.
    rig.say("motion.move y=20 velocity=50");
    rig.cycles(10);
    assert_eq!(rig.which(&modes), ["motion.coord-mode"]);
    assert_eq!(rig.failed("motion.jog joint=0 velocity=9"), moving);
    rig.done("motion.abort");
    assert_eq!(rig.joint(0, "pos-cmd"), at);
    rig.done("motion.jog joint=0 velocity=50 distance=1");
    near(rig.joint(0, "pos-cmd"), at + 1.0);
    assert_eq!(rig.which(&modes), [""; 0]);
}

#[test]
fn only_joints_that_are_axes_may_move_along_a_path_unhomed() {
    let mut rig = Rig::on(&["kinstype=b"]);
    let coord = "all joints must be homed before going into coordinated mode";
    assert_eq!(rig.failed("motion.move x=1 velocity=1"), coord);
    let teleop = "all joints must be homed before going into teleop mode";
    assert_eq!(rig.failed("motion.jog axis=x velocity=1"), teleop);
    rig.done("motion.home joint=all");
    rig.done("motion.move x=1 velocity=1");
}

#[test]
fn homing_names_the_place_and_goes_home() {
    let mut rig = Rig::on(&[]);
    rig.done("motion.jog joint=0 velocity=50 position=7");
    rig.say("motion.configure joint=0 home-offset=3 home=1 home-final-vel=20");
    let motor = rig.joint(0, "motor-pos-cmd");
    rig.say("motion.home joint=0");
    rig.cycles(3);
    assert!(rig.is("joint.0.homing") && !rig.is("joint.0.homed"));
    // The position is redefined, and the motor has not moved.
    assert_eq!(rig.joint(0, "motor-pos-cmd"), motor);
    near(rig.joint(0, "pos-cmd"), 3.0);
    near(rig.joint(0, "motor-offset"), 4.0);
    let mut states = Vec::new();
    while rig.is("joint.0.homing") {
        states.push(rig.bench.get::<i32>("joint.0.home-state"));
        rig.cycle();
        assert!(rig.joint(0, "vel-cmd").abs() <= 20.0);
    }
    states.dedup();
    assert_eq!(states, [20, 21]);
    assert_eq!(rig.end(), Ok(()));
    near(rig.joint(0, "pos-cmd"), 1.0);
    near(rig.joint(0, "motor-pos-cmd"), 5.0);
    assert!(rig.is("joint.0.homed") && !rig.is("motion.is-all-homed"));
    assert_eq!(rig.bench.get::<i32>("joint.0.home-state"), 0);
    rig.done("motion.home joint=all");
    assert!(rig.is("motion.is-all-homed"));
    rig.done("motion.unhome joint=1");
    assert_eq!(rig.which(&["joint.0.homed", "joint.1.homed"]), ["joint.0.homed"]);
}

/// The figure is LinuxCNC 2.9's, displayed for the same joint on the same travel.
#[test]
fn the_bit_of_the_way_that_is_not_gone() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.configure joint=0 home-offset=3 home=0");
    rig.done("motion.home joint=0");
    let left = rig.joint(0, "pos-cmd");
    assert!((left - 1.028_297e-6).abs() < 1e-12, "{left:e}");
}

#[test]
fn homing_that_cannot_be() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.home joint=0");
    rig.cycles(1);
    assert_eq!(rig.failed("motion.home joint=2"), "cannot home: homing is under way");
    assert_eq!(rig.failed("motion.jog joint=2 velocity=1"), "cannot jog while homing");
    rig.done("motion.abort");
    assert!(!rig.is("joint.0.homed") && !rig.is("joint.0.homing"));
    rig.bench.set("motion.homing-inhibit", true);
    assert_eq!(rig.failed("motion.home joint=0"), "homing denied by motion.homing-inhibit");
}

#[test]
fn a_spindle_turns() {
    let mut rig = Rig::on(&[]);
    let row = |rig: &Rig| {
        let of = |pin: &str| format!("spindle.0.{pin}");
        let bits = ["on", "forward", "reverse", "brake"].map(|p| u8::from(rig.is(&of(p))));
        let speeds = ["speed-out", "speed-out-abs", "speed-cmd-rps", "speed-out-rps"];
        (bits, speeds.map(|p| rig.float(&of(p))))
    };
    for (text, inhibit, bits, speeds) in [
        ("speed=600", false, [1, 1, 0, 0], [600.0, 600.0, 10.0, 10.0]),
        ("speed=600", true, [0, 0, 0, 0], [0.0, 0.0, 10.0, 0.0]),
        ("override=0.5", false, [1, 1, 0, 0], [300.0, 300.0, 10.0, 5.0]),
        ("speed=-9000", false, [1, 0, 1, 0], [-4500.0, 4500.0, -150.0, -75.0]),
        ("speed=0", false, [0, 0, 0, 1], [0.0, 0.0, 0.0, 0.0]),
        ("brake=0", false, [0, 0, 0, 0], [0.0, 0.0, 0.0, 0.0]),
    ] {
        rig.bench.set("spindle.0.inhibit", inhibit);
        rig.done(&format!("motion.spindle {text}"));
        assert_eq!(row(&rig), (bits, speeds), "{text}");
    }
    rig.done("motion.spindle speed=600");
    rig.done("motion.abort");
    assert_eq!(row(&rig).0, [0, 0, 0, 1]);
}

#[test]
fn status_tells_the_machine() {
    let mut rig = Rig::homed(&["coordinates=xyz"]);
    rig.done("motion.move x=1.5 velocity=9");
    assert_eq!(
        rig.say("motion.status"),
        [
            "machine enabled=TRUE mode=coord in-position=TRUE homed=TRUE velocity=0.000000 \
             distance-to-go=0.000000",
            "joint 0 position=1.500000 feedback=1.500000 velocity=0.000000 \
             following-error=0.000000 homed=TRUE in-position=TRUE limit=none error=FALSE",
            "joint 1 position=0.000000 feedback=0.000000 velocity=0.000000 \
             following-error=0.000000 homed=TRUE in-position=TRUE limit=none error=FALSE",
            "joint 2 position=0.000000 feedback=0.000000 velocity=0.000000 \
             following-error=0.000000 homed=TRUE in-position=TRUE limit=none error=FALSE",
            "axis x position=1.500000",
        ]
    );
}

#[test]
fn an_extra_joint_follows_its_pin_once_homed() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&["coordinates=x", "kinstype=b"]).unwrap();
    bench.load::<Motmod>(&["num_joints=2", "num_extrajoints=1"]).unwrap();
    for n in 0..2 {
        let args = [format!("joint={n}"), "max-velocity=50".to_owned()];
        bench.command("motion.configure", &[&args[0], &args[1]]).unwrap();
    }
    let run = |n: usize| {
        for _ in 0..n {
            bench.run("motion-command-handler", 1_000_000);
            bench.run("motion-controller", 1_000_000);
            bench.work("motmod.planner", 64).unwrap();
            let x: f64 = bench.get("joint.0.motor-pos-cmd");
            bench.set("joint.0.motor-pos-fb", x);
        }
    };
    bench.command("motion.enable", &[]).unwrap();
    bench.command("motion.home", &["joint=all"]).unwrap();
    run(300);
    assert!(bench.get::<bool>("motion.is-all-homed"));
    // Its feedback no longer counts.
    for n in 1..=130 {
        bench.set("joint.1.posthome-cmd", f64::from(n) * 0.025);
        run(1);
    }
    run(1);
    assert_eq!(bench.get::<f64>("joint.1.motor-pos-cmd"), 3.25);
    bench.set("joint.1.posthome-cmd", f64::NAN);
    bench.command("motion.move", &["x=1"]).unwrap();
    run(2200);
    assert_eq!(bench.get::<f64>("joint.1.motor-pos-cmd"), 3.25);
    assert_eq!(bench.get::<f64>("joint.0.pos-cmd"), 1.0);
    assert!(bench.get::<bool>("motion.motion-enabled"));
}

#[test]
fn the_last_period_is_machine_time() {
    let mut rig = Rig::off(&[]);
    rig.cycles(1);
    assert_eq!(rig.bench.get::<u32>("motion.servo.last-period"), 0);
    rig.cycles(1);
    assert_eq!(rig.bench.get::<u32>("motion.servo.last-period"), 1_000_000);
}
