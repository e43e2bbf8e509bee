//! The programs and plugins under test: built once, found, run.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::OnceLock,
};

/// The folder with halrun, halcmd and every plugin, built if need be. `HAL_TEST_PROGRAMS` names
/// one that is to be taken as it is.
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
        let status = cargo.status().unwrap();
        assert!(status.success(), "the programs under test do not build");
        target.join(profile)
    })
}

/// A cargo command for this workspace.
pub fn cargo(command: &str) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.arg(command).current_dir(root()).stdin(Stdio::null());
    cargo
}

/// Where this test was built: the target folder, and in it the profile's.
pub fn target() -> (PathBuf, String) {
    let exe = std::env::current_exe().unwrap();
    let profile = exe.ancestors().nth(2).unwrap();
    let name = profile.file_name().unwrap().to_string_lossy().into_owned();
    (profile.parent().unwrap().to_owned(), name)
}

/// The workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The profile that builds into this folder.
fn dev(folder: &str) -> &str {
    if folder == "debug" { "dev" } else { folder }
}
