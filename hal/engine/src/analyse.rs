//! Analysis of a machine before anything moves: findings (`check/`), data-flow order (`order/`), and an engine that touches no
//! hardware (`dry_run.rs`).

pub(crate) mod check;
pub(crate) mod dry_run;
pub(crate) mod order;
