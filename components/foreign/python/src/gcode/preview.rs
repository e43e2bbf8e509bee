//! The world of a preview: that of a check, in which every program of the user exists.

use hal_gcode::{
    Environment, Text,
    tool::{Tool, ToolTable},
};
use hal_job::{Machine, World};
use std::collections::BTreeMap;

/// The world of a preview.
pub(super) struct Preview(World);

impl Preview {
    pub(super) fn new(machine: Machine) -> Self {
        Self(World { machine, hal: BTreeMap::new() })
    }

    /// Returns the tool table.
    pub(super) const fn tools(&self) -> &ToolTable {
        &self.0.machine.tools
    }
}

impl Environment for Preview {
    fn open(&self, name: &str) -> Option<Text> {
        self.0.open(name)
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        self.0.tool(number)
    }

    fn ini(&self, section: &str, key: &str) -> Option<f64> {
        self.0.ini(section, key)
    }

    fn user_code(&self, _code: u16) -> bool {
        true
    }
}
