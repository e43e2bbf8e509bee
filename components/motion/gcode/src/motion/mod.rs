//! Moves: straight, arcs, cycles, compensation, splines, probing, threads.

pub mod arc;
mod comp_arc;
mod comp_line;
pub mod compensation;
mod corner;
pub mod cycle;
mod drill;
pub(crate) mod geometry;
mod probe;
pub mod profile;
pub mod spline;
mod straight;
mod thread;

use crate::{
    error::Problem,
    interpret::{Run, block::Block, codes::shown},
    question::Request,
};

impl Run<'_> {
    /// Runs the motion of a block.
    pub(crate) fn motion(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.motion else { return Ok(None) };
        self.close_curves(code)?;
        let mut request = None;
        match code {
            0 => self.straight(b, true)?,
            10 => self.straight(b, false)?,
            20 => self.arc(b, true)?,
            30 => self.arc(b, false)?,
            50 => self.cubic(b)?,
            51 => self.quadratic(b)?,
            52 => self.nurbs_point(b)?,
            53 => self.nurbs_end()?,
            330 => self.thread_pass(b)?,
            331 => self.rigid_tap(b)?,
            382..=385 => request = Some(self.probe(b, code)?),
            // The interpreter runs these, because it has the lines of their subroutine.
            700..=722 => {}
            760 => self.thread_cycle(b)?,
            800 => {
                self.state.cycle.active = None;
                self.note("motion mode set to none")?;
            }
            _ => self.cycle(b, code)?,
        }
        // A profile leaves the modal motion as it was.
        if !(700..=722).contains(&code) {
            self.state.modal.motion = if code == 53 { 800 } else { code };
        }
        Ok(request)
    }

    /// Refuses a code that compensation cannot follow.
    pub(crate) fn without_compensation(&self, code: u16) -> Result<(), Problem> {
        if self.state.compensation.is_on() {
            return Err(Problem::CompWith { code: shown(code) });
        }
        Ok(())
    }
}
