//! LinuxCNC's program halshow, unchanged, on a screen without a monitor.

use hal_tests::{
    programs::root,
    scratch::Scratch,
    tools::{Tool, linuxcnc},
};
use std::{fs, process::Command};

/// The program reads preferences at its start, as a file of Tcl: `tests/halshow/halshow.preferences` does there what a person
/// does in the window, and writes what the window shows.
#[test]
fn halshow_of_the_package_shows_pins_and_executes_commands() {
    if linuxcnc().is_none() {
        return;
    }
    let runs = |program: &&str| Command::new(program).arg("--help").output().is_ok();
    if Tool::of("xvfb-run").or_skip(Some("xvfb-run").filter(runs)).is_none() {
        return;
    }
    let folder = root().join("tests/halshow");
    let scratch = Scratch::copy_of(&folder);
    let mut command = scratch.command(&[], "halrun");
    command.args(["--virtual", "-f", "test.hal"]).env("CONFIG_DIR", scratch.path());
    let run = scratch.run(command.env("LANG", "C").env_remove("DISPLAY"));
    assert_eq!(run.status, Some(0), "{run:?}");
    let expected = fs::read_to_string(folder.join("expected")).unwrap();
    assert_eq!(scratch.read("seen"), expected, "{run:?}");
}
