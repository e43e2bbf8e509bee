//! Tables of inputs and outputs for components, replayed by the real halrun on the virtual clock.
//!
//! ```text
//! # What the block shows.
//! load knobs count=1
//! period 1000000
//! set knobs.0.b 1
//! run knobs.0
//! in knobs.0.go knobs.0.f
//! out knobs.0.rf knobs.0.rs
//! 1 . | 0.5 0
//! expect knobs.0.f 0.25
//! absent knobs.1.f
//! said a part of what it complained about
//! unload knobs | a part of what it complains about then
//! refuse knobs cuont=2 | a part of why
//! ```
//!
//! `load` begins a block, which runs in an instance of its own. A row sets its inputs, runs the functions of `run` once
//! in their order, and compares its outputs; `.` leaves an input unchanged or an output unchecked. Bits are 0 and 1.
//! Numbers are compared as printed, to six figures, or with the tolerance of `within`.

use crate::scratch::Scratch;
use std::{fmt::Write, path::Path};

/// Script of one block, with a check for each value that the script prints.
#[derive(Debug, Default)]
struct Block {
    script: String,
    checks: Vec<Check>,
    run: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    period: u64,
    within: f64,
    threads: u32,
    said: Vec<(usize, String)>,
    line: usize,
}

/// Check of a printed value, with the line of the table that requires it.
#[derive(Debug)]
enum Check {
    Value { line: usize, name: String, wanted: String, within: f64 },
    Absent { line: usize, name: String },
}

/// Replays a table with the plugins of this folder and returns the number of rows compared.
///
/// # Errors
/// All differences, each with its line.
pub fn replay(table: &str, plugins: &Path) -> Result<usize, String> {
    let (mut rows, mut wrong) = (0, String::new());
    let mut block: Option<Block> = None;
    for (i, line) in table.lines().enumerate() {
        let (line, number) = (line.trim(), i + 1);
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            [] => {}
            [first, ..] if first.starts_with('#') => {}
            ["load", args @ ..] => {
                block.take().iter().for_each(|b| b.check(plugins, &mut wrong));
                block = Some(Block::new(args, number));
            }
            ["refuse", ..] => {
                if let Err(why) = refused(line, plugins) {
                    writeln!(wrong, "line {number}, `{line}`: {why}").unwrap();
                }
            }
            _ => {
                let Some(b) = &mut block else { return Err(format!("line {number}: no load yet")) };
                match b.line(line, &words, number) {
                    Ok(row) => rows += usize::from(row),
                    Err(why) => writeln!(wrong, "line {number}, `{line}`: {why}").unwrap(),
                }
            }
        }
    }
    block.take().iter().for_each(|b| b.check(plugins, &mut wrong));
    if wrong.is_empty() { Ok(rows) } else { Err(wrong) }
}

/// Runs one line of a script that must fail, and checks the reason.
fn refused(line: &str, plugins: &Path) -> Result<(), String> {
    let (load, why) = line.split_once(" | ").ok_or("`refuse NAME ARGS | WHY`")?;
    let script = format!("loadrt {}\n", load.trim_start_matches("refuse "));
    let (out, status) = halrun(&script, plugins);
    match status {
        Some(0) => Err("it was not refused".to_owned()),
        None => Err(format!("halrun was killed: {out}")),
        Some(_) if out.contains(why) => Ok(()),
        Some(_) => Err(format!("refused otherwise: {out}")),
    }
}

/// Runs a script with halrun and returns its output and exit status.
fn halrun(script: &str, plugins: &Path) -> (String, Option<i32>) {
    let scratch = Scratch::new("trace");
    scratch.write("test.hal", script);
    let mut command = scratch.command(&[], "halrun");
    command.args(["--virtual", "--hold", "-f", "test.hal"]).env("HAL_RTMOD_DIR", plugins);
    let output = scratch.run(&mut command);
    (format!("{}\n--- complaints\n{}", output.stdout, output.stderr), output.status)
}

impl Block {
    fn new(args: &[&str], line: usize) -> Self {
        let script = format!("loadrt {}\n", args.join(" "));
        Self { script, line, period: 1_000_000, ..Self::default() }
    }

