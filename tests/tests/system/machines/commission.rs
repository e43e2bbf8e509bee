//! `ferrule commission` on a simulated machine: the test is the person, who looks at what the machine really does. Each fault
//! of `tests/commission/faults.toml` must be found at its step, and nothing may move far in a wrong direction.
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests; the ways in a wrong direction are shown"
)]

use hal_protocol::{Client, Link as _, Reply, Request, Value};
use hal_tests::{programs::root, scratch::Scratch};
use hal_trace::{Trace, measure::number};
use rustix::process::{Pid, Signal, kill_process};
use serde::Deserialize;
use std::{
    fs,
    io::{Read as _, Write as _},
    process::Stdio,
};

/// Longest way in a wrong direction, in millimetres.
const MOST: f64 = 2.0;
const STEPS: [&str; 8] =
    ["estop", "switches", "enable", "direction", "scale", "following", "homing", "spindle"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Faults {
    fault: Vec<Fault>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fault {
    name: String,
    change: Vec<(String, String)>,
    at: String,
    says: String,
    #[serde(default)]
    names: Vec<String>,
    #[serde(default)]
    accept: bool,
    #[serde(default)]
    aborts: bool,
}

fn faults() -> Vec<Fault> {
    let text = fs::read_to_string(root().join("tests/commission/faults.toml")).unwrap();
    toml::from_str::<Faults>(&text).unwrap().fault
}

/// Returns a folder with the machine, with a fault in it.
fn machine(fault: &Fault) -> Scratch {
    let scratch = Scratch::copy_of(&root().join("tests/commission"));
    for (from, to) in &fault.change {
        let mut found = 0;
        for file in ["machine.hal", "plant.hal", "machine.ini"] {
            let text = scratch.read(file);
            let changed: Vec<String> = text
                .lines()
                .map(|line| {
                    // In the INI file, which has the same entries for each joint, the first one.
                    if line == from && (found == 0 || file != "machine.ini") {
                        found += 1;
                        to.clone()
                    } else {
                        line.to_owned()
                    }
                })
                .collect();
            scratch.write(file, format!("{}\n", changed.join("\n")));
        }
        assert_eq!(found, 1, "{}: {from}", fault.name);
    }
    scratch
}

/// The person, who has eyes for the machine and hands for its switches.
struct Hands {
    client: Option<Client>,
    /// Places of the motors before a movement.
    before: [f64; 3],
    /// Drives that were on while the machine was.
    held: [bool; 3],
    /// Longest way in a wrong direction so far.
    wrong: f64,
}

impl Hands {
    fn call(&mut self, scratch: &Scratch, request: Request) -> Reply {
        if self.client.as_ref().is_none_or(Client::is_gone) {
            self.client = Some(Client::connect(&scratch.place("default"), "").unwrap());
        }
        self.client.as_mut().unwrap().call(request).unwrap()
    }

    fn value(&mut self, scratch: &Scratch, name: &str) -> f64 {
        match self.call(scratch, Request::Get { name: name.to_owned() }) {
            Reply::Value(Value::Bit(on)) => f64::from(u8::from(on)),
            Reply::Value(Value::Float(x)) => x,
            other => panic!("{name}: {other:?}"),
        }
    }

    fn set(&mut self, scratch: &Scratch, name: &str, on: bool) {
        let value = if on { "TRUE" } else { "FALSE" }.to_owned();
        self.call(scratch, Request::Set { name: name.to_owned(), value });
    }

    fn places(&mut self, scratch: &Scratch) -> [f64; 3] {
        ["motor-x.position", "motor-y.position", "motor-z.out"]
            .map(|name| self.value(scratch, name))
    }

    /// Returns the answer to a question.
    fn answer(&mut self, scratch: &Scratch, question: &str, fault: &Fault) -> String {
        let switch = |label: &str| {
            let (axis, what) = label.split_once(' ').unwrap();
            let what = what.split(' ').next().unwrap();
            format!("{}-{what}.in1", axis.to_lowercase())
        };
        let yes = |is: bool| if is { "y" } else { "n" }.to_owned();
        let of = |text: &str, before: &str, after: &str| {
            let (_, rest) = text.split_once(before)?;
            Some(rest.split_once(after)?.0.to_owned())
        };
        if question.contains("pull") {
            self.set(scratch, "button.in1", false);
        } else if question.contains("press the e-stop button") {
            self.set(scratch, "button.in1", true);
        } else if let Some(label) = of(question, "press and hold the switch of ", ", then") {
            self.set(scratch, &switch(&label), true);
        } else if let Some(label) = of(question, "leave the switch of ", ", then") {
            self.set(scratch, &switch(&label), false);
        } else if question.contains("turned by hand") {
            let on =
                ["gate-x.in1", "gate-y.in1", "power.in"].map(|pin| self.value(scratch, pin) != 0.0);
            return yes(!on.contains(&true));
        } else if question.contains("Does each drive hold") {
            let on =
                ["gate-x.in1", "gate-y.in1", "power.in"].map(|pin| self.value(scratch, pin) != 0.0);
            self.held = on;
            return yes(!on.contains(&false));
        } else if question.contains("which one") {
            // The one whose drive is not as it should be: on while the machine is off, or off while it was on.
            let on =
                ["gate-x.in1", "gate-y.in1", "power.in"].map(|pin| self.value(scratch, pin) != 0.0);
            let odd = if question.contains("is held") {
                on.iter().position(|on| *on)
            } else {
                self.held.iter().position(|on| !on)
            };
            return ["x", "y", "z"][odd.unwrap()].to_owned();
        } else if question.contains("toward +") {
            self.before = self.places(scratch);
        } else if question.contains("what has moved") {
            let now = self.places(scratch);
            let moved = (0..3).find(|n| (now[*n] - self.before[*n]).abs() > 0.05);
            let sign = |n: usize| if now[n] > self.before[n] { "+" } else { "-" };
            return moved
                .map_or("none".to_owned(), |n| format!("{}{}", ["x", "y", "z"][n], sign(n)));
        } else if let Some(name) = of(question, "how far has ", " moved") {
            let n = "XYZ".find(&name).unwrap();
            return format!("{:.3}", self.places(scratch)[n] - self.before[n]);
        } else if question.contains("which way does it turn") {
            let (on, back) =
                (self.value(scratch, "spins.out"), self.value(scratch, "spin-back.out"));
            return match (on != 0.0, back != 0.0) {
                (false, _) => "none",
                (true, false) => "cw",
                (true, true) => "ccw",
            }
            .to_owned();
        } else if question.contains("stand still") {
            return yes(self.value(scratch, "spins.out") == 0.0);
        } else if question.contains("write this to") {
            // The machine has ended: its recording is whole.
            self.client = None;
            self.wrong = self.wrong.max(wrong_way(scratch, fault));
            return yes(fault.accept);
        } else if question.contains("begin this step again") {
            return "n".to_owned();
        }
        String::new()
    }
}

/// Returns the recording of the true places.
fn recording(scratch: &Scratch, of: &str) -> Trace {
    let recording = scratch.path().join("truth.vcd");
    assert!(recording.exists(), "{of}: the machine did not start");
    let (trace, _) = hal_trace::load(&recording).unwrap();
    trace.whole().unwrap_or_else(|(_, flaw)| panic!("{of}: {flaw}"))
}

/// Returns the values of a channel.
fn values(trace: &Trace, name: &str) -> Vec<f64> {
    let channel = &trace.channels()[trace.find(name).unwrap()];
    channel.changes().filter_map(|change| number(change.value?)).collect()
}

/// Returns the longest way that a motor went against its command, or without one, as the recording of the true places has it.
fn wrong_way(scratch: &Scratch, fault: &Fault) -> f64 {
    let trace = recording(scratch, &fault.name);
    let channel = |name: &str| &trace.channels()[trace.find(name).unwrap()];
    let mut most = 0.0_f64;
    for (place, speed) in [
        ("true-x", "joint.0.vel-cmd"),
        ("true-y", "joint.1.vel-cmd"),
        ("true-z", "joint.2.vel-cmd"),
    ] {
        let changes = |name: &str, is_place: bool| {
            let of = channel(name).changes();
            of.filter_map(move |c| Some((c.sample, is_place, number(c.value?)?)))
                .collect::<Vec<_>>()
        };
        let mut all = [changes(place, true), changes(speed, false)].concat();
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut at, mut start, mut sign) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (_, is_place, value) in all {
            if !is_place {
                // A command that has ended permits no way.
                let now = if value == 0.0 { 0.0 } else { value.signum() };
                if now != sign {
                    sign = now;
                    start = at;
                }
                continue;
            }
            at = value;
            let way = at - start;
            // Without a command every way is a wrong one.
            most = most.max(if sign == 0.0 { way.abs() } else { -sign * way });
            if sign * way > 0.0 {
                start = at;
            }
        }
    }
    most
}

/// The way in which a person ends the program at a question.
#[derive(Clone, Copy, Debug)]
enum Leaves {
    /// The input ends.
    End,
    /// The word for it.
    Word,
    /// A signal.
    Signal(Signal),
    /// A signal, after the question was answered: while something moves, where the question is about that.
    Later(Signal),
}

/// Commissions the machine; returns what was said, the status, and the longest way in a wrong direction.
fn commissioned(scratch: &Scratch, fault: &Fault) -> (String, Option<i32>, f64) {
    left(scratch, fault, None)
}

/// Commissions the machine as [`commissioned`] does, until the person leaves at a question.
fn left(
    scratch: &Scratch,
    fault: &Fault,
    leaves: Option<(&str, Leaves)>,
) -> (String, Option<i32>, f64) {
    let mut command = scratch.command(&[], "ferrule");
    command.args(["commission", "--virtual", "machine.ini"]);
    let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child.unwrap();
    let (mut to, mut from) = (child.stdin.take(), child.stdout.take().unwrap());
    let pid = Pid::from_child(&child);
    let mut hands = Hands { client: None, before: [0.0; 3], held: [false; 3], wrong: 0.0 };
    let (mut said, mut open) = (String::new(), String::new());
    let mut bytes = [0; 4096];
    loop {
        let n = from.read(&mut bytes).unwrap();
        if n == 0 {
            break;
        }
        open.push_str(&String::from_utf8_lossy(&bytes[..n]));
        if !open.ends_with(' ') {
            continue;
        }
        let question = open.lines().last().unwrap().to_owned();
        let answer = hands.answer(scratch, &question, fault);
        said.push_str(&open);
        said.push_str(&answer);
        said.push('\n');
        open.clear();
        let how = leaves.filter(|(at, _)| question.contains(at)).map(|(_, how)| how);
        let mut say = |line: &str| {
            // The program may have ended already.
            to.as_mut().is_none_or(|to| writeln!(to, "{line}").is_err())
        };
        match how {
            None => drop(say(&answer)),
            Some(Leaves::Word) => drop(say("stop")),
            Some(Leaves::End) => to = None,
            Some(Leaves::Signal(signal)) => kill_process(pid, signal).unwrap(),
            Some(Leaves::Later(signal)) => {
                say(&answer);
                kill_process(pid, signal).unwrap();
            }
        }
    }
    said.push_str(&open);
    let mut errors = String::new();
    child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
    said.push_str(&errors);
    let status = child.wait().unwrap().code();
    assert!(!said.contains("ended at its start"), "{}: {said}", fault.name);
    let wrong = hands.wrong.max(wrong_way(scratch, fault));
    (said, status, wrong)
}

#[test]
fn a_good_machine_passes_each_step_without_a_false_finding() {
    let fault = Fault { name: "none".to_owned(), ..Fault::default() };
    let scratch = machine(&fault);
    let before = scratch.files();
    let (said, status, wrong) = commissioned(&scratch, &fault);
    assert_eq!(status, Some(0), "{said}");
    assert!(!said.contains("FAULT") && !said.contains("aborted"), "{said}");
    assert!(said.contains("Each step has passed"), "{said}");
    assert!(wrong <= 0.1, "{wrong} mm in a wrong direction\n{said}");
    // A tenth of the speed and of the acceleration of the INI file, and no less.
    let trace = recording(&scratch, "good");
    for (name, most) in [("vel", 4.0), ("acc", 40.0)] {
        for n in 0..3 {
            let all = values(&trace, &format!("joint.{n}.{name}-cmd"));
            let largest = all.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let is_slow = 0.9 * most < largest && largest < 1.001 * most;
            assert!(is_slow, "joint.{n}.{name}-cmd: {largest}");
        }
    }
    let results = scratch.read("machine.commission");
    let lines: Vec<Vec<&str>> = results.lines().map(|l| l.split(' ').collect()).collect();
    assert_eq!(lines.iter().map(|l| l[1]).collect::<Vec<_>>(), STEPS);
    assert!(
        lines.iter().all(|l| l[2] == "passed" && l[0].len() == 20 && l[0].ends_with('Z')),
        "{results}"
    );
    for file in ["machine.ini", "machine.hal", "plant.hal"] {
        assert_eq!(scratch.files()[file], before[file], "{file} was changed");
    }
    assert!(scratch.files().keys().all(|name| !name.ends_with(".commission.ini")));
    // What has passed is not asked for again, unless the wiring is another one or the person wants it.
    let (again, status, _) = commissioned(&scratch, &fault);
    assert_eq!((status, again.matches(": passed 20").count()), (Some(0), 8), "{again}");
    scratch.write("plant.hal", format!("{}# another wire\n", scratch.read("plant.hal")));
    let mut child = scratch.command(&[], "ferrule");
    let other = scratch.run(child.args(["commission", "--virtual", "machine.ini"]));
    assert!(other.stdout.contains("estop: pull the e-stop button out"), "{other:?}");
    assert_eq!(other.status, Some(1));
}

#[test]
fn each_fault_is_found_at_its_step() {
    let faults = faults();
    assert!(faults.len() >= 20, "{} faults", faults.len());
    let mut failures = String::new();
    for fault in &faults {
        let scratch = machine(fault);
        let original = scratch.read("machine.ini");
        let (said, status, wrong) = commissioned(&scratch, fault);
        let word = if fault.aborts { "aborted" } else { "FAULT" };
        let found =
            said.lines().find(|line| line.contains(": FAULT: ") || line.contains(": aborted: "));
        let expected = format!("{}: {word}: ", fault.at);
        let after = found.and_then(|line| said.split_once(line)).map_or("", |(_, after)| after);
        let mend = after.lines().nth(1).unwrap_or_default();
        let unnamed = fault.names.iter().find(|name| !mend.contains(*name));
        assert!(fault.aborts || !fault.names.is_empty(), "{}: names nothing", fault.name);
        let is_found = found.is_some_and(|l| l.starts_with(&expected) && l.contains(&fault.says))
            && unnamed.is_none();
        println!("{wrong:.3} mm wrong: {}", fault.name);
        let ends = if fault.accept { Some(0) } else { Some(1) };
        let place = STEPS.iter().position(|step| *step == fault.at).unwrap();
        let later = STEPS[place + 1..].iter().find(|step| said.contains(&format!("\n{step}: ")));
        let went_on = later.is_some() && !fault.accept;
        let one = said.matches(": FAULT: ").count() + said.matches(": aborted: ").count() == 1;
        if !is_found || status != ends || wrong > MOST || went_on || !one {
            failures.push_str(&format!(
                "{}: found {found:?}, status {status:?}, {wrong:.3} mm wrong, later {later:?}, not named {unnamed:?}\n{said}\n",
                fault.name
            ));
        }
        let kept = scratch.read("machine.commission");
        if !kept.contains(&format!(
            " {} {} ",
            fault.at,
            if fault.aborts { "aborted" } else { "fault" }
        )) {
            failures.push_str(&format!("{}: {kept}", fault.name));
        }
        // Only what the person agreed to is written.
        let ini = scratch.read("machine.ini");
        let changed = ini.lines().zip(original.lines()).filter(|(a, b)| a != b).count();
        if fault.accept {
            // The person has seen what changes, and has the state before.
            assert_eq!(scratch.read(".ferrule/machine.ini/000001"), original, "{}", fault.name);
            let seen = said.contains("\n-SCALE = 40\n+SCALE = ");
            assert!(seen && said.contains("--- machine.ini\n+++ machine.ini\n@@ "), "{said}");
        }
        if changed != usize::from(fault.accept) {
            failures.push_str(&format!(
                "{}: {changed} lines of the INI file changed\n{said}",
                fault.name
            ));
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn a_person_who_leaves_has_a_machine_that_is_off_and_files_as_before() {
    let all = faults();
    let named = |name: &str| all.iter().find(|fault| fault.name == name).unwrap();
    let good = &Fault { name: "none".to_owned(), ..Fault::default() };
    let turned = named("the direction of X is inverted");
    let stuck = named("the spindle does not stop");
    for (fault, at, how) in [
        (good, "pull the e-stop button out", Leaves::End),
        (good, "press and hold", Leaves::Signal(Signal::INT)),
        (good, "Does each drive hold", Leaves::Signal(Signal::TERM)),
        (good, "toward +", Leaves::Later(Signal::INT)),
        (good, "what has moved", Leaves::End),
        (turned, "what has moved", Leaves::Signal(Signal::INT)),
        (turned, "write this to", Leaves::End),
        (turned, "write this to", Leaves::Signal(Signal::INT)),
        (turned, "write this to", Leaves::Word),
        (good, "how far has", Leaves::Word),
        (good, "looks for its switch", Leaves::Later(Signal::HUP)),
        (stuck, "which way does it turn", Leaves::End),
    ] {
        let scratch = machine(fault);
        let before = scratch.files();
        let (said, status, wrong) = left(&scratch, fault, Some((at, how)));
        let case = format!("{}, {at}, {how:?}: {said}", fault.name);
        assert!(said.contains(at), "{case}");
        assert_eq!(status, Some(1), "{case}");
        assert!(wrong <= MOST, "{wrong} mm: {case}");
        for (name, bytes) in &before {
            assert_eq!(scratch.files()[name], *bytes, "{name} was changed: {case}");
        }
        assert!(!scratch.path().join(".ferrule").exists(), "{case}");
        assert!(
            scratch.files().keys().all(|name| !name.ends_with(".ini") || before.contains_key(name))
        );
        // The machine has ended, and was off before: the e-stop was open, and nothing moved any more.
        let reached = Client::connect(&scratch.place("default"), "");
        assert!(reached.is_err(), "it still runs: {case}");
        let trace = recording(&scratch, &case);
        for (name, last) in
            [("motion.motion-enabled", 0.0), ("latch.ok-out", 0.0), ("joint.0.vel-cmd", 0.0)]
        {
            assert_eq!(values(&trace, name).last().copied(), Some(last), "{name}: {case}");
        }
    }
}
