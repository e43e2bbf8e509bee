//! The world of a preview: that of a check, in which every program of the user exists.

use hal_gcode::{
    Environment, Text,
    tool::{Tool, ToolTable},
};
use hal_job::{Machine, World};
use hal_remap::Functions;
use std::{cell::RefCell, collections::BTreeMap};

/// The world of a preview.
pub(super) struct Preview(World);

impl Preview {
    pub(super) fn new(machine: Machine) -> Self {
        Self(World::with_functions(machine, BTreeMap::new()))
    }

    /// Returns the functions in Python of the machine.
    pub(super) const fn functions(&self) -> Option<&RefCell<Functions>> {
        self.0.functions.as_ref()
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

    fn function(&self, name: &str) -> bool {
        self.0.function(name)
    }

    fn user_code(&self, _code: u16) -> Result<bool, Box<str>> {
        Ok(true)
    }
}
