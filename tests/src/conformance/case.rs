//! Description of one component for the judge: `tests/conformance/NAME.toml`, parsed and checked.

use super::inputs::fits;
use crate::programs::root;
use hal_protocol::{Patterns, Value};
use serde::Deserialize;
use std::{collections::BTreeSet, fmt::Write, path::PathBuf};

/// Returns the folder of these files.
pub fn folder() -> PathBuf {
    root().join("tests/conformance")
}

/// Contents of a file. `tests/tests/system/peer/conformance.rs` documents the defaults of omitted entries.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Case {
    /// Reason for not judging the component at all.
    pub skip: Option<String>,
    /// Reason why several instances of LinuxCNC's component cannot be compared: no `names=` in addition to `loads`.
    pub single: Option<String>,
    /// Arguments of `loadrt`, each a configuration of its own.
    pub loads: Vec<String>,
    /// Further arguments, with which only pins, parameters and functions are compared.
    pub shapes: Vec<String>,
    /// Modules that must be loaded first.
    pub before: Vec<String>,
    /// Minimum number of loads, where the default covers too little.
    pub rounds: Option<usize>,
    /// Number of cycles of a round, where the default covers too little.
    pub cycles: Option<u64>,
    /// Periods of the fast thread, in ns; the default ones if empty.
    pub periods: Vec<u64>,
    /// Constraints of inputs.
    pub inputs: Vec<Input>,
    /// Pins and parameters that only one side has.
    pub only: Vec<Only>,
    /// Items of another kind or direction on the other side, which are driven all the same.
    pub kinds: Vec<Only>,
    /// Outputs that never change.
    pub still: Vec<Only>,
    /// First values that differ.
    pub defaults: Vec<First>,
    /// Tolerances of numbers.
    pub tolerance: Vec<Tolerance>,
    /// Known differences.
    pub differs: Vec<Known>,
}

/// Constraints of some inputs.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
    /// True for positive values only.
    #[serde(default)]
    pub positive: bool,
    /// True if the input is set only once, after each load.
    #[serde(default)]
    pub steady: bool,
    /// True if the input is never set.
    #[serde(default)]
    pub alone: bool,
    /// True if the input receives no extremes.
    #[serde(default)]
    pub tame: bool,
    /// True if the input is never NaN.
    #[serde(default)]
    pub number: bool,
    /// True if the input is never NaN or infinite.
    #[serde(default)]
    pub finite: bool,
    /// True if the input is never 0.
    #[serde(default)]
    pub nonzero: bool,
    /// Factor applied before all other constraints.
    pub larger: Option<f64>,
    /// Constant that the input is set to once, after each load.
    pub set: Option<String>,
    /// Range, from the first to the second; `positive` applies as well.
    pub range: Option<[f64; 2]>,
    /// True if each integer of the range is equally likely.
    #[serde(default)]
    pub evenly: bool,
    /// Values to choose from at random.
    #[serde(default)]
    pub values: Vec<f64>,
    /// Average number of cycles between random changes.
    pub often: Option<u64>,
    /// Our output whose value after the last cycle is given to both.
    pub follows: Option<String>,
    /// Factor of the followed output: a pin of ours, or a number.
    pub times: Option<String>,
}

impl Input {
    /// Returns the constraints in words.
    fn kept(&self) -> Vec<String> {
        let words = [
            (self.alone, "left alone"),
            (self.positive, "kept positive"),
            (self.steady, "set once"),
            (self.tame, "without extremes"),
            (self.number, "never NaN"),
            (self.finite, "finite"),
            (self.nonzero, "not 0"),
            (self.evenly, "evenly"),
        ];
        let mut out: Vec<String> = words.iter().filter(|w| w.0).map(|w| w.1.to_owned()).collect();
        out.extend(self.larger.map(|n| format!("{n:e} times as large")));
        out.extend(self.range.map(|[low, high]| format!("from {low:e} to {high:e}")));
        out.extend(self.set.as_ref().map(|value| format!("set to {value}")));
        out.extend((!self.values.is_empty()).then(|| format!("one of {:?}", self.values)));
        out.extend(self.often.map(|n| format!("changed once in {n} cycles")));
        out.extend(self.follows.as_ref().map(|pin| match &self.times {
            Some(by) => format!("`{pin}` times {by} of the cycle before"),
            None => format!("`{pin}` of the cycle before"),
        }));
        out
    }
}

