//! The program halsampler: prints the records of a sampler component.

use crate::{
    Stdio, Terminal,
    programs::options::{Opt, from_environment, mixed, plain, program_usage},
    session::remote::{Remote, instance_option, lost_words, pause},
    terminal::ended,
    terminal::termination::ending_flag,
};
use hal_output::Growing;
use hal_protocol::{Link, Place, Request, Stream, Value};
use std::{
    io::ErrorKind,
    path::Path,
    process::ExitCode,
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

/// Maximum number of channels.
pub(crate) const CHANNELS: u32 = 8;
/// Interval between two checks for data, in milliseconds, and number of these intervals between two
/// checks whether the engine still runs.
pub(crate) const WAIT_MS: u32 = 5;
pub(crate) const LOOK_EVERY: u32 = 100;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Channel,
    Count,
    Tag,
    Instance,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        help: "the sampler's channel, from 0 (the default)",
        ..Opt::short_with(Id::Channel, 'c', "CHANNEL")
    },
    Opt { help: "end after this many records", ..Opt::short_with(Id::Count, 'n', "COUNT") },
    Opt { help: "print the number of each record", ..Opt::flag(Id::Tag, 't') },
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Id::Help, 'h') },
    instance_option(Id::Instance),
];

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    ended(run(words))
}

/// Parses the number of a channel.
pub(crate) fn channel(text: Option<&str>) -> Result<u32, String> {
    match text {
        None => Ok(0),
        Some(text) => text
            .parse()
            .ok()
            .filter(|c| *c < CHANNELS)
            .ok_or_else(|| format!("ERROR: invalid channel number '{text}'")),
    }
}

/// Returns the message about a wrong option, as worded by LinuxCNC's programs.
pub(crate) fn option_error(error: &crate::Error) -> String {
    match error {
        crate::Error::BadOption { option, .. } => format!("ERROR: unknown option '{option}'"),
        other => format!("ERROR: {other}"),
    }
}

/// Returns the file named on the command line, if any.
pub(crate) fn one_file(rest: &[String]) -> Result<Option<&String>, String> {
    match rest {
        [] => Ok(None),
        [file] => Ok(Some(file)),
        _ => Err("ERROR: At most one filename may be specified".to_owned()),
    }
}

fn run(words: &[String]) -> Result<(), String> {
    let (mut given, rest) = mixed("halsampler", OPTIONS, words).map_err(|e| option_error(&e))?;
    from_environment(OPTIONS, &|name| std::env::var(name).ok(), &mut given);
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    if given.iter().any(|(id, _)| *id == Id::Help) {
        Stdio.out(&format!(
            "Usage: halsampler [options] [FILE]\n\noptions:\n{}",
            program_usage(OPTIONS)
        ))?;
        return Ok(());
    }
    let channel = channel(value(Id::Channel).as_deref())?;
    let wanted: Option<u64> = match value(Id::Count) {
        None => None,
        Some(n) => Some(n.parse().map_err(|_| format!("ERROR: invalid sample count '{n}'"))?),
    };
    let count = wanted.unwrap_or(u64::MAX);
    let path = one_file(&rest)?;
    let ending = ending_flag();
    let place = Place::find(value(Id::Instance).as_deref())?;
    let remote = Remote::new(place.clone(), &format!("halsampler{channel}"));
    let mut remote = remote.unless(ending.clone());
    let attached = remote.client().and_then(|c| c.attach(&format!("sampler.{channel}"), wanted));
    let stream = attached.map_err(|f| format!("ERROR: {f}"))?;
    let tagged = given.iter().any(|(id, _)| *id == Id::Tag);
    let printer =
        Printer { out: Out::open(path)?, tagged, expected: 1, text: String::new(), records: 0 };
    print(stream, &mut remote, &place, printer, count, &ending)
}

/// Returns whether the engine responds.
fn answers(remote: &mut Remote) -> bool {
    remote.call(Request::Idle { ms: 0, flow: false }).is_ok()
}

/// Returns the reason why a component's ring is closed.
pub(crate) fn parted(remote: &mut Remote, place: &Place, component: &str) -> String {
    if answers(remote) {
        format!("the {component} has been unloaded")
    } else {
        lost_words(place).to_owned()
    }
}

