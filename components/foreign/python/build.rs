//! Makes the folder `python` beside the library, which `halrun` puts on `PYTHONPATH`: the modules in Python, and the
//! library.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=modules");
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    // OUT_DIR is `PROFILE/build/PACKAGE/out`.
    let beside = out.ancestors().nth(3).unwrap_or(Path::new(".")).join("python");
    copy(&here.join("modules"), &beside)?;
    // Before, each module of the library was a link to it.
    for old in ["_hal", "_machine", "gcode"] {
        removed(&beside.join(format!("{old}.abi3.so")))?;
    }
    let library = beside.join("ferrule/_library.abi3.so");
    removed(&library)?;
    std::os::unix::fs::symlink("../../libferrule_python.so", library)
}

/// Removes a file that may be missing.
fn removed(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Copies the modules of a folder and its packages.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let (path, name) = entry.map(|e| (e.path(), e.file_name()))?;
        if path.is_dir() && name != "__pycache__" {
            copy(&path, &to.join(name))?;
        } else if path.is_file() {
            fs::copy(&path, to.join(name))?;
        }
    }
    Ok(())
}
