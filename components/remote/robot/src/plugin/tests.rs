//! The plugin on the bench, where functions and worker run as the test says.

use super::{Robot, cause::Cause, report::Report, session::Session};
use crate::{Command, Volume};
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
fn a_run_whose_worker_was_dead_is_busy_until_the_worker_has_ended_it() {
    let rig = Rig::running();
    rig.stall(1000);
    assert!(rig.0.get::<bool>("robot.running") && rig.error() == 0);
    // The lease holds a run that it sees: hold comes, and nothing resumes.
    rig.stall(10);
    assert_eq!((rig.error(), rig.shown().as_str()), (8, "busy stopped"));
    rig.0.set("robot.hold", true);
    rig.0.set("robot.run", true);
    rig.stall(10);
    rig.0.set("robot.hold", false);
    assert!(rig.0.get::<bool>("robot.sim.moving"));
    // A connection that was asked for meanwhile moves nothing: it would come as a surprise.
    let asked = rig.0.command("robot.connect", &[]);
    rig.stall(1010);
    rig.pass(10);
    asked.unwrap();
    assert!(rig.0.failure().unwrap().starts_with("the order has waited too long"));
    assert_eq!((rig.error(), rig.shown().as_str()), (8, "stopped"));
    let why = "the worker of robot did not work: stopped at line";
    assert!(rig.0.said().iter().any(|text| text.contains(why)));
    assert!(!rig.0.get::<bool>("robot.sim.moving"));
    let moves = rig.0.get::<i32>("robot.sim.moves");
    rig.pass(5000);
    assert_eq!((rig.error(), rig.shown().as_str()), (8, "stopped"));
    assert_eq!(rig.0.get::<i32>("robot.sim.moves"), moves);
}

