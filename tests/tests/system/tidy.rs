//! The rules of the code base that no compiler checks.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_tests::programs::{files_below, root, short};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};
use syn::visit::{self, Visit};

/// Returns the file without its tests.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    text.split("\n#[cfg(test)]").next().unwrap().to_owned()
}

/// Returns the folder and the manifest of each crate of the workspace, by name.
pub(crate) fn manifests() -> BTreeMap<String, (PathBuf, toml::Table)> {
    let mut out = BTreeMap::new();
    for path in files_below(root(), "Cargo.toml") {
        let at = short(&path);
        let own = ["Cargo.toml", "tests/fuzz/", "tests/plugins/", "tests/loom/"];
        if at == "Cargo.toml" || own.iter().skip(1).any(|o| at.starts_with(o)) {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let table: toml::Table = text.parse().unwrap();
        let name = table["package"]["name"].as_str().unwrap().to_owned();
        out.insert(name, (path.parent().unwrap().to_owned(), table));
    }
    out
}

fn members() -> BTreeMap<String, toml::Table> {
    manifests().into_iter().map(|(name, (_, table))| (name, table)).collect()
}

fn dependencies(table: &toml::Table) -> Vec<String> {
    let list = table.get("dependencies").and_then(toml::Value::as_table);
    list.map(|t| t.keys().cloned().collect()).unwrap_or_default()
}

/// A driver that notes the state of its hardware has a test in which that fails: then motion is off.
#[test]
fn each_driver_that_notes_its_hardware_has_a_test_in_which_it_fails() {
    // The report itself, and the reader of all failures.
    let others = ["port", "motion"];
    let (mut drivers, mut untested) = (0, Vec::new());
    for (name, (folder, _)) in manifests() {
        let files = files_below(&folder.join("src"), ".rs");
        let texts: Vec<_> = files.iter().map(|f| std::fs::read_to_string(f).unwrap()).collect();
        let has = |words: &str| texts.iter().any(|text| text.contains(words));
        let is_driver = folder.starts_with(root().join("components"))
            && (has("b.hardware()") || has("Report::new(b"))
            && !others.contains(&name.as_str());
        drivers += usize::from(is_driver);
        if is_driver && !has("failed_hardware()") {
            untested.push(name);
        }
    }
    assert!(drivers >= 7, "only {drivers} drivers are found");
    assert!(untested.is_empty(), "no test asks for failed_hardware() in {untested:?}");
}

/// Parts of a crate that have no tests are not built for them (`test = false`, `doctest = false`); a test that is
/// written there later would not run.
#[test]
fn no_test_is_where_cargo_does_not_look_for_it() {
    let silent =
        |part: &toml::Value, key| part.get(key).and_then(toml::Value::as_bool) == Some(false);
    let mut unseen = Vec::new();
    for (name, (folder, table)) in manifests() {
        let source = folder.join("src");
        let lib = table.get("lib").cloned().unwrap_or_else(|| toml::Table::new().into());
        let bins = table.get("bin").and_then(toml::Value::as_array).cloned().unwrap_or_default();
        for path in files_below(&source, ".rs") {
            let inside = path.strip_prefix(&source).unwrap();
            let program = inside.strip_prefix("bin").ok();
            let text = std::fs::read_to_string(&path).unwrap();
            let tests = text.lines().any(|l| matches!(l.trim(), "#[test]" | "#[cfg(test)]"));
            let example = text.lines().any(|l| {
                let l = l.trim_start();
                l.strip_prefix("///")
                    .or(l.strip_prefix("//!"))
                    .is_some_and(|l| l.trim_start().starts_with("```"))
            });
            let muted = match program {
                Some(program) => bins.iter().any(|bin| {
                    let first = program.components().next().unwrap().as_os_str().to_str().unwrap();
                    silent(bin, "test")
                        && bin["name"].as_str() == Some(first.trim_end_matches(".rs"))
                }),
                None => silent(&lib, "test"),
            };
            if tests && muted || example && program.is_none() && silent(&lib, "doctest") {
                unseen.push(format!("{name}: {}", short(&path)));
            }
        }
    }
    assert!(
        unseen.is_empty(),
        "tests in parts with `test = false` or `doctest = false`: {unseen:#?}"
    );
}

/// `cargo build` makes everything that a machine may load, and nothing of the tests.
#[test]
fn everything_but_the_tests_is_built() {
    let text = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let table: toml::Table = text.parse().unwrap();
    let list = |key: &str| -> Vec<String> {
        let all = table["workspace"][key].as_array().unwrap().iter();
        all.map(|name| name.as_str().unwrap().to_owned()).filter(|name| name != "tests").collect()
    };
    assert_eq!(list("members"), list("default-members"));
    assert!(text.contains(", \"tests\"]"), "the tests are a member");
}

#[test]
fn arrows_point_only_downward() {
    let members = members();
    let ours: Vec<&String> = members.keys().collect();
    let fixed: BTreeMap<&str, &[&str]> = BTreeMap::from([
        ("hal-abi", &[][..]),
        ("hal-derive", &[]),
        ("hal-component", &["hal-abi", "hal-derive"]),
        ("hal-bench", &["hal-component"]),
        ("hal-golden", &[]),
        ("hal-protocol", &["hal-abi"]),
        ("hal-beneath", &[]),
        ("hal-ini", &[]),
        ("hal-output", &[]),
        ("hal-trace", &["hal-output", "hal-protocol"]),
        ("hal-engine", &["hal-abi", "hal-output", "hal-protocol", "hal-trace"]),
        (
            "halcmd",
            &[
                "hal-align",
                "hal-arm",
                "hal-engine",
                "hal-gcode",
                "hal-ini",
                "hal-job",
                "hal-output",
                "hal-protocol",
                "hal-trace",
                "hal-trajectory",
            ],
        ),
        ("hal-docs", &[]),
        ("ferrule", &["hal-docs", "hal-ini", "hal-output", "hal-protocol", "hal-trace"]),
        ("halcompile", &["hal-output"]),
        ("hal-arm", &[]),
        ("hal-align", &["hal-gcode", "hal-ini"]),
        ("camera", &["hal-marks", "hal-output"]),
        ("hal-marks", &["hal-align", "hal-ini"]),
        ("align", &["hal-align", "hal-component", "hal-ini", "hal-marks", "hal-output"]),
        (
            "halpanel",
            &[
                "hal-align",
                "hal-beneath",
                "hal-docs",
                "hal-gcode",
                "hal-ini",
                "hal-job",
                "hal-lease",
                "hal-output",
                "hal-protocol",
                "hal-trace",
                "halcmd",
                "teleop",
            ],
        ),
        ("teleop", &["hal-output", "hal-protocol"]),
        ("hal-lease", &["hal-ini", "hal-protocol"]),
        ("rsh", &["hal-ini", "hal-lease", "hal-output", "hal-protocol"]),
        ("robot", &["hal-arm", "hal-component", "hal-gcode", "hal-output"]),
        ("accessory", &["hal-component", "hal-handheld", "hal-nk105", "hal-storage"]),
        ("hal-handheld", &[]),
        ("hal-nk105", &["hal-gcode", "hal-handheld", "hal-job"]),
        ("hal-storage", &["hal-output"]),
        ("hal-lbp16", &[]),
        ("hal-firmware", &[]),
        ("hal-udp", &["port"]),
        ("hal-card", &["hal-firmware", "hal-lbp16"]),
        (
            "hostmot2",
            &["hal-card", "hal-component", "hal-firmware", "hal-lbp16", "hal-udp", "port"],
        ),
        ("hal-modbus", &[]),
        ("hal-modbus-devices", &["hal-modbus"]),
        ("modbus", &["hal-component", "hal-ini", "hal-modbus", "hal-modbus-devices", "port"]),
        ("input", &["hal-component", "hal-ini", "port"]),
        ("kinematics", &["hal-arm", "hal-component"]),
        ("ferrule-client", &["hal-protocol"]),
        ("ferrule-python", &["hal-gcode", "hal-ini", "hal-job", "hal-protocol", "hal-remap"]),
        ("hal-remap", &["hal-gcode", "hal-ini", "hal-output"]),
        (
            "hal-job",
            &["hal-beneath", "hal-gcode", "hal-ini", "hal-output", "hal-remap", "hal-trajectory"],
        ),
        (
            "task",
            &[
                "hal-beneath",
                "hal-component",
                "hal-gcode",
                "hal-ini",
                "hal-job",
                "hal-output",
                "hal-remap",
            ],
        ),
        ("hal-safety", &[]),
        ("motion", &["hal-component", "hal-safety", "hal-trajectory", "hal-watchman"]),
        ("remote", &["hal-component", "hal-safety"]),
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
    for path in files_below(root(), ".rs") {
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
    for path in files_below(&root().join("components"), ".rs") {
        let at = short(&path);
        let compat = at.starts_with("components/foreign/compat/");
        let driver = [
            "components/drivers/gpio/",
            "components/drivers/input/",
            "components/drivers/parport/",
            "components/drivers/viagpio/",
        ]
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
    for path in files_below(&root().join("halcmd"), ".rs") {
        let uses = code(&path).lines().any(|l| l.contains(&format!("{word} {{")));
        assert!(!uses, "{}: no {word} code here", short(&path));
    }
}

#[test]
fn files_have_one_subject() {
    for folder in ["hal", "components", "halcmd", "tests/src"] {
        for path in files_below(&root().join(folder), ".rs") {
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

/// A test that writes where it runs leaves such files beside its `Cargo.toml`.
#[test]
fn crates_hold_no_files_without_an_ending() {
    let mut seen = 0;
    for folder in ["hal", "components", "halcmd", "tests"] {
        for manifest in files_below(&root().join(folder), "Cargo.toml") {
            seen += 1;
            for entry in std::fs::read_dir(manifest.parent().unwrap()).unwrap() {
                let path = entry.unwrap().path();
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                let is_good = path.is_dir() || name.contains('.');
                assert!(is_good, "{}: no file of a crate has such a name", short(&path));
            }
        }
    }
    assert!(40 < seen, "{seen} crates");
}

#[test]
fn realtime_files_do_nothing_that_realtime_must_not() {
    let mut seen = 0;
    for path in files_below(&root().join("hal"), ".rs") {
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
            for w in NOT_REALTIME {
                assert!(!line.contains(w), "{}:{}: {w} in a realtime file", short(&path), i + 1);
            }
        }
    }
    assert!(seen >= 12, "only {seen} realtime files: are their first lines as they should be?");
}

/// Words that a realtime file must not contain.
const NOT_REALTIME: &[&str] = &[
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

/// Further words that a component's realtime file must not contain: they format without memory, which takes its time.
const FORMATS: &[&str] = &["format_args!(", "write_fmt("];

/// Functions in components' realtime files that allocate or lock, because they run while a component is created, opened
/// or closed. `-` stands for declarations outside of functions. Each must be used.
const BEFORE_THREADS: &[(&str, &[&str])] = &[
    ("components/drivers/gpio/src/device.rs", &["messages", "open", "simulate"]),
    ("components/drivers/gpio/src/kernel.rs", &["numbers", "open", "request"]),
    ("components/drivers/input/src/show.rs", &["new"]),
    ("components/drivers/parport/src/device.rs", &["open", "simulated"]),
    ("components/drivers/parport/src/hardware.rs", &["claim", "find"]),
    ("components/drivers/parport/src/lines.rs", &["inputs", "outputs"]),
    (
        "components/drivers/port/src/simulated.rs",
        &["-", "config", "drive", "drive_bits", "new", "show"],
    ),
    (
        "components/drivers/port/src/simulated_lines.rs",
        &["-", "lines", "new", "read_from", "written"],
    ),
    ("components/drivers/speaker/src/device.rs", &["-", "fmt", "lost"]),
    ("components/drivers/stepgen/src/pulses.rs", &["new"]),
    ("components/drivers/viagpio/src/device.rs", &["simulated"]),
    ("components/drivers/viagpio/src/hardware.rs", &["ask"]),
    ("components/drivers/viagpio/src/lines.rs", &["inputs", "outputs"]),
    ("components/mesa/hostmot2/src/modules/dpll.rs", &["make"]),
    ("components/mesa/hostmot2/src/modules/encoder.rs", &["counter", "make_kind"]),
    ("components/mesa/hostmot2/src/modules/inm.rs", &["bank", "make"]),
    ("components/mesa/hostmot2/src/modules/ioport.rs", &["form_name", "make"]),
    ("components/mesa/hostmot2/src/modules/led.rs", &["make"]),
    ("components/mesa/hostmot2/src/modules/outm.rs", &["make"]),
    ("components/mesa/hostmot2/src/modules/pwmgen.rs", &["make"]),
    ("components/mesa/hostmot2/src/modules/raw.rs", &["make"]),
    ("components/mesa/hostmot2/src/modules/ssr.rs", &["make"]),
    ("components/mesa/hostmot2/src/modules/stepgen.rs", &["generator", "make"]),
    ("components/mesa/hostmot2/src/modules/watchdog.rs", &["make"]),
    ("components/mesa/hostmot2/src/simulated.rs", &["board", "new"]),
    (
        "components/mesa/hostmot2/src/world.rs",
        &["encoders", "lights", "line", "make", "outputs", "relays", "scanned"],
    ),
    (
        "components/foreign/compat/src/registers.rs",
        &["claim", "item", "keep", "new", "show", "word_at"],
    ),
    ("components/foreign/compat/src/stream.rs", &["-", "give", "hal_stream_create", "named"]),
    ("components/foreign/compat/src/trap.rs", &["watch"]),
    ("components/motion/kinematics/src/switch.rs", &["make", "usual"]),
    ("components/motion/motion/src/path.rs", &["new"]),
    ("components/motion/motion/src/state.rs", &["new"]),
    ("components/motion/motion/src/switch.rs", &["make"]),
    ("components/motion/toolchange/src/carousel/magazine.rs", &["new"]),
    ("components/motion/toolchange/src/carousel/pocket.rs", &["new"]),
    ("components/motion/trajectory/src/axis.rs", &["new"]),
    ("components/motion/trajectory/src/follower.rs", &["new"]),
    ("components/motion/trajectory/src/slots.rs", &["new"]),
    ("components/motion/trivkins/src/map.rs", &["parse"]),
    ("components/processes/axis/src/waypoints.rs", &["default"]),
    ("components/processes/motor/src/drive.rs", &["declare"]),
    ("components/processes/plasma/src/plasmac/steady.rs", &["default"]),
];

#[test]
fn realtime_files_of_components_allocate_only_before_threads_run() {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in files_below(&root().join("components"), ".rs") {
        let text = code(&path);
        if !text.starts_with("//! Realtime.") {
            continue;
        }
        let mut function = "-".to_owned();
        for line in text.lines().filter(|l| !l.trim_start().starts_with("//")) {
            if line.starts_with('}') {
                function = "-".to_owned();
            }
            if let Some((_, name)) = line.split_once("fn ").filter(|_| !line.contains("fn(")) {
                function =
                    name.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap().into();
            }
            if NOT_REALTIME.iter().chain(FORMATS).any(|w| line.contains(w)) {
                found.entry(short(&path)).or_default().insert(function.clone());
            }
        }
    }
    let known: BTreeMap<String, BTreeSet<String>> = BEFORE_THREADS
        .iter()
        .map(|(file, names)| ((*file).to_owned(), names.iter().map(|n| (*n).to_owned()).collect()))
        .collect();
    assert_eq!(found, known, "functions of realtime files that allocate or lock");
}

#[test]
fn orderings_name_their_partners() {
    for path in files_below(&root().join("hal"), ".rs") {
        let at = short(&path);
        if at.contains("/tests/") || at.contains("/benches/") || at.ends_with("/tests.rs") {
            continue;
        }
        let text = code(&path);
        let lines: Vec<&str> = text.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            let code = line.split("//").next().unwrap();
            let mut words = code.split(|c: char| !c.is_alphanumeric());
            let strong = words.any(|w| ["Acquire", "Release", "AcqRel", "SeqCst"].contains(&w));
            // An import names orderings without using them.
            if !strong || code.contains("Ordering::{") {
                continue;
            }
            let near = &lines[i.saturating_sub(3)..=i];
            let named = near.iter().filter_map(|l| l.split_once("//")).any(|(_, comment)| {
                comment.split(|c: char| !c.is_alphabetic()).any(|w| w.eq_ignore_ascii_case("pairs"))
            });
            assert!(named, "{at}:{}: which access does this pair with?", i + 1);
        }
    }
}

/// Places in `hal/` that know the operating system's interface, with the word for it. Each must be used.
const SYSTEM: &[(&str, &str)] = &[
    ("hal/beneath/src/", "rustix"),
    ("hal/engine/src/ends/", "libc"),
    ("hal/engine/src/ends/", "rustix"),
    ("hal/engine/src/load/code.rs", "libloading"),
    ("hal/engine/src/load/loader.rs", "libloading"),
    ("hal/engine/src/load/opening.rs", "rustix"),
    ("hal/engine/src/load/plugin_file.rs", "rustix"),
    ("hal/engine/src/observe/ring.rs", "rustix"),
    ("hal/engine/src/observe/snapshot.rs", "rustix"),
    ("hal/engine/src/os.rs", "libc"),
    ("hal/engine/src/os.rs", "rustix"),
    ("hal/engine/src/os/", "libc"),
    ("hal/engine/src/os/", "rustix"),
    ("hal/engine/src/serve/client.rs", "rustix"),
    ("hal/engine/src/serve/server.rs", "rustix"),
    ("hal/output/src/", "nix"),
    ("hal/output/src/", "rustix"),
    ("hal/protocol/src/client.rs", "rustix"),
    ("hal/protocol/src/peer.rs", "libc"),
    ("hal/protocol/src/folder.rs", "rustix"),
    ("hal/protocol/src/place.rs", "rustix"),
    ("hal/protocol/src/snapshot.rs", "rustix"),
    ("hal/protocol/src/stream.rs", "rustix"),
];

#[test]
fn few_files_know_the_system() {
    let mut used = BTreeSet::new();
    for path in files_below(&root().join("hal"), ".rs") {
        let at = short(&path);
        if at.contains("/tests/") || at.contains("/benches/") || at.ends_with("/tests.rs") {
            continue;
        }
        let text = code(&path);
        for line in text.lines().map(str::trim_start).filter(|l| !l.starts_with("//")) {
            for word in ["libc", "libloading", "nix", "rustix"] {
                let path_of = format!("{word}::");
                let is_used = line.match_indices(&path_of).any(|(n, _)| {
                    !line[..n].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':')
                });
                if is_used {
                    let known =
                        SYSTEM.iter().find(|(place, w)| *w == word && at.starts_with(place));
                    used.insert(*known.unwrap_or_else(|| panic!("{at}: {word} has its places")));
                }
            }
        }
    }
    let all: BTreeSet<_> = SYSTEM.iter().copied().collect();
    assert_eq!(used, all, "places of which some no longer need the system");
}

/// Error enums with texts, and the reason.
const TEXTS: &[(&str, &str, &str)] = &[
    (
        "hal/component/src/motion/user.rs",
        "MotionRefusal",
        "the text of another library, which has its own error enum",
    ),
    (
        "halcmd/src/programs/haltest/failure.rs",
        "Failure",
        "what the program prints before it ends; no other code reads it",
    ),
];

#[test]
fn errors_are_enums_without_strings() {
    let mut found = BTreeSet::new();
    for folder in ["hal", "halcmd", "components"] {
        for path in files_below(&root().join(folder), ".rs") {
            let at = short(&path);
            if at.contains("/tests/") || at.contains("/benches/") || at.ends_with("/tests.rs") {
                continue;
            }
            let file = syn::parse_file(&code(&path)).unwrap_or_else(|e| panic!("{at}: {e}"));
            let mut enums = Enums::default();
            enums.visit_file(&file);
            found.extend(enums.found.into_iter().map(|name| (at.clone(), name)));
        }
    }
    let known = TEXTS.iter().map(|(at, name, _)| ((*at).to_owned(), (*name).to_owned())).collect();
    assert_eq!(found, known, "error enums that carry a String");
}

/// Collects the enums that are errors by their names and carry a `String`.
#[derive(Default)]
struct Enums {
    found: BTreeSet<String>,
}

impl<'ast> Visit<'ast> for Enums {
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        let name = item.ident.to_string();
        let is_error = ["Error", "Failure", "Fault", "Refusal", "Trouble"]
            .iter()
            .any(|word| name.ends_with(word));
        let mut strings = Strings(false);
        strings.visit_item_enum(item);
        if is_error && strings.0 {
            self.found.insert(name);
        }
    }
}

/// Visitor that is true after a `String`.
struct Strings(bool);

impl<'ast> Visit<'ast> for Strings {
    fn visit_path_segment(&mut self, segment: &'ast syn::PathSegment) {
        self.0 |= segment.ident == "String";
        visit::visit_path_segment(self, segment);
    }
}

#[test]
fn atomics_of_the_engine_come_from_one_module() {
    for path in files_below(&root().join("hal/engine/src"), ".rs") {
        let text = code(&path);
        let direct = text.contains("std::sync::atomic") || text.contains("core::sync::atomic");
        assert!(!direct || path.ends_with("sync.rs"), "{}: use crate::sync", short(&path));
    }
}

#[test]
fn golden_files_are_accepted_in_one_way() {
    // The variable in quotes, as code that reads it has it.
    let variable = format!("{:?}", "UPDATE_EXPECT");
    let reads = |path: &PathBuf| std::fs::read_to_string(path).unwrap().contains(&variable);
    let files: Vec<String> = ["hal", "halcmd", "components", "tests"]
        .iter()
        .flat_map(|folder| files_below(&root().join(folder), ".rs"))
        .filter(|path| reads(path) && !path.ends_with("tests/tests/system/tidy.rs"))
        .map(|path| short(&path))
        .collect();
    assert_eq!(files, ["hal/golden/src/lib.rs"]);
}

/// Walks the crates that write tool tables, parameters and the record of the spindle.
#[test]
fn the_task_replaces_no_file_without_its_earlier_state() {
    let writes = |call: &str| -> Vec<String> {
        let files = files_below(&root().join("components/motion"), ".rs");
        files.iter().filter(|path| code(path).contains(call)).map(|path| short(path)).collect()
    };
    assert_eq!(writes("hal_output::write("), [""; 0]);
    assert_eq!(writes("hal_output::write_kept("), ["components/motion/task/src/worker/files.rs"]);
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
        ("components/remote/panel/src/audit.rs", "a log that only grows, line by line"),
        (
            "components/accessory/accessory/src/sim_medium.rs",
            "a disk image, of which nothing is changed",
        ),
        (
            "components/accessory/storage/src/folder.rs",
            "disk images, written in place while nobody sees them",
        ),
        ("components/accessory/storage/src/gadget.rs", device),
        ("components/drivers/gpio/src/kernel.rs", device),
        ("components/drivers/parport/src/hardware.rs", device),
        ("components/drivers/speaker/src/device.rs", device),
        ("components/drivers/viagpio/src/hardware.rs", device),
        ("hal/golden/src/lib.rs", "expected files, which only tests write"),
        ("hal/golden/src/tools.rs", "a list of skipped tests that only grows, line by line"),
        ("hal/engine/src/os/processors.rs", device),
        ("hal/engine/src/ends/apart.rs", device),
        ("hal/engine/src/ends/watcher.rs", "a lock, and a recording that a kill has cut"),
        ("halcmd/src/programs/halrun/detach.rs", device),
        ("halcmd/src/programs/haltest/one.rs", scratch),
        ("halcmd/src/programs/haltest/process.rs", scratch),
        ("halcmd/src/programs/haltest/stage.rs", scratch),
    ]);
    for folder in ["hal", "halcmd", "components"] {
        for path in files_below(&root().join(folder), ".rs") {
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
    for path in files_below(root(), ".rs") {
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
    for path in files_below(&root().join("hal/engine/src"), ".rs") {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let known = map.contains(&format!("`{name}`"));
        assert!(known, "hal/README.md: the code map has no `{name}`");
    }
}
