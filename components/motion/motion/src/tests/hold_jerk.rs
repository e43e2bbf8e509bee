//! Random commands to a machine with limits of jerk, under the eyes of its watchman: jogs, wheels, homing, external offsets, moves,
//! probing and aborts.

use super::{LIMITS, Rig, random::orderly};
use hal_bench::Random;

/// Commands to one machine.
const COMMANDS: u32 = 250;

/// Joint whose switch is closed above this motor position.
const SWITCH: f64 = 30.0;

/// Distance within which joint 1 brakes from its highest speed.
const BRAKE: f64 = 10.0;

/// Returns a homed machine with limits of jerk, wheels, a home switch of joint 0 and an external offset of y.
fn machine(random: &mut Random, kinematics: &[&str]) -> Rig {
    let mut rig = Rig::on(kinematics);
    for n in 0..3 {
        let jerk = random.pick(&[500.0, 1e4, 3e4, 5e4, 1e5, 3e5, 1e6, 4e6]);
        rig.say(&format!("motion.configure joint={n} max-jerk={jerk}"));
        rig.bench.set(&format!("joint.{n}.jog-scale"), 0.05);
        rig.bench.set(&format!("joint.{n}.jog-enable"), true);
    }
    for axis in ["x", "y", "z"] {
        rig.bench.set(&format!("axis.{axis}.jog-scale"), 0.05);
        rig.bench.set(&format!("axis.{axis}.jog-enable"), true);
    }
    if random.below(2) == 0 {
        let jerk = random.pick(&[2e3, 2e4, 2e5]);
        rig.say(&format!("motion.configure axis=x max-jerk={jerk}"));
        rig.say(&format!("motion.configure max-jerk={}", random.pick(&[1e4, 1e5])));
    }
    if random.below(3) == 0 {
        rig.say("motion.configure axis=y offset-av-ratio=0.3");
        rig.bench.set("axis.y.eoffset-scale", 0.1);
        rig.bench.set("axis.y.eoffset-enable", true);
    }
    rig.done("motion.home joint=all");
    rig
}

/// Runs cycles in which the wheels and the offset's counts may change, with the switch of joint 0.
fn run(rig: &mut Rig, random: &mut Random, cycles: usize) {
    let fraction = random.between(0.0, 1.2);
    rig.bench.set("joint.0.jog-accel-fraction", fraction);
    rig.bench.set("axis.x.jog-accel-fraction", fraction);
    for _ in 0..cycles {
        if random.below(40) == 0 {
            let wheels =
                ["joint.0.jog", "joint.1.jog", "axis.x.jog", "axis.z.jog", "axis.y.eoffset"];
            let pin = format!("{}-counts", random.pick(&wheels));
            let counts: i32 = rig.bench.get(&pin);
            rig.bench.set(&pin, counts + random.pick(&[-40, -9, 2, 7, 60]));
        }
        let is_on = rig.joint(0, "motor-pos-cmd") > SWITCH;
        rig.bench.set("joint.0.home-sw-in", is_on);
        rig.cycle();
        for (n, (.., min, max)) in LIMITS.iter().enumerate() {
            let place = rig.joint(n, "pos-cmd");
            let is_inside = min - 1e-5 <= place && place <= max + 1e-5;
            // A path is planned without the offset: where that is too slow to give way, the path ends with an error.
            let by_offset =
                n == 1 && rig.is("motion.coord-mode") && rig.is("motion.eoffset-active");
            let beyond = (place - max).max(min - place);
            let is_ending = by_offset && rig.is("motion.on-soft-limit") && beyond < BRAKE;
            let is_homed = rig.is(&format!("joint.{n}.homed"));
            assert!(is_inside || is_ending || !is_homed, "joint {n} at {place}");
        }
    }
}

/// Gives random commands to random machines. [`Rig::cycle`] asserts that the watchman sees no violation.
fn hold(seed: u64, commands: u32) {
    let mut random = Random::new(seed);
    let mut given = 0;
    let mut worst = 0.0_f64;
    while given < commands {
        let kinematics = random.pick(&[&[][..], &["kinstype=b"]]);
        let mut rig = machine(&mut random, kinematics);
        for _ in 0..COMMANDS {
            given += 1;
            let speed = random.between(1.0, 120.0);
            let to = random.between(-40.0, 90.0);
            let text = match random.below(24) {
                0 => "motion.abort".to_owned(),
                1 => "motion.pause".to_owned(),
                2 => "motion.resume".to_owned(),
                3 => format!("motion.probe x={to} velocity={speed}"),
                4 => format!("motion.probe x={to} y=3 velocity={speed} away=1 optional=1"),
                5 => format!("motion.move x={to} y={} rapid=1 mode=blend tolerance=0.1", 0.5 * to),
                6 if random.below(4) == 0 => {
                    // From rest at the switch or before it, with the search in both directions.
                    let latch = random.pick(&[-4.0, 4.0]);
                    format!(
                        "motion.configure joint=0 home-search-vel={} home-latch-vel={latch} home=0 \
                         home-offset=30 home-final-vel=0",
                        random.pick(&[10.0, 40.0])
                    )
                }
                7 if random.below(4) == 0 => "motion.home joint=0".to_owned(),
                8 => format!("motion.mode mode={}", random.pick(&["free", "teleop", "coord"])),
                _ => orderly(&mut random),
            };
            // Refused or not, the limits hold.
            drop(rig.try_say(&text));
            rig.bench.set("motion.probe-input", random.below(6) == 0);
            rig.bench.set("motion.feed-hold", random.below(12) == 0);
            rig.bench.set("motion.jog-stop", random.below(12) == 0);
            let cycles = random.pick(&[1, 2, 5, 9, 17, 40, 120]);
            run(&mut rig, &mut random, cycles);
            let is_homing = rig.status().homing;
            if is_homing && random.below(2) == 0 {
                run(&mut rig, &mut random, 1500);
            }
            if !is_homing && !rig.status().all_homed {
                drop(rig.try_say("motion.home joint=all"));
                run(&mut rig, &mut random, 200);
            }
            assert!(rig.is("motion.motion-enabled"), "seed {seed}: {:?}", rig.bench.said());
        }
        worst = worst.max(rig.float("motion.watch.worst"));
    }
    assert!(0.99 < worst && worst <= 1.0, "{worst}");
}

#[test]
fn random_commands_hold_the_jerk() {
    for seed in 0..4 {
        hold(seed, 2_500);
    }
    // A jog of a joint in the cycle after the end of a jog of its axis.
    hold(101, 8_000);
    // A jog of a joint in the cycle after a pause on the path.
    hold(104, 10_000);
    // A jog toward the limit to which the axis's external offset moves.
    hold(123, 2_000);
}

#[test]
#[ignore = "a million commands take ten minutes: cargo test -p motion --release hold_jerk -- --ignored"]
fn a_million_random_commands_hold_the_jerk() {
    for seed in 100..200 {
        hold(seed, 10_000);
    }
}
