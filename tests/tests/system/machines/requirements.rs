//! The page of requirements: all that it names exists, and no row is without a proof.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::tidy::manifests;
use hal_tests::programs::root;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// Collects the text of all Rust files below a folder, each behind the name of its module.
fn collect(folder: &Path, text: &mut String) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            text.push_str(&format!("\nmod {};\n", path.file_name().unwrap().to_string_lossy()));
            collect(&path, text);
        } else if path.extension().is_some_and(|e| e == "rs") {
            text.push_str(&format!("\nmod {};\n", path.file_stem().unwrap().to_string_lossy()));
            text.push_str(&fs::read_to_string(&path).unwrap());
        }
    }
}

/// Returns what is wrong with a proof: a path, or the name of a crate and of a test of it.
fn wrong(proof: &str, sources: &BTreeMap<String, String>) -> Option<String> {
    let Some((package, test)) = proof.split_once(' ') else {
        return (!root().join(proof).exists()).then(|| format!("{proof}: there is no such file"));
    };
    let Some(text) = sources.get(package) else {
        return Some(format!("{proof}: there is no crate {package}"));
    };
    test.split("::").find_map(|part| {
        let is_there =
            text.contains(&format!("fn {part}(")) || text.contains(&format!("mod {part};"));
        (!is_there).then(|| format!("{proof}: {package} has no test or module {part}"))
    })
}

#[test]
fn each_has_a_proof_that_exists() {
    let page = fs::read_to_string(root().join("configs/REQUIREMENTS.md")).unwrap();
    let source = |(name, (folder, _)): (String, (PathBuf, toml::Table))| {
        let mut text = String::new();
        collect(&folder, &mut text);
        (name, text)
    };
    let sources = manifests().into_iter().map(source).collect();
    let mut rows = 0;
    let mut faults = Vec::new();
    for line in page.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| ID")) {
        rows += 1;
        let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
        let proofs: Vec<&str> = cells[2].split('`').skip(1).step_by(2).collect();
        if proofs.is_empty() {
            faults.push(format!("{}: nothing shows it", cells[0].trim()));
        }
        faults.extend(proofs.into_iter().filter_map(|proof| wrong(proof, &sources)));
    }
    assert_eq!(rows, 28 + 13 + 12 + 10 + 12 + 16, "systems, and requirements of each document");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
