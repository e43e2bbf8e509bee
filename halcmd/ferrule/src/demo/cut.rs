//! Range, way, steps and speed of each axis, from the recording.

use crate::failure::Failure;
use hal_trace::{Channel, Trace, measure::number};

/// Axes of the machine, with the step line, the position and the speed of each.
const AXES: [(&str, &str, &str, &str); 3] = [
    ("X", "xstep", "xpos-fb", "axis.0.joint-vel-cmd"),
    ("Y", "ystep", "ypos-fb", "axis.1.joint-vel-cmd"),
    ("Z", "zstep", "zpos-fb", "axis.2.joint-vel-cmd"),
];

/// Returns the machine time that the recording lasts, in seconds.
pub(super) fn duration(trace: &Trace) -> f64 {
    let (first, last) = (trace.times().first(), trace.times().last());
    trace.base().seconds(last.unwrap_or(0) - first.unwrap_or(0))
}

/// Returns a line for each axis: its range and its way in millimetres, its steps, and its greatest speed.
pub(super) fn table(trace: &Trace) -> Result<String, Failure> {
    let mut text = String::from("axis   from mm    to mm   way mm    steps   fastest mm/s\n");
    for (axis, step, place, speed) in AXES {
        let steps = rising(channel(trace, step)?);
        let places = numbers(channel(trace, place)?);
        let speeds = numbers(channel(trace, speed)?);
        let low = places.iter().copied().fold(f64::INFINITY, f64::min);
        let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let way: f64 = places.iter().zip(places.iter().skip(1)).map(|(a, b)| (b - a).abs()).sum();
        let fastest = speeds.iter().map(|v| v.abs()).fold(0.0, f64::max);
        text.push_str(&format!(
            "{axis:<4} {low:>9.2} {high:>8.2} {way:>8.1} {steps:>8} {fastest:>14.2}\n"
        ));
    }
    Ok(text)
}

fn channel<'t>(trace: &'t Trace, name: &str) -> Result<&'t Channel, Failure> {
    let found = trace.find(name).and_then(|place| trace.channels().get(place));
    found.ok_or_else(|| Failure::NotRecorded { line: name.into() })
}

fn numbers(channel: &Channel) -> Vec<f64> {
    channel.changes().filter_map(|change| number(change.value?)).collect()
}

/// Returns how often a line has risen.
fn rising(channel: &Channel) -> usize {
    let levels: Vec<bool> = numbers(channel).into_iter().map(|level| level != 0.0).collect();
    levels.iter().zip(levels.iter().skip(1)).filter(|(before, now)| !**before && **now).count()
}
