//! What the whole-system tests share: programs, folders of their own, cases as data, recordings.
#![expect(clippy::unwrap_used, clippy::panic, reason = "whatever fails here fails a test")]

pub mod case;
pub mod programs;
pub mod scratch;
pub mod vcd;
