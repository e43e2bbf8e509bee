//! Machine tests: those of `configs` pass, and each kind of failure reports the fault, its place, and its amount.
//! `UPDATE_EXPECT=1` writes the expected output; `CASE=value` runs the cases whose names begin with that text.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    golden,
    programs::root,
    scratch::{Output, Scratch},
};
use std::{fs, path::Path};

/// Runs haltest in the workspace's folder.
fn haltest(scratch: &Scratch, words: &[&str]) -> Output {
    let mut command = scratch.command(&[], "haltest");
    scratch.run(command.args(words).current_dir(root()))
}

/// Returns the tests in a folder, by name.
fn tests(folder: &Path) -> Vec<String> {
    let wanted = std::env::var("CASE").unwrap_or_default();
    let paths = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let tests = paths.filter(|p| p.extension().is_some_and(|e| e == "toml"));
    let mut names: Vec<String> =
        tests.map(|p| p.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    names.retain(|n| n.starts_with(&wanted));
    names.sort();
    names
}

#[test]
fn the_machines_pass_with_the_same_bytes_one_by_one_and_ten_at_once() {
    let scratch = Scratch::new("machines");
    let run = |jobs: &str, name: &str| {
        let junit = scratch.path().join(name);
        let output =
            haltest(&scratch, &["-j", jobs, "--junit", junit.to_str().unwrap(), "configs"]);
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""), "{}", output.stdout);
        (output.stdout, scratch.read(name))
    };
    let first = run("1", "one.xml");
    let again = run("10", "ten.xml");
    assert_eq!(first, again);
    assert!(
        first.0.lines().filter(|l| l.contains("configs/printer/")).count() >= 15,
        "{}",
        first.0
    );
}

