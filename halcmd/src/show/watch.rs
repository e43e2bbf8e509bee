//! `watch`: values as they change, in lines or on a screen.

use crate::{
    Error, Session, language::command::Watch, language::hint::nearest, show::from_signal,
    terminal::screen,
};
use hal_protocol::{Direction, Failure, Kind, Link, Patterns, Reply, Request, Value};
use serde::Serialize;
use std::collections::BTreeMap;

/// Failure code for a name that does not exist.
const ENOENT: i32 = -2;
/// Maximum wait between two checks of the keyboard or of the end of the instance, in milliseconds.
const STEP_MS: u32 = 50;

/// Kind of item to which a value belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Of {
    /// A pin.
    Pin,
    /// A signal.
    Sig,
    /// A parameter.
    Param,
}

impl Of {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Pin => "pin",
            Self::Sig => "sig",
            Self::Param => "param",
        }
    }
}

/// An item with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Seen {
    pub(crate) name: String,
    pub(crate) of: Of,
    pub(crate) value: Value,
    #[serde(skip)]
    pub(crate) direction: Option<Direction>,
    #[serde(skip)]
    pub(crate) signal: Option<String>,
    #[serde(skip)]
    pub(crate) doc: String,
}

/// Values at one machine time, sorted by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Look {
    /// Machine time in nanoseconds.
    pub(crate) time: u64,
    pub(crate) seen: Vec<Seen>,
}

/// Reads every item that a pattern names exactly, or else matches.
pub(crate) fn look(link: &mut dyn Link, patterns: &[String]) -> Result<Look, Error> {
    let time = match link.call(Request::Status)? {
        Reply::Status(status) => status.time,
        _ => return Err(Error::Unexpected),
    };
    let mut seen = Vec::new();
    for kind in [Kind::Pins, Kind::Signals, Kind::Params] {
        let request = Request::List { kind, patterns: patterns.to_vec(), ty: None };
        match link.call(request)? {
            Reply::Items(list) => seen.extend(list.into_iter().map(|i| Seen {
                of: if i.direction.is_pin() { Of::Pin } else { Of::Param },
                name: i.name,
                value: i.value,
                direction: Some(i.direction),
                signal: i.signal,
                doc: i.doc,
            })),
            Reply::Signals(list) => seen.extend(list.into_iter().map(|s| Seen {
                of: Of::Sig,
                name: s.name,
                value: s.value,
                direction: None,
                signal: None,
                doc: s.pins.iter().map(|(d, pin)| format!("{} {pin}\n", from_signal(*d))).collect(),
            })),
            _ => return Err(Error::Unexpected),
        }
    }
    // A complete name selects that item, not all items that begin with it.
    let whole = |p: &String| seen.iter().any(|s| s.name == *p);
    let (exact, others): (Vec<String>, Vec<String>) = patterns.iter().cloned().partition(whole);
    let others_match = Patterns::new(&others);
    seen.retain(|s| exact.contains(&s.name) || others_match.names(&s.name));
    seen.sort_by(|a, b| (&a.name, a.of).cmp(&(&b.name, b.of)));
    Ok(Look { time, seen })
}

/// Waits. The clock of a machine in this process moves meanwhile; that of another is not affected.
/// Returns false if the instance is ending.
pub(crate) fn wait(link: &mut dyn Link, ms: u32) -> Result<bool, Error> {
    let flow = link.is_local();
    if link.is_ending() {
        return Ok(false);
    }
    link.call(Request::Idle { ms, flow })?;
    Ok(!link.is_ending())
}

/// Writes machine time in seconds.
pub(crate) fn seconds(ns: u64) -> String {
    format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)
}

impl Session<'_> {
    /// Executes `watch`.
    pub(crate) fn watch(&mut self, watch: &Watch) -> Result<(), Error> {
        let first = look(self.link, &watch.patterns)?;
        if first.seen.is_empty() {
            return Err(self.nothing(&watch.patterns));
        }
        if self.terminal.is_screen() && !self.style.json && !self.style.script {
            let last = screen::watch(self.link, watch, first, &self.instance)?;
            let text: String = last.seen.iter().map(|s| line(last.time, s)).collect();
            self.terminal.out(&text)?;
            return Ok(());
        }
        self.watch_lines(watch, first)
    }

    /// Prints a line for each change.
    fn watch_lines(&mut self, watch: &Watch, first: Look) -> Result<(), Error> {
        let mut before = BTreeMap::new();
        let mut look_now = first;
        let mut looks = 0;
        loop {
            let Look { time, mut seen } = look_now;
            seen.retain(|s| before.insert((s.name.clone(), s.of), s.value) != Some(s.value));
            self.print_changes(time, &seen)?;
            looks += 1;
            if watch.count.is_some_and(|count| looks >= count) {
                return Ok(());
            }
            let mut left = watch.every_ms;
            while left > 0 {
                let ms = left.min(STEP_MS);
                if !wait(self.link, ms)? {
                    return Ok(());
                }
                left -= ms;
            }
            look_now = look(self.link, &watch.patterns)?;
        }
    }

    fn print_changes(&mut self, time: u64, seen: &[Seen]) -> Result<(), Error> {
        if self.style.silent || seen.is_empty() {
            return Ok(());
        }
        let text = if self.style.json {
            let all = serde_json::json!({ "time": time, "changes": seen });
            format!("{all}\n")
        } else {
            seen.iter().map(|s| line(time, s)).collect()
        };
        self.terminal.out(&text)?;
        Ok(())
    }

    /// Returns the error that no pattern matches, with the nearest name.
    pub(crate) fn nothing(&mut self, patterns: &[String]) -> Error {
        let word = patterns.first().map(String::as_str).unwrap_or_default();
        let text = format!("pin, signal or parameter '{}' not found", patterns.join(" "));
        let mut failure = Failure::new(ENOENT, text);
        let all = look(self.link, &["".to_owned()]).unwrap_or_default();
        let near = nearest(word, all.seen.iter().map(|s| s.name.as_str()));
        failure.hint = near.map(|near| format!("did you mean {near}?"));
        Error::Engine(failure)
    }
}

