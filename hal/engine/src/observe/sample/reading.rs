//! A sample in progress.

use crate::{observe::probe::Probe, observe::ring::Memory, serve::hold::Hold, sync::Arc};

/// A sample of a client.
#[derive(Debug)]
pub(crate) struct Sample {
    pub(super) client: u64,
    pub(super) probe: Arc<Probe>,
    pub(super) memory: Arc<Memory>,
    pub(super) bytes: usize,
    /// Number of samples that the reader had taken, and the time that the virtual clock has waited
    /// for it to take more.
    pub(super) hold: (u64, Hold),
    /// The reason why the sample has ended.
    pub(super) ended: Option<&'static str>,
}

impl Sample {
    /// Returns whether the ring has no room, and the reader has kept the virtual clock waiting for
    /// too long.
    pub(crate) fn is_unread(&mut self, too_long: impl Fn(&mut Hold) -> bool) -> bool {
        if self.probe.has_room() {
            return false;
        }
        let taken = self.memory.ring().taken();
        if self.hold.0 != taken {
            self.hold = (taken, Hold::NONE);
        }
        too_long(&mut self.hold.1)
    }
}
