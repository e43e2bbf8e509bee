//! A spindle that the program has turned is stopped: by whom, at which moment of the job, and what goes on by which command.

use super::real::{cycles, on};
use crate::status::TaskStatus;
use hal_bench::Bench;
use hal_component::{MotionStatus, Wait};

/// Ways to stop the spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// `motion.spindle speed=0`, as halui and the panel send it.
    Hand,
    /// `motion.spindle-orient` by hand.
    Orient,
    /// `spindle.0.inhibit`, which stays TRUE until the resume.
    Inhibit,
    /// `spindle.0.inhibit` for a moment.
    Pulse,
    /// An override of 0, which is raised before the resume.
    Override,
    /// `spindle.0.amp-fault-in`.
    Fault,
}

const WAYS: [Way; 6] =
    [Way::Hand, Way::Orient, Way::Inhibit, Way::Pulse, Way::Override, Way::Fault];

/// Moments of the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    /// A feed is in progress.
    Feed,
    /// A feed is paused.
    Paused,
    /// The job waits at M0.
    Wait,
    /// A rapid move is in progress before the feed.
    Rapid,
}

const MOMENTS: [Moment; 4] = [Moment::Feed, Moment::Paused, Moment::Wait, Moment::Rapid];

/// Commands that go on.
const COMMANDS: [&str; 3] = ["task.resume", "task.step", "motion.resume"];

fn status(bench: &Bench) -> (TaskStatus, MotionStatus) {
    (bench.snapshot("task.status"), bench.snapshot("motion.status"))
}

fn x(bench: &Bench) -> f64 {
    bench.get("joint.0.motor-pos-cmd")
}

/// Begins a program and runs it to a moment, with the spindle at its speed.
fn at(moment: Moment) -> Bench {
    let before = match moment {
        Moment::Feed | Moment::Paused => "",
        Moment::Wait => "M0\n",
        Moment::Rapid => "G0 Y50\n",
    };
    let name = format!("hal-stopped-spindle-{}-{moment:?}.ngc", std::process::id());
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, format!("G21 G90 G61\nM3 S500\n{before}G1 X50 F1000\nG1 X60\nM5\nM2\n"))
        .unwrap();
    let mut bench = on("auto");
    bench.command("task.open", &[&format!("file={}", path.display())]).unwrap();
    cycles(&mut bench, 10);
    bench.command("task.run", &[]).unwrap();
    for _ in 0..200 {
        cycles(&mut bench, 10);
        let (task, motion) = status(&bench);
        let is_there = match moment {
            Moment::Feed | Moment::Paused => x(&bench) > 5.0,
            Moment::Wait => task.wait == Wait::Stop as u32,
            Moment::Rapid => motion.pose[1] > 5.0,
        };
        if is_there {
            assert!(bench.get::<bool>("spindle.0.on"), "{moment:?}");
            if moment == Moment::Paused {
                bench.command("task.pause", &[]).unwrap();
                cycles(&mut bench, 300);
            }
            std::fs::remove_file(&path).unwrap();
            return bench;
        }
    }
    panic!("{moment:?} is not reached: {:?}", bench.said());
}

fn stop(bench: &mut Bench, way: Way) {
    match way {
        Way::Hand => drop(bench.command("motion.spindle", &["speed=0"]).unwrap()),
        Way::Orient => drop(bench.command("motion.spindle-orient", &["angle=90"]).unwrap()),
        Way::Inhibit | Way::Pulse => bench.set("spindle.0.inhibit", true),
        Way::Override => drop(bench.command("motion.spindle", &["override=0"]).unwrap()),
        Way::Fault => bench.set("spindle.0.amp-fault-in", true),
    }
    cycles(bench, 20);
    match way {
        Way::Pulse => bench.set("spindle.0.inhibit", false),
        Way::Fault => bench.set("spindle.0.amp-fault-in", false),
        _ => {}
    }
}

