//! Readers of values after a cycle: samples for programs, the recording and the flight recorder,
//! with their probes.
//!
//! Only the files of this room see the fields.

use crate::{
    observe::flight::Flight, observe::probes::Probes, observe::record::Recording,
    observe::sample::Sample, serve::hold::Hold, sync::Arc,
};
use hal_protocol::{StatusInfo, StoppedRecording};
use std::{collections::BTreeMap, sync::Mutex};

/// Samples, recording and flight recorder of an instance.
#[derive(Debug, Default)]
pub(crate) struct Observers {
    pub(in crate::observe) probes: Probes,
    pub(in crate::observe) recording: Option<Recording>,
    /// The latest recording, if it could not be written and another `record` has not come yet.
    pub(in crate::observe) stopped_recording: Option<StoppedRecording>,
    /// True if a recording, or the file of an event, could not be written whole.
    pub(in crate::observe) unwritten: bool,
    pub(in crate::observe) flight: Option<Arc<Mutex<Flight>>>,
    /// The samples, by the numbers of their probes.
    pub(in crate::observe) samples: BTreeMap<u64, Sample>,
}

impl Observers {
    /// Returns the probes.
    pub(crate) const fn probes(&self) -> &Probes {
        &self.probes
    }

    /// Lets the virtual clock move even if this probe has no room.
    pub(crate) fn lose(&mut self, probe: u64) {
        self.probes.lose(probe);
    }

    /// Returns whether a recording is in progress.
    pub(crate) const fn is_recording(&self) -> bool {
        self.recording.is_some()
    }

    /// Returns whether a recording waits for time to move.
    pub(crate) fn recording_waits(&self) -> bool {
        self.recording.as_ref().is_some_and(Recording::is_waiting)
    }

    /// Returns whether the flight recorder is on.
    pub(crate) const fn is_flight_on(&self) -> bool {
        self.flight.is_some()
    }

    /// Returns whether a recording, or the file of an event, could not be written whole.
    pub(crate) const fn is_unwritten(&self) -> bool {
        self.unwritten
    }

    /// Completes the answer to `status`.
    pub(crate) fn fill(&self, status: &mut StatusInfo) {
        status.recording = self.recording.as_ref().map(|r| (r.path().to_owned(), r.lost()));
        status.recording_stopped.clone_from(&self.stopped_recording);
    }

    /// Returns the samples without room whose reader has kept the virtual clock waiting for too
    /// long.
    pub(crate) fn unread_samples(&mut self, too_long: impl Fn(&mut Hold) -> bool) -> Vec<u64> {
        let mut unread = Vec::new();
        for (id, sample) in &mut self.samples {
            if self.probes.is_lossless(*id) && sample.is_unread(&too_long) {
                unread.push(*id);
            }
        }
        unread
    }
}
