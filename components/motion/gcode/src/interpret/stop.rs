//! Pauses and the end of a program.

use super::{Run, block::Block, codes::MGroup};
use crate::{
    canon::{Call, Direction, Plane},
    error::Problem,
    question::Request,
    state::FeedMode,
};

impl Run<'_> {
    pub(super) fn stop(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        // A pause on a compensated path waits for the next move, which decides where the tool pauses.
        match b.m(MGroup::Stop) {
            None => {}
            Some(0) => self.emit(Call::ProgramStop)?,
            Some(1) => self.emit(Call::OptionalProgramStop)?,
            Some(60) => {
                self.emit(Call::PalletShuttle)?;
                self.emit(Call::ProgramStop)?;
            }
            Some(code) => self.end(code == 30)?,
        }
        Ok(None)
    }

    /// Ends the program and sets the modal state that a new one begins with.
    pub(crate) fn end(&mut self, pallet: bool) -> Result<(), Problem> {
        self.flush_compensation();
        self.end_compensation();
        let machine = self.state.frame.machine(self.state.position);
        let k = self.table_scale();
        let (offset, rotation) = self.stored_offset(1);
        self.state.modal.system = 1;
        self.state.numbered.put(crate::parameters::number::SYSTEM, 1.0);
        self.state.frame.g5x = offset.scaled(k);
        self.state.frame.rotation = rotation;
        self.state.position = self.state.frame.program(machine);
        let offset = self.state.frame.g5x;
        self.emit(Call::SetG5xOffset { system: 1, offset })?;
        self.emit(Call::SetXyRotation(rotation))?;
        if self.state.modal.plane != Plane::Xy {
            self.state.modal.plane = Plane::Xy;
            self.emit(Call::SelectPlane(Plane::Xy))?;
        }
        self.state.modal.absolute = true;
        self.state.modal.feed_mode = FeedMode::PerMinute;
        self.state.modal.feed_spindle = 0;
        self.state.modal.feed = 0.0;
        self.emit(Call::SetFeedMode { spindle: 0, per_revolution: false })?;
        self.emit(Call::SetFeedRate(0.0))?;
        if !self.state.modal.feed_override {
            self.set_feed_override(true)?;
        }
        let spindles = u8::try_from(self.state.modal.spindles.len()).unwrap_or(0);
        for spindle in 0..spindles {
            self.turn(spindle, Direction::Stopped)?;
            self.emit(Call::SetSpindleMode { spindle, css_max: 0.0 })?;
            if let Some(s) = self.state.modal.spindles.get_mut(usize::from(spindle)) {
                (s.css, s.css_max) = (false, 0.0);
            }
        }
        if self.state.modal.mist {
            self.state.modal.mist = false;
            self.emit(Call::Mist(false))?;
        }
        if self.state.modal.flood {
            self.state.modal.flood = false;
            self.emit(Call::Flood(false))?;
        }
        self.state.modal.motion = 10;
        if pallet {
            self.emit(Call::PalletShuttle)?;
        }
        self.emit(Call::ProgramEnd)?;
        self.state.ended = true;
        Ok(())
    }
}
