//! Test bench of the controller: motors that follow, and checks of every cycle.

mod command;
mod compensation;
mod event;
mod fault;
mod follow;
mod gap;
mod hold_jerk;
mod home;
mod interlock;
mod jerk;
mod jog;
mod jump;
mod line;
mod offset;
mod output;
mod page;
mod path;
mod pin;
mod ramp;
mod random;
mod retract;
mod segments;
mod service;
mod snapshot;
mod speed;
mod spindle_stop;
mod stop_line;
mod switch;
mod sync;
mod tap;
mod trouble;
mod two_spindles;
mod walk;
mod watch;
mod world;

use crate::Motmod;
use hal_bench::Bench;
use hal_component::{Component, abi::TicketState};
use trivkins::Trivkins;

/// Servo period in nanoseconds, and in seconds.
const PERIOD: i64 = 1_000_000;
const DT: f64 = 1e-3;

/// Limits of the joints: velocity, acceleration, lowest and highest position.
const LIMITS: [(f64, f64, f64, f64); 3] =
    [(90.0, 1350.0, -50.0, 200.0), (90.0, 1350.0, -50.0, 200.0), (10.0, 35.0, -100.0, 100.0)];

/// A machine of three joints whose motors are at their commanded positions.
struct Rig {
    bench: Bench,
    /// True for motors that do not follow.
    stuck: [bool; 3],
    /// Last two commands and velocities of each joint.
    seen: [(f64, f64); 3],
    /// True if velocity and acceleration are checked against the limits.
    strict: bool,
    /// Cycles that a test has waited for commands.
    waited: u32,
    /// Spindle that turns as its pins command.
    turner: Option<follow::Turner>,
    /// True while the planner does not run.
    is_starved: bool,
}

impl Rig {
    /// Returns a machine that is configured and off.
    fn off(kinematics: &[&str]) -> Self {
        let mut bench = Bench::new();
        bench.load::<Trivkins>(kinematics).unwrap();
        Self::with(bench)
    }

    /// Returns the same machine, with the kinematics that are on the bench.
    fn with(bench: Bench) -> Self {
        Self::of::<Motmod>(bench)
    }

    /// Returns the same machine, with a modified motion controller.
    fn of<M: Component>(bench: Bench) -> Self {
        Self::load::<M>(bench, &[])
    }

    /// Returns the same machine, with more arguments for the motion controller.
    fn load<M: Component>(mut bench: Bench, args: &[&str]) -> Self {
        let args = [&["num_joints=3", "num_misc_error=2"], args].concat();
        bench.load::<M>(&args).unwrap();
        let rig = Self {
            bench,
            stuck: [false; 3],
            seen: [(0.0, 0.0); 3],
            strict: true,
            waited: 0,
            turner: None,
            is_starved: false,
        };
        for (n, (velocity, acceleration, min, max)) in LIMITS.iter().enumerate() {
            rig.say(&format!(
                "motion.configure joint={n} max-velocity={velocity} \
                 max-acceleration={acceleration} min-limit={min} max-limit={max} ferror=1 \
                 min-ferror=.25"
            ));
        }
        rig
    }

    /// Returns a machine that is configured and on.
    fn on(kinematics: &[&str]) -> Self {
        let mut rig = Self::off(kinematics);
        rig.done("motion.enable");
        rig
    }

    /// Returns a machine that is on, with every joint homed at zero.
    fn homed(kinematics: &[&str]) -> Self {
        let mut rig = Self::on(kinematics);
        rig.done("motion.home joint=all");
        rig
    }

    /// Sends a command; returns the reason if it is refused at once.
    fn try_say(&self, text: &str) -> Result<Vec<String>, String> {
        let mut words = text.split_whitespace();
        let name = words.next().unwrap();
        self.bench.command(name, &words.collect::<Vec<_>>())
    }

    fn say(&self, text: &str) -> Vec<String> {
        self.try_say(text).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    /// Sends a command and waits for its end; returns the reason if it fails.
    fn wait(&mut self, text: &str) -> Result<(), &'static str> {
        self.say(text);
        self.end()
    }

    /// Waits for the last command.
    fn end(&mut self) -> Result<(), &'static str> {
        for _ in 0..200_000 {
            match self.bench.ticket().unwrap() {
                TicketState::Pending => self.cycle(),
                TicketState::Done => return Ok(()),
                TicketState::Failed(why) => return Err(why),
            }
        }
        panic!("never ends")
    }

    fn done(&mut self, text: &str) {
        self.wait(text).unwrap_or_else(|e| panic!("{text}: {e}"));
    }

    fn failed(&mut self, text: &str) -> &'static str {
        self.wait(text).expect_err(text)
    }

    /// Runs one servo cycle; checks the limits of joints that move.
    fn cycle(&mut self) {
        if let Some(mut turner) = self.turner.take() {
            turner.step(self);
            self.turner = Some(turner);
        }
        self.bench.pass(PERIOD);
        self.bench.run("motion-command-handler", PERIOD);
        self.bench.run("motion-controller", PERIOD);
        if !self.is_starved {
            self.bench.work("motmod.planner", 64).unwrap();
        }
        let on = self.is("motion.motion-enabled");
        let violations: u32 = self.bench.get("motion.watch.violations");
        assert!(!self.strict || violations == 0, "{:?}", self.bench.said());
        for (n, (velocity, acceleration, ..)) in LIMITS.iter().enumerate() {
            let cmd = self.joint(n, "motor-pos-cmd");
            let (last, last_vel) = self.seen[n];
            let vel = (cmd - last) / DT;
            if self.strict && on {
                let acc = (vel - last_vel) / DT;
                assert!(vel.abs() <= velocity * (1.0 + 1e-6), "joint {n}: {vel} units/s");
                assert!(acc.abs() <= acceleration * (1.0 + 1e-4), "joint {n}: {acc} units/s²");
            }
            self.seen[n] = (cmd, vel);
            if !self.stuck[n] {
                self.bench.set(&format!("joint.{n}.motor-pos-fb"), cmd);
            }
        }
    }

    fn cycles(&mut self, n: usize) {
        (0..n).for_each(|_| self.cycle());
    }

    fn joint(&self, n: usize, pin: &str) -> f64 {
        self.bench.get(&format!("joint.{n}.{pin}"))
    }

    fn places(&self) -> [f64; 3] {
        [0, 1, 2].map(|n| self.joint(n, "pos-cmd"))
    }

    fn is(&self, pin: &str) -> bool {
        self.bench.get(pin)
    }

    fn float(&self, pin: &str) -> f64 {
        self.bench.get(pin)
    }

    /// Returns the bits of a list that are TRUE.
    fn which<'p>(&self, pins: &[&'p str]) -> Vec<&'p str> {
        pins.iter().copied().filter(|p| self.is(p)).collect()
    }
}

/// Asserts that two numbers are equal within the planner's deadband.
fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 2e-6, "{a} is not {b}");
}
