//! Every name of `tests/compat/names.txt`, LinuxCNC's modules among them, is offered by one of our libraries, or `components/README.md`
//! explains its absence.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::{foreign::Bench, programs::root, tools};
use std::collections::{BTreeMap, BTreeSet};

/// Returns the names of the list.
fn asked() -> BTreeSet<String> {
    let text = std::fs::read_to_string(root().join("tests/compat/names.txt")).unwrap();
    let lines: Vec<&str> = text.lines().filter(|l| !l.is_empty() && !l.starts_with('#')).collect();
    let names: BTreeSet<String> = lines.iter().map(|l| (*l).to_owned()).collect();
    assert_eq!(names.len(), lines.len(), "a name stands twice");
    names
}

/// Returns the names that our libraries offer.
fn offered() -> BTreeSet<String> {
    let request = Request::List { kind: Kind::Offers, patterns: Vec::new(), ty: None };
    let Ok(Reply::Offers(list)) = Bench::new(&[]).call(request) else { panic!("no list") };
    list.into_iter().map(|o| o.component).collect()
}

/// Returns the names that a section of `components/README.md` explains, if the section exists, with the explanations.
fn explained(section: &str) -> BTreeMap<String, String> {
    let text = std::fs::read_to_string(root().join("components/README.md")).unwrap();
    let from = text.split_once(&format!("\n## {section}\n")).map_or("", |(_, from)| from);
    let rows = from.split("\n## ").next().unwrap().lines().filter(|l| l.starts_with("| `"));
    let mut all = BTreeMap::new();
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [names, why] = cells[..] else { panic!("not two cells: {row}") };
        for name in names.split(',') {
            let name = name.trim().trim_matches('`').to_owned();
            assert!(all.insert(name, why.to_owned()).is_none(), "{names} stands twice");
        }
    }
    all
}

#[test]
fn every_name_is_offered_or_explained() {
    let (asked, offered) = (asked(), offered());
    let mut told = explained("What cannot be built");
    for (name, how) in explained("Names that are served otherwise") {
        assert!(told.insert(name.clone(), how).is_none(), "{name} stands in both sections");
    }
    let is_known = |n: &String| offered.contains(n) || told.contains_key(n);
    let missing: Vec<_> = asked.iter().filter(|n| !is_known(n)).collect();
    assert!(missing.is_empty(), "neither offered nor explained: {missing:?}");
    for (name, why) in &told {
        assert!(why.split(' ').count() > 2, "{name}: `{why}` explains nothing");
        assert!(!offered.contains(name), "{name} is offered, and explained as if it were not");
        assert!(asked.contains(name), "{name} is explained, and not in tests/compat/names.txt");
    }
}

/// The list has every module of the package, where that is installed.
#[test]
fn the_list_is_whole() {
    let Some(folder) = tools::linuxcnc() else { return };
    let asked = asked();
    let files = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path());
    let modules = files.filter(|f| f.extension().is_some_and(|e| e == "so"));
    let names = modules.map(|f| f.file_stem().unwrap().to_string_lossy().into_owned());
    let missing: Vec<_> = names.filter(|n| !asked.contains(n)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
