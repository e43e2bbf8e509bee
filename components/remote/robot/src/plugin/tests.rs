//! The plugin on the bench, where functions and worker run as the test says.

mod refused;
mod stops;

use super::Robot;
use hal_bench::Bench;
use hal_component::abi::TicketState;

const MS: i64 = 1_000_000;

/// The plugin with a simulated controller.
struct Rig(Bench);

impl Rig {
    fn new(args: &[&str]) -> Self {
        let mut bench = Bench::new();
        bench.load::<Robot>(args).unwrap();
        bench.set("robot.enable", true);
        let rig = Self(bench);
        rig.pass(10);
        rig
    }

    /// Lets milliseconds pass with both at work.
    fn pass(&self, ms: u32) {
        for n in 0..ms {
            self.0.pass(MS);
            self.0.run("robot", MS);
            if n % 2 == 1 {
                self.0.work("robot", 1).unwrap();
            }
        }
    }

    /// Lets milliseconds pass without the worker.
    fn stall(&self, ms: u32) {
        for _ in 0..ms {
            self.0.pass(MS);
            self.0.run("robot", MS);
        }
    }

    /// Returns the states that are TRUE, in the order of the alphabet.
    fn shown(&self) -> String {
        let mut all =
            ["busy", "connected", "connecting", "ended", "paused", "ready", "running", "stopped"]
                .to_vec();
        all.retain(|name| self.0.get::<bool>(&format!("robot.{name}")));
        all.join(" ")
    }

    fn connected() -> Self {
        let rig = Self::new(&[]);
        rig.0.command("robot.connect", &[]).unwrap();
        rig.pass(5100);
        assert!(rig.0.get::<bool>("robot.ready"));
        assert_eq!(rig.0.ticket(), Some(TicketState::Done));
        rig
    }

    /// Returns a rig in the first move of a run, which takes 6.4 s.
    fn running() -> Self {
        let rig = Self::connected();
        rig.load("G0 Z10\nG0 X50\n");
        rig.0.command("robot.run", &[]).unwrap();
        rig.pass(2000);
        rig
    }

    /// Gives a command that is refused; returns the reason.
    fn refused(&self, name: &str, args: &[&str]) -> String {
        self.0.command(name, args).unwrap();
        self.pass(10);
        self.0.failure().unwrap()
    }

    fn load(&self, text: &str) {
        let name = format!("ferrule-robot-{}-{:p}.nc", std::process::id(), self);
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).unwrap();
        self.0.command("robot.load", &[&format!("file={}", path.display())]).unwrap();
        assert!(self.0.is_awaited(), "a refusal must not be missed");
        self.pass(10);
        std::fs::remove_file(path).unwrap();
        assert_eq!(self.0.failure(), None);
    }

    fn error(&self) -> i32 {
        self.0.get("robot.error")
    }
}

#[test]
fn a_run_goes_on_in_the_middle_from_the_old_part_zero_alone() {
    let rig = Rig::connected();
    rig.load("G0 Z10\nG0 X50\nG0 Z20\n");
    for (x, is_same) in [(-399.7, true), (-398.0, false)] {
        rig.0.command("robot.disconnect", &[]).unwrap();
        rig.0.set("robot.sim.zero-x", x);
        rig.pass(10);
        rig.0.command("robot.connect", &[]).unwrap();
        rig.pass(5100);
        assert!(rig.0.get::<bool>("robot.ready"), "{x}");
        rig.0.command("robot.run", &[]).unwrap();
        rig.pass(10);
        let why = rig.0.failure().unwrap();
        assert!(
            why.contains("has changed since the program was loaded: robot.load again"),
            "{why}"
        );
        rig.0.command("robot.run", &["from=1"]).unwrap();
        rig.pass(100);
        assert_eq!(rig.0.get::<bool>("robot.running"), is_same);
        rig.pass(60_000);
        assert_eq!(rig.0.get::<bool>("robot.ended"), is_same);
    }
    let why = rig.0.failure().unwrap();
    assert!(why.contains("move the tool back to it, and robot.connect (it was X-400.000"), "{why}");
}

