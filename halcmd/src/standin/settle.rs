//! The values of stand-ins and of simulated ports when the machine's files have been executed.

use super::{
    StandIns,
    healthy::{self, Driver, Want},
    infer::{Pin, RPS},
    reach,
    wires::Wires,
};
use crate::Error;
use hal_protocol::{Direction, Link, Request, Type, Value};
use std::collections::{BTreeMap, BTreeSet};

/// The component of stand-ins.
const OWNER: &str = "standin";
/// Beginning of the inputs that determine its outputs.
const SIM: &str = "standin.sim.";

/// Ends of the names of outputs that are TRUE while hardware works.
const WORKING: &[&str] = &[
    "link-up",
    "all-op",
    "state-op",
    "slave-online",
    "slave-oper",
    "slave-state-op",
    "online",
    "oper",
    "ready",
    "at-speed",
    "is-connected",
    "connected",
    "hardware-ok",
    "remora-status",
    "PRU-reset-ok",
];

/// Inputs of a simulated parallel port: pin, register, bit, and whether the bit is the opposite of the line.
const LINES: [(u8, &str, u8, bool); 17] = [
    (10, "status", 6, false),
    (11, "status", 7, true),
    (12, "status", 5, false),
    (13, "status", 4, false),
    (15, "status", 3, false),
    (2, "data", 0, false),
    (3, "data", 1, false),
    (4, "data", 2, false),
    (5, "data", 3, false),
    (6, "data", 4, false),
    (7, "data", 5, false),
    (8, "data", 6, false),
    (9, "data", 7, false),
    (1, "control", 0, true),
    (14, "control", 1, true),
    (16, "control", 2, false),
    (17, "control", 3, true),
];

/// Signals that pins without one have got; `None` while lines may still link those.
type Made = Option<BTreeMap<String, String>>;

/// Returns the simulated bit of an input of a parallel port, of a card or of a GPIO chip, and whether it is the opposite of the
/// pin.
fn line(wires: &Wires, pin: &str) -> Option<(String, bool)> {
    port_line(wires, pin).or_else(|| card_line(wires, pin)).or_else(|| gpio_line(wires, pin))
}

/// Components that drive GPIO lines.
const GPIO: [&str; 2] = ["hal_gpio", "hal_pi_gpio"];

/// Returns the simulated level of a GPIO line, and whether it is the opposite of the pin: `hal_gpio.GPIO5-in-not` shows the
/// opposite of `hal_gpio.sim.GPIO5`, and of a line of `activelow` the level itself.
pub(super) fn gpio_line(wires: &Wires, pin: &str) -> Option<(String, bool)> {
    let wired = wires.pins.get(pin).filter(|wired| GPIO.contains(&wired.owner.as_str()))?;
    let name = pin.strip_prefix(&wired.owner)?.strip_prefix('.')?;
    let (name, not) = match name.strip_suffix("-in-not") {
        Some(name) => (name, true),
        None => (name.strip_suffix("-in")?, false),
    };
    // The engine keeps the words of the line, with their quotes.
    let args = wires.args.get(&wired.owner).map(|args| args.replace('"', "")).unwrap_or_default();
    let lists = args.split_whitespace().filter_map(|arg| arg.strip_prefix("activelow="));
    let is_low = lists.flat_map(|list| list.split(',')).any(|line| line == name);
    let sim = format!("{}.sim.{name}", wired.owner);
    let is_free = wires.pins.get(&sim).is_some_and(|pin| {
        pin.direction == Direction::In && pin.signal.is_none() && pin.value == Value::Bit(false)
    });
    (wired.direction == Direction::Out && is_free).then_some((sim, not ^ is_low))
}

/// Component that drives Mesa's cards.
const CARDS: &str = "hm2_eth";

