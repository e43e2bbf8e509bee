//! Analysis before anything moves: `check`, `order`, `graph`, the dry run.

mod check;
mod graph;
mod order;
mod trial;
