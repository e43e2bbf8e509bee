//! The modules `hal` and `_hal` beside LinuxCNC's: names, scripts, virtual time, and the end of programs.
#![expect(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use hal_tests::{
    golden,
    programs::root,
    scratch::{Output, Scratch, until},
    tools::{Tool, linuxcnc},
};
use rustix::process::Signal;
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    fs,
    path::PathBuf,
    process::Command,
};

fn folder() -> PathBuf {
    root().join("tests/python")
}

/// Returns Python where there is one; reports the running test as skipped otherwise. LinuxCNC's module belongs to the
/// system's Python.
pub(crate) fn python() -> Option<&'static str> {
    let runs = |name: &&str| {
        Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success())
    };
    Tool::of("python3").or_skip(["/usr/bin/python3", "python3"].into_iter().find(runs))
}

/// Returns the scripts by name. Lines that begin with `#: ` are lines of HAL that come before the program.
fn scripts() -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder().join("scripts")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if name != "common" {
            all.insert(name, fs::read_to_string(path).unwrap());
        }
    }
    all
}

/// Writes a script and its HAL file into a folder.
fn write(scratch: &Scratch, python: &str, name: &str, script: &str) {
    let lines = script.lines().filter_map(|l| l.strip_prefix("#: "));
    let hal: String = lines.map(|l| format!("{l}\n")).collect();
    scratch.write("common.py", fs::read(folder().join("scripts/common.py")).unwrap());
    scratch.write(&format!("{name}.py"), script);
    scratch.write("run.hal", format!("{hal}loadusr -w {python} {name}.py\n"));
}

fn ours(scratch: &Scratch, words: &[&str]) -> Output {
    scratch.run(scratch.command(&[], "halrun").env("PYTHONDONTWRITEBYTECODE", "1").args(words))
}

/// Returns what a script prints with Ferrule's module.
fn printed(python: &str, name: &str, script: &str) -> String {
    let scratch = Scratch::new("python");
    write(&scratch, python, name, script);
    let output = ours(&scratch, &["--virtual", "-f", "run.hal"]);
    if output.stderr.contains("Traceback") {
        return format!("{}{}", output.stdout, output.stderr);
    }
    output.stdout
}

/// Returns the sections of a file, each of which begins with a line `== NAME`.
fn sections(file: &str) -> BTreeMap<String, String> {
    let text = fs::read_to_string(folder().join(file)).unwrap_or_default();
    let parts = text.split("== ").skip(1).filter_map(|part| part.split_once('\n'));
    parts.map(|(name, body)| (name.to_owned(), body.to_owned())).collect()
}

/// Returns the differences that are known: the lines `- THEIRS` and `+ OURS` of each script. Lines that begin with `#`
/// give the reason.
fn applied(known: &str, theirs: &str) -> String {
    let mut lines: Vec<&str> = theirs.lines().collect();
    let (mut theirs, mut ours) = (
        known.lines().filter_map(|l| l.strip_prefix("- ")),
        known.lines().filter_map(|l| l.strip_prefix("+ ")),
    );
    while let (Some(from), Some(to)) = (theirs.next(), ours.next()) {
        let at = lines.iter().position(|l| *l == from);
        lines[at.unwrap_or_else(|| panic!("no line '{from}'"))] = to;
    }
    lines.iter().map(|l| format!("{l}\n")).collect()
}

