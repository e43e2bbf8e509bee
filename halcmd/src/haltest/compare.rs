//! Values, beside what is expected of them.

use super::{
    expectation::Bounds,
    inject::number,
    outcome::{Complaint, Spot},
};
use hal_protocol::Value;

/// How far, in parts of itself, a number may be from what is expected in any case: binary fractions
/// are never exactly what was written.
const NEARLY: f64 = 1e-9;
/// How many digits of a number are shown.
const DIGITS: i32 = 10;

/// Compares what a pin has with what is expected.
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

/// Whether a value is as expected.
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
        // What is not a number is only like itself.
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

/// Whether a value is within bounds.
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

/// What is expected, in words.
pub(super) fn bounds(bounds: &Bounds, like: Value) -> String {
    match bounds {
        Bounds::Is(wanted, tolerance) => told(wanted, *tolerance, like),
        Bounds::Within(least, most) if most.is_infinite() => format!("at least {least}"),
        Bounds::Within(least, most) if least.is_infinite() => format!("at most {most}"),
        Bounds::Within(least, most) => format!("{least} to {most}"),
    }
}

/// A value as a machinist reads it.
pub(super) fn shown(value: Value) -> String {
    match value {
        Value::Float(f) if f.is_finite() => short(f),
        other => other.to_string(),
    }
}

/// A number without the digits that binary fractions leave behind.
fn short(x: f64) -> String {
    let scientific = format!("{x:.width$e}", width = DIGITS.unsigned_abs() as usize - 1);
    // What was printed is a number.
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
