//! Programs in C with pins: what they are linked with.

use crate::{
    build::FLAGS,
    error::{Error, at},
};
use std::{
    env,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

/// The library of programs, which stands beside this one.
const LIBRARY: &str = "libferrule_client.so";
/// What only C can say of it.
const SOURCE: &str = include_str!("../../compat/client/client.c");

/// Words for the linker; the C part of the library is put into this folder.
///
/// # Errors
/// The library is not there.
pub(crate) fn link_words(scratch: &Path, include: &Path) -> Result<Vec<OsString>, Error> {
    let exe = env::current_exe().ok();
    let here = exe.as_deref().and_then(Path::parent).map(PathBuf::from).unwrap_or_default();
    let folders = [here.clone(), here.join("../lib/ferrule")];
    let Some(folder) = folders.into_iter().find(|f| f.join(LIBRARY).is_file()) else {
        return Err(Error::NoLibrary {
            library: LIBRARY,
            folder: here.display().to_string().into(),
        });
    };
    let source = scratch.join("client.c");
    fs::write(&source, SOURCE).map_err(at(&source))?;
    let mut words: Vec<OsString> = FLAGS.iter().map(OsString::from).collect();
    let mut path = OsString::from("-Wl,-rpath,");
    path.push(&folder);
    words.extend(["-DULAPI".into(), "-I".into(), include.into(), source.into()]);
    words.extend([folder.join(LIBRARY).into(), path]);
    Ok(words)
}
