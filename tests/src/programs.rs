//! Programs and plugins under test: built once per test process and run from there.

use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::OnceLock,
};

/// Returns the folder with halrun, halcmd and every plugin, and builds them if necessary. If `HAL_TEST_PROGRAMS` names
/// a folder, that folder is used unchanged.
pub fn programs() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        if let Some(folder) = std::env::var_os("HAL_TEST_PROGRAMS") {
            return PathBuf::from(folder);
        }
        let (target, profile) = target();
        let mut cargo = cargo("build");
        cargo.args(["--workspace", "--exclude", "hal-tests", "--lib", "--bins", "--quiet"]);
        cargo.arg("--target-dir").arg(&target).args(["--profile", dev(&profile)]);
        let folder = target.join(&profile);
        let built = cargo.arg("--message-format=json-render-diagnostics");
        let built = built.stderr(Stdio::inherit()).output().unwrap();
        assert!(built.status.success(), "the programs under test do not build");
        forget_others(&folder, &built.stdout);
        folder
    })
}

/// Removes the plugins that this build, according to cargo's messages, did not produce: a family that was removed from
/// the workspace would otherwise still offer its components there.
fn forget_others(folder: &Path, built: &[u8]) {
    let lines = serde_json::Deserializer::from_slice(built).into_iter::<serde_json::Value>();
    let made: BTreeSet<_> = lines
        .flat_map(|line| line.unwrap()["filenames"].as_array().cloned().unwrap_or_default())
        .filter_map(|path| Path::new(path.as_str().unwrap()).file_name().map(OsStr::to_owned))
        .collect();
    assert!(!made.is_empty(), "cargo does not say what it made");
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        if entry.path().extension().is_some_and(|e| e == "so") && !made.contains(&entry.file_name())
        {
            fs::remove_file(entry.path()).unwrap();
        }
    }
}

/// Returns a cargo command for this workspace.
pub fn cargo(command: &str) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.arg(command).current_dir(root()).stdin(Stdio::null());
    cargo
}

/// Returns the name of a test of this program as its command line takes it; `module` is `module_path!()`.
/// Without a name, what the names of all tests of the module begin with.
pub fn own_test(module: &str, name: &str) -> String {
    let rooms = module.split_once("::").map_or("", |(_, rooms)| rooms);
    if rooms.is_empty() { name.to_owned() } else { format!("{rooms}::{name}") }
}

/// Runs tests of this program in another process.
///
/// # Panics
/// One of them fails, or there is none.
pub fn passes(again: &mut Command) {
    let output = again.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && !said.contains("running 0 tests"), "{said}");
}

/// Returns the target folder of this test's build, and the name of the profile's folder in it.
pub fn target() -> (PathBuf, String) {
    let exe = std::env::current_exe().unwrap();
    let profile = exe.ancestors().nth(2).unwrap();
    let name = profile.file_name().unwrap().to_string_lossy().into_owned();
    (profile.parent().unwrap().to_owned(), name)
}

/// Returns the root folder of the workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Returns every file below `folder` with this ending, sorted, without build output and hidden folders.
pub fn files_below(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy();
        if path.is_dir() {
            if name != "target" && !name.starts_with('.') {
                found.extend(files_below(&path, ending));
            }
        } else if name.ends_with(ending) {
            found.push(path);
        }
    }
    found
}

/// Returns a path relative to the repository's root.
pub fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().display().to_string()
}

/// Returns the folder of each crate of `components/`, by the folder's own name.
///
/// # Panics
/// There are too few for a workspace, so the search looked in the wrong folder.
pub fn families() -> BTreeMap<String, PathBuf> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root().join("components")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.join("Cargo.toml").is_file() {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                found.insert(name, path.clone());
            }
            let source = path.file_name().is_some_and(|n| n == "src" || n == "tests");
            if path.is_dir() && !source {
                folders.push(path);
            }
        }
    }
    assert!(found.len() > 25, "only {} crates in components/", found.len());
    found
}

/// Returns the folder of one crate of `components/`.
///
/// # Panics
/// No crate has this name.
pub fn family(library: &str) -> PathBuf {
    families().remove(library).unwrap_or_else(|| panic!("no crate {library} in components/"))
}

/// Returns the profile that builds into this folder.
fn dev(folder: &str) -> &str {
    if folder == "debug" { "dev" } else { folder }
}