/// Pins and parameters with a reason, for example those that only one side has.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Only {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
    /// Value set after each load, for our items.
    #[serde(default)]
    pub set: Option<String>,
}

/// A first value that differs; both sides are then set to ours.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct First {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
    /// Our value, as displayed.
    pub ours: String,
    /// LinuxCNC's value, as displayed.
    pub theirs: String,
}

/// Tolerance of numbers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
    /// Tolerance in units of the last place.
    pub ulps: u64,
}

/// A known difference, and its bounds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
    /// First cycle in which any of these pins may differ.
    pub from: u64,
    /// Maximum number of cycles in which each of these pins may differ.
    pub cycles: u64,
    /// Largest permitted difference of numbers, if bounded.
    pub by: Option<f64>,
}

/// Returns whether the list contains a name.
pub fn named(pins: &[String], name: &str) -> bool {
    Patterns::new(pins).matches(name)
}

impl Case {
    /// Reads the case of a component; most components have none.
    ///
    /// # Errors
    /// The file cannot be read, or is wrong.
    pub fn of(module: &str) -> Result<Self, String> {
        let path = folder().join(format!("{module}.toml"));
        let mut case = if path.is_file() {
            let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
            Self::parse(&text).map_err(|e| format!("tests/conformance/{module}.toml: {e}"))?
        } else {
            Self::default()
        };
        if case.loads.is_empty() {
            case.loads.push(String::new());
        }
        Ok(case)
    }

    /// # Errors
    /// The text is wrong.
    fn parse(text: &str) -> Result<Self, String> {
        let case: Self = toml::from_str(text).map_err(|e| e.to_string())?;
        for i in &case.inputs {
            if i.kept().is_empty() {
                return Err(format!("{}: positive, steady, alone, tame, …?", i.pins.join(", ")));
            }
        }
        if let Some(i) = case.inputs.iter().find(|i| i.evenly && i.range.is_none()) {
            return Err(format!("{}: evenly in which range?", i.pins.join(", ")));
        }
        if let Some(i) = case.inputs.iter().find(|i| i.range.is_some_and(|[a, b]| b < a)) {
            return Err(format!(
                "{}: range = {:?} ends before it begins",
                i.pins.join(", "),
                i.range
            ));
        }
        if case.lists().any(|(pins, why)| pins.is_empty() || why.is_empty()) {
            return Err("a list without pins, or without a reason".to_owned());
        }
        Ok(case)
    }

    fn lists(&self) -> impl Iterator<Item = (&[String], &str)> {
        let inputs = self.inputs.iter().map(|r| (&*r.pins, &*r.why));
        let only =
            self.only.iter().chain(&self.kinds).chain(&self.still).map(|r| (&*r.pins, &*r.why));
        let defaults = self.defaults.iter().map(|r| (&*r.pins, &*r.why));
        let tolerance = self.tolerance.iter().map(|r| (&*r.pins, &*r.why));
        let differs = self.differs.iter().map(|r| (&*r.pins, &*r.why));
        inputs.chain(only).chain(defaults).chain(tolerance).chain(differs)
    }

    /// Checks the constraints of an input against its type.
    ///
    /// # Errors
    /// A range exceeds the type.
    pub(super) fn suits(&self, module: &str, name: &str, first: Value) -> Result<(), String> {
        match self.told(name, |i| i.range.filter(|range| !fits(first, *range))) {
            None => Ok(()),
            Some(range) => Err(format!(
                "tests/conformance/{module}.toml: range = {range:?}: `{name}` is {}, which has no such number",
                first.ty().name()
            )),
        }
    }

