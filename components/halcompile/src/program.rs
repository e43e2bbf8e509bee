//! Programs in C with pins: what they are linked with.

use crate::error::Error;
use std::{env, path::PathBuf};

/// The library of programs, beside this one.
const LIBRARY: &str = "libferrule_client.so";

/// Words for the linker.
///
/// # Errors
/// The library is not there.
pub(crate) fn link_words() -> Result<Vec<String>, Error> {
    let exe = env::current_exe().ok();
    let here =
        exe.as_deref().and_then(std::path::Path::parent).map(PathBuf::from).unwrap_or_default();
    let found = [here.join(LIBRARY), here.join("../lib/ferrule").join(LIBRARY)]
        .into_iter()
        .find(|p| p.is_file())
        .ok_or(Error::NoPlace { what: "libferrule_client.so", variable: "HAL_LIB_DIR" })?;
    let folder = found.parent().map(|p| p.display().to_string()).unwrap_or_default();
    Ok(vec![found.display().to_string(), format!("-Wl,-rpath,{folder}")])
}
