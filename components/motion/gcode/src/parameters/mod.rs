//! Parameters: numbered, named local and global, and those of the system.

pub mod file;
pub mod system;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::Problem;

/// The number of numbered parameters, with the unused 0.
pub const COUNT: usize = 5602;

/// The most named parameters of one level.
pub const MAX_NAMES: usize = 10_000;

/// The numbers of parameters with a meaning.
pub mod number {
    /// The probe's result, X first.
    pub const PROBE: i32 = 5061;
    /// 1 after a probe that tripped.
    pub const PROBE_TRIPPED: i32 = 5070;
    /// The home of G28, X first.
    pub const G28: i32 = 5161;
    /// The home of G30, X first.
    pub const G30: i32 = 5181;
    /// 1 if G92 applies.
    pub const G92_APPLIES: i32 = 5210;
    /// The offset of G92, X first.
    pub const G92: i32 = 5211;
    /// The number of the coordinate system.
    pub const SYSTEM: i32 = 5220;
    /// The switch of messages of `(DEBUG,…)`: they are shown above 0.
    pub const DEBUG: i32 = 5599;
    /// The offset of G54, X first.
    pub const G54: i32 = 5221;
    /// The rotation of G54.
    pub const G54_ROTATION: i32 = 5230;
    /// The distance between coordinate systems.
    pub const SYSTEM_STEP: i32 = 20;
    /// The result of M66.
    pub const INPUT: i32 = 5399;
    /// The tool in the spindle.
    pub const TOOL: i32 = 5400;
    /// The current position, X first.
    pub const POSITION: i32 = 5420;
}

/// A numbered parameter and its value before a change.
pub type Change = (i32, f64);

/// The numbered parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Numbered {
    values: Vec<f64>,
    /// Changes since [`Numbered::take_changes`], the oldest first, if they are recorded.
    #[serde(skip)]
    changes: Option<Vec<Change>>,
}

impl Default for Numbered {
    fn default() -> Self {
        let mut out = Self { values: vec![0.0; COUNT], changes: None };
        out.put(number::SYSTEM, 1.0);
        out.put(number::DEBUG, 1.0);
        out
    }
}

impl Numbered {
    /// Returns the parameter, or 0 where there is none.
    pub fn get(&self, index: i32) -> f64 {
        let index = usize::try_from(index).unwrap_or(0);
        self.values.get(index).copied().unwrap_or(0.0)
    }

    /// Sets the parameter, whether a program may or not.
    pub fn put(&mut self, index: i32, value: f64) {
        let slot = usize::try_from(index).ok().and_then(|i| self.values.get_mut(i));
        if let Some(slot) = slot {
            let before = core::mem::replace(slot, value);
            if let Some(changes) = &mut self.changes {
                changes.push((index, before));
            }
        }
    }

    /// Records changes from now on, for [`Numbered::take_changes`].
    pub fn record_changes(&mut self) {
        self.changes.get_or_insert_default();
    }

    /// Returns the changes since the last call, the oldest first.
    pub fn take_changes(&mut self) -> Vec<Change> {
        self.changes.as_mut().map(core::mem::take).unwrap_or_default()
    }

    /// Returns the first thirty, which a call saves.
    pub fn locals(&self) -> Vec<f64> {
        self.values.get(1..31).unwrap_or_default().to_vec()
    }

    /// Sets the first thirty; missing ones are 0.
    pub fn set_locals(&mut self, values: &[f64]) {
        for index in 1..=30u8 {
            let value = values.get(usize::from(index) - 1).copied().unwrap_or(0.0);
            self.put(i32::from(index), value);
        }
    }
}

/// Checks that a program may read the parameter.
pub fn check_readable(index: i32) -> Result<(), Problem> {
    let count = i32::try_from(COUNT).unwrap_or(i32::MAX);
    if (1..count).contains(&index) { Ok(()) } else { Err(Problem::ParameterRange) }
}

/// Checks that a program may set the parameter.
pub fn check_writable(index: i32) -> Result<(), Problem> {
    check_readable(index)?;
    if (5400..=5413).contains(&index) || (5420..=5428).contains(&index) {
        return Err(Problem::ParameterReadOnly);
    }
    Ok(())
}

/// Named parameters of one level.
pub type Names = BTreeMap<Box<str>, f64>;

/// Sets a named parameter within the bound on their number.
pub fn set_name(names: &mut Names, name: &str, value: f64) -> Result<(), Problem> {
    if let Some(slot) = names.get_mut(name) {
        *slot = value;
        return Ok(());
    }
    if names.len() >= MAX_NAMES {
        return Err(Problem::TooManyNames { limit: MAX_NAMES });
    }
    names.insert(name.into(), value);
    Ok(())
}

/// Returns `value` with `digits` digits; with none, it is rounded to an integer.
pub fn format_value(value: f64, digits: usize) -> String {
    let shown = format!("{value:.digits$}");
    shown
}
