//! FST, the compressed format of `GTKWave` and Surfer.
//!
//! Scopes and types are those of [VCD](crate::vcd). Data that FST cannot express (number of
//! samples, order of channels, markers, lost samples) is stored as JSON in scopes named `ferrule`,
//! which viewers show as empty scopes. An unknown float is a NaN with a special payload. A file
//! consists of blocks. If a file was cut off, its complete blocks are read.
//!
//! The crate `fst-writer` does the writing. The reader is our own, because the existing ones panic
//! on incomplete files and trust the lengths in them.

mod block;
mod bytes;
mod fastlz;
mod hierarchy;
mod read;
mod write;

pub use read::read;
pub use write::write;

/// Bit pattern of an unknown float.
const UNKNOWN: u64 = 0x7ff8_0000_0000_4645;

/// Scope that holds the data that FST cannot express.
const SCOPE: &str = "ferrule";

/// Contents of that scope.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
struct Notes {
    samples: u64,
    /// Time of the first sample. A sample at time zero is stored in the frame, where other programs
    /// put the values before all changes.
    first: Option<i64>,
    /// FST handle of each channel.
    handles: Vec<u32>,
    gaps: Vec<(u32, u64)>,
    markers: Vec<(i64, String)>,
}
