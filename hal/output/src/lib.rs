//! Everything that leaves a program: text on standard output, and files. Whatever cannot be written
//! is an error with the system's reason, and no file is left half written in place of a good one.
#![forbid(unsafe_code)]

mod file;
mod program;
mod stdout;
mod target;

pub use file::{Growing, Whole, install, write};
pub use program::program;
pub use stdout::{Unwritten, lose_reader, print, reader_is_gone};

/// Returns the reason of an error in the system's words, without its number.
#[must_use]
pub fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}
