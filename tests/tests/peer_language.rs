//! Scripts through LinuxCNC 2.9 and through Ferrule: what differs is known, and why.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch};
use std::fs;

/// What Ferrule prints for a script of `tests/peer`: standard output, standard error.
fn ours(script: &str) -> (String, String) {
    let scratch = Scratch::new("peer");
    scratch.write(script, fs::read(root().join("tests/peer").join(script)).unwrap());
    let mut command = scratch.command(&[], "halrun");
    command.args(["--virtual", "-k", "-f", script]);
    let output = scratch.run(&mut command);
    (output.stdout, output.stderr)
}

fn theirs(file: &str) -> String {
    fs::read_to_string(root().join("tests/peer").join(file)).unwrap()
}

/// A line without what the newer release changed: widths of columns, blanks at the end. The numbers
/// of components are each system's own.
fn plain(line: &str) -> String {
    let mut words: Vec<&str> = line.split_whitespace().collect();
    let owner = words.first().is_some_and(|w| w.parse::<u32>().is_ok());
    if owner && words.get(1).is_some_and(|w| matches!(*w, "bit" | "float" | "s32" | "u32")) {
        words.remove(0);
    }
    words.join(" ")
}

#[test]
fn listings_are_the_same_but_for_widths() {
    let (stdout, _) = ours("listings.hal");
    let got: Vec<String> = stdout.lines().map(plain).collect();
    let want: Vec<String> = theirs("listings.out").lines().map(plain).collect();
    assert_eq!(got, want);
}

/// What LinuxCNC 2.9 says that Ferrule does not say in these words.
const BY_DESIGN: &[(&str, &str)] = &[
    ("rtapi_app", "no program of its own loads modules"),
    (": dlopen: ", "what cannot be found is said with where it was looked for"),
    (" invalid for ", "the newer release: thing 'X': invalid argument"),
    ("setp failed", "the newer release has no second line"),
    ("sets failed", "the newer release has no second line"),
    (" is not writable", "the newer release: thing 'X': not writable"),
    ("already has writer(s)", "the newer release: thing 'X': not writable"),
    ("parameter or pin 'nothing' not found", "the newer release: 'X': not found"),
    ("pin or parameter ", "the newer release: parameter or pin 'X': not found"),
    ("signal 'nosig' not found", "the newer release: 'X': not found, where a value is asked for"),
    ("newsig failed", "the newer release has no second line for a type"),
    ("signal 'q' already has output", "'net' is whole or not at all"),
    ("link failed", "'net' is whole or not at all"),
    (": Permission denied", "what the system says of a folder in PATH"),
];

#[test]
fn refusals_are_the_same_but_where_that_is_meant() {
    let (_, stderr) = ours("refusals.hal");
    let said: Vec<&str> = stderr.lines().collect();
    let mut unknown = Vec::new();
    let mut used = Vec::new();
    for line in theirs("refusals.err").lines().filter(|l| !l.is_empty()) {
        // The library's sentences have no place there.
        let library = line.strip_prefix("HAL: ERROR: ");
        let same = match library {
            Some(text) => said.iter().any(|s| s.ends_with(&format!(": {text}"))),
            None => said.iter().any(|s| *s == line || s.ends_with(&format!(": {line}"))),
        };
        match BY_DESIGN.iter().find(|(part, _)| line.contains(part)) {
            _ if same => {}
            Some((part, _)) => used.push(*part),
            None => unknown.push(line.to_owned()),
        }
    }
    for (part, why) in BY_DESIGN {
        assert!(used.contains(part), "no longer different: {part}: {why}");
    }
    assert!(unknown.is_empty(), "not said here:\n{}\nbut:\n{stderr}", unknown.join("\n"));
}
