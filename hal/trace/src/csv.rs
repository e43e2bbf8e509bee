//! CSV, for spreadsheets and scripts.
//!
//! ```text
//! time [ns],stepgen.0.step (bit),joint.0.pos = xpos (float),lost,marker
//! 0,0,0.25,,
//! 1000,,,,trigger: stepgen.0.step rises
//! 1000,1,0.5,3,
//! ```
//!
//! Each row is a sample: its time, then a value for each channel. A cell is empty where the value
//! is unknown. The header row gives the unit of time, and the name and type of each channel. `lost`
//! is the number of samples missing before this one. A row with a `marker` is a marker and not a
//! sample. These two columns are present only if they contain something. All values are stored
//! exactly, bit for bit. Two limits remain: a file that was cut off between two rows looks
//! complete, and spreadsheets round integers beyond 2^53.
//!
//! Tables of other programs are read if their first column is a time (`time`, `t`, `Time [us]`; in
//! seconds if no unit is given). Commas, semicolons or tabs separate the columns. Comments before
//! the header begin with `;` or `#`. The type of a column is then the first one that fits all its
//! values: bit, s64, u64, float.

mod read;

use crate::Trace;
use ::csv::{QuoteStyle, WriterBuilder};
use hal_protocol::Value;
use std::io::{Result, Write};

pub use read::read;

/// Writes a trace.
///
/// # Errors
/// An error of the output.
pub fn write<W: Write>(out: W, trace: &Trace) -> Result<()> {
    let mut out = WriterBuilder::new().quote_style(QuoteStyle::Necessary).from_writer(out);
    let has_lost = !trace.gaps().is_empty();
    let has_marker = !trace.markers().is_empty();
    let channels = trace.channels();
    let mut row = vec![format!("time [{}]", trace.base().name())];
    row.extend(channels.iter().map(|c| format!("{} ({})", c.names().join(" = "), c.ty().name())));
    row.extend(has_lost.then(|| "lost".to_owned()));
    row.extend(has_marker.then(|| "marker".to_owned()));
    out.write_record(&row)?;
    // Cells of the previous row. A cell keeps its text until the channel changes.
    for cell in &mut row {
        cell.clear();
    }
    let blank = row.clone();
    let mark = |at: i64, text: &str| {
        let mut row = blank.clone();
        if let (Some(time), true) = (row.first_mut(), has_marker) {
            *time = at.to_string();
        }
        if let Some(last) = row.last_mut() {
            text.clone_into(last);
        }
        row
    };
    let place_of_lost = channels.len() + 1;
    let mut gaps = trace.gaps().iter().peekable();
    let mut markers = trace.markers().iter().peekable();
    let mut next = vec![0_usize; channels.len()];
    for (sample, time) in trace.times().iter().enumerate() {
        while let Some(m) = markers.next_if(|m| m.at <= time) {
            out.write_record(mark(m.at, &m.text))?;
        }
        for ((n, channel), cell) in next.iter_mut().zip(channels).zip(row.iter_mut().skip(1)) {
            if let Some(change) = channel.change(*n).filter(|c| c.sample == sample) {
                *n += 1;
                *cell = change.value.map_or(String::new(), text);
            }
        }
        if let Some(cell) = row.first_mut() {
            *cell = time.to_string();
        }
        let gap = gaps.next_if(|g| g.sample == sample);
        if let Some(cell) = row.get_mut(place_of_lost).filter(|_| has_lost) {
            *cell = gap.map_or(String::new(), |g| g.lost.to_string());
        }
        out.write_record(&row)?;
    }
    for m in markers {
        out.write_record(mark(m.at, &m.text))?;
    }
    for gap in gaps {
        let mut row = blank.clone();
        if let Some(cell) = row.get_mut(place_of_lost) {
            *cell = gap.lost.to_string();
        }
        out.write_record(row)?;
    }
    out.flush()
}

/// Formats a value with all its digits.
fn text(value: Value) -> String {
    match value {
        Value::Bit(b) => u8::from(b).to_string(),
        Value::Float(x) if x.is_nan() => "nan".to_owned(),
        Value::Float(x) => format!("{x:?}"),
        Value::S32(_) | Value::U32(_) | Value::S64(_) | Value::U64(_) | Value::Port(_) => {
            value.to_string()
        }
    }
}
