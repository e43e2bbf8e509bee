//! The wizard `halsetup`, driven question by question: every pair of options gives a machine without a finding that passes
//! its own tests, and answers are never lost.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_tests::{
    programs::root,
    scratch::{Output, Scratch},
    terminal::Terminal,
};
use rustix::process::{Pid, Signal, kill_process};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, File},
    io::{Read as _, Write as _},
    process::Stdio,
};

/// Options of a machine, each with its values. The first is the plainest.
const OPTIONS: &[(&str, &[&str])] = &[
    ("board", &["own", "printer", "gecko-g540", "xylotex", "sherline", "tb6560", "stepcraft"]),
    ("kind", &["steppers", "servos", "arm"]),
    ("axes", &["XYZ", "X", "XZ", "XYZA"]),
    ("gantry", &["none", "first", "last"]),
    ("units", &["mm", "inch"]),
    ("ports", &["378 out", "378 out, 278 in", "378 out, 278 in, 0 x"]),
    ("estop", &["none", "in", "in and out", "out"]),
    ("pump", &["none", "yes"]),
    ("enable", &["none", "all", "each"]),
    ("touch", &["none", "probe", "setter", "both"]),
    ("spindle", &["none", "on", "pwm", "all"]),
    ("switches", &["none", "first", "all"]),
    ("inverted", &["no", "yes"]),
    ("pulse", &["board", "slow"]),
];

type Row = BTreeMap<&'static str, &'static str>;

/// Returns machines in which each value of each option meets each value of each other one.
fn pairs() -> Vec<Row> {
    type Value = (&'static str, &'static str);
    let each: Vec<Value> =
        OPTIONS.iter().flat_map(|(name, values)| values.iter().map(move |v| (*name, *v))).collect();
    let all = each.iter().flat_map(|a| each.iter().map(move |b| (*a, *b)));
    let mut open: BTreeSet<(Value, Value)> = all.filter(|(a, b)| a.0 < b.0).collect();
    let mut rows = Vec::new();
    while let Some(&(first, second)) = open.iter().next() {
        let mut row = Row::from([first, second]);
        for (name, values) in OPTIONS {
            if row.contains_key(name) {
                continue;
            }
            let gain = |value: &str| {
                let met = |(a, b): &&(Value, Value)| {
                    let has = |v: &Value| row.get(v.0) == Some(&v.1);
                    (a.0 == *name && a.1 == value && has(b))
                        || (b.0 == *name && b.1 == value && has(a))
                };
                open.iter().filter(met).count()
            };
            let best = values.iter().rev().max_by_key(|value| gain(value)).unwrap();
            row.insert(name, best);
        }
        open.retain(|(a, b)| !(row.get(a.0) == Some(&a.1) && row.get(b.0) == Some(&b.1)));
        rows.push(row);
    }
    rows
}

/// Returns the answer to a question of a machine with these options. `is_again` says that it was refused once.
fn answer(row: &Row, prompt: &str, is_again: bool) -> String {
    let question = prompt.lines().last().unwrap_or_default();
    let (_, accepted) = question.rsplit_once('(').unwrap();
    let (of, text) =
        question.split_once(": ").filter(|(of, _)| of.len() < 8).unwrap_or(("", question));
    let is = |option: &str, values: &[&str]| values.contains(&row[option]);
    let preset = question.rsplit_once('[').map_or("", |(_, rest)| rest.trim_end_matches("]: "));
    let no = if is("inverted", &["yes"]) { "!" } else { "" };
    let line = |wants: bool| {
        let (_, lines) = accepted.split_once(' ').unwrap();
        let free = lines.split([',', ';', ')']).next().unwrap().trim();
        let may_be_none = accepted.contains("none)");
        match wants && !is_again && free != "none is free" {
            true if preset != "none" && !preset.is_empty() => String::new(),
            false if may_be_none => "none".to_owned(),
            _ => format!("{no}{free}"),
        }
    };
    let is_first = of == "X" || of == "joint 0" || of == "X2" && is("gantry", &["first"]);
    let letters = row["axes"];
    match text.split(" (").next().unwrap() {
        "Name of the machine" => "m".to_owned(),
        t if t.starts_with("Board between") => row["board"].to_owned(),
        t if t.starts_with("What moves") => row["kind"].to_owned(),
        t if t.starts_with("Its inputs") => {
            let has_gpio = is("board", &["printer"]) && is("kind", &["steppers"]);
            if has_gpio { String::new() } else { "parport".to_owned() }
        }
        t if t.starts_with("Addresses") => row["ports"].to_owned(),
        t if t.starts_with("Unit of") => row["units"].to_owned(),
        t if t.starts_with("Axes,") && is("kind", &["arm"]) => "XYZABC".to_owned(),
        t if t.starts_with("Axes,") => {
            if is_again {
                "X".to_owned()
            } else {
                letters.to_owned()
            }
        }
        t if t.starts_with("Axis with two") => match row["gantry"] {
            _ if is_again => "none".to_owned(),
            "first" => letters[..1].to_owned(),
            "last" if accepted.contains(letters) => letters[letters.len() - 1..].to_owned(),
            _ => "none".to_owned(),
        },
        t if t.starts_with("E-stop chain") => line(is("estop", &["in", "in and out"])),
        t if t.starts_with("E-stop relay") => line(is("estop", &["out", "in and out"])),
        t if t.starts_with("Charge pump") => line(is("pump", &["yes"])),
        t if t.starts_with("Enable of all") => line(is("enable", &["all"])),
        t if t.starts_with("Touch probe") => line(is("touch", &["probe", "both"])),
        t if t.starts_with("Tool setter") => line(is("touch", &["setter", "both"])),
        "Spindle on" => line(is("spindle", &["on", "all"])),
        t if t.starts_with("Spindle backward") => line(is("spindle", &["all"])),
        t if t.starts_with("Spindle speed") => line(is("spindle", &["pwm", "all"])),
        t if t.starts_with("Length of a step") && is("pulse", &["slow"]) => "30000".to_owned(),
        t if t.starts_with("Steps,") || t == "Direction" => {
            line(!(is_again && t.starts_with("Steps")))
        }
        t if t.starts_with("Enable of this") => line(is("enable", &["each"])),
        t if t.starts_with("Limit and home") => {
            line(is("switches", &["all"]) || is("switches", &["first"]) && is_first)
        }
        t if t.starts_with("Encoder") => line(true),
        _ => String::new(),
    }
}

