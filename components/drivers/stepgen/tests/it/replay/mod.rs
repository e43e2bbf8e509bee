//! Replays a script of `tests/peer` on a [`Bench`] and compares it with LinuxCNC's samples.
//!
//! The components under test are real; those that only transport values (`scale`, `sum2`, `streamer`, `sampler`) are
//! emulated here.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a test"
)]

use hal_bench::Bench;
use std::{collections::BTreeMap, fs, path::PathBuf};

/// Function that loads the component of a `loadrt` line, or returns false if it is not under test.
pub(crate) type Load = fn(&mut Bench, &str, &[&str]) -> bool;

/// Runs `NAME.hal` and compares every sample with `NAME.out`.
pub(crate) fn check(name: &str, load: Load) {
    let mut script = Script::new(load);
    let text = read(name, "hal");
    text.lines().for_each(|line| script.line(line));
    let expected = read(name, "out");
    let expected: Vec<&str> = expected.lines().collect();
    assert!(expected.len() >= 500, "too few samples to prove anything");
    script.run(expected.len());
    for (n, (is, should)) in script.rows.iter().zip(&expected).enumerate() {
        let before = n.checked_sub(1).map_or("", |n| expected[n]);
        assert_eq!(is, should, "{name}: sample {n}, the one before was\n{before}");
    }
    assert_eq!(script.rows.len(), expected.len(), "{name}");
}

fn read(name: &str, kind: &str) -> String {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../tests/peer");
    fs::read_to_string(root.join(format!("{name}.{kind}"))).unwrap()
}

struct Script {
    load: Load,
    bench: Bench,
    /// Types and directions of the pins and parameters on the bench.
    types: BTreeMap<String, (String, String)>,
    /// Pins of the components emulated here.
    played: BTreeMap<String, f64>,
    /// Readers of each writing pin.
    nets: BTreeMap<String, Vec<String>>,
    signals: BTreeMap<String, (Option<String>, Vec<String>)>,
    threads: Vec<(String, i64, Vec<String>)>,
    /// Type letters of each sampler.
    samplers: Vec<String>,
    /// Remaining input of the streamer, the last line first.
    input: Vec<Vec<f64>>,
    rows: Vec<String>,
    /// True once samples are recorded.
    recording: bool,
}

impl Script {
    fn new(load: Load) -> Self {
        Self {
            load,
            bench: Bench::new(),
            types: BTreeMap::new(),
            played: BTreeMap::new(),
            nets: BTreeMap::new(),
            signals: BTreeMap::new(),
            threads: Vec::new(),
            samplers: Vec::new(),
            input: Vec::new(),
            rows: Vec::new(),
            recording: false,
        }
    }

    fn line(&mut self, line: &str) {
        let words: Vec<&str> = line.split_whitespace().filter(|w| *w != "=>").collect();
        match words.as_slice() {
            ["loadrt", kind, args @ ..] => self.loadrt(kind, args),
            ["net", signal, pins @ ..] => self.net(signal, pins),
            ["setp", pin, value] => self.put(pin, value.parse().unwrap()),
            ["addf", funct, thread] => {
                let thread = self.threads.iter_mut().find(|t| t.0 == *thread).unwrap();
                thread.2.push((*funct).to_owned());
            }
            ["loadusr", "-w", "halstreamer", file] => {
                let text = read(file.trim_end_matches(".in"), "in");
                let line = |l: &str| l.split(' ').map(|x| x.parse().unwrap()).collect();
                self.input = text.lines().map(line).rev().collect();
            }
            [] | ["start" | "setexact_for_test_suite_only" | "#" | "loadusr", ..] => {}
            _ => panic!("not understood: {line}"),
        }
    }

    fn loadrt(&mut self, kind: &str, args: &[&str]) {
        let arg = |name: &str| args.iter().find_map(|a| a.strip_prefix(name)?.strip_prefix('='));
        match kind {
            "threads" => {
                for n in ["1", "2"] {
                    if let Some(name) = arg(&format!("name{n}")) {
                        let period = arg(&format!("period{n}")).unwrap().parse().unwrap();
                        self.threads.push((name.to_owned(), period, Vec::new()));
                    }
                }
            }
            "sampler" => {
                self.samplers = arg("cfg").unwrap().split(',').map(str::to_owned).collect();
            }
            "scale" | "sum2" | "streamer" => {}
            _ => {
                assert!((self.load)(&mut self.bench, kind, args), "cannot load {kind}");
                for line in self.bench.names() {
                    let (name, rest) = line.split_once(' ').unwrap();
                    let (ty, dir) = rest.split_once(' ').unwrap();
                    self.types.insert(name.to_owned(), (ty.to_owned(), dir.to_owned()));
                }
            }
        }
    }