#[test]
fn scripts_print_what_they_print_with_the_module_of_linuxcnc() {
    let Some(python) = python() else { return };
    let (expected, known) = (sections("expected.txt"), sections("differences.txt"));
    let scripts = scripts();
    assert!(scripts.len() >= 40);
    let mut wrong = String::new();
    for (name, script) in scripts.iter().filter(|(name, _)| *name != "surface") {
        let known = known.get(name).map_or("", String::as_str);
        let want = applied(known, &expected[name]);
        let got = printed(python, name, script);
        if got != want {
            writeln!(wrong, "== {name}\n-- expected\n{want}-- got\n{got}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    assert!(known.keys().all(|name| scripts.contains_key(name)));
}

/// Each line of the file is `- NAME` or `+ NAME`, where a `*` at the end stands for any rest.
#[test]
fn the_modules_have_the_names_of_linuxcnc() {
    let Some(python) = python() else { return };
    let expected = sections("expected.txt");
    let set = |text: &str| text.lines().map(str::to_owned).collect::<BTreeSet<_>>();
    let theirs = set(&expected["surface"]);
    let ours = set(&printed(python, "surface", &scripts()["surface"]));
    let known = fs::read_to_string(folder().join("surface.differences")).unwrap();
    let mut unused: BTreeSet<&str> = known.lines().filter(|l| l.starts_with(['-', '+'])).collect();
    assert_eq!(unused.len(), known.lines().filter(|l| l.starts_with(['-', '+'])).count());
    let rows: Vec<&str> = unused.iter().copied().collect();
    let mut new = Vec::new();
    let differences = theirs.difference(&ours).map(|l| format!("- {l}"));
    for line in differences.chain(ours.difference(&theirs).map(|l| format!("+ {l}"))) {
        let matches = |row: &&&str| match row.strip_suffix('*') {
            Some(start) => line.starts_with(start),
            None => line == **row,
        };
        match rows.iter().find(matches) {
            Some(row) => drop(unused.remove(row)),
            None => new.push(line),
        }
    }
    assert!(new.is_empty() && unused.is_empty(), "new: {new:#?}\nno longer: {unused:#?}");
}

/// Measures LinuxCNC's module again: the expected output is what its scripts print.
#[test]
#[ignore = "starts LinuxCNC, which must run alone: cargo test -p hal-tests --test system peer::python -- --ignored"]
fn linuxcnc_prints_what_is_expected() {
    let (Some(python), Some(_)) = (python(), linuxcnc()) else { return };
    let mut all = String::new();
    for (name, script) in scripts() {
        let scratch = Scratch::new("peer-python");
        write(&scratch, python, &name, &script);
        let mut command = if is_root() {
            // LinuxCNC's programs run as an ordinary user.
            std::os::unix::fs::chown(scratch.path(), Some(65534), Some(65534)).unwrap();
            let mut command = Command::new("setpriv");
            command.args(["--reuid=65534", "--clear-groups", "/usr/bin/halrun"]);
            command
        } else {
            Command::new("/usr/bin/halrun")
        };
        command.current_dir(scratch.path()).env("HOME", scratch.path()).env("LANG", "C");
        let output =
            command.env("PYTHONDONTWRITEBYTECODE", "1").args(["-f", "run.hal"]).output().unwrap();
        let printed = String::from_utf8(output.stdout).unwrap();
        let own = printed.lines().filter(|l| !l.starts_with("Note: Using POSIX"));
        let own: String = own.map(|l| format!("{l}\n")).collect();
        assert!(!own.is_empty(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        write!(all, "== {name}\n{own}").unwrap();
    }
    golden::check(&folder().join("expected.txt"), &all);
}

fn is_root() -> bool {
    fs::metadata("/proc/self").is_ok_and(|m| std::os::unix::fs::MetadataExt::uid(&m) == 0)
}

/// A component that doubles a value in each 1.5 ms.
const DOUBLER: &str = r#"
import hal, time
h = hal.component("doubler")
h.newpin("in", hal.HAL_FLOAT, hal.HAL_IN)
h.newpin("out", hal.HAL_FLOAT, hal.HAL_OUT)
h.newpin("n", hal.HAL_U32, hal.HAL_OUT)
h.ready()
while True:
    h["n"] = h["n"] + 1
    h["out"] = 2 * h["in"]
    time.sleep(0.0015)
"#;

const MACHINE: &str = "loadrt threads name1=t period1=1000000
loadrt siggen
addf siggen.0.update t
net s siggen.0.sine => doubler.in
net d doubler.out
start
";

#[test]
fn a_run_in_virtual_time_with_a_program_in_python_gives_the_same_bytes_twice() {
    let Some(python) = python() else { return };
    let run = || {
        let scratch = Scratch::new("python-twice");
        scratch.write("doubler.py", DOUBLER);
        let machine =
            MACHINE.replace("net s", &format!("loadusr -Wn doubler {python} doubler.py\nnet s"));
        scratch.write("run.hal", format!("{machine}run 30ms\ngetp doubler.out\ngetp doubler.n\n"));
        let output = ours(&scratch, &["--virtual", "--record", "run.vcd", "-f", "run.hal"]);
        (output.stdout, output.stderr, scratch.read("run.vcd"))
    };
    let first = run();
    // The program works at 0 ms, 1.5 ms, …, 30 ms.
    assert!(first.0.ends_with("\n21\n"), "{first:?}");
    assert!(first.2.contains("doubler"));
    for _ in 0..2 {
        assert_eq!(run(), first);
    }
}

/// Output of the script `machine/bounds.py` on the mill, whose e-stop chain is closed.
const BOUNDS: &str = "\
axis is -1, should be 0 to 8
axis is -1, should be 0 to 8
axis is 9, should be 0 to 8
axis is 9, should be 0 to 8
reset 1
on 1
home 1
rapid override 0.25 1 1 0.25 0.75
rapid override 1.5 1 1 1.0 0.75
rapid override -1 1 1 0.0 0.75
rapid override 0.5 1 1 0.5 0.75
mdi 1
waiting: [100, 0] 100
messages: 100 True
abort 1
mdi 1
(13, 'fourth') (13, '3 more messages came too fast to be shown') None
";

#[test]
fn commands_and_messages_of_a_machine_are_bounded_and_lost_ones_are_counted() {
    let Some(python) = python() else { return };
    let scratch = Scratch::copy_of(&root().join("configs/mill"));
    scratch.write("bounds.py", fs::read(folder().join("machine/bounds.py")).unwrap());
    scratch.write("run.ini", "#INCLUDE mill.ini\n[HAL]\nPOSTGUI_HALFILE = run.hal\n");
    let lines = "setp parport.0.sim.status 192\n";
    scratch.write("run.hal", format!("{lines}loadusr -w {python} bounds.py\nshutdown\n"));
    let output = ours(&scratch, &["--virtual", "run.ini"]);
    assert_eq!(output.stdout, BOUNDS, "{}", output.stderr);
}

/// Output of the script `machine/early.py`: state, e-stop, joints homed, file, queue, coordinate system and feed override.
const EARLY: &str = "\
before [1, 1, (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0), '', 0, 0, 0.0] None
after [1, 1, (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0), '', 0, 1, 1.0] None
of another shape: []
";

/// As LinuxCNC's `millturn.hal` does with `millturngui`.
#[test]
fn a_program_that_a_hal_file_starts_before_motion_or_the_task_sees_a_machine_in_e_stop() {
    let Some(python) = python() else { return };
    let early = "[HAL]\nHALFILE = early.hal\n";
    for ini in [
        format!("{early}#INCLUDE printer.ini\n[HAL]\nPOSTGUI_HALFILE = end.hal\n"),
        format!("#INCLUDE printer.ini\n{early}POSTGUI_HALFILE = end.hal\n"),
    ] {
        let scratch = Scratch::copy_of(&root().join("configs/printer"));
        scratch.write("early.py", fs::read(folder().join("machine/early.py")).unwrap());
        scratch.write("early.hal", format!("loadusr -Wn early {python} early.py\n"));
        scratch.write("end.hal", "waitusr early\nshutdown\n");
        scratch.write("run.ini", &ini);
        let output = ours(&scratch, &["--virtual", "run.ini"]);
        assert_eq!(output.stdout, EARLY, "{ini}{}", output.stderr);
    }
}

/// Output of the script `machine/taskless.py`.
const TASKLESS: &str = "\
e-stop 1 True 1
polls in between True
snapshot 'motion.status' not found: the scripts of the machine have ended without 'loadrt motmod'
snapshot 'motion.status' not found: the scripts of the machine have ended without 'loadrt motmod'
snapshot 'motion.status' not found: the scripts of the machine have ended without 'loadrt motmod'
connections 1 0
True 1
the last state 1
";

#[test]
fn a_program_of_a_machine_without_a_task_gets_an_error_when_the_scripts_have_ended() {
    let Some(python) = python() else { return };
    let scratch = Scratch::new("python-taskless");
    scratch.write("taskless.py", fs::read(folder().join("machine/taskless.py")).unwrap());
    let threads = "loadrt threads name1=t period1=1000000\nstart\n";
    scratch.write(
        "bare.hal",
        format!("{threads}loadusr -Wn taskless {python} taskless.py\nrun 55ms\n"),
    );
    scratch.write("run.ini", "[EMC]\nVERSION = 1.1\n[HAL]\nHALFILE = bare.hal\n");
    let output = ours(&scratch, &["--virtual", "--for", "100ms", "run.ini"]);
    assert_eq!(output.stdout, TASKLESS, "{}", output.stderr);
}

/// Output of the script `machine/stops.py`.
const STOPS: &str = "\
estop rests True on False e-stop True queue 0
e-stop True True False True nothing 1.0 '' 9
off rests True on False e-stop False queue 0
off False True False True nothing 1.0 '' 9
abort rests True on True e-stop False queue 0
on False True False True nothing 1.0 '' 9
pause rests True on True e-stop False queue 1
on False True True True pause 1.0 '' 9
fields ['feed_override', 'rapid_override', 'state', 'tool_offset', 'wait', 'wait_ends', 'wait_number', 'wait_since'] True
resumed
3 programs need a task, and this machine has none: loadrt task
True
";

#[test]
fn a_program_stops_a_machine_without_a_task() {
    let Some(python) = python() else { return };
    let scratch = Scratch::copy_of(&root().join("configs/rs03n"));
    scratch.write("stops.py", fs::read(folder().join("machine/stops.py")).unwrap());
    scratch.write("run.hal", format!("source rs03n.hal\nloadusr -w {python} stops.py\n"));
    let output = ours(&scratch, &["--simulate", "-f", "run.hal"]);
    assert_eq!(output.stdout, STOPS, "{}", output.stderr);
}

#[test]
fn a_program_that_is_killed_leaves_nothing_behind() {
    let Some(python) = python() else { return };
    let scratch = Scratch::new("python-killed");
    let ready = "h.ready()\nopen('pid', 'w').write(str(__import__('os').getpid()))";
    scratch.write("doubler.py", DOUBLER.replace("h.ready()", ready));
    let program = format!("loadusr -Wn doubler {python} doubler.py");
    scratch.write("run.hal", MACHINE.replace("net s", &format!("{program}\nnet s")));
    let running = scratch.start(scratch.command(&[], "halrun").arg("run.hal"));
    let says = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let output = scratch.halcmd(&words);
        output.stdout.trim().to_owned()
    };
    let count = || says("getp doubler.n").parse::<u32>().unwrap_or(0);
    until("it works", || count() > 10 && !says("gets d").is_empty());
    scratch.run(Command::new("kill").args(["-9", &scratch.read("pid")]));
    until("its pins go", || says("getp doubler.n").is_empty());
    let left = says("show");
    assert!(!left.contains("doubler"), "{left}");
    let value: f64 = says("gets d").parse().unwrap();
    assert!((-2.0..=2.0).contains(&value), "the signal keeps a value that was written");
    // The name is free again.
    says(&program);
    until("another one works", || count() > 0);
    running.signal(Signal::TERM);
    running.wait();
}
