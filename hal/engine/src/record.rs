//! Recording to VCD: the file that the control side writes from what the probe saw. Changes only.

use crate::{
    Engine, Error,
    code::Ptr,
    graph::{Graph, Item},
    os,
    probe::{Probe, Source, Watch},
    sync::{Arc, AtomicU64, Ordering},
};
use crossbeam::queue::ArrayQueue;
use hal_protocol::{Patterns, Type, Value};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Write},
};

/// How many changes wait for the file at the most.
const ROOM: usize = 1 << 16;

/// A recording under way.
#[derive(Debug)]
pub(crate) struct Recording {
    pub(crate) path: String,
    patterns: Patterns,
    file: BufWriter<File>,
    /// Type and code of each watched value; set when time first moves.
    columns: Vec<(Type, String)>,
    probe: Option<Arc<Probe>>,
    at: i64,
    failed: bool,
}

impl Recording {
    /// Whether it is not settled yet what is recorded.
    pub(crate) const fn is_waiting(&self) -> bool {
        self.probe.is_none()
    }

    /// Changes lost for want of room.
    pub(crate) fn lost(&self) -> u64 {
        self.probe.as_ref().map_or(0, |p| p.lost.load(Ordering::Relaxed))
    }
}

impl Engine {
    /// `record FILE PATTERNS…`; what the patterns name is settled when time first moves.
    pub(crate) fn record(&mut self, path: &str, patterns: &[String]) -> Result<(), Error> {
        if let Some(r) = &self.recording {
            return Err(Error::Recording { path: r.path.as_str().into() });
        }
        let file =
            File::create(path).map_err(|e| Error::File { path: path.into(), why: os::said(&e) })?;
        self.recording = Some(Recording {
            path: path.to_owned(),
            patterns: Patterns::new(patterns),
            file: BufWriter::with_capacity(1 << 16, file),
            columns: Vec::new(),
            probe: None,
            at: -1,
            failed: false,
        });
        if self.shared.boundary.is_running() {
            self.begin_recording();
        }
        Ok(())
    }

    /// Settles what is recorded and writes the head of the file.
    pub(crate) fn begin_recording(&mut self) {
        let Some(mut r) = self.recording.take() else { return };
        if r.probe.is_none() {
            let (watches, names) = self.watches(&r);
            if watches.is_empty() && !r.patterns.is_empty() {
                self.notice(format!("{}: nothing matches what is to be recorded", r.path));
            }
            let mut codes = BTreeMap::new();
            for (i, (ty, _)) in names.iter().enumerate() {
                codes.insert(i, code(i));
                r.columns.push((*ty, code(i)));
            }
            let time = self.shared.now();
            let written = head(&mut r.file, &names).and_then(|()| {
                writeln!(r.file, "#{time}\n$dumpvars")?;
                for (w, (ty, code)) in watches.iter().zip(&r.columns) {
                    value(&mut r.file, *ty, w.last.load(Ordering::Relaxed), code)?;
                }
                writeln!(r.file, "$end")
            });
            r.failed = written.is_err();
            r.at = time;
            let room = ROOM.max(watches.len() * 4);
            let probe = Arc::new(Probe {
                watches,
                changes: ArrayQueue::new(room),
                lost: AtomicU64::new(0),
            });
            self.shared.probe.store(Some(probe.clone()));
            r.probe = Some(probe);
        }
        self.recording = Some(r);
    }

    /// What to watch, and under which names each value appears.
    fn watches(&self, r: &Recording) -> (Vec<Watch>, Vec<(Type, Vec<String>)>) {
        let mut watches = Vec::new();
        let mut names: Vec<(Type, Vec<String>)> = Vec::new();
        let mut of_signal = BTreeMap::new();
        for (name, ix) in &self.graph.signals {
            let Some(s) = self.graph.signal(*ix).filter(|s| s.ty != Type::Port) else { continue };
            if r.patterns.matches(name.as_str()) {
                of_signal.insert(*ix, watches.len());
                let last = AtomicU64::new(s.bits());
                watches.push(Watch { source: Source::Cell(s.cell), last });
                names.push((s.ty, vec![name.as_str().to_owned()]));
            }
        }
        let items = self.graph.pins.iter().chain(&self.graph.params);
        for (name, ix) in items {
            let Some(item) = self.graph.item(*ix) else { continue };
            let plain = !item.hidden && !item.times && item.direction.is_pin();
            let wanted =
                if r.patterns.is_empty() { plain } else { r.patterns.names(name.as_str()) };
            if !wanted || item.shown() != name || item.ty == Type::Port {
                continue;
            }
            let signal = self.graph.signal_of(*ix);
            if let Some(at) = signal.and_then(|s| of_signal.get(&s)).and_then(|i| names.get_mut(*i))
            {
                at.1.push(name.as_str().to_owned());
                continue;
            }
            if let Some(slot) = Item::slot(item) {
                let last = AtomicU64::new(item.bits());
                if let Some(s) = signal {
                    of_signal.insert(s, watches.len());
                }
                watches.push(Watch { source: Source::Slot(Ptr(slot)), last });
                names.push((item.ty, vec![name.as_str().to_owned()]));
            }
        }
        (watches, names)
    }

