//! The rows of a component's `traces/`, executed by LinuxCNC's component of the same name.

use super::verdict::exact;
use crate::{
    foreign::{Bench, installed},
    machine::{get, script},
};
use hal_protocol::{Link, Request, Value};
use std::fmt::Write;

/// Returns the table with the outputs of LinuxCNC's component; a value that agrees keeps its spelling.
/// `hal_bench::trace` documents the format of a table.
///
/// # Errors
/// LinuxCNC has no such component, or refuses a command; the message names the line.
pub fn measured(table: &str) -> Result<String, String> {
    let (mut out, mut block) = (String::new(), Block::new());
    for (i, line) in table.lines().enumerate() {
        let line = block.line(line).map_err(|e| format!("line {}, `{line}`: {e}", i + 1))?;
        writeln!(out, "{line}").unwrap();
    }
    block.unload();
    Ok(out)
}

/// State between one `load` and the next.
struct Block {
    bench: Bench,
    module: String,
    period: u64,
    within: f64,
    run: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    links: Vec<String>,
    started: bool,
}

impl Block {
    fn new() -> Self {
        let (bench, module) = (Bench::new(&[&installed().unwrap()]), String::new());
        let (run, inputs, outputs, links) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (period, within, started) = (1_000_000, 0.0, false);
        Self { bench, module, period, within, run, inputs, outputs, links, started }
    }

    fn unload(&mut self) {
        self.rest();
        if !self.module.is_empty() {
            script(&mut self.bench, &format!("unloadrt {}", self.module));
        }
    }

    /// Removes the threads until the next row.
    fn rest(&mut self) {
        if std::mem::take(&mut self.started) {
            script(&mut self.bench, "stop\nunloadrt threads");
        }
    }

    fn start(&mut self) {
        if std::mem::replace(&mut self.started, true) {
            return;
        }
        let mut lines = format!("loadrt threads name1=t period1={}\n", self.period);
        for f in &self.run {
            writeln!(lines, "addf {f} t").unwrap();
        }
        script(&mut self.bench, &format!("{lines}start"));
    }

    fn line(&mut self, line: &str) -> Result<String, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let owned = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect();
        match words.as_slice() {
            [] => {}
            [first, ..] if first.starts_with('#') => {}
            ["load", name, args @ ..] => {
                self.unload();
                *self = Self::new();
                self.bench.load_c("", &format!("{name} {}", args.join(" ")))?;
                (*name).clone_into(&mut self.module);
            }
            ["period", ns] => {
                self.rest();
                self.period = ns.parse().map_err(|_| "not a period")?;
            }
            ["within", far] => self.within = far.parse().map_err(|_| "not a number")?,
            ["run", names @ ..] => {
                self.rest();
                self.run = owned(names);
            }
            ["in", names @ ..] => self.inputs = owned(names),
            ["out", names @ ..] => self.outputs = owned(names),
            ["link", name] => {
                script(&mut self.bench, &format!("net {} {name}", signal(name)));
                self.links.push((*name).to_owned());
            }
            ["set", name, value] => self.set(name, value)?,
            ["expect", name, value] => {
                return Ok(format!("expect {name} {}", self.got(name, value)));
            }
            _ => return self.row(line),
        }
        Ok(line.to_owned())
    }

    fn row(&mut self, line: &str) -> Result<String, String> {
        let (given, wanted) = line.split_once('|').ok_or("neither a command nor a row")?;
        for (name, value) in self.inputs.clone().iter().zip(given.split_whitespace()) {
            self.set(name, value)?;
        }
        self.start();
        self.bench.call(Request::Run { ns: self.period }).map_err(|e| e.to_string())?;
        let (names, mut words) = (self.outputs.clone(), wanted.split_whitespace());
        let got: Vec<_> =
            names.iter().map(|name| self.got(name, words.next().unwrap_or("?"))).collect();
        Ok(if got.iter().zip(wanted.split_whitespace()).all(|(a, b)| a == b) {
            line.to_owned()
        } else {
            format!("{}| {}", given, got.join(" "))
        })
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        if value == "." {
            return Ok(());
        }
        let value = value.to_owned();
        let request = if self.links.iter().any(|l| l == name) {
            Request::SetSignal { name: signal(name), value }
        } else {
            Request::Set { name: name.to_owned(), value }
        };
        self.bench.call(request).map(drop).map_err(|e| e.to_string())
    }

    /// Reads a pin; returns the previous text if the value is the same.
    fn got(&mut self, name: &str, was: &str) -> String {
        if was == "." {
            return was.to_owned();
        }
        let value = get(&mut self.bench, name);
        let same = match (value, was.parse::<f64>()) {
            (Value::Float(f), Ok(w)) => {
                f == w || (f - w).abs() <= self.within || f.is_nan() && w.is_nan()
            }
            _ => false,
        };
        match value {
            _ if same => was.to_owned(),
            Value::Bit(b) => u8::from(b).to_string(),
            Value::Float(f) if f.is_nan() => "nan".to_owned(),
            other => {
                let text = exact(other);
                text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
            }
        }
    }
}

fn signal(pin: &str) -> String {
    format!("on-{pin}")
}
