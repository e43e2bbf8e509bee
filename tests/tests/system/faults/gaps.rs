//! Gaps in time on the real clock: a machine whose process stands still while it moves, and clients that stand still or end
//! while theirs moves. No test here measures durations.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use crate::peer::python::python;
use hal_tests::{
    programs::programs,
    scratch::{Running, Scratch, until},
};
use rustix::process::{Pid, Signal, kill_process};
use std::fs;

/// Two joints that are homed and jog: joint 0 counts its own steps, an encoder measures joint 1. The sampler records, in
/// every cycle, whether motion is enabled, and the time since the cycle before in ns.
const MACHINE: &str = "\
loadrt trivkins coordinates=XY
loadrt motmod servo_period_nsec=1000000 num_joints=2
loadrt stepgen step_type=0 ctrl_type=p
loadrt encoder num_chan=1
loadrt sampler depth=60000 cfg=bu
addf stepgen.capture-position servo-thread
addf encoder.capture-position servo-thread
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf stepgen.update-freq servo-thread
addf stepgen.make-pulses servo-thread
addf sampler.0 servo-thread
setp stepgen.0.position-scale 10
setp stepgen.0.enable 1
net x-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd
net x-fb stepgen.0.position-fb => joint.0.motor-pos-fb
net y-fb encoder.0.position => joint.1.motor-pos-fb
net enabled motion.motion-enabled => sampler.0.pin.0
net period motion.servo.last-period => sampler.0.pin.1
motion.configure joint=0 max-velocity=20 max-acceleration=1000 min-limit=-1e6 max-limit=1e6 ferror=1e9 min-ferror=1e9
motion.configure joint=1 max-velocity=20 max-acceleration=1000 min-limit=-1e6 max-limit=1e6 ferror=1e9 min-ferror=1e9
start
";
const HOMED: [&str; 2] = ["joint.0.homed", "joint.1.homed"];

/// Starts the machine. With `fifo`, its threads run under `SCHED_FIFO` where the computer lets them.
fn machine(scratch: &Scratch, fifo: bool, words: &[&str]) -> Running {
    scratch.write("m.hal", MACHINE);
    let mut halrun = scratch.command(&[], "halrun");
    halrun.env_remove("HAL_MAX_GAP");
    if !fifo {
        halrun.env("HAL_NO_FIFO", "1");
    }
    let mut running = scratch.start(halrun.args(["--simulate"]).args(words).arg("m.hal"));
    until("the machine runs", || {
        assert!(running.is_running(), "{:?}", running.said());
        let beat = scratch.halcmd(&["getp", "servo-thread.threadbeat"]);
        beat.status == Some(0) && beat.stdout.trim() != "0"
    });
    running
}

fn get(scratch: &Scratch, pin: &str) -> String {
    scratch.told(&format!("getp {pin}")).trim().to_owned()
}

fn homed(scratch: &Scratch) -> [String; 2] {
    HOMED.map(|pin| get(scratch, pin))
}

/// Switches on, homes, and jogs both joints.
fn jog(scratch: &Scratch) {
    scratch.told("--wait motion.enable");
    scratch.told("--wait motion.home joint=all");
    assert_eq!(homed(scratch), ["TRUE", "TRUE"]);
    for n in [0, 1] {
        scratch.told(&format!("motion.jog joint={n} velocity=10"));
        until("it jogs", || get(scratch, &format!("joint.{n}.vel-cmd")) == "10");
    }
}

/// Waits until a process is stopped.
fn until_stopped(pid: u32) {
    until("it is stopped", || {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
        stat.rsplit(')').next().unwrap().trim_start().starts_with('T')
    });
}

/// Stops a process for at least this many milliseconds, and lets it go on.
fn stand_still(running: &Running, ms: i64) {
    running.signal(Signal::STOP);
    until_stopped(running.pid());
    let now = || {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        t.tv_sec * 1_000_000_000 + t.tv_nsec
    };
    let begin = now();
    until("time has passed", || now() - begin > ms * 1_000_000);
    running.signal(Signal::CONT);
}

