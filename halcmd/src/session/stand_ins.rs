//! Stand-ins of a machine, made and set by its session.

use super::{Error, Session};
use hal_protocol::At;
use std::collections::BTreeSet;

impl Session<'_> {
    /// Makes the pins of the stand-ins, and says so.
    pub(crate) fn begin_stand_ins(&mut self, place: &At) -> Result<(), Error> {
        if let Some(request) = self.stand_ins.load() {
            self.ask(request)?;
        }
        self.stand_at(&place.file, place.line);
        let notes = self.stand_ins.notes();
        notes.iter().for_each(|note| self.warn_at(note));
        Ok(())
    }

    /// Gives the stand-ins of a script their values, before its threads run. A machine's start does it elsewhere.
    pub(super) fn settle_script(&mut self) -> Result<(), Error> {
        let is_script = !self.is_machine && !self.is_dry_run();
        if is_script && !self.stand_ins.is_empty() {
            self.settle_stand_ins(true)?;
        }
        Ok(())
    }

    /// Gives the stand-ins the values of a machine at rest; `last` when all lines are executed. Returns the joints that
    /// are homed where they stand.
    pub(crate) fn settle_stand_ins(&mut self, last: bool) -> Result<BTreeSet<u32>, Error> {
        self.stand_ins.settle(self.link, last)
    }
}
