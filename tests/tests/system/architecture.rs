//! The structure of the code: circles among modules, and the maps of its folders.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests; the circles are shown")]

use hal_tests::{
    imports::{circles, imports},
    programs::{families, files_below, root, short},
};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// Maximum number of modules of a crate that may depend on each other in a circle.
const MAX_CIRCLE: usize = 6;

#[test]
fn no_circle_of_modules_is_large() {
    let mut crates: BTreeMap<String, PathBuf> =
        families().into_iter().map(|(name, path)| (name, path.join("src"))).collect();
    for name in
        ["abi", "beneath", "component", "derive", "engine", "ini", "output", "protocol", "trace"]
    {
        crates.insert(format!("hal-{name}"), root().join("hal").join(name).join("src"));
    }
    crates.insert("halcmd".to_owned(), root().join("halcmd/src"));
    crates.insert("hal-tests".to_owned(), root().join("tests/src"));
    let mut larger = BTreeMap::new();
    for (name, src) in crates {
        let graph = imports(&src);
        let found = circles(&graph);
        let Some(largest) = found.first().filter(|c| c.len() > MAX_CIRCLE) else { continue };
        println!("{name}: {} of {} modules: {}", largest.len(), graph.len(), largest.join(" "));
        larger.insert(name, largest.len());
    }
    assert_eq!(
        larger,
        BTreeMap::new(),
        "crates with a circle of more than {MAX_CIRCLE} modules, by its size"
    );
}

/// Parts of the engine: the file, the part, and the room that sees its fields.
const PARTS: &[(&str, &str, &str)] = &[
    ("graph/model.rs", "Model", "graph"),
    ("realtime/runtime.rs", "Runtime", "realtime"),
    ("observe/observers.rs", "Observers", "observe"),
    ("serve/clients.rs", "Clients", "serve"),
    ("messages/log.rs", "Log", "messages"),
];

#[test]
fn fields_of_the_engines_parts_are_seen_in_their_rooms_alone() {
    for (file, part, room) in PARTS {
        let text = fs::read_to_string(root().join("hal/engine/src").join(file)).unwrap();
        let items = syn::parse_file(&text).unwrap().items;
        let part = items.iter().find_map(|item| match item {
            syn::Item::Struct(s) if s.ident == part => Some(s),
            _ => None,
        });
        let part = part.unwrap_or_else(|| panic!("{file}: no part"));
        assert!(part.fields.len() > 3, "{file}: a part of {} fields", part.fields.len());
        for field in &part.fields {
            let own = match &field.vis {
                syn::Visibility::Inherited => true,
                syn::Visibility::Restricted(r) => {
                    let path: Vec<_> =
                        r.path.segments.iter().map(|s| s.ident.to_string()).collect();
                    path == ["crate", room]
                }
                syn::Visibility::Public(_) => false,
            };
            let name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
            assert!(own, "{file}: the field {name} is seen outside {room}/");
        }
    }
}

/// Folders of source files, with the page that maps each.
const MAPS: &[(&str, &str)] = &[
    ("hal/engine/src", "hal/README.md"),
    ("halcmd/src", "halcmd/README.md"),
    ("components/motion/motion/src", "components/motion/README.md"),
    ("components/motion/kinematics/src", "components/motion/README.md"),
    ("tests/tests/system", "tests/README.md"),
];

/// Largest number of types that share a name, tests not included.
const MAX_NAMESAKES: usize = 8;
/// Names that more types have, each the only one of its kind where it is, and the largest number of them.
const COMMON_NAMES: &[(&str, usize)] = &[
    ("Entry", 9),
    ("Error", 10),
    ("Id", 16),
    ("Kind", 14),
    ("Pins", 30),
    ("Run", 10),
    ("State", 12),
    ("Step", 11),
];

#[test]
fn few_types_share_a_name() {
    let mut names: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for folder in ["hal", "halcmd", "components"] {
        for path in files_below(&root().join(folder), ".rs") {
            let at = short(&path);
            if at.contains("/tests/") || at.ends_with("tests.rs") {
                continue;
            }
            let text = fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for name in code.lines().filter_map(named_type) {
                names.entry(name.to_owned()).or_default().push(at.clone());
            }
        }
    }
    let most = |name: &str| {
        COMMON_NAMES.iter().find(|row| row.0 == name).map_or(MAX_NAMESAKES, |row| row.1)
    };
    let mut bad = Vec::new();
    for (name, files) in &names {
        if files.len() > most(name) {
            bad.push(format!("{} types are named {name}: {}", files.len(), files.join(" ")));
        }
    }
    assert!(names.len() > 1000, "only {} names", names.len());
    assert!(bad.is_empty(), "name some of them by what they are:\n{}", bad.join("\n"));
    for (name, _) in COMMON_NAMES {
        let count = names.get(*name).map_or(0, Vec::len);
        assert!(count > MAX_NAMESAKES, "{name}: {count} types need no number of their own");
    }
}

