//! VCD, which every waveform viewer opens.
//!
//! Dots in names become scopes. A bit is a `wire` of 1, `u32` and `u64` are wires of 32 and 64, `s32`
//! and `s64` are `integer`s, a float is a `real`. A line `#TIME` stands for every sample. What VCD has
//! no words for stands in comments: how many samples the file has and that it ends, markers,
//! lost samples, and that a float is not known; our reader knows them, others pass over them. The one thing that is not held is the
//! order of several names of one channel: they come back sorted. Blanks in names become `_`.

mod kinds;
mod read;
mod write;

pub use read::read;
pub(crate) use write::path;
pub use write::{Column, Writer, write};
