//! The spindle: its direction, and that it stops.

use super::{Stopped, fault, machine::SlowMachine, motion::ready, person::Person};

/// Time for which it turns, and in which it stops, in seconds.
const TURNS: f64 = 3.0;
const STOPS: f64 = 5.0;
/// Pins of which one is linked where a spindle is wired.
const WIRED: &[&str] = &["on", "forward", "reverse", "speed-out", "speed-out-abs", "speed-out-rps"];

/// The spindle turns clockwise, and backward if that is wired, and stops.
pub(crate) fn spindle(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let wires = machine.wires()?;
    let names = WIRED.iter().map(|end| format!("spindle.0.{end}"));
    let wired: Vec<String> = names.filter(|name| wires.signal(name).is_some()).collect();
    if wired.is_empty() {
        return Ok("none is wired".to_owned());
    }
    let at = wires.all(&wired);
    ready(machine, person)?;
    let speed = machine.spindle;
    person.enter(&format!("spindle: no tool, nobody near it: it turns at {speed:.0} rpm"))?;
    turn(machine, person, speed, ("cw", &at))?;
    if wired.iter().any(|name| name.ends_with(".reverse")) {
        person.enter("spindle: it turns backward")?;
        turn(machine, person, -speed, ("ccw", &at))?;
    }
    Ok("turns the right way, and stops".to_owned())
}

/// Turns the spindle for a while, and stops it.
fn turn(
    machine: &mut SlowMachine,
    person: &mut Person,
    speed: f64,
    (way, wires): (&str, &str),
) -> Result<(), Stopped> {
    machine.order("motion.spindle", &[format!("speed={speed}")])?;
    machine.pass_watched(TURNS)?;
    let question = "spindle: which way does it turn, seen from above? (cw, ccw, none) ";
    let seen = person.word(question, &["cw", "ccw", "none"]);
    machine.order("motion.spindle", &["speed=0".to_owned()])?;
    machine.pass(STOPS)?;
    let seen = seen?;
    let stands = person.word("spindle: does it stand still now? [y/n] ", &["y", "n"])?;
    if stands == "n" {
        drop(machine.order("iocontrol.estop", &[]));
        return Err(fault(
            "the spindle does not stop: press the e-stop",
            format!("look at its wires and at the stop of the inverter: {wires}"),
        ));
    }
    match seen.as_str() {
        "none" => Err(fault(
            "the spindle does not turn",
            format!("look at its wires and at the inverter: {wires}"),
        )),
        seen if seen != way => Err(fault(
            format!("the spindle turns {seen}, and should turn {way}"),
            format!("exchange two phases of its motor, or the wires of its direction: {wires}"),
        )),
        _ => Ok(()),
    }
}
