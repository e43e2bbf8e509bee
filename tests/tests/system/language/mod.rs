//! Scripts and prompts: what each line prints, and what each error says.

mod bad_files;
mod beginners;
mod cases;
mod corpus;
mod first_use;
mod messages;
mod prompt;
mod refusals;
mod tcl;
