//! Axes move only where forward and inverse kinematics lead back to the same joints.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

use hal_bench::{Bench, Random};
use hal_component::{Component, KinematicsRef, abi::TicketState};
use kinematics as k;

const PERIOD: i64 = 1_000_000;
const DT: f64 = 1e-3;
const VELOCITY: f64 = 100.0;
const ACCELERATION: f64 = 2000.0;

struct Machine {
    bench: Bench,
    joints: usize,
}

impl Machine {
    /// Returns a machine that is on and homed, with the joints at these positions.
    fn new<K: Component>(set: &[(&str, f64)], homes: &[f64]) -> Self {
        let mut bench = Bench::new();
        bench.load::<K>(&[]).unwrap();
        set.iter().for_each(|(name, value)| bench.set(name, *value));
        let joints = homes.len();
        bench.load::<motion::Motmod>(&[&format!("num_joints={joints}")]).unwrap();
        let mut machine = Self { bench, joints };
        for (n, home) in homes.iter().enumerate() {
            machine.say(&format!(
                "motion.configure joint={n} max-velocity={VELOCITY} \
                 max-acceleration={ACCELERATION} min-limit=-2000 max-limit=2000 ferror=1 \
                 min-ferror=1 home={home} home-offset={home}"
            ));
        }
        machine.say("motion.configure max-velocity=100 max-acceleration=2000");
        machine.wait("motion.enable").unwrap();
        machine.wait("motion.home joint=all").unwrap();
        machine
    }

    fn say(&self, text: &str) {
        let mut words = text.split_whitespace();
        let name = words.next().unwrap();
        let said = self.bench.command(name, &words.collect::<Vec<_>>());
        said.unwrap_or_else(|e| panic!("{text}: {e}"));
    }

    /// Runs a command. Returns its error.
    fn wait(&mut self, text: &str) -> Result<(), String> {
        self.say(text);
        for _ in 0..100_000 {
            match self.bench.ticket().unwrap() {
                TicketState::Pending => self.cycle(),
                TicketState::Done => return Ok(()),
                TicketState::Failed(_) => return Err(self.bench.failure().unwrap()),
            }
        }
        panic!("{text} never ends");
    }

    fn cycle(&mut self) {
        let before = self.motors();
        let was_on = self.bench.get::<bool>("motion.motion-enabled");
        self.bench.pass(PERIOD);
        self.bench.run("motion-command-handler", PERIOD);
        self.bench.run("motion-controller", PERIOD);
        self.bench.work("motmod.planner", 64).unwrap();
        let now = self.motors();
        for (n, (before, now)) in before.iter().zip(&now).enumerate() {
            let step = (now - before).abs();
            assert!(!was_on || step <= VELOCITY * DT * (1.0 + 1e-5), "joint {n} went by {step}");
            self.bench.set(&format!("joint.{n}.motor-pos-fb"), *now);
        }
    }

    fn places(&self) -> Vec<f64> {
        (0..self.joints).map(|n| self.bench.get(&format!("joint.{n}.pos-cmd"))).collect()
    }

    fn motors(&self) -> Vec<f64> {
        (0..self.joints).map(|n| self.bench.get(&format!("joint.{n}.motor-pos-cmd"))).collect()
    }
}

/// Every command that moves an axis.
const WAYS: [&str; 6] = [
    "motion.mode mode=teleop",
    "motion.mode mode=coord",
    "motion.jog axis=x velocity=10",
    "motion.jog axis=z velocity=10 distance=1",
    "motion.move x=0 y=0 z=0",
    "motion.move c=10",
];

#[test]
fn a_delta_without_a_pose_does_not_move() {
    for (homes, said) in [
        ([450.0, 0.0, 0.0], "joint 0 at 450"),
        ([0.0, 450.0, 0.0], "joint 1 at 450"),
        ([0.0, 0.0, -450.0], "joint 2 at -450"),
    ] {
        let set = [("lineardeltakins.R", 130.0), ("lineardeltakins.L", 280.0)];
        for way in WAYS {
            let mut machine = Machine::new::<k::Lineardeltakins>(&set, &homes);
            for letter in ["x", "y", "z"] {
                machine.bench.set(&format!("axis.{letter}.jog-enable"), true);
                machine.bench.set(&format!("axis.{letter}.jog-scale"), 1.0);
                machine.bench.set(&format!("axis.{letter}.eoffset-enable"), true);
                machine.bench.set(&format!("axis.{letter}.eoffset-scale"), 1.0);
                machine.say(&format!("motion.configure axis={letter} offset-av-ratio=0.5"));
            }
            machine.cycle();
            assert_eq!(machine.places(), homes);
            let why = format!("the axes cannot move: the kinematics have no pose for {said}");
            assert_eq!(machine.wait(way).as_ref(), Err(&why), "{way}");
            assert_eq!(machine.bench.said(), [why]);
            for n in 0..50 {
                machine.bench.set("axis.x.jog-counts", n);
                machine.bench.set("axis.y.eoffset-counts", n);
                machine.cycle();
                assert_eq!(machine.places(), homes, "{way}");
            }
            assert!(machine.bench.get::<bool>("motion.motion-enabled"));
            assert!(!machine.bench.get::<bool>("motion.teleop-mode"));
            assert!(!machine.bench.get::<bool>("motion.coord-mode"));
            // Joints can still be jogged to a position with a pose.
            for (n, home) in homes.iter().enumerate() {
                let to = if *home == 0.0 { 400.0 } else { 450.0 };
                machine.wait(&format!("motion.jog joint={n} velocity=100 position={to}")).unwrap();
            }
            machine.wait("motion.mode mode=teleop").unwrap();
            assert!(machine.bench.get::<bool>("motion.teleop-mode"));
        }
    }
}

