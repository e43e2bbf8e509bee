//! Analysis before anything moves: `check`, `order`, `graph`, the dry run.

mod check;
mod crossings;
mod dry_run;
mod graph;
mod mutations;
mod order;
