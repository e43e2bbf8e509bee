//! What is looked at while a test runs: what is recorded, and conditions that are waited for.

use super::{
    bench::Bench,
    condition::{Condition, Looking},
    inject,
    outcome::Complaint,
    test::{Named, Test},
};
use crate::units::duration;
use hal_protocol::Value;
use std::collections::BTreeSet;

/// The names of what must be recorded.
pub(super) fn recorded(test: &Test) -> Vec<String> {
    let names: BTreeSet<String> = all(test).into_iter().map(|n| n.name).collect();
    names.into_iter().collect()
}

/// What is wrong with names and conditions that are looked at, once the machine is made.
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

/// Looks at the machine from now on.
fn begin(bench: &mut Bench, condition: &Condition) -> Result<Looking, Complaint> {
    let types = look(bench, &condition.names())?.into_iter().flatten().map(|v| v.ty());
    condition.begin(&types.collect::<Vec<_>>())
}

/// Time passes until something is so: to the end of the cycle in which it is.
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
