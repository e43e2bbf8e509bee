//! The last cycles before a difference, printed for a person who debugs one component.

use super::verdict::exact;
use hal_protocol::Value;
use std::collections::{BTreeSet, VecDeque};

/// Number of cycles that are printed.
const DEPTH: usize = 16;

/// Values of every pin on both sides, for the last cycles.
#[derive(Debug, Default)]
pub(super) struct History {
    cycles: VecDeque<(u64, Vec<(Value, Value)>)>,
    told: BTreeSet<String>,
}

impl History {
    /// Returns whether the history is requested.
    pub(super) fn wanted() -> bool {
        std::env::var_os("CONFORMANCE").is_some()
    }

    /// Forgets the cycles before a round.
    pub(super) fn begin(&mut self) {
        self.cycles.clear();
    }

    /// Records a cycle.
    pub(super) fn push(&mut self, cycle: u64, values: Vec<(Value, Value)>) {
        if self.cycles.len() == DEPTH {
            self.cycles.pop_front();
        }
        self.cycles.push_back((cycle, values));
    }

    /// Returns the changes in each cycle of the pins of this pin's instance; only once for each instance.
    pub(super) fn of(&mut self, pin: &str, names: &[(String, String)]) -> String {
        let group = pin.rsplit_once('.').map_or("", |(group, _)| group);
        let mine = |name: &str| name.strip_prefix(group).is_some_and(|n| n.starts_with('.'));
        let mut out = String::new();
        if !self.told.insert(group.to_owned()) {
            return out;
        }
        let mut before: Option<&Vec<(Value, Value)>> = None;
        for (cycle, values) in &self.cycles {
            out.push_str(&format!("    {cycle}:"));
            for (i, (name, _)) in names.iter().enumerate().filter(|(_, n)| mine(&n.0)) {
                let (ours, theirs) = values[i];
                if before
                    .is_some_and(|b| exact(b[i].0) == exact(ours) && exact(b[i].1) == exact(theirs))
                {
                    continue;
                }
                out.push_str(&format!(" {}={}", &name[group.len() + 1..], exact(ours)));
                if exact(ours) != exact(theirs) {
                    out.push_str(&format!("|{}", exact(theirs)));
                }
            }
            out.push('\n');
            before = Some(values);
        }
        out
    }
}
