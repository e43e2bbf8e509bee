//! The words of the code base: plain ones, as STYLE asks.

use hal_tests::programs::{files_below, root, short};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Words that no doc comment begins with: a noun phrase or a verb says what a thing is or does.
const OPENINGS: &[&str] = &[
    "How", "It", "Its", "One", "So", "Such", "That", "Their", "These", "They", "Those", "What",
    "Whatever", "Where", "Wherever", "Whether", "Which", "Who", "Whoever", "Whom", "Whose", "Why",
];

/// Words of a private dialect, with the standard ones.
const DIALECT: &[(&str, &str)] = &[
    ("anew", "again"),
    ("dearest", "most expensive"),
    ("given up", "aborted"),
    ("is told", "is reported"),
    ("mended", "fixed"),
    ("no number", "NaN"),
    ("whoever", "the actor by name"),
];

#[test]
fn doc_comments_begin_with_a_noun_or_a_verb() {
    let mut bad = Vec::new();
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        let mut inside = false;
        for (n, line) in text.lines().enumerate() {
            let doc = doc(line);
            if let Some(doc) = doc
                && !inside
            {
                let word = doc.split(|c: char| !c.is_alphabetic()).next().unwrap_or_default();
                if OPENINGS.contains(&word) {
                    bad.push(format!("{}:{}: {}", short(&path), n + 1, line.trim()));
                }
            }
            inside = doc.is_some();
        }
    }
    assert!(bad.is_empty(), "{} doc comments begin with a pronoun:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn comments_are_in_standard_words() {
    let mut bad = Vec::new();
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        for (n, line) in text.lines().enumerate() {
            let Some((_, comment)) = line.split_once("//") else { continue };
            let comment = comment.to_lowercase();
            for (word, standard) in DIALECT {
                let found =
                    comment.split(|c: char| !c.is_alphabetic()).collect::<Vec<_>>().join(" ");
                if format!(" {found} ").contains(&format!(" {word} ")) {
                    bad.push(format!("{}:{}: '{word}': {standard}", short(&path), n + 1));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

/// Returns the text of a line of a doc comment.
fn doc(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let text = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))?;
    if text.starts_with('/') { None } else { Some(text.trim_start()) }
}

/// Returns every Rust file but expected output and this list.
fn sources() -> Vec<PathBuf> {
    let folders = ["hal", "halcmd", "components", "tests"];
    let all = folders.iter().flat_map(|folder| files_below(&root().join(folder), ".rs"));
    let is_own = |path: &PathBuf| !path.ends_with("words.rs") && !is_expected(path);
    let found: Vec<_> = all.filter(is_own).collect();
    assert!(found.len() > 500, "only {} files", found.len());
    found
}

fn is_expected(path: &Path) -> bool {
    path.components().any(|part| part.as_os_str() == "expected")
}
