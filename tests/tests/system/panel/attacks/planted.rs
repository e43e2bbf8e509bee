//! Every fault of the list of attacks, planted into a copy of the tree: each attack must have success then.

use super::list::{Attack, BREACH, Edit, Held, List, beside};
use hal_tests::programs::{cargo, root};
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    fs,
    path::Path,
    process::Command,
};

/// Folder of the copy, below that of builds.
const COPY: &str = "target/planted";

/// Returns the names of the files of the repository.
fn files() -> Vec<String> {
    let mut git = Command::new("git");
    git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]);
    let listed = git.current_dir(root()).output().unwrap();
    let names = String::from_utf8(listed.stdout).unwrap();
    names.split_terminator('\0').map(str::to_owned).collect()
}

/// Makes the copy the tree with these changes. A file that is right already keeps its time, so that little is built again.
fn plant(copy: &Path, names: &[String], edits: &[&Edit]) {
    let mut changes: BTreeMap<&str, Vec<&Edit>> = BTreeMap::new();
    edits.iter().for_each(|edit| changes.entry(&edit.file).or_default().push(edit));
    for name in names {
        let (from, to) = (root().join(name), copy.join(name));
        let Ok(mut bytes) = fs::read(&from) else { continue };
        for edit in changes.get(name.as_str()).into_iter().flatten() {
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(text.matches(&edit.text).count(), 1, "{name}: {}", edit.text);
            bytes = text.replacen(&edit.text, &edit.becomes, 1).into_bytes();
        }
        if fs::read(&to).ok().as_ref() == Some(&bytes) {
            continue;
        }
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        // A copy keeps whether a file can be run.
        fs::copy(&from, &to).unwrap();
        fs::write(&to, bytes).unwrap();
    }
}

/// Runs tests of the copy; returns what they said.
fn run(copy: &Path, package: Option<&str>, tests: &BTreeSet<&str>) -> String {
    let mut cargo = cargo("test");
    cargo.current_dir(copy).env("CARGO_INCREMENTAL", "0").env_remove("CARGO_TARGET_DIR");
    match package {
        Some(package) => cargo.args(["-p", package, "--lib"]),
        None => cargo.args(["-p", "hal-tests", "--test", "system"]),
    };
    let output = cargo.args(["--locked", "--", "--exact"]).args(tests).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let said = format!("{}{}", text(&output.stderr), text(&output.stdout));
    assert!(said.contains("running "), "the tests with the faults do not build:\n{said}");
    said
}

/// Returns whether an attack had success, by what the tests said.
fn has_success(held: &Held, attack: &Attack, said: &str) -> bool {
    let fails = said.contains(&format!("test {} ... FAILED", held.test));
    let line = format!("{BREACH}{}: ", attack.name);
    fails && (held.package.is_some() || said.lines().any(|said| said.starts_with(&line)))
}

#[test]
#[ignore = "builds the tree several times: cargo test -p hal-tests --test system panel::attacks::planted -- --ignored --nocapture"]
fn each_attack_has_success_with_its_fault() {
    let (list, names, copy) = (List::read(), files(), root().join(COPY));
    let batches: BTreeSet<_> = list.fault.iter().map(|fault| fault.batch).collect();
    let known = fs::read_to_string(beside("attacks.seen")).unwrap_or_default();
    let known: BTreeSet<_> = known.lines().collect();
    let (mut seen, mut void) = (BTreeSet::new(), String::new());
    for batch in batches {
        let faults: Vec<_> = list.fault.iter().filter(|fault| fault.batch == batch).collect();
        let edits: Vec<_> = faults.iter().flat_map(|fault| &fault.edit).collect();
        let attacks: Vec<(&Held, &Attack)> = list
            .attacks()
            .filter(|(_, attack)| faults.iter().any(|fault| fault.name == attack.fault))
            .collect();
        let lines: Vec<_> = attacks.iter().map(|(_, attack)| list.seen(attack)).collect();
        if lines.iter().all(|line| known.contains(&**line)) {
            println!("batch {batch}: seen before, with the faults as they are");
            seen.extend(lines);
            continue;
        }
        plant(&copy, &names, &edits);
        let packages: BTreeSet<_> =
            attacks.iter().map(|(held, _)| held.package.as_deref()).collect();
        let said = packages.iter().map(|package| {
            let of = attacks.iter().filter(|(held, _)| held.package.as_deref() == *package);
            run(&copy, *package, &of.map(|(held, _)| &*held.test).collect())
        });
        let said = said.collect::<Vec<_>>().concat();
        println!("batch {batch}: {} faults, {} attacks", faults.len(), attacks.len());
        for (held, attack) in &attacks {
            if has_success(held, attack, &said) {
                seen.insert(list.seen(attack));
            } else {
                writeln!(void, "{} (fault {})", attack.name, attack.fault).unwrap();
            }
        }
        if !void.is_empty() {
            println!("{said}");
        }
    }
    plant(&copy, &names, &[]);
    let lines: Vec<_> = seen.iter().map(|line| format!("{line}\n")).collect();
    fs::write(beside("attacks.seen"), lines.concat()).unwrap();
    println!("{} of {} attacks had success", seen.len(), list.attacks().count());
    assert!(void.is_empty(), "without success in spite of the fault:\n{void}");
}