    /// Parses a line; returns true if it was a row.
    fn line(&mut self, line: &str, words: &[&str], number: usize) -> Result<bool, String> {
        let owned = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
        match words {
            ["period", ns] => self.period = ns.parse().map_err(|_| "not a period")?,
            ["within", far] => self.within = far.parse().map_err(|_| "not a number")?,
            ["run", names @ ..] => {
                self.run = owned(names);
                self.thread();
            }
            ["in", names @ ..] => self.inputs = owned(names),
            ["out", names @ ..] => self.outputs = owned(names),
            ["set", name, value] => writeln!(self.script, "setp {name} {value}").unwrap(),
            ["expect", name, value] => self.expect(name, value, number),
            ["absent", name] => {
                writeln!(self.script, "list pin {name}\nlist param {name}").unwrap();
                self.checks.push(Check::Absent { line: number, name: (*name).to_owned() });
            }
            ["said", ..] => self.said.push((number, line.trim_start_matches("said ").to_owned())),
            ["unload", name, "|", ..] => {
                let (_, said) = line.split_once(" | ").unwrap_or_default();
                writeln!(self.script, "unloadrt {name}").unwrap();
                self.said.push((number, said.to_owned()));
            }
            _ => return self.row(line, number).map(|()| true),
        }
        Ok(false)
    }

    /// Puts the functions of `run` into a thread of their own; a block has only one `run`.
    fn thread(&mut self) {
        let n = self.threads;
        self.threads += 1;
        assert!(n == 0, "one `run` a block");
        writeln!(self.script, "loadrt threads name1=t period1={}", self.period).unwrap();
        for name in &self.run {
            writeln!(self.script, "addf {name} t").unwrap();
        }
        self.script.push_str("start\n");
    }

    fn row(&mut self, line: &str, number: usize) -> Result<(), String> {
        let (given, wanted) = line.split_once('|').ok_or("neither a command nor a row")?;
        for (name, value) in pairs(&self.inputs, given)? {
            writeln!(self.script, "setp {name} {value}").unwrap();
        }
        writeln!(self.script, "run {}ns", self.period).unwrap();
        for (name, value) in pairs(&self.outputs, wanted)? {
            self.expect(&name, &value, number);
        }
        Ok(())
    }

    fn expect(&mut self, name: &str, value: &str, line: usize) {
        writeln!(self.script, "getp {name}").unwrap();
        let (name, wanted) = (name.to_owned(), value.to_owned());
        self.checks.push(Check::Value { line, name, wanted, within: self.within });
    }

    /// Runs the script and compares the values.
    fn check(&self, plugins: &Path, wrong: &mut String) {
        let (out, status) = halrun(&self.script, plugins);
        let (printed, complaints) = out.split_once("\n--- complaints\n").unwrap_or_default();
        if status != Some(0) {
            writeln!(wrong, "line {}: halrun ends with {status:?}:\n{complaints}", self.line)
                .unwrap();
            return;
        }
        for (line, said) in &self.said {
            if !out.contains(said.as_str()) {
                writeln!(wrong, "line {line}: `{said}` was not said, but:\n{complaints}").unwrap();
            }
        }
        let mut lines = printed.lines().map(str::trim);
        for check in &self.checks {
            let mut value = lines.next().unwrap_or_default().to_owned();
            if matches!(check, Check::Absent { .. }) {
                // The listing has a table of pins and one of parameters.
                value.push_str(lines.next().unwrap_or_default());
            }
            match check {
                Check::Absent { line, name } if !value.is_empty() => {
                    writeln!(wrong, "line {line}: there is {name}: {value}").unwrap();
                }
                Check::Absent { .. } => {}
                Check::Value { line, name, wanted, within } => {
                    if !equal(&value, wanted, *within) {
                        writeln!(wrong, "line {line}: {name} is {value}, and not {wanted}")
                            .unwrap();
                    }
                }
            }
        }
    }
}

fn equal(value: &str, wanted: &str, within: f64) -> bool {
    let bit = match value {
        "TRUE" => Some("1"),
        "FALSE" => Some("0"),
        _ => None,
    };
    if value == wanted || bit == Some(wanted) {
        return true;
    }
    let number = |text: &str| text.parse::<f64>().ok();
    match (number(value), number(wanted)) {
        // Integers are printed in full, other numbers to six figures.
        (Some(a), Some(b)) if value.contains(['.', 'e']) || wanted.contains(['.', 'e']) => {
            (a - b).abs() <= within.max(b.abs() * 1e-6)
        }
        (Some(a), Some(b)) => a == b && value.len() < 16,
        _ => false,
    }
}

/// Pairs names with values; `.` stands for no value.
fn pairs(names: &[String], values: &str) -> Result<Vec<(String, String)>, String> {
    let values: Vec<&str> = values.split_whitespace().collect();
    if names.len() != values.len() {
        return Err(format!("{} names and {} values", names.len(), values.len()));
    }
    let all = names.iter().zip(values).filter(|(_, v)| *v != ".");
    Ok(all.map(|(n, v)| (n.clone(), v.to_owned())).collect())
}
