//! Memory of a machine: earlier states of its files, and tests of a machine that has been used.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    programs::root,
    scratch::{Output, Scratch},
};
use std::{collections::BTreeMap, fs, path::Path};

/// Returns a folder with a copy of the printer.
fn with_printer(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    let from = root().join("configs/printer");
    for file in ["printer.ini", "printer.hal", "custom.hal", "custom_postgui.hal", "tool.tbl"] {
        fs::copy(from.join(file), scratch.path().join(file)).unwrap();
    }
    scratch
}

fn ferrule(scratch: &Scratch, words: &[&str]) -> Output {
    scratch.run(scratch.command(&[], "ferrule").args(words))
}

/// Runs lines as a program on the machine in virtual time.
fn run(scratch: &Scratch, lines: &str) {
    scratch.write("job.ngc", format!("{lines}\nM2\n"));
    let words = ["--virtual", "--headless", "--run", "job.ngc", "printer.ini"];
    let output = scratch.run(scratch.command(&[], "halrun").args(words));
    assert_eq!(output.status, Some(0), "{output:?}");
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let files = entries.filter(|entry| entry.path().is_file());
    files.map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap())).collect()
}

#[test]
fn a_tool_table_and_parameters_that_a_program_changed_come_back() {
    let scratch = with_printer("restore");
    let new = ferrule(&scratch, &["restore", "printer.ini"]);
    assert_eq!(new.stdout, "printer.ini: none of its files has an earlier state\n");
    let first = scratch.read("tool.tbl");
    run(&scratch, "G10 L1 P1 Z-12.5\nG10 L2 P1 X7");
    let parameters = scratch.read("linuxcnc.var");
    run(&scratch, "G10 L2 P1 X9");
    let second = scratch.read("tool.tbl");
    assert_ne!(first, second);

    let list = ferrule(&scratch, &["restore", "printer.ini"]);
    let named: Vec<&str> =
        list.stdout.lines().filter_map(|l| l.split_whitespace().next()).collect();
    assert_eq!(
        named,
        ["file", "linuxcnc.var", "linuxcnc.var", "tool.tbl", "'ferrule"],
        "{}",
        list.stdout
    );

    let compared = ferrule(&scratch, &["restore", "printer.ini", "tool.tbl", "1", "--compare"]);
    assert!(compared.stdout.starts_with("--- tool.tbl (now)\n+++ tool.tbl (state 1)\n"));
    assert!(compared.stdout.contains("-12.5") && compared.status == Some(0), "{compared:?}");
    assert_eq!(scratch.read("tool.tbl"), second, "a comparison writes nothing");

    // Without an answer nothing is written.
    let asked = ferrule(&scratch, &["restore", "printer.ini", "tool.tbl", "1"]);
    assert_eq!(asked.status, Some(1), "{asked:?}");
    assert_eq!(scratch.read("tool.tbl"), second);

    for (file, number, before) in [("tool.tbl", 1, &first), ("linuxcnc.var", 2, &parameters)] {
        let now = scratch.read(file);
        let back =
            ferrule(&scratch, &["restore", "printer.ini", file, &number.to_string(), "--yes"]);
        assert!(
            back.stdout.ends_with(&format!("the file that it replaced is state {}\n", number + 1)),
            "{back:?}"
        );
        assert_eq!(&scratch.read(file), before);
        // A restoration can be undone.
        let again = ferrule(
            &scratch,
            &["restore", "printer.ini", file, &format!("{}", number + 1), "--yes"],
        );
        assert_eq!(again.status, Some(0), "{again:?}");
        assert_eq!(scratch.read(file), now);
    }

    let refusals = [
        ("other.tbl", "1", "other.tbl: is none of the machine's files with states, which are: "),
        ("tool.tbl", "77", "tool.tbl: has no state 77: it has 1, 2, 3"),
        ("printer.ini", "1", "printer.ini: has no state 1: it has none"),
    ];
    for (file, number, why) in refusals {
        let refused = ferrule(&scratch, &["restore", "printer.ini", file, number, "--yes"]);
        assert_eq!(refused.status, Some(1));
        assert!(refused.stderr.starts_with(&format!("ferrule: {why}")), "{}", refused.stderr);
    }
}

#[test]
fn nothing_is_written_back_under_a_running_machine() {
    let scratch = with_printer("restore-runs");
    run(&scratch, "G10 L1 P1 Z-12.5");
    let second = scratch.read("tool.tbl");
    let started = scratch.run(scratch.command(&[], "halrun").args([
        "--virtual",
        "--headless",
        "--detach",
        "printer.ini",
    ]));
    assert_eq!(started.status, Some(0), "{started:?}");
    let refused = ferrule(&scratch, &["restore", "printer.ini", "tool.tbl", "1", "--yes"]);
    assert!(refused.stderr.contains("runs and writes its files itself"), "{refused:?}");
    assert_eq!((refused.status, scratch.read("tool.tbl")), (Some(1), second));
    let ended = scratch.run(scratch.command(&[], "halrun").arg("-U"));
    assert_eq!(ended.status, Some(0), "{ended:?}");
    let back = ferrule(&scratch, &["restore", "printer.ini", "tool.tbl", "1", "--yes"]);
    assert_eq!(back.status, Some(0), "{back:?}");
}

/// A test that passes on a new machine alone: without offsets, without a tool, with the tool table as it is.
const TEST: &str = r#"
about = "a new machine"
machine = "printer.ini"

[[step]]
do = """
iocontrol.estop-reset --wait
motion.enable --wait
motion.home joint=all --wait
task.mode mode=mdi --wait
task.mdi text='G0 X20' --wait
"""

[[step]]
expect = { "axis.0.motor-pos-cmd" = 20, "iocontrol.0.tool-number" = 0 }

[[step]]
do = "task.mdi text='G10 L1 P1 Z-3' --wait"
"#;

/// Walks a machine with its files beside the INI file, and one that has them in a folder below.
#[test]
fn the_tests_of_a_used_machine_begin_as_those_of_a_new_one_and_change_nothing() {
    for (name, below) in [("used", ""), ("used-below", "state/")] {
        let scratch = with_printer(name);
        fs::create_dir_all(scratch.path().join(below)).unwrap();
        let (table, parameters) = (format!("{below}tool.tbl"), format!("{below}linuxcnc.var"));
        fs::rename(scratch.path().join("tool.tbl"), scratch.path().join(&table)).unwrap();
        let ini = scratch.read("printer.ini").replace("= tool.tbl", &format!("= {table}"));
        scratch.write("printer.ini", ini.replace("= linuxcnc.var", &format!("= {parameters}")));
        scratch.write("printer-new.toml", TEST);
        let haltest = || scratch.run(scratch.command(&[], "haltest").args(["printer-new.toml"]));
        let new = haltest();
        assert_eq!(new.status, Some(0), "{new:?}");
        // A record of the tool in the spindle beside the table, as earlier versions have left it.
        scratch.write(&format!("{table}.spindle"), "tool 1 #51c15fcca7506bdc\n");
        run(&scratch, "G10 L2 P1 X5 Z40\nG10 L1 P1 Z-12.5");
        assert!(scratch.read(&parameters).contains("5221\t5"));
        let state = scratch.path().join(below);
        let before = (files(scratch.path()), files(&state));
        let used = haltest();
        assert_eq!((used.status, &used.stdout), (Some(0), &new.stdout), "{used:?}");
        assert_eq!((files(scratch.path()), files(&state)), before);
    }
}