#[test]
fn no_feed_runs_on_a_spindle_that_was_stopped() {
    let mut cells = 0;
    for (way, moment) in WAYS.into_iter().flat_map(|w| MOMENTS.map(|m| (w, m))) {
        for command in COMMANDS {
            let name = format!("{way:?} at {moment:?}, {command}");
            cells += 1;
            let mut bench = at(moment);
            stop(&mut bench, way);
            if way == Way::Orient && matches!(moment, Moment::Feed | Moment::Rapid) {
                let why = bench.failure().unwrap_or_default();
                assert!(why.contains("a program is in progress"), "{name}: {why}");
                assert!(bench.get::<bool>("spindle.0.on"), "{name}");
                continue;
            }
            // A feed brakes; a rapid move ends.
            cycles(&mut bench, 1500);
            let rests = x(&bench);
            cycles(&mut bench, 500);
            assert_eq!(x(&bench), rests, "{name}: moves on");
            assert!(!bench.get::<bool>("spindle.0.on") || way == Way::Override, "{name}");
            let (task, motion) = status(&bench);
            if way == Way::Fault {
                assert!(!motion.enabled && task.interpreter == 0, "{name}");
                bench.command(command, &[]).unwrap();
                cycles(&mut bench, 300);
                assert_eq!(
                    (x(&bench), bench.get::<bool>("spindle.0.on")),
                    (rests, false),
                    "{name}"
                );
                continue;
            }
            match moment {
                Moment::Feed => assert!(5.0 < rests && rests < 9.0, "{name}: {rests}"),
                Moment::Paused => assert!(rests < 9.0, "{name}: {rests}"),
                Moment::Wait => assert_eq!(rests, 0.0, "{name}"),
                // Within the tolerance of G61.
                Moment::Rapid => assert!(rests < 0.01, "{name}: {rests}"),
            }
            let kind = if moment == Moment::Wait { Wait::Stop } else { Wait::SpindleStopped };
            assert_eq!((Wait::of(task.wait), task.interpreter), (kind, 2), "{name}");
            assert_eq!(motion.spindles_stopped, 1, "{name}");
            if way == Way::Inhibit {
                bench.command(command, &[]).unwrap();
                cycles(&mut bench, 300);
                // At M0 motion has nothing to resume.
                let is_idle = (command, moment) == ("motion.resume", Moment::Wait);
                let why = bench.failure();
                let is_named = why.as_ref().is_some_and(|why| why.contains("inhibit is TRUE"));
                assert!(is_named || is_idle, "{name}: {why:?}");
                assert_eq!(x(&bench), rests, "{name}: moves although it was refused");
                bench.set("spindle.0.inhibit", false);
                cycles(&mut bench, 300);
                assert_eq!(x(&bench), rests, "{name}: the end of inhibit resumes");
                assert!(!bench.get::<bool>("spindle.0.on"), "{name}: the end of inhibit turns it");
            }
            if way == Way::Override {
                bench.command("motion.spindle", &["override=1"]).unwrap();
                cycles(&mut bench, 300);
                assert_eq!(x(&bench), rests, "{name}: the override resumes");
            }
            bench.set("spindle.0.at-speed", false);
            bench.command(command, &[]).unwrap();
            if command == "motion.resume" && moment == Moment::Wait {
                // It ends no wait of the task.
                cycles(&mut bench, 100);
                assert_eq!(x(&bench), rests, "{name}");
                bench.command("task.resume", &[]).unwrap();
            }
            cycles(&mut bench, 300);
            assert!(bench.get::<bool>("spindle.0.on"), "{name}: {:?}", bench.said());
            assert_eq!(bench.get::<f64>("spindle.0.speed-out"), 500.0, "{name}");
            assert_eq!(x(&bench), rests, "{name}: it does not wait for the speed");
            assert_eq!(status(&bench).1.wait, Wait::AtSpeed as u32, "{name}");
            bench.set("spindle.0.at-speed", true);
            cycles(&mut bench, 4000);
            // A step rests behind its move, which may be the rapid one.
            let least = if command == "task.step" && moment == Moment::Rapid { 0.0 } else { 49.9 };
            assert!(
                (least..=60.0).contains(&x(&bench)),
                "{name}: {}, {:?}",
                x(&bench),
                bench.said()
            );
        }
    }
    assert_eq!(cells, 72);
}

#[test]
fn after_the_programs_own_m5_nothing_is_waited_for() {
    let mut bench = on("mdi");
    bench.set("spindle.0.at-speed", true);
    for line in ["text=M3 S500", "text=M5", "text=G1 X5 F6000"] {
        bench.command("task.mdi", &[line]).unwrap();
        cycles(&mut bench, 50);
        bench.set("spindle.0.at-speed", false);
    }
    cycles(&mut bench, 500);
    assert_eq!(x(&bench), 5.0);
    let (task, motion) = status(&bench);
    assert_eq!((task.wait, motion.spindles_stopped), (0, 0));
}

#[test]
fn the_program_itself_does_not_turn_a_spindle_that_was_stopped() {
    let mut bench = at(Moment::Rapid);
    stop(&mut bench, Way::Hand);
    assert!(!bench.get::<bool>("spindle.0.on"));
    // A rapid move goes on to its end.
    cycles(&mut bench, 1500);
    assert!((49.9..=50.0).contains(&status(&bench).1.pose[1]));
    bench.command("task.abort", &[]).unwrap();
    cycles(&mut bench, 100);
    assert_eq!(status(&bench).1.spindles_stopped, 0, "an abort ends all commands");
}

#[test]
fn a_new_order_turns_a_spindle_that_was_stopped() {
    let mut bench = on("mdi");
    let mdi = |bench: &mut Bench, line: &str| {
        bench.command("task.mdi", &[&format!("text={line}")]).unwrap();
        cycles(bench, 100);
    };
    mdi(&mut bench, "M3 S500");
    stop(&mut bench, Way::Hand);
    // A feed of MDI waits for a resume; the line M3 turns the spindle.
    mdi(&mut bench, "M3 S600");
    assert_eq!(bench.get::<f64>("spindle.0.speed-out"), 600.0, "{:?}", bench.said());
    stop(&mut bench, Way::Hand);
    mdi(&mut bench, "G1 X5 F6000");
    assert_eq!((x(&bench), Wait::of(status(&bench).0.wait)), (0.0, Wait::SpindleStopped));
    bench.command("task.abort", &[]).unwrap();
    cycles(&mut bench, 200);
    mdi(&mut bench, "M3 S500");
    stop(&mut bench, Way::Pulse);
    assert_eq!(status(&bench).1.spindles_stopped, 1);
    // A program begins as if it had not been turned.
    let path = std::env::temp_dir().join(format!("hal-new-order-{}.ngc", std::process::id()));
    std::fs::write(&path, "G21 G90\nG1 X5 F6000\nM3 S700\nG1 X10\nM2\n").unwrap();
    bench.command("task.mode", &["mode=auto"]).unwrap();
    bench.command("task.open", &[&format!("file={}", path.display())]).unwrap();
    cycles(&mut bench, 20);
    bench.command("task.run", &[]).unwrap();
    cycles(&mut bench, 1000);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(x(&bench), 10.0, "{:?}", bench.said());
}
