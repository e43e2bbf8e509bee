//! Changes that a test makes to a machine from outside: ramps and faults.

use super::{
    bench::Bench,
    outcome::Complaint,
    step::Ramp,
    test::{Entry, Named},
};
use hal_protocol::{Direction, Failure, ItemInfo, Kind, Link, Reply, Request, SignalInfo, Value};

/// Failure code for a name that does not exist.
pub(super) const ENOENT: i32 = -2;

/// A value that follows a ramp.
#[derive(Debug)]
pub(super) struct Ramping {
    name: String,
    begun: i64,
    from: f64,
    to: f64,
    over: i64,
}

impl Ramping {
    /// Begins a ramp. It replaces a ramp of the same name.
    pub(super) fn begin(bench: &mut Bench, ramp: &Ramp) -> Result<(), Complaint> {
        let now = value(bench, &ramp.what)?;
        let begun = bench.now();
        let from = ramp.from.unwrap_or_else(|| number(now));
        let over = i64::try_from(ramp.over).unwrap_or(i64::MAX);
        bench.ramps.retain(|r| r.name != ramp.what.name);
        let name = ramp.what.name.clone();
        bench.ramps.push(Self { name, begun, from, to: ramp.to, over });
        set(bench, &ramp.what, &written(now, from))
    }

    /// Sets every ramped value for the present time.
    pub(super) fn take_effect(bench: &mut Bench) -> Result<(), Failure> {
        let now = bench.now();
        for ramp in core::mem::take(&mut bench.ramps) {
            let done = now.saturating_sub(ramp.begun);
            let value = if done >= ramp.over {
                ramp.to
            } else {
                ramp.from + (ramp.to - ramp.from) * (done as f64 / ramp.over as f64)
            };
            let old = bench.get(&ramp.name)?;
            store(bench, &ramp.name, &written(old, value))?;
            if done < ramp.over {
                bench.ramps.push(ramp);
            }
        }
        Ok(())
    }
}

/// Pins that a test has disconnected from their signals.
#[derive(Debug, Default)]
pub(super) struct Faults {
    held: Vec<Held>,
    drops: Vec<Drop>,
}

/// A pin that is disconnected from its signal.
#[derive(Debug)]
struct Held {
    /// Name that the test used.
    name: String,
    pin: String,
    signal: String,
}

/// Pulses that do not reach their readers.
#[derive(Debug)]
struct Drop {
    name: String,
    signal: String,
    left: u32,
    /// True while the readers are disconnected from their signal.
    is_cut: bool,
    was_high: bool,
}

/// The signal that a name refers to, and the pins that read it.
struct Target {
    /// The signal, if there is one.
    signal: Option<String>,
    /// The pins that read the signal and that the name selects.
    readers: Vec<String>,
}

impl Faults {
    /// Returns whether every cycle must be examined.
    pub(super) const fn is_looking(&self) -> bool {
        !self.drops.is_empty()
    }

    /// Makes the readers of a name see another value from now on.
    pub(super) fn force(bench: &mut Bench, entry: &Entry) -> Result<(), Complaint> {
        let named = Named { spot: entry.spot.clone(), name: entry.name.clone() };
        let held = cut(bench, &named)?;
        let text = super::step::text_of(&entry.value);
        held.iter()
            .try_for_each(|pin| set(bench, &Named { name: pin.clone(), ..named.clone() }, &text))
    }

    /// Makes the readers of a name keep seeing its present value.
    pub(super) fn stick(bench: &mut Bench, named: &Named) -> Result<(), Complaint> {
        let now = exact(value(bench, named)?);
        let held = cut(bench, named)?;
        held.iter()
            .try_for_each(|pin| set(bench, &Named { name: pin.clone(), ..named.clone() }, &now))
    }

    /// Disconnects a pin from its signal.
    pub(super) fn unlink(bench: &mut Bench, named: &Named) -> Result<(), Complaint> {
        let target = target(bench, named)?;
        let Some(signal) = target.signal else {
            let text = format!("'{}' is not linked", named.name);
            return Err(Complaint::new(&named.spot, text));
        };
        take_off(bench, named, &named.name, &signal)
    }

    /// Keeps the next pulses of a signal from its readers.
    pub(super) fn drop(bench: &mut Bench, named: &Named, pulses: u32) -> Result<(), Complaint> {
        let Value::Bit(_) = value(bench, named)? else {
            let text = format!("'{}' is not a bit: it has no pulses", named.name);
            return Err(Complaint::new(&named.spot, text));
        };
        let target = target(bench, named)?;
        let (Some(signal), false) = (target.signal, target.readers.is_empty()) else {
            let text = format!("nothing that reads '{}' is linked to a signal", named.name);
            return Err(Complaint::new(&named.spot, text));
        };
        let name = named.name.clone();
        let drop = Drop { name, signal, left: pulses, is_cut: false, was_high: false };
        bench.faults.drops.push(drop);
        Self::look(bench).map_err(|f| refused(named, &f))
    }

