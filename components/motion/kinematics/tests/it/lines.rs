//! Machines whose joints are not axes move their tools along straight lines.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

use hal_bench::Bench;
use hal_component::{Component, KinematicsRef, abi::TicketState};
use kinematics::{Corexykins, FiveAxiskins, Lineardeltakins, Pumakins, Scarakins, XyzacTrt};

const PERIOD: i64 = 1_000_000;

struct Machine {
    bench: Bench,
    k: KinematicsRef,
    joints: usize,
}

impl Machine {
    /// Returns a machine that is on and homed, with the joints at these positions.
    fn new<K: Component>(homes: &[f64]) -> Self {
        let mut bench = Bench::new();
        bench.load::<K>(&[]).unwrap();
        let k = bench.find();
        let joints = homes.len();
        bench.load::<motion::Motmod>(&[&format!("num_joints={joints}")]).unwrap();
        let mut machine = Self { bench, k, joints };
        for (n, home) in homes.iter().enumerate() {
            machine.say(&format!(
                "motion.configure joint={n} max-velocity=200 max-acceleration=2000 \
                 min-limit=-2000 max-limit=2000 ferror=1 min-ferror=1 home={home} \
                 home-offset={home}"
            ));
        }
        machine.say("motion.configure max-velocity=500 max-acceleration=5000");
        machine.done("motion.enable");
        machine.done("motion.home joint=all");
        machine
    }

    fn say(&self, text: &str) {
        let mut words = text.split_whitespace();
        let name = words.next().unwrap();
        let said = self.bench.command(name, &words.collect::<Vec<_>>());
        said.unwrap_or_else(|e| panic!("{text}: {e}"));
    }

    fn cycle(&mut self) {
        self.bench.pass(PERIOD);
        self.bench.run("motion-command-handler", PERIOD);
        self.bench.run("motion-controller", PERIOD);
        self.bench.work("motmod.planner", 64).unwrap();
        for n in 0..self.joints {
            let cmd: f64 = self.bench.get(&format!("joint.{n}.motor-pos-cmd"));
            self.bench.set(&format!("joint.{n}.motor-pos-fb"), cmd);
        }
    }

    /// Runs a command, and calls `look` in every cycle.
    fn watched(&mut self, text: &str, mut look: impl FnMut([f64; 9])) {
        self.say(text);
        let mut guess = self.pose([0.0; 9]);
        for _ in 0..100_000 {
            match self.bench.ticket().unwrap() {
                TicketState::Pending => self.cycle(),
                TicketState::Done => return,
                TicketState::Failed(why) => panic!("{text}: {why}"),
            }
            guess = self.pose(guess);
            look(guess);
        }
        panic!("{text} never ends");
    }

    fn done(&mut self, text: &str) {
        self.watched(text, |_| ());
    }

    /// Returns the pose of the commanded joints.
    fn pose(&self, guess: [f64; 9]) -> [f64; 9] {
        let mut joints = [0.0; 16];
        for (n, place) in joints.iter_mut().enumerate().take(self.joints) {
            *place = self.bench.get(&format!("joint.{n}.pos-cmd"));
        }
        let mut pose = guess;
        self.k.forward(&joints, &mut pose).unwrap();
        pose
    }
}

const LETTERS: [&str; 9] = ["x", "y", "z", "a", "b", "c", "u", "v", "w"];

/// Moves by these displacements in turn. Asserts that the tool tip stays on its line, and that rotary letters turn in
/// proportion to the distance of the tip.
fn along<K: Component>(homes: &[f64], ways: &[&[(usize, f64)]]) {
    let mut machine = Machine::new::<K>(homes);
    for way in ways {
        let from = machine.pose([0.0; 9]);
        let mut to = from;
        let mut text = String::from("motion.move velocity=100");
        for (letter, way) in *way {
            to[*letter] += way;
            text += &format!(" {}={}", LETTERS[*letter], to[*letter]);
        }
        let mut looks = 0;
        let span: f64 = (0..3).map(|i| (to[i] - from[i]) * (to[i] - from[i])).sum();
        machine.watched(&text, |at| {
            let gone: f64 = (0..3).map(|i| (at[i] - from[i]) * (to[i] - from[i])).sum();
            let share = gone / span;
            assert!((-1e-9..=1.0 + 1e-9).contains(&share), "{share} of {text}");
            for i in 0..9 {
                let straight = from[i] + share * (to[i] - from[i]);
                assert!((at[i] - straight).abs() < 1e-6, "{text}: {at:?} at {share}");
            }
            looks += 1;
        });
        assert!(looks > 50, "{text} took {looks} cycles");
        let at = machine.pose(to);
        assert!((0..9).all(|i| (at[i] - to[i]).abs() < 1e-6), "{text} ended at {at:?}");
    }
}

#[test]
fn corexykins_moves_along_a_line() {
    along::<Corexykins>(&[0.0; 3], &[&[(0, 40.0), (1, 20.0)], &[(0, -10.0), (1, 60.0), (2, 5.0)]]);
}

#[test]
fn scarakins_moves_along_a_line() {
    let homes = [10.0, 60.0, 20.0, 0.0, 0.0, 0.0];
    along::<Scarakins>(&homes, &[&[(0, -80.0), (1, 40.0)], &[(0, 30.0), (2, 25.0), (5, 45.0)]]);
}

#[test]
fn lineardeltakins_moves_along_a_line() {
    along::<Lineardeltakins>(
        &[300.0; 3],
        &[&[(0, 50.0), (1, 30.0)], &[(0, -90.0), (1, -20.0), (2, 60.0)]],
    );
}

#[test]
fn five_axes_move_the_tip_along_a_line_while_the_head_turns() {
    along::<FiveAxiskins>(
        &[0.0; 6],
        &[&[(0, 50.0), (1, 30.0), (4, 30.0)], &[(0, -50.0), (2, 10.0), (4, -50.0), (5, 90.0)]],
    );
}

#[test]
fn a_tilting_table_moves_the_tip_along_a_line() {
    let ways: &[&[(usize, f64)]] = &[&[(0, 50.0), (3, 30.0), (5, 45.0)], &[(1, 40.0), (3, -40.0)]];
    along::<XyzacTrt>(&[10.0, 20.0, -30.0, 0.0, 0.0], ways);
}

#[test]
fn an_arm_moves_the_tip_along_a_line() {
    let homes = [10.0, -60.0, 40.0, 20.0, 50.0, 30.0];
    along::<Pumakins>(&homes, &[&[(0, 40.0), (2, -30.0)], &[(0, -60.0), (1, 50.0), (2, 20.0)]]);
}
