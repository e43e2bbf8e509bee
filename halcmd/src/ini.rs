//! INI files, read by `hal-ini`.

use hal_protocol::At;

pub use hal_ini::{Doubt, Entry, Ini, IniWarning};

/// Returns the system's reason, without the error number.
pub(crate) fn plain(error: &std::io::Error) -> Box<str> {
    hal_output::reason(error).into()
}

/// Splits `file:line: text` into place and text.
pub(crate) fn placed(line: &str) -> Option<(At, &str)> {
    let (place, text) = line.split_once(": ")?;
    let (file, number) = place.rsplit_once(':')?;
    Some((At::new(file, number.parse().ok()?), text))
}
