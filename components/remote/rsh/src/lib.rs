//! The text protocol of linuxcncrsh: a machine that clients command with lines of text.
//!
//! A [`Session`] turns a line into its reply and commands of a [`Machine`]. It knows no network; the program linuxcncrsh
//! connects both.
#![forbid(unsafe_code)]

mod get;
mod help;
mod line;
mod machine;
mod rows;
mod session;
mod set;
mod state;

pub use line::{Lines, MAX_LINE};
pub use machine::{Jog, JogTarget, Machine};
pub use session::{Next, Passwords, Session, is_stop};
pub use state::{Facts, Record, Snapshots};

#[cfg(test)]
mod tests;
