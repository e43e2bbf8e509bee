//! Tests of a computer and of an axis, before a machine is written: `latency-test`, and `halsetup --test`.
#![expect(clippy::indexing_slicing, reason = "tests")]

use hal_tests::{
    golden,
    programs::root,
    scratch::{Output, Scratch},
};
use serde_json::Value;
use std::fs::{self, File};

fn run(scratch: &Scratch, line: &str) -> Output {
    let words: Vec<&str> = line.split(' ').collect();
    scratch.run(scratch.command(&[], words[0]).args(&words[1..]))
}

#[test]
fn a_virtual_computer_is_exactly_regular() {
    let scratch = Scratch::new("latency");
    let output = run(&scratch, "latency-test --virtual --for 50ms");
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    golden::check(&root().join("tests/setup/latency.expected"), &output.stdout);
    let output = run(&scratch, "latency-test --virtual --for 50ms --json 1ms");
    let said: Value = serde_json::from_str(&output.stdout).unwrap();
    let thread = &said["threads"][0];
    assert_eq!(thread["period"], 1_000_000);
    assert_eq!((&thread["max_jitter"], &thread["verdict"]), (&0.0.into(), &"very-good".into()));
}

#[test]
fn a_real_computer_has_a_verdict() {
    let scratch = Scratch::new("latency-real");
    let output = run(&scratch, "latency-test --for 300ms --json 1ms");
    assert_eq!(output.status, Some(0), "{output:?}");
    let said: Value = serde_json::from_str(&output.stdout).unwrap();
    let thread = &said["threads"][0];
    // As irregular as it is while other tests run: it was measured, and the verdict is that of the figure.
    let jitter = thread["max_jitter"].as_f64().unwrap();
    assert!(0.0 < jitter, "{said}");
    assert_eq!(thread["verdict"] == "very-good", jitter <= 20_000.0, "{said}");
    assert_eq!(thread["verdict"] == "not-suitable", jitter > 100_000.0, "{said}");
    let wrong = run(&scratch, "latency-test 2us");
    assert_eq!(wrong.status, Some(1));
    assert!(wrong.stderr.starts_with("latency-test: period '2us': from 5us to 1s"), "{wrong:?}");
}

/// Searches an axis of the printer of the document.
fn search(options: &str) -> Output {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    run(&scratch, &format!("halsetup printer.setup {options}"))
}

#[test]
fn the_search_ends_at_the_figures_of_the_document() {
    let mut told = String::new();
    for (axis, options) in [
        ("X", "--simulate 100,1600 --amplitude 95 --velocity-step 10 --acceleration-step 100"),
        ("Y", "--simulate 100,1600 --amplitude 95 --velocity-step 10 --acceleration-step 100"),
        ("Z", "--simulate 15,45 --amplitude 45 --velocity-step 3 --acceleration-step 5"),
    ] {
        let output = search(&format!("--test {axis} {options}"));
        assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{axis}");
        told.push_str(&output.stdout);
    }
    for figures in [
        "axis X\n  velocity: 90 mm/s held, 100 lost steps\n  acceleration: 1500 mm/s^2 held, 1600 lost steps",
        "axis Y\n  velocity: 90 mm/s held, 100 lost steps\n  acceleration: 1500 mm/s^2 held, 1600 lost steps",
        "axis Z\n  velocity: 12 mm/s held, 15 lost steps\n  acceleration: 40 mm/s^2 held, 45 lost steps",
    ] {
        assert!(told.contains(figures), "{told}");
    }
    golden::check(&root().join("tests/setup/search.expected"), &told);
}

#[test]
fn a_person_judges_whether_the_axis_stands_on_its_mark() {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    let asked = |said: &str| {
        scratch.write("said", said);
        let mut command = scratch.command(&[], "halsetup");
        command.args(["printer.setup", "--test", "x", "--virtual", "--velocity-step", "40"]);
        command.args(["--acceleration-step", "800"]);
        scratch.run(command.stdin(File::open(scratch.path().join("said")).unwrap()))
    };
    // 40 and 80 mm/s return to the mark, 120 does not; then 800 mm/s^2 does, 1600 does not.
    let output = asked("\ny\n\ny\n\nn\n\ny\n\nn\n");
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{}", output.stdout);
    golden::check(&root().join("tests/setup/search-asked.expected"), &output.stdout);
    // A person who leaves early gets no figures, and nothing is written.
    for (said, why) in [("\ny\n\nq\n", "was ended"), ("\ny\n", "was not finished")] {
        let output = asked(said);
        assert_eq!(output.status, Some(1), "{said:?}");
        assert!(output.stderr.contains(why), "{}", output.stderr);
    }
}

#[test]
fn a_search_that_cannot_be_is_refused() {
    for (options, why) in [
        ("--test W --simulate 1,1", "--test 'W': the answers have X, Y, Z"),
        ("--test", "test"),
        ("--test X --simulate 100", "--simulate '100': VELOCITY,ACCELERATION"),
        ("--test X --amplitude 0", "--amplitude '0': a number above 0"),
        ("--test X --velocity-step fast", "--velocity-step 'fast': a number above 0"),
        ("--simulate 100,100", "are for --test"),
        ("--test Y", "axis Y: the answers have no step and direction for it"),
        ("--test X --simulate 5,1600", "no velocity is borne"),
    ] {
        let output = search(options);
        assert_eq!((output.stdout.as_str(), output.status), ("", Some(1)), "{options}");
        assert!(output.stderr.contains(why), "{options}: {}", output.stderr);
    }
    let scratch = Scratch::copy_of(&root().join("tests/setup"));
    let printer = fs::read_to_string(root().join("configs/printer/printer.setup")).unwrap();
    let slow = printer.replace("latency = 11732", "latency = 94000");
    scratch.write("slow.setup", slow.replace("velocity = 90", "velocity = 3000"));
    for (answers, why) in [
        ("servo.toml", "servos have encoders: they lose no steps that a search could find"),
        ("slow.setup", "a velocity of 3000 is too fast for a jitter of 94000 ns"),
    ] {
        let output = run(&scratch, &format!("halsetup {answers} --test X --simulate 100,100"));
        assert_eq!((output.stdout.as_str(), output.status), ("", Some(1)), "{answers}");
        assert!(output.stderr.contains(why), "{answers}: {}", output.stderr);
    }
}
