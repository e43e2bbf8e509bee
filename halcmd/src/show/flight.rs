//! The command `flight`: control of the flight recorder, and its state as text.

use crate::{Command, Error, Session, language::units};
use hal_protocol::{Failure, FlightInfo, FlightSpec, KeptInfo, KeptState, Reply, Request};
use std::fmt::Write;

/// Error codes for a wrong word and for a file that cannot be written.
const EINVAL: i32 = -22;
const EIO: i32 = -5;

/// Parsed arguments of `flight`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flight {
    /// Without arguments: show the state.
    State,
    /// Write the present contents, or the last event.
    Save {
        /// The file.
        path: String,
        /// True for the last event.
        last: bool,
    },
}

/// Parses `flight`, `flight on …`, `flight off` and `flight save FILE [last]`.
pub(crate) fn parse(words: &[String]) -> Result<Command, Error> {
    let rest = words.get(1..).unwrap_or_default();
    Ok(match (words.first().map(String::as_str), rest) {
        (None, _) => Command::Flight(Flight::State),
        (Some("on"), rest) => Command::Ask(Request::Flight(spec(rest)?), None),
        (Some("off"), []) => Command::Ask(Request::EndFlight, None),
        (Some("save"), [file]) => save(file, false),
        (Some("save"), [file, last]) if last == "last" => save(file, true),
        _ => return Err(bad(&format!("flight: what is '{}'", words.join(" ")))),
    })
}

fn save(file: &str, last: bool) -> Command {
    Command::Flight(Flight::Save { path: whole(file), last })
}

fn bad(text: &str) -> Error {
    let mut failure = Failure::new(EINVAL, text);
    failure.hint = Some("'help flight' says how it is used".to_owned());
    Error::Engine(failure)
}

/// Returns the absolute path of a file.
fn whole(file: &str) -> String {
    let file = file.trim_matches('"');
    std::path::absolute(file).map_or_else(|_| file.to_owned(), |p| p.display().to_string())
}

/// Parses words of the form `NAME=VALUE`. Other words continue the condition before them.
pub(crate) fn spec(words: &[String]) -> Result<FlightSpec, Error> {
    let mut spec = FlightSpec::default();
    for word in words {
        match word.split_once('=') {
            Some(("size", text)) => {
                spec.bytes = bytes(text).ok_or_else(|| {
                    bad(&format!("'{text}' is not a size: a number of bytes, or of K, M or G"))
                })?;
            }
            Some(("time", text)) => spec.before_ns = Some(time(text)?),
            Some(("after", text)) => spec.after_ns = time(text)?,
            Some(("file", file)) => spec.file = Some(whole(file)),
            Some(("when", condition)) => spec.when.push(condition.to_owned()),
            _ => match spec.when.last_mut() {
                Some(condition) => {
                    condition.push(' ');
                    condition.push_str(word);
                }
                None => return Err(bad(&format!("flight: what is '{word}'"))),
            },
        }
    }
    Ok(spec)
}

fn time(text: &str) -> Result<u64, Error> {
    units::nanoseconds(text).map_err(|_| Error::Time { word: text.into() })
}

fn bytes(text: &str) -> Option<u64> {
    let split = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at_checked(split)?;
    let scale = match unit {
        "" => 0,
        "K" | "k" => 10,
        "M" => 20,
        "G" => 30,
        _ => return None,
    };
    number.parse::<u64>().ok()?.checked_mul(1 << scale)
}

impl Session<'_> {
    pub(crate) fn flight(&mut self, what: Flight) -> Result<(), Error> {
        let Flight::Save { path, last } = what else {
            let reply = self.ask(Request::FlightState)?;
            return self.print(&reply, |reply| match reply {
                Reply::Flight(info) => Some(text(info)),
                _ => None,
            });
        };
        self.ask(Request::SaveFlight { path: path.clone(), last })?;
        // On the real clock, a separate thread writes the file.
        loop {
            let Reply::Flight(info) = self.ask(Request::FlightState)? else {
                return Err(Error::Unexpected);
            };
            let mine = |k: &&KeptInfo| k.file.as_deref() == Some(path.as_str());
            match info.kept.iter().rev().find(mine).map(|k| &k.state) {
                Some(KeptState::Writing) => {
                    self.ask(Request::Idle { ms: 5, flow: false })?;
                }
                Some(KeptState::Failed(why)) => {
                    return Err(Error::Engine(Failure::new(EIO, format!("{path}: {why}"))));
                }
                _ => return Ok(()),
            }
        }
    }
}

