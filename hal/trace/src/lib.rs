//! Traces: samples of pins over time, their files, and how they are drawn in text.
//!
//! A [`Trace`] is what a recording, a capture or a file comes to:
//!
//! - **Samples** have times, in ticks of the trace's [`TimeBase`] (nanoseconds unless a file says
//!   otherwise), which only increase. Every sample counts, also one at which nothing changed.
//! - **Channels** ([`Channel`]) have a name, perhaps further names of the same thing, and a HAL type.
//!   A channel keeps its changes: the number of a sample and the value from there on. Between two
//!   samples a value holds. Before its first change it is not known (`None`), as is what a
//!   logic simulator calls `x`.
//! - **Gaps** ([`Gap`]) say before which sample how many were lost.
//! - **Markers** ([`Marker`]) are texts at times: why a trigger fired, what went wrong. The marker of a
//!   trigger begins with `trigger`.
//!
//! ```
//! use hal_protocol::{Type, Value};
//! use hal_trace::{Trace, draw::edges};
//!
//! let mut trace = Trace::default();
//! let step = trace.add("stepgen.0.step", Type::Bit);
//! let count = trace.add("stepgen.0.counts", Type::S32);
//! trace.push(0, &[0, 7])?; // A whole record, as cells hold it.
//! trace.push(25_000, &[1, 8])?;
//! trace.sample(50_000)?; // Or a time, and what has changed.
//! trace.set(step, Value::Bit(false))?;
//! trace.mark(25_000, "trigger: stepgen.0.step rises");
//!
//! assert_eq!(trace.value(count, 2), Some(Value::S32(8)));
//! assert_eq!(trace.at(step, 30_000), Some(Value::Bit(true)));
//! let name = ["stepgen.0.step"];
//! assert_eq!(edges(&trace, &name, 0, 60_000)?, "stepgen.0.step  _/‾25‾\\_50_\n");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A NaN is one NaN here: its sign and payload differ between processors and mean nothing.
//! Everything else is kept bit for bit, -0 too.
//!
//! | where | what |
//! |---|---|
//! | [`Trace`], [`Channel`], [`Times`] | the samples; `trace.rs`, `channel.rs`, `times.rs` |
//! | [`load`], [`save`], [`Format`] | files by their endings; `file.rs` |
//! | [`vcd`], [`fst`], [`csv`], [`json`] | what each format holds; all read and write whole traces, and `vcd` also writes while samples come |
//! | [`trigger`] | when a capture begins: conditions, the machine that is fed samples, captures |
//! | [`draw`] | waveforms as text, and which edges differ between two |
//! | [`columns`] | a channel in so many columns of a picture |
//! | [`measure`] | frequency, duty cycle, extremes between two times |
//!
//! What comes from files is not believed: a reader never panics, says where a file is wrong, and hands out
//! what it had read until then ([`Reading`]).

mod channel;
pub mod columns;
pub mod csv;
pub mod draw;
mod file;
pub mod fst;
pub mod json;
pub mod measure;
mod reading;
mod times;
mod trace;
pub mod trigger;
pub mod vcd;

pub use channel::{Change, Channel};
pub use file::{FileError, Format, load, save};
pub use reading::{Flaw, Place, Reading};
pub use times::{TimeBase, Times};
pub use trace::{Gap, Marker, Refusal, Trace};
