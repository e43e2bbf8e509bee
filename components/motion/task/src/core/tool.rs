//! The tool in the spindle: written to disk before it is believed.

use super::{Core, Waiting};
use crate::convert::Action;
use crate::outside::{Level, Outside};
use hal_component::IoRequest;
use hal_gcode::Interpreter;
use hal_job::{
    Machine,
    spindle::{Spindle, UNKNOWN},
};

/// The tool in the spindle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// The record on disk.
    pub(crate) record: Spindle,
    /// The tool that iocontrol stated last.
    seen: i32,
}

impl Held {
    /// Returns the tool that the machine's record names, and passes it to the interpreter.
    pub(super) fn new(machine: &Machine, interpreter: &mut Interpreter) -> Self {
        let record = machine.spindle;
        interpreter.state.tool = machine.tools.find(record.tool()).cloned().unwrap_or_default();
        Self { record, seen: 0 }
    }
}

impl Core {
    /// Returns whether the job waits for a tool, and its number.
    pub(crate) fn awaited_tool(&self) -> Option<i32> {
        match (&self.waiting, self.queue.front().map(|entry| &entry.action)) {
            _ if !self.flight.is_empty() => None,
            (Some(Waiting::Change { tool, .. }), _) => Some(*tool),
            // The change waits until its tool is prepared.
            (None, Some(Action::Change(tool))) if self.preparing.is_some() => Some(*tool),
            _ => None,
        }
    }

    /// Returns the reason why no program can begin, if it is unknown which tool is in the spindle.
    pub(super) fn needs_known_tool(&self) -> Result<(), String> {
        let what = match self.held.record {
            Spindle::Holds(UNKNOWN) => "the tool in the spindle is unknown".to_owned(),
            Spindle::Changing { from: UNKNOWN, to } => {
                format!("the change to tool {to} was interrupted")
            }
            Spindle::Changing { from, to } => {
                format!("the change from tool {from} to tool {to} was interrupted")
            }
            Spindle::Holds(_) => return Ok(()),
        };
        Err(format!(
            "{what}: in mode mdi, task.mdi text='M61 Q…' says which one is in the spindle, Q0 none"
        ))
    }

    /// Writes that a tool change begins, and then asks iocontrol for it.
    pub(super) fn begin_change(
        &mut self,
        tool: i32,
        out: &mut impl Outside,
    ) -> Result<bool, String> {
        self.record(self.held.record.asked(tool), out)?;
        let Some(id) = out.request(IoRequest::Change) else { return Ok(false) };
        self.waiting = Some(Waiting::Change { id, tool });
        Ok(true)
    }

    /// Follows the end of a change. A change to another tool stays open: a person must say which tool is there.
    pub(super) fn changed_tool(&mut self, tool: i32, out: &mut impl Outside) -> Result<(), String> {
        let is = out.io().tool;
        let Some(record) = Spindle::changed(tool, is) else {
            self.held.seen = is;
            return Err(format!("the changer was asked for tool {tool} and states tool {is}"));
        };
        if self.world.machine.settings.random_changer {
            self.swap_pockets(tool, out)?;
        }
        self.record(record, out)
    }

    /// Writes the tool that the operator states.
    pub(super) fn take_tool(&mut self, tool: i32, out: &mut impl Outside) -> Result<(), String> {
        if self.world.machine.settings.random_changer {
            self.swap_pockets(tool, out)?;
        }
        self.record(Spindle::Holds(tool), out)
    }

    /// Follows a tool that a command to iocontrol has changed or stated.
    pub(super) fn watch_tool(&mut self, out: &mut impl Outside) {
        let tool = out.io().tool;
        let before = core::mem::replace(&mut self.held.seen, tool);
        let is_own = matches!(self.waiting, Some(Waiting::Change { .. }));
        if tool == before || is_own || tool == self.held.record.tool() {
            return;
        }
        if let Err(why) = self.record(Spindle::Holds(tool), out) {
            self.tell(Level::Error, &why, out);
        }
        if self.job.is_none() {
            let tools = &self.world.machine.tools;
            self.interpreter.state.tool = tools.find(tool).cloned().unwrap_or_default();
        }
    }

    fn record(&mut self, now: Spindle, out: &mut impl Outside) -> Result<(), String> {
        if now != self.held.record {
            out.save_spindle(self.held.record, now)?;
            self.held.record = now;
        }
        Ok(())
    }

    /// Exchanges the pockets of the tool in the spindle, which is pocket 0, and of the tool that comes into it.
    fn swap_pockets(&mut self, tool: i32, out: &mut impl Outside) -> Result<(), String> {
        let tools = &self.world.machine.tools;
        let Some(pocket) = tools.find(tool).map(|t| t.pocket).filter(|p| *p != 0) else {
            return Ok(());
        };
        self.world.machine.check_table()?;
        let tools = &mut self.world.machine.tools;
        for entry in &mut tools.tools {
            if entry.pocket == 0 {
                entry.pocket = pocket;
            } else if entry.number == tool {
                entry.pocket = 0;
            }
        }
        self.save_tools(out)
    }

    /// Writes the tool table.
    pub(super) fn save_tools(&mut self, out: &mut impl Outside) -> Result<(), String> {
        out.save_tools(&self.world.machine.tools)?;
        self.world.machine.note_table();
        Ok(())
    }
}
