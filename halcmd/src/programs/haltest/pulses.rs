//! Pulses: count, width, frequency, and the steps that a motor makes from them.

use super::{
    condition::Condition,
    evaluate::Record,
    expectation::{Pulses, Times},
    outcome::{Complaint, Spot},
    test::Named,
};
use crate::language::units::duration;
use hal_protocol::Value;

/// Returns the edges of a bit: time, and the level after the edge.
fn edges(
    record: &Record<'_>,
    of: &Named,
    from: i64,
    to: i64,
) -> Result<Vec<(i64, bool)>, Complaint> {
    let channel = record.channel(of)?;
    let Some(Value::Bit(mut level)) = record.trace.at(channel, from) else {
        let text = format!("'{}' is not a bit: it has no pulses", of.name);
        return Err(Complaint::new(&of.spot, text));
    };
    let times = record.times(from, to).into_iter();
    let bits = times.filter_map(|t| match record.trace.at(channel, t) {
        Some(Value::Bit(bit)) => Some((t, bit)),
        _ => None,
    });
    Ok(bits.filter(|(_, bit)| core::mem::replace(&mut level, *bit) != *bit).collect())
}

/// Checks the pulses of a bit.
pub(super) fn evaluate(
    record: &Record<'_>,
    spot: &Spot,
    wanted: &Pulses,
    from: i64,
    to: i64,
) -> Result<(), Complaint> {
    let name = &wanted.of.name;
    let edges = edges(record, &wanted.of, from, to)?;
    let rises: Vec<i64> = edges.iter().filter(|(_, up)| *up).map(|(t, _)| *t).collect();
    if let Some(count) = wanted.count
        && count != rises.len() as u64
    {
        let pulses = if rises.len() == 1 { "pulse" } else { "pulses" };
        let text = format!("'{name}' has {} {pulses}", rises.len());
        return Err(Complaint::new(spot, text)
            .with(format!("expected: {count}"))
            .with(format!("found:    {}", rises.len())));
    }
    if let Some((hertz, tolerance)) = wanted.frequency {
        let (Some(first), Some(last)) = (rises.first(), rises.last()) else {
            return Err(Complaint::new(spot, format!("'{name}' has no pulses: no frequency"))
                .with(format!("expected: {hertz} Hz")));
        };
        if rises.len() < 2 {
            return Err(Complaint::new(spot, format!("'{name}' has one pulse: no frequency"))
                .with(format!("expected: {hertz} Hz")));
        }
        let found = (rises.len() - 1) as f64 * 1e9 / (last - first) as f64;
        let near = (found - hertz).abs() <= tolerance;
        if !near {
            return Err(Complaint::new(spot, format!("'{name}' pulses at {found:.3} Hz"))
                .with(format!("expected: {hertz} ± {tolerance} Hz"))
                .with(format!("found:    {found:.3} Hz over {} pulses", rises.len())));
        }
    }
    for (bounds, level, word) in [(&wanted.high, true, "high"), (&wanted.low, false, "low")] {
        let Some((spot, times)) = bounds else { continue };
        for pair in edges.windows(2) {
            let [(a, up), (b, _)] = pair else { continue };
            if *up == level {
                let what = format!("'{name}' is {word} for");
                time(record, spot, &what, (*a, *b), *times)?;
            }
        }
    }
    Ok(())
}

/// Checks the times from each `first` event to the next `then` event.
pub(super) fn between(
    record: &Record<'_>,
    spot: &Spot,
    (first, firsts): (&Condition, &[i64]),
    (then, thens): (&Condition, &[i64]),
    times: Times,
) -> Result<(), Complaint> {
    let names = format!("from '{}' to '{}'", first.named.name, then.named.name);
    let mut seen = false;
    for a in firsts {
        let Some(b) = thens.iter().find(|b| *b > a) else { break };
        seen = true;
        time(record, spot, &format!("{names} it takes"), (*a, *b), times)?;
    }
    if seen {
        return Ok(());
    }
    let text = format!("there is nothing {names}");
    let told = |name: &str, times: &[i64]| match times.first() {
        Some(t) => format!("'{name}' is first at {}", record.told(*t)),
        None => format!("'{name}' never happens"),
    };
    Err(Complaint::new(spot, text)
        .with(told(&first.named.name, firsts))
        .with(told(&then.named.name, thens)))
}

fn time(
    record: &Record<'_>,
    spot: &Spot,
    what: &str,
    (from, to): (i64, i64),
    times: Times,
) -> Result<(), Complaint> {
    let found = to.saturating_sub(from).unsigned_abs();
    if times.least <= found && found <= times.most {
        return Ok(());
    }
    let wanted = match times {
        Times { least, most: u64::MAX } => format!("at least {}", duration(least)),
        Times { least: 0, most } => format!("at most {}", duration(most)),
        Times { least, most } => format!("{} to {}", duration(least), duration(most)),
    };
    let text = format!("{what} {} at {}", duration(found), record.told(from));
    let (short, by) = match found.checked_sub(times.most) {
        Some(by) => ("too long", by),
        None => ("too short", times.least.saturating_sub(found)),
    };
    Err(Complaint::new(spot, text).with(format!("expected: {wanted}")).with(format!(
        "found:    {}, {} {short}",
        duration(found),
        duration(by)
    )))
}

/// Returns the position in steps of a motor that makes one step at each rising edge of `step`, in
/// the negative direction while `direction` is high.
pub(super) fn steps(
    record: &Record<'_>,
    step: &Named,
    direction: &Named,
    from: i64,
    to: i64,
) -> Result<i64, Complaint> {
    let rises = edges(record, step, from, to)?.into_iter().filter(|(_, up)| *up);
    let way = record.channel(direction)?;
    Ok(rises.fold(0, |n, (t, _)| match record.trace.at(way, t) {
        Some(Value::Bit(true)) => n - 1,
        _ => n + 1,
    }))
}
