//! Components in C: the interface they are written to, and their loader.
//!
//! The headers are in `include/`.
#![forbid(unsafe_code)]