#[test]
fn numbers_that_are_none_change_nothing() {
    let rig = Rig::connected();
    for pin in ["robot.sim.lost", "robot.sim.doubled", "robot.sim.delay", "robot.sim.zero-x"] {
        rig.0.set(pin, f64::NAN);
    }
    rig.load("G0 Z10\nG0 X5\n");
    rig.0.command("robot.run", &[]).unwrap();
    rig.pass(6000);
    assert!(rig.0.get::<bool>("robot.ended"));
    rig.0.set("robot.tool-length", f64::NAN);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(6000);
    // The tool stays where the run has left it, which is another part zero.
    assert!(rig.0.get::<bool>("robot.ready"));
    let zero = ["x", "y", "z"].map(|axis| rig.0.get::<f64>(&format!("robot.zero-{axis}")));
    assert_eq!(zero, [-400.0, 5.0, -20.0]);
    rig.0.command("robot.disconnect", &[]).unwrap();
    rig.0.set("robot.sim.zero-x", -400.0);
    rig.pass(10);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(6000);
    assert!(rig.0.get::<f64>("robot.zero-y").to_bits() == 0, "a person has moved it back");
    rig.0.command("robot.run", &[]).unwrap();
    rig.pass(10);
    assert!(rig.0.failure().unwrap().starts_with("robot.tool-length has changed"));
    // A length that a load refuses reaches no joint of the next connection.
    let why = rig.0.command_from_afar("robot.load", &["file=part.nc"]).unwrap_err();
    assert_eq!(why, "a program is loaded at the machine or by the panel, and not from afar");
    let why = rig.refused("robot.load", &["file=nowhere.nc"]);
    assert_eq!(why, "the length of the tool is NaN: from 0 to 500 mm");
    let joint = rig.0.get::<f64>("robot.joint.1");
    rig.0.command("robot.disconnect", &[]).unwrap();
    rig.0.set("robot.sim.zero-x", -350.0);
    rig.pass(10);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(6000);
    let other = rig.0.get::<f64>("robot.joint.1");
    assert!(other.is_finite() && (other - joint).abs() > 1.0, "{joint} {other}");
}

#[test]
fn arguments_and_status() {
    let mut bench = Bench::new();
    let refused = bench.load::<Robot>(&["volume=1,2,3"]).unwrap_err();
    assert!(refused.contains("volume=1,2,3: six numbers are needed"), "{refused}");
    let refused = Bench::new().load::<Robot>(&["volume=1,0,0,0,0,0"]).unwrap_err();
    assert!(refused.contains("a least coordinate is above the greatest"), "{refused}");
    for to in ["", "robot", ":1", "robot:", "robot:0", "robot:65536", "a b:1", "ä:1", "[::1]1"] {
        let refused = Bench::new().load::<Robot>(&[&format!("to={to}")]).unwrap_err();
        assert!(refused.contains("must be HOST:PORT"), "{to}: {refused}");
    }
    for to in ["robot:1", "[::1]:55000", "192.168.47.5:65535"] {
        Bench::new().load::<Robot>(&[&format!("to={to}")]).unwrap();
    }
    let rig = Rig::connected();
    rig.load("G0 Z10\nG0 X5\n");
    let lines = rig.0.command("robot.status", &[]).unwrap();
    assert_eq!(lines[..2], ["state ready", "part zero -400.000 0.000 -30.000"]);
    assert!(lines[2].ends_with(".nc: line 0 of 1 JMOVE,5.000,0.000,10.000"), "{lines:?}");
    let json = rig.0.command("robot.status", &["json=TRUE"]).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json[0]).unwrap();
    assert_eq!((&json["state"], &json["zero"][2]), (&"ready".into(), &(-30.0).into()));
    // The joints of the part zero: acceptance case 3 of the arm.
    let joint = |n| rig.0.get::<f64>(&format!("robot.joint.{n}"));
    for (n, wanted) in [-90.0, 25.1588, -110.8242, 0.0, -44.017, 0.0].iter().enumerate() {
        assert!((joint(n) - wanted).abs() < 1e-3, "joint {n}: {}", joint(n));
    }
}

#[test]
fn a_run_from_the_middle_has_the_cutting_speed_of_its_program() {
    let rig = Rig::connected();
    rig.load("G0 Z10\nG1 X5 F120\nG0 X10\nG0 X20\n");
    assert_eq!(rig.0.get::<f64>("robot.speed"), 0.0);
    let last = rig.0.get::<i32>("robot.lines") - 1;
    rig.0.command("robot.run", &[&format!("from={last}")]).unwrap();
    rig.pass(10);
    assert_eq!(rig.0.get::<f64>("robot.speed"), 2.0);
}
