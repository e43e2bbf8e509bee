//! The component on the bench, where functions and worker run as the test says.

mod drive;
mod halt;
mod lost;
mod names;
mod pty;
mod run;

use super::HyVfd;
use hal_bench::Bench;

const MS: i64 = 1_000_000;

/// The component with the simulated inverter.
struct Rig(Bench);

impl Rig {
    /// Returns an inverter that answers, with a spindle that stands.
    fn new(args: &[&str]) -> Self {
        let mut bench = Bench::new();
        bench.load::<HyVfd>(args).unwrap();
        let rig = Self(bench);
        rig.set("enable", true);
        rig.set("speed-command", 12_000.0);
        rig.set("spindle-forward", true);
        rig.pass(1000);
        assert!(rig.is("hycomm-ok") && !rig.is("fault"));
        rig
    }

    /// Returns an inverter that runs at its speed.
    fn running(args: &[&str]) -> Self {
        let rig = Self::new(args);
        rig.set("spindle-on", true);
        rig.pass(3000);
        assert!(rig.is("spindle-at-speed") && rig.is("sim.running"));
        rig
    }

    fn set<T: hal_component::Value>(&self, pin: &str, value: T) {
        self.0.set(&format!("hy_vfd.{pin}"), value);
    }

    fn is(&self, pin: &str) -> bool {
        self.0.get(&format!("hy_vfd.{pin}"))
    }

    fn get(&self, pin: &str) -> f64 {
        self.0.get(&format!("hy_vfd.{pin}"))
    }

    fn count(&self, pin: &str) -> u32 {
        self.0.get(&format!("hy_vfd.{pin}"))
    }

    /// Forgets the messages so far.
    fn forget(&self) {
        drop(self.0.said());
    }

    /// Lets milliseconds pass with both at work.
    fn pass(&self, ms: u32) {
        for _ in 0..ms {
            self.0.pass(MS);
            self.0.run("hy_vfd", MS);
            self.0.work("hy_vfd", 1).unwrap();
        }
    }

    /// Lets milliseconds pass without the worker.
    fn stall(&self, ms: u32) {
        for _ in 0..ms {
            self.0.pass(MS);
            self.0.run("hy_vfd", MS);
        }
    }

    /// Lets milliseconds pass without the function.
    fn idle(&self, ms: u32) {
        for _ in 0..ms {
            self.0.pass(MS);
            self.0.work("hy_vfd", 1).unwrap();
        }
    }

    /// Returns the number of milliseconds until a pin has a value.
    fn until(&self, pin: &str, value: bool) -> u32 {
        for ms in 0..10_000 {
            if self.is(pin) == value {
                return ms;
            }
            self.pass(1);
        }
        panic!("hy_vfd.{pin} does not become {value}");
    }

    /// Checks that nothing starts by itself, and that a person can start the spindle.
    fn starts_by_a_person_alone(&self) {
        let starts = self.count("sim.starts");
        self.pass(5000);
        assert!(self.is("spindle-on") && !self.is("sim.running") && !self.is("fault"));
        assert_eq!((self.count("sim.starts"), self.get("sim.frequency")), (starts, 0.0));
        self.set("spindle-on", false);
        self.pass(10);
        self.set("spindle-on", true);
        self.pass(5000);
        assert!(self.is("sim.running") && self.is("spindle-at-speed"));
        assert_eq!(self.count("sim.starts"), starts + 1);
    }
}
