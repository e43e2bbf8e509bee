//! Makes the folder `tcl` beside the programs, which `halrun` puts on `TCLLIBPATH`: the packages for Tcl, and the start of
//! Tcl files.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=tcl");
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    // OUT_DIR is `PROFILE/build/PACKAGE/out`.
    let beside = out.ancestors().nth(3).unwrap_or(Path::new(".")).join("tcl");
    fs::create_dir_all(&beside)?;
    for entry in fs::read_dir(here.join("tcl"))? {
        let (path, name) = entry.map(|e| (e.path(), e.file_name()))?;
        fs::copy(path, beside.join(name))?;
    }
    Ok(())
}