    /// Writes what has been queued.
    pub(crate) fn drain_recording(&mut self) {
        let Some(r) = &mut self.recording else { return };
        let Some(probe) = r.probe.clone() else { return };
        while let Some((time, which, bits)) = probe.changes.pop() {
            let Some((ty, code)) = r.columns.get(which as usize) else { continue };
            let mut write = || {
                if time != r.at {
                    writeln!(r.file, "#{time}")?;
                    r.at = time;
                }
                value(&mut r.file, *ty, bits, code)
            };
            r.failed |= write().is_err();
        }
    }

    /// While virtual time stands still, nobody looks at what a script or a stop action changes.
    fn look_last(&self) {
        let probe = self.recording.as_ref().and_then(|r| r.probe.as_ref());
        if let Some(probe) = probe.filter(|_| self.shared.is_virtual()) {
            probe.sample(self.shared.now());
        }
    }

    /// Ends the recording: the file is whole afterwards.
    pub(crate) fn end_recording(&mut self) -> Result<(), Error> {
        self.look_last();
        self.drain_recording();
        let Some(mut r) = self.recording.take() else { return Err(Error::NotRecording) };
        self.shared.probe.store(None);
        if let Some(probe) = r.probe.clone() {
            self.retire_probe(probe);
        }
        let now = self.shared.now();
        if now > r.at && writeln!(r.file, "#{now}").is_err() {
            r.failed = true;
        }
        if r.file.flush().is_err() || r.failed {
            let why = "the recording could not be written whole".into();
            return Err(Error::File { path: r.path.into(), why });
        }
        let lost = r.probe.map_or(0, |p| p.lost.load(Ordering::Relaxed));
        if lost > 0 {
            self.notice(format!("{}: {lost} changes were lost for want of room", r.path));
        }
        Ok(())
    }

    /// A recording watches no pin of a component that goes: it ends, and that is said.
    pub(crate) fn stop_watching(&mut self) {
        if self.recording.as_ref().is_some_and(|r| r.probe.is_some()) {
            let path = self.recording.as_ref().map_or(String::new(), |r| r.path.clone());
            self.notice(format!("{path}: the recording ends, because a component is unloaded"));
            if let Err(e) = self.end_recording() {
                self.notice(e.to_string());
            }
        }
    }
}

/// A short printable name for column `i`, as VCD wants.
fn code(mut i: usize) -> String {
    let mut out = String::new();
    loop {
        out.push(char::from(b'!' + u8::try_from(i % 94).unwrap_or(0)));
        i /= 94;
        if i == 0 {
            return out;
        }
    }
}

/// The head: names with dots become scopes.
fn head(file: &mut impl Write, columns: &[(Type, Vec<String>)]) -> std::io::Result<()> {
    writeln!(file, "$version Ferrule $end\n$timescale 1 ns $end")?;
    let mut vars: Vec<(Vec<&str>, Type, String)> = Vec::new();
    for (i, (ty, names)) in columns.iter().enumerate() {
        for name in names {
            vars.push((name.split('.').collect(), *ty, code(i)));
        }
    }
    vars.sort();
    let mut open: Vec<&str> = Vec::new();
    for (path, ty, code) in &vars {
        let Some((leaf, scopes)) = path.split_last() else { continue };
        let same = open.iter().zip(scopes).take_while(|(a, b)| a == b).count();
        for _ in same..open.len() {
            writeln!(file, "$upscope $end")?;
        }
        open.truncate(same);
        for scope in scopes.iter().skip(same) {
            writeln!(file, "$scope module {scope} $end")?;
            open.push(scope);
        }
        let kind = match ty {
            Type::Bit => "wire 1",
            Type::Float => "real 64",
            Type::S32 => "integer 32",
            Type::U32 => "wire 32",
            Type::S64 => "integer 64",
            Type::U64 | Type::Port => "wire 64",
        };
        writeln!(file, "$var {kind} {code} {leaf} $end")?;
    }
    for _ in &open {
        writeln!(file, "$upscope $end")?;
    }
    writeln!(file, "$enddefinitions $end")
}

fn value(file: &mut impl Write, ty: Type, bits: u64, code: &str) -> std::io::Result<()> {
    match Graph::value(ty, bits) {
        Value::Bit(b) => writeln!(file, "{}{code}", u8::from(b)),
        Value::Float(f) if f.is_finite() => writeln!(file, "r{f:e} {code}"),
        Value::Float(f) if f.is_nan() => writeln!(file, "rnan {code}"),
        Value::Float(f) => writeln!(file, "r{}inf {code}", if f < 0.0 { "-" } else { "" }),
        Value::S32(_) | Value::U32(_) => writeln!(file, "b{:b} {code}", bits & 0xffff_ffff),
        Value::S64(_) | Value::U64(_) | Value::Port(_) => writeln!(file, "b{bits:b} {code}"),
    }
}
