//! Waveforms as text, and the differences between two of them.

mod differences;

pub use differences::differences;

use crate::Trace;
use hal_protocol::Value;
use std::fmt::Write;

/// Error: the trace does not have this channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoChannel(pub Box<str>);

impl core::fmt::Display for NoChannel {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "'{}' is not in the trace", self.0)
    }
}

impl core::error::Error for NoChannel {}

/// Draws a line for each channel, from `from` up to but not including `to`.
///
/// ```text
/// stepgen.0.step  _/‾100‾\_200_/‾2600‾\_2700_
/// stepgen.0.dir   _/‾1900‾
/// stepgen.0.pos   0.5 |25 1.25 |70.5 -3
/// ```
///
/// A bit is drawn as its level, `_` or `‾`, and its edges, each with its time. Other types are
/// drawn as their values, with the time of each change between them. `?` is an unknown value. Times
/// are microseconds after `from`. The drawing is not to scale: if an edge moves, only its own
/// number changes. A line-by-line comparison of two drawings therefore shows the edge, and
/// [`differences`] says by how much it moved.
///
/// # Errors
/// A name is not in the trace.
pub fn edges(trace: &Trace, names: &[&str], from: i64, to: i64) -> Result<String, NoChannel> {
    let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for name in names {
        let number = trace.find(name).ok_or_else(|| NoChannel((*name).into()))?;
        let Some(channel) = trace.channels().get(number) else { continue };
        let shown = |value: Option<Value>| match value {
            None => "?".to_owned(),
            Some(Value::Bit(b)) => if b { "‾" } else { "_" }.to_owned(),
            Some(value) => value.to_string(),
        };
        // Writing to a `String` cannot fail.
        let _: std::fmt::Result = write!(text, "{name:width$}  {}", shown(trace.at(number, from)));
        let times = trace.times();
        let before = |time: i64| channel.changes_before(times.from(time));
        let changes = before(from.saturating_add(1))..before(to);
        for change in changes.filter_map(|n| channel.change(n)) {
            let at = times.get(change.sample).unwrap_or(from).saturating_sub(from);
            let at = trace.base().microseconds(at);
            let _: std::fmt::Result = match change.value {
                Some(Value::Bit(true)) => write!(text, "/‾{at}‾"),
                Some(Value::Bit(false)) => write!(text, "\\_{at}_"),
                value => write!(text, " |{at} {}", shown(value)),
            };
        }
        text.push('\n');
    }
    Ok(text)
}
