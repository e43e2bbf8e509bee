//! Canonical calls as calls of a Python object. Lengths are in inches there, whatever the unit of the program.

use super::{
    line::{LineCode, plane_number},
    preview::Preview,
};
use hal_gcode::{
    Call, State,
    axis::{Axis, AxisMask, Position},
    canon::{ControlPoint, Plane, Unit, curve_point},
    state::FeedMode,
    tool::{Tool, ToolTable},
};
use hal_job::Machine;
use pyo3::{call::PyCallArgs, prelude::*, types::PyTuple};

/// Number of straight pieces for each control point of a curve.
const PIECES_PER_POINT: usize = 16;
/// The most straight pieces of a curve.
const MAX_PIECES: usize = 100_000;
/// The most tools that the object is asked for.
const MAX_TOOLS: i32 = 1000;
/// Number of the first program of users, M100.
const FIRST_USER_CODE: u16 = 100;

/// An object that takes canonical calls. Methods that it does not have are left out.
pub(super) struct Canon<'py> {
    object: Bound<'py, PyAny>,
    /// Unit of the program.
    unit: Unit,
    /// Feed is a time instead of a length.
    inverse_time: bool,
    /// Place of the last move, in the program's unit.
    at: Position,
    /// The program has said that it ends.
    pub(super) ended: bool,
}

/// A row of a tool table: number, nine offsets, diameter, front and back angle, orientation.
type ToolRow = (i32, f64, f64, f64, f64, f64, f64, f64, f64, f64, f64, f64);

impl<'py> Canon<'py> {
    pub(super) fn new(object: Bound<'py, PyAny>) -> PyResult<Self> {
        let (unit, at) = (Unit::Inch, Position::default());
        Ok(Self { object, unit, inverse_time: false, at, ended: false })
    }

    /// Returns an attribute; `None` if the object has none of this name.
    pub(super) fn attribute<T>(&self, name: &str) -> PyResult<Option<T>>
    where
        T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
    {
        match self.object.getattr_opt(name)? {
            Some(value) if !value.is_none() => value.extract().map(Some),
            _ => Ok(None),
        }
    }

    /// Returns the result of a method without arguments; `None` without such a method.
    fn answer<T>(&self, name: &str) -> PyResult<Option<T>>
    where
        T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
    {
        match self.object.getattr_opt(name)? {
            Some(method) => method.call0()?.extract().map(Some),
            None => Ok(None),
        }
    }

    fn tell(&self, name: &str, args: impl PyCallArgs<'py>) -> PyResult<()> {
        match self.object.getattr_opt(name)? {
            Some(method) => method.call1(args).map(drop),
            None => Ok(()),
        }
    }

    /// Tells whether the object wants no more calls.
    pub(super) fn is_aborted(&self) -> PyResult<bool> {
        match self.object.getattr_opt("check_abort")? {
            Some(method) => method.call0()?.is_truthy(),
            None => Ok(false),
        }
    }

    /// Changes a machine's settings to those of the object.
    pub(super) fn apply_settings(&mut self, machine: &mut Machine) -> PyResult<()> {
        if let Some(units) = self.answer::<f64>("get_external_length_units")? {
            // Units per millimetre.
            let unit = if units < 0.5 { Unit::Inch } else { Unit::Millimetre };
            machine.settings.unit = unit;
            machine.settings.program_unit = unit;
        }
        if let Some(mask) = self.answer::<u16>("get_axis_mask")? {
            machine.settings.axes = AxisMask(mask);
        }
        if let Some(method) = self.object.getattr_opt("get_block_delete")? {
            machine.settings.block_delete = method.call0()?.is_truthy()?;
        }
        self.unit = machine.settings.program_unit;
        Ok(())
    }

    /// Replaces a tool table by that of the object, and returns the tool in the spindle.
    pub(super) fn tools(&self, table: &mut ToolTable) -> PyResult<Option<Tool>> {
        let Some(method) = self.object.getattr_opt("get_tool")? else { return Ok(None) };
        let mut in_spindle = None;
        let mut tools: Vec<Tool> = Vec::new();
        for index in 0..MAX_TOOLS {
            let row = method.call1((index,))?;
            let row = row.cast_into::<PyTuple>()?;
            let angle = |i: usize| row.get_item(i)?.extract::<f64>();
            let (number, x, y, z, a, b, c, u, v, w, diameter, front): ToolRow =
                row.get_slice(0, 12).extract()?;
            let (back, orientation) = (angle(12)?, row.get_item(13)?.extract().unwrap_or(0));
            if number < 0 && index > 0 {
                break;
            }
            let tool = Tool {
                number,
                pocket: index,
                offset: Position { x, y, z, a, b, c, u, v, w },
                diameter,
                front,
                back,
                orientation,
                remark: Box::default(),
            };
            if index == 0 {
                in_spindle = (number > 0).then_some(tool);
            } else if tools.iter().all(|t| t.number != number) {
                tools.push(tool);
            } else {
                break;
            }
        }
        if !tools.is_empty() {
            table.tools = tools;
        }
        Ok(in_spindle)
    }