    /// Restores what was forced, stuck, unlinked or dropped under this name.
    pub(super) fn release(bench: &mut Bench, named: &Named) -> Result<(), Complaint> {
        let drops = bench.faults.drops.len();
        bench.faults.drops.retain(|d| d.name != named.name);
        let all = core::mem::take(&mut bench.faults.held);
        let (held, rest): (Vec<_>, Vec<_>) = all.into_iter().partition(|h| h.name == named.name);
        bench.faults.held = rest;
        if held.is_empty() && drops == bench.faults.drops.len() {
            let text = format!("'{}' is not forced, stuck or unlinked", named.name);
            return Err(Complaint::new(&named.spot, text));
        }
        held.into_iter().try_for_each(|h| relink(bench, h).map_err(|f| refused(named, &f)))
    }

    /// Counts dropped pulses, after a cycle.
    pub(super) fn look(bench: &mut Bench) -> Result<(), Failure> {
        if bench.faults.drops.is_empty() {
            return Ok(());
        }
        for mut drop in core::mem::take(&mut bench.faults.drops) {
            let high = match bench.ask(Request::GetSignal { name: drop.signal.clone() })? {
                Reply::Value(value) => value == Value::Bit(true),
                _ => false,
            };
            if drop.is_cut && drop.was_high && !high {
                drop.left -= 1;
            }
            drop.was_high = high;
            if drop.left == 0 {
                let all = core::mem::take(&mut bench.faults.held);
                let (held, rest): (Vec<_>, Vec<_>) =
                    all.into_iter().partition(|h| h.name == drop.name);
                bench.faults.held = rest;
                held.into_iter().try_for_each(|h| relink(bench, h))?;
                continue;
            }
            // A pulse that has begun passes.
            if !drop.is_cut && !high {
                let pins = match signal(bench, &drop.signal)? {
                    Some(info) => meant(&info, &drop.name),
                    None => Vec::new(),
                };
                for pin in pins {
                    bench.ask(Request::Unlink { pin: pin.clone() })?;
                    bench.ask(Request::Set { name: pin.clone(), value: "0".to_owned() })?;
                    let (name, signal) = (drop.name.clone(), drop.signal.clone());
                    bench.faults.held.push(Held { name, pin, signal });
                }
                drop.is_cut = true;
            }
            bench.faults.drops.push(drop);
        }
        Ok(())
    }
}

/// Sets a pin, a parameter or a signal.
pub(super) fn set(bench: &mut Bench, named: &Named, text: &str) -> Result<(), Complaint> {
    store(bench, &named.name, text).map_err(|failure| {
        let complaint = refused(named, &failure);
        // A linked pin cannot be set.
        if failure.hint.as_ref().is_some_and(|h| h.contains("linked")) {
            complaint.with("to have its readers see another value, use 'force'")
        } else {
            complaint
        }
    })
}

/// Returns the value of a pin, a parameter or a signal.
pub(super) fn value(bench: &mut Bench, named: &Named) -> Result<Value, Complaint> {
    bench.get(&named.name).map_err(|failure| refused(named, &failure))
}

/// Converts a value to a number: a bit is 0 or 1.
pub(super) const fn number(value: Value) -> f64 {
    match value {
        Value::Bit(b) => b as u8 as f64,
        Value::Float(f) => f,
        Value::S32(i) => i as f64,
        Value::U32(u) => u as f64,
        Value::S64(i) => i as f64,
        Value::U64(u) | Value::Port(u) => u as f64,
    }
}

/// Writes a value for a script, without loss of precision.
fn exact(value: Value) -> String {
    match value {
        Value::Float(f) if f.is_finite() => format!("{f:e}"),
        other => other.to_string(),
    }
}

/// Converts a failure of the engine to a complaint.
pub(super) fn refused(named: &Named, failure: &Failure) -> Complaint {
    let text = if failure.code == ENOENT {
        format!("there is no pin, parameter or signal '{}'", named.name)
    } else {
        failure.text.clone()
    };
    let complaint = Complaint::new(&named.spot, text);
    match &failure.hint {
        Some(hint) => complaint.with(hint.clone()),
        None => complaint,
    }
}

/// Writes a number for a pin of this type.
fn written(like: Value, number: f64) -> String {
    match like {
        Value::Float(_) => format!("{number:e}"),
        Value::Bit(_) => u8::from(number >= 0.5).to_string(),
        _ => format!("{:.0}", number.round()),
    }
}

