//! The output of `show worker`, `show snapshot` and `snapshot`.

use crate::language::units::duration;
use hal_protocol::{SnapshotInfo, SnapshotValues, Value, WorkerInfo};
use serde_json::{Map, Number, json};

pub(super) fn workers(text: &mut String, list: &[WorkerInfo], script: bool) {
    if !script {
        text.push_str("Period     Items  State      Steps       Done  Name\n");
    }
    for w in list {
        let period = duration(w.period.unsigned_abs());
        let (most, state) = (w.most, w.state.name());
        text.push_str(&format!(
            "{period:<9} {most:>6}  {state:<7} {:>8} {:>10}  {}\n",
            w.steps, w.items, w.name
        ));
    }
}

pub(super) fn snapshots(text: &mut String, list: &[SnapshotInfo], script: bool) {
    if !script {
        text.push_str("Version  Values  Name\n");
    }
    for s in list {
        let values: u32 = s.fields.iter().map(|f| f.count).sum();
        text.push_str(&format!("{:<7} {values:>7}  {}\n", s.version, s.name));
        for field in s.fields.iter().filter(|_| !script) {
            let count = if field.count > 1 { format!("[{}]", field.count) } else { String::new() };
            let doc = field.doc.lines().next().unwrap_or_default();
            text.push_str(&format!("    {} {}{count}: {doc}\n", field.ty.name(), field.name));
        }
    }
}

/// Writes the record of a snapshot as a JSON object: a value, or a list of values, for each field.
/// Floats that are not finite and 64-bit integers are strings.
pub(crate) fn json(snapshot: &SnapshotValues) -> String {
    let mut record = Map::new();
    for (field, values) in snapshot.info.fields.iter().zip(&snapshot.values) {
        let all: Vec<serde_json::Value> = values.iter().map(plain).collect();
        let value = match (field.count, all.first()) {
            (1, Some(only)) => only.clone(),
            _ => json!(all),
        };
        record.insert(field.name.clone(), value);
    }
    format!("{}\n", json!(record))
}

fn plain(value: &Value) -> serde_json::Value {
    match value {
        Value::Bit(truth) => json!(truth),
        Value::Float(x) => {
            Number::from_f64(*x).map_or_else(|| json!(value.to_string()), Into::into)
        }
        Value::S32(n) => json!(n),
        Value::U32(n) => json!(n),
        other => json!(other.to_string()),
    }
}
