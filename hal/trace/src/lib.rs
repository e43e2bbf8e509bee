//! Traces: samples of pins over time, trace files, and drawings as text.
//!
//! A [`Trace`] holds the contents of a recording, a capture or a file:
//!
//! - **Samples** have times that strictly increase, in ticks of the trace's [`TimeBase`]
//!   (nanoseconds unless a file says otherwise). A sample counts even if no value changed.
//! - **Channels** ([`Channel`]) have a name, possibly further names for the same thing, and a HAL
//!   type. A channel stores its changes: the number of a sample and the value from there on.
//!   Between two samples a value holds. Before the first change the value is unknown (`None`), as
//!   is a value that a logic simulator calls `x`.
//! - **Gaps** ([`Gap`]) give the number of samples lost before a sample.
//! - **Markers** ([`Marker`]) are texts at times: why a trigger fired, what went wrong. The text of
//!   a trigger's marker begins with `trigger`.
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
//! All NaNs are treated as the same NaN, because sign and payload differ between processors and
//! carry no meaning. All other values are kept bit for bit, including -0.
//!
//! | item | contents |
//! |---|---|
//! | [`Trace`], [`Channel`], [`Times`] | the samples; `trace.rs`, `channel.rs`, `times.rs` |
//! | [`load`], [`save`], [`Format`] | files, selected by extension; `file.rs` |
//! | [`vcd`], [`fst`], [`csv`], [`json`] | the file formats; `vcd` can also write while samples arrive |
//! | [`trigger`] | start of a capture: conditions, the trigger state machine, captures |
//! | [`draw`] | waveforms as text, and the edges that differ between two of them |
//! | [`columns`] | a channel reduced to the columns of a picture |
//! | [`measure`] | frequency, duty cycle and extremes between two times |
//!
//! Data from files is not trusted: a reader never panics, reports where a file is wrong, and
//! returns everything that it read before that point ([`Reading`]).

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
pub use reading::{Flaw, Position, Reading};
pub use times::{TimeBase, Times};
pub use trace::{Gap, Marker, Refusal, Trace};
