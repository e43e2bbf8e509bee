//! The plugins of `tests/plugins`, which fail on demand, and files that are not plugins.

use crate::programs::{cargo, root, target};
use std::{
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    sync::OnceLock,
};

/// Further names of `libbroken.so`, each with a descriptor of its own.
pub const BROKEN: [&str; 10] =
    ["bare", "cut", "hollow", "latin", "longer", "major", "minor", "mute", "nameless", "nulls"];

/// Returns a folder with all of them, built if necessary:
///
/// - `libfaulty.so`: components that fail; each file of `tests/plugins/faulty` documents its failure;
/// - `libNAME.so` for every name of [`BROKEN`], and `libstub.so`: descriptors that must be refused;
/// - `libaborts.so`, whose panics end the process, and `libnothing.so`, which has no descriptor;
/// - `librenamed.so`, a good plugin under a name other than its own;
/// - `libtext.so`, `libempty.so`, `libhalf.so`, `libalien.so` and the folder `libfolder.so`, which are not libraries.
pub fn plugins() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = built("debug").with_file_name("plugins");
        fs::create_dir_all(folder.join("libfolder.so")).unwrap();
        let (debug, abort) = (built("debug"), built("abort"));
        for name in ["faulty", "nothing"] {
            put(&folder, name, &debug.join(format!("lib{name}.so")));
        }
        for name in BROKEN.iter().chain(&["stub"]) {
            put(&folder, name, &debug.join("libbroken.so"));
        }
        put(&folder, "renamed", &debug.join("libfaulty.so"));
        put(&folder, "aborts", &abort.join("libaborts.so"));
        let whole = fs::read(debug.join("libnothing.so")).unwrap();
        write(&folder, "text", b"#!/bin/sh\necho this is no library\n");
        write(&folder, "empty", b"");
        write(&folder, "half", whole.get(..whole.len() / 2).unwrap());
        let mut alien = fs::read(debug.join("libbroken.so")).unwrap();
        // The machine field of the ELF header: set to one that does not exist.
        alien.splice(18..20, [0xfe, 0xfe]);
        write(&folder, "alien", &alien);
        folder
    })
}

/// Returns the library for `LD_PRELOAD` that counts the allocations of realtime threads.
pub fn interpose() -> PathBuf {
    built("debug").join("libinterpose.so")
}

/// Returns the folder into which a profile of `tests/plugins` is built.
fn built(profile: &str) -> PathBuf {
    static TARGET: OnceLock<PathBuf> = OnceLock::new();
    let target = TARGET.get_or_init(|| {
        let target = target().0.join("test-plugins");
        let manifest = root().join("tests/plugins/Cargo.toml");
        for words in [&["--workspace"][..], &["--package", "aborts", "--profile", "abort"]] {
            let mut cargo = cargo("build");
            cargo.args(["--locked", "--quiet", "--manifest-path"]).arg(&manifest);
            let status = cargo.args(words).arg("--target-dir").arg(&target).status().unwrap();
            assert!(status.success(), "tests/plugins does not build");
        }
        target
    });
    target.join(profile)
}

/// Copies a file to another name, atomically, because concurrent tests may read it.
fn put(folder: &Path, name: &str, file: &Path) {
    placed(folder, name, |path| symlink(file, path).unwrap());
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    placed(folder, name, |path| fs::write(path, bytes).unwrap());
}

fn placed(folder: &Path, name: &str, make: impl FnOnce(&Path)) {
    let unfinished = folder.join(format!(".{}-{name}", std::process::id()));
    make(&unfinished);
    fs::rename(&unfinished, folder.join(format!("lib{name}.so"))).unwrap();
}

#[cfg(test)]
mod tests {
    use super::root;
    use std::{collections::BTreeSet, fs};

    /// Building the test plugins must not need a download.
    #[test]
    fn the_plugins_for_tests_use_no_other_versions_than_the_workspace() {
        let packages = |file: &str| -> BTreeSet<String> {
            let text = fs::read_to_string(root().join(file)).unwrap();
            let fetched = |p: &&str| p.contains("\nsource = ");
            let version = |p: &str| p.lines().skip(1).take(2).collect::<Vec<_>>().join(" ");
            text.split("[[package]]").filter(fetched).map(version).collect()
        };
        let (ours, all) = (packages("tests/plugins/Cargo.lock"), packages("Cargo.lock"));
        assert!(!ours.is_empty() && ours.is_subset(&all), "{:?}", ours.difference(&all));
    }
}
