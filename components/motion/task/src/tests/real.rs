//! The task on a real motion controller.

use super::{Rules, ToolTable};
use crate::{
    commands,
    core::Core,
    pins::Pins,
    status,
    worker::{Files, Shared, Worker},
};
use hal_bench::Bench;
use hal_component::{Builder, Component, Error, MotionRef, MotionStatus, abi::component_flags};
use hal_job::{Machine, World};
use motion::Motmod;
use std::{cell::RefCell, collections::BTreeMap};
use toolchange::Iocontrol;
use trivkins::Trivkins;

const PERIOD: i64 = 1_000_000;

thread_local! {
    static MOTION: RefCell<Option<MotionRef>> = const { RefCell::new(None) };
}

/// A task whose machine needs no homing.
struct Jobs;

impl Component for Jobs {
    const NAME: &'static str = "jobs";
    const DOC: &'static str = "A task without an INI file.";
    const FLAGS: u32 = component_flags::ONCE;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (motion, io) = (b.motion()?.unwrap(), b.iocontrol()?.unwrap());
        MOTION.with(|known| *known.borrow_mut() = Some(motion.clone()));
        let shared = Shared::default();
        let now = motion.clone();
        commands::open(b, &shared, move || now.epoch())?;
        let mut machine = Machine::read(&hal_job::Files::default()).unwrap();
        machine.tools = ToolTable::default();
        let rules = Rules {
            needs_homing: false,
            at_speed_timeout: 5.0,
            has_top_speed: [false; 8],
            change_position: None,
            safe_height: None,
            has_full_codes: false,
        };
        let core =
            Core::new(World { machine, hal: BTreeMap::new(), functions: None }, rules).unwrap();
        shared.lock().opened = Some((Box::new(core), Files { letters: 7, ..Files::default() }));
        let snapshot = b.snapshot("task.status", status::VERSION, "")?;
        let pins = Pins::make(b)?;
        let worker = Worker::new(shared, motion, io, None, b, pins, snapshot);
        b.worker("task", "Runs jobs.", PERIOD, 400, worker)
    }
}

pub(super) fn cycles(bench: &mut Bench, n: usize) {
    for _ in 0..n {
        bench.pass(PERIOD);
        let estop: bool = bench.get("iocontrol.0.user-enable-out");
        bench.set("iocontrol.0.emc-enable-in", estop);
        bench.run("iocontrol", PERIOD);
        bench.run("motion-command-handler", PERIOD);
        bench.run("motion-controller", PERIOD);
        for joint in 0..3 {
            let cmd: f64 = bench.get(&format!("joint.{joint}.motor-pos-cmd"));
            bench.set(&format!("joint.{joint}.motor-pos-fb"), cmd);
        }
        bench.work("motmod.planner", 64).unwrap();
        bench.work("task", 400).unwrap();
    }
}

/// A machine that is on, in this mode.
pub(super) fn on(mode: &str) -> Bench {
    let mut bench = Bench::new();
    bench.load::<Iocontrol>(&["cycle_time=0.01"]).unwrap();
    bench.load::<Trivkins>(&["coordinates=xyz"]).unwrap();
    bench.load::<Motmod>(&["num_joints=3"]).unwrap();
    for joint in ["joint=0", "joint=1", "joint=2"] {
        let args = [joint, "max-velocity=100", "max-acceleration=1000", "ferror=1", "min-ferror=1"];
        bench.command("motion.configure", &args).unwrap();
    }
    bench.load::<Jobs>(&[]).unwrap();
    let mode = format!("mode={mode}");
    let commands = [("task.estop-reset", &[][..]), ("task.on", &[]), ("task.mode", &[&*mode])];
    for (command, args) in commands {
        bench.command(command, args).unwrap();
        cycles(&mut bench, 20);
    }
    bench
}

#[test]
fn one_joint_homes_alone() {
    let mut bench = on("manual");
    bench.command("task.home", &["joint=1"]).unwrap();
    cycles(&mut bench, 500);
    let homed = bench.snapshot::<MotionStatus>("motion.status").joint_homed;
    assert_eq!(homed[..3], [false, true, false], "{:?}", bench.said());
}

#[test]
fn an_override_of_motion_is_that_of_the_task() {
    let mut bench = on("manual");
    let shown = |bench: &Bench| {
        let task = bench.snapshot::<status::TaskStatus>("task.status");
        let motion = bench.snapshot::<MotionStatus>("motion.status");
        assert_eq!(task.feed_override, motion.feed_override);
        assert_eq!(task.rapid_override, motion.rapid_override);
        assert_eq!(task.spindle_override[0], motion.spindle_override[0]);
        (task.feed_override, task.rapid_override, task.spindle_override[0])
    };
    bench.command("motion.feed", &["override=0.5", "rapid-override=0.25"]).unwrap();
    bench.command("motion.spindle", &["spindle=0", "override=0.75"]).unwrap();
    cycles(&mut bench, 10);
    assert_eq!(shown(&bench), (0.5, 0.25, 0.75));
    bench.command("task.feed-override", &["scale=0.7"]).unwrap();
    cycles(&mut bench, 10);
    assert_eq!(shown(&bench), (0.7, 0.25, 0.75));
    bench.command("task.rapid-override", &["scale=0.1"]).unwrap();
    cycles(&mut bench, 10);
    assert_eq!(shown(&bench), (0.7, 0.1, 0.75));
    let refused = bench.command("task.rapid-override", &["scale=1.5"]).unwrap_err().to_string();
    assert!(refused.contains("1.5") && refused.contains("0 to 1"), "{refused}");
}

#[test]
fn a_new_token_is_claimed_again() {
    let mut bench = on("mdi");
    let line = |bench: &mut Bench, text: &str| {
        bench.command("task.mdi", &[text]).unwrap();
        cycles(bench, 5);
    };
    let claimed = |bench: &Bench| bench.snapshot::<MotionStatus>("motion.status").claimed;
    line(&mut bench, "text=G4 P1");
    assert!(claimed(&bench));
    // Another one of this name takes motion, and the claim ends.
    let motion = MOTION.with(|known| known.borrow_mut().take()).unwrap();
    let other = motion.acquire("task").unwrap();
    cycles(&mut bench, 5);
    assert!(!claimed(&bench) && motion.claim(other, false));
    // The next order finds the token void. The job goes on, so the claim is due again.
    bench.command("task.feed-override", &["scale=0.5"]).unwrap();
    cycles(&mut bench, 5);
    assert!(claimed(&bench));
    cycles(&mut bench, 1100);
    assert!(!claimed(&bench), "the job has ended");
}

#[test]
fn a_job_shows_on_its_pin_also_in_a_pause_and_ends_by_one() {
    let mut bench = on("mdi");
    let job = |bench: &Bench| bench.get::<bool>("task.job");
    assert!(!job(&bench));
    bench.command("task.mdi", &["text=M0"]).unwrap();
    cycles(&mut bench, 50);
    let interpreter = bench.snapshot::<status::TaskStatus>("task.status").interpreter;
    assert!(job(&bench) && interpreter == 2, "{interpreter}");
    bench.set("task.abort", true);
    cycles(&mut bench, 50);
    assert!(!job(&bench), "{:?}", bench.said());
    // Only the edge counts.
    bench.command("task.mdi", &["text=G4 P1"]).unwrap();
    cycles(&mut bench, 50);
    assert!(job(&bench));
}