fn print(
    mut stream: Stream,
    remote: &mut Remote,
    place: &Place,
    mut printer: Printer<'_>,
    mut count: u64,
    ending: &AtomicBool,
) -> Result<(), String> {
    let mut record = Vec::new();
    let mut empty = 0;
    let mut lost = None;
    let mut is_ending = false;
    while printer.records < count {
        if !is_ending && ending.load(Relaxed) {
            // What was sampled before the signal is still read.
            is_ending = true;
            count = count.min(printer.records.saturating_add(stream.waiting().into()));
            continue;
        }
        if let Some(number) = stream.take(&mut record) {
            printer.record(number, &record);
            empty = 0;
            if printer.text.len() > 60_000 {
                printer.flush()?;
            }
            continue;
        }
        printer.flush()?;
        if let Some(why) = lost {
            let (n, place) = (printer.records, printer.out.place());
            let s = if n == 1 { "" } else { "s" };
            printer.out.finish()?;
            return Err(format!("ERROR: {why}: {n} record{s} {place}"));
        }
        if stream.is_closed() {
            // Records that arrived meanwhile are read first.
            lost = Some(parted(remote, place, "sampler"));
            continue;
        }
        pause(WAIT_MS);
        empty += 1;
        if empty % LOOK_EVERY == 0 && stream.waiting() == 0 && !answers(remote) {
            lost = Some(lost_words(place).to_owned());
        }
    }
    printer.flush()?;
    printer.out.finish()
}

/// Destination of records.
enum Out<'a> {
    Stdout,
    File(&'a str, Growing),
}

impl<'a> Out<'a> {
    fn open(path: Option<&'a String>) -> Result<Self, String> {
        let Some(path) = path else { return Ok(Self::Stdout) };
        let file = Growing::create(Path::new(path)).map_err(|e| refused(path, &e))?;
        Ok(Self::File(path, file))
    }

    /// Returns the destination, as the end of a sentence.
    fn place(&self) -> String {
        match self {
            Self::Stdout => "were printed".to_owned(),
            Self::File(path, _) => format!("are in '{path}'"),
        }
    }

    fn finish(self) -> Result<(), String> {
        match self {
            Self::Stdout => Ok(()),
            Self::File(path, file) => file.finish().map_err(|e| refused(path, &e)),
        }
    }
}

fn refused(path: &str, error: &std::io::Error) -> String {
    if error.kind() == ErrorKind::BrokenPipe {
        hal_output::lose_reader();
    }
    format!("ERROR: cannot write '{path}': {}", hal_output::reason(error))
}

/// Writes records as lines.
struct Printer<'a> {
    out: Out<'a>,
    tagged: bool,
    expected: u64,
    /// Lines not yet written.
    text: String,
    /// Number of records.
    records: u64,
}

impl Printer<'_> {
    /// Writes the pending lines.
    fn flush(&mut self) -> Result<(), String> {
        let text = core::mem::take(&mut self.text);
        if text.is_empty() {
            return Ok(());
        }
        match &mut self.out {
            Out::Stdout => hal_output::print(&text).map_err(|e| format!("ERROR: {e}")),
            Out::File(path, file) => file.append(text.as_bytes()).map_err(|e| refused(path, &e)),
        }
    }

    /// Adds a line.
    fn record(&mut self, number: u64, record: &[Value]) {
        if number != self.expected {
            self.text.push_str("overrun\n");
        }
        self.expected = number.wrapping_add(1);
        if self.tagged {
            // Records are numbered from 1, lines from 0.
            self.text.push_str(&format!("{} ", number.wrapping_sub(1)));
        }
        for value in record {
            match value {
                Value::Float(f) if f.is_finite() => self.text.push_str(&format!("{f:.6} ")),
                Value::Bit(b) => self.text.push_str(if *b { "1 " } else { "0 " }),
                other => self.text.push_str(&format!("{other} ")),
            }
        }
        self.text.push('\n');
        self.records += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_become_lines() {
        let (out, text) = (Out::Stdout, String::new());
        let mut printer = Printer { out, tagged: true, expected: 1, text, records: 0 };
        let row = |f: f64| [Value::Float(f), Value::Bit(f > 0.0), Value::U32(7), Value::S32(-3)];
        printer.record(1, &row(1.5));
        printer.record(2, &row(-0.0));
        printer.record(5, &row(f64::INFINITY));
        printer.tagged = false;
        printer.record(6, &[Value::S64(i64::MIN), Value::U64(u64::MAX), Value::Float(f64::NAN)]);
        let want = "0 1.500000 1 7 -3 \n1 -0.000000 0 7 -3 \noverrun\n4 inf 1 7 -3 \n\
                    -9223372036854775808 18446744073709551615 nan \n";
        assert_eq!(printer.text, want);
    }

    #[test]
    fn what_is_wrong_is_said_in_these_words() {
        for (words, want) in [
            ("-n x", "ERROR: invalid sample count 'x'"),
            ("-n -1", "ERROR: invalid sample count '-1'"),
            ("-c 99", "ERROR: invalid channel number '99'"),
            ("-z", "ERROR: unknown option 'z'"),
            ("a b", "ERROR: At most one filename may be specified"),
        ] {
            let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
            assert_eq!(run(&words), Err(want.to_owned()));
        }
    }
}
