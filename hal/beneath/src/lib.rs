//! Files below a folder. A name that comes from a program, a remote request or an INI file opens a file of that folder or
//! nothing: it is checked first, and the system then follows no link on the way.
#![forbid(unsafe_code)]

mod beneath;
mod error;
mod name;
mod new_file;
mod opening;
mod run;
#[cfg(test)]
mod tests;

pub use beneath::{Beneath, Found};
pub use error::OpenError;
pub use name::{FileName, MAX_DEPTH, NameError, RelativeName};
pub use new_file::NewFile;
pub use run::{check_guarded, is_below, is_private};