    fn net(&mut self, signal: &str, pins: &[&str]) {
        let entry = self.signals.entry(signal.to_owned()).or_default();
        for pin in pins {
            let writes = match self.types.get(*pin) {
                Some((_, dir)) => dir == "OUT",
                None => pin.ends_with(".out") || pin.starts_with("streamer."),
            };
            if writes {
                entry.0 = Some((*pin).to_owned());
            } else {
                entry.1.push((*pin).to_owned());
            }
        }
        if let Some(writer) = &entry.0 {
            self.nets.insert(writer.clone(), entry.1.clone());
        }
    }

    fn put(&mut self, pin: &str, value: f64) {
        match self.types.get(pin).map(|t| t.0.as_str()) {
            None => _ = self.played.insert(pin.to_owned(), value),
            Some("bit") => self.bench.set(pin, value != 0.0),
            Some("float") => self.bench.set(pin, value),
            Some("s32") => self.bench.set(pin, value as i32),
            Some("u32") => self.bench.set(pin, value as u32),
            Some(ty) => panic!("{pin} is {ty}"),
        }
    }

    fn take(&self, pin: &str) -> f64 {
        match self.types.get(pin).map(|t| t.0.as_str()) {
            None => self.played.get(pin).copied().unwrap_or(0.0),
            Some("bit") => f64::from(u8::from(self.bench.get::<bool>(pin))),
            Some("float") => self.bench.get(pin),
            Some("s32") => f64::from(self.bench.get::<i32>(pin)),
            Some(ty) => panic!("{pin} is {ty}"),
        }
    }

    fn run(&mut self, samples: usize) {
        let threads = self.threads.clone();
        match threads.as_slice() {
            [one] => {
                self.recording = true;
                while self.rows.len() < samples {
                    self.cycle(one);
                }
            }
            [fast, slow] => {
                self.cycle(fast);
                self.recording = true;
                while self.rows.len() < samples {
                    self.cycle(slow);
                    for _ in 0..slow.1 / fast.1 {
                        self.cycle(fast);
                    }
                }
            }
            _ => panic!("no threads"),
        }
    }

    fn cycle(&mut self, (_, period, functs): &(String, i64, Vec<String>)) {
        let mut row: Vec<String> = Vec::new();
        for funct in functs {
            let (kind, number) = funct.split_once('.').unwrap();
            match kind {
                "scale" => {
                    let of = |pin| self.take(&format!("{funct}.{pin}"));
                    let out = of("in") * of("gain") + of("offset");
                    self.put(&format!("{funct}.out"), out);
                }
                "sum2" => {
                    let of = |pin| self.take(&format!("{funct}.{pin}"));
                    let out = of("in0") + of("in1") + of("offset");
                    self.put(&format!("{funct}.out"), out);
                }
                "streamer" => {
                    for (n, x) in self.input.pop().unwrap_or_default().iter().enumerate() {
                        self.put(&format!("streamer.0.pin.{n}"), *x);
                    }
                }
                "sampler" => {
                    let types = &self.samplers[number.parse::<usize>().unwrap()];
                    for (n, ty) in types.chars().enumerate() {
                        let value = self.take(&format!("{funct}.pin.{n}"));
                        row.push(if ty == 'f' { format!("{value:.6}") } else { value.to_string() });
                    }
                }
                _ => self.bench.run(funct, *period),
            }
            self.copy_nets();
        }
        if self.recording && !row.is_empty() {
            self.rows.push(row.join(" "));
        }
    }

    fn copy_nets(&mut self) {
        for (writer, readers) in self.nets.clone() {
            let value = self.take(&writer);
            readers.iter().for_each(|pin| self.put(pin, value));
        }
    }
}
