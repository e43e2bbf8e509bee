//! The real clock: other terminals, every manner of ending, and the files left behind. No test here measures durations.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_tests::{
    programs::root,
    scratch::{Running, Scratch, until},
};
use rustix::process::Signal;
use std::{fs, path::Path};

const BLINK: &str = "\
loadrt threads name1=t period1=1000000
loadrt not
net blink not.0.out => not.0.in
addf not.0 t
start
";

fn halrun(scratch: &Scratch, words: &[&str]) -> Running {
    scratch.start(scratch.command(&[], "halrun").args(words))
}

/// Returns the output of a command; it must succeed.
fn ask(scratch: &Scratch, words: &[&str]) -> String {
    let output = scratch.halcmd(words);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{words:?}");
    output.stdout
}

/// Waits until a thread of the instance has run a cycle.
fn until_up(scratch: &Scratch, instance: &mut Running, thread: &str) {
    let beat = format!("{thread}.threadbeat");
    until("the instance runs its threads", || {
        assert!(instance.is_running(), "it ended, and said {:?}", instance.said());
        let output = scratch.halcmd(&["getp", &beat]);
        output.status == Some(0) && output.stdout.trim() != "0"
    });
}

/// Returns whether a process exists.
fn lives(pid: &str) -> bool {
    let stat = fs::read_to_string(Path::new("/proc").join(pid).join("stat")).unwrap_or_default();
    let state = stat.rsplit(')').next().and_then(|s| s.split_whitespace().next());
    state.is_some_and(|s| s != "Z")
}

/// Returns the process of an instance.
fn process(scratch: &Scratch) -> String {
    let text = ask(scratch, &["status", "instance"]);
    let after = text.split("(process ").nth(1).unwrap_or_else(|| panic!("{text}"));
    after.split(')').next().unwrap().to_owned()
}

/// Returns the process of a program that has joined.
fn program(scratch: &Scratch, name: &str) -> String {
    let text = ask(scratch, &["show", "comp", name]);
    let line = text.lines().find(|l| l.contains(name)).unwrap_or_else(|| panic!("{text}"));
    line.split_whitespace().nth(3).unwrap().to_owned()
}

fn nothing_is_left(scratch: &Scratch, processes: &[String]) {
    assert!(scratch.left().is_empty(), "left behind: {:?}", scratch.left());
    for pid in processes {
        until("its processes have ended", || !lives(pid));
    }
}

#[test]
fn a_machine_from_another_terminal() {
    let scratch = Scratch::copy_of(&root().join("tests/hal/printer"));
    scratch.write("custom_postgui.hal", "");
    let mut machine = halrun(&scratch, &["--simulate", "--headless", "impresora3D.ini"]);
    until_up(&scratch, &mut machine, "servo-thread");
    let own = vec![process(&scratch), program(&scratch, "hal_manualtoolchange")];

    let pins = ask(&scratch, &["show", "pin"]);
    for part in
        ["float OUT", "stepgen.0.position-fb ==> xpos-fb", "axis.0.motor-pos-cmd ==> xpos-cmd"]
    {
        assert!(pins.contains(part), "{pins}");
    }
    assert!(!pins.contains(".sim."), "simulated registers are shown when they are named");
    let threads = ask(&scratch, &["show", "thread"]);
    for part in ["1000000  YES          servo-thread (", "100000  NO            base-thread ("] {
        assert!(threads.contains(part), "{threads}");
    }
    ask(&scratch, &["setp", "stepgen.0.maxaccel", "1250"]);
    assert_eq!(ask(&scratch, &["getp", "stepgen.0.maxaccel"]), "1250\n");
    ask(&scratch, &["setp", "stepgen.0.maxaccel", "1500"]);
    assert_eq!(ask(&scratch, &["getp", "stepgen.0.maxaccel"]), "1500\n");

    // Late wakeups on this computer must not switch the axis off.
    ask(&scratch, &["motion.configure", "joint=0", "ferror=1000", "min-ferror=1000"]);
    ask(&scratch, &["--wait", "iocontrol.estop-reset"]);
    ask(&scratch, &["--wait", "motion.enable"]);
    ask(&scratch, &["motion.jog", "joint=0", "velocity=20", "distance=3"]);
    until("the axis is where it was sent", || {
        let at: f64 = ask(&scratch, &["getp", "stepgen.0.position-fb"]).trim().parse().unwrap();
        (at - 3.0).abs() < 0.01
    });
    assert_eq!(ask(&scratch, &["getp", "stepgen.0.counts"]), "12\n");

    machine.signal(Signal::INT);
    let output = machine.wait();
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    nothing_is_left(&scratch, &own);
}

#[test]
fn every_polite_way_to_end() {
    let scratch = Scratch::new("ends");
    scratch.write("blink.hal", BLINK);
    for end in ["SIGINT", "SIGTERM", "shutdown", "-U"] {
        let mut machine = halrun(&scratch, &["blink.hal"]);
        until_up(&scratch, &mut machine, "t");
        let own = vec![process(&scratch)];
        match end {
            "SIGINT" => machine.signal(Signal::INT),
            "SIGTERM" => machine.signal(Signal::TERM),
            "shutdown" => drop(ask(&scratch, &["shutdown"])),
            _ => assert_eq!(scratch.halrun(&["-U"]).status, Some(0)),
        }
        let output = machine.wait();
        let (said, status) = (output.stderr.as_str(), output.status);
        assert_eq!((said, status), ("", Some(0)), "{end}");
        nothing_is_left(&scratch, &own);
    }
    assert_eq!(scratch.halrun(&["-U"]).status, Some(0), "nothing runs, and that is well");
    let output = scratch.halcmd(&["getp", "not.0.out"]);
    assert_eq!(output.status, Some(1));
    assert!(output.stderr.contains("no instance 'default' is running"), "{}", output.stderr);
}

