//! A recording's file and the probe that fills it: records are whole as soon as their look is over.

use super::file::WholeFile;
use crate::{os, probe::Probe, sync::Arc};
use hal_trace::{
    TimeBase,
    vcd::{Column, Writer},
};
use std::io::{Result, Write};

/// How long whole records wait for the file at the most, in nanoseconds, and how many bytes.
const LONGEST_WAIT_NS: i64 = 500_000_000;
const MOST_WAITING: usize = 1 << 16;

/// A recording under way.
#[derive(Debug)]
pub(crate) struct Tape {
    probe: Arc<Probe>,
    writer: Writer<WholeFile>,
    /// How often the probe had looked when its changes were last taken.
    looks: u64,
    /// When the file was last written.
    put_at: i64,
    /// Whether a write has failed: nothing is written after that.
    failed: bool,
}

impl Tape {
    /// Begins the file: what the columns are, and what each is at `now`.
    ///
    /// # Errors
    /// The columns cannot be written as VCD.
    pub(super) fn begin(
        file: WholeFile,
        columns: &[Column],
        probe: Arc<Probe>,
        now: i64,
    ) -> Result<Self> {
        let first: Vec<_> = probe.last().map(Some).collect();
        let mut writer = Writer::new(file, TimeBase::NANOSECONDS, columns, None)?;
        writer.all(now, &first)?;
        let failed = writer.out().flush().is_err();
        let (looks, put_at) = (probe.looks(), os::monotonic_ns());
        Ok(Self { probe, writer, looks, put_at, failed })
    }

    /// Whether a write has failed.
    pub(super) const fn has_failed(&self) -> bool {
        self.failed
    }

    /// Takes what has changed. `still`: no look is under way. Whole records reach the file now and
    /// then.
    pub(crate) fn drain(&mut self, still: bool) {
        // Every look whose changes were taken before, in part perhaps, is over.
        let over = still || self.probe.looks() > self.looks;
        let mut begun = false;
        while let Some((time, which, bits)) = self.probe.change() {
            if self.failed {
                continue;
            }
            if self.writer.at() != Some(time) {
                self.writer.out().end_record();
                begun = true;
            }
            // Into memory: that does not fail.
            let written = self.writer.time(time);
            drop(written.and_then(|()| self.writer.change(which as usize, Some(bits))));
        }
        if still || (over && !begun) {
            self.writer.out().end_record();
        }
        self.looks = self.probe.looks();
        let waiting = self.writer.out().waiting();
        let now = os::monotonic_ns();
        if waiting >= MOST_WAITING || (waiting > 0 && now - self.put_at >= LONGEST_WAIT_NS) {
            self.put_at = now;
            self.failed |= self.writer.out().put().is_err();
        }
    }

    /// Before the process crashes: what was seen is kept, and what is there now if no cycle is
    /// under way.
    pub(crate) fn salvage(&mut self, still: bool, now: i64) {
        if still {
            self.probe.look(now);
            self.end(now);
            return;
        }
        self.drain(false);
        self.failed |= self.writer.out().put().is_err();
    }

    /// Ends the recording at `now`: all of it is in the file.
    pub(crate) fn end(&mut self, now: i64) {
        self.drain(true);
        if self.failed {
            return;
        }
        if self.writer.at() < Some(now) {
            drop(self.writer.time(now));
        }
        self.failed |= self.writer.out().flush().is_err();
    }
}
