//! Options of a .comp file, and the values that a file chooses.

use crate::{
    Problem,
    place::Fault,
    tree::{At, OptionLine, Value},
};
use std::collections::BTreeMap;

/// Kind of value of an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// Yes or no, with this default.
    Switch(bool),
    /// Integer in this range.
    Whole(i128, i128),
    /// Name of a C type.
    Type,
    /// Any text.
    Text,
}

/// Name, value kind and description of an option.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Name of the option.
    pub name: &'static str,
    /// Kind of its value.
    pub takes: Takes,
    /// Description of its effect.
    pub help: &'static str,
}

const fn row(name: &'static str, takes: Takes, help: &'static str) -> Row {
    Row { name, takes, help }
}

/// All options.
pub const OPTIONS: &[Row] = &[
    row("singleton", Takes::Switch(false), "one instance, named as the component"),
    row(
        "default_count",
        Takes::Whole(1, 65_536),
        "how many instances there are without count= and names=",
    ),
    row("count_function", Takes::Switch(false), "int get_count(void) of the C text says how many"),
    row(
        "rtapi_app",
        Takes::Switch(true),
        "no: the C text has its own rtapi_app_main and rtapi_app_exit",
    ),
    row("data", Takes::Type, "each instance has one of this type, as `data`"),
    row(
        "extra_setup",
        Takes::Switch(false),
        "EXTRA_SETUP() runs before an instance's pins are made",
    ),
    row(
        "extra_cleanup",
        Takes::Switch(false),
        "EXTRA_CLEANUP() runs when the component is unloaded",
    ),
    row("post_export", Takes::Switch(false), "POST_EXPORT() runs when an instance is whole"),
    row("userspace", Takes::Switch(false), "a program of its own, with user_mainloop"),
    row("userinit", Takes::Switch(false), "userinit(argc, argv) runs first in the program"),
    row("extra_link_args", Takes::Text, "further words for the linker"),
    row("extra_compile_args", Takes::Text, "further words for the compiler"),
    row("homemod", Takes::Switch(false), "a homing module of motmod"),
    row("tpmod", Takes::Switch(false), "a planner module of motmod"),
    row("period", Takes::Switch(true), "no: functions have no period"),
    row("constructable", Takes::Switch(false), "instances can be made after loading"),
    row(
        "no_convenience_defines",
        Takes::Switch(false),
        "no macros for pins, FUNCTION and the like",
    ),
    row(
        "default_personality",
        Takes::Whole(i32::MIN as i128, i32::MAX as i128),
        "the personality of instances that are given none",
    ),
];

/// Values of the options that a file chose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    chosen: BTreeMap<&'static str, At<Value>>,
}

impl Options {
    /// Returns whether a switch is on.
    #[must_use]
    pub fn on(&self, name: &str) -> bool {
        let given = self.chosen.get(name).map(|v| v.value == Value::Truth(true));
        let default = OPTIONS.iter().any(|r| r.name == name && r.takes == Takes::Switch(true));
        given.unwrap_or(default)
    }

    /// Returns the integer that was given.
    #[must_use]
    pub fn whole(&self, name: &str) -> Option<i128> {
        match self.chosen.get(name).map(|v| &v.value) {
            Some(Value::Whole(n)) => Some(*n),
            _ => None,
        }
    }

    /// Returns the type or text that was given.
    #[must_use]
    pub fn word(&self, name: &str) -> Option<&str> {
        match self.chosen.get(name).map(|v| &v.value) {
            Some(Value::Name(t) | Value::Text(t)) => Some(t),
            _ => None,
        }
    }

    /// Returns the value of an option with its span.
    #[must_use]
    pub fn place(&self, name: &str) -> Option<&At<Value>> {
        self.chosen.get(name)
    }

    /// Ignores `option period no`, as LinuxCNC 2.9 does.
    pub(crate) fn keep_period(&mut self) {
        self.chosen.remove("period");
    }

    /// Applies an option line. Returns a warning, or the fault as an error.
    pub(crate) fn take(&mut self, line: &OptionLine, source: &str) -> Result<Option<Fault>, Fault> {
        let name = line.name.value.as_str();
        let Some(row) = OPTIONS.iter().find(|r| r.name == name) else {
            let near = OPTIONS.iter().map(|r| (strsim::osa_distance(r.name, name), r.name)).min();
            let near = near.filter(|(far, near)| far * 3 <= near.len()).map(|(_, near)| near);
            let problem = Problem::UnknownOption { name: name.into(), near };
            return Ok(Some(Fault { span: line.name.span, problem }));
        };
        let span = line.value.as_ref().map_or(line.name.span, |v| v.span);
        let wrong = |problem| Err(Fault { span, problem });
        let name = row.name;
        let value = match (row.takes, line.value.as_ref().map(|v| &v.value)) {
            (Takes::Switch(_), None) => Value::Truth(true),
            (Takes::Switch(_), Some(Value::Truth(t))) => Value::Truth(*t),
            (Takes::Switch(_), Some(Value::Whole(n @ (0 | 1)))) => Value::Truth(*n == 1),
            (Takes::Switch(_), _) => return wrong(Problem::OptionSwitch { name }),
            (Takes::Whole(least, most), Some(Value::Whole(n))) if least <= *n && *n <= most => {
                Value::Whole(*n)
            }
            (Takes::Whole(least, most), _) => {
                return wrong(Problem::OptionWhole { name, least, most });
            }
            (Takes::Type, Some(Value::Name(t))) => Value::Name(t.clone()),
            (Takes::Type, _) => return wrong(Problem::OptionType { name }),
            (Takes::Text, Some(Value::Text(t))) => Value::Text(t.clone()),
            (Takes::Text, _) => return wrong(Problem::OptionText { name }),
        };
        if let Some(first) = self.chosen.get(name) {
            let (line, _, _) = crate::place::place(source, first.span.start);
            return wrong(Problem::OptionTwice { name: name.into(), line });
        }
        self.chosen.insert(name, At { value, span });
        Ok(None)
    }
}
