//! Recording to VCD: the control side writes the changes that a probe has seen to a file.

mod file;
mod recording;
mod tape;

use crate::{
    Engine, Error, ends,
    error::watch::WatchError,
    graph::Ix,
    observe::probe::Probe,
    observe::probes::{At, Watching},
    os,
    sync::{Arc, AtomicU64},
};
use file::WholeFile;
use hal_output::Growing;
use hal_protocol::{Patterns, StoppedRecording, Type};
use hal_trace::vcd::Column;
pub(crate) use recording::Recording;
use std::{
    collections::BTreeMap,
    path::Path,
    sync::{Mutex, MutexGuard, PoisonError},
};
pub(crate) use tape::Tape;

/// Minimum capacity of the queue of changes.
const MIN_QUEUE: usize = 1 << 16;

/// Locks the tape, which the guard also uses.
fn lock(tape: &Mutex<Tape>) -> MutexGuard<'_, Tape> {
    tape.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Converts a stopped recording to an error.
fn unwritten(stopped: StoppedRecording) -> Error {
    let why = stopped.words().into();
    Error::File { path: stopped.file.into(), why }
}

impl Engine {
    /// Executes `record FILE PATTERNS…`. The patterns are matched when time first moves.
    pub(crate) fn record(&mut self, path: &str, patterns: &[String]) -> Result<(), Error> {
        if let Some(r) = &self.observers.recording {
            return Err(WatchError::Recording { path: r.path.as_str().into() }.into());
        }
        let refused = |e: std::io::Error| Error::File { path: path.into(), why: os::said(&e) };
        let file = Growing::create(Path::new(path)).map_err(refused)?;
        self.observers.stopped_recording = None;
        self.observers.recording = Some(Recording {
            path: path.to_owned(),
            patterns: Patterns::new(patterns),
            // An existing file stays as it is, and no temporary file appears beside it, until the
            // head is written.
            file: file.is_there().then_some(file),
            tape: None,
            probe: None,
        });
        if self.runtime.is_running() {
            self.begin_recording();
        }
        Ok(())
    }

    /// Determines the recorded values and writes the head of the file.
    pub(crate) fn begin_recording(&mut self) {
        let Some(mut r) = self.observers.recording.take_if(|r| r.is_waiting()) else { return };
        let watching = match self.begin_tape(&mut r) {
            Ok(watching) => watching,
            Err(stopped) => return self.stop_recording(r, stopped),
        };
        let probe = watching.probe.clone();
        match self.begin_watching(watching) {
            Ok(id) => {
                r.probe = Some((id, probe));
                self.observers.recording = Some(r);
            }
            Err(e) => {
                let stopped = self.not_begun(&r, &e.to_string());
                self.stop_recording(r, stopped);
            }
        }
    }

    /// Creates the file with its head and returns what the probe has to watch.
    fn begin_tape(&mut self, r: &mut Recording) -> Result<Watching, StoppedRecording> {
        let (nodes, columns) = self.watches(r);
        if nodes.is_empty() && !r.patterns.is_empty() {
            self.notice(format!("{}: nothing matches what is to be recorded", r.path));
        }
        let sources: Box<[_]> = nodes.iter().filter_map(|ix| self.source(*ix)).collect();
        let last = sources.iter().map(|s| AtomicU64::new(s.bits())).collect();
        let probe = Probe::changes(sources, last, MIN_QUEUE.max(nodes.len() * 4));
        let probe = Arc::new(probe.noting(ends::lost()));
        let file = r.file.take().map_or_else(|| Growing::create(Path::new(&r.path)), Ok);
        let begun = file.and_then(|file| {
            ends::note_recording(&r.path, file.inode().unwrap_or(0));
            let file = WholeFile::new(file);
            Tape::begin(&r.path, file, &columns, probe.clone(), self.runtime.now())
        });
        let mut tape = begun.map_err(|e| self.not_begun(r, &os::said(&e)))?;
        if let Some(stopped) = tape.stopped() {
            return Err(stopped);
        }
        r.tape = Some(Arc::new(Mutex::new(tape)));
        self.runtime.instance().set_tape(r.tape.clone());
        let nodes = nodes.into_iter().collect();
        Ok(Watching { probe, at: At::Moments, nodes, lossless: true })
    }

    /// Returns the description of a recording of which nothing could be written.
    fn not_begun(&self, r: &Recording, reason: &str) -> StoppedRecording {
        StoppedRecording {
            file: r.path.clone(),
            reason: reason.to_owned(),
            time: self.runtime.now().unsigned_abs(),
            bytes: 0,
            kept_to: None,
        }
    }

    /// Ends a recording that cannot be written any further, and reports it once.
    fn stop_recording(&mut self, r: Recording, stopped: StoppedRecording) {
        self.end_probe_of(&r);
        self.leave_recording();
        self.notice(stopped.to_string());
        self.observers.unwritten = true;
        self.observers.stopped_recording = Some(stopped);
    }

