//! Tests of the driver on simulated lines, on fake chips, and on edges from memory.
//!
//! `fake` has chips that refuse as a kernel does; `opening` has a row for each refusal, `arguments` one for each bad
//! argument, `simulated` tables of pins, and `edges` encoders.

mod arguments;
mod edges;
mod fake;
mod opening;
mod simulated;

/// A millisecond, in nanoseconds.
const MS: i64 = 1_000_000;