#[test]
fn each_kind_of_failure_says_what_is_wrong() {
    let folder = root().join("tests/haltest");
    let scratch = Scratch::new("failures");
    let wrong: Vec<String> = tests(&folder)
        .iter()
        .filter_map(|name| {
            let output = haltest(&scratch, &[&format!("tests/haltest/{name}.toml")]);
            let good = name.starts_with("good") || name == "refused-as-expected";
            assert_eq!(output.status, Some(i32::from(!good)), "{name}: {}", output.stdout);
            let status = output.status.map_or("a signal".to_owned(), |s| s.to_string());
            let text = format!("{}{}status {status}\n", output.stdout, output.stderr);
            golden::compare(&folder.join(format!("{name}.expected")), &text).err()
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_longer_set_up_of_the_direction_is_a_moved_edge() {
    let scratch = Scratch::new("dirsetup");
    let text = fs::read_to_string(root().join("configs/printer/tests/reversal.toml")).unwrap();
    let machine = root().join("configs/printer/printer.ini");
    let text = text.replace("../printer.ini", machine.to_str().unwrap());
    // One base period more: 131.732 us are rounded up to two.
    let longer = text.replace("maxaccel 0\n", "maxaccel 0\nsetp stepgen.0.dirsetup 131732\n");
    assert!(longer != text);
    scratch.write("reversal.toml", longer);
    let kept = "reversal.turn.wave";
    scratch.write(kept, fs::read(root().join("configs/printer/tests").join(kept)).unwrap());
    let output = scratch.run(scratch.command(&[], "haltest").arg("reversal.toml"));
    let path = root().join("tests/haltest/dirsetup.shown");
    golden::check(&path, &output.stdout);
    assert_eq!((output.status, output.stderr.as_str()), (Some(1), ""));
}

/// Creates a folder with a machine and tests of it.
fn bench(name: &str, tests: &[(&str, &str)]) -> Scratch {
    let scratch = Scratch::new(name);
    scratch.write("bench.hal", fs::read(root().join("tests/haltest/bench.hal")).unwrap());
    for (name, text) in tests {
        scratch.write(name, format!("machine = \"bench.hal\"\n{text}"));
    }
    scratch
}

const PICTURE: &str =
    "[[step]]\nrun = \"2ms\"\n\n[[snapshot]]\nname = \"pump\"\nchannels = [\"pump\"]\n";

#[test]
fn snapshots_are_accepted_only_when_all_else_is_right() {
    let scratch = bench(
        "accept",
        &[
            ("good.toml", PICTURE),
            ("bad.toml", &format!("{PICTURE}\n[[expect]]\nnever = \"pump\"\n")),
        ],
    );
    let run = |words: &[&str]| scratch.run(scratch.command(&[], "haltest").args(words));
    let output = run(&["--accept", "."]);
    assert_eq!(output.status, Some(1), "{}", output.stdout);
    assert!(output.stdout.contains("  accepted: ./good.pump.wave\n"), "{}", output.stdout);
    assert!(output.stdout.contains("its waveforms are not accepted"), "{}", output.stdout);
    let files = scratch.files();
    assert!(files.contains_key("good.pump.wave") && !files.contains_key("bad.pump.wave"));
    assert_eq!(run(&["good.toml"]).status, Some(0));
    let kept = scratch.read("good.pump.wave");
    assert!(kept.starts_with("pump  _/‾400‾"), "{kept}");
    // An unchanged waveform stays as it is when accepted again, and a changed one is updated.
    scratch.write("good.pump.wave", kept.replace("400", "500"));
    assert_eq!(run(&["good.toml"]).status, Some(1));
    assert_eq!(run(&["good.toml", "--accept"]).status, Some(0));
    assert_eq!(scratch.read("good.pump.wave"), kept);
}

#[test]
fn a_failed_expectation_hides_no_other() {
    let scratch = bench(
        "hides",
        &[
            (
                "all.toml",
                "[[step]]\nexpect = { pump = 1, pulse = 1 }\n\n[[step]]\nrun = \"1ms\"\n\n\
                 [[step]]\nexpect = { position = 7 }\n\n[[expect]]\nnever = \"pump\"\n",
            ),
            (
                "ends.toml",
                "[[step]]\ndo = \"setp nothing 1\"\n\n[[step]]\nrun = \"1ms\"\n\n[[expect]]\n\
                 never = \"pump\"\n",
            ),
        ],
    );
    let run = |file| scratch.run(scratch.command(&[], "haltest").arg(file)).stdout;
    golden::check(
        &root().join("tests/haltest/hides.shown"),
        &(run("all.toml") + &run("ends.toml")),
    );
}

#[test]
fn a_test_that_hangs_or_dies_takes_no_other_with_it() {
    let scratch = bench(
        "hang",
        &[
            ("dies.toml", "[[step]]\ndo = \"loadusr -w sh dies.sh\"\n"),
            ("good.toml", "[[step]]\nrun = \"1ms\"\n"),
            ("hangs.toml", "[[step]]\ndo = \"loadusr -w sleep 1000\"\n"),
        ],
    );
    scratch.write("dies.sh", "kill -9 $PPID\n");
    let run = |words: &[&str]| {
        let output = scratch.run(scratch.command(&[], "haltest").args(words));
        assert_eq!((output.status, output.stderr.as_str()), (Some(1), ""));
        output.stdout
    };
    let want = "\
FAIL  dies.toml (0 ns)
  dies.toml:1: the process of the test was ended by signal 9
ok    good.toml (1 ms)
2 tests, 1 failed, 1 ms of machine time
";
    assert_eq!(run(&["-j2", "dies.toml", "good.toml"]), want);
    let want = "\
FAIL  hangs.toml (0 ns)
  hangs.toml:1: aborted: the test did not end within 500 ms of wall-clock time
1 test, 1 failed, 0 ns of machine time
";
    assert_eq!(run(&["hangs.toml", "--timeout", "500ms"]), want);
}

#[test]
fn what_the_program_lists_writes_and_refuses() {
    let scratch = bench(
        "program",
        &[
            ("one.toml", PICTURE),
            ("two.toml", "[[step]]\nrun = \"1ms\"\n\n[[expect]]\nnever = \"pump\"\n"),
        ],
    );
    let run = |words: &[&str]| {
        let o = scratch.run(scratch.command(&[], "haltest").args(words));
        (o.stdout, o.stderr, o.status)
    };
    assert_eq!(run(&["--list", "."]).0, "./one.toml\n./two.toml\n");
    assert_eq!(run(&["--list", ".", "--filter", "tw"]).0, "./two.toml\n");
    let usage = "\n\nFor usage try: haltest -h\n";
    for (words, text) in [
        (&[][..], "haltest: which tests? Name a folder or a file"),
        (&["none"], "haltest: none: No such file or directory"),
        (&[".run"], "haltest: no tests in .run"),
        (&["--filter", "x/y", "."], "haltest: none of 2 tests has 'x/y' in its name"),
        (&["-j0", "."], "haltest: -j '0': it is a number, 1 or more"),
        (&["--frob"], "haltest: unrecognized option '--frob'"),
    ] {
        let (out, err, status) = run(words);
        assert_eq!((out.as_str(), err, status), ("", format!("{text}{usage}"), Some(2)));
    }
    let (out, _, status) = run(&["--json", "--record", "kept", "--junit", "out.xml", "."]);
    assert_eq!(status, Some(1));
    let objects: Vec<serde_json::Value> =
        out.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(objects.len(), 2);
    assert_eq!(objects[1]["complaints"][0]["spot"]["line"], 5);
    assert!(scratch.read("kept/one.vcd").contains("pump"));
    let xml = scratch.read("out.xml");
    for part in ["<testsuites", "tests=\"2\"", "failures=\"2\"", "name=\"one\"", "two.toml:5: "] {
        assert!(xml.contains(part), "no {part} in {xml}");
    }
    assert!(run(&["-h"]).0.contains("--accept"));
}

/// Returns the manual page on the format.
fn page() -> String {
    fs::read_to_string(root().join("halcmd/README.md")).unwrap()
}

#[test]
fn the_example_of_the_page_runs() {
    let page = page();
    let mut examples = page.split("```toml\n").filter_map(|part| part.split("```").next());
    let example = examples.find(|e| e.starts_with("about = ")).unwrap();
    let machine = root().join("configs/mill/mill.ini");
    let scratch = Scratch::new("example");
    let text = example.replace("../mill.ini", machine.to_str().unwrap());
    scratch.write("example.toml", text);
    let output = scratch.run(scratch.command(&[], "haltest").args(["--accept", "example.toml"]));
    assert_eq!(output.status, Some(0), "{}{}", output.stdout, output.stderr);
}

#[test]
fn the_page_has_every_key() {
    let page = page();
    let scratch = bench(
        "keys",
        &[
            ("a.toml", "zzzzzz = 1\n"),
            ("b.toml", "[[step]]\nzzzzzz = 1\n"),
            ("c.toml", "[[expect]]\nzzzzzz = 1\n"),
            ("d.toml", "[[snapshot]]\nzzzzzz = 1\n"),
        ],
    );
    let output = scratch.run(scratch.command(&[], "haltest").args(["-j1", "."]));
    let lists = output.stdout.lines().filter_map(|l| l.split_once("the keys here are "));
    let keys: Vec<&str> = lists.flat_map(|(_, keys)| keys.split(", ")).collect();
    assert!(keys.len() > 50, "{}", output.stdout);
    for key in keys {
        let known = ["step", "expect", "snapshot"].contains(&key)
            || page.contains(&format!("`{key}`"))
            || page.contains(&format!("\n{key} = "));
        assert!(known, "halcmd/README.md says nothing of '{key}'");
    }
}
