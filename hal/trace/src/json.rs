//! JSON, for scripts.
//!
//! ```text
//! {"format": "ferrule trace", "version": 1, "tick": "ns",
//! "channels": [
//! {"names": ["stepgen.0.step"], "type": "bit"},
//! {"names": ["joint.0.pos", "xpos"], "type": "float"}],
//! "gaps": [{"sample": 1, "lost": 3}],
//! "markers": [{"at": 1000, "text": "trigger: stepgen.0.step rises"}],
//! "samples": [
//! [0, false, 0.25],
//! [1000, true, "nan"]]}
//! ```
//!
//! A sample is its time and a value for each channel, or `null` where the value is unknown. Floats
//! that are not finite and 64-bit integers are strings. All values are stored exactly, bit for bit,
//! and a file that was cut off is recognised. Each sample has its own line, so that a line-by-line
//! comparison shows the samples that differ.

mod read;

use crate::Trace;
use hal_protocol::Value;
use std::io::{Result, Write};

pub use read::read;

/// Format name that identifies a file.
const FORMAT: &str = "ferrule trace";

/// Writes a trace.
///
/// # Errors
/// An error of the output.
pub fn write<W: Write>(mut out: W, trace: &Trace) -> Result<W> {
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let tick = quoted(&trace.base().name());
    write!(out, "{{\"format\": \"{FORMAT}\", \"version\": 1, \"tick\": {tick},\n\"channels\": [")?;
    for (n, c) in trace.channels().iter().enumerate() {
        let names: Vec<String> = c.names().iter().map(|n| quoted(n)).collect();
        let (comma, names, ty) = (comma(n), names.join(", "), c.ty().name());
        write!(out, "{comma}\n{{\"names\": [{names}], \"type\": \"{ty}\"}}")?;
    }
    write!(out, "],\n\"gaps\": [")?;
    for (n, gap) in trace.gaps().iter().enumerate() {
        write!(out, "{}\n{{\"sample\": {}, \"lost\": {}}}", comma(n), gap.sample, gap.lost)?;
    }
    write!(out, "],\n\"markers\": [")?;
    for (n, m) in trace.markers().iter().enumerate() {
        write!(out, "{}\n{{\"at\": {}, \"text\": {}}}", comma(n), m.at, quoted(&m.text))?;
    }
    write!(out, "],\n\"samples\": [")?;
    let mut row = vec!["null".to_owned(); trace.channels().len()];
    let mut next = vec![0_usize; row.len()];
    for (sample, time) in trace.times().iter().enumerate() {
        for ((n, channel), cell) in next.iter_mut().zip(trace.channels()).zip(&mut row) {
            if let Some(change) = channel.change(*n).filter(|c| c.sample == sample) {
                *n += 1;
                *cell = change.value.map_or_else(|| "null".to_owned(), text);
            }
        }
        write!(out, "{}\n[{time}", comma(sample))?;
        for cell in &row {
            write!(out, ", {cell}")?;
        }
        write!(out, "]")?;
    }
    writeln!(out, "]}}")?;
    out.flush()?;
    Ok(out)
}

const fn comma(n: usize) -> &'static str {
    if n == 0 { "" } else { "," }
}

fn text(value: Value) -> String {
    match value {
        Value::Bit(b) => b.to_string(),
        Value::Float(x) if x.is_nan() => "\"nan\"".to_owned(),
        Value::Float(x) if x.is_infinite() => format!("\"{x}\""),
        Value::Float(x) => format!("{x:?}"),
        Value::S32(_) | Value::U32(_) => value.to_string(),
        Value::S64(_) | Value::U64(_) | Value::Port(_) => format!("\"{value}\""),
    }
}
