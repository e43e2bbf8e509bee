//! Programs of users in C and Python: the client of `ferrule.h`, the socket, machines in tests.
#![expect(clippy::unwrap_used, reason = "tests")]

use super::python::python;
use hal_tests::{
    programs::{programs, root},
    scratch::Scratch,
    tools::{Tool, compiler},
};
use std::{fs, process::Command};

const MACHINE: &str =
    "loadrt threads name1=t period1=1000000\nnewsig sum float\nsets sum 1.25\nstart\n";

/// Parts of the output of the example.
const SEEN: [&str; 3] = ["sum", "2.5", "'no-such-name'"];

/// Returns a folder in which the machine runs, and the machine.
fn running() -> (Scratch, hal_tests::scratch::Running) {
    let scratch = Scratch::new("programs");
    scratch.write("run.hal", MACHINE);
    let running = scratch.start(scratch.command(&[], "halrun").args(["--virtual", "run.hal"]));
    hal_tests::scratch::until("it runs", || {
        scratch.halcmd(&["gets", "sum"]).stdout.trim() == "1.25"
    });
    (scratch, running)
}

#[test]
fn the_example_in_c_reads_and_sets_values() {
    let Some(cc) = compiler() else { return };
    let (scratch, _running) = running();
    let folder = root().join("components/foreign/compat");
    let mut command = Command::new(cc);
    command.args(["-Wall", "-Wextra", "-Werror", "-I"]).arg(folder.join("include"));
    command.arg(folder.join("examples/values.c")).arg("-L").arg(programs());
    command.arg("-lferrule_client").arg(format!("-Wl,-rpath,{}", programs().display()));
    command.args(["-o", "values"]).current_dir(scratch.path());
    let built = scratch.run(&mut command);
    assert_eq!(built.status, Some(0), "{}", built.stderr);
    let program = scratch.path().join("values");
    let output = scratch.run(scratch.command(&[], program.to_str().unwrap()).arg("sum"));
    let lines: Vec<&str> = output.stdout.lines().collect();
    assert_eq!(lines[..2], ["sum = 1.25", "sum = 2.5"], "{output:?}");
    assert!(lines[2].contains("'no-such-name'"), "{output:?}");
    assert_eq!(lines[3..], [r#"{"ok":{"value":{"float":2.5}}}"#, "refused: no such request"]);
    // Without the instance, the reason is that of every program.
    let alone = Scratch::new("programs-alone");
    let refused = alone.run(alone.command(&[], program.to_str().unwrap()).arg("sum"));
    assert_eq!(refused.status, Some(1));
    assert!(refused.stderr.contains("no instance"), "{refused:?}");
}

#[test]
fn the_example_of_the_socket_reads_and_sets_values() {
    let Some(python) = python() else { return };
    let (scratch, _running) = running();
    let example = root().join("components/foreign/compat/examples/over_socket.py");
    let output = scratch.run(scratch.command(&[], python).arg(example).arg("sum"));
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    for part in SEEN {
        assert!(output.stdout.contains(part), "{output:?}");
    }
}

/// Output of `tests/python/tests/plain.py`.
const PLAIN: &str = "\
2.0 0.0 False
['and2.0.in0', 'and2.0.in1', 'and2.0.out', 'sum', 'wave']
[0.101] 0.0 2.5
[0.001, 0.5, 1.0] 1.000
True 11 True
AttributeError the machine has no pin, parameter or signal 'nothing'
Refused parameter or pin 'nothing': not found
Refused pin 'and2.0.in0': invalid argument
ValueError '3 weeks' is no time: use seconds, or a text such as '20ms' (ns, us, ms, s, min, h)
KeyError \"'nothing' was not recorded: there are and2.0.in0, and2.0.in1, and2.0.out, sum, wave\"
AssertionError none.txt: there is no such file
Refused command 'task.nothing' not found
AttributeError 'a_b' is a method, or the name of several: write machine[\"NAME\"]
AttributeError 'run' is a method, or the name of several: write machine[\"NAME\"]
FileNotFoundError bad.hal: there is no such file
Refused :1: nothing_here: no plugin library offers this component
";

fn in_python(python: &str, words: &[&str]) -> hal_tests::scratch::Output {
    let scratch = Scratch::new("python-machine");
    let from = root().join("tests/python/tests");
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        scratch.write(&name, fs::read(&path).unwrap());
    }
    let mut command = scratch.command(&[], python);
    command.env("PYTHONPATH", programs().join("python")).env("PYTHONDONTWRITEBYTECODE", "1");
    scratch.run(command.args(words))
}

#[test]
fn a_machine_in_python_has_pins_waveforms_and_refusals() {
    let Some(python) = python() else { return };
    let output = in_python(python, &["plain.py"]);
    assert_eq!(output.stdout, PLAIN, "{}", output.stderr);
}

#[test]
fn the_plugin_of_pytest_makes_a_machine_for_each_test() {
    let runs = |name: &&str| {
        let mut command = Command::new(name);
        let output = command.args(["-c", "import pytest"]).output();
        output.is_ok_and(|o| o.status.success())
    };
    let found = ["python3", "/usr/bin/python3"].into_iter().find(runs);
    let Some(python) = Tool::of("pytest").or_skip(found) else { return };
    let words = ["-m", "pytest", "-q", "-p", "ferrule.plugin", "-p", "no:cacheprovider"];
    let output = in_python(python, &words);
    assert_eq!(output.status, Some(0), "{}{}", output.stdout, output.stderr);
    assert!(output.stdout.contains("2 passed"), "{}", output.stdout);
}
