//! What is told of one component to the judge: `tests/judge/NAME.toml`, read and checked.

use super::inputs::fits;
use crate::programs::root;
use hal_protocol::{Patterns, Value};
use serde::Deserialize;
use std::{collections::BTreeSet, fmt::Write, path::PathBuf};

/// The folder of these files.
pub fn folder() -> PathBuf {
    root().join("tests/judge")
}

/// One file. What is left out is as written in `tests/tests/judge.rs`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Case {
    /// Why it is not judged at all.
    pub skip: Option<String>,
    /// Why several instances of theirs cannot be compared: no `names=` beside `loads`.
    pub single: Option<String>,
    /// Arguments of `loadrt`, each a configuration of its own.
    pub loads: Vec<String>,
    /// More arguments, with which only pins, parameters and functions are compared.
    pub shapes: Vec<String>,
    /// What must be loaded before it.
    pub before: Vec<String>,
    /// How often both are loaded anew, at least, where the usual number reaches too little.
    pub rounds: Option<usize>,
    /// Cycles of a round, where the usual number reaches too little.
    pub cycles: Option<u64>,
    /// Periods of the fast thread, in ns; without any, the usual ones.
    pub periods: Vec<u64>,
    /// What inputs are kept to.
    pub inputs: Vec<Input>,
    /// Pins and parameters that only one side has.
    pub only: Vec<Only>,
    /// Items of another kind or direction on the other side, which are given all the same.
    pub kinds: Vec<Only>,
    /// Outputs that never change.
    pub still: Vec<Only>,
    /// First values that differ.
    pub defaults: Vec<First>,
    /// How far numbers may be apart.
    pub tolerance: Vec<Tolerance>,
    /// What is known to differ.
    pub differs: Vec<Known>,
}

/// What some inputs are kept to.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
    /// Sizes alone: no sign, and not 0.
    #[serde(default)]
    pub positive: bool,
    /// Set once after each load, and no more.
    #[serde(default)]
    pub steady: bool,
    /// Never set.
    #[serde(default)]
    pub alone: bool,
    /// No extremes.
    #[serde(default)]
    pub tame: bool,
    /// Never NaN.
    #[serde(default)]
    pub number: bool,
    /// Neither NaN nor infinite.
    #[serde(default)]
    pub finite: bool,
    /// Never 0.
    #[serde(default)]
    pub nonzero: bool,
    /// So many times as large, first of all.
    pub larger: Option<f64>,
    /// Set to this after each load, and no more.
    pub set: Option<String>,
    /// From the first to the second; with `positive`, that is kept as well.
    pub range: Option<[f64; 2]>,
    /// Each whole number of its range is as likely as any other.
    #[serde(default)]
    pub evenly: bool,
    /// One of these, by chance.
    #[serde(default)]
    pub values: Vec<f64>,
    /// Changed once in so many cycles, by chance.
    pub often: Option<u64>,
    /// What our output of this name was after the last cycle, given to both.
    pub follows: Option<String>,
    /// What is multiplied with what it follows: a pin of ours, or a number.
    pub times: Option<String>,
}

impl Input {
    /// What they are kept to, in words.
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

/// Pins and parameters with a reason: those that only one side has, for one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Only {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
    /// What it is set to after each load, where it is ours.
    #[serde(default)]
    pub set: Option<String>,
}

/// A first value that differs; both begin with ours then.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct First {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
    /// Ours, as it is shown.
    pub ours: String,
    /// Theirs, as it is shown.
    pub theirs: String,
}

/// How far numbers may be apart.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
    /// Units of the last place.
    pub ulps: u64,
}

/// A difference that is known, and how bad it may be.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
    /// The first cycle in which it may differ, of any of these pins.
    pub from: u64,
    /// In how many cycles each of these pins may differ.
    pub cycles: u64,
    /// How far numbers may be apart, if there is a bound.
    pub by: Option<f64>,
}

/// Whether a name is one of these.
pub fn named(pins: &[String], name: &str) -> bool {
    Patterns::new(pins).matches(name)
}

impl Case {
    /// The one of a component; nothing is told of most.
    ///
    /// # Errors
    /// It cannot be read, or is wrong.
    pub fn of(module: &str) -> Result<Self, String> {
        let path = folder().join(format!("{module}.toml"));
        let mut case = if path.is_file() {
            let text = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
            Self::parse(&text).map_err(|e| format!("tests/judge/{module}.toml: {e}"))?
        } else {
            Self::default()
        };
        if case.loads.is_empty() {
            case.loads.push(String::new());
        }
        Ok(case)
    }

    /// # Errors
    /// It is wrong.
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

    /// Looks at what is told of an input whose type is known now.
    ///
    /// # Errors
    /// A range is beyond its type.
    pub(super) fn suits(&self, module: &str, name: &str, first: Value) -> Result<(), String> {
        match self.told(name, |i| i.range.filter(|range| !fits(first, *range))) {
            None => Ok(()),
            Some(range) => Err(format!(
                "tests/judge/{module}.toml: range = {range:?}: `{name}` is {}, which has no such number",
                first.ty().name()
            )),
        }
    }

    /// What those that only we have are set to.
    pub(super) fn sets(&self, lone: &BTreeSet<String>) -> Vec<(String, String)> {
        let set = |name: &String| {
            let only = self.only.iter().find(|o| named(&o.pins, name))?;
            Some((name.clone(), only.set.clone()?))
        };
        lone.iter().filter_map(set).collect()
    }

    /// Names in it that no pin has.
    pub fn unknown<'c>(&'c self, names: &[String]) -> Vec<&'c str> {
        let all = self.lists().flat_map(|(pins, _)| pins);
        let known = |p: &&String| !names.iter().any(|n| named(std::slice::from_ref(*p), n));
        all.filter(known).map(String::as_str).collect()
    }

    /// Whether some input is kept to this.
    pub fn keeps(&self, name: &str, to: impl Fn(&Input) -> bool) -> bool {
        self.inputs.iter().any(|i| to(i) && named(&i.pins, name))
    }

    /// What an input is set to, and stays.
    pub fn set(&self, name: &str) -> Option<&str> {
        self.told(name, |i| i.set.as_deref())
    }

    /// The first that is told of an input.
    pub(super) fn told<'c, T>(
        &'c self,
        name: &str,
        of: impl Fn(&'c Input) -> Option<T>,
    ) -> Option<T> {
        self.inputs.iter().filter(|i| named(&i.pins, name)).find_map(of)
    }

    /// How far a number may be apart, in units of the last place.
    pub fn ulps(&self, name: &str) -> u64 {
        self.tolerance.iter().find(|t| named(&t.pins, name)).map_or(0, |t| t.ulps)
    }

    /// What is known of a pin that differs.
    pub fn known(&self, name: &str) -> Option<&Known> {
        self.differs.iter().find(|d| named(&d.pins, name))
    }

    /// What its inputs are kept to, for people.
    pub fn kept(&self) -> String {
        let mut out = String::new();
        if !self.periods.is_empty() {
            write!(out, "; at {:?} ns", self.periods).unwrap();
        }
        for i in &self.inputs {
            let (pins, to) = (i.pins.join("`, `"), i.kept().join(", "));
            write!(out, "; `{pins}` {to}: {}", i.why).unwrap();
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
            "tests/judge/x.toml: range = [-5.0, 10000000000.0]: `x.0.in` is u32, which has no such number"
        );
    }
}
