//! Machines as pictures, through the real halcmd. `UPDATE_EXPECT=1` writes the expected output.

use hal_tests::{golden, programs::root, scratch::Scratch};
use std::path::Path;

fn is(path: &Path, text: &str) {
    golden::check(path, text);
}

fn drawn(scratch: &Scratch, words: &[&str]) -> String {
    let output = scratch.halcmd(&[&["graph"], words].concat());
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{words:?}");
    output.stdout
}

#[test]
fn small_machines_in_every_format() {
    let folder = root().join("tests/graph");
    let scratch = Scratch::copy_of(&folder);
    for machine in ["servo", "loose"] {
        let file = format!("{machine}.hal");
        for (option, ending) in [("--svg", "svg"), ("--dot", "dot"), ("--mermaid", "mmd")] {
            let text = drawn(&scratch, &[option, &file]);
            is(&folder.join(format!("{machine}.{ending}")), &text);
            // The same picture, written to a file whose name determines the format.
            let out = format!("out.{ending}");
            assert_eq!(drawn(&scratch, &[&file, "-o", &out]), "");
            assert_eq!(scratch.read(&out), text);
        }
    }
}

#[test]
fn the_printers_picture_is_true() {
    let folder = root().join("configs/printer");
    let scratch = Scratch::copy_of(&folder);
    is(&folder.join("printer.svg"), &drawn(&scratch, &["printer.ini"]));
}

#[test]
fn a_pattern_draws_a_part_and_all_draws_more() {
    let scratch = Scratch::copy_of(&root().join("tests/graph"));
    let has = |words: &[&str], name: &str| drawn(&scratch, words).contains(&format!(">{name}<"));
    let plain = ["loose.hal"];
    for (name, want) in [("step", true), ("and2.0", true), ("and2.1", false), ("in1", false)] {
        assert_eq!(has(&plain, name), want, "{name}");
    }
    // By the name of a signal, of a pin, and of a component.
    for pattern in ["start", "parport.0.pin-10-in", "and2"] {
        let words = ["loose.hal", pattern];
        assert!(has(&words, "start") && has(&words, "pin-10-in"), "{pattern}");
        assert!(!has(&words, "step"), "{pattern}");
    }
    let all = ["loose.hal", "--all", "and2"];
    for name in ["in1", "and2.1", "pin-10-in"] {
        assert!(has(&all, name), "{name}");
    }
    assert!(!has(&all, "updown"), "a pattern selects with --all as well");
    let params = drawn(&scratch, &["loose.hal", "--params"]);
    assert!(params.contains(">0.steplen = 1<"), "{params}");
    assert!(!drawn(&scratch, &plain).contains("steplen"));
}

#[test]
fn the_running_machine_is_drawn_as_well() {
    let scratch = Scratch::copy_of(&root().join("tests/graph"));
    let script = scratch.read("loose.hal");
    scratch.write("run.hal", format!("{script}graph --dot -o running.dot\nshutdown\n"));
    let output = scratch.halrun(&["--virtual", "-f", "run.hal"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let (head, running) = scratch
        .read("running.dot")
        .split_once("node [")
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .unwrap();
    assert!(head.contains("label="), "{head}");
    let made = drawn(&scratch, &["--dot", "loose.hal"]);
    assert_eq!(running, made.split_once("node [").unwrap().1);
}

#[test]
fn what_is_wrong_is_said() {
    let scratch = Scratch::copy_of(&root().join("tests/graph"));
    for (words, want) in [
        (vec!["graph", "--png", "loose.hal"], "unrecognized option '--png'"),
        (vec!["graph", "missing.hal"], "missing.hal"),
        (vec!["graph", "loose.hal", "-o", "no/such/folder.svg"], "no/such/folder.svg"),
        (vec!["graph", "-o"], "requires an argument"),
    ] {
        let output = scratch.halcmd(&words);
        assert!(output.stderr.contains(want), "{words:?}: {}", output.stderr);
        assert_eq!((output.stdout.as_str(), output.status), ("", Some(1)), "{words:?}");
    }
    // The picture shows the part that is correct.
    scratch.write("bad.hal", "loadrt and2\nnet x and2.0.out\nnet y and2.9.out\n");
    let output = scratch.halcmd(&["graph", "bad.hal"]);
    assert!(output.stderr.starts_with("bad.hal:3: "), "{}", output.stderr);
    assert!(output.stdout.contains(">x<") && !output.stdout.contains(">y<"));
    assert_eq!(output.status, Some(1));
}
