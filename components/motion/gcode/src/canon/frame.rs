//! The frame of the canonical calls: from program coordinates to machine coordinates.

use serde::{Deserialize, Serialize};

use super::{Call, Unit};
use crate::axis::Position;

/// The offsets in force between program coordinates and the machine's, all in the same unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The unit of lengths.
    pub unit: Unit,
    /// The offset of the coordinate system.
    pub g5x: Position,
    /// The rotation of the coordinate system about Z, in degrees.
    pub rotation: f64,
    /// The offset of G92.
    pub g92: Position,
    /// The tool's offset.
    pub tool: Position,
}

impl Frame {
    /// Returns a frame without offsets.
    pub fn new(unit: Unit) -> Self {
        let zero = Position::default();
        Self { unit, g5x: zero, rotation: 0.0, g92: zero, tool: zero }
    }

    /// Returns machine coordinates, in the frame's unit, of a place in program coordinates.
    pub fn machine(&self, program: Position) -> Position {
        (program + self.g92).rotated(self.rotation) + self.g5x + self.tool
    }

    /// Returns program coordinates of a place in machine coordinates.
    pub fn program(&self, machine: Position) -> Position {
        (machine - self.tool - self.g5x).rotated(-self.rotation) - self.g92
    }

    /// Returns machine coordinates in millimetres and degrees of a place in program coordinates.
    pub fn machine_mm(&self, program: Position) -> Position {
        self.machine(program).scaled(self.unit.millimetres())
    }

    /// Returns the frame in another unit.
    #[must_use]
    pub fn in_unit(self, unit: Unit) -> Self {
        let k = self.unit.to(unit);
        Self {
            unit,
            g5x: self.g5x.scaled(k),
            rotation: self.rotation,
            g92: self.g92.scaled(k),
            tool: self.tool.scaled(k),
        }
    }

    /// Follows a call that changes the frame; other calls change nothing.
    pub fn apply(&mut self, call: &Call) {
        match call {
            Call::UseLengthUnits(unit) => *self = self.in_unit(*unit),
            Call::SetG5xOffset { offset, .. } => self.g5x = *offset,
            Call::SetXyRotation(degrees) => self.rotation = *degrees,
            Call::SetG92Offset(offset) => self.g92 = *offset,
            Call::UseToolLengthOffset(offset) => self.tool = *offset,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_the_machine_and_back_is_the_same_place() {
        let at = |x, y, z| Position { x, y, z, ..Position::default() };
        let mut frame = Frame::new(Unit::Inch);
        frame.apply(&Call::SetG5xOffset { system: 1, offset: at(1.0, 2.0, 3.0) });
        frame.apply(&Call::SetXyRotation(90.0));
        frame.apply(&Call::SetG92Offset(at(0.5, 0.0, 0.0)));
        frame.apply(&Call::UseToolLengthOffset(at(0.0, 0.0, 4.0)));
        let machine = frame.machine(at(1.0, 0.0, 0.0));
        assert!((machine - at(1.0, 3.5, 7.0)).map(|_, v| v.abs()).x < 1e-12);
        assert!((frame.program(machine).x - 1.0).abs() < 1e-12);
        frame.apply(&Call::UseLengthUnits(Unit::Millimetre));
        let mm = frame.machine_mm(at(25.4, 0.0, 0.0));
        assert!((mm.y - 3.5 * 25.4).abs() < 1e-9 && (mm.z - 7.0 * 25.4).abs() < 1e-9);
    }
}
