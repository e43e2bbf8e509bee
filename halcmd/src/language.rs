//! The `.hal` language: text to words, words to commands.
//!
//! `source.rs` reads lines, `lex.rs`, `vars.rs` and `syntax.rs` make words of them, `parse.rs` makes a [`Command`](command::Command) of words by
//! the one table in `table.rs`, whose rows are in `rows/`. `fault.rs` and `hint.rs` say what is wrong and what would be right.

pub(crate) mod arguments;
pub(crate) mod command;
pub(crate) mod fault;
pub(crate) mod flight;
pub(crate) mod hint;
pub(crate) mod joined;
pub mod lex;
pub(crate) mod parse;
pub(crate) mod row;
pub(crate) mod rows;
pub(crate) mod source;
pub mod syntax;
pub mod table;
pub(crate) mod units;
pub mod vars;
pub(crate) mod word;
