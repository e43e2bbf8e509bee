//! The plugin on the bench, where functions and worker run as the test says.

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

    fn connected() -> Self {
        let rig = Self::new(&[]);
        rig.0.command("robot.connect", &[]).unwrap();
        rig.pass(5100);
        assert!(rig.0.get::<bool>("robot.ready"));
        assert_eq!(rig.0.ticket(), Some(TicketState::Done));
        rig
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
fn a_dead_worker_is_an_error_and_a_living_one_none_again() {
    let rig = Rig::connected();
    for _ in 0..1000 {
        rig.0.pass(MS);
        rig.0.run("robot", MS);
    }
    assert!(rig.0.get::<bool>("robot.connected") && rig.error() == 0);
    for _ in 0..10 {
        rig.0.pass(MS);
        rig.0.run("robot", MS);
    }
    assert!(!rig.0.get::<bool>("robot.connected") && !rig.0.get::<bool>("robot.ready"));
    assert!(rig.0.get::<bool>("robot.stopped"));
    assert_eq!(rig.error(), 8);
    rig.pass(4);
    assert_eq!(rig.error(), 0);
}

#[test]
fn a_connection_needs_the_function_and_ends_without_it() {
    let mut bench = Bench::new();
    bench.load::<Robot>(&[]).unwrap();
    bench.command("robot.connect", &[]).unwrap();
    bench.work("robot", 1).unwrap();
    bench.work("robot", 1).unwrap();
    assert_eq!(bench.failure().unwrap(), "function robot is in no thread that runs");

    let rig = Rig::connected();
    rig.load("G0 Z10\nG0 X50\n");
    rig.0.command("robot.run", &[]).unwrap();
    rig.pass(2000);
    assert!(rig.0.get::<bool>("robot.sim.moving"));
    for _ in 0..300 {
        rig.0.pass(2 * MS);
        rig.0.work("robot", 1).unwrap();
    }
    let wanted = "function robot is in no thread that runs: stopped at line 0";
    assert_eq!(rig.0.failure().unwrap(), wanted);
    rig.pass(10);
    assert_eq!((rig.error(), rig.0.get::<bool>("robot.sim.moving")), (9, false));
    assert!(rig.0.said().iter().any(|text| text.contains("function robot is in no thread")));
}

#[test]
fn the_stop_action_of_the_instance_ends_a_run() {
    let rig = Rig::connected();
    rig.load("G0 Z10\nG0 X50\n");
    rig.0.command("robot.run", &[]).unwrap();
    rig.pass(2000);
    rig.0.stop();
    rig.0.stop();
    rig.pass(10);
    assert_eq!((rig.error(), rig.0.get::<bool>("robot.sim.moving")), (10, false));
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
    assert!(rig.0.get::<bool>("robot.ready"), "the tool stays where it was");
    rig.0.command("robot.run", &[]).unwrap();
    rig.pass(10);
    assert!(rig.0.failure().unwrap().starts_with("robot.tool-length has changed"));
    assert!(rig.0.get::<f64>("robot.joint.0").is_finite());
}

#[test]
fn many_commands_at_once_are_refused_but_for_the_stop() {
    let rig = Rig::connected();
    let mut refused = 0;
    for _ in 0..40 {
        refused += usize::from(rig.0.command("robot.pause", &[]).is_err());
    }
    assert_eq!(refused, 24);
    rig.0.command("robot.stop", &[]).unwrap();
    rig.pass(4);
    assert_eq!((rig.error(), rig.0.get::<bool>("robot.connected")), (1, false));
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
