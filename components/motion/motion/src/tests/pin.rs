//! Names, types, directions, defaults and old names.

use crate::{Motmod, pins::LETTERS};
use hal_bench::Bench;
use trivkins::Trivkins;

const JOINT: &str = "\
float OUT acc-cmd
bit OUT active
bit OUT amp-enable-out
bit IN amp-fault-in
float OUT backlash-corr
float OUT backlash-filt
float OUT backlash-vel
float OUT coarse-pos-cmd
bit OUT error
float OUT f-error
float OUT f-error-lim
bit OUT f-errored
bit OUT faulted
float OUT free-pos-cmd
bit OUT free-tp-enable
float OUT free-vel-lim
s32 OUT home-state
bit IN home-sw-in
bit OUT homed
bit OUT homing
bit OUT in-position
bit I/O index-enable
float OUT jerk-cmd
float IN jog-accel-fraction
s32 IN jog-counts
bit IN jog-enable
float IN jog-scale
bit IN jog-vel-mode
bit OUT kb-jog-active
float OUT motor-offset
float OUT motor-pos-cmd
float IN motor-pos-fb
bit RO motor-pos-fb-measured
bit OUT neg-hard-limit
bit IN neg-lim-sw-in
float OUT pos-cmd
float OUT pos-fb
bit OUT pos-hard-limit
bit IN pos-lim-sw-in
float OUT vel-cmd
float OUT watch-acceleration
float OUT watch-jerk
float OUT watch-velocity
bit OUT wheel-jog-active";

const AXIS: &str = "\
float OUT eoffset
bit IN eoffset-clear
s32 IN eoffset-counts
bit IN eoffset-enable
float OUT eoffset-request
float IN eoffset-scale
float IN jog-accel-fraction
s32 IN jog-counts
bit IN jog-enable
float IN jog-scale
bit IN jog-vel-mode
bit OUT kb-jog-active
float OUT pos-cmd
float OUT teleop-pos-cmd
bit OUT teleop-tp-enable
float OUT teleop-vel-cmd
float OUT teleop-vel-lim
bit OUT wheel-jog-active";

const SPINDLE: &str = "\
bit IN amp-fault-in
bit IN at-speed
bit OUT brake
bit OUT forward
bit I/O index-enable
bit IN inhibit
bit IN is-oriented
bit OUT locked
bit OUT on
bit OUT orient
float OUT orient-angle
s32 IN orient-fault
s32 OUT orient-mode
bit OUT reverse
float IN revs
float OUT speed-cmd-rps
float IN speed-in
float OUT speed-out
float OUT speed-out-abs
float OUT speed-out-rps
float OUT speed-out-rps-abs
float OUT sync-error";

const GENERAL: &str = "\
float IN motion.adaptive-feed
float IN motion.analog-in-00
float OUT motion.analog-out-00
bit OUT motion.coord-error
bit OUT motion.coord-mode
float OUT motion.current-vel
bit RO motion.debug-bit-0
bit RO motion.debug-bit-1
float RO motion.debug-float-0
float RO motion.debug-float-1
float RO motion.debug-float-2
float RO motion.debug-float-3
s32 RO motion.debug-s32-0
s32 RO motion.debug-s32-1
bit IN motion.digital-in-00
bit OUT motion.digital-out-00
float OUT motion.distance-to-go
bit IN motion.enable
bit OUT motion.eoffset-active
bit OUT motion.eoffset-limited
bit IN motion.feed-hold
float OUT motion.feed-inches-per-minute
float OUT motion.feed-inches-per-second
bit IN motion.feed-inhibit
float OUT motion.feed-mm-per-minute
float OUT motion.feed-mm-per-second
float OUT motion.feed-upm
bit IN motion.homing-inhibit
bit OUT motion.in-position
float OUT motion.interp.arc-center-x
float OUT motion.interp.arc-center-y
float OUT motion.interp.arc-center-z
float OUT motion.interp.arc-radius
float OUT motion.interp.feedrate
float OUT motion.interp.heading
bit OUT motion.interp.iscircle
s32 OUT motion.interp.line-number
s32 OUT motion.interp.motion-type
float OUT motion.interp.normal-heading
bit OUT motion.is-all-homed
bit IN motion.jog-inhibit
bit OUT motion.jog-is-active
bit IN motion.jog-stop
bit IN motion.jog-stop-immediate
bit IN motion.misc-error-00
bit OUT motion.motion-enabled
s32 OUT motion.motion-type
bit OUT motion.on-soft-limit
bit IN motion.probe-input
s32 OUT motion.program-line
float OUT motion.requested-vel
u32 OUT motion.servo.last-period
bit OUT motion.teleop-mode
bit OUT motion.tp-reverse
s32 OUT motion.watch.joint
s32 OUT motion.watch.line
u32 OUT motion.watch.violations
u32 OUT motion.watch.hard-stops
float OUT motion.watch.worst
bit IN motion.watch.reset
bit RW motion.watch.stop
float RO traj.pos_out
float RO traj.vel_out
u32 RO traj.active_tc
float IN joint.1.posthome-cmd
bit OUT joint.0.unlock
bit IN joint.0.is-unlocked";

