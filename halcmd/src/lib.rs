//! The `.hal` language (lexer, INI files, one table of commands, interpreter), and the programs
//! halrun, halcmd, halscope, halsampler, halstreamer, haltest, halsetup, haltcl, linuxcnc and `hal_manualtoolchange`.
//!
//! The lexer splits a line of a script into words ([`language::lex`], [`language::vars`]). The table in [`language::table`] turns
//! words into a [`Command`]. A [`Session`] executes the command over any
//! [`Link`](hal_protocol::Link): an engine in this process or in another one.

pub mod check;
mod error;
pub mod graph;
pub mod ini;
mod io;
pub mod language;
pub mod manual;
pub mod order;
pub mod programs;
pub mod session;
pub mod show;
mod standin;
pub mod terminal;

pub use error::Error;
pub use language::command::Command;
pub use language::fault::{Fault, Span};
pub use language::source::{Bytes, Lines, MAX_PHYSICAL, Physical, Stdin};
pub use language::units::{UnitError, nanoseconds};
pub use language::word::Word;
pub use programs::haltest;
pub use session::{Outcome, Session, Style};
pub use terminal::{Captured, Stdio, Terminal};