/// Writes machine time for a person.
pub(crate) fn about_seconds(ns: u64) -> String {
    format!("{}.{:03} s", ns / 1_000_000_000, ns % 1_000_000_000 / 1_000_000)
}

/// Writes time, name and value.
fn line(time: u64, seen: &Seen) -> String {
    format!("{} {} {}\n", seconds(time), seen.name, seen.value)
}

#[cfg(test)]
mod tests {
    use super::seconds;
    use crate::{
        Captured, Outcome, Session, Style, language::arguments, show::samples::item, show::status,
    };
    use hal_protocol::{Direction, Failure, Kind, Link, Lock, Reply, Request, SignalInfo, Value};

    /// Counts its readings: it has a pin that counts along, one that is constant, and a signal of
    /// the same name.
    #[derive(Default)]
    struct Counting {
        looks: i32,
    }

    impl Link for Counting {
        fn call(&mut self, request: Request) -> Result<Reply, Failure> {
            Ok(match request {
                Request::Status => {
                    self.looks += 1;
                    let mut status = status::samples::status(Lock::NONE);
                    status.time = u64::try_from(self.looks).unwrap() * 1_000_000;
                    Reply::Status(Box::new(status))
                }
                Request::List { kind: Kind::Pins, .. } => Reply::Items(vec![
                    item((1, "c"), "a.count", Direction::Out, Value::S32(self.looks / 2)),
                    item((1, "c"), "a.count-not", Direction::Out, Value::Bit(self.looks % 2 == 0)),
                    item((1, "c"), "a.nan", Direction::In, Value::Float(f64::NAN)),
                ]),
                Request::List { kind: Kind::Signals, .. } => Reply::Signals(vec![SignalInfo {
                    name: "a.nan".to_owned(),
                    value: Value::U64(u64::MAX),
                    pins: Vec::new(),
                }]),
                Request::List { .. } => Reply::Items(Vec::new()),
                _ => Reply::Done,
            })
        }
    }

    fn check(line: &str, style: Style, want: &str) {
        let (mut link, mut terminal) = (Counting::default(), Captured::default());
        let mut session = Session::new(&mut link, &mut terminal, style, "default");
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let mark = if session.command(&words) == Outcome::Good { "" } else { "!" };
        assert_eq!(format!("{mark}{}", terminal.all), want, "{line}");
    }

    #[test]
    fn changes_are_lines() {
        check(
            "watch --count 4 a.count",
            Style::default(),
            "0.001000000 a.count 0\n0.002000000 a.count 1\n0.004000000 a.count 2\n",
        );
        check(
            "watch a.count* --count 2 -n 1ms",
            Style::default(),
            "0.001000000 a.count 0\n0.001000000 a.count-not FALSE\n\
             0.002000000 a.count 1\n0.002000000 a.count-not TRUE\n",
        );
        check(
            "watch a.n --count 3",
            Style { json: true, ..Style::default() },
            "{\"changes\":[{\"name\":\"a.nan\",\"of\":\"pin\",\"value\":{\"float\":\"nan\"}},\
             {\"name\":\"a.nan\",\"of\":\"sig\",\"value\":{\"u64\":\"18446744073709551615\"}}],\
             \"time\":1000000}\n",
        );
        check(
            "watch a.coumt --count 1",
            Style::default(),
            "!<commandline>:0: pin, signal or parameter 'a.coumt' not found\n\
             <commandline>:0: did you mean a.count?\n",
        );
        check("meter", Style::default(), "!<commandline>:0: this view needs a terminal\n");
    }

    #[test]
    fn options_stand_anywhere() {
        let shown = |line: &str| {
            let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
            arguments::watch(&words).map_or_else(
                |e| format!("! {e}"),
                |w| format!("{} {} {:?}", w.patterns.join(" "), w.every_ms, w.count),
            )
        };
        for (line, want) in [
            ("a b", "a b 200 None"),
            ("-n 1s a --count 3 b", "a b 1000 Some(3)"),
            ("a --count=2", "a 200 Some(2)"),
            ("", "! watch requires at least 1 arguments, 0 given"),
            ("-n 5 a", "! watch: -n '5': it is a time from 1ms, such as 200ms"),
            ("-n 5us a", "! watch: -n '5us': it is a time from 1ms, such as 200ms"),
            ("--count 0 a", "! watch: --count '0': it is a number from 1"),
            ("-x a", "! watch: invalid option -- 'x'"),
        ] {
            assert_eq!(shown(line), want, "{line}");
        }
        assert_eq!(seconds(61_000_000_001), "61.000000001");
    }
}