/// Returns the state of the recorder as lines of text.
fn text(info: &FlightInfo) -> String {
    let ns = |t: i64| units::duration(u64::try_from(t).unwrap_or(0));
    let mut out = format!(
        "Flight recorder: {} values, {} of {}, from {} to {}\n",
        info.values,
        size(info.used),
        size(info.bytes),
        ns(info.from),
        ns(info.to)
    );
    let mut line = |text: &str| {
        // Writing to a `String` cannot fail.
        let _: Result<(), std::fmt::Error> = writeln!(out, "  {text}");
    };
    if info.lost > 0 {
        line(&format!("{} changes were lost: they came too fast", info.lost));
    }
    // Memory holds the last event only.
    let events = info.kept.iter().filter(|k| k.state != KeptState::Awaited);
    let last = events.map(|k| k.number).max().unwrap_or(0);
    for k in &info.kept {
        let file = k.file.as_deref().unwrap_or("memory");
        let state = match &k.state {
            KeptState::Awaited => "what comes after it is awaited".to_owned(),
            KeptState::InMemory if k.number == last => {
                "in memory: 'flight save FILE.vcd last'".to_owned()
            }
            KeptState::InMemory => "no longer in memory: a later event took its place".to_owned(),
            KeptState::Writing => format!("being written to {file}"),
            KeptState::Written => file.to_owned(),
            KeptState::Failed(why) => format!("{file}: {why}"),
        };
        line(&format!("{}  at {}  {}  {state}", k.number, ns(k.time), k.why));
    }
    out
}

fn size(bytes: u64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match units.into_iter().find(|(shift, _)| bytes >> shift > 0) {
        Some((shift, unit)) => format!("{:.1} {unit}", bytes as f64 / (1_u64 << shift) as f64),
        None => format!("{bytes} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::{parse, size, spec, text};
    use hal_protocol::{FlightInfo, KeptInfo, KeptState};

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn what_it_is_told() {
        let s =
            spec(&words("size=64K time=1.5s after=20ms file=/x/a.vcd when=a > 5 when=!b")).unwrap();
        assert_eq!((s.bytes, s.before_ns, s.after_ns), (65536, Some(1_500_000_000), 20_000_000));
        assert_eq!(
            (s.file.as_deref(), &s.when[..]),
            (
                Some("/x/a.vcd"),
                &words("a_>_5 !b").iter().map(|w| w.replace('_', " ")).collect::<Vec<_>>()[..]
            )
        );
        for (text, want) in [
            ("on size=1T", "'1T' is not a size: a number of bytes, or of K, M or G"),
            ("on time=5", "'5' is not a time"),
            ("on color=red", "flight: what is 'color=red'"),
            ("off now", "flight: what is 'off now'"),
            ("save", "flight: what is 'save'"),
            ("save a.vcd first", "flight: what is 'save a.vcd first'"),
        ] {
            let said = parse(&words(text)).unwrap_err().whole();
            assert!(said.starts_with(want), "{text}: {said}");
        }
        assert_eq!(
            (size(1023), size(1 << 20), size(3 << 29)),
            ("1023 bytes".into(), "1.0 MiB".into(), "1.5 GiB".into())
        );
    }

    #[test]
    fn only_the_last_event_is_in_memory() {
        let kept = |number, why: &str, state| KeptInfo {
            number,
            time: i64::from(number) * 1_000_000,
            why: why.to_owned(),
            file: (state == KeptState::Written).then(|| "/x.vcd".to_owned()),
            state,
        };
        let info = FlightInfo {
            bytes: 4096,
            used: 24,
            values: 3,
            from: 0,
            to: 5_000_000,
            lost: 0,
            kept: vec![
                kept(1, "a", KeptState::InMemory),
                kept(2, "b", KeptState::InMemory),
                kept(2, "asked for", KeptState::Written),
                kept(3, "c", KeptState::Awaited),
            ],
        };
        let want = "Flight recorder: 3 values, 24 bytes of 4.0 KiB, from 0 ns to 5 ms\n\
             \x20 1  at 1 ms  a  no longer in memory: a later event took its place\n\
             \x20 2  at 2 ms  b  in memory: 'flight save FILE.vcd last'\n\
             \x20 2  at 2 ms  asked for  /x.vcd\n\
             \x20 3  at 3 ms  c  what comes after it is awaited\n";
        assert_eq!(text(&info), want);
    }
}
