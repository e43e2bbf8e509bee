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

#[cfg(test)]
mod tests {
    use super::{json, workers};
    use hal_protocol::{
        FieldInfo, SnapshotInfo, SnapshotValues, Type, Value, WorkerInfo, WorkerState,
    };

    #[test]
    fn columns_of_workers() {
        let worker = |name: &str, state| WorkerInfo {
            name: name.to_owned(),
            owner_name: "planner".to_owned(),
            period: 10_000_000,
            most: 20,
            steps: 12,
            items: 240,
            state,
            doc: String::new(),
        };
        let list = [worker("planner.plan", WorkerState::Idle), worker("x", WorkerState::Working)];
        let mut text = String::new();
        workers(&mut text, &list, false);
        let want = "Period     Items  State      Steps       Done  Name\n\
                    10 ms         20  idle          12        240  planner.plan\n\
                    10 ms         20  working       12        240  x\n";
        assert_eq!(text, want);
    }

    #[test]
    fn values_that_json_cannot_hold_are_strings() {
        let rows = [
            ("nan", vec![Value::Float(f64::NAN)]),
            ("list", vec![Value::Float(f64::INFINITY), Value::Float(-0.5)]),
            ("large", vec![Value::U64(u64::MAX)]),
            ("least", vec![Value::S64(i64::MIN)]),
            ("small", vec![Value::S32(-1)]),
        ];
        let field = |name: &str, values: &[Value]| FieldInfo {
            name: name.to_owned(),
            ty: Type::Float,
            count: u32::try_from(values.len()).unwrap(),
            doc: String::new(),
        };
        let info = SnapshotInfo {
            name: "a.b".to_owned(),
            owner_name: "a".to_owned(),
            version: 1,
            doc: String::new(),
            fields: rows.iter().map(|(name, values)| field(name, values)).collect(),
        };
        let values = rows.into_iter().map(|(_, values)| values).collect();
        let want = "{\"large\":\"18446744073709551615\",\"least\":\"-9223372036854775808\",\
                    \"list\":[\"inf\",-0.5],\"nan\":\"nan\",\"small\":-1}\n";
        assert_eq!(json(&SnapshotValues { info, records: 1, values }), want);
    }
}
