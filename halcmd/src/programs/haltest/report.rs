//! The summary line for all tests.

use super::outcome::Outcome;

/// Returns the last line of the output.
pub(super) fn summary(outcomes: &[Outcome]) -> String {
    let failed = outcomes.iter().filter(|o| !o.passed()).count();
    let tests = if outcomes.len() == 1 { "test" } else { "tests" };
    let ns = outcomes.iter().fold(0_u64, |sum, o| sum.saturating_add(o.machine_ns));
    let time = crate::language::units::duration(ns);
    let fate = if failed == 0 { "all passed".to_owned() } else { format!("{failed} failed") };
    format!("{} {tests}, {fate}, {time} of machine time\n", outcomes.len())
}