/// Returns random joints, or those of a random pose.
fn homes<K: Component>(random: &mut Random) -> Vec<f64> {
    let count = random.pick(&[3, 5, 6]);
    let reach = random.pick(&[1.0, 40.0, 300.0]);
    let mut joints = [0.0; 16].map(|_: f64| random.between(-reach, reach));
    if random.below(2) == 0 {
        let mut bench = Bench::new();
        bench.load::<K>(&[]).unwrap();
        let kinematics: KinematicsRef = bench.find();
        let mut pose = [0.0; 9].map(|_: f64| random.between(-20.0, 20.0));
        pose[2] += random.pick(&[-300.0, 0.0, 20.0, 300.0]);
        if kinematics.inverse(&pose, &mut joints).is_ok() {
            return joints[..6].to_vec();
        }
    }
    joints[..count].to_vec()
}

/// Enters a mode in which axes move: it is refused, or entered without motion. Then jogs several axes at once.
fn try_modes<K: Component>(random: &mut Random) -> String {
    let [mut refused, mut entered, mut stopped] = [0; 3];
    for _ in 0..40 {
        let homes = homes::<K>(random);
        let mut machine = Machine::new::<K>(&[], &homes);
        machine.cycle();
        let before = machine.places();
        let mode = random.pick(&["teleop", "coord"]);
        let answer = machine.wait(&format!("motion.mode mode={mode}"));
        for _ in 0..20 {
            machine.cycle();
            for (before, now) in before.iter().zip(machine.places()) {
                let step = if answer.is_ok() { ACCELERATION * DT * DT + 1e-6 } else { 0.0 };
                assert!((now - before).abs() <= step, "{}: {homes:?} {before} {now}", K::NAME);
            }
        }
        assert!(machine.bench.get::<bool>("motion.motion-enabled"), "{:?}", machine.bench.said());
        if let Err(why) = answer {
            refused += 1;
            assert!(why.starts_with("the axes cannot move: "), "{}: {why}", K::NAME);
            continue;
        }
        entered += 1;
        for letter in ["x", "y", "z"] {
            let velocity = random.between(-200.0, 200.0);
            let args = [format!("axis={letter}"), format!("velocity={velocity}")];
            // An axis may have no joint, or the arm no room.
            drop(machine.bench.command("motion.jog", &[&args[0], &args[1]]));
        }
        (0..300).for_each(|_| machine.cycle());
        stopped += usize::from(!machine.bench.get::<bool>("motion.motion-enabled"));
    }
    format!("{} refused {refused} entered {entered} stopped {stopped}\n", K::NAME)
}

/// Expected counts: no machine is stopped.
const SEEN: &str = "\
corexykins refused 0 entered 40 stopped 0
5axiskins refused 0 entered 40 stopped 0
genhexkins refused 14 entered 26 stopped 0
genserkins refused 0 entered 40 stopped 0
lineardeltakins refused 4 entered 36 stopped 0
matrixkins refused 0 entered 40 stopped 0
maxkins refused 0 entered 40 stopped 0
millturn refused 0 entered 40 stopped 0
pentakins refused 31 entered 9 stopped 0
pumakins refused 0 entered 40 stopped 0
rosekins refused 11 entered 29 stopped 0
rotarydeltakins refused 26 entered 14 stopped 0
rotatekins refused 0 entered 40 stopped 0
scarakins refused 0 entered 40 stopped 0
scorbot-kins refused 19 entered 21 stopped 0
three21kins refused 0 entered 40 stopped 0
tripodkins refused 21 entered 19 stopped 0
userkins refused 0 entered 40 stopped 0
xyzab_tdr_kins refused 0 entered 40 stopped 0
xyzac-trt-kins refused 0 entered 40 stopped 0
xyzbc-trt-kins refused 0 entered 40 stopped 0
xyzacb_trsrn refused 0 entered 40 stopped 0
xyzbca_trsrn refused 0 entered 40 stopped 0
";

#[test]
fn joints_anywhere_do_not_move_as_a_mode_is_entered() {
    let mut random = Random::new(5);
    let mut seen = String::new();
    macro_rules! all {
        ($($name:ident)*) => {$(seen += &try_modes::<k::$name>(&mut random);)*};
    }
    all! {
        Corexykins FiveAxiskins Genhexkins Genserkins Lineardeltakins Matrixkins Maxkins Millturn
        Pentakins Pumakins Rosekins Rotarydeltakins Rotatekins Scarakins ScorbotKins Three21kins
        Tripodkins Userkins XyzabTdr XyzacTrt XyzbcTrt XyzacbTrsrn XyzbcaTrsrn
    }
    assert_eq!(seen, SEEN);
}
