//! Output of programs: text on standard output, and files. Every failed write is an error with the
//! system's reason, and a good file is never replaced by an incomplete one.
#![forbid(unsafe_code)]

pub mod checksum;
mod file;
mod history;
mod program;
mod stdout;
mod target;
mod terminal;

pub use file::{Growing, Whole, close_file, install, write};
pub use history::{KeptState, MAX_STATES, STATES_FOLDER, keep, states, write_kept};
pub use program::program;
pub use stdout::{Unwritten, lose_reader, print, reader_is_gone};
pub use terminal::{is_coloured, is_person, state_file, state_of_machine};

/// Returns the system's text for an error, without the error number.
#[must_use]
pub fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}
