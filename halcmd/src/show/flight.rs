//! The command `flight`: control of the flight recorder, and its state as text.

use crate::{Error, Session, language::command::Flight, language::units};
use hal_protocol::{Failure, FlightInfo, KeptInfo, KeptState, Reply, Request};
use std::fmt::Write;

/// The code of a failure that says that a file could not be written.
const EIO: i32 = -5;

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
            KeptState::InMemory => "no longer in memory: replaced by a later event".to_owned(),
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
    use super::{size, text};
    use hal_protocol::{FlightInfo, KeptInfo, KeptState};

    #[test]
    fn sizes_have_units() {
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
             \x20 1  at 1 ms  a  no longer in memory: replaced by a later event\n\
             \x20 2  at 2 ms  b  in memory: 'flight save FILE.vcd last'\n\
             \x20 2  at 2 ms  asked for  /x.vcd\n\
             \x20 3  at 3 ms  c  what comes after it is awaited\n";
        assert_eq!(text(&info), want);
    }
}
