//! The service `motion`: its commands beside the text commands, its owner, and several sources of motion.

use super::{PERIOD, Rig};
use hal_bench::{Bench, Random};
use hal_component::{
    MotionCommand, MotionEnd, MotionId, MotionRef, MotionRefusal, MotionStatus, MotionToken,
    abi::TicketState, motion_flags as flags, motion_kind as kind, motion_setting, motion_source,
};
use trivkins::Trivkins;

fn new(kind: u32) -> MotionCommand {
    MotionCommand::new(kind)
}

/// Returns a move of x and y at a velocity.
fn line(x: f64, y: f64, speed: f64) -> MotionCommand {
    let mut pose = [0.0; 9];
    (pose[0], pose[1]) = (x, y);
    MotionCommand { letters: 3, pose, speed_kind: 2, speed, ..new(kind::MOVE) }
}

fn jog(joint: u32, speed: f64) -> MotionCommand {
    MotionCommand { index: joint, flags: flags::JOINT, speed, ..new(kind::JOG) }
}

fn setting(name: &str, value: f64) -> MotionCommand {
    let setting = motion_setting::NAMES.iter().position(|n| *n == name).unwrap();
    MotionCommand { setting: u32::try_from(setting).unwrap(), value, ..new(kind::CONFIGURE) }
}

/// Waits for the end of a command.
fn end(rig: &mut Rig, motion: &MotionRef, id: MotionId) -> MotionEnd {
    for _ in 0..200_000 {
        match motion.poll(id) {
            MotionEnd::Pending => rig.cycle(),
            end => return end,
        }
    }
    panic!("never ends")
}

