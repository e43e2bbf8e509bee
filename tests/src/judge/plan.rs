//! What the judge does to a component: round after round, each with a load, a period and a style
//! of its own.

use super::{Style, case::Case};
use std::fmt;

/// Cycles of a round. What is not a number stays in a filter for ever, and would hide all that
/// follows: so both are loaded anew.
pub const CYCLES: u64 = 500;

/// Periods of the fast thread, in ns: users' ones, and odd ones.
pub(super) const PERIODS: [u64; 7] =
    [1_000_000, 25_000, 999_983, 10_000_000, 100_000, 1_000_000_000, 50_021];

/// How much slower the other thread is, where a component has functions for both.
const SLOWER: [u64; 4] = [1, 10, 2, 37];

/// All rounds of a component.
#[derive(Debug)]
pub(super) struct Plan {
    loads: Vec<String>,
    periods: Vec<u64>,
    least: usize,
}

/// Both loaded once.
#[derive(Clone, Debug)]
pub(super) struct Round {
    /// What inputs do.
    pub(super) style: Style,
    /// Arguments of `loadrt`.
    pub(super) args: String,
    /// Period of the fast thread.
    pub(super) period: u64,
    slower: u64,
    /// Functions are added in an order by chance, not in theirs.
    pub(super) shuffled: bool,
    /// Every input is set at first, parameters as well.
    pub(super) all_at_first: bool,
}

impl Plan {
    /// Of these arguments, and of names for instances beside the first of them.
    pub(super) fn new(loads: &[String], names: bool, case: &Case) -> Self {
        let own = &case.periods;
        let periods = if own.is_empty() { PERIODS.to_vec() } else { own.clone() };
        let mut loads = loads.to_owned();
        if names {
            loads.push(with_names(&loads[0], &NAMES));
        }
        Self { loads, periods, least: case.rounds.unwrap_or(0) }
    }

    /// Each load meets each style at several periods.
    pub(super) fn rounds(&self) -> impl Iterator<Item = Round> {
        let (loads, styles) = (self.loads.len(), Style::ALL.len());
        let groups = PERIODS.len().max(self.least.div_ceil(styles));
        let groups = loads * groups.div_ceil(loads);
        (0..groups * styles).map(move |i| {
            let group = i / styles;
            Round {
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

/// Names of instances, one with a dot.
const NAMES: [&str; 2] = ["judged", "x.y"];

/// Arguments with names for instances, each of the same personality.
pub(super) fn with_names(args: &str, names: &[&str]) -> String {
    let each = |word: &str| match word.strip_prefix("personality=") {
        Some(n) => format!("personality={} ", vec![n; names.len()].join(",")),
        None => format!("{word} "),
    };
    let words: String = args.split(' ').filter(|w| !w.is_empty()).map(each).collect();
    format!("{words}names={}", names.join(","))
}

impl Round {
    /// The lines that make its threads.
    pub(super) fn threads(&self, slow: bool) -> String {
        let (fast, slow) = (self.period, if slow { self.period * self.slower } else { 0 });
        match slow {
            0 => format!("loadrt threads name1=fast period1={fast}"),
            _ => format!("loadrt threads name1=fast period1={fast} name2=slow period2={slow}"),
        }
    }

    /// The name that an item has where instances are counted: `and2.0.out` for `judged.out`.
    pub(super) fn counted(&self, module: &str, name: &str) -> String {
        let rest = NAMES.iter().find_map(|instance| name.strip_prefix(instance));
        match rest.filter(|_| self.args.contains("names=")) {
            Some(rest) => format!("{}.0{rest}", module.replace('_', "-")),
            None => name.to_owned(),
        }
    }
}

impl fmt::Display for Round {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} at {} ns, `{}`", self.style, self.period, self.args)
    }
}