#[test]
fn a_machine_whose_process_was_stopped_is_off_in_its_first_cycle_and_has_lost_what_only_counts_steps()
 {
    for fifo in [true, false] {
        let scratch = Scratch::new("gap");
        // A debugger and a paused computer are others: here only what was stopped and continued counts.
        let running = machine(&scratch, fifo, &["--max-gap", "3600s"]);
        let sampler = scratch.start(scratch.command(&[], "halsampler").args(["-t", "samples"]));
        for n in 1..=3 {
            jog(&scratch);
            stand_still(&running, 1000);
            until("motion is off", || get(&scratch, "motion.motion-enabled") == "FALSE");
            assert_eq!(homed(&scratch), ["FALSE", "TRUE"], "fifo {fifo}");
            let status = scratch.told("status instance");
            let line = status.lines().find(|l| l.trim_start().starts_with("gaps:"));
            let line = line.unwrap_or_else(|| panic!("{status}"));
            let cause = "it was stopped and continued (SIGSTOP, Ctrl-Z)";
            assert!(line.contains(&format!(" {n}, ")) && line.ends_with(cause), "{line}");
            // Nothing goes on by itself.
            assert_eq!(
                (get(&scratch, "joint.0.vel-cmd"), get(&scratch, "joint.1.vel-cmd")),
                ("0".into(), "0".into())
            );
        }
        let json = scratch.told("--json status instance");
        assert!(json.contains("\"gaps\":{\"count\":3,"), "{json}");
        let (_, said) = running.said();
        let told = |text: &str| said.matches(text).count();
        assert_eq!(told("motion stopped: the process stood still"), 3, "{said}");
        assert_eq!(told("joint 0 is no longer homed"), 3, "{said}");
        assert_eq!(told("joint 1 is no longer homed"), 0, "{said}");
        let realtime = running.realtime();
        assert_eq!(
            realtime.matches("realtime: the process stood still for ").count(),
            3,
            "{realtime}"
        );
        sampler.signal(Signal::INT);
        drop(sampler.wait());
        first_cycles(&scratch.read("samples"));
        running.signal(Signal::TERM);
        drop(running.wait());
    }
}

/// Checks that motion is off in the cycle that came a second after the one before. A process that was stopped within a cycle
/// ends that cycle as it began, and motion is off in the next. A busy computer makes cycles late too, and switches nothing off.
fn first_cycles(samples: &str) {
    let rows: Vec<Vec<&str>> = samples.lines().map(|l| l.split_whitespace().collect()).collect();
    let is_late = |row: &[&str]| row[2].parse::<u64>().unwrap() >= 1_000_000_000;
    let (mut at_once, mut offs) = (0, 0);
    for n in (1..rows.len()).filter(|n| rows[n - 1][1] == "1" && rows[*n][1] == "0") {
        offs += 1;
        at_once += u32::from(is_late(&rows[n]));
        assert!(is_late(&rows[n]) || is_late(&rows[n - 1]), "{:?}", &rows[n - 1..=n]);
    }
    assert_eq!(offs, 3);
    assert!(at_once > 0, "it is never off in the first cycle");
}

#[test]
fn threads_that_are_stopped_and_started_by_command_switch_a_machine_off() {
    let scratch = Scratch::new("stop-start");
    let running = machine(&scratch, true, &[]);
    jog(&scratch);
    scratch.told("stop");
    scratch.told("start");
    until("motion is off", || get(&scratch, "motion.motion-enabled") == "FALSE");
    assert_eq!(homed(&scratch), ["FALSE", "TRUE"]);
    let status = scratch.told("status instance");
    assert!(status.contains("the threads were stopped and started by command"), "{status}");
    running.signal(Signal::TERM);
    drop(running.wait());
}

