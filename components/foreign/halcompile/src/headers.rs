//! Headers for components in C, embedded in the program and written where compilers find them.

use crate::error::{Error, at};
use std::{
    env, fs,
    hash::{DefaultHasher, Hash, Hasher},
    path::{Path, PathBuf},
};

include!(concat!(env!("OUT_DIR"), "/headers.rs"));

/// Makefile fragment that builds modules as `halcompile` does.
const MODINC: &str = include_str!("modinc.mk");

/// Returns the folder with the headers: `HAL_INCLUDE_DIR`, or a folder that is written to the user's cache.
///
/// # Errors
/// The folder cannot be written.
pub fn include_folder() -> Result<PathBuf, Error> {
    match env::var_os("HAL_INCLUDE_DIR").filter(|v| !v.is_empty()) {
        Some(folder) => Ok(folder.into()),
        None => laid_out(),
    }
}

/// Returns the path of the file that makefiles include.
///
/// # Errors
/// The file cannot be written.
pub fn modinc() -> Result<PathBuf, Error> {
    Ok(laid_out()?.join("Makefile.modinc"))
}

/// Returns the folder for exactly this set of headers; its content never changes.
fn laid_out() -> Result<PathBuf, Error> {
    let mut hash = DefaultHasher::new();
    (HEADERS, MODINC).hash(&mut hash);
    let folder = cache().join(format!("include-{:016x}", hash.finish()));
    if folder.is_dir() {
        return Ok(folder);
    }
    let unfinished = folder.with_extension(std::process::id().to_string());
    for (name, text) in HEADERS {
        write(&unfinished.join(name), text)?;
    }
    let makefile = MODINC.replace("@INCLUDE@", &folder.display().to_string());
    write(&unfinished.join("Makefile.modinc"), &makefile)?;
    // Another process may have written it first; both are the same.
    if fs::rename(&unfinished, &folder).is_err() {
        drop(fs::remove_dir_all(&unfinished));
    }
    if folder.is_dir() {
        Ok(folder)
    } else {
        Err(Error::NoHeaders { folder: folder.display().to_string().into() })
    }
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(at(folder))?;
    }
    fs::write(path, text).map_err(at(path))
}

fn cache() -> PathBuf {
    let given = |name| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = given("XDG_CACHE_HOME").or_else(|| given("HOME").map(|h| h.join(".cache")));
    base.filter(|b| fs::create_dir_all(b.join("ferrule")).is_ok())
        .unwrap_or_else(env::temp_dir)
        .join("ferrule")
}
