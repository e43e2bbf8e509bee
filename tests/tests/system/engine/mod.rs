//! The engine: changes, clocks, rings, samples, recordings.

mod apply;
mod apply_random;
mod clock_holds;
mod determinism;
mod flight;
mod locked;
mod output;
mod realclock;
mod rings;
mod samples;
mod stuck;
mod thousand;
