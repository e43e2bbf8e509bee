//! Functions in Python that programs call, on a whole machine.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, tools::Tool};
use std::fs;

/// The machine of the printer's part, with functions of the tests of `hal-job`.
const INI: &str = "#INCLUDE pedal.ini
[PYTHON]
PATH_PREPEND = python
TOPLEVEL = python/toplevel.py
TIMEOUT = 2
[RS274NGC]
SUBROUTINE_PATH = .
REMAP = M402 modalgroup=10 argspec=p prolog=before ngc=around epilog=behind
REMAP = M406 modalgroup=10 py=endless
REMAP = M407 modalgroup=10 py=crashes
REMAP = G88.6 modalgroup=1 argspec=XYzp py=spiral
";

fn machine(program: &str) -> Option<Scratch> {
    if !Tool::of("python3").is_installed() {
        return None;
    }
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    let from = root().join("components/motion/job/tests/functions");
    fs::create_dir_all(scratch.path().join("python")).unwrap();
    for file in ["python/toplevel.py", "python/remap.py", "python/oword.py", "around.ngc"] {
        scratch.write(file, fs::read(from.join(file)).unwrap());
    }
    scratch.write("run.ini", INI);
    scratch.write("job.ngc", program);
    Some(scratch)
}

#[test]
fn a_program_that_calls_functions_gives_the_same_bytes_twice() {
    let program =
        "G21 G64 F600\nG88.6 X2 Y4\nG1 X5\no<yields> call\nG1 X[#<_value>]\nM402 P1\nM2\n";
    let run = || {
        let scratch = machine(program)?;
        let output = scratch.halrun(&["--virtual", "--run", "job.ngc", "run.ini"]);
        assert_eq!(output.status, Some(0), "{}", output.stderr);
        Some((output.stderr, scratch.read("pedal.vcd")))
    };
    let Some(first) = run() else { return };
    assert!(first.0.contains("behind: value 6 of True, given 3"), "{}", first.0);
    // The place of X behind the call is the value of the function.
    assert!(first.0.contains("ended after 1.620 s"), "{}", first.0);
    assert_eq!(run(), Some(first));
}

#[test]
fn a_function_that_asks_the_instance_on_the_virtual_clock_fails_at_once() {
    for (statement, error) in [
        ("import linuxcnc; linuxcnc.stat().poll()", "linuxcnc.error: "),
        ("import hal; hal.component('c')", "hal.error: "),
    ] {
        let Some(scratch) = machine("G21 F600\nG1 X2\nM406\nG1 X9\nM2\n") else { return };
        scratch
            .write("python/remap.py", format!("calls = 0\ndef endless(self):\n    {statement}\n"));
        let output = scratch.halrun(&["--virtual", "--run", "job.ngc", "run.ini"]);
        assert_eq!(output.status, Some(1), "{}", output.stderr);
        let said = format!("{}{}", output.stdout, output.stderr);
        assert!(
            said.contains("on the virtual clock the instance stands still"),
            "{statement}: {said}"
        );
        assert!(said.contains(error), "{statement}: {said}");
        // Not after TIMEOUT.
        assert!(!said.contains("it made no step"), "{statement}: {said}");
    }
}

#[test]
fn a_function_that_crashes_or_never_ends_is_an_error_at_its_line() {
    for (code, wanted) in [
        ("M406", "job.ngc:3: endless: it made no step within 2 s ([PYTHON]TIMEOUT) and was ended"),
        ("M407", "job.ngc:3: crashes: the process of the functions has ended: signal: 9 (SIGKILL)"),
    ] {
        let Some(scratch) = machine(&format!("G21 F600\nG1 X2\n{code}\nG1 X9\nM2\n")) else {
            return;
        };
        let output = scratch.halrun(&["--virtual", "--run", "job.ngc", "run.ini"]);
        assert_eq!(output.status, Some(1), "{}", output.stderr);
        assert!(output.stderr.contains(wanted), "{}", output.stderr);
    }
}