#[test]
fn a_stop_and_a_connection_in_one_step_stop_the_robot_first() {
    // Both orders, and an end by the e-stop chain behind which a connection waits.
    for (first, then, busy) in
        [("robot.stop", "robot.connect", true), ("robot.connect", "robot.stop", false)]
    {
        let rig = Rig::running();
        let moves = rig.0.get::<i32>("robot.sim.moves");
        rig.0.command(first, &[]).unwrap();
        rig.0.command(then, &[]).unwrap();
        rig.pass(10);
        // Only the retract of the new connection moves it: the controller accepts that behind the end of the one before.
        assert_eq!(rig.0.get::<bool>("robot.connecting"), busy, "{first}");
        assert_eq!(rig.0.get::<bool>("robot.connected"), busy, "{first}");
        rig.pass(6000);
        assert_eq!(rig.0.get::<bool>("robot.ready"), busy, "{first}");
        assert_eq!(rig.0.get::<i32>("robot.sim.moves"), moves, "{first}");
        assert!(!rig.0.get::<bool>("robot.sim.moving"), "{first}");
    }
    let rig = Rig::running();
    rig.0.set("robot.enable", false);
    rig.0.run("robot", MS);
    rig.0.set("robot.enable", true);
    rig.0.run("robot", MS);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(10);
    assert!(rig.0.get::<bool>("robot.connecting"), "the controller has seen the end");
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
fn an_order_that_has_waited_long_moves_nothing() {
    for (order, is_stale) in [("robot.run", true), ("robot.pause", false)] {
        let rig = Rig::connected();
        rig.load("G0 Z10\nG0 X50\n");
        rig.0.command(order, &[]).unwrap();
        // Without the function's cycles this is no dead worker.
        rig.0.pass(1001 * MS);
        rig.pass(10);
        let why = rig.0.failure().unwrap();
        assert_eq!(why.starts_with("the order has waited too long"), is_stale, "{order}: {why}");
        assert!(!rig.0.get::<bool>("robot.busy"));
    }
}

#[test]
fn a_connection_is_busy_until_it_is_ready_and_hold_refuses_it() {
    let rig = Rig::new(&[]);
    rig.0.set("robot.hold", true);
    rig.pass(4);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(10);
    assert_eq!(rig.0.failure().unwrap(), "robot.hold is TRUE");
    rig.0.set("robot.hold", false);
    rig.pass(4);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(10);
    assert_eq!(rig.shown(), "busy connected connecting");
    rig.pass(5100);
    assert_eq!(rig.shown(), "connected ready");
    // The function stands: nothing connects, whatever enable was.
    rig.0.command("robot.disconnect", &[]).unwrap();
    rig.pass(10);
    rig.0.pass(600 * MS);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.0.work("robot", 1).unwrap();
    rig.0.work("robot", 1).unwrap();
    assert_eq!(rig.0.failure().unwrap(), "function robot is in no thread that runs");
}

#[test]
fn a_connection_needs_the_function_and_ends_without_it() {
    let mut bench = Bench::new();
    bench.load::<Robot>(&[]).unwrap();
    bench.command("robot.connect", &[]).unwrap();
    bench.work("robot", 1).unwrap();
    bench.work("robot", 1).unwrap();
    assert_eq!(bench.failure().unwrap(), "function robot is in no thread that runs");

    let rig = Rig::running();
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
    let rig = Rig::running();
    rig.0.stop();
    rig.0.stop();
    rig.pass(10);
    assert_eq!(rig.0.failure().unwrap(), "the instance has stopped: stopped at line 0");
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
fn many_commands_at_once_are_refused_but_for_the_stop() {
    let rig = Rig::connected();
    let mut refused = 0;
    for _ in 0..40 {
        if let Err(why) = rig.0.command("robot.pause", &[]) {
            assert_eq!(why, "too many commands wait for the worker of robot");
            refused += 1;
        }
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

#[test]
fn a_hold_precedes_an_answer_that_has_come() {
    let rig = Rig::connected();
    rig.load("G0 Z10\nG0 X5\nG0 X10\n");
    rig.0.command("robot.run", &[]).unwrap();
    while !rig.0.get::<bool>("robot.sim.moving") {
        rig.pass(2);
    }
    // The first move takes 4.03 s. Its answer and the hold come while the worker does not look.
    rig.pass(3900);
    rig.0.set("robot.hold", true);
    rig.stall(200);
    rig.pass(1000);
    assert_eq!(rig.shown(), "busy connected paused");
    assert_eq!((rig.0.get("robot.sim.moves"), rig.0.get("robot.sim.moving")), (1, false));
    rig.0.set("robot.hold", false);
    rig.pass(1000);
    assert_eq!((rig.shown().as_str(), rig.0.get("robot.sim.moves")), ("ended", 2));
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

#[test]
fn a_refusal_after_a_failed_connection_is_logged() {
    let rig = Rig::new(&[]);
    rig.0.set("robot.sim.cut", true);
    rig.pass(4);
    let why = "the simulated link is down";
    assert_eq!(rig.refused("robot.connect", &[]), why);
    assert_eq!(rig.error(), 7);
    let said = rig.0.said();
    assert_eq!(said.iter().filter(|text| text.contains(why)).count(), 1, "{said:?}");
    for (name, why) in [
        ("robot.run", "there is no program: robot.load first"),
        ("robot.pause", "no run is in progress"),
    ] {
        assert_eq!(rig.refused(name, &[]), why);
        let said = rig.0.said();
        assert!(said.iter().any(|text| text.contains(why)), "{said:?}");
    }
}

#[test]
fn a_command_that_does_not_fit_a_run_is_refused() {
    let rig = Rig::running();
    for (name, args, why) in [
        ("robot.connect", &[][..], "the controller is connected already"),
        ("robot.disconnect", &[], "a run is in progress: robot.stop ends it"),
        ("robot.load", &["file=nowhere.nc"], "a run is in progress"),
        ("robot.run", &[], "a run is in progress"),
    ] {
        assert_eq!(rig.refused(name, args), why);
    }
    rig.0.command("robot.pause", &[]).unwrap();
    rig.0.command("robot.pause", &[]).unwrap();
    rig.pass(10);
    let before = rig.0.tickets().into_iter().rev().nth(1);
    let why = "another command of this kind has followed";
    assert_eq!(
        (before, rig.0.ticket()),
        (Some(TicketState::Failed(why)), Some(TicketState::Pending))
    );
    rig.pass(6000);
    assert_eq!(
        (rig.0.ticket(), rig.shown().as_str()),
        (Some(TicketState::Done), "busy connected paused")
    );
}

#[test]
fn a_connection_that_a_command_ends_is_named() {
    let rig = Rig::new(&[]);
    rig.0.command("robot.connect", &[]).unwrap();
    rig.pass(10);
    rig.0.command("robot.disconnect", &[]).unwrap();
    rig.pass(10);
    let why = "robot.disconnect has ended the connection";
    assert_eq!(rig.0.tickets(), [TicketState::Failed(why), TicketState::Done]);
    assert_eq!((rig.error(), rig.shown().as_str()), (0, ""));
}

/// Returns a session without a link, whose driver has begun a run, and has sent its first line.
fn driven() -> Session {
    let mut session = Session::new(&Volume::default(), 20.0, None);
    session.driver.connected(0.0);
    session.driver.receive(b"-400 0 -30\r\nEsperando inicio\r\n", 0.0);
    assert!(session.driver.run(vec![Command::Rapid([5.0, 0.0, 10.0])], 0, 0.0));
    assert_eq!(session.driver.output(), b"inicio\r\n");
    session
}

/// Returns the last line of `robot.status`.
fn told(session: &Session) -> String {
    let mut report = Report::default();
    session.report(&mut report);
    report.lines().pop().unwrap()
}

#[test]
fn an_end_by_the_controller_has_its_number_and_its_text() {
    for (answer, number, text) in [
        ("error unknown\r\n", 5, "the controller does not know line 0"),
        ("error format\r\nerror unknown\r\n", 5, "the controller finds wrong numbers in line 0"),
        ("error range\r\n", 5, "the controller finds line 0 outside its range"),
        ("error busy\r\n", 6, "another client is connected to the controller"),
    ] {
        let mut session = driven();
        session.driver.receive(answer.as_bytes(), 0.0);
        assert_eq!(told(&session), format!("problem: {text}"));
        assert_eq!(session.results().error, number, "{text}");
    }
}

#[test]
fn the_reason_of_an_end_precedes_text_that_is_no_answer() {
    let mut session = driven();
    session.driver.receive(b"booting\r\n", 0.0);
    session.flush(false, 0.0);
    let noise = "the controller has sent text that is no answer";
    assert_eq!(told(&session), format!("problem: {noise}"));
    session.stop(Cause::Command, 0.0);
    assert_eq!(told(&session), format!("problem: stopped at line 0; {noise}"));
}

#[test]
fn the_end_of_the_instance_is_no_lost_connection() {
    let mut session = driven();
    session.driver.disconnected();
    assert_eq!(session.cause(), Some(Cause::Lost));
    session.end_with_instance(0.0);
    assert_eq!(session.cause(), Some(Cause::Instance));
    let mut session = Session::new(&Volume::default(), 20.0, None);
    session.end_with_instance(0.0);
    assert_eq!(session.cause(), None, "nothing has ended");
}
