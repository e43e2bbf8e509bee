//! Changes as transactions: staged and checked against the graph, applied whole at one boundary of the threads, or reverted.
//!
//! `transaction.rs` stages requests, `undo.rs` reverts them, `apply.rs` brings them to the threads, and `handover.rs` and
//! `stores.rs` are the realtime side of the boundary.

pub(crate) mod apply;
pub(crate) mod handover;
pub(crate) mod staged;
pub(crate) mod stores;
pub(crate) mod transaction;
pub(crate) mod undo;