/// Answers the questions as they come; returns what was said, and the reason if there is no machine.
fn asked(scratch: &Scratch, row: &Row) -> (String, Option<String>) {
    let mut command = scratch.command(&[], "halsetup");
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut to = child.stdin.take().unwrap();
    let mut from = child.stdout.take().unwrap();
    let (mut said, mut prompt, mut before) = (String::new(), Vec::new(), String::new());
    let mut bytes = [0; 4096];
    loop {
        let n = from.read(&mut bytes).unwrap();
        if n == 0 {
            break;
        }
        prompt.extend_from_slice(&bytes[..n]);
        if !(prompt.ends_with(b"): ") || prompt.ends_with(b"]: ")) {
            continue;
        }
        let text = String::from_utf8(std::mem::take(&mut prompt)).unwrap();
        let question = text.lines().last().unwrap().to_owned();
        let is_again = question == before;
        let line = answer(row, &text, is_again);
        said.push_str(&text);
        said.push_str(&format!("{line}\n"));
        assert!(said.matches(&question).count() < 4, "refused again and again: {row:?}\n{said}");
        before = question;
        writeln!(to, "{line}").unwrap();
    }
    let mut errors = String::new();
    child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
    let status = child.wait().unwrap();
    said.push_str(&String::from_utf8(prompt).unwrap());
    (said, if status.success() && errors.is_empty() { None } else { Some(errors) })
}

