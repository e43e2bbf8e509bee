//! The words of the code base: plain ones, as STYLE asks.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::programs::root;
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
    let mut found = Vec::new();
    for folder in ["hal", "halcmd", "components", "tests"] {
        collect(&root().join(folder), &mut found);
    }
    assert!(found.len() > 500, "only {} files", found.len());
    found
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "target" && name != "expected" {
                collect(&path, found);
            }
        } else if name.ends_with(".rs") && name != "words.rs" {
            found.push(path);
        }
    }
}

fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().display().to_string()
}
