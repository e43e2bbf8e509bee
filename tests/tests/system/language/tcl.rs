//! Every folder of `tests/tcl`: Tcl files as HAL files, the program haltcl, two passes, and what `check` says of Tcl files.

use hal_tests::{
    case::{Case, cases_in, for_each},
    programs::programs,
    scratch::Scratch,
    tools::{Tool, tclsh},
};
use std::{fs, process::Command};

#[test]
fn tcl_files_do_what_is_expected() {
    if Tool::of("tclsh").or_skip(tclsh()).is_none() {
        return;
    }
    let cases = cases_in("tests/tcl");
    assert!(!cases.is_empty(), "no case of this name");
    for_each(&cases, Case::check);
}

/// Starts a Tcl file with this program; returns the message.
fn refused(scratch: &Scratch, halrun: &mut Command) -> String {
    scratch.write("m.tcl", "loadrt threads\n");
    let run = scratch.run(halrun.args(["--virtual", "m.tcl"]).env("PATH", "/nonexistent"));
    assert_ne!(run.status, Some(0), "{run:?}");
    run.stderr
}

#[test]
fn a_computer_without_tclsh_is_refused_by_name() {
    let scratch = Scratch::new("no-tclsh");
    let said = refused(&scratch, &mut scratch.command(&[], "halrun"));
    assert!(said.contains("Tcl files need tclsh, which is not installed"), "{said}");
}

#[test]
fn a_folder_of_programs_without_the_package_for_tcl_is_refused_by_name() {
    let scratch = Scratch::new("no-package");
    let own = scratch.path().join("halrun");
    fs::copy(programs().join("halrun"), &own).unwrap();
    let said = refused(&scratch, Command::new(own).current_dir(scratch.path()));
    assert!(said.contains("Ferrule's package for Tcl is not in '"), "{said}");
}

#[test]
fn the_prompt_of_tcl_reads_its_input_after_a_script() {
    if Tool::of("tclsh").or_skip(tclsh()).is_none() {
        return;
    }
    let scratch = Scratch::new("tcl-prompt");
    // A program of the script that has ended before takes nothing away from the prompt.
    scratch.write("m.hal", "loadrt threads\nloadusr -w true\nloadusr true\nnewsig x float\n");
    // LinuxCNC's library is asked for twice, with a scan of packages between: the command stays Ferrule's.
    let load = "load /nowhere/hal.so\ncatch {package require Nothing}\n";
    scratch.write("said", format!("{load}{load}hal sets x 2.5\nputs [hal gets x]\n"));
    let mut command = scratch.command(&[], "halrun");
    command.args(["--virtual", "-T", "m.hal"]);
    command.stdin(fs::File::open(scratch.path().join("said")).unwrap());
    let run = scratch.run(&mut command);
    assert!(run.stdout.contains("2.5") && !run.stderr.contains("rename"), "{run:?}");
}
