//! Steps in which the drives are on: enable, direction, scale, following error, homing.

use super::{
    Stopped,
    entries::{Change, JointEntries, stated},
    fault,
    inputs::reset,
    machine::{CHAIN, Cause, SlowMachine},
    person::Person,
};

/// Way of the first movement, which may go the wrong way: millimetres, inches, degrees.
const FIRST: (f64, f64, f64) = (0.5, 0.02, 0.5);
/// Way that is measured.
const MEASURED: (f64, f64, f64) = (5.0, 0.2, 5.0);
/// Share of the travel that the measured way is at most.
const TRAVEL: f64 = 0.2;
/// Share by which a measured way may differ.
const NEAR: f64 = 0.02;
/// Share of the permitted following error that a slow movement may use.
const FOLLOWS: f64 = 0.5;
/// Difference that two homings may have.
const SPREAD: (f64, f64, f64) = (0.02, 0.001, 0.02);

/// Returns the one of the unit of a joint.
fn of_unit(joint: &JointEntries, (mm, inch, degrees): (f64, f64, f64)) -> f64 {
    match joint.unit {
        "inch" => inch,
        "degrees" => degrees,
        _ => mm,
    }
}

/// Switches the machine on. In e-stop the person lets it out first.
pub(crate) fn ready(machine: &mut SlowMachine, person: &mut Person) -> Result<(), Stopped> {
    if !machine.is(CHAIN)? {
        person.enter("the machine is switched on now: pull the e-stop button out")?;
        reset(machine)?;
    }
    let on = machine.order("motion.enable", &[]);
    machine.pass(0.3)?;
    if machine.is("motion.motion-enabled")? {
        return Ok(());
    }
    let cause = machine.cause()?;
    Err(match (on, cause) {
        (Err(Stopped::Aborted(text)), Cause::Unknown) => fault(
            format!("the machine cannot be switched on: {text}"),
            format!("look at the e-stop chain: {}", machine.wires()?.of("motion.enable")),
        ),
        (Ok(()) | Err(Stopped::Aborted(_)), cause) => Stopped::Off(cause),
        (Err(other), _) => other,
    })
}

/// The drives hold while the machine is on, and only then.
pub(crate) fn enable(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    const SENSE: &str = "a line of the wrong sense wants '-out-invert'";
    let free = "enable: the machine is off. Can each motor be turned by hand? [y/n] ";
    if person.word(free, &["y", "n"])? == "n" {
        let (name, wire) = which(machine, person, "is held")?;
        return Err(fault(
            format!("the drive of {name} holds its motor while the machine is off"),
            format!("wire its enable to {wire}; {SENSE}"),
        ));
    }
    ready(machine, person)?;
    let holds = "enable: the machine is on. Does each drive hold its motor? [y/n] ";
    if person.word(holds, &["y", "n"])? == "n" {
        let (name, wire) = which(machine, person, "turns freely")?;
        return Err(fault(
            format!("the drive of {name} does not hold its motor while the machine is on"),
            format!("look at its power and at its enable, {wire}; {SENSE}"),
        ));
    }
    person.enter("enable: press the e-stop button and leave it pressed")?;
    machine.pass(0.3)?;
    machine.rest();
    let again = "enable: the e-stop is pressed. Can each motor be turned by hand? [y/n] ";
    if person.word(again, &["y", "n"])? == "n" {
        let (name, wire) = which(machine, person, "is held")?;
        return Err(fault(
            format!("the drive of {name} holds its motor in e-stop"),
            format!("look at its enable, {wire}"),
        ));
    }
    Ok("the drives hold only while the machine is on, and not in e-stop".to_owned())
}

/// Asks for a motor; returns its name and the wire of its enable. The machine is off then.
fn which(
    machine: &mut SlowMachine,
    person: &mut Person,
    what: &str,
) -> Result<(String, String), Stopped> {
    machine.rest();
    let wires = machine.wires()?;
    let names: Vec<String> = machine.joints.iter().map(|joint| short(&joint.name)).collect();
    let words: Vec<&str> = names.iter().map(String::as_str).collect();
    let question = format!("enable: which one {what}? ({}) ", words.join(", "));
    let word = person.word(&question, &words)?;
    let n = words.iter().position(|name| *name == word).unwrap_or_default();
    let name = machine.joints.get(n).map_or_else(String::new, |joint| joint.name.clone());
    Ok((name, wires.of(&format!("joint.{n}.amp-enable-out"))))
}

