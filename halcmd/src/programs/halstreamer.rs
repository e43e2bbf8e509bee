//! The program halstreamer: sends records to a streamer component.

use crate::{
    Stdio, Terminal,
    programs::halsampler::{LOOK_EVERY, WAIT_MS, channel, one_file, option_error, parted},
    programs::options::{Opt, from_environment, mixed, plain, program_usage},
    session::remote::{Remote, instance_option, pause},
    terminal::ended,
    terminal::termination::ending_flag,
};
use hal_protocol::{Link, Place, Request, Type, Value, ValueError};
use std::{
    io::{BufRead, BufReader, Read},
    process::ExitCode,
    sync::atomic::Ordering::Relaxed,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Channel,
    Instance,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        help: "the streamer's channel, from 0 (the default)",
        ..Opt::short_with(Id::Channel, 'c', "CHANNEL")
    },
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

fn run(words: &[String]) -> Result<(), String> {
    let (mut given, rest) = mixed("halstreamer", OPTIONS, words).map_err(|e| option_error(&e))?;
    from_environment(OPTIONS, &|name| std::env::var(name).ok(), &mut given);
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    if given.iter().any(|(id, _)| *id == Id::Help) {
        Stdio.out(&format!(
            "Usage: halstreamer [options] [FILE]\n\noptions:\n{}",
            program_usage(OPTIONS)
        ))?;
        return Ok(());
    }
    let channel = channel(value(Id::Channel).as_deref())?;
    let input: Box<dyn Read> = match one_file(&rest)? {
        None => Box::new(std::io::stdin()),
        Some(path) => {
            let file = std::fs::File::open(path);
            Box::new(file.map_err(|e| format!("ERROR: cannot read '{path}': {e}"))?)
        }
    };
    let ending = ending_flag();
    let place = Place::find(value(Id::Instance).as_deref())?;
    let remote = Remote::new(place.clone(), &format!("halstreamer{channel}"));
    let mut remote = remote.unless(ending.clone());
    let attached = remote.client().and_then(|c| c.attach(&format!("streamer.{channel}"), None));
    let mut stream = attached.map_err(|f| format!("ERROR: {f}"))?;
    let types = stream.types().to_vec();
    let mut input = BufReader::new(input);
    let mut line = Vec::new();
    let mut number = 0;
    while !ending.load(Relaxed) {
        line.clear();
        let got = input.read_until(b'\n', &mut line).map_err(|e| format!("ERROR: {e}"))?;
        if got == 0 {
            break;
        }
        match record(&String::from_utf8_lossy(&line), &types) {
            Ok(None) => {}
            Ok(Some(record)) => {
                let mut full = 0;
                loop {
                    if stream.is_closed() {
                        return Err(format!("ERROR: {}", parted(&mut remote, &place, "streamer")));
                    }
                    if stream.put(&record) || ending.load(Relaxed) {
                        break;
                    }
                    pause(WAIT_MS);
                    full += 1;
                    if full % LOOK_EVERY == 0 {
                        let look = Request::Idle { ms: 0, flow: false };
                        remote.call(look).map_err(|failure| format!("ERROR: {failure}"))?;
                    }
                }
            }
            Err((field, why)) => {
                let text = format!("line {number}, field {field}: {why}, skipping the line\n");
                Stdio.err(&text);
            }
        }
        number += 1;
    }
    Ok(())
}

/// Parses a line. Returns `None` for one that begins with `#`. Whitespace or the end of the line
/// must follow each field; surplus fields are ignored.
fn record(line: &str, types: &[Type]) -> Result<Option<Vec<Value>>, (usize, &'static str)> {
    if line.starts_with('#') {
        return Ok(None);
    }
    let mut fields = line.split_inclusive(|c: char| c.is_ascii_whitespace());
    let mut record = Vec::new();
    for (i, ty) in types.iter().enumerate() {
        let field = fields.find(|f| !f.trim().is_empty());
        let field = field.ok_or((i, "premature end of line"))?;
        if !field.ends_with(|c: char| c.is_ascii_whitespace()) {
            return Err((i, "premature end of line"));
        }
        record.push(value(field.trim_end(), *ty).map_err(|why| (i, why))?);
    }
    Ok(Some(record))
}

/// Parses a field. Integers are decimal; a float has the form of C.
fn value(field: &str, ty: Type) -> Result<Value, &'static str> {
    const BAD: &str = "bad character";
    const RANGE: &str = "value out of range";
    match (ty, field) {
        (Type::Bit, "0") => Ok(Value::Bit(false)),
        (Type::Bit, "1") => Ok(Value::Bit(true)),
        (Type::Bit, _) => Err("bit value not 0 or 1"),
        (Type::Float | Type::Port, _) => Value::parse(Type::Float, field).map_err(|_| BAD),
        (_, _) => {
            let (sign, digits) = match field.strip_prefix('-') {
                Some(rest) => ("-", rest),
                None => ("", field.strip_prefix('+').unwrap_or(field)),
            };
            if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
                return Err(BAD);
            }
            let zeros = digits.trim_start_matches('0');
            let plain = if zeros.is_empty() { "0" } else { zeros };
            Value::parse(ty, &format!("{sign}{plain}")).map_err(|error| match error {
                ValueError::Invalid => BAD,
                ValueError::Range => RANGE,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_records() {
        let types = [Type::Float, Type::Bit, Type::U32, Type::S32];
        for (line, want) in [
            ("# comment\n", "-"),
            ("1.5 1 7 -3\n", "1.5 TRUE 7 -3"),
            ("\n", "field 0: premature end of line"),
            ("x 1 2 3\n", "field 0: bad character"),
            ("1 2 3 4\n", "field 1: bit value not 0 or 1"),
            ("1 1 3 4x\n", "field 3: bad character"),
            ("1 1 3\n", "field 3: premature end of line"),
            ("1 1 3 4 5 6\n", "1 TRUE 3 4"),
            ("   3e2\t1  4294967295 -2147483648\n", "300 TRUE 4294967295 -2147483648"),
            ("inf 1 1 1\n", "inf TRUE 1 1"),
            ("0x10 1 010 4\n", "16 TRUE 10 4"),
            ("1 1 4294967296 4\n", "field 2: value out of range"),
            ("1 1 -1 4\n", "field 2: value out of range"),
            (" # d\n", "field 0: bad character"),
            ("+5 1 +3 +4\n", "5 TRUE 3 4"),
            ("9 1 9 9", "field 3: premature end of line"),
        ] {
            let shown = match record(line, &types) {
                Ok(None) => "-".to_owned(),
                Ok(Some(values)) => {
                    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
                }
                Err((field, why)) => format!("field {field}: {why}"),
            };
            assert_eq!(shown, want, "{line:?}");
        }
    }
}
