//! Analysis of a machine before anything moves: findings (`check/`), data-flow order (`order/`), an engine that touches no
//! hardware (`dry_run.rs`), and what people elsewhere leave alone (`guarded.rs`).

pub(crate) mod check;
pub(crate) mod dry_run;
pub(crate) mod guarded;
pub(crate) mod order;