#[test]
fn every_pair_of_options_gives_a_machine_that_is_clean_and_passes_its_tests() {
    let rows = pairs();
    assert!((28..90).contains(&rows.len()), "{} machines", rows.len());
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let mut tests = 0;
    let mut failures = String::new();
    for row in &rows {
        let scratch = Scratch::new("wizard");
        let (said, why) = asked(&scratch, row);
        if let Some(why) = why {
            failures.push_str(&format!("{row:?}\n{said}\n{why}\n"));
            continue;
        }
        let checked = scratch.halcmd(&["check", "--all", "m/m.ini"]);
        if (checked.stdout.as_str(), checked.status) != ("nothing found\n", Some(0)) {
            failures.push_str(&format!("{row:?}\n{said}\n{}\n", checked.stdout));
        }
        let tested = scratch.run(scratch.command(&[], "haltest").args(["-j", "1", "m"]));
        let hal = scratch.read("m/m.hal");
        if tested.status != Some(0) {
            failures.push_str(&format!("{row:?}\n{}{}\n{hal}\n", tested.stdout, tested.stderr));
        }
        tests += tested.stdout.matches("ok    ").count();
        let ran = scratch.halrun(&["--virtual", "--for", "100ms", "m/m.ini"]);
        assert_eq!((ran.stderr.as_str(), ran.status), ("", Some(0)), "{row:?}");
        let ini = scratch.read("m/m.ini");
        for (what, is_there) in [
            ("e-stop input", hal.contains("estop-button")),
            ("charge pump", hal.contains("loadrt charge_pump")),
            (
                "e-stop output",
                hal.contains("net estop-allowed =>") || hal.contains("net estop-out =>"),
            ),
            ("probe", hal.contains("net probe-in")),
            ("tool setter", hal.contains("net setter-in")),
            ("both", hal.contains("loadrt or2 names=touch")),
            ("pulse width", hal.contains("net spindle-pwm")),
            ("spindle's direction", hal.contains("net spindle-reverse")),
            ("gantry", ini.contains("kinstype=BOTH")),
            ("gantry with switches", ini.contains("HOME_SEQUENCE = -") && hal.contains("2switch")),
            ("switch", hal.contains("switch ")),
            ("inverted input", hal.contains("-in-not")),
            ("inverted output", hal.contains("-invert TRUE")),
            ("servos", hal.contains("loadrt pid")),
            ("arm", ini.contains("armkins")),
            ("reset", hal.contains("-reset TRUE")),
        ] {
            *seen.entry(what).or_default() += usize::from(is_there);
        }
        // The answers that it kept give the same machine again.
        fs::create_dir(scratch.path().join("again")).unwrap();
        let again = halsetup(&scratch, &["m/m.setup", "-o", "again"]);
        assert_eq!(again.status, Some(0), "{}", again.stderr);
        for kind in ["ini", "hal", "setup"] {
            let file = format!("m/m.{kind}");
            assert_eq!(scratch.read(&file), scratch.read(&format!("again/{file}")), "{row:?}");
        }
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(seen.len() == 16 && seen.values().all(|n| *n >= 3), "{seen:?}");
    assert!(tests > 4 * rows.len(), "{tests} tests of {} machines", rows.len());
}

fn halsetup(scratch: &Scratch, words: &[&str]) -> Output {
    scratch.run(scratch.command(&[], "halsetup").args(words))
}

/// Runs halsetup with these lines as its input.
fn with_lines(scratch: &Scratch, words: &[&str], lines: &str) -> Output {
    scratch.write("said", lines);
    let mut command = scratch.command(&[], "halsetup");
    scratch.run(command.args(words).stdin(File::open(scratch.path().join("said")).unwrap()))
}

#[test]
fn answers_are_kept_at_every_question_and_gone_on_with() {
    let lines = fs::read_to_string(root().join("tests/setup/questions.txt")).unwrap();
    let lines: Vec<&str> = lines.split_inclusive('\n').collect();
    let whole = Scratch::new("wizard-whole");
    assert_eq!(with_lines(&whole, &[], &lines.concat()).status, Some(0));
    let files = ["small/small.ini", "small/small.hal", "small/small.setup"];
    for (n, stop) in (3..lines.len()).zip(["", "save\n"].into_iter().cycle()) {
        let scratch = Scratch::new("wizard-part");
        let part = format!("{}{stop}", lines[..n].concat());
        let output = with_lines(&scratch, &[], &part);
        let status = if stop.is_empty() { 1 } else { 0 };
        let told = if stop.is_empty() { &output.stderr } else { &output.stdout };
        assert!(told.contains("'halsetup ./small.setup' goes on with it"), "{n}: {output:?}");
        assert_eq!(output.status, Some(status), "{n}");
        assert!(!scratch.path().join("small").exists(), "{n}: a machine without all answers");
        let output = with_lines(&scratch, &["small.setup"], &lines[n..].concat());
        assert_eq!(
            (output.stderr.as_str(), output.status),
            ("", Some(0)),
            "{n}: {}",
            output.stdout
        );
        assert!(!output.stdout.contains("small.setup:"), "{n}: {}", output.stdout);
        for file in files {
            assert_eq!(scratch.read(file), whole.read(file), "{n}: {file}");
        }
    }
}

#[test]
fn ctrl_c_and_a_full_disk_lose_no_answer() {
    let scratch = Scratch::new("wizard-ctrl-c");
    let mut terminal = Terminal::start(&scratch, "halsetup", &[]);
    terminal.until("[machine]: ");
    terminal.keys("mine\n");
    terminal.until("[own]: ");
    terminal.keys("xylotex\n");
    terminal.until("[steppers]: ");
    let pid = i32::try_from(terminal.pid()).unwrap();
    // What Ctrl-C sends.
    kill_process(Pid::from_raw(pid).unwrap(), Signal::INT).unwrap();
    assert_ne!(terminal.end().0, Some(0));
    assert!(scratch.read("mine.setup").contains("board = \"xylotex\""));
    // A name that is taken is refused at its question.
    let output = with_lines(&scratch, &[], "mine\nother\nsave\n");
    assert!(output.stdout.contains("mine.setup: is there already; another name"), "{output:?}");
    let before = scratch.read("mine.setup");
    let full = with_lines(&scratch, &["-o", "/dev/null/none"], "third\n");
    assert_eq!(full.status, Some(1));
    assert!(full.stderr.contains("third.setup"), "{full:?}");
    assert_eq!(scratch.read("mine.setup"), before);
}

#[test]
fn a_file_that_is_not_answered_to_the_end_is_asked_for_the_rest() {
    let scratch = Scratch::new("wizard-rest");
    let whole = fs::read_to_string(root().join("tests/setup/mill.toml")).unwrap();
    // Without a person, what lacks is reported with its line.
    scratch.write("part.toml", whole.replace("pitch = 5\n", ""));
    let output = halsetup(&scratch, &["part.toml"]);
    assert_eq!(
        output.stderr.matches("pitch is missing: Way of a turn of the screw").count(),
        3,
        "{output:?}"
    );
    assert!(output.stderr.contains("part.toml:16: "), "{output:?}");
    // At a terminal the same file is gone on with.
    let mut terminal = Terminal::start(&scratch, "halsetup", &["part.toml"]);
    while !terminal.until("]: ").contains("Way of a turn") {
        terminal.keys("\n");
    }
    terminal.keys("save\n");
    assert_eq!(terminal.end().0, Some(0));
    assert!(scratch.read("part.toml").contains("unfinished = true"));
}
