//! Ends of moves.

use super::{Run, block::Block, codes::GGroup};
use crate::{
    axis::{Axis, Position},
    error::Problem,
};

impl Run<'_> {
    /// Returns the end of a move in program coordinates.
    pub(crate) fn target(&self, block: &Block) -> Result<Position, Problem> {
        let state = &*self.state;
        let mut end = self.programmed();
        if block.g(GGroup::Once) == Some(530) {
            if state.compensation.is_on() {
                return Err(Problem::CompMotion { what: "Cannot use g53 with cutter radius comp" });
            }
            if !state.modal.absolute {
                return Err(Problem::G53Incremental);
            }
            let mut machine = state.frame.machine(state.position);
            for axis in Axis::ALL {
                if let Some(v) = block.get(axis.letter() as u8) {
                    machine[axis] = self.unwrapped(axis, v, machine[axis])?;
                }
            }
            return Ok(state.frame.program(machine));
        }
        for axis in Axis::ALL {
            let Some(v) = block.get(axis.letter() as u8) else { continue };
            end[axis] = if state.modal.absolute {
                self.unwrapped(axis, v, end[axis])?
            } else {
                end[axis] + v
            };
        }
        if block.has_any(b"@^") {
            let at_origin = state.position.x == 0.0 && state.position.y == 0.0;
            if state.modal.absolute && at_origin && !block.has(b'^') {
                return Err(Problem::PolarNeedsAngle);
            }
            (end.x, end.y) = self.polar(block, self.state.position)?;
        }
        if !end.is_finite() {
            return Err(Problem::Infinite);
        }
        Ok(end)
    }

    /// Returns X and Y of the end that the polar words of a block give from this place.
    pub(crate) fn polar(&self, block: &Block, at: Position) -> Result<(f64, f64), Problem> {
        let (radius, angle) = (libm::hypot(at.x, at.y), libm::atan2(at.y, at.x));
        let (r, a) = (block.get(b'@'), block.get(b'^').map(f64::to_radians));
        let (r, a) = if self.state.modal.absolute {
            (r.unwrap_or(radius), a.unwrap_or(angle))
        } else if at.x == 0.0 && at.y == 0.0 {
            return Err(Problem::PolarAtOrigin);
        } else {
            (radius + r.unwrap_or(0.0), angle + a.unwrap_or(0.0))
        };
        Ok((r * libm::cos(a), r * libm::sin(a)))
    }

    /// Returns the position of a wrapped rotary axis: the sign of the word is the direction of the turn.
    fn unwrapped(&self, axis: Axis, word: f64, current: f64) -> Result<f64, Problem> {
        if !axis.is_rotary() || !self.state.settings.wrapped.has(axis) {
            return Ok(word);
        }
        if !(-360.0..=360.0).contains(&word) {
            return Err(Problem::WrappedRange { axis: axis.letter().to_ascii_uppercase() });
        }
        let turn = 360.0 * libm::floor(current / 360.0);
        let near = turn + libm::fabs(word);
        Ok(match word.is_sign_negative() {
            true if near > current => near - 360.0,
            false if near < current => near + 360.0,
            _ => near,
        })
    }
}
