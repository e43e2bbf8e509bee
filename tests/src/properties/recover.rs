//! Checks that the effects of exceptional inputs pass when the inputs are sane again.

use super::{HELD, Lifetime};
use crate::{
    conformance::case::named,
    machine::{get, script},
};
use hal_protocol::Value;
use std::collections::BTreeSet;

/// Returns whether an integer is at an end of its type that a value does not reach by chance.
pub(super) fn is_end(value: Value) -> bool {
    match value {
        Value::S32(n) => n == i32::MIN || n == i32::MAX,
        Value::U32(n) => n == u32::MAX,
        Value::S64(n) => n == i64::MIN || n == i64::MAX,
        Value::U64(n) => n == u64::MAX,
        _ => false,
    }
}

impl Lifetime<'_> {
    /// Checks that the effects of exceptional inputs have passed, or pass with a reset.
    pub(super) fn recover(&mut self, stuck: &BTreeSet<usize>) {
        let mut kept = Vec::new();
        for (name, value) in self.left(stuck) {
            match self.case.stays(&name) {
                Some(row) => {
                    self.report.needed.extend(row.pins.iter().cloned());
                    kept.push(row);
                }
                None => {
                    self.fault(&name, &format!("stays {value} when the inputs are sane again"));
                }
            }
        }
        // Items that only a new load resets have a row already.
        let steps = kept.iter().map(|row| row.reset.len()).max().unwrap_or_default();
        for step in 0..steps {
            for (glob, value) in kept.iter().filter_map(|row| row.reset.get(step)).flatten() {
                let glob = std::slice::from_ref(glob);
                for i in self.items.iter().filter(|i| i.given() && named(glob, &i.name)) {
                    script(self.bench, &format!("setp {} {value}", i.name));
                }
            }
            for _ in 0..HELD {
                self.run_once();
            }
        }
        for (name, value) in self.left(stuck) {
            if self.case.stays(&name).is_none_or(|row| !row.reset.is_empty()) {
                self.fault(&name, &format!("is still {value} after its reset"));
            }
        }
    }

    /// Returns the outputs that are not finite, and the integers that are still stuck.
    fn left(&mut self, stuck: &BTreeSet<usize>) -> Vec<(String, String)> {
        let mut out: Vec<_> = self.odd().into_iter().map(|(n, v)| (n, v.to_string())).collect();
        for i in self.ends.intersection(stuck).filter_map(|n| self.items.get(*n)) {
            out.push((i.name.clone(), get(self.bench, &i.name).to_string()));
        }
        out
    }
}
