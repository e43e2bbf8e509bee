//! The begin and the end of a program in RS274-D: its start values, and those from before it.

use super::{NO_MOTION, NoFiles};
use crate::{
    canon::{Call, PathMode, Plane, Unit},
    error::Problem,
    interpret::{Interpreter, Run},
    state::{FeedMode, rs274d::Before},
};

impl Interpreter {
    /// Restores what a program in RS274-D has replaced, after a job that breaks off.
    pub fn leave_program(&mut self) {
        let mut out = Vec::new();
        let left = Run::new(&mut self.state, &NoFiles, &mut out).leave_rs274d();
        debug_assert!(left.is_ok(), "the calls are few");
        self.state.rs274d.before = None;
    }
}

impl Run<'_> {
    /// Sets the start values at the begin of a program: inches, absolute, exact path, no feed, no motion.
    pub(super) fn begin_rs274d(&mut self) -> Result<(), Problem> {
        if self.state.rs274d.before.is_some() {
            return Ok(());
        }
        self.flush_compensation();
        self.end_compensation();
        let frame = self.state.frame;
        let g92 = frame.g92.scaled(frame.unit.millimetres());
        let modal = &self.state.modal;
        self.state.rs274d.before = Some(Box::new(Before {
            g92,
            unit: modal.unit,
            path: modal.path,
            naive_tolerance: modal.naive_tolerance,
            absolute: modal.absolute,
            ijk_absolute: modal.ijk_absolute,
            diameter: modal.diameter,
        }));
        self.set_unit(Unit::Inch)?;
        let modal = &mut self.state.modal;
        modal.motion = NO_MOTION;
        (modal.absolute, modal.ijk_absolute, modal.diameter) = (true, false, false);
        (modal.feed_mode, modal.feed_spindle, modal.feed) = (FeedMode::PerMinute, 0, 0.0);
        modal.plane = Plane::Xy;
        self.emit(Call::SelectPlane(Plane::Xy))?;
        self.emit(Call::SetFeedMode { spindle: 0, per_revolution: false })?;
        self.set_path(PathMode::ExactPath, 0.0)
    }

    /// Restores the offset of G92, the unit, the path mode and the modes of distances (G90, G90.1, G7) that were in force
    /// before the program.
    pub(super) fn leave_rs274d(&mut self) -> Result<(), Problem> {
        let Some(before) = self.state.rs274d.before.clone() else { return Ok(()) };
        if self.state.modal.unit != before.unit {
            self.set_unit(before.unit)?;
        }
        let g92 = before.g92.scaled(1.0 / before.unit.millimetres());
        if g92 != self.state.frame.g92 {
            self.keep_g92(g92);
            self.set_g92(g92)?;
        }
        let modal = &mut self.state.modal;
        modal.absolute = before.absolute;
        (modal.ijk_absolute, modal.diameter) = (before.ijk_absolute, before.diameter);
        if modal.path != before.path {
            self.set_path(before.path, before.naive_tolerance)?;
        }
        Ok(())
    }
}
