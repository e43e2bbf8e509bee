//! Waveforms as text.

use crate::Trace;
use hal_protocol::Value;
use std::fmt::Write;

/// A channel that a trace does not have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoChannel(pub Box<str>);

impl core::fmt::Display for NoChannel {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "'{}' is not in the trace", self.0)
    }
}

impl core::error::Error for NoChannel {}

/// A line for each channel: what it was at `from`, and each change up to `to`, which is itself out, in
/// microseconds after `from`. Bits are high and low, and rise and fall; others have values.
///
/// ```text
/// stepgen.0.step  low   rise 25  fall 50
/// stepgen.0.pos   0.5   1.25 at 25  -3 at 70.5
/// ```
///
/// # Errors
/// A name that is not in the trace.
pub fn edges(trace: &Trace, names: &[&str], from: i64, to: i64) -> Result<String, NoChannel> {
    let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for name in names {
        let number = trace.find(name).ok_or_else(|| NoChannel((*name).into()))?;
        let Some(channel) = trace.channels().get(number) else { continue };
        let first = match trace.at(number, from) {
            None => "?".to_owned(),
            Some(Value::Bit(b)) => if b { "high" } else { "low" }.to_owned(),
            Some(value) => value.to_string(),
        };
        // Nothing that is written to a text fails.
        let _: std::fmt::Result = write!(text, "{name:width$}  {first:4}");
        let times = trace.times();
        let before = |time: i64| channel.changes_before(times.from(time));
        for change in (before(from.saturating_add(1))..before(to)).filter_map(|n| channel.change(n))
        {
            let at = times.get(change.sample).unwrap_or(from);
            let at = trace.base().microseconds(at.saturating_sub(from));
            let _: std::fmt::Result = match change.value {
                None => write!(text, "  ? at {at}"),
                Some(Value::Bit(b)) => write!(text, "  {} {at}", if b { "rise" } else { "fall" }),
                Some(value) => write!(text, "  {value} at {at}"),
            };
        }
        text.push('\n');
    }
    Ok(text)
}
