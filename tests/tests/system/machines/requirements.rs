//! The page of requirements: each row has proofs, and each proof is a file or a test that exists.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::tidy::manifests;
use hal_tests::programs::{files_below, root};
use std::{collections::BTreeMap, fs, path::PathBuf};

/// File with tests: the names of its folders and its own name, and the names of its tests.
struct TestFile {
    path: Vec<String>,
    tests: Vec<String>,
}

impl TestFile {
    /// Returns whether a path of modules, perhaps with a test behind it, names tests of this file.
    fn has(&self, names: &[&str]) -> bool {
        let is_below = |names: &[&str]| {
            names.is_empty() || self.path.windows(names.len()).any(|part| part == names)
        };
        let (test, modules) = names.split_last().unwrap();
        is_below(names) || is_below(modules) && self.tests.iter().any(|t| t == test)
    }
}

/// Returns the files with tests of each crate.
fn files() -> BTreeMap<String, Vec<TestFile>> {
    let of_crate = |(name, (folder, _)): (String, (PathBuf, toml::Table))| {
        let files = files_below(&folder, ".rs").into_iter().map(|file| {
            let text = fs::read_to_string(&file).unwrap();
            let behind = text.split("#[test]").skip(1).filter_map(|t| t.split_once("fn "));
            let tests = behind.map(|(_, t)| t.split('(').next().unwrap().to_owned()).collect();
            let path = file.strip_prefix(&folder).unwrap().with_extension("");
            let path = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            TestFile { path, tests }
        });
        (name, files.filter(|file| !file.tests.is_empty()).collect())
    };
    manifests().into_iter().map(of_crate).collect()
}

/// Returns whether a proof exists: a path, or a crate and tests of it.
fn exists(proof: &str, files: &BTreeMap<String, Vec<TestFile>>) -> bool {
    let Some((package, test)) = proof.split_once(' ') else { return root().join(proof).exists() };
    let names: Vec<&str> = test.split("::").collect();
    files.get(package).is_some_and(|files| files.iter().any(|file| file.has(&names)))
}

#[test]
fn each_has_a_proof_that_exists() {
    let page = fs::read_to_string(root().join("configs/REQUIREMENTS.md")).unwrap();
    let files = files();
    for none in ["configs/none.toml", "none rig", "hal-arm none", "hal-arm tests::none"] {
        assert!(!exists(none, &files), "{none}");
    }
    let rows = page.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| ID"));
    let rows: Vec<(&str, Vec<&str>)> = rows
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
            (cells[0].trim(), cells[2].split('`').skip(1).step_by(2).collect())
        })
        .collect();
    assert_eq!(
        rows.len(),
        28 + 13 + 12 + 10 + 12 + 16,
        "systems, and requirements of each document"
    );
    for (id, proofs) in rows {
        assert!(!proofs.is_empty(), "{id}: nothing shows it");
        for proof in proofs {
            assert!(exists(proof, &files), "{id}: there is no {proof}");
        }
    }
}
