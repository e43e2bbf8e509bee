//! The stop epoch of motion, as its record has it.

use hal_protocol::{Client, Snapshot, Value};

/// The record of motion, for its stop epoch.
#[derive(Debug)]
pub struct EpochPage {
    snapshot: Snapshot,
    values: Vec<Value>,
    /// Places of the fields.
    cycle: usize,
    epoch: usize,
}

impl EpochPage {
    /// Opens the record. A machine without motion has none.
    pub fn open(client: &mut Client) -> Option<Self> {
        let snapshot = client.snapshot("motion.status").ok()?;
        let place = |name: &str| {
            let fields = &snapshot.info().fields;
            let at = fields.iter().position(|field| field.name == name)?;
            Some(fields.iter().take(at).map(|field| field.count as usize).sum())
        };
        let (cycle, epoch) = (place("cycle")?, place("epoch")?);
        Some(Self { snapshot, values: Vec::new(), cycle, epoch })
    }

    /// Returns the number of the latest cycle, and its stop epoch; `None` before the first cycle.
    pub fn read(&mut self) -> Option<(u64, u64)> {
        self.snapshot.wait(&mut self.values)?;
        let number = |n: usize| self.values.get(n).map(Value::bits);
        Some((number(self.cycle)?, number(self.epoch)?))
    }
}
