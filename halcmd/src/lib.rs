//! The `.hal` language (lexer, INI files, one table of commands, interpreter), and the programs
//! halrun, halcmd, halscope, halsampler, halstreamer, haltest and `hal_manualtoolchange`.
//!
//! The lexer splits a line of a script into words ([`lex`], [`vars`]). The table in [`table`] turns
//! words into a [`Command`]. A [`Session`] executes the command over any
//! [`Link`](hal_protocol::Link): an engine in this process or in another one.

mod after;
mod apply;
pub mod check;
mod colour;
mod command;
pub mod complete;
mod error;
mod examine;
mod execute;
pub mod explain;
mod fault;
mod flight;
pub mod graph;
pub mod halcmd;
pub mod halrun;
pub mod haltest;
pub mod help;
mod hint;
pub mod ini;
mod io;
pub mod lex;
pub mod list;
pub mod man;
pub mod manual;
mod meter;
pub mod options;
pub mod order;
mod parse;
pub mod profile;
mod program;
mod prompt;
pub mod remote;
mod rows;
pub mod sampler;
pub mod save;
mod say;
pub mod scope;
mod screen;
mod session;
pub mod show;
pub mod signals;
mod source;
mod status;
pub mod streamer;
pub mod syntax;
pub mod table;
mod terminal;
pub mod toolchange;
pub mod trial;
mod units;
pub mod vars;
mod watch;
mod word;

pub use command::Command;
pub use error::Error;
pub use fault::{Fault, Span};
pub use session::{Outcome, Session, Style};
pub use source::{Bytes, Lines, MAX_PHYSICAL, Physical, Stdin};
pub use terminal::{Captured, Stdio, Terminal};
pub use units::{UnitError, nanoseconds};
pub use word::Word;