    /// Begins a line.
    pub(super) fn next_line(&mut self, py: Python<'py>, state: &State, line: u32) -> PyResult<()> {
        self.inverse_time = state.modal.feed_mode == FeedMode::InverseTime;
        if self.object.hasattr("next_line")? {
            self.tell("next_line", (Py::new(py, LineCode::of(state, line))?,))?;
        }
        Ok(())
    }

    /// Returns the coordinates of a place in inches and degrees.
    fn inches(&self, place: Position) -> [f64; 9] {
        let scaled = place.scaled(self.unit.to(Unit::Inch));
        Axis::ALL.map(|axis| scaled[axis])
    }

    /// Tells a place.
    fn place(&self, name: &str, place: Position) -> PyResult<()> {
        let [x, y, z, a, b, c, u, v, w] = self.inches(place);
        self.tell(name, (x, y, z, a, b, c, u, v, w))
    }

    /// Tells a canonical call.
    pub(super) fn call(&mut self, call: &Call, world: &Preview) -> PyResult<()> {
        let before = self.at;
        match call {
            Call::StraightTraverse(end)
            | Call::StraightFeed(end)
            | Call::StraightProbe { end, .. }
            | Call::ArcFeed { end, .. }
            | Call::NurbsFeed { end, .. } => self.at = *end,
            _ => {}
        }
        match call {
            Call::UseLengthUnits(unit) => {
                self.at = self.at.scaled(self.unit.to(*unit));
                self.unit = *unit;
                Ok(())
            }
            Call::SelectPlane(plane) => self.tell("set_plane", (plane_number(*plane),)),
            Call::SetG5xOffset { system, offset } => {
                let [x, y, z, a, b, c, u, v, w] = self.inches(*offset);
                self.tell("set_g5x_offset", (*system, x, y, z, a, b, c, u, v, w))
            }
            Call::SetG92Offset(offset) => self.place("set_g92_offset", *offset),
            Call::SetXyRotation(degrees) => self.tell("set_xy_rotation", (*degrees,)),
            Call::UseToolLengthOffset(offset) => self.place("tool_offset", *offset),
            Call::StraightTraverse(end) => self.place("straight_traverse", *end),
            Call::StraightFeed(end) => self.place("straight_feed", *end),
            Call::StraightProbe { end, .. } => self.place("straight_probe", *end),
            Call::ArcFeed { plane, end, centre_first, centre_second, turns } => {
                self.arc(*plane, *end, (*centre_first, *centre_second), *turns)
            }
            Call::NurbsFeed { order, points, end } => self.curve(*order, points, before, *end),
            Call::RigidTap { end, .. } => {
                let [x, y, z, ..] = self.inches(*end);
                self.tell("rigid_tap", (x, y, z))
            }
            Call::SetFeedRate(feed) => {
                let k = if self.inverse_time { 1.0 } else { self.unit.to(Unit::Inch) };
                self.tell("set_feed_rate", (*feed * k,))
            }
            Call::SetSpindleSpeed { speed, .. } => self.tell("set_spindle_rate", (*speed,)),
            Call::Dwell(seconds) => self.tell("dwell", (*seconds,)),
            Call::ChangeTool(tool) | Call::ChangeToolNumber(tool) => {
                let place = world.tools().tools.iter().position(|t| t.number == *tool);
                self.tell("change_tool", (place.map_or(0, |i| i + 1),))
            }
            Call::UserCode { code, p, q } => {
                self.tell("user_defined_function", (code.saturating_sub(FIRST_USER_CODE), *p, *q))
            }
            Call::Message(text) => self.tell("message", (&**text,)),
            Call::Comment(text) => self.tell("comment", (&**text,)),
            Call::ProgramEnd | Call::Finish => {
                self.ended = true;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn arc(&self, plane: Plane, end: Position, centre: (f64, f64), turns: i32) -> PyResult<()> {
        let k = self.unit.to(Unit::Inch);
        let (first, second, across) = plane.axes();
        let to = end.scaled(k);
        let [_, _, _, a, b, c, u, v, w] = self.inches(end);
        let (x1, y1, z1) = (to[first], to[second], to[across]);
        self.tell("arc_feed", (x1, y1, centre.0 * k, centre.1 * k, turns, z1, a, b, c, u, v, w))
    }

    /// Tells a curve as straight pieces.
    fn curve(
        &self,
        order: u32,
        points: &[ControlPoint],
        start: Position,
        end: Position,
    ) -> PyResult<()> {
        let pieces = points.len().saturating_mul(PIECES_PER_POINT).min(MAX_PIECES);
        for i in 1..pieces {
            #[expect(clippy::cast_precision_loss, reason = "at most MAX_PIECES")]
            let share = i as f64 / pieces as f64;
            if let Some((x, y)) = curve_point(order, points, share) {
                self.place("straight_feed", Position { x, y, ..start })?;
            }
        }
        self.place("straight_feed", end)
    }
}
