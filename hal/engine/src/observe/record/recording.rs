//! A recording in progress.

use super::tape::Tape;
use crate::{observe::probe::Probe, sync::Arc};
use hal_output::Growing;
use hal_protocol::Patterns;
use std::sync::Mutex;

/// Recording in progress.
#[derive(Debug)]
pub(crate) struct Recording {
    pub(super) path: String,
    pub(super) patterns: Patterns,
    /// Device or pipe, until time first moves. A regular file is created only then.
    pub(super) file: Option<Growing>,
    /// None until time first moves, when the recorded values are determined.
    pub(super) tape: Option<Arc<Mutex<Tape>>>,
    /// Probe and its number.
    pub(super) probe: Option<(u64, Arc<Probe>)>,
}

impl Recording {
    /// Returns the path of the file.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// Returns whether the recorded values are not yet determined.
    pub(crate) const fn is_waiting(&self) -> bool {
        self.tape.is_none()
    }

    /// Returns the number of changes lost because the queue was full.
    pub(crate) fn lost(&self) -> u64 {
        self.probe.as_ref().map_or(0, |(_, p)| p.lost())
    }
}