/// Joint 0 counts its own steps, an encoder measures joint 1 behind a component, and joint 2 follows its command. They jog
/// when the threads are stopped and started. Each line that begins with `=` is the output of the line above it.
const STOPPED: &str = "\
loadrt trivkins coordinates=XYZ
loadrt motmod servo_period_nsec=1000000 num_joints=3
loadrt stepgen step_type=0 ctrl_type=p
loadrt encoder num_chan=1
loadrt scale
addf stepgen.capture-position servo-thread
addf encoder.capture-position servo-thread
addf scale.0 servo-thread
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf stepgen.update-freq servo-thread
addf stepgen.make-pulses servo-thread
setp stepgen.0.position-scale 10
setp stepgen.0.enable 1
net x-cmd joint.0.motor-pos-cmd => stepgen.0.position-cmd
net x-fb stepgen.0.position-fb => joint.0.motor-pos-fb
net y-raw encoder.0.position => scale.0.in
net y-fb scale.0.out => joint.1.motor-pos-fb
net z joint.2.motor-pos-cmd => joint.2.motor-pos-fb
getp joint.0.motor-pos-fb-measured
=FALSE
getp joint.1.motor-pos-fb-measured
=TRUE
getp joint.2.motor-pos-fb-measured
=FALSE
motion.configure joint=0 max-velocity=20 max-acceleration=100 min-limit=-900 max-limit=900 ferror=900 min-ferror=900
motion.configure joint=1 max-velocity=20 max-acceleration=100 min-limit=-900 max-limit=900 ferror=900 min-ferror=900
motion.configure joint=2 max-velocity=20 max-acceleration=100 min-limit=-900 max-limit=900 ferror=900 min-ferror=900
start
motion.enable --wait
motion.home joint=all --wait
start
run 5ms
getp motion.motion-enabled
=TRUE
motion.jog joint=0 velocity=10
motion.jog joint=1 velocity=10
motion.jog joint=2 velocity=10
run 500ms
getp joint.2.vel-cmd
=10
stop
run 3s
getp motion.motion-enabled
=TRUE
start
run 1ms
getp motion.motion-enabled
=FALSE
getp joint.2.vel-cmd
=0
getp joint.0.homed
=FALSE
getp joint.1.homed
=TRUE
getp joint.2.homed
=FALSE
motion.enable --wait
run 100ms
getp joint.2.vel-cmd
=0
motion.home joint=all --wait
stop
start
run 1ms
getp motion.motion-enabled
=FALSE
getp joint.0.homed
=TRUE
unlinkp joint.1.motor-pos-fb
getp joint.1.motor-pos-fb-measured
=FALSE
unlinkp joint.2.motor-pos-fb
net y-raw => joint.2.motor-pos-fb
getp joint.2.motor-pos-fb-measured
=TRUE
unloadrt encoder
getp joint.2.motor-pos-fb-measured
=FALSE
";

#[test]
fn on_the_virtual_clock_too_and_the_first_cycle_after_the_start_is_off() {
    let scratch = Scratch::new("stopped-virtual");
    let lines = STOPPED.lines().filter(|l| !l.starts_with('=')).map(|l| format!("{l}\n"));
    scratch.write("m.hal", lines.collect::<String>());
    let output = scratch.halrun(&["--virtual", "-f", "m.hal"]);
    let want = STOPPED.lines().filter_map(|l| l.strip_prefix('=')).map(|l| format!("{l}\n"));
    assert_eq!(output.stdout, want.collect::<String>(), "{}", output.stderr);
    assert_eq!(output.stderr.matches("joint 0 is no longer homed").count(), 1, "{}", output.stderr);
    assert_eq!(output.stderr.matches("joint 1 is no longer homed").count(), 0, "{}", output.stderr);
}

#[test]
fn a_signal_that_continues_what_was_not_stopped_is_no_gap() {
    let scratch = Scratch::new("cont");
    let running = machine(&scratch, true, &["--max-gap", "3600s"]);
    jog(&scratch);
    for _ in 0..20 {
        running.signal(Signal::CONT);
        let before = get(&scratch, "servo-thread.threadbeat");
        until("cycles pass", || get(&scratch, "servo-thread.threadbeat") != before);
    }
    let status = scratch.told("status instance");
    // A thread that wakes a whole cycle late just then takes the signal for the end of a stop.
    if !status.contains("gaps:") {
        assert_eq!(get(&scratch, "joint.1.vel-cmd"), "10");
    } else {
        assert!(status.contains("overruns:"), "{status}");
    }
    running.signal(Signal::TERM);
    drop(running.wait());
}

/// A program with pins of its own that sleeps in machine time, and exchanges their values through a page, as the panel does.
const SLEEPER: &str = "\
import hal, time
c = hal.component('sleeper')
c.newpin('n', hal.HAL_U32, hal.HAL_OUT)
c.ready()
while True:
    c['n'] += 1
    time.sleep(0.01)
";

