//! Saved modal state: M70 to M73.

use crate::{
    canon::{PathMode, Plane, Unit},
    environment::Environment,
    error::Problem,
    interpret::{BlockError, Interpreter, Run, block::Block, codes::MGroup},
    question::Request,
    state::{Compensation, FeedMode, LevelKind, Modal, Saved},
};

impl Interpreter {
    /// Restores a saved state at the end of a subroutine.
    pub(crate) fn restore(
        &mut self,
        saved: &Saved,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let mut out = core::mem::take(&mut self.late);
        let result = Run::new(&mut self.state, env, &mut out).restore(saved);
        self.late = out;
        result.map_err(BlockError::from)
    }
}

impl Run<'_> {
    pub(crate) fn save_or_restore(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.m(MGroup::Save) else { return Ok(None) };
        let saved = Saved {
            modal: self.state.modal.clone(),
            offset: self.state.frame.tool,
            compensation: self.state.compensation.setting(),
        };
        let Some(level) = self.state.levels.last_mut() else { return Ok(None) };
        match code {
            70 => level.modal = Some(Box::new(saved)),
            71 => level.modal = None,
            72 => {
                let saved = level.modal.clone().ok_or(Problem::NothingSaved)?;
                self.restore(&saved)?;
            }
            _ => {
                if level.kind != LevelKind::Sub {
                    // The reference accepts M73 outside of a subroutine; nothing ends there.
                    return Ok(None);
                }
                level.modal = Some(Box::new(saved));
                level.restores = true;
            }
        }
        Ok(None)
    }

    /// Makes the modal state what it was, by the codes that differ.
    /// Restores the saved state by the codes that set it, in the order of the reference.
    fn restore(&mut self, saved: &Saved) -> Result<(), Problem> {
        let old = &saved.modal;
        let now = self.state.modal.clone();
        if self.state.compensation.is_on() && !saved.compensation.is_on() {
            // Units and planes do not change under compensation.
            self.code(b'g', 40.0)?;
        }
        if old.unit != now.unit {
            self.code(b'g', if old.unit == Unit::Inch { 20.0 } else { 21.0 })?;
        }
        self.restore_spindle_modes(old, &now)?;
        if old.feed_mode != now.feed_mode {
            let code = match old.feed_mode {
                FeedMode::InverseTime => 93.0,
                FeedMode::PerMinute => 94.0,
                FeedMode::PerRevolution => 95.0,
            };
            self.code(b'g', code)?;
        }
        if old.feed != now.feed && old.feed_mode != FeedMode::InverseTime {
            self.code(b'f', old.feed)?;
        }
        self.restore_spindles(old, &now)?;
        if old.plane != now.plane {
            self.code(b'g', plane(old.plane))?;
        }
        if saved.compensation.is_on() && !self.state.compensation.is_on() {
            let ended = self.state.compensation.ended;
            self.state.compensation = Compensation { ended, ..saved.compensation.clone() };
            self.note_compensation()?;
        }
        if old.tool_offset != now.tool_offset {
            self.set_tool_offset(saved.offset)?;
            self.state.modal.tool_offset = old.tool_offset;
        }
        let mut b = Block::default();
        let mut word = |letter: u8, value: f64| b.add(letter, 0, value, &[]);
        if old.absolute != now.absolute {
            word(b'g', if old.absolute { 90.0 } else { 91.0 })?;
        }
        if old.ijk_absolute != now.ijk_absolute {
            word(b'g', if old.ijk_absolute { 90.1 } else { 91.1 })?;
        }
        if old.retract_old != now.retract_old {
            word(b'g', if old.retract_old { 98.0 } else { 99.0 })?;
        }
        if old.diameter != now.diameter {
            word(b'g', if old.diameter { 7.0 } else { 8.0 })?;
        }
        if old.system != now.system {
            let system = f64::from(old.system);
            word(b'g', if system <= 6.0 { 53.0 + system } else { 59.0 + (system - 6.0) / 10.0 })?;
        }
        if (old.path, old.naive_tolerance) != (now.path, now.naive_tolerance) {
            match old.path {
                PathMode::ExactPath => word(b'g', 61.0)?,
                PathMode::ExactStop => word(b'g', 61.1)?,
                PathMode::Continuous { tolerance } => {
                    word(b'g', 64.0)?;
                    word(b'p', tolerance)?;
                    word(b'q', old.naive_tolerance)?;
                }
            }
        }
        self.execute(&mut b, 0)?;
        if old.mist != now.mist || old.flood != now.flood {
            self.restore_coolant(old)?;
        }
        self.restore_overrides(old, &now)
    }

    /// Runs a line of one word.
    fn code(&mut self, letter: u8, value: f64) -> Result<(), Problem> {
        let mut b = Block::default();
        b.add(letter, 0, value, &[])?;
        self.execute(&mut b, 0)?;
        Ok(())
    }

    fn restore_overrides(&mut self, old: &Modal, now: &Modal) -> Result<(), Problem> {
        if old.feed_override != now.feed_override {
            self.set_feed_override(old.feed_override)?;
        }
        for (n, (was, is)) in (0u8..).zip(old.spindles.iter().zip(&now.spindles)) {
            if was.speed_override != is.speed_override {
                self.set_speed_override(n, was.speed_override)?;
            }
        }
        if old.adaptive_feed != now.adaptive_feed {
            self.set_adaptive_feed(old.adaptive_feed)?;
        }
        if old.feed_hold != now.feed_hold {
            self.set_feed_hold(old.feed_hold)?;
        }
        Ok(())
    }

    fn restore_coolant(&mut self, old: &Modal) -> Result<(), Problem> {
        let mut codes = vec![9.0];
        codes.extend(old.mist.then_some(7.0));
        codes.extend(old.flood.then_some(8.0));
        for code in codes {
            let mut b = Block::default();
            b.add(b'm', 0, code, &[])?;
            self.execute(&mut b, 0)?;
        }
        Ok(())
    }

    /// Restores constant surface speed, or its end. Its speed follows with that of all spindles.
    fn restore_spindle_modes(&mut self, old: &Modal, now: &Modal) -> Result<(), Problem> {
        for (n, (was, is)) in (0u8..).zip(old.spindles.iter().zip(&now.spindles)) {
            if was.css != is.css {
                self.set_css(n, was.css, was.css_max)?;
            }
        }
        Ok(())
    }

    fn restore_spindles(&mut self, old: &Modal, now: &Modal) -> Result<(), Problem> {
        for (n, (was, is)) in (0u8..).zip(old.spindles.iter().zip(&now.spindles)) {
            if was.speed != is.speed || was.css != is.css {
                let mut b = Block::default();
                b.add(b's', 0, was.speed, &[])?;
                b.add(b'$', 0, f64::from(n), &[])?;
                self.execute(&mut b, 0)?;
            }
            if was.direction != is.direction {
                self.turn(n, was.direction)?;
            }
        }
        Ok(())
    }
}

fn plane(plane: Plane) -> f64 {
    match plane {
        Plane::Xy => 17.0,
        Plane::Xz => 18.0,
        Plane::Yz => 19.0,
        Plane::Uv => 17.1,
        Plane::Uw => 18.1,
        Plane::Vw => 19.1,
    }
}
