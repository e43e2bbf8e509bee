//! INI files, read by `hal-ini`.

pub use hal_ini::{Entry, Ini};

/// Returns the system's reason, without the error number.
pub(crate) fn plain(error: &std::io::Error) -> Box<str> {
    hal_output::reason(error).into()
}