/// A text command, the same as a record, and the number of cycles after it.
type Row = (&'static str, MotionCommand, usize);

/// Commands that are executed in order.
fn rows() -> Vec<Row> {
    let spindle = MotionCommand { flags: flags::HAS_SPEED, speed: 500.0, ..new(kind::SPINDLE) };
    let feed = MotionCommand { flags: flags::HAS_SCALE, scale: 0.5, ..new(kind::FEED) };
    let arc = MotionCommand {
        flags: flags::CLOCKWISE | flags::CENTER_X,
        center: [5.0, 0.0, 0.0],
        count: 1,
        ..MotionCommand { kind: kind::ARC, ..line(5.0, 5.0, 20.0) }
    };
    let blend = MotionCommand { mode: 2, tolerance: 0.1, line: 7, ..line(3.0, 1.0, 15.0) };
    let offset = MotionCommand { letters: 4, ..new(kind::TOOL_OFFSET) };
    let offset = MotionCommand { pose: [0.0, 0.0, 2.5, 0., 0., 0., 0., 0., 0.], ..offset };
    vec![
        ("motion.disable", new(kind::DISABLE), 2),
        ("motion.enable", new(kind::ENABLE), 5),
        ("motion.unhome joint=1", MotionCommand { index: 1, ..new(kind::UNHOME) }, 3),
        ("motion.home joint=all", MotionCommand { flags: flags::ALL, ..new(kind::HOME) }, 40),
        ("motion.jog joint=0 velocity=10", jog(0, 10.0), 60),
        (
            "motion.jog-stop joint=0",
            MotionCommand { flags: flags::JOINT, ..new(kind::JOG_STOP) },
            100,
        ),
        ("motion.mode mode=teleop", MotionCommand { mode: 1, ..new(kind::MODE) }, 5),
        (
            "motion.jog axis=y velocity=20 distance=-3",
            MotionCommand { index: 1, flags: flags::AXIS, extent: 1, value: -3.0, ..jog(1, 20.0) },
            300,
        ),
        (
            "motion.jog axis=z velocity=2 position=1",
            MotionCommand { index: 2, flags: flags::AXIS, extent: 2, value: 1.0, ..jog(2, 2.0) },
            30,
        ),
        ("motion.jog-stop", new(kind::JOG_STOP), 200),
        ("motion.spindle speed=500", spindle, 5),
        (
            "motion.spindle brake=FALSE override=0.8",
            {
                let flags = flags::HAS_BRAKE | flags::HAS_SCALE;
                MotionCommand { flags, scale: 0.8, ..new(kind::SPINDLE) }
            },
            5,
        ),
        (
            "motion.feed override=0.5 rapid-override=0.25 adaptive=FALSE hold=TRUE",
            {
                let more = flags::HAS_RAPID | flags::HAS_ADAPTIVE | flags::HAS_HOLD | flags::HOLD;
                MotionCommand { flags: feed.flags | more, value: 0.25, ..feed }
            },
            1,
        ),
        ("motion.move x=8 y=-4 velocity=30", line(8.0, -4.0, 30.0), 100),
        ("motion.pause", new(kind::PAUSE), 150),
        ("motion.reverse", new(kind::REVERSE), 2),
        ("motion.resume", new(kind::RESUME), 60),
        ("motion.forward", new(kind::FORWARD), 40),
        ("motion.move x=3 y=1 velocity=15 mode=blend tolerance=0.1 line=7", blend, 50),
        (
            "motion.digital-out index=1 value=TRUE sync=TRUE",
            {
                MotionCommand { index: 1, flags: flags::ON | flags::SYNC, ..new(kind::DIGITAL_OUT) }
            },
            3,
        ),
        (
            "motion.analog-out index=2 value=1.5",
            { MotionCommand { index: 2, value: 1.5, ..new(kind::ANALOG_OUT) } },
            3,
        ),
        ("motion.tool-offset z=2.5", offset, 5),
        ("motion.pause", new(kind::PAUSE), 200),
        ("motion.step", new(kind::STEP), 900),
        ("motion.resume", new(kind::RESUME), 600),
        ("motion.arc x=5 y=5 velocity=20 center-x=5 clockwise=TRUE turns=1", arc, 1500),
        ("motion.move x=0 y=0 rapid=TRUE", MotionCommand { speed_kind: 1, ..line(0., 0., 0.) }, 30),
        ("motion.abort", new(kind::ABORT), 300),
        (
            "motion.move x=1 y=1 time=0.5 acceleration=500",
            { MotionCommand { speed_kind: 3, acceleration: 500.0, ..line(1.0, 1.0, 0.5) } },
            900,
        ),
        (
            "motion.probe x=2 y=2 velocity=5 optional=TRUE",
            { MotionCommand { kind: kind::PROBE, flags: flags::OPTIONAL, ..line(2.0, 2.0, 5.0) } },
            900,
        ),
        (
            "motion.spindle-orient angle=90 mode=1",
            { MotionCommand { value: 90.0, mode: 1, ..new(kind::ORIENT) } },
            5,
        ),
        ("motion.override-limits", new(kind::OVERRIDE_LIMITS), 3),
        (
            "motion.configure joint=0 max-velocity=12",
            { MotionCommand { flags: flags::JOINT, ..setting("max-velocity", 12.0) } },
            3,
        ),
        (
            "motion.configure axis=y max-limit=3.5",
            { MotionCommand { index: 1, flags: flags::AXIS, ..setting("max-limit", 3.5) } },
            3,
        ),
        (
            "motion.configure spindle=0 max-forward-velocity=300",
            { MotionCommand { flags: flags::SPINDLE, ..setting("max-forward-velocity", 300.0) } },
            3,
        ),
        ("motion.configure max-feed-override=1.2", setting("max-feed-override", 1.2), 3),
        (
            "motion.configure joint=2 home-sequence=-4",
            { MotionCommand { index: 2, flags: flags::JOINT, ..setting("home-sequence", -4.0) } },
            3,
        ),
        ("motion.spindle speed=900", MotionCommand { speed: 900.0, ..spindle }, 20),
        ("motion.move x=-5 y=9 velocity=80", line(-5.0, 9.0, 80.0), 400),
        ("motion.move x=-5 y=3 velocity=80", line(-5.0, 3.0, 80.0), 900),
        (
            "motion.move x=-9 y=2 per-turn=3",
            { MotionCommand { pitch: 3.0, flags: flags::VELOCITY_MODE, ..line(-9.0, 2.0, 0.0) } },
            50,
        ),
        ("motion.move x=4 y=3 pitch=2", MotionCommand { pitch: 2.0, ..line(4.0, 3.0, 7.0) }, 50),
        ("motion.abort", new(kind::ABORT), 300),
        ("motion.spindle speed=900", MotionCommand { speed: 900.0, ..spindle }, 20),
        (
            "motion.tap x=4 y=3 pitch=2 return=0.5",
            {
                MotionCommand {
                    kind: kind::TAP,
                    pitch: -2.0,
                    flags: flags::HAS_SCALE,
                    scale: 0.5,
                    ..line(4.0, 3.0, 0.0)
                }
            },
            50,
        ),
    ]
}

/// Every command by the service does the same as by text, in each cycle, and ends alike.
#[test]
fn each_command_equals_its_text() {
    let (mut by_text, mut by_record) = (Rig::homed(&[]), Rig::homed(&[]));
    let motion: MotionRef = by_record.bench.find();
    let mut ends = Vec::new();
    let mut moved = 0;
    for (text, record, cycles) in rows() {
        let before = by_text.bench.tickets().len();
        let said = by_text.try_say(text).map(|_| ());
        let pushed = motion.push(MotionToken::LOCAL, &record);
        match (&said, &pushed) {
            (Ok(()), Ok(id)) if by_text.bench.tickets().len() > before => {
                ends.push((text, before, *id));
            }
            (Ok(()), Ok(_)) => {}
            (Err(a), Err(MotionRefusal::Refused(b))) => assert_eq!(a, b, "{text}"),
            _ => panic!("{text}: {said:?}, {pushed:?}"),
        }
        for n in 0..cycles {
            by_text.cycle();
            by_record.cycle();
            let a: MotionStatus = by_text.bench.snapshot("motion.status");
            let b = motion.status().unwrap();
            assert_eq!(a, b, "{text}, cycle {n}");
            moved += u32::from(a.velocity > 0.0);
        }
        for pin in ["spindle.0.speed-out", "motion.analog-out-02", "motion.tooloffset.z"] {
            assert_eq!(by_text.float(pin), by_record.float(pin), "{text}: {pin}");
        }
    }
    for (text, ticket, id) in ends {
        match (by_text.bench.tickets()[ticket], motion.poll(id)) {
            (TicketState::Done, MotionEnd::Done)
            | (TicketState::Pending, MotionEnd::Pending)
            | (TicketState::Failed(_), MotionEnd::Failed(_)) => {}
            (a, b) => panic!("{text}: {a:?}, {b:?}"),
        }
    }
    assert!(moved > 2000, "{moved} cycles with motion");
}

/// The table of the test has every kind for which motmod has a text command.
#[test]
fn no_kind_is_left_out() {
    let rig = Rig::off(&[]);
    for (n, name) in kind::NAMES.iter().enumerate().skip(1) {
        let exists = rig.bench.commands().contains(&format!("motion.{name}"));
        let is_tested = rows().iter().any(|(_, c, _)| c.kind as usize == n);
        assert_eq!(exists, is_tested, "motion.{name}");
    }
}

#[test]
fn refusals_are_those_of_the_text() {
    let mut rig = Rig::off(&["coordinates=xyz"]);
    let motion: MotionRef = rig.bench.find();
    let joint = |c: MotionCommand| MotionCommand { flags: flags::JOINT, ..c };
    let by_axis = |n| MotionCommand { index: n, flags: flags::AXIS, ..jog(0, 1.0) };
    for (record, why) in [
        (new(0), "there is no command of kind 0"),
        (new(99), "there is no command of kind 99"),
        (new(u32::MAX), "there is no command of kind 4294967295"),
        (MotionCommand { flags: 1 << 31, ..new(1) }, "there is no flag in 2147483648"),
        (MotionCommand { letters: 512, ..line(0., 0., 1.) }, "there is no letter in 512"),
        (MotionCommand { speed_kind: 4, ..line(0., 0., 1.) }, "there is no kind of speed 4"),
        (MotionCommand { extent: 3, ..jog(0, 1.0) }, "there is no extent of a jog 3"),
        (MotionCommand { setting: 77, ..new(kind::CONFIGURE) }, "there is no setting 77"),
        (joint(MotionCommand { index: 3, ..jog(3, 1.0) }), "there is no joint 3, they are 0 to 2"),
        (by_axis(3), "axis a has no joint in these kinematics"),
        (by_axis(9), "axis '9' is none of x y z a b c u v w"),
        (jog(0, f64::NAN), "velocity is NaN, must be a finite number"),
        (jog(0, 0.0), "velocity is 0, a jog needs one"),
        (MotionCommand { flags: 0, ..jog(0, 1.0) }, "joint= or axis= is missing"),
        (
            MotionCommand { flags: flags::JOINT | flags::AXIS, ..jog(0, 1.0) },
            "joint= and axis= exclude each other",
        ),
        (line(f64::INFINITY, 0.0, 1.0), "x is inf, must be a finite number"),
        (line(0.0, f64::NAN, 1.0), "y is NaN, must be a finite number"),
        (line(0.0, 0.0, -1.0), "velocity is -1, must be above 0"),
        (
            MotionCommand { kind: kind::TAP, ..line(0.0, 0.0, 0.0) },
            "velocity is 0, must be above 0",
        ),
        (
            MotionCommand { kind: kind::TAP, speed_kind: 0, ..line(0.0, 0.0, 0.0) },
            "pitch= is missing",
        ),
        (
            MotionCommand { letters: 0, ..line(0.0, 0.0, 1.0) },
            "a move needs at least one of x= y= z= a= b= c= u= v= w=",
        ),
        (
            MotionCommand { mode: 3, ..line(0., 0., 1.) },
            "mode '3' is none of stop, exact and blend",
        ),
        (
            MotionCommand { mode: 2, tolerance: f64::NAN, ..line(0.0, 0.0, 1.0) },
            "tolerance is NaN, must be a finite number",
        ),
        (
            MotionCommand { acceleration: f64::NAN, ..line(0.0, 0.0, 1.0) },
            "acceleration is NaN, must be a finite number",
        ),
        (
            MotionCommand { mode: 9, ..new(kind::MODE) },
            "mode '9' is none of free, teleop and coord",
        ),
        (
            MotionCommand { index: 64, ..new(kind::DIGITAL_OUT) },
            "there is no index 64, there are 4 outputs",
        ),
        (MotionCommand { index: 7, ..new(kind::ORIENT) }, "there is no spindle 7, there are 1"),
        (joint(setting("max-velocity", -1.0)), "max-velocity is -1, must be above 0"),
        (joint(setting("min-limit", f64::NAN)), "min-limit is NaN, must be a number"),
        (joint(setting("default-velocity", 1.0)), "default-velocity= does not belong to joint="),
        (
            joint(setting("home-sequence", 0.5)),
            "home-sequence is 9223372036854775807, must be -1000 to 1000",
        ),
    ] {
        let refused = motion.push(MotionToken::LOCAL, &record);
        assert_eq!(refused, Err(MotionRefusal::Refused(why.to_owned())), "{record:?}");
    }
}

const PROGRAM: &str = "a program is in progress: motion.abort ends it";

/// Every setting reads as it was given, and not for an object that lacks it.
#[test]
fn settings_read_as_given() {
    let mut rig = Rig::off(&[]);
    let motion: MotionRef = rig.bench.find();
    let of = |flags, name: &str, value| MotionCommand { flags, ..setting(name, value) };
    let (mut joint, mut axis, mut spindle, mut traj) = (0, 0, 0, 0);
    for (n, name) in motion_setting::NAMES.iter().enumerate() {
        let value = if name.starts_with("max") { 0.75 } else { 0.25 } + n as f64 / 128.0;
        let value = if *name == "home-sequence" { 3.0 } else { value };
        for (flag, count) in [
            (flags::JOINT, &mut joint),
            (flags::AXIS, &mut axis),
            (flags::SPINDLE, &mut spindle),
            (0, &mut traj),
        ] {
            if *name == "max-jerk" {
                // No limit reads as it is given.
                let none = motion.setting(&of(flag, name, 0.0));
                assert!(none.is_none_or(|jerk| jerk == 0.0), "{none:?} with {flag}");
            }
            let command = of(flag, name, value);
            let accepted = motion.push(MotionToken::LOCAL, &command).is_ok();
            rig.cycle();
            let read = motion.setting(&of(flag, name, 0.0));
            assert_eq!(read, accepted.then_some(value), "{name} with {flag}");
            *count += usize::from(accepted);
        }
    }
    assert_eq!((joint, axis, spindle, traj), (11, 6, 4, 5));
    let missing = MotionCommand { index: 3, ..of(flags::JOINT, "ferror", 0.0) };
    assert_eq!(motion.setting(&missing), None);
}

/// Two sources never move at once.
#[test]
fn one_source_moves_at_a_time() {
    let mut rig = Rig::homed(&[]);
    let motion: MotionRef = rig.bench.find();
    let task = motion.acquire("task").unwrap();
    let remote = |c: MotionCommand| MotionCommand { source: motion_source::REMOTE, ..c };
    // A program: local motion is refused, pause and resume are not.
    let id = motion.push(task, &line(30.0, 0.0, 30.0)).unwrap();
    rig.cycles(100);
    for text in ["motion.jog joint=1 velocity=1", "motion.move y=3", "motion.home joint=0"] {
        assert_eq!(rig.failed(text), PROGRAM, "{text}");
    }
    let moves = motion.push(task, &remote(jog(1, 1.0))).unwrap();
    assert_eq!(end(&mut rig, &motion, moves), MotionEnd::Failed(PROGRAM.to_owned()));
    rig.done("motion.pause");
    rig.cycles(300);
    // The paused path rests: axes jog, from one source at a time.
    rig.done("motion.jog axis=y velocity=5");
    rig.cycles(20);
    let other = motion.push(task, &remote(MotionCommand { flags: flags::AXIS, ..jog(0, 1.0) }));
    let MotionEnd::Failed(why) = end(&mut rig, &motion, other.unwrap()) else { panic!() };
    assert_eq!(why, "a local source moves the machine: motion.abort ends that");
    rig.done("motion.jog-stop axis=y");
    rig.done("motion.resume");
    assert_eq!(end(&mut rig, &motion, id), MotionEnd::Done);
    assert_eq!(rig.places()[..2], [30.0, 0.0]);

    // A claim holds between two moves, where nothing moves. An abort ends it.
    assert!(motion.claim(task, true));
    for text in ["motion.jog joint=1 velocity=1", "motion.mode mode=free", "motion.spindle speed=1"]
    {
        assert_eq!(rig.failed(text), PROGRAM, "{text}");
    }
    rig.done("motion.spindle override=0.9");
    assert!(motion.status().unwrap().claimed);
    rig.done("motion.abort");
    assert!(!motion.status().unwrap().claimed);
    rig.done("motion.jog joint=1 velocity=5");
    rig.cycles(30);

    // A local jog: the program is refused.
    let refused = motion.push(task, &line(0.0, 0.0, 10.0)).unwrap();
    let local = "a local source moves the machine: motion.abort ends that";
    assert_eq!(end(&mut rig, &motion, refused), MotionEnd::Failed(local.to_owned()));
    rig.done("motion.jog-stop");
    rig.done("motion.jog-stop");

    // A remote jog: a local command ends it, and is accepted at rest.
    motion.push(task, &remote(jog(1, 5.0))).unwrap();
    rig.cycles(50);
    assert_eq!(motion.status().unwrap().source, motion_source::REMOTE);
    assert_eq!(
        rig.failed("motion.jog joint=0 velocity=1"),
        "remote motion was ended: give the command again when the machine is at rest"
    );
    rig.cycles(100);
    assert!(rig.is("motion.in-position"));
    rig.done("motion.jog joint=0 velocity=1");
    rig.cycles(10);
    rig.done("motion.jog-stop");
    // A jog wheel too.
    rig.bench.set("joint.0.jog-enable", true);
    rig.bench.set("joint.0.jog-scale", 0.1);
    motion.push(task, &remote(jog(1, 5.0))).unwrap();
    rig.cycles(50);
    let at = rig.places()[0];
    rig.bench.set("joint.0.jog-counts", 5_i32);
    rig.cycles(200);
    assert!(rig.is("motion.in-position"));
    assert_eq!(rig.places()[0], at, "the counts that ended it move nothing");
    rig.bench.set("joint.0.jog-counts", 10_i32);
    rig.cycles(300);
    assert!((rig.places()[0] - at - 0.5).abs() < 1e-6);
    assert_eq!(motion.status().unwrap().source, motion_source::LOCAL);
}

/// A remote path in a pause ends when a local source moves, except for jogs beside it.
#[test]
fn a_local_move_ends_a_remote_path_that_is_paused() {
    let mut rig = Rig::homed(&[]);
    let motion: MotionRef = rig.bench.find();
    let task = motion.acquire("task").unwrap();
    let remote = MotionCommand { source: motion_source::REMOTE, ..line(30.0, 0.0, 30.0) };
    let id = motion.push(task, &remote).unwrap();
    rig.cycles(100);
    rig.done("motion.pause");
    rig.cycles(300);
    rig.done("motion.jog axis=y velocity=5 distance=1");
    rig.cycles(500);
    assert_eq!(motion.poll(id), MotionEnd::Pending, "a jog leaves the path");
    let at = rig.places();
    assert_eq!(
        rig.failed("motion.move y=3"),
        "remote motion was ended: give the command again when the machine is at rest"
    );
    let taken = "a local source ended remote motion";
    assert_eq!(end(&mut rig, &motion, id), MotionEnd::Failed(taken.to_owned()));
    assert_eq!(rig.places(), at, "nothing has moved");
    rig.done("motion.mode mode=coord");
    rig.done("motion.move y=3");
    assert_eq!(rig.places()[1], 3.0);
}

/// A queue that is full refuses moves, but an abort has room.
#[test]
fn a_full_queue_refuses_moves_and_accepts_an_abort() {
    let mut rig = Rig::homed(&[]);
    let motion: MotionRef = rig.bench.find();
    let task = motion.acquire("task").unwrap();
    let (mut x, mut ids) = (0.0, Vec::new());
    let mut refused = 0;
    while refused < 100 {
        x += 1e-3;
        match motion.push(task, &line(x, 0.0, 0.01)) {
            Ok(id) => {
                ids.push(id);
                refused = 0;
            }
            Err(MotionRefusal::Full) => {
                refused += 1;
                rig.cycle();
            }
            Err(why) => panic!("{why:?}"),
        }
        assert!(motion.room() <= 2000);
    }
    assert!(ids.len() > 1800, "{} moves wait", ids.len());
    assert_eq!(motion.room(), 0);
    let depth = motion.status().unwrap().queue;
    assert!(1800 < depth && depth <= 2000, "{depth}");
    let failed = ids.iter().filter(|id| matches!(motion.poll(**id), MotionEnd::Failed(_))).count();
    assert_eq!(failed, 0, "no accepted move is refused later");
    let abort = motion.push(MotionToken::LOCAL, &new(kind::ABORT)).unwrap();
    assert_eq!(end(&mut rig, &motion, abort), MotionEnd::Done);
    assert!(ids.iter().all(|id| motion.poll(*id) != MotionEnd::Pending));
    assert!(motion.room() > 200);
    let next = motion.push(task, &line(1.0, 0.0, 10.0)).unwrap();
    assert_eq!(end(&mut rig, &motion, next), MotionEnd::Done);
}

/// Without a running thread nothing takes commands: the queue says that it is full, at once.
#[test]
fn commands_that_nobody_takes_are_refused() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    let mut rig = Rig::with(bench);
    let motion: MotionRef = rig.bench.find();
    assert_eq!(motion.status(), None, "no cycle has run");
    let mut sent = 0;
    while motion.push(MotionToken::LOCAL, &new(kind::PAUSE)).is_ok() {
        sent += 1;
    }
    assert!(200 < sent && sent <= 256, "{sent}");
    assert_eq!(motion.push(MotionToken::LOCAL, &new(kind::PAUSE)), Err(MotionRefusal::Full));
    rig.bench.run("motion-command-handler", PERIOD);
    assert!(motion.push(MotionToken::LOCAL, &new(kind::PAUSE)).is_ok());
}

