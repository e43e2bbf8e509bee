//! FST, the packed format of `GTKWave` and Surfer.
//!
//! Scopes and types are those of [VCD](crate::vcd). What FST has no words for (how many samples there are, the
//! order of channels, markers, lost samples) stands as JSON in scopes named `ferrule`, which
//! viewers show as empty ones. A float that is not known is a NaN with a payload of its own. A file is
//! written in blocks; of one that is cut off, the whole blocks are read.
//!
//! Writing is done by the crate `fst-writer`. The reader is our own: those that there are panic on files that
//! are not whole, and believe the lengths that stand in them.

mod block;
mod bytes;
mod fastlz;
mod hierarchy;
mod read;
mod write;

pub use read::read;
pub use write::write;

/// The bits of a float that is not known.
const UNKNOWN: u64 = 0x7ff8_0000_0000_4645;

/// The scope that holds what FST has no words for.
const SCOPE: &str = "ferrule";

/// What stands in it.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
struct Notes {
    samples: u64,
    /// When the first was: one at zero stands where others have what was before all changes.
    first: Option<i64>,
    /// The handle of each channel.
    handles: Vec<u32>,
    gaps: Vec<(u32, u64)>,
    markers: Vec<(i64, String)>,
}
