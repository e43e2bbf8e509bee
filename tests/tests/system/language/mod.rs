//! Scripts and prompts: what each line prints, and what each error says.

mod cases;
mod corpus;
mod messages;
mod prompt;
mod refusals;
