//! Comparison of values with expected values.

use super::{
    expectation::Bounds,
    inject::number,
    outcome::{Complaint, Spot},
};
use hal_protocol::Value;

/// Relative tolerance that always applies, because a binary fraction is rarely exactly the decimal
/// number in the text.
const NEARLY: f64 = 1e-9;
/// Number of significant digits shown.
const DIGITS: i32 = 10;

/// Compares a found value with the expected one.
pub(super) fn value(
    spot: &Spot,
    name: &str,
    wanted: &toml::Value,
    tolerance: f64,
    found: Value,
) -> Result<(), Complaint> {
    if is(spot, name, wanted, tolerance, found)? {
        return Ok(());
    }
    let wanted = told(wanted, tolerance, found);
    Err(Complaint::new(spot, format!("'{name}' is {}", shown(found)))
        .with(format!("expected: {wanted}"))
        .with(format!("found:    {}", shown(found))))
}

/// Returns whether a value is the expected one.
pub(super) fn is(
    spot: &Spot,
    name: &str,
    wanted: &toml::Value,
    tolerance: f64,
    found: Value,
) -> Result<bool, Complaint> {
    let wrong = || {
        let text = format!("'{name}' is {}: {wanted} is none", kind(found));
        Complaint::new(spot, text).with(found.ty().expects())
    };
    let near = |wanted: f64| {
        let found = number(found);
        // NaN matches only NaN.
        let tolerance = tolerance.max(NEARLY * wanted.abs().max(1.0));
        (found - wanted).abs() <= tolerance || found == wanted || found.is_nan() && wanted.is_nan()
    };
    Ok(match (wanted, found) {
        (toml::Value::Boolean(b), Value::Bit(found)) => *b == found,
        (toml::Value::Integer(i @ (0 | 1)), Value::Bit(found)) => (*i == 1) == found,
        (_, Value::Bit(_)) | (toml::Value::Boolean(_), _) => return Err(wrong()),
        (toml::Value::Integer(i), _) => near(*i as f64),
        (toml::Value::Float(f), _) => near(*f),
        (toml::Value::String(text), _) => {
            Value::parse(found.ty(), text).map_err(|_| wrong())? == found
        }
        _ => return Err(wrong()),
    })
}

/// Returns whether a value is within bounds.
pub(super) fn within(
    spot: &Spot,
    name: &str,
    bounds: &Bounds,
    found: Value,
) -> Result<bool, Complaint> {
    match bounds {
        Bounds::Is(wanted, tolerance) => is(spot, name, wanted, *tolerance, found),
        Bounds::Within(least, most) => {
            let found = number(found);
            Ok(*least <= found && found <= *most)
        }
    }
}

/// Describes bounds in words.
pub(super) fn bounds(bounds: &Bounds, like: Value) -> String {
    match bounds {
        Bounds::Is(wanted, tolerance) => told(wanted, *tolerance, like),
        Bounds::Within(least, most) if most.is_infinite() => format!("at least {least}"),
        Bounds::Within(least, most) if least.is_infinite() => format!("at most {most}"),
        Bounds::Within(least, most) => format!("{least} to {most}"),
    }
}

/// Writes a value for a report.
pub(super) fn shown(value: Value) -> String {
    match value {
        Value::Float(f) if f.is_finite() => short(f),
        other => other.to_string(),
    }
}

/// Writes a number without the digits that binary fractions leave behind.
fn short(x: f64) -> String {
    let scientific = format!("{x:.width$e}", width = DIGITS.unsigned_abs() as usize - 1);
    // The text was printed from a number, so it parses.
    scientific.parse::<f64>().map_or(scientific, |x| x.to_string())
}

fn told(wanted: &toml::Value, tolerance: f64, found: Value) -> String {
    let text = match (wanted, found) {
        (toml::Value::Boolean(b), _) => Value::Bit(*b).to_string(),
        (toml::Value::Integer(i), Value::Bit(_)) => Value::Bit(*i != 0).to_string(),
        (toml::Value::String(text), _) => text.clone(),
        (other, _) => other.to_string(),
    };
    if tolerance > 0.0 && !matches!(found, Value::Bit(_)) {
        format!("{text} ± {tolerance}")
    } else {
        text
    }
}

const fn kind(value: Value) -> &'static str {
    match value {
        Value::Bit(_) => "a bit",
        Value::Float(_) => "a number",
        Value::S32(_) | Value::U32(_) | Value::S64(_) | Value::U64(_) => "a whole number",
        Value::Port(_) => "a queue",
    }
}