/// Returns the name of the type that begins on a line.
fn named_type(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let line = match line.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
        Some(rest) => rest.trim_start(),
        None => line,
    };
    let rest =
        ["struct ", "enum ", "trait ", "union "].iter().find_map(|k| line.strip_prefix(k))?;
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    name.starts_with(char::is_uppercase).then_some(name)
}

#[test]
fn every_room_is_on_a_map() {
    for (folder, page) in MAPS {
        let map = fs::read_to_string(root().join(page)).unwrap();
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let known = match path.is_dir() {
                true => name == "bin" || name == "tests" || map.contains(&format!("`{name}/`")),
                false => {
                    ["lib.rs", "tests.rs", "main.rs"].contains(&name.as_str()) || on(&map, &path)
                }
            };
            assert!(known, "{page}: the map has no `{name}` of {folder}");
        }
    }
}

/// Returns whether a map names a file, or the room of the same name.
fn on(map: &str, path: &Path) -> bool {
    let stem = path.file_stem().unwrap().to_string_lossy();
    map.contains(&format!("`{stem}.rs`")) || map.contains(&format!("`{stem}/`"))
}

#[test]
fn every_file_of_a_room_is_on_a_map() {
    for (folder, page) in MAPS.iter().filter(|(folder, _)| !folder.starts_with("tests/")) {
        let map = fs::read_to_string(root().join(page)).unwrap();
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let room = entry.unwrap().path();
            if !room.is_dir() || room.ends_with("bin") || room.ends_with("tests") {
                continue;
            }
            for entry in fs::read_dir(room).unwrap() {
                let path = entry.unwrap().path();
                let known = on(&map, &path) || path.ends_with("tests.rs");
                assert!(known, "{page}: the map has no {}", path.display());
            }
        }
    }
}

#[test]
fn every_crate_is_on_the_map_of_its_group() {
    let mut groups = BTreeMap::new();
    for (name, path) in families() {
        let page = path.parent().unwrap().join("README.md");
        let group = groups
            .entry(page.clone())
            .or_insert_with(|| fs::read_to_string(&page).unwrap_or_default());
        let manifest: toml::Table =
            fs::read_to_string(path.join("Cargo.toml")).unwrap().parse().unwrap();
        let description = manifest["package"]["description"].as_str().unwrap();
        let folder = path.file_name().unwrap().to_string_lossy().into_owned();
        let row = format!("| [`{folder}`]({folder}/) | {description} |");
        let inside = page.ends_with("compat/README.md");
        assert!(inside || group.contains(&row), "{}: no row {row} for {name}", page.display());
    }
}

#[test]
fn the_map_of_tests_names_every_folder() {
    let map = fs::read_to_string(root().join("tests/README.md")).unwrap();
    for entry in fs::read_dir(root().join("tests")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let known = !path.is_dir() || name == "tests" || map.contains(&format!("`{name}/`"));
        assert!(known, "tests/README.md: the map has no `{name}/`");
    }
}

/// Folders to which the paths of the walks in `hal/README.md` are relative.
const WALKED: &[&str] = &[
    "halcmd/src",
    "hal/protocol/src",
    "hal/engine/src",
    "hal/component/src",
    "components/drivers",
];

#[test]
fn the_walks_lead_through_files_and_names_that_exist() {
    let page = fs::read_to_string(root().join("hal/README.md")).unwrap();
    let walks = page.split_once("## The path of a value").unwrap().1;
    let walks = walks.split_once("### What the structure measures").unwrap().0;
    let (mut steps, mut names) = (0, 0);
    for line in walks.lines() {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, number, files, action, _] = cells.as_slice() else { continue };
        if number.parse::<u32>().is_err() {
            continue;
        }
        steps += 1;
        let mut code = String::new();
        for path in quoted(files).chain(quoted(action).filter(|name| name.ends_with(".rs"))) {
            let all = WALKED.iter().map(|folder| root().join(folder).join(path));
            let found: Vec<PathBuf> = all.filter(|file| file.is_file()).collect();
            assert_eq!(found.len(), 1, "step {number}: files for `{path}`: {found:?}");
            code.extend(found.iter().map(|file| fs::read_to_string(file).unwrap()));
        }
        for name in quoted(action).filter(|name| !name.ends_with(".rs")) {
            let word = name.rsplit("::").next().unwrap();
            let mut words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
            assert!(words.any(|w| w == word), "step {number}: its files have no `{name}`");
            names += 1;
        }
    }
    assert!(steps == 20 && names > 10, "{steps} steps, {names} names");
}

/// Returns the words between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}
