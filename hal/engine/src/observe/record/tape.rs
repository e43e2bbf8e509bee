//! A recording's file and the probe that fills it. A record is whole once its sample is over.

use super::file::WholeFile;
use crate::{observe::probe::Probe, os, sync::Arc};
use hal_protocol::StoppedRecording;
use hal_trace::{
    TimeBase,
    vcd::{Column, Writer},
};
use std::io::Result;

/// Longest time in nanoseconds, and largest number of bytes, for which whole records wait to be
/// written.
const MAX_WAIT_NS: i64 = 500_000_000;
const MAX_WAITING: usize = 1 << 16;

/// Recording in progress.
#[derive(Debug)]
pub(crate) struct Tape {
    path: String,
    probe: Arc<Probe>,
    writer: Writer<WholeFile>,
    /// Number of samples of the probe when its changes were last read.
    looks: u64,
    /// Time of the last write, on the monotonic clock in nanoseconds.
    put_at: i64,
    /// Reason and time of a refused write. Nothing is written after that.
    failure: Option<(Box<str>, i64)>,
    /// True once the file is complete.
    is_over: bool,
}

impl Tape {
    /// Begins the file with the declarations of the columns and their values at `now`.
    ///
    /// # Errors
    /// The columns cannot be written as VCD.
    pub(super) fn begin(
        path: &str,
        file: WholeFile,
        columns: &[Column],
        probe: Arc<Probe>,
        now: i64,
    ) -> Result<Self> {
        let first: Vec<_> = probe.last().map(Some).collect();
        let mut writer = Writer::new(file, TimeBase::NANOSECONDS, columns, None)?;
        writer.all(now, &first)?;
        let (looks, put_at) = (probe.samples(), os::monotonic_ns());
        let path = path.to_owned();
        let mut tape = Self { path, probe, writer, looks, put_at, failure: None, is_over: false };
        tape.end_record();
        tape.put(now);
        Ok(tape)
    }

    /// Returns a description of how the recording stopped, once a write was refused.
    pub(crate) fn stopped(&mut self) -> Option<StoppedRecording> {
        let (reason, at) = self.failure.as_ref()?;
        let (bytes, kept_to) = self.writer.out().kept();
        Some(StoppedRecording {
            file: self.path.clone(),
            reason: reason.as_ref().into(),
            time: at.unsigned_abs(),
            bytes,
            kept_to: kept_to.map(i64::unsigned_abs),
        })
    }

    /// Marks what was written so far as whole records.
    fn end_record(&mut self) {
        let at = self.writer.at();
        self.writer.out().end_record(at);
    }

    /// Writes the whole records to the file.
    fn put(&mut self, now: i64) {
        let put = self.writer.out().put();
        self.have_put(put, now);
    }

    fn have_put(&mut self, put: Result<()>, now: i64) {
        if let Err(e) = put {
            self.failure.get_or_insert_with(|| (os::said(&e), now));
        }
    }

    /// Reads changes from the probe; whole records are written from time to time. `still` says that
    /// no sample is in progress.
    pub(crate) fn drain(&mut self, still: bool, now: i64) {
        if self.is_over {
            return;
        }
        // Every sample whose changes were read before, at least in part, is over.
        let over = still || self.probe.samples() > self.looks;
        let mut begun = false;
        while let Some((time, which, bits)) = self.probe.change() {
            if self.failure.is_some() {
                continue;
            }
            // A cycle that began late has the time at which it was due, which may be before the
            // recording, or before a sample that was taken while threads were stopped.
            let last = self.writer.at().unwrap_or(time);
            if last != time {
                self.end_record();
                begun = true;
            }
            let time = time.max(last);
            // This writes to memory, which does not fail.
            let written = self.writer.time(time);
            drop(written.and_then(|()| self.writer.change(which as usize, Some(bits))));
        }
        if self.failure.is_some() {
            return;
        }
        if still || (over && !begun) {
            self.end_record();
        }
        self.looks = self.probe.samples();
        let waiting = self.writer.out().waiting();
        let clock = os::monotonic_ns();
        if waiting >= MAX_WAITING || (waiting > 0 && clock - self.put_at >= MAX_WAIT_NS) {
            self.put_at = clock;
            self.put(now);
        }
    }

