//! Arguments of components and their commands, with their ranges.

use core::fmt;
use serde::{Deserialize, Serialize};

/// An argument of a command or of `loadrt`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArgInfo {
    /// Name, as in `NAME=VALUE`.
    pub name: String,
    /// Type: `int`, `float`, `text`, `ints`, `texts` or `bit`.
    pub ty: String,
    /// Description.
    pub doc: String,
    /// True if the argument is required.
    pub required: bool,
    /// Value that is used if the argument is omitted.
    pub default: Option<String>,
    /// Range of a number, or of each number of a list.
    #[serde(default, skip_serializing_if = "Bounds::is_none")]
    pub bounds: Bounds,
    /// Unit of a number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

impl ArgInfo {
    /// Returns the range with the unit, such as `1 to 8`, `0 or more units/s` or `ns`. Empty if
    /// there is neither.
    #[must_use]
    pub fn range(&self) -> String {
        let (bounds, unit) = (self.bounds.to_string(), self.unit.as_str());
        let blank = if bounds.is_empty() || unit.is_empty() { "" } else { " " };
        format!("{bounds}{blank}{unit}")
    }
}

/// The legal values of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Least legal value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Greatest legal value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// True if `low` itself is not legal.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub above: bool,
}

impl Eq for Bounds {}

impl Bounds {
    /// Returns whether every number is legal.
    #[must_use]
    pub const fn is_none(&self) -> bool {
        self.low.is_none() && self.high.is_none()
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.low, self.high) {
            (Some(low), Some(high)) if self.above => write!(f, "above {low}, up to {high}"),
            (Some(low), Some(high)) => write!(f, "{low} to {high}"),
            (Some(low), None) if self.above => write!(f, "above {low}"),
            (Some(low), None) => write!(f, "{low} or more"),
            (None, Some(high)) => write!(f, "up to {high}"),
            (None, None) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Bounds;

    #[test]
    fn ranges_as_text() {
        let bounds = |low, high, above| Bounds { low, high, above }.to_string();
        for (low, high, above, text) in [
            (Some(1.0), Some(8.0), false, "1 to 8"),
            (Some(0.0), Some(0.5), true, "above 0, up to 0.5"),
            (Some(-1.0), None, false, "-1 or more"),
            (Some(0.0), None, true, "above 0"),
            (None, Some(1e12), false, "up to 1000000000000"),
            (None, None, false, ""),
        ] {
            assert_eq!(bounds(low, high, above), text);
        }
    }
}
