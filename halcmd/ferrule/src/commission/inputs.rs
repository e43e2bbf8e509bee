//! Steps in which nothing moves: the e-stop, and the switches.

use super::{
    Stopped, fault,
    machine::{CHAIN, SlowMachine},
    person::Person,
};
use crate::failure::Failure;
use std::collections::BTreeMap;

/// Time in which an input settles, in seconds.
const SETTLE: f64 = 0.3;
/// Looks at the inputs while a switch is held, and the time between two of them in seconds.
const LOOKS: u32 = 60;
const BETWEEN: f64 = 0.005;

/// The e-stop: it can be left, it is seen, and its end starts nothing.
pub(crate) fn estop(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let chain = machine.wires()?.of(CHAIN);
    person.enter("estop: pull the e-stop button out")?;
    reset(machine)?;
    if !machine.is(CHAIN)? {
        return Err(fault(
            "the e-stop chain stays open with the button out",
            format!(
                "look at the wires of the chain and the reset of its latch; an input of the wrong sense is read as pin-NN-in-not: {chain}"
            ),
        ));
    }
    person.enter("estop: press the e-stop button and leave it pressed")?;
    machine.pass(SETTLE)?;
    if machine.is(CHAIN)? {
        return Err(fault(
            "the e-stop button is pressed, and the controller does not see it",
            format!("wire its input to the chain; do not run this machine before: {chain}"),
        ));
    }
    // Pressed, it cannot be left.
    reset(machine)?;
    if machine.is(CHAIN)? {
        return Err(fault(
            "the e-stop is reset although the button is pressed",
            format!(
                "the chain must go through the button: wire it in series with the reset: {chain}"
            ),
        ));
    }
    person.enter("estop: pull it out again")?;
    machine.pass(SETTLE)?;
    if machine.is(CHAIN)? {
        return Err(fault(
            "the e-stop ends by itself when the button is pulled out",
            format!("put an estop_latch into the chain, so that only a reset ends it: {chain}"),
        ));
    }
    Ok("pressed, seen, and held until its reset".to_owned())
}

/// Asks iocontrol to leave the e-stop; whether it does is seen at the chain.
pub(crate) fn reset(machine: &mut SlowMachine) -> Result<(), Stopped> {
    match machine.order("iocontrol.estop-reset", &[]) {
        Ok(()) | Err(Stopped::Aborted(_)) => machine.pass(SETTLE),
        Err(other) => Err(other),
    }
}

/// A signal of switches, and what they are.
#[derive(Clone)]
struct Switch {
    /// A pin that reads it.
    pin: String,
    label: String,
    /// The pin with its signal and writer.
    wire: String,
}

/// Returns the switches of the machine: the signals that limit and home inputs read.
fn wired(machine: &mut SlowMachine) -> Result<Vec<Switch>, Failure> {
    let wires = machine.wires()?;
    let mut by_signal: BTreeMap<String, Switch> = BTreeMap::new();
    let mut order = Vec::new();
    for (n, joint) in machine.joints.iter().enumerate() {
        for (end, what) in [
            ("home-sw-in", "home"),
            ("neg-lim-sw-in", "low limit"),
            ("pos-lim-sw-in", "high limit"),
        ] {
            let name = format!("joint.{n}.{end}");
            let Some(signal) = wires.signal(&name).map(str::to_owned) else { continue };
            let label = format!("{} {what}", joint.name);
            match by_signal.get_mut(&signal) {
                Some(switch) => switch.label.push_str(&format!(", {label}")),
                None => {
                    order.push(signal.clone());
                    let wire = wires.of(&name);
                    by_signal.insert(signal, Switch { pin: name, label, wire });
                }
            }
        }
    }
    Ok(order.iter().filter_map(|signal| by_signal.remove(signal)).collect())
}

/// Each switch: open at rest, closed and quiet while it is pressed, and no other with it.
pub(crate) fn switches(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let switches = wired(machine)?;
    person.enter("switches: leave every limit and home switch")?;
    machine.pass(SETTLE)?;
    if let Some(Switch { label, wire, .. }) = closed(machine, &switches)?.first() {
        return Err(fault(
            format!("the switch of {label} is closed, and nothing presses it"),
            format!(
                "a switch that opens when it is pressed is read as the other of pin-NN-in and pin-NN-in-not; otherwise look at its wires: {wire}"
            ),
        ));
    }
    for switch in &switches {
        pressed(machine, person, &switches, switch)?;
    }
    Ok(format!("{} switches, each seen alone", switches.len()))
}

/// A person presses one of the switches, and leaves it.
fn pressed(
    machine: &mut SlowMachine,
    person: &mut Person,
    switches: &[Switch],
    switch: &Switch,
) -> Result<(), Stopped> {
    let Switch { pin, label, wire } = switch;
    person.enter(&format!("switches: press and hold the switch of {label}"))?;
    machine.pass(SETTLE)?;
    let (mut on, mut changes, mut before) = (0, 0, None);
    for _ in 0..LOOKS {
        machine.pass(BETWEEN)?;
        let is_on = machine.is(pin)?;
        on += u32::from(is_on);
        changes += u32::from(before.replace(is_on).is_some_and(|b| b != is_on));
    }
    let seen = closed(machine, switches)?;
    let other = seen.iter().find(|seen| seen.pin != *pin);
    if changes > 0 {
        return Err(fault(
            format!("the switch of {label} is noisy: it changed {changes} times while it was held"),
            format!("shield its wires, or lead it through debounce: {wire}"),
        ));
    }
    match (on > 0, other) {
        (false, Some(other)) => Err(fault(
            format!("the switch of {label} is pressed, and that of {} is seen", other.label),
            format!(
                "their wires are exchanged: change them at the board, or their pins in the HAL file: {wire}; {}",
                other.wire
            ),
        )),
        (false, None) => Err(fault(
            format!("the switch of {label} is pressed, and nothing is seen"),
            format!("look at its wires and at its pin in the HAL file: {wire}"),
        )),
        (true, Some(other)) => Err(fault(
            format!("the switch of {label} is pressed, and that of {} closes too", other.label),
            format!(
                "their wires touch, or both are on one line: give each its own, or one signal: {wire}; {}",
                other.wire
            ),
        )),
        (true, None) => {
            person.enter(&format!("switches: leave the switch of {label}"))?;
            machine.pass(SETTLE)?;
            if machine.is(pin)? {
                return Err(fault(
                    format!("the switch of {label} stays closed when it is left"),
                    format!("it is stuck, or its wire touches another one: {wire}"),
                ));
            }
            Ok(())
        }
    }
}

/// Returns the switches that are closed.
fn closed(machine: &mut SlowMachine, switches: &[Switch]) -> Result<Vec<Switch>, Failure> {
    let mut to = Vec::new();
    for switch in switches {
        if machine.is(&switch.pin)? {
            to.push(switch.clone());
        }
    }
    Ok(to)
}