/// Returns the simulated input of a Mesa card, and whether it is the opposite of the pin: `hm2_7i92.0.gpio.010.in_not` shows
/// the opposite of `hm2_7i92.0.sim.in-010`, `hm2_7i96s.0.inm.00.input-03` shows `hm2_7i96s.0.sim.inm.00.in-03`.
fn card_line(wires: &Wires, pin: &str) -> Option<(String, bool)> {
    let wired = wires.pins.get(pin).filter(|wired| wired.owner == CARDS)?;
    let mut parts = pin.splitn(3, '.');
    let (card, number, rest) = (parts.next()?, parts.next()?, parts.next()?);
    let (sim, not) = match rest.strip_prefix("gpio.") {
        Some(gpio) => {
            let (io, end) = gpio.split_once('.')?;
            (format!("in-{io}"), end == "in_not")
        }
        None => {
            let (bank, input) = rest.rsplit_once('.')?;
            let input = input.strip_prefix("raw-").unwrap_or(input).strip_prefix("input-")?;
            let (input, not) = input.strip_suffix("-not").map_or((input, false), |n| (n, true));
            // The inputs of a remote keep their names.
            let name = if bank.starts_with("7i") { "input" } else { "in" };
            (format!("{bank}.{name}-{input}"), not)
        }
    };
    let sim = format!("{card}.{number}.sim.{sim}");
    // Free I/O pins are pulled up.
    let at_rest = rest.starts_with("gpio.");
    let is_free = wires.pins.get(&sim).is_some_and(|pin| {
        pin.direction == Direction::In && pin.signal.is_none() && pin.value == Value::Bit(at_rest)
    });
    (wired.direction == Direction::Out && is_free).then_some((sim, not))
}

/// Returns the place of the simulated encoder whose position a pin shows, if nobody turns that: it may follow the axis that
/// it measures.
fn card_place(wires: &Wires, pin: &str) -> Option<String> {
    let wired = wires.pins.get(pin).filter(|wired| wired.owner == CARDS)?;
    let (card, encoder) = pin.strip_suffix(".position")?.split_once(".encoder.")?;
    let sim = |name: &str| format!("{card}.sim.encoder.{encoder}.{name}");
    let is_free = |name: &str| {
        wires.pins.get(&sim(name)).is_some_and(|pin| {
            let zero = matches!(pin.value, Value::S32(0) | Value::Float(0.0));
            pin.signal.is_none() && zero
        })
    };
    let free = wired.direction == Direction::Out && is_free("counts") && is_free("position");
    free.then(|| sim("position"))
}

/// Returns the simulated bit of a parallel port's input, and whether it is the opposite of the pin.
fn port_line(wires: &Wires, pin: &str) -> Option<(String, bool)> {
    let wired = wires.pins.get(pin).filter(|wired| wired.owner == "hal_parport")?;
    let (port, end) = pin.rsplit_once(".pin-")?;
    let (number, not) = match end.strip_suffix("-in-not") {
        Some(number) => (number, true),
        None => (end.strip_suffix("-in")?, false),
    };
    let number: u8 = number.parse().ok().filter(|_| wired.direction == Direction::Out)?;
    let (_, register, bit, opposite) = LINES.iter().find(|line| line.0 == number)?;
    let (word, bit) = (format!("{port}.sim.{register}"), format!("{port}.sim.{register}-{bit}"));
    // A person or a script has set or linked it.
    let is_free = |name: &str| {
        wires.pins.get(name).is_some_and(|pin| {
            let zero = matches!(pin.value, Value::Bit(false) | Value::U32(0));
            pin.direction == Direction::In && pin.signal.is_none() && zero
        })
    };
    let whole = !wires.pins.get(&word).is_some_and(|pin| pin.direction == Direction::In);
    (is_free(&bit) && (whole || is_free(&word))).then_some((bit, opposite ^ not))
}

