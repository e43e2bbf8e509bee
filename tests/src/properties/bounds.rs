//! Documented limits of outputs, checked after each cycle.

use super::case::{Bound, Case, filled};
use crate::{conformance::inputs::float, foreign::Bench, machine::get};
use std::collections::{BTreeMap, BTreeSet};

/// Tolerance for rounding, relative to the limit.
const SLACK: f64 = 1e-9;

/// Limit of one output.
struct Limit<'c> {
    pin: String,
    row: &'c Bound,
    /// Text that `#` stands for.
    fill: String,
}

/// Limits of all outputs.
pub(super) struct Limits<'c> {
    all: Vec<Limit<'c>>,
    /// Previous values.
    before: BTreeMap<String, f64>,
    /// Outputs whose limit is disabled permanently.
    off: BTreeSet<String>,
}

impl<'c> Limits<'c> {
    /// Returns the limits that a case file declares for these names.
    pub(super) fn of<'n>(case: &'c Case, names: impl Iterator<Item = &'n str>) -> Self {
        let mut all = Vec::new();
        for name in names {
            for row in &case.bounds {
                if let Some(fill) = filled(&row.pin, name) {
                    all.push(Limit { pin: name.to_owned(), row, fill: fill.to_owned() });
                }
            }
        }
        Self { all, before: BTreeMap::new(), off: BTreeSet::new() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Returns the outputs that violate their limits, each with a description.
    pub(super) fn broken(&mut self, b: &mut Bench, secs: f64) -> Vec<(String, String)> {
        let mut out = Vec::new();
        for limit in &self.all {
            let row = limit.row;
            let value = float(get(b, &limit.pin));
            let was = self.before.insert(limit.pin.clone(), value);
            if row.off.as_ref().is_some_and(|off| limit.value(b, off) != 0.0) {
                self.off.insert(limit.pin.clone());
            }
            if self.off.contains(&limit.pin) {
                continue;
            }
            if row.unless.as_ref().is_some_and(|u| limit.value(b, u) == 0.0) {
                continue;
            }
            let mut is = |value: f64, low: f64, high: f64, what: &str| {
                // If the limits cross, both remain as outer limits.
                let (low, high) = (low.min(high), low.max(high));
                let slack = SLACK * (low.abs().max(high.abs()) + value.abs());
                if !(low - slack <= value && value <= high + slack) {
                    let said = format!("{what} {value:?}, not {low:?} to {high:?}");
                    out.push((limit.pin.clone(), said));
                }
            };
            match (limit.product(b, &row.low), limit.product(b, &row.high)) {
                (Some(low), Some(high)) => is(value, low, high, "is"),
                (None, Some(high)) => is(value, -high, high, "is"),
                (Some(low), None) => is(value, low, f64::INFINITY, "is"),
                (None, None) => (),
            }
            if let (Some(rate), Some(was)) = (&row.rate, was) {
                let most = limit.value(b, rate).abs() * secs;
                is(value - was, -most, most, "moves by");
            }
        }
        out
    }
}

impl Limit<'_> {
    fn product(&self, b: &mut Bench, factors: &[String]) -> Option<f64> {
        let values: Vec<f64> = factors.iter().map(|f| self.value(b, f)).collect();
        (!values.is_empty()).then(|| values.into_iter().product())
    }

    /// Returns the value of a number or of an item.
    fn value(&self, b: &mut Bench, text: &str) -> f64 {
        text.parse().unwrap_or_else(|_| float(get(b, &text.replace('#', &self.fill))))
    }
}
