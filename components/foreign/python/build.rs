//! Makes the folder `python` beside the library, which `halrun` puts on `PYTHONPATH`: the modules in Python, and the
//! library under the names of its modules.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
};

/// Modules of the library.
const MODULES: [&str; 3] = ["_hal", "_machine", "gcode"];

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=modules");
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    // OUT_DIR is `PROFILE/build/PACKAGE/out`.
    let beside = out.ancestors().nth(3).unwrap_or(Path::new(".")).join("python");
    copy(&here.join("modules"), &beside)?;
    for name in MODULES {
        let module = beside.join(format!("{name}.abi3.so"));
        match fs::remove_file(&module) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => std::os::unix::fs::symlink("../libferrule_python.so", module)?,
        }
    }
    Ok(())
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