/// A program with pins is stopped: the virtual clock goes on without it, and waits for it again when it is back.
#[test]
fn a_stopped_program_does_not_hold_the_virtual_clock() {
    let sleeper = python().map(|python| ("sleeper", format!("{python} sleeper.py")));
    let changer = ("hal_manualtoolchange", "hal_manualtoolchange".to_owned());
    for (name, program) in [Some(changer), sleeper].into_iter().flatten() {
        let scratch = Scratch::new("stopped-client");
        scratch.write("sleeper.py", SLEEPER);
        let lines = format!(
            "loadrt threads name1=t period1=1000000\nloadusr -Wn {name} {program}\nstart\nprint \
             ready\n"
        );
        scratch.write("m.hal", lines);
        // No program is so slow that the clock gives it up.
        let mut halrun = scratch.command(&[], "halrun");
        halrun.env("HAL_PATIENCE_MS", "3000000").env("PYTHONDONTWRITEBYTECODE", "1");
        let running = scratch.start(halrun.args(["--virtual", "--hold", "m.hal"]));
        until("the machine runs", || running.said().1.contains("ready"));
        let text = scratch.told(&format!("show comp {name}"));
        let line = text.lines().find(|l| l.contains(name)).unwrap();
        let number: i32 = line.split_whitespace().nth(3).unwrap().parse().unwrap();
        let pid = Pid::from_raw(number).unwrap();
        kill_process(pid, Signal::STOP).unwrap();
        until_stopped(number.cast_unsigned());
        scratch.told("run 5s");
        let want = format!(
            "program '{name}' (process {number}) is stopped: the virtual clock waits for it again \
             when it polls"
        );
        let (_, said) = running.said();
        assert_eq!(said.matches(&want).count(), 1, "{said}");
        kill_process(pid, Signal::CONT).unwrap();
        if name == "sleeper" {
            let before = get(&scratch, "sleeper.n");
            until("it is back", || {
                scratch.told("run 20ms");
                get(&scratch, "sleeper.n") != before
            });
            // The clock waits for it: it counts once every 10 ms.
            let count = || get(&scratch, "sleeper.n").parse::<u32>().unwrap();
            let before = count();
            scratch.told("run 1s");
            assert_eq!(count() - before, 100);
        }
        running.signal(Signal::TERM);
        drop(running.wait());
    }
}

const JOGS: &str = "\
import linuxcnc, sys, time
c = linuxcnc.command()
c.jog(linuxcnc.JOG_CONTINUOUS, 1, 0, 10.0)
if sys.argv[1] == 'forgets':
    del c
if sys.argv[1] == 'stops':
    c.jog(linuxcnc.JOG_STOP, 1, 0)
    c.wait_complete()
if sys.argv[1] == 'increment':
    c.jog(linuxcnc.JOG_INCREMENT, 1, 1, 10.0, 1e5)
print('jogs', flush=True)
if sys.argv[1] == 'ends':
    sys.exit(0)
time.sleep(10000)
";

/// A jog of a program in Python ends with its process: the joint brakes, and the machine stays on.
#[test]
fn a_continuous_jog_in_python_ends_with_its_process() {
    let Some(python) = python() else { return };
    let scratch = Scratch::new("python-jog");
    scratch.write("jogs.py", JOGS);
    // What a busy computer does to the threads is not judged here.
    let machine = machine(&scratch, true, &["--max-gap", "3600s"]);
    scratch.told("--wait motion.enable");
    let start = |how: &str| {
        let mut command = scratch.command(&[], python);
        command.env("PYTHONPATH", programs().join("python")).env("PYTHONDONTWRITEBYTECODE", "1");
        scratch.start(command.args(["jogs.py", how]))
    };
    for how in ["kill", "forgets", "ends"] {
        let program = start(how);
        if how == "ends" {
            drop(program.wait());
        } else {
            until("it jogs", || get(&scratch, "joint.0.vel-cmd") == "10");
            program.signal(Signal::KILL);
            drop(program.wait());
        }
        until("it brakes", || get(&scratch, "joint.0.vel-cmd") == "0");
        assert_eq!(get(&scratch, "motion.motion-enabled"), "TRUE", "{how}");
    }
    // A jog that the program itself has ended is no longer its own: that of another goes on.
    let program = start("stops");
    until("it has stopped", || program.said().0.contains("jogs"));
    until("it rests", || get(&scratch, "joint.0.vel-cmd") == "0");
    scratch.told("motion.jog joint=0 velocity=10");
    until("another jogs", || get(&scratch, "joint.0.vel-cmd") == "10");
    program.signal(Signal::KILL);
    drop(program.wait());
    let before = get(&scratch, "servo-thread.threadbeat");
    until("cycles pass", || get(&scratch, "servo-thread.threadbeat") != before);
    assert_eq!(get(&scratch, "joint.0.vel-cmd"), "10");
    scratch.told("--wait motion.jog-stop joint=0");
    // A jog of a distance is a movement with an end of its own.
    let program = start("increment");
    until("it jogs", || get(&scratch, "joint.1.vel-cmd") == "10");
    program.signal(Signal::KILL);
    drop(program.wait());
    until("the continuous jog brakes", || get(&scratch, "joint.0.vel-cmd") == "0");
    assert_eq!(get(&scratch, "joint.1.vel-cmd"), "10");
    machine.signal(Signal::TERM);
    drop(machine.wait());
}
