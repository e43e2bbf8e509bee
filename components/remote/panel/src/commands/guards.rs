//! Changes of the wiring: what guards against remote motion is not changed from afar.

use super::{Args, Input};
use crate::error::{Code, Error};
use hal_protocol::{Direction, ItemInfo, Request};

/// Pins of motion, the task and a robot that the dead man acts on or looks at.
const STOPS: &[&str] = &[
    "motion.jog-stop",
    "motion.feed-inhibit",
    "task.abort",
    "task.job",
    "robot.hold",
    "robot.stop",
    "robot.busy",
    "robot.enable",
];

/// Pins that begin a run.
const RUNS: &[&str] = &["robot.run", "robot.resume"];

/// Returns the signal that a command writes or links, by its argument.
pub(crate) fn signal_of<'a>(name: &str, args: &'a Args) -> Option<&'a str> {
    let argument = match name {
        "sets" => "name",
        "net" | "linkp" => "signal",
        _ => return None,
    };
    args.get(argument)?.as_str()
}

/// Refuses a signal that one of these pins reads to learn whether remote motion is permitted, or must stop.
pub(crate) fn guard_signal(signal: &str, pins: &[ItemInfo]) -> Result<(), Error> {
    let reads = |pin: &&ItemInfo| {
        pin.signal.as_deref() == Some(signal)
            && pin.direction != Direction::Out
            && guard(&pin.name).is_err()
    };
    match pins.iter().find(reads) {
        None => Ok(()),
        Some(pin) => {
            let text =
                format!("signal {signal} leads to {}: it is not changed from afar", pin.name);
            Err(Error::new(Code::Remote, text))
        }
    }
}

/// Refuses changes of the pins that stop remote motion: no client rewires what guards against it.
fn guard(name: &str) -> Result<(), Error> {
    let guarded = name.starts_with("remote.") || name.starts_with("halpanel.");
    if guarded || STOPS.contains(&name) {
        let text = format!("{name} stops remote motion: it is not changed from afar");
        return Err(Error::new(Code::Remote, text));
    }
    if RUNS.contains(&name) {
        let text = format!("{name} begins a run past the lease: it is not changed from afar");
        return Err(Error::new(Code::Remote, text));
    }
    Ok(())
}

pub(super) fn setp(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["name", "value"])?;
    guard(&given.needed("name")?)?;
    Ok(vec![Request::Set { name: given.needed("name")?, value: given.needed("value")? }])
}

pub(super) fn sets(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["name", "value"])?;
    Ok(vec![Request::SetSignal { name: given.needed("name")?, value: given.needed("value")? }])
}

pub(super) fn net(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["signal", "pins"])?;
    let pins: Vec<String> = given.needed("pins")?.split_whitespace().map(str::to_owned).collect();
    pins.iter().try_for_each(|pin| guard(pin))?;
    Ok(vec![Request::Net { signal: given.needed("signal")?, pins }])
}

pub(super) fn linkp(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["pin", "signal"])?;
    guard(&given.needed("pin")?)?;
    Ok(vec![Request::Link { pin: given.needed("pin")?, signal: given.needed("signal")? }])
}

pub(super) fn unlink(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["pin"])?;
    guard(&given.needed("pin")?)?;
    Ok(vec![Request::Unlink { pin: given.needed("pin")? }])
}
