//! Ends and holds of runs and connections.

use super::{
    super::{Robot, gate::Stops},
    MS, Rig,
};
use hal_bench::Bench;

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
fn an_order_from_before_a_stop_is_refused() {
    const STOPPED: &str = "the robot was stopped after this order was given";
    type Stop = fn(&Rig);
    let stops: [(&str, Stop); 3] = [
        ("robot.stop", |rig| drop(rig.0.command("robot.stop", &[]).unwrap())),
        ("stop", |rig| {
            rig.0.set("robot.stop", true);
            rig.pass(2);
            rig.0.set("robot.stop", false);
        }),
        ("enable", |rig| {
            rig.0.set("robot.enable", false);
            rig.pass(2);
            rig.0.set("robot.enable", true);
        }),
    ];
    for (name, stop) in stops {
        let rig = Rig::connected();
        rig.load("G0 Z10\nG0 X50\n");
        let at = || rig.0.snapshot::<Stops>("robot.stops").epoch;
        let before = at();
        let arg = format!("epoch={before}");
        stop(&rig);
        rig.pass(10);
        assert_eq!(at(), before + 1, "{name}: one stop is one");
        for order in ["robot.connect", "robot.run", "robot.resume"] {
            assert_eq!(rig.0.command(order, &[&arg]).unwrap_err(), STOPPED, "{name} {order}");
        }
        // Of now, or without an epoch, it is given again.
        rig.0.command("robot.connect", &[&format!("epoch={}", at())]).unwrap();
        rig.pass(6000);
        assert!(rig.0.get::<bool>("robot.ready"), "{name}");
        rig.0.command("robot.run", &["epoch=-1"]).unwrap();
        rig.pass(10);
        assert!(rig.0.get::<bool>("robot.running"), "{name}");
    }
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