    /// Saves the recording before the process crashes: everything seen, and the present values if
    /// no cycle is in progress.
    pub(crate) fn salvage(&mut self, still: bool, now: i64) {
        if self.is_over {
            return;
        }
        if still {
            self.probe.sample(now);
            self.end(now);
            return;
        }
        self.drain(false, now);
        if self.failure.is_none() {
            self.put(now);
        }
    }

    /// Ends the recording at `now` and writes all of it to the file.
    pub(crate) fn end(&mut self, now: i64) {
        self.drain(true, now);
        if self.failure.is_some() {
            return;
        }
        if self.writer.at() < Some(now) {
            drop(self.writer.time(now));
        }
        self.end_record();
        let finished = self.writer.out().finish();
        self.have_put(finished, now);
        self.is_over = true;
    }
}

#[cfg(test)]
mod tests {
    use super::{Tape, WholeFile};
    use crate::{
        observe::probe::{Probe, Source},
        sync::{Arc, AtomicU8, AtomicU64, Ordering},
    };
    use core::ptr::NonNull;
    use hal_output::Growing;
    use hal_protocol::Type;
    use hal_trace::vcd::Column;

    #[test]
    fn a_cycle_that_was_due_before_the_recording_began_is_at_its_beginning() {
        let path = std::env::temp_dir().join(format!("hal-tape-late-{}", std::process::id()));
        let value = AtomicU8::new(0);
        let source = Source::own(NonNull::from(&value).cast(), Type::Bit);
        let probe = Arc::new(Probe::changes([source].into(), [AtomicU64::new(0)].into(), 16));
        let columns = [Column { ty: Type::Bit, names: vec!["x".to_owned()] }];
        let file = WholeFile::new(Growing::create(&path).unwrap());
        let mut tape = Tape::begin("x.vcd", file, &columns, probe.clone(), 11).unwrap();
        for (at, bit) in [(10, 1), (20, 0)] {
            value.store(bit, Ordering::Relaxed);
            probe.sample(at);
            tape.drain(false, 21);
        }
        tape.end(21);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let reading = hal_trace::vcd::read(text.as_bytes());
        assert_eq!(reading.flaw, None, "{text}");
        assert_eq!(reading.trace.times().iter().collect::<Vec<_>>(), [11, 20, 21], "{text}");
    }

    /// The reader cannot see whether the sample whose changes it reads is over: another thread may be about to queue
    /// more of them. The start of the next sample says so.
    #[test]
    fn a_record_is_whole_once_the_next_sample_has_begun() {
        let path = std::env::temp_dir().join(format!("hal-tape-{}", std::process::id()));
        let value = AtomicU8::new(0);
        let source = Source::own(NonNull::from(&value).cast(), Type::Bit);
        let probe = Arc::new(Probe::changes([source].into(), [AtomicU64::new(0)].into(), 16));
        let columns = [Column { ty: Type::Bit, names: vec!["x".to_owned()] }];
        let file = WholeFile::new(Growing::create(&path).unwrap());
        let mut tape = Tape::begin("x.vcd", file, &columns, probe.clone(), 0).unwrap();
        // Whole records wait, so that they can be counted.
        tape.put_at = i64::MAX;
        let sample = |at, bit| {
            value.store(bit, Ordering::Relaxed);
            probe.sample(at);
        };
        let whole = |tape: &mut Tape, still| {
            tape.drain(still, 9);
            tape.writer.out().waiting()
        };
        let bytes = "#1\n1!\n".len();
        sample(1, 1);
        assert_eq!([whole(&mut tape, false), whole(&mut tape, false)], [0; 2]);
        // The second sample has begun, and may be in progress.
        sample(2, 0);
        assert_eq!([whole(&mut tape, false), whole(&mut tape, false)], [bytes; 2]);
        // The third changes nothing.
        sample(3, 0);
        assert_eq!(whole(&mut tape, false), 2 * bytes);
        // No sample is in progress.
        sample(4, 1);
        assert_eq!(whole(&mut tape, false), 2 * bytes);
        assert_eq!(whole(&mut tape, true), 3 * bytes);
        tape.end(4);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.ends_with("#1\n1!\n#2\n0!\n#4\n1!\n"), "{text}");
        std::fs::remove_file(&path).unwrap();
    }
}
