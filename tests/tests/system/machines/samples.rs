//! The sample configurations of LinuxCNC's package: which of them start here without a display, home, and run a program.
//!
//! `UPDATE_EXPECT=1 cargo test -p hal-tests --test system machines::samples -- --ignored` starts each in virtual time and writes
//! `tests/samples.md`.

use hal_tests::{
    golden,
    programs::{files_below, root},
    scratch::Scratch,
};
use std::{collections::BTreeMap, fmt::Write as _, path::Path, process::Command};

const SAMPLES: &str = "/usr/share/doc/linuxcnc/examples/sample-configs";
/// The library of HAL files of the package.
const LIBRARY: &str = "/usr/share/linuxcnc/hallib";

/// A move there and back, in the machine's own units.
const PROGRAM: &str = "G91 G94 F100\nG1 X0.1\nG1 X-0.1\nG90\nM2\n";
/// The same in the other direction, for arms that stand at the end of their reach when they are at home.
const INWARD: &str = "G91 G94 F100\nG1 X-0.1\nG1 X0.1\nG90\nM2\n";

/// Drivers of boards: without the board nothing can be shown.
const BOARDS: [&str; 10] = [
    "hostmot2",
    "hal_ppmc",
    "hal_gm",
    "hal_motenc",
    "pluto_step",
    "pluto_servo",
    "hal_vti",
    "hal_stg",
    "hal_parport_ppmc",
    "opto_ac5",
];

/// Machines that do not run, and what LinuxCNC 2.9 does with them (measured): only what concerns the machine itself.
const WITH_LINUXCNC: &[(&str, &str)] = &[
    ("plasma-thc-sim/plasma_mm.ini", "LinuxCNC does not load trivkins with this parameter, either"),
    ("stepper-gantry/stepper_mm.ini", "LinuxCNC 2.9 has no gantrykins, either"),
    (
        "orphans/axis_noio.ini",
        "LinuxCNC stays in e-stop, too: nothing answers in the place of iocontrol",
    ),
    (
        "pentapod/pentapod.ini",
        "no pose fits its HOME values; LinuxCNC jumps its joints from them to those of the origin",
    ),
    ("qtdragon_xyyz.ini", "LinuxCNC does not find the file, either"),
    (
        "craftsman/craftsmancnc-axis.ini",
        "LinuxCNC wants it to be converted to its present format first",
    ),
    (
        "lathe_configs/lathe_imperial.ini",
        "LinuxCNC does not home it, either: HOME is outside the limits",
    ),
];

/// Lines with these beginnings or parts give no reason.
const NO_REASON: [&str; 8] = [
    "Warning",
    "Traceback",
    "  ",
    "motmod: ",
    "halrun: Warning",
    "hal_manualtoolchange",
    "setup_kins",
    "check_ini_items",
];

/// Returns whether an INI file is that of a machine; the others are parts, or settings of panels.
fn is_machine(path: &Path) -> bool {
    let begins =
        |e: &hal_ini::Entry| ["JOINT_", "AXIS_", "KINS"].iter().any(|s| e.section.starts_with(s));
    hal_ini::Ini::read(path).is_ok_and(|ini| ini.entries().any(begins))
}

/// Returns the kind of failure, and the line that says it.
fn reason(stderr: &str, scratch: &str) -> (String, String) {
    let is_reason =
        |line: &&str| !NO_REASON.iter().any(|n| line.starts_with(n) || line.contains(": Warning"));
    let line =
        stderr.lines().filter(|l| !l.trim().is_empty()).find(is_reason).unwrap_or("no message");
    let line = line.replace(scratch, "").replace('|', "/");
    let line = line.split(" (searched").next().unwrap_or_default().to_owned();
    let has = |part: &str| stderr.contains(part);
    let board = BOARDS.iter().find(|board| line.contains(&format!("{board}: no plugin")));
    let kind = match board {
        Some(_) => "needs a board that is not here",
        None if has("ModuleNotFoundError") => "needs a Python module that is not here",
        None if has("TclError") || has("display") => "needs a display",
        None if has("Tcl file") => "has a HAL file in Tcl",
        None if has("no plugin library offers") => "needs a component that is missing",
        None if has("on limit switch") || has("no home switch") => "waits for its switches",
        None => "other",
    };
    (kind.to_owned(), line.chars().take(160).collect())
}

#[test]
#[ignore = "needs LinuxCNC's package, and takes minutes: cargo test -p hal-tests --test system machines::samples -- --ignored"]
fn the_table_of_sample_configurations_is_true() {
    if !Path::new(SAMPLES).is_dir() {
        return;
    }
    let scratch = Scratch::new("samples");
    let copied = Command::new("cp").args(["-r", SAMPLES]).arg(scratch.path()).status();
    assert!(copied.unwrap().success());
    scratch.write("move.ngc", PROGRAM);
    scratch.write("inward.ngc", INWARD);
    let all = scratch.path().join("sample-configs");
    let files = files_below(&all, ".ini");
    let mut kinds: BTreeMap<String, u32> = BTreeMap::new();
    let mut rows = String::new();
    for path in files.iter().filter(|path| is_machine(path)) {
        let (folder, name) = (path.parent().unwrap(), path.file_name().unwrap());
        let run = |program: &str| {
            let mut command = scratch.command(&["timeout", "60"], "halrun");
            command.env("HALLIB_PATH", LIBRARY).env_remove("DISPLAY").current_dir(folder);
            command.args(["--virtual", "--headless", "--run"]);
            scratch.run(command.arg(scratch.path().join(program)).arg(name))
        };
        let mut output = run("move.ngc");
        if output.stderr.contains("the kinematics cannot go there") {
            output = run("inward.ngc");
        }
        let shown = path.strip_prefix(&all).unwrap().display().to_string();
        let (kind, line) = match output.status {
            Some(0) => ("runs".to_owned(), String::new()),
            Some(124) => ("does not end in a minute".to_owned(), String::new()),
            _ => reason(&output.stderr, &format!("{}/", scratch.path().display())),
        };
        let known = WITH_LINUXCNC.iter().find(|(end, _)| kind != "runs" && shown.ends_with(end));
        let (kind, line) = match known {
            Some((_, why)) => ("does not run with LinuxCNC".to_owned(), format!("{line}: {why}")),
            None => (kind, line),
        };
        writeln!(rows, "| {shown} | {kind} | {line} |").unwrap();
        *kinds.entry(kind).or_default() += 1;
    }
    let mut text = "# Sample configurations\n\nThe machines among the sample configurations of LinuxCNC's package, each started by \
                    `halrun --virtual --headless --run`: out of e-stop, on, homed, and through a program that moves X there and \
                    back (an arm that stands at the end of its reach moves back first). Written by `UPDATE_EXPECT=1 cargo test -p hal-tests --test system machines::samples -- --ignored`; what a \
                    computer lacks (displays, Python modules) depends on it.\n\n| | machines |\n|---|---|\n"
        .to_owned();
    for (kind, count) in &kinds {
        writeln!(text, "| {kind} | {count} |").unwrap();
    }
    write!(text, "\n| configuration | | first message |\n|---|---|---|\n{rows}").unwrap();
    golden::check(&root().join("tests/samples.md"), &text);
}
