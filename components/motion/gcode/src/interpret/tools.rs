//! Tool selection, tool change and tool offsets.

use super::{
    Run,
    block::Block,
    codes::{GGroup, MGroup},
};
use crate::{
    axis::{Axis, Position},
    canon::{Call, Direction},
    error::Problem,
    question::Request,
    tool::Tool,
};

/// Returns the words of the axes of a block.
fn words(b: &Block) -> Position {
    Position::default().map(|axis, _| b.get(axis.letter() as u8).unwrap_or(0.0))
}

impl Run<'_> {
    /// Returns a tool with what G10 changed.
    pub(crate) fn tool(&self, number: i32) -> Result<Tool, Problem> {
        if number == 0 {
            return Ok(Tool::default());
        }
        let changed = self.state.changed_tools.get(&number).cloned();
        let tool = changed.or_else(|| self.env.tool(number));
        tool.ok_or(Problem::ToolMissing { tool: number })
    }

    /// Returns the factor from the tool table's unit to the program's.
    pub(crate) fn table_scale(&self) -> f64 {
        self.state.settings.unit.to(self.state.frame.unit)
    }

    pub(super) fn select_tool(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(number) = b.integer(b't')? else { return Ok(None) };
        if number < 0 {
            return Err(Problem::NegativeTool);
        }
        self.tool(number)?;
        self.state.selected = Some(number);
        self.emit(Call::SelectTool(number))?;
        Ok(None)
    }

    pub(super) fn change_tool(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        match b.m(MGroup::Tool) {
            Some(6) => {
                let number = self.state.selected.ok_or(Problem::NoToolSelected)?;
                if self.state.compensation.is_on() {
                    return Err(Problem::CompMotion {
                        what: "Cannot change tools with cutter radius compensation on",
                    });
                }
                let tool = self.tool(number)?;
                self.emit(Call::StartChange)?;
                for spindle in 0..u8::try_from(self.state.modal.spindles.len()).unwrap_or(0) {
                    self.turn(spindle, Direction::Stopped)?;
                }
                self.emit(Call::ChangeTool(number))?;
                let old = core::mem::replace(&mut self.state.tool, tool);
                if self.state.settings.random_changer {
                    self.swap_pockets(old);
                }
                Ok(Some(Request::ToolChange { tool: number }))
            }
            Some(_) => {
                let number = b.integer(b'q')?.filter(|q| *q >= 0).ok_or(Problem::M61NeedsQ)?;
                self.state.tool = self.tool(number)?;
                self.emit(Call::ChangeToolNumber(number))?;
                Ok(None)
            }
            None => Ok(None),
        }
    }

    /// Puts the old tool into the pocket that the new one came from. Pocket 0 is the spindle.
    pub(super) fn swap_pockets(&mut self, mut old: Tool) {
        let new = &mut self.state.tool;
        if new.number == old.number {
            new.pocket = 0;
            return;
        }
        old.pocket = new.pocket;
        new.pocket = 0;
        for tool in [new.clone(), old] {
            if tool.number != 0 {
                self.state.changed_tools.insert(tool.number, tool);
            }
        }
    }

    pub(super) fn tool_offset(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.g(GGroup::ToolOffset) else { return Ok(None) };
        if self.state.compensation.is_on() && code != 490 {
            return Err(Problem::OffsetWithComp { what: "Cannot change tool offset" });
        }
        let k = self.table_scale();
        let old = self.state.frame.tool;
        let new = match code {
            490 => Position::default(),
            430 | 432 => {
                let tool = match b.integer(b'h')? {
                    None if code == 432 && !b.has_axes() => {
                        return Err(Problem::OffsetWordsMissing);
                    }
                    None if code == 432 => {
                        Tool { offset: words(b).scaled(1.0 / k), ..Tool::default() }
                    }
                    Some(_) if code == 432 && b.has_axes() => {
                        return Err(Problem::OffsetWordsBoth);
                    }
                    Some(h) if h < 0 => return Err(Problem::ToolMissing { tool: h }),
                    None | Some(0) => self.state.tool.clone(),
                    Some(h) => self.tool(h)?,
                };
                let offset = tool.offset.scaled(k);
                if code == 432 { old + offset } else { offset }
            }
            _ => {
                let mut new = old;
                for axis in Axis::ALL {
                    if let Some(v) = b.get(axis.letter() as u8) {
                        new[axis] = v;
                    }
                }
                new
            }
        };
        self.set_tool_offset(new)?;
        self.state.modal.tool_offset = code != 490;
        Ok(None)
    }

    pub(crate) fn set_tool_offset(&mut self, new: Position) -> Result<(), Problem> {
        let machine = self.state.frame.machine(self.state.position);
        self.state.frame.tool = new;
        self.state.position = self.state.frame.program(machine);
        self.emit(Call::UseToolLengthOffset(new))
    }

    /// Runs G10 L1, L10 and L11.
    pub(super) fn set_tool(&mut self, b: &Block, l: i32) -> Result<(), Problem> {
        let number = b.integer(b'p')?.ok_or(Problem::G10NeedsTool)?;
        let mut tool = match number {
            n if n <= 0 => return Err(Problem::G10ToolRange),
            n => self.tool(n)?,
        };
        let k = 1.0 / self.table_scale();
        let at = self.state.position + self.state.frame.tool;
        for axis in Axis::ALL {
            let Some(word) = b.get(axis.letter() as u8) else { continue };
            let scale = if axis.is_rotary() { 1.0 } else { k };
            tool.offset[axis] = scale
                * match l {
                    1 => word,
                    10 => at[axis] - word,
                    _ => self.fixture(axis) - word,
                };
        }
        if let Some(r) = b.get(b'r') {
            tool.diameter = 2.0 * r * k;
        }
        if let Some(i) = b.get(b'i') {
            tool.front = i;
        }
        if let Some(j) = b.get(b'j') {
            tool.back = j;
        }
        if let Some(q) = b.integer(b'q')? {
            tool.orientation =
                u8::try_from(q).ok().filter(|q| *q <= 9).ok_or(Problem::G10Orientation)?;
        }
        self.emit(Call::SetToolTableEntry {
            pocket: u32::try_from(tool.pocket).unwrap_or(0),
            tool: number,
            offset: tool.offset,
            diameter: tool.diameter,
            front: tool.front,
            back: tool.back,
            orientation: tool.orientation,
        })?;
        if self.state.tool.number == number {
            self.state.tool = tool.clone();
        }
        self.state.changed_tools.insert(number, tool);
        Ok(())
    }

    /// Returns the machine's place of an axis as G59.3 shows it, without rotation.
    fn fixture(&self, axis: Axis) -> f64 {
        let frame = &self.state.frame;
        let k = self.table_scale();
        let fixture = self.stored_offset(9).0.scaled(k);
        frame.machine(self.state.position)[axis] - fixture[axis]
    }
}
