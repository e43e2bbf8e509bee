//! Libraries that a C program with pins is linked with.

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

/// Client library, which lies beside this program.
const LIBRARY: &str = "libferrule_client.so";
/// Part of the client library that only C can express.
const SOURCE: &str = include_str!("../../compat/client/client.c");

/// Returns the arguments for the linker, after writing the C part of the library to this folder.
///
/// # Errors
/// The library is missing.
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