/// Jogs a joint by a way, and watches its following error; returns the largest share of it that was used.
fn jog(machine: &mut SlowMachine, n: usize, way: f64) -> Result<f64, Stopped> {
    let Some(joint) = machine.joints.get(n).cloned() else { return Ok(0.0) };
    let args =
        [format!("joint={n}"), format!("velocity={}", joint.velocity), format!("distance={way}")];
    let time = 5.0 + 3.0 * (way.abs() / joint.velocity + joint.velocity / joint.acceleration);
    let mut most = 0.0_f64;
    let ended = machine.moving("motion.jog", &args, time, &mut |machine| {
        let limit = machine.value(&format!("joint.{n}.f-error-lim"))?;
        let error = machine.value(&format!("joint.{n}.f-error"))?.abs();
        if limit > 0.0 {
            most = most.max(error / limit);
        }
        Ok(())
    });
    ended?;
    machine.pass(0.2)?;
    Ok(most)
}

/// Each motor moves a little: the right one, and the right way.
pub(crate) fn direction(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let joints = machine.joints.clone();
    let mut words: Vec<String> = joints
        .iter()
        .flat_map(|j| ["+", "-"].map(|sign| format!("{}{sign}", short(&j.name))))
        .collect();
    words.push("none".to_owned());
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    for (n, joint) in joints.iter().enumerate() {
        let way = of_unit(joint, FIRST);
        let name = &joint.name;
        ready(machine, person)?;
        person
            .enter(&format!("direction: {name} moves {way} {} toward +: look at it", joint.unit))?;
        jog(machine, n, way)?;
        let question = format!("direction: what has moved, and which way? ({}) ", words.join(", "));
        let seen = person.word(&question, &words)?;
        if seen == "none" {
            return Err(fault(
                format!("{name}: nothing has moved"),
                format!(
                    "look at the power of the drive and at its wires: {}",
                    machine.wires()?.outputs(n)
                ),
            ));
        }
        let own = short(name);
        let (moved, sign) = seen.split_at(seen.len() - 1);
        if moved != own {
            let (wires, other) =
                (machine.wires()?, joints.iter().position(|j| short(&j.name) == moved));
            return Err(fault(
                format!("{name} was to move, and {} has moved", moved.to_uppercase()),
                format!(
                    "the wires of two motors are exchanged: change them at the board, or their pins in the HAL file: {}; {}",
                    wires.outputs(n),
                    wires.outputs(other.unwrap_or(n))
                ),
            ));
        }
        if sign == "-" {
            let wires = machine.wires()?;
            let open = wires.is_open(n);
            let scale = joint.scale.as_ref().filter(|_| open);
            let value = scale.and_then(stated);
            return Err(Stopped::Fault {
                what: format!("{name} moves the wrong way"),
                mend: if open {
                    format!(
                        "the opposite sign of {} turns it round; so does '-invert' at its direction: {}",
                        entry_of(joint, n),
                        wires.outputs(n)
                    )
                } else {
                    format!(
                        "exchange the wires of its motor, and A and B of its encoder with them: {}; {}",
                        wires.outputs(n),
                        wires.of(&format!("joint.{n}.motor-pos-fb"))
                    )
                },
                change: scale.zip(value).map(|(entry, value)| Box::new(Change::new(entry, -value))),
            });
        }
        // The way back is known to be right.
        jog(machine, n, -way)?;
    }
    Ok("each motor moves alone, and the right way".to_owned())
}

/// Returns the name of the entry with a joint's steps of a unit.
fn entry_of(joint: &JointEntries, n: usize) -> String {
    match &joint.scale {
        Some(entry) => format!("[{}]{}", entry.section, entry.name),
        None => format!("the scale of joint.{n}.motor-pos-cmd"),
    }
}

/// Returns the name of a joint in an answer.
fn short(name: &str) -> String {
    name.trim_start_matches("joint ").to_lowercase()
}

/// Returns the way that is measured.
fn measured(joint: &JointEntries) -> f64 {
    f64::min(of_unit(joint, MEASURED), TRAVEL * (joint.max - joint.min))
}

/// A way is measured: the steps of a unit are right.
pub(crate) fn scale(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let joints = machine.joints.clone();
    let mut told = Vec::new();
    for (n, joint) in joints.iter().enumerate() {
        let (way, name, unit) = (measured(joint), &joint.name, joint.unit);
        ready(machine, person)?;
        person.enter(&format!(
            "scale: {name} moves {way} {unit} toward +, with room for twice as much: set a gauge to 0"
        ))?;
        jog(machine, n, way)?;
        let moved = person.number(&format!("scale: how far has {name} moved, in {unit}? "))?;
        jog(machine, n, -way)?;
        if moved <= 0.0 {
            return Err(fault(
                format!("{name}: moved by {moved} {unit} instead of {way}"),
                format!(
                    "measure again; a motor that does not move has no steps or no power: {}",
                    machine.wires()?.outputs(n)
                ),
            ));
        }
        if (moved / way - 1.0).abs() > NEAR {
            let value = joint.scale.as_ref().and_then(stated);
            let right = value.map(|value| value * way / moved);
            return Err(Stopped::Fault {
                what: format!("{name} moves {moved} {unit} instead of {way}"),
                mend: format!(
                    "correct {}; look at microsteps, belt and screw as well",
                    entry_of(joint, n)
                ),
                change: joint
                    .scale
                    .as_ref()
                    .zip(right)
                    .map(|(entry, x)| Box::new(Change::new(entry, x))),
            });
        }
        told.push(format!("{name} {moved} of {way} {unit}"));
    }
    Ok(told.join(", "))
}

