//! Makes the folder `python` beside the library, which `halrun` puts on `PYTHONPATH`: the modules in Python, and the
//! library under its name as a module.

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
    fs::create_dir_all(&beside)?;
    for entry in fs::read_dir(here.join("modules"))? {
        let entry = entry?;
        fs::copy(entry.path(), beside.join(entry.file_name()))?;
    }
    let module = beside.join("_hal.abi3.so");
    match fs::remove_file(&module) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => std::os::unix::fs::symlink("../libferrule_python.so", module),
    }
}
