//! Result of a comparison, checked against the known differences.

use super::{
    case::{Case, named},
    plan::LoadPlan,
};
use hal_protocol::{Direction, Value};
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
};

/// Difference of one pin.
#[derive(Clone, Debug)]
pub struct Apart {
    /// First cycle in which the values differed.
    pub first: u64,
    /// Number of cycles in which they differed.
    pub cycles: u64,
    /// Largest difference; infinite if one of the values was not finite.
    pub by: f64,
    /// Both values at the first difference, as text.
    pub said: String,
}

/// Result of a comparison.
#[derive(Debug, Default)]
pub struct Verdict {
    /// Number of pins and parameters that were compared.
    pub compared: usize,
    /// Number of cycles that were run.
    pub cycles: u64,
    /// True if all rounds were run.
    pub whole: bool,
    /// Largest differences among the tolerated ones, in units of the last place.
    pub ulps: BTreeMap<String, u64>,
    /// Number of times that 0 was compared with -0.
    pub zeros: u64,
    /// Pins that differ.
    pub apart: BTreeMap<String, Apart>,
    /// All names of both sides.
    pub names: BTreeSet<String>,
    pub(super) ours_only: BTreeSet<String>,
    pub(super) theirs_only: BTreeSet<String>,
    /// Outputs, by their names with counted instances, and whether they ever changed.
    moved: BTreeMap<String, bool>,
    /// Outputs of this load that have not changed, by name, with the counted name and the first value.
    still: BTreeMap<String, (String, Value)>,
    defaults: BTreeMap<String, String>,
    wrong: BTreeSet<String>,
}

impl Verdict {
    /// Starts a round: both components have been loaded again, with these items.
    pub(super) fn begin<'n>(
        &mut self,
        module: &str,
        round: &LoadPlan,
        items: impl Iterator<Item = (&'n str, (Direction, Value))>,
    ) {
        self.still.clear();
        for (name, (_, value)) in items.filter(|i| matches!(i.1.0, Direction::Out | Direction::Ro))
        {
            let counted = round.counted(module, name);
            if !*self.moved.entry(counted.clone()).or_default() {
                self.still.insert(name.to_owned(), (counted, value));
            }
        }
    }

    /// Records a pin whose type or direction differs.
    pub(super) fn shape(&mut self, name: &str, said: String) {
        self.wrong.insert(format!("`{name}` is {said}"));
    }

    /// Records a first value that differs; returns whether the difference is known.
    pub(super) fn begins(&mut self, case: &Case, name: &str, ours: Value, theirs: Value) -> bool {
        let (ours, theirs) = (exact(ours), exact(theirs));
        let row = case.defaults.iter().find(|d| named(&d.pins, name));
        let said = format!("`{name}` begins with {ours}, theirs with {theirs}");
        let known = row.is_some_and(|d| (&d.ours, &d.theirs) == (&ours, &theirs));
        if let Some(row) = row.filter(|_| known) {
            self.defaults.insert(name.to_owned(), format!("{said}: {}", row.why));
        } else {
            self.wrong.insert(said);
        }
        known
    }

    /// Compares two values; returns whether they differ for the first time.
    pub(super) fn compare(&mut self, name: &str, ours: Value, theirs: Value, allowed: u64) -> bool {
        if let (Value::Float(a), Value::Float(b)) = (ours, theirs)
            && a == 0.0
            && b == 0.0
            && a.to_bits() != b.to_bits()
        {
            self.zeros += 1;
        }
        if let Some((counted, first)) = self.still.get(name)
            && apart(*first, ours) != Some(0)
        {
            self.moved.insert(counted.clone(), true);
            self.still.remove(name);
        }
        let ulps = apart(ours, theirs);
        if let Some(ulps) = ulps.filter(|n| *n <= allowed) {
            if ulps > 0 {
                let most = self.ulps.entry(name.to_owned()).or_default();
                *most = ulps.max(*most);
            }
            return false;
        }
        let by = match (ours, theirs) {
            (Value::Float(a), Value::Float(b)) if (a - b).is_finite() => (a - b).abs(),
            (Value::Float(_), _) => f64::INFINITY,
            _ => number(ours).abs_diff(number(theirs)) as f64,
        };
        if let Some(known) = self.apart.get_mut(name) {
            known.cycles += 1;
            known.by = known.by.max(by);
            return false;
        }
        let mut said = format!("cycle {}: {}, theirs {}", self.cycles, exact(ours), exact(theirs));
        if let Some(ulps) = ulps.filter(|n| *n < 1_000_000) {
            write!(said, ", {ulps} ULPs").unwrap();
        }
        let first = Apart { first: self.cycles, cycles: 1, by, said };
        self.apart.insert(name.to_owned(), first);
        true
    }

    /// Returns the faults: unknown differences, differences larger than the known ones, and known ones that did not
    /// occur.
    pub fn faults(&self, case: &Case) -> Vec<String> {
        let mut out: Vec<String> = self.wrong.iter().cloned().collect();
        for (side, list) in [("ours", &self.ours_only), ("theirs", &self.theirs_only)] {
            for name in list.iter().filter(|n| !case.only.iter().any(|o| named(&o.pins, n))) {
                out.push(format!("only {side} has `{name}`"));
            }
        }
        for (name, apart) in &self.apart {
            let Some(known) = case.known(name) else {
                out.push(format!("`{name}` {}", apart.said));
                continue;
            };
            if apart.first < known.from {
                out.push(format!("`{name}` sooner than in cycle {}: {}", known.from, apart.said));
            }
            if apart.cycles > known.cycles {
                out.push(format!(
                    "`{name}` differs in {} cycles, not {} at most",
                    apart.cycles, known.cycles
                ));
            }
            if known.by.is_some_and(|by| by < apart.by) {
                out.push(format!("`{name}` differs by {:e}: {}", apart.by, apart.said));
            }
        }
        if self.whole {
            self.stale(case, &mut out);
        }
        out
    }

