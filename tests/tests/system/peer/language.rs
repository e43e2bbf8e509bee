//! Scripts through LinuxCNC 2.9 and through Ferrule: all differences are known and explained.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch};
use std::{collections::BTreeSet, fs};

/// Returns Ferrule's output for a script of `tests/peer`: standard output, standard error.
fn ours(script: &str) -> (String, String) {
    let scratch = Scratch::new("peer");
    scratch.write(script, fs::read(root().join("tests/peer").join(script)).unwrap());
    let mut command = scratch.command(&[], "halrun");
    command.args(["--virtual", "-k", "-f", script]);
    let output = scratch.run(&mut command);
    (output.stdout, output.stderr)
}

/// Returns a file of LinuxCNC's output, or of its known differences.
fn theirs(file: &str) -> String {
    fs::read_to_string(root().join("tests/peer").join(file)).unwrap()
}

/// Returns a line without the changes of the newer release: column widths, trailing blanks. Component ids are each
/// system's own.
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

/// Lines that LinuxCNC prints and Ferrule does not are exactly those of `refusals.differences`.
#[test]
fn refusals_are_the_same_but_where_that_is_meant() {
    let (_, stderr) = ours("refusals.hal");
    let said: Vec<&str> = stderr.lines().collect();
    let is_said = |line: &&str| {
        // Ferrule does not print the prefix of the HAL library.
        let library = line.strip_prefix("HAL: ERROR: ");
        let end = format!(": {}", library.unwrap_or(line));
        said.iter().any(|s| s.ends_with(&end) || (library.is_none() && s == line))
    };
    let (theirs, known) = (theirs("refusals.err"), theirs("refusals.differences"));
    let missing: BTreeSet<&str> =
        theirs.lines().filter(|l| !l.is_empty()).filter(|l| !is_said(l)).collect();
    let known: BTreeSet<&str> =
        known.lines().filter(|l| !l.is_empty() && !l.starts_with('#')).collect();
    let new: Vec<_> = missing.difference(&known).collect();
    let gone: Vec<_> = known.difference(&missing).collect();
    assert!(new.is_empty() && gone.is_empty(), "not said: {new:#?}\nsaid after all: {gone:#?}");
}
