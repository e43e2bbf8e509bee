//! Threads: their cycles, clocks, faults and background tasks, and the state that both sides share.
//!
//! `thread.rs` is one cycle, `clock.rs` the two clocks, `runners.rs` the threads of the system, `shared.rs` the state that the
//! control thread and the realtime threads share. `fault.rs`, `stuck.rs`, `watchdog.rs` and `overruns.rs` deal with functions that fail,
//! hang or are late, `gaps.rs` with times in which nothing ran, `resources.rs` with what the system grants (scheduling, processor, memory), `task.rs` with background tasks,
//! `worker.rs` with workers, and `questions.rs` with what they ask.

pub(crate) mod account;
pub(crate) mod clock;
pub(crate) mod fault;
pub(crate) mod gaps;
pub(crate) mod overruns;
pub(crate) mod questions;
pub(crate) mod resources;
pub(crate) mod runners;
pub(crate) mod runtime;
pub(crate) mod shared;
pub(crate) mod stuck;
pub(crate) mod task;
pub(crate) mod thread;
pub(crate) mod watchdog;
pub(crate) mod worker;