#[test]
fn after_a_kill_a_new_start_works() {
    let scratch = Scratch::new("kill");
    scratch.write("blink.hal", format!("loadusr -W hal_manualtoolchange\n{BLINK}"));
    let mut machine = halrun(&scratch, &["blink.hal"]);
    until_up(&scratch, &mut machine, "t");
    let own = vec![process(&scratch), program(&scratch, "hal_manualtoolchange")];
    machine.signal(Signal::KILL);
    assert_eq!(machine.wait().status, None);
    for pid in &own {
        until("its programs end without it", || !lives(pid));
    }
    let mut machine = halrun(&scratch, &["blink.hal"]);
    until_up(&scratch, &mut machine, "t");
    machine.signal(Signal::INT);
    assert_eq!(machine.wait().status, Some(0));
    nothing_is_left(&scratch, &[]);
}

#[test]
fn in_the_background() {
    let scratch = Scratch::new("detach");
    scratch.write("blink.hal", BLINK);
    let output = scratch.halrun(&["--detach", "blink.hal"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    // The script has finished when this returns.
    assert_eq!(ask(&scratch, &["list", "sig"]), "blink \n");
    let own = vec![process(&scratch)];
    let again = scratch.halrun(&["blink.hal"]);
    assert_eq!(again.status, Some(1));
    assert!(again.stderr.contains("already running"), "{}", again.stderr);
    assert_eq!(scratch.halrun(&["-U"]).status, Some(0));
    nothing_is_left(&scratch, &own);

    scratch.write("bad.hal", "loadrt threads name1=t period1=1000000\nloadrt nto\n");
    let output = scratch.halrun(&["--detach", "bad.hal"]);
    assert_eq!(output.status, Some(1));
    assert!(output.stderr.starts_with("bad.hal:2: nto: "), "{}", output.stderr);
    nothing_is_left(&scratch, &[]);
}

#[test]
fn in_the_background_it_says_in_its_log_how_it_ended() {
    let scratch = Scratch::new("log");
    scratch.write("blink.hal", BLINK);
    let detach = || {
        // Standard error is a pipe, which is released like a terminal.
        let shell = ["sh", "-c", "\"$0\" --detach \"$@\" 2>&1 | cat"];
        let output = scratch.run(scratch.command(&shell, "halrun").arg("blink.hal"));
        assert_eq!((output.stdout.as_str(), output.status), ("", Some(0)));
        process(&scratch)
    };
    let log = scratch.path().join(".run/ferrule/default.log");
    let said = || fs::read_to_string(&log).unwrap_or_default();
    for (signal, words) in
        [("-KILL", "was ended by SIGKILL"), ("-SEGV", "SIGSEGV, sent by process")]
    {
        let pid = detach();
        scratch.run(scratch.command(&["sh", "-c"], &format!("kill {signal} {pid}")).arg(""));
        until("its log says it", || said().contains(words));
        until("it is gone", || scratch.left() == ["default.log"]);
        let output = scratch.halcmd(&["list", "sig"]);
        let place = format!("what it said in the background is in {}", log.display());
        assert!(output.stderr.contains(&place), "{}", output.stderr);
    }
    // The next instance appends to the log. An instance without messages leaves no log.
    assert!(said().contains("SIGKILL") && said().contains("SIGSEGV"), "{}", said());
    fs::remove_file(&log).unwrap();
    detach();
    assert_eq!(scratch.halrun(&["-U"]).status, Some(0));
    // On a busy computer a thread may wake late, which is a message.
    let late = said();
    let is_late = !late.is_empty() && late.lines().all(|l| l.starts_with("realtime: "));
    let left: &[&str] = if is_late { &["default.log"] } else { &[] };
    assert_eq!(scratch.left(), left, "{late}");
}

#[test]
fn two_instances_know_nothing_of_each_other() {
    let scratch = Scratch::new("two");
    scratch.write("blink.hal", BLINK);
    let mut a = halrun(&scratch, &["--instance", "a", "blink.hal"]);
    let mut b = halrun(&scratch, &["--instance", "b", "blink.hal"]);
    for (name, machine) in [("a", &mut a), ("b", &mut b)] {
        until("both run", || {
            assert!(machine.is_running(), "{:?}", machine.said());
            scratch.halcmd(&["--instance", name, "list", "sig"]).stdout == "blink \n"
        });
    }
    ask(&scratch, &["--instance", "a", "newsig", "only-here", "bit"]);
    assert_eq!(ask(&scratch, &["--instance", "b", "list", "sig"]), "blink \n");
    ask(&scratch, &["--instance", "a", "shutdown"]);
    assert_eq!(a.wait().status, Some(0));
    assert_eq!(ask(&scratch, &["--instance", "b", "list", "sig"]), "blink \n");
    b.signal(Signal::TERM);
    assert_eq!(b.wait().status, Some(0));
    nothing_is_left(&scratch, &[]);
}