fn store(bench: &mut Bench, name: &str, text: &str) -> Result<(), Failure> {
    bench.get(name)?;
    let (name, value) = (name.to_owned(), text.to_owned());
    let request = if bench.ask(Request::Get { name: name.clone() }).is_err() {
        Request::SetSignal { name, value }
    } else {
        Request::Set { name, value }
    };
    bench.call(request).map(|_| ())
}

/// Disconnects the readers of a name from their signal. Returns the pins whose own values apply
/// from now on.
fn cut(bench: &mut Bench, named: &Named) -> Result<Vec<String>, Complaint> {
    // The name is forced again, or a value is set for a name that is already cut.
    let again: Vec<String> =
        bench.faults.held.iter().filter(|h| h.name == named.name).map(|h| h.pin.clone()).collect();
    if !again.is_empty() {
        return Ok(again);
    }
    let target = target(bench, named)?;
    let Some(signal) = target.signal else { return Ok(vec![named.name.clone()]) };
    if target.readers.is_empty() {
        let text = format!("nothing reads '{}': to force it would change nothing", named.name);
        return Err(Complaint::new(&named.spot, text));
    }
    for pin in &target.readers {
        take_off(bench, named, pin, &signal)?;
    }
    Ok(target.readers)
}

fn take_off(bench: &mut Bench, named: &Named, pin: &str, signal: &str) -> Result<(), Complaint> {
    let request = Request::Unlink { pin: pin.to_owned() };
    bench.ask(request).map_err(|f| refused(named, &f))?;
    let (pin, signal) = (pin.to_owned(), signal.to_owned());
    bench.faults.held.push(Held { name: named.name.clone(), pin, signal });
    Ok(())
}

/// Links a pin to its signal again. A signal without other pins would take the pin's value, so the
/// signal's value is restored.
fn relink(bench: &mut Bench, held: Held) -> Result<(), Failure> {
    let Held { pin, signal, .. } = held;
    let Reply::Value(before) = bench.ask(Request::GetSignal { name: signal.clone() })? else {
        return Ok(());
    };
    bench.ask(Request::Link { pin, signal: signal.clone() })?;
    let after = bench.ask(Request::GetSignal { name: signal.clone() })?;
    if after != Reply::Value(before) {
        bench.ask(Request::SetSignal { name: signal, value: exact(before) })?;
    }
    Ok(())
}

/// Resolves a name.
fn target(bench: &mut Bench, named: &Named) -> Result<Target, Complaint> {
    let wrong = |f: Failure| refused(named, &f);
    let name = &named.name;
    if let Some(item) = item(bench, name).map_err(wrong)? {
        let Some(linked) = item.signal else {
            if item.direction == Direction::Out {
                let text = format!("'{name}' is written by its component, and nothing reads it");
                return Err(Complaint::new(&named.spot, text));
            }
            return Ok(Target { signal: None, readers: Vec::new() });
        };
        let info = signal(bench, &linked).map_err(wrong)?;
        let readers = info.map(|info| meant(&info, name)).unwrap_or_default();
        return Ok(Target { signal: Some(linked), readers });
    }
    match signal(bench, name).map_err(wrong)? {
        Some(info) => Ok(Target { readers: meant(&info, name), signal: Some(info.name) }),
        // The engine knows the nearest name.
        None => value(bench, named).map(|_| Target { signal: None, readers: Vec::new() }),
    }
}

/// Returns the reading pins of a signal that a name selects: the one with this name, or all of
/// them.
fn meant(info: &SignalInfo, name: &str) -> Vec<String> {
    let readers = info.pins.iter().filter(|(d, _)| *d != Direction::Out);
    let all: Vec<String> = readers.map(|(_, pin)| pin.clone()).collect();
    if all.iter().any(|pin| pin == name) { vec![name.to_owned()] } else { all }
}

/// Returns the pin or parameter with this name.
fn item(bench: &mut Bench, name: &str) -> Result<Option<ItemInfo>, Failure> {
    for kind in [Kind::Pins, Kind::Params] {
        let list = Request::List { kind, patterns: vec![name.to_owned()], ty: None };
        if let Reply::Items(items) = bench.ask(list)? {
            let own = |i: &ItemInfo| i.name == name || i.original.as_deref() == Some(name);
            if let Some(item) = items.into_iter().find(own) {
                return Ok(Some(item));
            }
        }
    }
    Ok(None)
}

/// Returns the signal with this name.
fn signal(bench: &mut Bench, name: &str) -> Result<Option<SignalInfo>, Failure> {
    let patterns = vec![name.to_owned()];
    let list = Request::List { kind: Kind::Signals, patterns, ty: None };
    match bench.ask(list)? {
        Reply::Signals(list) => Ok(list.into_iter().find(|s| s.name == name)),
        _ => Ok(None),
    }
}
