//! The sample configurations of LinuxCNC's package: which of them start here without a display, home, and run a program.
//!
//! `UPDATE_EXPECT=1 cargo test -p hal-tests --test system machines::samples -- --ignored` starts each in virtual time and writes
//! `tests/samples.md`.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    golden,
    programs::{files_below, root},
    scratch::Scratch,
};
use std::{collections::BTreeMap, fmt::Write as _, fs, path::Path, process::Command};

const SAMPLES: &str = "/usr/share/doc/linuxcnc/examples/sample-configs";
/// The library of HAL files of the package.
const LIBRARY: &str = "/usr/share/linuxcnc/hallib";

/// A move there and back, in the machine's own units.
const PROGRAM: &str = "G91 G94 F100\nG1 X0.1\nG1 X-0.1\nG90\nM2\n";

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

/// Lines with these beginnings or parts give no reason.
const NO_REASON: [&str; 6] =
    ["Warning", "Traceback", "  ", "motmod: ", "halrun: Warning", "hal_manualtoolchange"];

/// Returns whether an INI file is that of a machine; the others are parts, or settings of panels.
fn is_machine(path: &Path) -> bool {
    let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    let begins = |line: &str| ["[JOINT_", "[AXIS_", "[KINS"].iter().any(|s| line.starts_with(s));
    text.lines().any(|line| begins(line.trim()))
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
    let all = scratch.path().join("sample-configs");
    let files = files_below(&all, ".ini");
    let mut kinds: BTreeMap<String, u32> = BTreeMap::new();
    let mut rows = String::new();
    for path in files.iter().filter(|path| is_machine(path)) {
        let (folder, name) = (path.parent().unwrap(), path.file_name().unwrap());
        let mut command = scratch.command(&["timeout", "60"], "halrun");
        command.env("HALLIB_PATH", LIBRARY).env_remove("DISPLAY").current_dir(folder);
        command
            .args(["--virtual", "--headless", "--run"])
            .arg(scratch.path().join("move.ngc"))
            .arg(name);
        let output = scratch.run(&mut command);
        let shown = path.strip_prefix(&all).unwrap().display().to_string();
        let (kind, line) = match output.status {
            Some(0) => ("runs".to_owned(), String::new()),
            Some(124) => ("does not end in a minute".to_owned(), String::new()),
            _ => reason(&output.stderr, &format!("{}/", scratch.path().display())),
        };
        writeln!(rows, "| {shown} | {kind} | {line} |").unwrap();
        *kinds.entry(kind).or_default() += 1;
    }
    let mut text = "# Sample configurations\n\nThe machines among the sample configurations of LinuxCNC's package, each started by \
                    `halrun --virtual --headless --run`: out of e-stop, on, homed, and through a program that moves X there and \
                    back. Written by `UPDATE_EXPECT=1 cargo test -p hal-tests --test system machines::samples -- --ignored`; what a \
                    computer lacks (displays, Python modules) depends on it.\n\n| | machines |\n|---|---|\n"
        .to_owned();
    for (kind, count) in &kinds {
        writeln!(text, "| {kind} | {count} |").unwrap();
    }
    write!(text, "\n| configuration | | first message |\n|---|---|---|\n{rows}").unwrap();
    golden::check(&root().join("tests/samples.md"), &text);
}
