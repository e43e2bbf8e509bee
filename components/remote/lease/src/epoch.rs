//! The stop epoch of motion or of a robot behind its own controller, as its record has it.

use hal_protocol::{Client, FieldInfo, Snapshot, Value};

/// Names of the records: that of motion comes first.
const RECORDS: [&str; 2] = ["motion.status", "robot.stops"];

/// The record of motion, or of a robot in a machine without it, for its stop epoch.
#[derive(Debug)]
pub struct EpochPage {
    snapshot: Snapshot,
    values: Vec<Value>,
    /// Places of the fields.
    cycle: usize,
    epoch: usize,
}

impl EpochPage {
    /// Opens the record. A machine without motion and robot has none.
    pub fn open(client: &mut Client) -> Option<Self> {
        let snapshot = RECORDS.iter().find_map(|name| client.snapshot(name).ok())?;
        let fields = &snapshot.info().fields;
        let (cycle, epoch) = (place(fields, "cycle")?, place(fields, "epoch")?);
        Some(Self { snapshot, values: Vec::new(), cycle, epoch })
    }

    /// Returns the number of the latest cycle, and its stop epoch; `None` before the first cycle.
    pub fn read(&mut self) -> Option<(u64, u64)> {
        self.snapshot.wait(&mut self.values)?;
        let number = |n: usize| self.values.get(n).map(Value::bits);
        Some((number(self.cycle)?, number(self.epoch)?))
    }
}

/// Returns the number of the first value of a field.
fn place(fields: &[FieldInfo], name: &str) -> Option<usize> {
    let at = fields.iter().position(|field| field.name == name)?;
    Some(fields.iter().take(at).map(|field| field.count as usize).sum())
}

#[cfg(test)]
mod tests {
    use super::place;

    #[test]
    fn a_field_stands_behind_all_values_of_those_before_it() {
        let fields = serde_json::json!([
            { "name": "joint", "ty": "float", "count": 9, "doc": "" },
            { "name": "cycle", "ty": "u64", "count": 1, "doc": "" },
            { "name": "epoch", "ty": "u64", "count": 1, "doc": "" },
        ]);
        let fields: Vec<_> = serde_json::from_value(fields).unwrap();
        let places = ["joint", "cycle", "epoch", "other"].map(|name| place(&fields, name));
        assert_eq!(places, [Some(0), Some(9), Some(10), None]);
    }
}