    /// Returns the values of the items that only ours has.
    pub(super) fn sets(&self, lone: &BTreeSet<String>) -> Vec<(String, String)> {
        let set = |name: &String| {
            let only = self.only.iter().find(|o| named(&o.pins, name))?;
            Some((name.clone(), only.set.clone()?))
        };
        lone.iter().filter_map(set).collect()
    }

    /// Returns the names in the file that match no pin.
    pub fn unknown<'c>(&'c self, names: &[String]) -> Vec<&'c str> {
        let all = self.lists().flat_map(|(pins, _)| pins);
        let known = |p: &&String| !names.iter().any(|n| named(std::slice::from_ref(*p), n));
        all.filter(known).map(String::as_str).collect()
    }

    /// Returns whether an input has a constraint.
    pub fn keeps(&self, name: &str, to: impl Fn(&Input) -> bool) -> bool {
        self.inputs.iter().any(|i| to(i) && named(&i.pins, name))
    }

    /// Returns the constant that an input is set to.
    pub fn set(&self, name: &str) -> Option<&str> {
        self.told(name, |i| i.set.as_deref())
    }

    /// Returns the first constraint given for an input.
    pub(super) fn told<'c, T>(
        &'c self,
        name: &str,
        of: impl Fn(&'c Input) -> Option<T>,
    ) -> Option<T> {
        self.inputs.iter().filter(|i| named(&i.pins, name)).find_map(of)
    }

    /// Returns the tolerance of a pin, in units of the last place.
    pub fn ulps(&self, name: &str) -> u64 {
        self.tolerance.iter().find(|t| named(&t.pins, name)).map_or(0, |t| t.ulps)
    }

    /// Returns the known difference of a pin.
    pub fn known(&self, name: &str) -> Option<&Known> {
        self.differs.iter().find(|d| named(&d.pins, name))
    }

    /// Returns the constraints of its inputs, for a person, each behind a tab.
    pub fn kept(&self) -> String {
        let mut out = String::new();
        if !self.periods.is_empty() {
            write!(out, "\tat {:?} ns", self.periods).unwrap();
        }
        for i in &self.inputs {
            let (pins, to) = (i.pins.join("`, `"), i.kept().join(", "));
            write!(out, "\t`{pins}` {to}: {}", i.why).unwrap();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::Case;
    use hal_protocol::Value;

    #[test]
    fn what_is_wrong_in_a_file_is_told() {
        let wrong = |text: &str| Case::parse(text).unwrap_err();
        assert!(wrong("skp = \"x\"").contains("unknown field `skp`"));
        assert!(wrong("[[inputs]]\npins = [\"a\"]\nwhy = \"b\"").contains("positive, steady"));
        let evenly = "[[inputs]]\npins = [\"a\"]\nwhy = \"b\"\nevenly = true";
        assert!(wrong(evenly).contains("in which range"));
        let range = evenly.replace("evenly = true", "range = [1, 0]");
        assert!(wrong(&range).contains("ends before it begins"));
        assert!(wrong("[[tolerance]]\npins = []\nwhy = \"b\"\nulps = 1").contains("without pins"));
        assert!(wrong("[[differs]]\npins = [\"a\"]\nwhy = \"b\"").contains("missing field `from`"));
    }

    #[test]
    fn a_range_is_one_of_the_type() {
        let case =
            Case::parse("[[inputs]]\npins = [\"*\"]\nwhy = \"b\"\nrange = [-5, 1e10]").unwrap();
        for (first, suits) in [
            (Value::Float(0.0), true),
            (Value::Bit(false), true),
            (Value::S64(0), true),
            (Value::S32(0), false),
            (Value::U32(0), false),
            (Value::U64(0), false),
        ] {
            assert_eq!(case.suits("x", "x.0.in", first).is_ok(), suits, "{first:?}");
        }
        assert_eq!(
            case.suits("x", "x.0.in", Value::U32(0)).unwrap_err(),
            "tests/conformance/x.toml: range = [-5.0, 10000000000.0]: `x.0.in` is u32, which has no such number"
        );
    }
}