fn bench(args: &[&str]) -> Bench {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&["kinstype=b"]).unwrap();
    bench.load::<Motmod>(args).unwrap();
    bench
}

#[test]
fn every_pin_and_parameter_is_there_and_no_other() {
    let bench = bench(&[
        "num_joints=2",
        "num_extrajoints=1",
        "num_spindles=2",
        "num_dio=1",
        "num_aio=1",
        "num_misc_error=1",
        "unlock_joints_mask=1",
    ]);
    let mut expected = Vec::new();
    let mut add = |list: &str, prefix: &str| {
        expected.extend(list.lines().map(|l| {
            let [ty, dir, name] = l.split(' ').collect::<Vec<_>>()[..] else { panic!("{l}") };
            format!("{prefix}{name} {ty} {dir}")
        }));
    };
    add(GENERAL, "");
    ["joint.0.", "joint.1."].iter().for_each(|p| add(JOINT, p));
    ["spindle.0.", "spindle.1."].iter().for_each(|p| add(SPINDLE, p));
    for letter in LETTERS {
        add(AXIS, &format!("axis.{letter}."));
        add(&format!("float OUT motion.tooloffset.{letter}"), "");
    }
    for n in 0..4 {
        ["pos", "vel", "acc"].iter().for_each(|v| add(&format!("float RO tc.{n}.{v}"), ""));
    }
    expected.sort();
    assert_eq!(bench.names(), expected);
}

#[test]
fn defaults_that_are_not_zero() {
    let bench = bench(&["num_joints=1"]);
    for name in ["motion.adaptive-feed", "joint.0.jog-accel-fraction", "axis.w.jog-accel-fraction"]
    {
        assert_eq!(bench.get::<f64>(name), 1.0, "{name}");
    }
    for name in ["motion.enable", "spindle.0.at-speed"] {
        assert!(bench.get::<bool>(name), "{name}");
    }
    for name in ["joint.0.amp-enable-out", "spindle.0.brake", "motion.in-position"] {
        assert!(!bench.get::<bool>(name), "{name}");
    }
}

#[test]
fn threads_and_functions() {
    for (args, threads) in [
        (&[][..], &[("servo-thread", 1_000_000)][..]),
        (
            &["base_period_nsec=100000", "servo_period_nsec=1000000"],
            &[("base-thread", 100_000), ("servo-thread", 1_000_000)],
        ),
        (
            &["base_period_nsec=300000", "servo_period_nsec=1000000"],
            &[("base-thread", 300_000), ("servo-thread", 900_000)],
        ),
    ] {
        let bench = bench(args);
        let made = bench.threads();
        let made: Vec<_> = made.iter().map(|(n, p)| (n.as_str(), *p)).collect();
        assert_eq!(made, threads);
        assert_eq!(bench.functs(), ["motion-command-handler", "motion-controller"]);
    }
}

#[test]
fn pins_by_name() {
    let bench = bench(&[
        "num_joints=1",
        "names_din=door,coolant",
        "names_aout=laser",
        "names_misc_errors=hot",
    ]);
    let names = bench.names();
    let of = |part: &str| {
        names.iter().filter(|n| n.contains(part)).map(String::as_str).collect::<Vec<_>>()
    };
    assert_eq!(of("motion.din-"), ["motion.din-coolant bit IN", "motion.din-door bit IN"]);
    assert_eq!(
        of("motion.digital-"),
        ["motion.digital-out-00 bit OUT", "motion.digital-out-01 bit OUT"]
    );
    assert_eq!(of("motion.aout-"), ["motion.aout-laser float OUT"]);
    assert_eq!(of("motion.analog-"), ["motion.analog-in-00 float IN"]);
    assert_eq!(of("motion.err-"), ["motion.err-hot bit IN"]);
}

