//! INI files, as `hal-ini` reads them.

pub use hal_ini::{Entry, Ini};

/// The system's reason, without its number.
pub(crate) fn plain(error: &std::io::Error) -> Box<str> {
    hal_output::reason(error).into()
}
