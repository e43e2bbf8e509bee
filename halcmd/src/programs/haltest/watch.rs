//! Names that a test records, and conditions that it waits for while the machine runs.

use super::{
    bench::Bench,
    condition::{Condition, Looking},
    inject,
    outcome::Complaint,
    test::{Named, Test},
};
use crate::language::units::duration;
use hal_protocol::Value;
use std::collections::BTreeSet;

/// Returns the names that must be recorded.
pub(super) fn recorded(test: &Test) -> Vec<String> {
    let names: BTreeSet<String> = all(test).into_iter().map(|n| n.name).collect();
    names.into_iter().collect()
}

/// Returns the errors in names and conditions, once the machine has been set up.
pub(super) fn unknown(test: &Test, bench: &mut Bench) -> Vec<Complaint> {
    let mut wrong: Vec<Complaint> = Vec::new();
    for named in all(test) {
        wrong.extend(inject::value(bench, &named).err());
    }
    if wrong.is_empty() {
        let begun = test.conditions().map(|condition| begin(bench, condition).map(drop));
        wrong.extend(begun.filter_map(Result::err));
    }
    wrong.sort_by(|a, b| a.spot.cmp(&b.spot));
    wrong.dedup();
    wrong
}

fn all(test: &Test) -> Vec<Named> {
    let of_conditions = test.conditions().flat_map(Condition::names);
    of_conditions.chain(test.channels().cloned()).collect()
}

/// Starts evaluating a condition with the machine's types.
fn begin(bench: &mut Bench, condition: &Condition) -> Result<Looking, Complaint> {
    let types = look(bench, &condition.names())?.into_iter().flatten().map(|v| v.ty());
    condition.begin(&types.collect::<Vec<_>>())
}

/// Lets time pass until a condition holds, to the end of that cycle.
pub(super) fn wait(bench: &mut Bench, until: &Condition, within: u64) -> Result<(), Complaint> {
    let names = until.names();
    let spot = &until.named.spot;
    let mut looking = begin(bench, until)?;
    let end = bench.now().saturating_add(i64::try_from(within).unwrap_or(i64::MAX));
    loop {
        let values = look(bench, &names)?;
        if looking.look(&values) {
            return Ok(());
        }
        if bench.now() >= end {
            let text = format!("'{}' is not so within {}", until.named.name, duration(within));
            let complaint = Complaint::new(spot, text);
            return Err(names.iter().zip(values).fold(complaint, |complaint, (name, value)| {
                let value = value.map_or_else(|| "not known".to_owned(), super::compare::shown);
                complaint.with(format!("'{}' is {value}", name.name))
            }));
        }
        bench.cycle(end).map_err(|f| Complaint::new(spot, f.to_string()))?;
    }
}

fn look(bench: &mut Bench, names: &[Named]) -> Result<Vec<Option<Value>>, Complaint> {
    names.iter().map(|named| inject::value(bench, named).map(Some)).collect()
}
