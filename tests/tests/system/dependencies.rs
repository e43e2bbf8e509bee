//! Crates of others: where they come from, their licences, and that each is there once, as `.ci/deny.toml` says.
//!
//! No list of known weaknesses can be had without a network. `cargo deny check advisories` compares with one where
//! cargo-deny is installed and has fetched it; the test that runs it is skipped by name elsewhere.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_tests::{
    programs::{cargo, root},
    tools::Tool,
};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};
use toml::Table;

/// Registry of crates.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";
/// Program that also knows published weaknesses.
const DENY: Tool = Tool {
    name: "cargo-deny",
    what: "cargo-deny, with a list of advisories,",
    remedy: "cargo install cargo-deny; cargo deny fetch",
};

fn table(path: &str) -> Table {
    fs::read_to_string(root().join(path)).unwrap().parse().unwrap()
}

/// Returns the texts of a list.
fn texts(list: &toml::Value) -> BTreeSet<String> {
    list.as_array().unwrap().iter().map(|t| t.as_str().unwrap().to_owned()).collect()
}

/// Returns the crates of `Cargo.lock`: name, version, source, checksum.
fn locked() -> Vec<Table> {
    let lock = table("Cargo.lock");
    let all = lock["package"].as_array().unwrap().iter();
    all.map(|package| package.as_table().unwrap().clone()).collect()
}

/// Returns the crates that a build for this kind of computer uses.
fn used() -> Vec<Value> {
    let mut metadata = cargo("metadata");
    metadata.args(["--format-version", "1", "--offline", "--locked", "--filter-platform"]);
    let output = metadata.arg(concat!("x86_64", "-unknown-linux-gnu")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let all: Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = all["packages"].as_array().unwrap();
    packages.iter().filter(|package| !package["source"].is_null()).cloned().collect()
}

/// Returns whether a licence, such as `MIT OR (Apache-2.0 AND ISC)`, has a choice whose parts are all allowed.
fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let text = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let text = text.replace(" WITH ", "\u{1}");
    let words: Vec<String> =
        text.split_whitespace().map(|w| w.replace('\u{1}', " WITH ")).collect();
    let mut rest = &words[..];
    let is_allowed = either(&mut rest, allowed);
    is_allowed && rest.is_empty()
}

/// Takes choices off the front.
fn either(words: &mut &[String], allowed: &BTreeSet<String>) -> bool {
    let mut found = every(words, allowed);
    while words.first().is_some_and(|w| w == "OR") {
        *words = &words[1..];
        found |= every(words, allowed);
    }
    found
}

/// Takes parts that all apply off the front.
fn every(words: &mut &[String], allowed: &BTreeSet<String>) -> bool {
    let mut found = true;
    loop {
        let Some((word, rest)) = words.split_first() else { return false };
        *words = rest;
        if word == "(" {
            found &= either(words, allowed);
            *words = words.get(1..).unwrap_or_default();
        } else {
            found &= allowed.contains(word);
        }
        if words.first().is_none_or(|w| w != "AND") {
            return found;
        }
        *words = &words[1..];
    }
}

#[test]
fn crates_of_others_come_from_the_registry_with_a_checksum() {
    let all = locked();
    let (own, others): (Vec<_>, Vec<_>) = all.iter().partition(|p| !p.contains_key("source"));
    assert!(own.len() > 40 && others.len() > 100, "{} and {}", own.len(), others.len());
    for package in others {
        let name = package["name"].as_str().unwrap();
        assert_eq!(package["source"].as_str(), Some(REGISTRY), "{name}");
        let sum = package.get("checksum").and_then(|sum| sum.as_str()).unwrap_or_default();
        assert_eq!(sum.len(), 64, "{name} has no checksum");
    }
}

#[test]
fn licences_are_those_that_are_allowed() {
    let allowed = texts(&table(".ci/deny.toml")["licenses"]["allow"]);
    let mut needed = BTreeSet::new();
    for package in used() {
        let name = package["name"].as_str().unwrap();
        let licence =
            package["license"].as_str().unwrap_or_else(|| panic!("{name} has no licence"));
        assert!(is_allowed(licence, &allowed), "{name} has the licence {licence}");
        needed.extend(allowed.iter().filter(|a| licence.contains(a.as_str())).cloned());
    }
    assert_eq!(needed, allowed, "a licence is allowed that no crate has");
    for (licence, wanted) in [
        ("MIT OR GPL-3.0", true),
        ("MIT AND GPL-3.0", false),
        ("(MIT OR GPL-3.0) AND Unicode-3.0", true),
        ("GPL-3.0/LGPL-2.1", false),
        ("Apache-2.0 WITH LLVM-exception", true),
        ("GPL-3.0", false),
        ("", false),
    ] {
        assert_eq!(is_allowed(licence, &allowed), wanted, "{licence}");
    }
}

#[test]
fn each_crate_is_there_once_but_for_those_with_a_reason() {
    let rules = table(".ci/deny.toml");
    let skipped: BTreeMap<&str, &str> = rules["bans"]["skip"]
        .as_array()
        .unwrap()
        .iter()
        .map(|skip| {
            assert!(skip["reason"].as_str().is_some_and(|reason| !reason.is_empty()), "{skip}");
            (skip["name"].as_str().unwrap(), skip["version"].as_str().unwrap())
        })
        .collect();
    let mut versions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in used() {
        let name = package["name"].as_str().unwrap().to_owned();
        versions.entry(name).or_default().push(package["version"].as_str().unwrap().to_owned());
    }
    for (name, all) in &versions {
        let is_old = |v: &&String| {
            skipped.get(name.as_str()).is_some_and(|s| v.starts_with(&format!("{s}.")))
        };
        let rest = all.iter().filter(|v| !is_old(v)).count();
        assert!(rest <= 1, "{name} is there as {all:?}");
        assert!(
            all.len() > 1 || !skipped.contains_key(name.as_str()),
            "{name} is there once: it needs no line in .ci/deny.toml"
        );
    }
    let gone: Vec<_> = skipped.keys().filter(|name| !versions.contains_key(**name)).collect();
    assert!(gone.is_empty(), "{gone:?} are not used any more");
    for denied in rules["bans"]["deny"].as_array().unwrap() {
        let name = denied["name"].as_str().unwrap();
        assert!(!versions.contains_key(name), "{name}: {}", denied["reason"]);
    }
}

#[test]
fn no_crate_has_a_known_weakness() {
    let mut deny = cargo("deny");
    deny.args(["--offline", "--locked", "--config", ".ci/deny.toml", "check", "advisories"]);
    let output = deny.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    // Without the program, or without its list, there is nothing to compare with.
    let is_missing = [
        "no such command",
        "failed to get",
        "failed to fetch",
        "failed to acquire",
        "unable to find",
    ];
    let is_missing = is_missing.iter().any(|text| said.contains(text));
    if DENY.or_skip((!is_missing).then_some(())).is_some() {
        assert!(output.status.success(), "{said}");
    }
}
