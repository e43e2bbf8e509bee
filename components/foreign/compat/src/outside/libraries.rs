//! Libraries that a file brings into this process when it is opened.

use crate::{objects, system};
use std::{
    os::unix::ffi::OsStrExt,
    path::{Path, PathBuf},
    process::Command,
};

/// Returns the libraries that would be loaded with a file and that this process does not have yet. `needed` are the
/// names of those that it asks for itself.
///
/// # Errors
/// The dynamic linker cannot be asked.
pub(super) fn brought_by(path: &Path, needed: &[String]) -> Result<Vec<PathBuf>, String> {
    if needed.iter().all(|name| system::is_open(name.as_bytes())) {
        return Ok(Vec::new());
    }
    let asked = |e: &dyn core::fmt::Display| format!("{}: its libraries: {e}", path.display());
    let linker = linker().ok_or_else(|| asked(&"the dynamic linker is not known"))?;
    // The linker, as a program, lists the libraries without running any of their code.
    let out = Command::new(linker).arg("--list").arg(path).output().map_err(|e| asked(&e))?;
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let files = listed(&text).map(PathBuf::from);
    // What is missing is the opening's to report.
    Ok(files.filter(|file| !system::is_open(file.as_os_str().as_bytes())).collect())
}

/// Returns the path of the dynamic linker of this process.
fn linker() -> Option<PathBuf> {
    // SAFETY: queries a constant of the process.
    let base = unsafe { libc::getauxval(libc::AT_BASE) };
    let found = objects::mapped().into_iter().find(|o| o.base as u64 == base)?;
    found.path.to_str().ok().map(PathBuf::from).filter(|path| path.is_absolute())
}

/// Returns the paths in the linker's list: `NAME => PATH (ADDRESS)` or `PATH (ADDRESS)`.
fn listed(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let line = line.rsplit(" => ").next()?.trim();
        let (path, _) = line.rsplit_once(" (0x")?;
        path.starts_with('/').then_some(path)
    })
}

#[cfg(test)]
mod tests {
    use super::{brought_by, listed};
    use std::path::Path;

    #[test]
    fn the_list_of_the_linker() {
        let text = "\tlinux-vdso.so.1 (0x00007ffd)\n\tliba.so => /x y/liba.so (0x7f01)\n\
                    \tlibb.so => not found\n\t/lib64/ld-linux-x86-64.so.2 (0x7f02)\n";
        let found: Vec<&str> = listed(text).collect();
        assert_eq!(found, ["/x y/liba.so", "/lib64/ld-linux-x86-64.so.2"]);
    }

    #[test]
    fn what_the_process_has_is_not_brought() {
        let me = std::env::current_exe().unwrap();
        assert_eq!(brought_by(&me, &["libc.so.6".into()]), Ok(Vec::new()));
        let absent = brought_by(Path::new("/nonexistent.so"), &["libabsent.so".into()]);
        assert_eq!(absent, Ok(Vec::new()));
    }
}