impl StandIns {
    /// Sets the values of a machine at rest: of the stand-ins, and if wanted of the inputs of simulated ports and cards
    /// that nobody has set. Only with `last` real pins get new signals, since lines may still link them. Returns the joints that no
    /// switch can home.
    ///
    /// # Errors
    /// On the real clock, motion depends on a stand-in. A value is refused.
    pub(crate) fn settle(&self, link: &mut dyn Link, last: bool) -> Result<BTreeSet<u32>, Error> {
        // Homes are asked for once, before motion gets its data.
        let homes = self.start.homes && !last;
        if self.inferred.pins.is_empty() && !self.start.ports && !homes {
            return Ok(BTreeSet::new());
        }
        let wires = Wires::of(link);
        let is_ours = |pin: &str| {
            wires.pins.get(pin).is_some_and(|p| p.owner == OWNER && p.direction == Direction::Out)
        };
        if !self.start.simulated {
            let names = self.inferred.pins.iter().filter(|pin| pin.dir == Direction::Out);
            let outputs = names.map(|pin| pin.name.as_str());
            return match reach::depended(&wires, outputs) {
                Some((stand_in, pin)) => {
                    Err(Error::StandinUsed { stand_in: stand_in.into(), pin: pin.into() })
                }
                None => Ok(BTreeSet::new()),
            };
        }
        let is_simulated =
            |pin: &str| line(&wires, pin).is_some() || card_place(&wires, pin).is_some();
        let is_source = |pin: &str| is_ours(pin) || self.start.ports && is_simulated(pin);
        let mut made: Made = last.then(BTreeMap::new);
        let wants = healthy::wants(&wires, &is_source);
        for (pin, want) in &wants {
            if let (Some(sim), Want::As(other)) = (card_place(&wires, pin), want) {
                follow(link, &wires, &sim, other, &mut made)?;
                continue;
            }
            match line(&wires, pin).filter(|_| !is_ours(pin)) {
                Some((bit, opposite)) => {
                    if let Want::Bit(value) = want {
                        set(link, &wires, &bit, *value ^ opposite)?;
                    }
                }
                None => self.give(link, &wires, pin, want, &mut made)?,
            }
        }
        let free = |pin: &&Pin| pin.is_plain_bit() && !wants.contains_key(&pin.name);
        for pin in self.inferred.pins.iter().filter(free) {
            let end = pin.name.rsplit('.').next().unwrap_or_default();
            if WORKING.iter().any(|word| end == *word || end.ends_with(&format!("-{word}"))) {
                set(link, &wires, &format!("{SIM}{}", pin.name), true)?;
            }
        }
        for pin in &self.inferred.pins {
            if let Some(spindle) = pin.name.strip_prefix(RPS) {
                let from = format!("spindle.{spindle}.speed-out-rps");
                follow(link, &wires, &pin.name, &from, &mut made)?;
            }
        }
        Ok(if homes { unswitched(&wires, &is_source) } else { BTreeSet::new() })
    }

    /// Gives an output of a stand-in its value.
    fn give(
        &self,
        link: &mut dyn Link,
        wires: &Wires,
        pin: &str,
        want: &Want,
        made: &mut Made,
    ) -> Result<(), Error> {
        if self.inferred.pins.iter().any(|own| own.name == pin && own.has_rule()) {
            return Ok(());
        }
        let sim = format!("{SIM}{pin}");
        match (want, wires.type_of(pin)) {
            (Want::Bit(value), Some(Type::Bit)) => set(link, wires, &sim, *value),
            (Want::As(other), ty) if ty == wires.type_of(other) => {
                // Of two values that should be near each other, one is not ours.
                let writer = wires.signal_of(other).and_then(|signal| wires.writer(signal));
                let is_itself = writer == Some(pin);
                if is_itself { Ok(()) } else { follow(link, wires, &sim, other, made) }
            }
            _ => Ok(()),
        }
    }
}

/// Sets an input that is not linked.
fn set(link: &mut dyn Link, wires: &Wires, name: &str, value: bool) -> Result<(), Error> {
    if wires.signal_of(name).is_some() {
        return Ok(());
    }
    let value = if value { "TRUE" } else { "FALSE" }.to_owned();
    link.call(Request::Set { name: name.to_owned(), value })?;
    Ok(())
}

/// Links an input to the signal of another pin. If that has none, it gets one, which `made` then has.
fn follow(
    link: &mut dyn Link,
    wires: &Wires,
    pin: &str,
    other: &str,
    made: &mut Made,
) -> Result<(), Error> {
    if !wires.pins.contains_key(other) || wires.signal_of(pin).is_some() {
        return Ok(());
    }
    let (signal, pins) = match wires.signal_of(other) {
        Some(signal) => (signal.to_owned(), vec![pin.to_owned()]),
        None => {
            let Some(made) = made else { return Ok(()) };
            let next = format!("standin-{}", made.len() + 1);
            let signal = made.entry(other.to_owned()).or_insert(next).clone();
            (signal, vec![other.to_owned(), pin.to_owned()])
        }
    };
    link.call(Request::Net { signal, pins })?;
    Ok(())
}

/// Returns the joints whose home switches nobody writes.
fn unswitched(wires: &Wires, is_source: &dyn Fn(&str) -> bool) -> BTreeSet<u32> {
    let switches = wires.pins.keys().filter_map(|name| {
        let joint = name.strip_prefix("joint.")?.strip_suffix(".home-sw-in")?;
        Some((joint.parse().ok()?, name))
    });
    let nobody = |name: &str| healthy::driver(wires, is_source, name) < Driver::Somebody;
    switches.filter(|(_, name)| nobody(name)).map(|(joint, _)| joint).collect()
}
