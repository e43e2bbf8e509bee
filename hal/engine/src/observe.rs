//! Probes that sample values after a cycle, and what is made of them: samples for programs, recordings, the flight recorder.
//!
//! `probe.rs` is the only code that samples values in realtime, `watch.rs` adds and removes probes, `ring.rs` holds shared memory.
//! `snapshot.rs` holds the pages in which components publish records themselves.

pub(crate) mod flight;
pub(crate) mod observers;
pub(crate) mod probe;
pub(crate) mod probes;
pub(crate) mod record;
pub(crate) mod ring;
pub(crate) mod sample;
pub(crate) mod snapshot;
pub(crate) mod watch;
