//! The words of `flight`.

use crate::{Command, Error, language::command::Flight, language::units};
use hal_protocol::{Failure, FlightSpec, Request};

/// The code of a failure that says that a word is wrong.
const EINVAL: i32 = -22;

/// Parses `flight`, `flight on …`, `flight off` and `flight save FILE [last]`.
pub(crate) fn parse(words: &[String]) -> Result<Command, Error> {
    let rest = words.get(1..).unwrap_or_default();
    Ok(match (words.first().map(String::as_str), rest) {
        (None, _) => Command::Flight(Flight::State),
        (Some("on"), rest) => Command::Send(Request::Flight(spec(rest)?), None),
        (Some("off"), []) => Command::Send(Request::EndFlight, None),
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

#[cfg(test)]
mod tests {
    use super::{parse, spec};

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
    }
}
