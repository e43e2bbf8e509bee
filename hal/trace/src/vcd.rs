//! VCD, which every waveform viewer reads.
//!
//! Dots in names become scopes. A bit is a `wire` of width 1, `u32` and `u64` are wires of width 32
//! and 64, `s32` and `s64` are `integer`s, a float is a `real`. Every sample has a line `#TIME`.
//! Data that VCD cannot express is stored in comments: the number of samples, an end mark, markers,
//! lost samples, and unknown floats. Our reader understands these comments and other programs skip
//! them. Only the order of several names of one channel is lost: they are read back sorted. White
//! space in names becomes `_`.

mod kinds;
mod read;
mod write;

pub use read::read;
pub(crate) use write::path;
pub use write::{Column, Writer, write};
