//! Test plan of the judge: a sequence of rounds, each with its own load, period and style.

use super::{Style, case::Case};
use std::fmt;

/// Number of cycles of a round. A NaN stays in a filter forever and would hide all later differences, so both
/// components are loaded again for each round.
pub const CYCLES: u64 = 500;

/// Periods of the fast thread, in ns: common ones and unusual ones.
pub(super) const PERIODS: [u64; 7] =
    [1_000_000, 25_000, 999_983, 10_000_000, 100_000, 1_000_000_000, 50_021];

/// Ratios of the slow thread's period to the fast one's, where a component has functions for both.
const SLOWER: [u64; 4] = [1, 10, 2, 37];

/// All rounds of a component.
#[derive(Debug)]
pub(super) struct Plan {
    loads: Vec<String>,
    periods: Vec<u64>,
    least: usize,
}

/// A round, for which both components are loaded once.
#[derive(Clone, Debug)]
pub(super) struct LoadPlan {
    /// Stimulus of the inputs.
    pub(super) style: Style,
    /// Arguments of `loadrt`.
    pub(super) args: String,
    /// Period of the fast thread.
    pub(super) period: u64,
    slower: u64,
    /// True if functions are added in random order instead of their own.
    pub(super) shuffled: bool,
    /// True if every input, parameters included, is set at the start.
    pub(super) all_at_first: bool,
}

impl Plan {
    /// Creates the plan for these arguments; with `names`, also for the first of them with instance names added.
    pub(super) fn new(loads: &[String], names: bool, case: &Case) -> Self {
        let own = &case.periods;
        let periods = if own.is_empty() { PERIODS.to_vec() } else { own.clone() };
        let mut loads = loads.to_owned();
        if names {
            loads.push(with_names(&loads[0], &NAMES));
        }
        Self { loads, periods, least: case.rounds.unwrap_or(0) }
    }

    /// Returns the rounds: each load meets each style at several periods.
    pub(super) fn rounds(&self) -> impl Iterator<Item = LoadPlan> {
        let (loads, styles) = (self.loads.len(), Style::ALL.len());
        let groups = PERIODS.len().max(self.least.div_ceil(styles));
        let groups = loads * groups.div_ceil(loads);
        (0..groups * styles).map(move |i| {
            let group = i / styles;
            LoadPlan {
                style: Style::ALL[i % styles],
                args: self.loads[group % loads].clone(),
                period: self.periods[group % self.periods.len()],
                slower: SLOWER[(group / loads) % SLOWER.len()],
                shuffled: group / loads % 2 == 1,
                all_at_first: (group + i) % 2 == 1,
            }
        })
    }
}

/// Instance names, one with a dot.
const NAMES: [&str; 2] = ["judged", "x.y"];

/// Returns the arguments with names added, one personality repeated for each instance.
pub(super) fn with_names(args: &str, names: &[&str]) -> String {
    let each = |word: &str| match word.strip_prefix("personality=") {
        Some(n) => format!("personality={} ", vec![n; names.len()].join(",")),
        None => format!("{word} "),
    };
    let words: String = args.split(' ').filter(|w| !w.is_empty()).map(each).collect();
    format!("{words}names={}", names.join(","))
}

impl LoadPlan {
    /// Returns the lines that create its threads.
    pub(super) fn threads(&self, slow: bool) -> String {
        let (fast, slow) = (self.period, if slow { self.period * self.slower } else { 0 });
        match slow {
            0 => format!("loadrt threads name1=fast period1={fast}"),
            _ => format!("loadrt threads name1=fast period1={fast} name2=slow period2={slow}"),
        }
    }

    /// Returns the name of an item with counted instances: `and2.0.out` for `judged.out`.
    pub(super) fn counted(&self, module: &str, name: &str) -> String {
        let rest = NAMES.iter().find_map(|instance| name.strip_prefix(instance));
        match rest.filter(|_| self.args.contains("names=")) {
            Some(rest) => format!("{}.0{rest}", module.replace('_', "-")),
            None => name.to_owned(),
        }
    }
}

impl fmt::Display for LoadPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} at {} ns, `{}`", self.style, self.period, self.args)
    }
}