    /// Adds the known differences that are wrong or no longer occur.
    fn stale(&self, case: &Case, out: &mut Vec<String>) {
        let names: Vec<String> = self.names.iter().cloned().collect();
        for pin in case.unknown(&names) {
            out.push(format!("no pin is `{pin}`, of which its file tells"));
        }
        for name in self.moved.iter().filter(|(_, moved)| !**moved).map(|(name, _)| name) {
            if !case.still.iter().any(|s| named(&s.pins, name)) {
                out.push(format!("`{name}` never moves"));
            }
        }
        let mut gone = |what: &str, pins: &[String], found: bool| {
            if !found {
                out.push(format!("`{}`: {what}: take it out of its file", pins.join("`, `")));
            }
        };
        for d in &case.differs {
            gone("no longer differs", &d.pins, self.apart.keys().any(|n| named(&d.pins, n)));
        }
        for t in &case.tolerance {
            gone("needs no tolerance", &t.pins, self.ulps.keys().any(|n| named(&t.pins, n)));
        }
        for d in &case.defaults {
            gone("begins as theirs", &d.pins, self.defaults.keys().any(|n| named(&d.pins, n)));
        }
        for s in &case.still {
            let found = self.moved.iter().any(|(n, moved)| !moved && named(&s.pins, n));
            gone("moves", &s.pins, found);
            for (name, _) in self.moved.iter().filter(|(n, moved)| **moved && named(&s.pins, n)) {
                gone("moves", std::slice::from_ref(name), false);
            }
        }
        for o in &case.only {
            let lone = self.ours_only.iter().chain(&self.theirs_only);
            gone("both have it", &o.pins, lone.into_iter().any(|n| named(&o.pins, n)));
        }
    }

    /// Returns the row of the table, without the name; behind its last cell, each fact begins with a tab.
    pub fn row(&self, case: &Case) -> String {
        let faults = self.faults(case);
        let moved = self.moved.values().filter(|moved| **moved).count();
        let mut out =
            format!("{} | {moved} of {} | {} | ", self.compared, self.moved.len(), self.cycles);
        if faults.is_empty() {
            let most = self.ulps.values().max().copied().unwrap_or(0);
            match (self.apart.len() + self.defaults.len(), most) {
                (0, 0) => out.push_str("equal"),
                (0, most) => write!(out, "equal within {most} ULPs").unwrap(),
                (n, _) => write!(out, "equal but for {n}, which are known").unwrap(),
            }
        } else {
            write!(out, "DIFFERS: {}", faults.join("; ")).unwrap();
        }
        for t in case.tolerance.iter().filter(|_| !self.ulps.is_empty()) {
            write!(out, "\t`{}` within {} ULPs: {}", t.pins.join("`, `"), t.ulps, t.why).unwrap();
        }
        for (name, apart) in &self.apart {
            if let Some(known) = case.known(name) {
                let (said, n) = (&apart.said, apart.cycles);
                write!(out, "\t`{name}` in {n} cycles, {said}: {}", known.why).unwrap();
            }
        }
        for said in self.defaults.values() {
            write!(out, "\t{said}").unwrap();
        }
        out.push_str(&case.kept());
        for s in &case.still {
            write!(out, "\t`{}` never moves: {}", s.pins.join("`, `"), s.why).unwrap();
        }
        if let Some(why) = &case.single {
            write!(out, "\tone instance alone: {why}").unwrap();
        }
        for o in &case.only {
            write!(out, "\tonly one has `{}`: {}", o.pins.join("`, `"), o.why).unwrap();
            if let Some(value) = &o.set {
                write!(out, ", and it is {value} here").unwrap();
            }
        }
        for k in &case.kinds {
            write!(out, "\t`{}` of another kind: {}", k.pins.join("`, `"), k.why).unwrap();
        }
        if self.zeros > 0 {
            write!(out, "\t0 beside -0: {}", self.zeros).unwrap();
        }
        out
    }
}

/// Returns the distance of two values in units of the last place; `None` if they are not numbers that can be compared
/// in this way.
fn apart(ours: Value, theirs: Value) -> Option<u64> {
    match (ours, theirs) {
        (Value::Float(a), Value::Float(b)) => {
            if a.is_nan() && b.is_nan() || a.to_bits() == b.to_bits() {
                return Some(0);
            }
            let place = |f: f64| {
                let size = f.abs().to_bits().cast_signed();
                if f.is_sign_negative() { -size } else { size }
            };
            (a.is_finite() && b.is_finite()).then(|| place(a).abs_diff(place(b)))
        }
        _ => (ours == theirs).then_some(0),
    }
}

/// Converts a value that is not a float to an integer.
fn number(value: Value) -> i128 {
    match value {
        Value::Bit(b) => i128::from(b),
        Value::S32(n) => n.into(),
        Value::U32(n) => n.into(),
        Value::S64(n) => n.into(),
        Value::U64(n) => n.into(),
        Value::Float(_) | Value::Port(_) => 0,
    }
}

/// Returns a value with all its digits.
pub(super) fn exact(value: Value) -> String {
    match value {
        Value::Float(f) => format!("{f:?}"),
        other => other.to_string(),
    }
}