#[test]
fn old_names_are_the_same_pins() {
    let bench = bench(&["num_joints=2"]);
    for (old, new) in [
        ("axis.1.motor-pos-fb", "joint.1.motor-pos-fb"),
        ("axis.0.motor-pos-cmd", "joint.0.motor-pos-cmd"),
        ("axis.0.joint-pos-cmd", "joint.0.pos-cmd"),
        ("axis.0.joint-pos-fb", "joint.0.pos-fb"),
        ("axis.0.joint-vel-cmd", "joint.0.vel-cmd"),
        ("axis.0.f-error", "joint.0.f-error"),
        ("axis.0.jog-scale", "joint.0.jog-scale"),
        ("motion.spindle-speed-out", "spindle.0.speed-out"),
        ("motion.spindle-speed-out-abs", "spindle.0.speed-out-abs"),
        ("motion.spindle-speed-out-rps", "spindle.0.speed-out-rps"),
        ("motion.spindle-speed-in", "spindle.0.speed-in"),
        ("motion.spindle-revs", "spindle.0.revs"),
        ("motion.spindle-orient-angle", "spindle.0.orient-angle"),
    ] {
        bench.set(new, 4.5);
        assert_eq!(bench.get::<f64>(old), 4.5, "{old}");
    }
    for (old, new) in [
        ("axis.0.amp-enable-out", "joint.0.amp-enable-out"),
        ("axis.0.amp-fault-in", "joint.0.amp-fault-in"),
        ("axis.0.neg-lim-sw-in", "joint.0.neg-lim-sw-in"),
        ("axis.0.pos-lim-sw-in", "joint.0.pos-lim-sw-in"),
        ("axis.0.home-sw-in", "joint.0.home-sw-in"),
        ("axis.0.homed", "joint.0.homed"),
        ("axis.0.homing", "joint.0.homing"),
        ("axis.0.in-position", "joint.0.in-position"),
        ("axis.0.index-enable", "joint.0.index-enable"),
        ("axis.0.jog-enable", "joint.0.jog-enable"),
        ("motion.spindle-forward", "spindle.0.forward"),
        ("motion.spindle-reverse", "spindle.0.reverse"),
        ("motion.spindle-on", "spindle.0.on"),
        ("motion.spindle-brake", "spindle.0.brake"),
        ("motion.spindle-index-enable", "spindle.0.index-enable"),
        ("motion.spindle-orient", "spindle.0.orient"),
        ("motion.spindle-is-oriented", "spindle.0.is-oriented"),
        ("motion.spindle-locked", "spindle.0.locked"),
    ] {
        bench.set(new, true);
        assert!(bench.get::<bool>(old), "{old}");
    }
    // The axis letters keep their own names in addition to the old joint names.
    bench.set("axis.x.jog-scale", 2.0);
    assert_eq!(bench.get::<f64>("axis.0.jog-scale"), 4.5);
}

#[test]
fn arguments_out_of_range() {
    for (args, text) in [
        (&["num_joints=0"][..], "num_joints is 0, must be between 1 and 16"),
        (&["num_joints=17"], "num_joints is 17, must be between 1 and 16"),
        (&["num_spindles=9"], "num_spindles is 9, must be between 0 and 8"),
        (&["num_dio=65"], "num_dio is 65, must be between 0 and 64"),
        (&["num_aio=-1"], "num_aio is -1, must be between 0 and 64"),
        (&["num_misc_error=65"], "num_misc_error is 65, must be between 0 and 64"),
        (&["num_dio=3", "names_din=a"], "num_dio= excludes names_din= and names_dout="),
        (
            &["num_misc_error=1", "names_misc_errors=a"],
            "num_misc_error= and names_misc_errors= exclude each other",
        ),
        (
            &["base_period_nsec=2000000"],
            "servo_period_nsec is 1000000, must be at least base_period_nsec, 2000000",
        ),
        (&["servo_period_nsec=0"], "servo_period_nsec is 0, must be above 0"),
        (&["num_joints=3", "num_extrajoints=4"], "num_extrajoints is 4, must be between 0 and 3"),
        (&["unlock_joints_mask=-1"], "unlock_joints_mask is -1, must be a mask of joints"),
    ] {
        let mut bench = Bench::new();
        bench.load::<Trivkins>(&["kinstype=b"]).unwrap();
        assert_eq!(bench.load::<Motmod>(args).unwrap_err(), text);
    }
    let mut bench = Bench::new();
    assert_eq!(bench.load::<Motmod>(&[]).unwrap_err(), "no kinematics loaded");
    bench.load::<Trivkins>(&[]).unwrap();
    let refused = bench.load::<Motmod>(&["num_extrajoints=1"]).unwrap_err();
    assert_eq!(refused, "num_extrajoints needs kinematics with kinstype=b");
}

#[test]
fn each_function_says_what_it_touches() {
    let bench = bench(&["num_joints=16"]);
    let touches = bench.touches("motion-controller");
    for line in ["joint.15.motor-pos-cmd w", "joint.0.motor-pos-fb r", "axis.w.jog-counts r", "# r"]
    {
        assert!(touches.iter().any(|t| t == line), "{line}");
    }
    assert_eq!(bench.touches("motion-command-handler"), ["# r", "# w"]);
}