/// Returns a record of random codes and numbers.
fn garbage(random: &mut Random) -> MotionCommand {
    const ODD: [f64; 9] =
        [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 1e308, -1e-308, 3.0, -50.0];
    fn below(random: &mut Random, n: u64) -> u32 {
        u32::try_from(random.below(n)).unwrap()
    }
    fn number(random: &mut Random) -> f64 {
        if random.below(3) == 0 { random.pick(&ODD) } else { random.between(-10.0, 10.0) }
    }
    let mut c = new(below(random, 30));
    c.source = below(random, 4);
    let bits = random.pick(&[1 << 32, 1 << 22, 1 << 22, 1 << 22]);
    c.flags = below(random, bits);
    c.letters = below(random, 600);
    c.pose = [0.0; 9].map(|_| number(random));
    c.center = [0.0; 3].map(|_| number(random));
    c.normal = [0.0; 3].map(|_| number(random));
    for field in [&mut c.index, &mut c.mode, &mut c.speed_kind, &mut c.extent, &mut c.count] {
        *field = match random.below(8) {
            0 => u32::MAX,
            1 => 1 << random.below(32),
            _ => below(random, 5),
        };
    }
    c.setting = below(random, 20);
    for field in [
        &mut c.speed,
        &mut c.acceleration,
        &mut c.tolerance,
        &mut c.scale,
        &mut c.value,
        &mut c.pitch,
    ] {
        *field = number(random);
    }
    c
}

/// Records of random numbers neither panic nor make a position NaN or infinite.
#[test]
fn garbage_moves_nothing_wrongly() {
    let mut rig = Rig::homed(&[]);
    rig.strict = false;
    let motion: MotionRef = rig.bench.find();
    let task = motion.acquire("task").unwrap();
    let mut random = Random::new(7);
    let (mut accepted, mut refused) = (0, 0);
    for n in 0..20_000 {
        let c = garbage(&mut random);
        match motion.push(task, &c) {
            Ok(_) => accepted += 1,
            Err(_) => refused += 1,
        }
        rig.cycle();
        assert!(rig.places().iter().all(|p| p.is_finite()), "record {n}: {c:?}");
        if !rig.is("motion.motion-enabled") {
            motion.push(task, &new(kind::ENABLE)).unwrap();
        }
    }
    assert!(accepted > 1000 && refused > 2000, "{accepted} accepted, {refused} refused");
}