    /// Ends the watching of a recording.
    fn end_probe_of(&mut self, r: &Recording) {
        if let Some((id, _)) = r.probe {
            self.end_watching(id);
        }
    }

    /// Withdraws a recording from the guard and the watcher, once its file is complete.
    fn leave_recording(&self) {
        self.runtime.instance().set_tape(None);
        ends::note_recording("", 0);
    }

    /// Returns the nodes to watch, and the names under which each value appears.
    fn watches(&self, r: &Recording) -> (Vec<Ix>, Vec<Column>) {
        let mut nodes = Vec::new();
        let mut columns: Vec<Column> = Vec::new();
        let mut of_signal = BTreeMap::new();
        for (name, ix) in &self.model.graph().signal_names() {
            let Some(s) = self.model.graph().signal(*ix).filter(|s| s.ty != Type::Port) else {
                continue;
            };
            if r.patterns.matches(name.as_str()) {
                of_signal.insert(*ix, nodes.len());
                nodes.push(*ix);
                columns.push(Column { ty: s.ty, names: vec![name.as_str().to_owned()] });
            }
        }
        for (name, ix) in self.model.graph().all_item_names() {
            let Some(item) = self.model.graph().item(ix) else { continue };
            let plain = !item.hidden() && !item.times && item.direction.is_pin();
            let wanted =
                if r.patterns.is_empty() { plain } else { r.patterns.names(name.as_str()) };
            if !wanted || item.shown() != name || item.ty == Type::Port {
                continue;
            }
            // A pin that the user names in full is recorded by itself, also after it is linked to
            // another signal.
            let apart = r.patterns.is_one(name.as_str());
            let signal = self.model.graph().signal_of(ix).filter(|_| !apart);
            if let Some(at) =
                signal.and_then(|s| of_signal.get(&s)).and_then(|i| columns.get_mut(*i))
            {
                at.names.push(name.as_str().to_owned());
                continue;
            }
            if let Some(s) = signal {
                of_signal.insert(s, nodes.len());
            }
            nodes.push(ix);
            columns.push(Column { ty: item.ty, names: vec![name.as_str().to_owned()] });
        }
        (nodes, columns)
    }

    /// Writes queued changes.
    pub(crate) fn drain_recording(&mut self) {
        // While no cycle is in progress, neither is a sample.
        let still = self.runtime.is_virtual() || self.runtime.is_quiet();
        let Some(tape) = self.observers.recording.as_ref().and_then(|r| r.tape.as_deref()) else {
            return;
        };
        let mut tape = lock(tape);
        tape.drain(still, self.runtime.now());
        let stopped = tape.stopped();
        drop(tape);
        if let Some(stopped) = stopped
            && let Some(r) = self.observers.recording.take()
        {
            self.stop_recording(r, stopped);
        }
    }

    /// Takes a last sample: while no cycle runs, the probe does not see changes by a script or a
    /// stop action.
    fn look_last(&self) {
        let probe = self.observers.recording.as_ref().and_then(|r| r.probe.as_ref());
        if let Some((_, probe)) =
            probe.filter(|_| self.runtime.is_virtual() || self.runtime.is_quiet())
        {
            probe.sample(self.runtime.now());
        }
    }

    /// Ends the recording and completes the file.
    ///
    /// # Errors
    /// It could not be written whole, or changes were lost.
    pub(crate) fn end_recording(&mut self) -> Result<(), Error> {
        self.look_last();
        let Some(mut r) = self.observers.recording.take() else {
            let stopped = self.observers.stopped_recording.take();
            return Err(stopped.map_or_else(|| WatchError::NotRecording.into(), unwritten));
        };
        // Time has not moved, so the recording consists of the present values.
        let begun = if r.is_waiting() { self.begin_tape(&mut r).map(drop) } else { Ok(()) };
        self.end_probe_of(&r);
        // Until the file is complete, the guard must know of it: the write may not return.
        let stopped = begun.err().or_else(|| {
            let mut tape = lock(r.tape.as_deref()?);
            tape.end(self.runtime.now());
            tape.stopped()
        });
        self.leave_recording();
        if let Some(stopped) = stopped {
            self.observers.unwritten = true;
            return Err(unwritten(stopped));
        }
        match r.lost() {
            0 => Ok(()),
            lost => {
                self.observers.unwritten = true;
                let why = format!("{lost} changes were lost for want of room").into();
                Err(Error::File { path: r.path.into(), why })
            }
        }
    }

    /// Ends the recording of probe `id`, with a message, because a component that it watches is
    /// unloaded.
    pub(crate) fn recording_parted(&mut self, id: u64) {
        let probe = self.observers.recording.as_ref().and_then(|r| r.probe.as_ref());
        if probe.is_some_and(|p| p.0 == id) {
            let path = self.observers.recording.as_ref().map_or(String::new(), |r| r.path.clone());
            self.notice(format!("{path}: the recording ends, because a component is unloaded"));
            if let Err(e) = self.end_recording() {
                self.notice(e.to_string());
            }
        }
    }
}
