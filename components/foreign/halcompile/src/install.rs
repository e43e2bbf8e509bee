//! Installation of results in folders where programs find them.

use crate::error::{Error, at};
use std::{
    env, fs,
    io::{IsTerminal, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Returns the folder of modules: the first of `HAL_RTMOD_DIR`, or beside this program, where
/// `halrun` looks.
///
/// # Errors
/// No such folder is known, or it cannot be created.
pub fn modules() -> Result<PathBuf, Error> {
    let asked = env::var("HAL_RTMOD_DIR").unwrap_or_default();
    let first = asked.split(':').find(|f| !f.is_empty()).map(PathBuf::from);
    made(first.or_else(here), "modules", "HAL_RTMOD_DIR")
}

/// Returns the folder of programs: `USER_MODULE_DIR`, or beside this program, where `loadusr` looks
/// first.
///
/// # Errors
/// No such folder is known, or it cannot be created.
pub fn programs() -> Result<PathBuf, Error> {
    let asked = env::var_os("USER_MODULE_DIR").filter(|v| !v.is_empty()).map(PathBuf::from);
    made(asked.or_else(here), "programs", "USER_MODULE_DIR")
}

/// Installs a Python program under its name without `.py`: its first line finds Python by PATH.
///
/// # Errors
/// The file cannot be read or written.
pub fn python(file: &Path) -> Result<(), Error> {
    let text = fs::read_to_string(file).map_err(at(file))?;
    let body = match text.strip_prefix("#!") {
        Some(rest) => rest.split_once('\n').map_or("", |(_, body)| body),
        None => &text,
    };
    let out = programs()?.join(file.file_stem().unwrap_or_default());
    let text = format!("#!/usr/bin/env python3\n{body}");
    hal_output::install(&out, text.as_bytes(), 0o555).map_err(at(&out))
}

/// Installs a manual page where `man` looks: below `HAL_MAN_DIR`, or in the user's own folder.
///
/// # Errors
/// The page cannot be written.
pub fn page(name: &str, section: u32, roff: &str) -> Result<(), Error> {
    let given = |name| env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let base = given("HAL_MAN_DIR").or_else(|| given("HOME").map(|h| h.join(".local/share/man")));
    let folder = base.map(|b| b.join(format!("man{section}")));
    let out = made(folder, "manual pages", "HAL_MAN_DIR")?.join(name);
    hal_output::write(&out, roff.as_bytes()).map_err(at(&out))
}

/// Shows a page with `man` if standard output is a terminal, and returns an empty text. Otherwise
/// returns the output of `man`, or the page as it is if there is no `man`. `man` reads the page
/// from a pipe, so that no file is created that another user could have put there first.
pub fn view(roff: &str) -> String {
    let is_terminal = std::io::stdout().is_terminal();
    let mut man = Command::new("man");
    man.args(["-l", "-"]).stdin(Stdio::piped());
    if !is_terminal {
        man.stdout(Stdio::piped());
    }
    let printed = man.spawn().ok().and_then(|mut man| {
        let page = man.stdin.take();
        std::thread::scope(|scope| {
            // A `man` that does not read to the end shows what it has read.
            scope.spawn(move || page.map(|mut page| page.write_all(roff.as_bytes())));
            man.wait_with_output().ok()
        })
    });
    let printed = printed.filter(|p| p.status.success());
    printed.map_or_else(|| roff.to_owned(), |p| String::from_utf8_lossy(&p.stdout).into_owned())
}

fn here() -> Option<PathBuf> {
    Some(env::current_exe().ok()?.parent()?.to_path_buf())
}

fn made(
    folder: Option<PathBuf>,
    what: &'static str,
    variable: &'static str,
) -> Result<PathBuf, Error> {
    let folder = folder.ok_or(Error::NoPlace { what, variable })?;
    fs::create_dir_all(&folder).map_err(at(&folder))?;
    Ok(folder)
}
