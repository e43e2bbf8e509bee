//! The rules of the code base that no compiler checks.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// Returns every file below `folder` with this ending, without build output.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "target" && !name.starts_with('.') {
                out.extend(files(&path, ending));
            }
        } else if name.ends_with(ending) {
            out.push(path);
        }
    }
    out
}

fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().display().to_string()
}

/// Returns the file without its tests.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]").next().unwrap().to_owned()
}

/// Returns the manifests of the workspace's members.
fn members() -> BTreeMap<String, toml::Table> {
    let mut out = BTreeMap::new();
    for path in files(&root(), "Cargo.toml") {
        let at = short(&path);
        let own =
            ["Cargo.toml", "tests/fuzz/", "tests/plugins/", "tests/loom/", "tests/compile-fail/"];
        if at == "Cargo.toml" || own.iter().skip(1).any(|o| at.starts_with(o)) {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let table: toml::Table = text.parse().unwrap();
        let name = table["package"]["name"].as_str().unwrap().to_owned();
        out.insert(name, table);
    }
    out
}

fn dependencies(table: &toml::Table) -> Vec<String> {
    let list = table.get("dependencies").and_then(toml::Value::as_table);
    list.map(|t| t.keys().cloned().collect()).unwrap_or_default()
}

#[test]
fn arrows_point_only_downward() {
    let members = members();
    let ours: Vec<&String> = members.keys().collect();
    let fixed: BTreeMap<&str, &[&str]> = BTreeMap::from([
        ("hal-abi", &[][..]),
        ("hal-derive", &[]),
        ("hal-component", &["hal-abi", "hal-derive"]),
        ("hal-protocol", &["hal-abi"]),
        ("hal-ini", &[]),
        ("hal-output", &[]),
        ("hal-trace", &["hal-output", "hal-protocol"]),
        ("hal-engine", &["hal-abi", "hal-output", "hal-protocol", "hal-trace"]),
        (
            "halcmd",
            &["hal-engine", "hal-gcode", "hal-ini", "hal-output", "hal-protocol", "hal-trace"],
        ),
        ("halcompile", &["hal-output"]),
        ("ferrule-client", &["hal-protocol"]),
    ]);
    for (name, table) in &members {
        if name == "hal-tests" {
            continue;
        }
        let component: &[&str] = &["hal-component", "port"];
        let allowed = fixed.get(name.as_str()).copied().unwrap_or(component);
        for d in dependencies(table) {
            let known = ours.iter().any(|o| **o == d);
            assert!(!known || allowed.contains(&d.as_str()), "{name} must not depend on {d}");
        }
    }
    assert!(dependencies(&members["hal-abi"]).is_empty(), "hal-abi depends on nothing");
}

#[test]
fn lints_are_inherited_and_exceptions_carry_a_reason() {
    for (name, table) in members() {
        let inherited = table.get("lints").and_then(|l| l.get("workspace"));
        assert_eq!(
            inherited,
            Some(&toml::Value::Boolean(true)),
            "{name}: [lints] workspace = true"
        );
        for key in ["edition", "rust-version", "license"] {
            let value = &table["package"][key];
            assert!(value.is_table(), "{name}: {key}.workspace = true");
        }
    }
    for path in files(&root(), ".rs") {
        if path.ends_with("tests/tests/system/tidy.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(!text.contains("#[allow("), "{}: use #[expect(…, reason)]", short(&path));
        for (i, line) in text.lines().enumerate() {
            let ignored = line.trim_start().starts_with("#[ignore");
            let told = line.contains("= \"") && line.contains(": cargo test -p ");
            assert!(!ignored || told, "{}:{}: why, and how to run it", short(&path), i + 1);
        }
    }
}

#[test]
fn unsafe_has_an_address() {
    let word = ["uns", "afe"].concat();
    let mut at_registers: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    for path in files(&root().join("components"), ".rs") {
        let at = short(&path);
        let compat = at.starts_with("components/foreign/compat/");
        let driver = ["components/drivers/parport/", "components/drivers/viagpio/"]
            .iter()
            .any(|d| at.starts_with(d));
        if at.ends_with("src/lib.rs") && !at.starts_with("components/foreign/compat/") {
            let text = code(&path);
            let forbids = text.contains(&format!("#![forbid({word}_code)]"));
            let denies = driver && text.contains(&format!("#![deny({word}_code)]"));
            assert!(forbids || denies, "{at}: #![forbid({word}_code)]");
        }
        let uses = code(&path).lines().any(|l| {
            let l = l.trim_start();
            !l.starts_with("//") && !l.contains(&format!("{word}_code")) && l.contains(&word)
        });
        assert!(!uses || driver || compat, "{at}: no {word} code in a component");
        if uses && driver {
            at_registers.entry(path.parent().unwrap().to_owned()).or_default().push(at);
        }
    }
    for list in at_registers.values() {
        assert_eq!(list.len(), 1, "one module of a driver touches registers: {list:?}");
    }
    for path in files(&root().join("halcmd"), ".rs") {
        let uses = code(&path).lines().any(|l| l.contains(&format!("{word} {{")));
        assert!(!uses, "{}: no {word} code here", short(&path));
    }
}

#[test]
fn files_have_one_subject() {
    for folder in ["hal", "components", "halcmd", "tests/src"] {
        for path in files(&root().join(folder), ".rs") {
            let at = short(&path);
            if at.contains("/tests/") || at.ends_with("/tests.rs") {
                continue;
            }
            let text = code(&path);
            assert!(text.starts_with("//!"), "{at}: the first line says what it is");
            let n = text.lines().count();
            assert!(n <= 400, "{at}: {n} lines before its tests; 400 is one subject");
        }
    }
}

#[test]
fn realtime_files_do_nothing_that_realtime_must_not() {
    let words = [
        "format!(",
        "println!",
        "Mutex",
        "RwLock",
        "Box::new",
        "vec!",
        ".to_owned()",
        ".to_string()",
        "String",
        "Vec::new",
        ".collect",
        "panic!(",
        ".unwrap()",
        ".expect(",
        "std::fs",
        "std::io",
    ];
    let mut seen = 0;
    for path in files(&root().join("hal"), ".rs") {
        let text = code(&path);
        let first = text.lines().next().unwrap_or_default();
        if !first.starts_with("//! Realtime.") {
            continue;
        }
        seen += 1;
        for (i, line) in text.lines().enumerate() {
            let line = line.trim_start();
            if line.starts_with("//") {
                continue;
            }
            for w in words {
                assert!(!line.contains(w), "{}:{}: {w} in a realtime file", short(&path), i + 1);
            }
        }
    }
    assert!(seen >= 12, "only {seen} realtime files: are their first lines as they should be?");
}

#[test]
fn atomics_of_the_engine_come_from_one_module() {
    for path in files(&root().join("hal/engine/src"), ".rs") {
        let text = code(&path);
        let direct = text.contains("std::sync::atomic") || text.contains("core::sync::atomic");
        assert!(!direct || path.ends_with("sync.rs"), "{}: use crate::sync", short(&path));
    }
}

#[test]
fn output_goes_through_one_crate() {
    let words = [
        "fs::write(",
        "fs::copy(",
        "fs::rename(",
        "File::create(",
        "File::options(",
        "OpenOptions",
        "print!(",
        "println!(",
        "stdout().lock",
        "stdout().write",
    ];
    // Files that write to something other than program output, and the reason. Each entry must be used.
    let scratch = "files in a folder that goes again";
    let device = "a device";
    let mut others = BTreeMap::from([
        ("components/foreign/halcompile/src/build.rs", scratch),
        ("components/foreign/halcompile/src/command.rs", scratch),
        (
            "components/foreign/halcompile/src/headers.rs",
            "a folder that is renamed when it is whole",
        ),
        ("components/foreign/halcompile/src/program.rs", scratch),
        ("components/drivers/parport/src/hardware.rs", device),
        ("components/drivers/speaker/src/device.rs", device),
        ("components/drivers/viagpio/src/hardware.rs", device),
        ("hal/engine/src/os/processors.rs", device),
        ("hal/engine/src/ends/apart.rs", device),
        ("hal/engine/src/ends/watcher.rs", "a lock, and a recording that a kill has cut"),
        ("halcmd/src/programs/halrun/detach.rs", device),
        ("halcmd/src/programs/haltest/one.rs", scratch),
        ("halcmd/src/programs/haltest/process.rs", scratch),
        ("halcmd/src/programs/haltest/stage.rs", scratch),
    ]);
    for folder in ["hal", "halcmd", "components"] {
        for path in files(&root().join(folder), ".rs") {
            let at = short(&path);
            let folders = ["/tests/", "/benches/", "/examples/"];
            let own = at.starts_with("hal/output/") || folders.iter().any(|f| at.contains(f));
            let is_build = at.ends_with("/build.rs") && !at.contains("/src/");
            if own || is_build || at.ends_with("/tests.rs") {
                continue;
            }
            let text = code(&path);
            let lines = text.lines().filter(|l| !l.trim_start().starts_with("//"));
            let used = lines.flat_map(|l| words.iter().filter(|w| l.contains(**w))).next();
            if let Some(word) = used {
                let known = others.remove(at.as_str());
                assert!(known.is_some(), "{at}: {word} ...): use hal-output");
            }
        }
    }
    assert_eq!(others, BTreeMap::new(), "exceptions that nothing needs");
}

#[test]
fn no_vague_names() {
    for path in files(&root(), ".rs") {
        if path.ends_with("tests/tests/system/tidy.rs") {
            continue;
        }
        // `motion-command-handler` is the name of that function for users.
        for word in ["Manager", "Handler", "Helper"] {
            for decl in ["struct ", "enum ", "trait "] {
                let text = code(&path);
                let bad = text.lines().any(|l| {
                    let l = l.trim_start();
                    !l.starts_with("//")
                        && l.split_once(decl).is_some_and(|(_, n)| {
                            n.split(|c: char| !c.is_alphanumeric())
                                .next()
                                .is_some_and(|n| n.ends_with(word) && n != "Handler")
                        })
                });
                assert!(!bad, "{}: a name with {word} says nothing", short(&path));
            }
        }
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(!["util", "utils", "misc", "helpers"].contains(&stem.as_str()), "{}", short(&path));
    }
}

#[test]
fn the_readme_names_every_folder() {
    let text = std::fs::read_to_string(root().join("README.md")).unwrap();
    for name in ["hal/", "components/", "halcmd/", "configs/", "tests/"] {
        assert!(text.contains(name), "README.md: {name} is not on the map");
    }
    let map = std::fs::read_to_string(root().join("hal/README.md")).unwrap();
    for path in files(&root().join("hal/engine/src"), ".rs") {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let known = map.contains(&format!("`{name}`"));
        assert!(known, "hal/README.md: the code map has no `{name}`");
    }
}
