//! State of a machine: the records of its snapshots, and facts of its INI file.

use hal_ini::Ini;
use hal_protocol::{Snapshot, SnapshotInfo, Value};
use std::collections::BTreeMap;

/// A record of a snapshot: values by the name of their field.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Position of the first value, and number of values, of each field.
    fields: BTreeMap<String, (usize, usize)>,
    values: Vec<Value>,
}

impl Record {
    /// Creates a record without values.
    #[must_use]
    pub fn new(info: &SnapshotInfo) -> Self {
        let (mut fields, mut first) = (BTreeMap::new(), 0);
        for field in &info.fields {
            let count = field.count as usize;
            fields.insert(field.name.clone(), (first, count));
            first += count;
        }
        Self { fields, values: Vec::new() }
    }

    /// Returns the place for the values, in the order of the snapshot.
    pub const fn values_mut(&mut self) -> &mut Vec<Value> {
        &mut self.values
    }

    /// Sets the values of a field.
    pub fn set(&mut self, name: &str, values: &[Value]) {
        let at = self.values.len();
        self.fields.insert(name.to_owned(), (at, values.len()));
        self.values.extend_from_slice(values);
    }

    fn all(&self, name: &str) -> &[Value] {
        let (first, count) = self.fields.get(name).copied().unwrap_or_default();
        self.values.get(first..first + count).unwrap_or_default()
    }

    /// Returns a value of a field as a number; 0 where there is none.
    #[must_use]
    pub fn number(&self, name: &str, n: usize) -> f64 {
        self.all(name).get(n).map_or(0.0, Value::number)
    }

    /// Returns a value of a field as a count.
    #[must_use]
    pub fn count(&self, name: &str, n: usize) -> u32 {
        match self.all(name).get(n) {
            Some(Value::U32(u)) => *u,
            Some(Value::S32(i)) => i.unsigned_abs(),
            Some(Value::Bit(on)) => u32::from(*on),
            _ => 0,
        }
    }

    /// Returns a value of a field as true or false.
    #[must_use]
    pub fn bit(&self, name: &str, n: usize) -> bool {
        self.all(name).get(n).is_some_and(|value| value.bits() & 1 != 0)
    }

    /// Returns whether bit `n` of a field of bits is set.
    #[must_use]
    pub fn has(&self, name: &str, n: usize) -> bool {
        n < 32 && self.count(name, 0) >> n & 1 != 0
    }

    /// Returns a field of words as text: eight bytes in each, the first lowest.
    #[must_use]
    pub fn text(&self, name: &str) -> String {
        Snapshot::text(self.all(name))
    }
}

/// Facts of a machine from its INI file.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Path of the INI file.
    pub path: String,
    /// The file.
    pub ini: Ini,
    /// True if the unit of length is the inch.
    pub is_inch: bool,
    /// Units of angles per degree.
    pub angular: f64,
    /// True for a joint that turns.
    pub turns: Vec<bool>,
    /// Kind of the kinematics: 1 for joints that are the axes, 4 for others.
    pub kinematics: u32,
}

impl Facts {
    /// Reads the facts.
    #[must_use]
    pub fn new(path: String, ini: Ini) -> Self {
        let word = |section: &str, name: &str| ini.get(section, name).unwrap_or("").trim();
        let lower = |section: &str, name: &str| word(section, name).to_lowercase();
        let angular = match lower("TRAJ", "ANGULAR_UNITS").as_str() {
            "rad" | "radian" => core::f64::consts::PI / 180.0,
            "grad" | "gon" => 10.0 / 9.0,
            _ => 1.0,
        };
        let joints = word("KINS", "JOINTS").parse::<usize>().unwrap_or(0).min(64);
        let turns =
            (0..joints).map(|n| lower(&format!("JOINT_{n}"), "TYPE") == "angular").collect();
        let words = lower("KINS", "KINEMATICS");
        let is_plain = words.split_whitespace().next() == Some("trivkins");
        let kinematics = if is_plain && !words.contains("kinstype=both") { 1 } else { 4 };
        Self { path, is_inch: ini.is_inch().unwrap_or(false), angular, turns, kinematics, ini }
    }
}

/// State of a machine: its snapshots, and facts of its INI file.
#[derive(Clone, Debug)]
pub struct Snapshots {
    /// Record of motion.
    pub motion: Record,
    /// Record of the task.
    pub task: Record,
    /// Facts of the INI file.
    pub facts: Facts,
}

impl Snapshots {
    /// Fills the record of the task on a machine without one, from that of motion.
    pub fn fill_task(&mut self) {
        let motion = &self.motion;
        let state = match (motion.bit("estop", 0), motion.bit("enabled", 0)) {
            (true, _) => 0,
            (false, false) => 1,
            (false, true) => 2,
        };
        let interpreter = match (motion.bit("paused", 0), motion.count("queue", 0)) {
            (true, _) => 2,
            (false, 0) => 0,
            (false, _) => 1,
        };
        let mut task = Record::default();
        task.set("state", &[Value::U32(state)]);
        task.set("interpreter", &[Value::U32(interpreter)]);
        for name in ["feed_override", "rapid_override", "spindle_override"] {
            task.set(name, motion.all(name));
        }
        self.task = task;
    }

    /// Returns whether the machine is in e-stop.
    #[must_use]
    pub fn is_estop(&self) -> bool {
        self.task.count("state", 0) == 0
    }

    /// Returns whether jogs move axes.
    #[must_use]
    pub fn is_teleop(&self) -> bool {
        self.motion.count("mode", 0) == 1
    }
}
