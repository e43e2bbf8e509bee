//! Clean machines with one mistake each: what `check` finds of it, counted by kind in `tests/mutations/README.md`.
#![expect(clippy::unwrap_used, clippy::print_stderr, reason = "tests")]

use hal_protocol::Level;
use hal_tests::{
    golden,
    mutations::{CleanMachine, Verdict, judge, machines, table},
    programs::{programs, root},
};
use std::{collections::BTreeSet, fmt::Write, path::PathBuf};

/// Mutants of one kind in one machine, in the committed table.
const MOST: usize = 3;

/// More than there are mutants of one kind in one machine.
const ALL: usize = 1_000_000;

/// Returns the verdicts on the machines of `configs/`, two at once.
fn verdicts(most: usize) -> Vec<Verdict> {
    programs();
    let mut list = machines();
    // Variants of a machine that is in the list.
    list.retain(|m| !["demo.ini", "scope.ini", "pedal.ini"].iter().any(|part| m.ends_with(part)));
    let (even, odd): (Vec<_>, Vec<_>) = list.iter().enumerate().partition(|(n, _)| n % 2 == 0);
    let run = |part: Vec<(usize, &PathBuf)>| -> Vec<(usize, Vec<Verdict>)> {
        part.into_iter().map(|(n, m)| (n, judge(&CleanMachine::read(m), most))).collect()
    };
    let mut all = std::thread::scope(|scope| {
        let odd = scope.spawn(|| run(odd));
        let mut all = run(even);
        all.extend(odd.join().unwrap());
        all
    });
    all.sort_by_key(|(n, _)| *n);
    all.into_iter().flat_map(|(_, v)| v).collect()
}

/// Returns the mistakes that are not caught, or whose place or remedy is wrong.
fn missed(verdicts: &[Verdict]) -> String {
    let mut text = String::new();
    for v in verdicts {
        let caught = v.level.is_some_and(|l| l > Level::Note);
        let wrong = match (caught, v.place, v.remedy) {
            (false, ..) => "not caught",
            (true, false, _) => "place",
            (true, true, false) => "remedy",
            _ => continue,
        };
        writeln!(text, "{wrong}: {}: {}", v.kind, v.what).unwrap();
    }
    text
}

#[test]
fn mistakes_are_caught_at_their_place_with_their_remedy() {
    let verdicts = verdicts(MOST);
    let (text, total) = table(&verdicts);
    let kinds: BTreeSet<&str> = verdicts.iter().map(|v| v.kind).collect();
    assert!(kinds.len() >= 45, "only {} kinds", kinds.len());
    let folder = root().join("tests/mutations");
    golden::check_part(&folder.join("README.md"), "<!-- table -->\n", "<!-- end -->", &text);
    golden::check(&folder.join("missed"), &missed(&verdicts));
    let caught = total.caught();
    assert!(caught * 100 >= total.all * 95, "{caught} of {} caught", total.all);
    assert!(total.place * 100 >= caught * 98, "{} of {caught} places", total.place);
    assert!(total.remedy * 100 >= caught * 90, "{} of {caught} remedies", total.remedy);
}

#[test]
#[ignore = "takes minutes; the test above checks a sample of each kind: cargo test -p hal-tests --test system every_mutant -- --ignored --nocapture"]
fn every_mutant_of_every_line() {
    let (text, total) = table(&verdicts(ALL));
    assert!(total.caught() * 100 >= total.all * 95, "{text}");
    eprintln!("{text}");
}
