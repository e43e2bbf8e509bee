//! The program `hal_manualtoolchange`: asks a person to change the tool.

use crate::{
    Stdio, Terminal,
    programs::options::{Opt, from_environment, options, plain, program_usage},
    session::remote::{Remote, instance_option},
    terminal::ended,
    terminal::termination::leave_on_signals,
};
use hal_protocol::{Direction, Failure, Link, Place, Reply, Request, Type, Value};
use std::{process::ExitCode, sync::mpsc};

pub(crate) const NAME: &str = "hal_manualtoolchange";
/// Interval between two polls of its pins, in nanoseconds of machine time.
const POLL_NS: u64 = 100_000_000;

/// Pins, in the order of their values.
const PINS: [(&str, Type, Direction); 4] = [
    ("hal_manualtoolchange.number", Type::S32, Direction::In),
    ("hal_manualtoolchange.change", Type::Bit, Direction::In),
    ("hal_manualtoolchange.change_button", Type::Bit, Direction::In),
    ("hal_manualtoolchange.changed", Type::Bit, Direction::Out),
];
const CHANGED: u32 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Instance,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
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
    ended(run(words).map_err(|text| format!("{NAME}: {text}")))
}

fn run(words: &[String]) -> Result<(), String> {
    let (mut given, _) = options(NAME, OPTIONS, words).map_err(|e| e.to_string())?;
    from_environment(OPTIONS, &|name| std::env::var(name).ok(), &mut given);
    if given.iter().any(|(id, _)| *id == Id::Help) {
        Stdio.out(&format!("Usage: {NAME} [options]\n\noptions:\n{}", program_usage(OPTIONS)))?;
        return Ok(());
    }
    let instance = given.iter().rev().find(|(id, _)| *id == Id::Instance);
    let place = Place::find(instance.and_then(|(_, value)| value.as_deref()))?;
    leave_on_signals(0);
    let mut remote = Remote::new(place, "");
    join(&mut remote).map_err(|f| f.to_string())?;
    let person = rustix::termios::isatty(std::io::stdin());
    let presses = if person { lines_of_input() } else { mpsc::channel().1 };
    let mut dialog = Dialog::new(person);
    let mut writes = Vec::new();
    loop {
        let reply = remote.call(Request::Poll { writes: core::mem::take(&mut writes) });
        // The engine is gone, so this program ends too.
        let Ok(Reply::Values { values, .. }) = reply else { return Ok(()) };
        let pressed = presses.try_iter().count() > 0;
        let (answer, text) = dialog.poll(&values, pressed);
        if let Some(text) = text {
            Stdio.err(&format!("{text}\n"));
        }
        if let Some(changed) = answer {
            writes.push((CHANGED, Value::Bit(changed)));
        }
    }
}

/// Creates the component with all its pins.
pub(crate) fn join(remote: &mut dyn Link) -> Result<(), Failure> {
    remote.call(Request::Join { name: NAME.to_owned(), poll_ns: POLL_NS })?;
    for (name, ty, direction) in PINS {
        remote.call(Request::NewPin { name: name.to_owned(), ty, direction })?;
    }
    remote.call(Request::Ready)?;
    Ok(())
}

/// Returns a channel that receives a message for each line that the user enters.
fn lines_of_input() -> mpsc::Receiver<()> {
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lines() {
            if line.is_err() || sender.send(()).is_err() {
                break;
            }
        }
    });
    receiver
}

/// State of the dialog with the person and with the machine.
#[derive(Debug)]
struct Dialog {
    person: bool,
    asked: Option<i32>,
    changed: bool,
}

impl Dialog {
    const fn new(person: bool) -> Self {
        Self { person, asked: None, changed: false }
    }

    /// Evaluates the pins. Returns the new value of `changed` and the message to print.
    fn poll(&mut self, values: &[Value], pressed: bool) -> (Option<bool>, Option<String>) {
        let bit = |i: usize| matches!(values.get(i), Some(Value::Bit(true)));
        let number = if let Some(Value::S32(n)) = values.first() { *n } else { 0 };
        let (change, button) = (bit(1), bit(2));
        if !change {
            let withdrawn = self.asked.take().filter(|_| !self.changed);
            let answer = core::mem::take(&mut self.changed).then_some(false);
            return (answer, withdrawn.map(|_| "The tool change was called off.".to_owned()));
        }
        if self.changed {
            return (None, None);
        }
        // A line entered before the question does not answer it.
        if button || (pressed && self.asked == Some(number)) {
            self.asked = Some(number);
            self.changed = true;
            return (Some(true), None);
        }
        if self.asked == Some(number) {
            return (None, None);
        }
        self.asked = Some(number);
        let what = match number {
            0 => "Remove the tool".to_owned(),
            n => format!("Insert tool {n}"),
        };
        let how = if self.person {
            "and press Enter."
        } else {
            "and set hal_manualtoolchange.change_button."
        };
        (None, Some(format!("{what} {how}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_person_is_asked_once_and_the_machine_told_once() {
        let mut dialog = Dialog::new(true);
        // number, change, button, Enter: new value of `changed`, message
        for (number, change, button, pressed, answer, text) in [
            (0, false, false, true, None, None),
            (5, true, false, true, None, Some("Insert tool 5 and press Enter.")),
            (5, true, false, false, None, None),
            (5, true, false, true, Some(true), None),
            (5, true, false, true, None, None),
            (5, false, false, false, Some(false), None),
            (0, true, false, false, None, Some("Remove the tool and press Enter.")),
            (0, false, false, false, None, Some("The tool change was called off.")),
            (7, true, true, false, Some(true), None),
            (7, false, true, false, Some(false), None),
        ] {
            let values =
                [Value::S32(number), Value::Bit(change), Value::Bit(button), Value::Bit(false)];
            let got = dialog.poll(&values, pressed);
            assert_eq!(got, (answer, text.map(str::to_owned)), "{number} {change} {button}");
        }
    }

    #[test]
    fn without_a_person_the_button_is_named() {
        let values = [Value::S32(3), Value::Bit(true), Value::Bit(false), Value::Bit(false)];
        let (_, text) = Dialog::new(false).poll(&values, false);
        assert_eq!(
            text.as_deref(),
            Some("Insert tool 3 and set hal_manualtoolchange.change_button.")
        );
    }
}
