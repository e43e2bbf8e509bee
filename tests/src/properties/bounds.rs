//! Documented limits of outputs, looked at after each cycle.

use super::case::{Bound, Case, filled};
use crate::{foreign::Bench, judge::inputs::float, machine::get};
use std::collections::{BTreeMap, BTreeSet};

/// How far arithmetic may miss a limit, as a share of it.
const SLACK: f64 = 1e-9;

/// A limit of one output.
struct Limit<'c> {
    pin: String,
    row: &'c Bound,
    /// What `#` stands for.
    fill: String,
}

/// The limits of all outputs.
pub(super) struct Limits<'c> {
    all: Vec<Limit<'c>>,
    /// The last values.
    before: BTreeMap<String, f64>,
    /// Those that have no limit any more.
    off: BTreeSet<String>,
}

impl<'c> Limits<'c> {
    /// Those that a file tells of.
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

    /// What is out of its limits, and how.
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
                // Limits that cross leave both.
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

    /// A number, or that of an item.
    fn value(&self, b: &mut Bench, text: &str) -> f64 {
        text.parse().unwrap_or_else(|_| float(get(b, &text.replace('#', &self.fill))))
    }
}