/// Each motor follows its command with a share of the permitted error.
pub(crate) fn following(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let joints = machine.joints.clone();
    let mut told = Vec::new();
    for (n, joint) in joints.iter().enumerate() {
        let (way, name) = (measured(joint), &joint.name);
        ready(machine, person)?;
        person.enter(&format!("following: {name} moves {way} {} and back", joint.unit))?;
        let share = jog(machine, n, way)?.max(jog(machine, n, -way)?);
        if share > FOLLOWS {
            return Err(fault(
                format!(
                    "{name} uses {:.0} % of the permitted following error at a tenth of its speed",
                    share * 100.0
                ),
                format!(
                    "tune {} (Pgain, FF1), or look for what brakes it, before it runs faster; [JOINT_{n}]FERROR is what is permitted",
                    machine.wires()?.loops(n)
                ),
            ));
        }
        told.push(format!("{name} {:.0} %", share * 100.0));
    }
    Ok(format!("of the permitted error: {}", told.join(", ")))
}

/// Each joint homes twice, and the two places are compared.
pub(crate) fn homing(machine: &mut SlowMachine, person: &mut Person) -> Result<String, Stopped> {
    let joints = machine.joints.clone();
    let mut told = Vec::new();
    for (n, joint) in joints.iter().enumerate() {
        let name = &joint.name;
        ready(machine, person)?;
        if joint.search == 0.0 {
            home(machine, n, joint)?;
            told.push(format!("{name} where it stands"));
            continue;
        }
        let end = if joint.search < 0.0 { "-" } else { "+" };
        person.enter(&format!("homing: {name} looks for its switch toward {end}"))?;
        let first = found(machine, n, joint)?;
        let second = found(machine, n, joint)?;
        let spread = (first - second).abs();
        let most = of_unit(joint, SPREAD);
        if spread > most {
            return Err(fault(
                format!(
                    "{name}: two homings differ by {spread:.4} {}, more than {most}",
                    joint.unit
                ),
                format!(
                    "fasten the switch and its cam, home slower ([JOINT_{n}]HOME_LATCH_VEL), or lead the switch through debounce: {}",
                    machine.wires()?.of(&format!("joint.{n}.home-sw-in"))
                ),
            ));
        }
        told.push(format!("{name} {spread:.4} {}", joint.unit));
    }
    Ok(format!("spread: {}", told.join(", ")))
}

/// Homes a joint with a switch. One that does not find it has a fault of its switch.
fn found(machine: &mut SlowMachine, n: usize, joint: &JointEntries) -> Result<f64, Stopped> {
    let stopped = match home(machine, n, joint) {
        Err(stopped @ (Stopped::Off(_) | Stopped::Aborted(_))) => machine.explained(stopped),
        other => return other,
    };
    let at = machine.wires()?.of(&format!("joint.{n}.home-sw-in"));
    let look = format!(
        "was the home switch passed? look at its cam and at {at}; the sign of [JOINT_{n}]HOME_SEARCH_VEL is the end toward which it is looked for"
    );
    let is_pressed = machine.cause()? == Cause::Estop;
    Err(match stopped {
        Stopped::Fault { what, mend, change } => {
            Stopped::Fault { what, mend: format!("{look}; {mend}"), change }
        }
        Stopped::Aborted(text) if !is_pressed => {
            fault(format!("{}: no home switch was found: {text}", joint.name), look)
        }
        other => other,
    })
}

/// Homes a joint; returns where its motor was found to be.
fn home(machine: &mut SlowMachine, n: usize, joint: &JointEntries) -> Result<f64, Stopped> {
    let travel = joint.max - joint.min;
    let slow = f64::min(joint.search.abs(), joint.velocity).max(1e-6);
    let latch = joint.latch.abs().max(1e-6);
    let looks = if joint.search == 0.0 { 0.0 } else { travel / slow + 0.05 * travel / latch };
    let time = 10.0 + 2.0 * (looks + travel / joint.velocity);
    let homed = format!("joint.{n}.homed");
    machine.order("motion.unhome", &[format!("joint={n}")])?;
    machine.moving("motion.home", &[format!("joint={n}")], time, &mut |_| Ok(()))?;
    machine.until(&format!("{} is homed", joint.name), time, &mut |m| Ok(m.is(&homed)?))?;
    Ok(machine.value(&format!("joint.{n}.motor-offset"))?)
}
