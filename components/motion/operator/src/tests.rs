//! `halui` and `inihal` with a motion controller and an e-stop.

mod jog;
mod knob;
mod machine;
mod settings;
mod task;

use crate::{halui::Halui, inihal::Inihal};
use hal_bench::Bench;
use hal_component::{MotionRef, OperatorRef, OperatorRequest, OperatorView};
use motion::Motmod;
use toolchange::Iocontrol;
use trivkins::Trivkins;

const PERIOD: i64 = 1_000_000;

struct Rig(Bench);

impl Rig {
    fn new() -> Self {
        let mut bench = Bench::new();
        bench.load::<Iocontrol>(&["cycle_time=0.01"]).unwrap();
        bench.load::<Trivkins>(&["coordinates=xyz"]).unwrap();
        bench.load::<Motmod>(&["num_joints=3"]).unwrap();
        for n in 0..3 {
            let joint = format!("joint={n}");
            let args = [
                &*joint,
                "max-velocity=100",
                "max-acceleration=1000",
                "min-limit=-50",
                "max-limit=50",
                "ferror=1",
                "min-ferror=1",
            ];
            bench.command("motion.configure", &args).unwrap();
        }
        bench.command("motion.configure", &["max-velocity=80"]).unwrap();
        bench.load::<Halui>(&["coordinates=XYZ", "mdi_commands=G0 X1|(MSG,a) G0 X0"]).unwrap();
        bench.load::<Inihal>(&[]).unwrap();
        let mut rig = Self(bench);
        rig.cycles(20);
        rig
    }

    /// Returns a machine that is on.
    fn on() -> Self {
        let mut rig = Self::new();
        rig.press("machine.on");
        rig.cycles(20);
        assert!(rig.is("machine.is-on"), "{:?}", rig.0.said());
        rig
    }

    fn cycles(&mut self, n: usize) {
        for cycle in 0..n {
            self.0.pass(PERIOD);
            self.0.run("motion-command-handler", PERIOD);
            self.0.run("motion-controller", PERIOD);
            self.0.work("motmod.planner", 64).unwrap();
            for joint in 0..3 {
                let cmd: f64 = self.0.get(&format!("joint.{joint}.motor-pos-cmd"));
                self.0.set(&format!("joint.{joint}.motor-pos-fb"), cmd);
            }
            let estop: bool = self.0.get("iocontrol.0.user-enable-out");
            self.0.set("iocontrol.0.emc-enable-in", estop);
            if cycle % 10 == 9 {
                for task in ["iocontrol", "halui", "inihal"] {
                    self.0.run(task, 10 * PERIOD);
                }
            }
        }
    }

    fn set<T: hal_component::Value>(&self, pin: &str, value: T) {
        self.0.set(&format!("halui.{pin}"), value);
    }

    /// Presses a button and releases it.
    fn press(&mut self, pin: &str) {
        self.set(pin, true);
        self.cycles(20);
        self.set(pin, false);
        self.cycles(20);
    }

    fn is(&self, pin: &str) -> bool {
        self.0.get(&format!("halui.{pin}"))
    }

    fn float(&self, pin: &str) -> f64 {
        self.0.get(&format!("halui.{pin}"))
    }

    fn at(&self, joint: usize) -> f64 {
        self.0.get(&format!("joint.{joint}.pos-cmd"))
    }

    /// Stops the motion that a test has ended.
    fn rest(&mut self) {
        self.cycles(300);
        assert!(self.0.get::<bool>("motion.in-position"));
    }
}
