//! The table of commands: who may give them, and what the engine is asked for them.

use crate::{
    error::{Code, Error},
    session::Role,
};
use hal_protocol::{Direction, ItemInfo, Request};
use serde_json::{Map, Value as Json};

/// Arguments of a command, as a client sends them.
pub(crate) type Args = Map<String, Json>;

/// A command of the API.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    /// Least role that may give it.
    pub(crate) role: Role,
    /// True if it needs the control lease.
    pub(crate) lease: bool,
    pub(crate) action: Action,
}

/// Effect of a command.
pub(crate) enum Action {
    /// Sends the engine these requests, one after the other; a refusal ends them.
    Engine(fn(&Input<'_>) -> Result<Vec<Request>, Error>),
    /// Jogs, with the number of the lease.
    Jog,
    /// Gives this command of the engine the file of a program of the list.
    Open(&'static str),
    /// Presses the button of `hal_manualtoolchange` by the plugin.
    ToolChanged,
}

use Action::{Engine, Jog, Open, ToolChanged};
use Role::{Integrator, Operator, Viewer};

const fn row(name: &'static str, role: Role, lease: bool, action: Action) -> Row {
    Row { name, role, lease, action }
}

/// All commands.
pub(crate) const ROWS: &[Row] = &[
    row("abort", Viewer, false, Engine(|g| g.plain("task.abort"))),
    row("estop", Operator, false, Engine(|g| g.plain("task.estop"))),
    row("off", Operator, false, Engine(|g| g.plain("task.off"))),
    row("pause", Operator, false, Engine(|g| g.plain("task.pause"))),
    row("jog-stop", Operator, false, Engine(|g| g.plain("motion.jog-stop"))),
    row("estop-reset", Operator, true, Engine(|g| g.plain("task.estop-reset"))),
    row("on", Operator, true, Engine(|g| g.plain("task.on"))),
    row("mode", Operator, true, Engine(|g| g.command("task.mode", &["mode"]))),
    row("home", Operator, true, Engine(|g| g.command("task.home", &["joint"]))),
    row("unhome", Operator, true, Engine(|g| g.command("motion.unhome", &["joint"]))),
    row("jog", Operator, true, Jog),
    row("open", Operator, true, Open("task.open")),
    row("run", Operator, true, Engine(|g| g.plain("task.run"))),
    row("run-from", Operator, true, Engine(|g| g.command("task.run-from", &["line", "pass?"]))),
    row("recover", Operator, true, Engine(|g| g.plain("task.recover"))),
    row("confirm", Operator, true, Engine(|g| g.command("task.confirm", &["token"]))),
    row("resume", Operator, true, Engine(|g| g.plain("task.resume"))),
    row("step", Operator, true, Engine(|g| g.plain("task.step"))),
    row("mdi", Operator, true, Engine(|g| g.command("task.mdi", &["text"]))),
    row("optional-stop", Operator, true, Engine(|g| g.command("task.optional-stop", &["on"]))),
    row("block-delete", Operator, true, Engine(|g| g.command("task.block-delete", &["on"]))),
    row("feed-override", Operator, true, Engine(|g| g.command("task.feed-override", &["scale"]))),
    row("rapid-override", Operator, true, Engine(|g| g.command("task.rapid-override", &["scale"]))),
    row(
        "spindle-override",
        Operator,
        true,
        Engine(|g| g.command("task.spindle-override", &["scale", "spindle?"])),
    ),
    row(
        "spindle",
        Operator,
        true,
        Engine(|g| g.command("motion.spindle", &["speed?", "brake?", "spindle?"])),
    ),
    row("mist", Operator, true, Engine(|g| g.renamed("iocontrol.coolant", "on", "mist"))),
    row("flood", Operator, true, Engine(|g| g.renamed("iocontrol.coolant", "on", "flood"))),
    row("override-limits", Operator, true, Engine(|g| g.plain("motion.override-limits"))),
    row("tool-changed", Operator, true, ToolChanged),
    row("touch-off", Operator, true, Engine(touch_off)),
    row("tool-offset", Operator, true, Engine(tool_offset)),
    row("align-look", Operator, true, Engine(|g| g.command("align.look", &["mark"]))),
    row("align-solve", Operator, true, Engine(|g| g.plain("align.solve"))),
    row("align-clear", Operator, true, Engine(|g| g.plain("align.clear"))),
    row("align-go", Operator, true, Engine(align_go)),
    row("align-sight", Integrator, true, Engine(|g| g.plain("align.sight"))),
    row("align-calibrate", Integrator, true, Engine(|g| g.plain("align.calibrate"))),
    row("robot-stop", Viewer, false, Engine(|g| g.plain("robot.stop"))),
    row("robot-pause", Operator, false, Engine(|g| g.plain("robot.pause"))),
    row("robot-connect", Operator, true, Engine(|g| g.plain("robot.connect"))),
    row("robot-disconnect", Operator, true, Engine(|g| g.plain("robot.disconnect"))),
    row("robot-load", Operator, true, Open("robot.load")),
    row("robot-run", Operator, true, Engine(|g| g.command("robot.run", &["from?"]))),
    row("robot-resume", Operator, true, Engine(|g| g.plain("robot.resume"))),
    row("setp", Integrator, true, Engine(setp)),
    row("sets", Integrator, true, Engine(sets)),
    row("net", Integrator, true, Engine(net)),
    row("linkp", Integrator, true, Engine(linkp)),
    row("unlink", Integrator, true, Engine(unlink)),
];

/// Returns the command of this name.
pub(crate) fn find(name: &str) -> Result<&'static Row, Error> {
    let missing = || Error::new(Code::NotFound, format!("there is no command '{name}'"));
    ROWS.iter().find(|row| row.name == name).ok_or_else(missing)
}

/// A command with its arguments.
pub(crate) struct Input<'a> {
    pub(crate) args: &'a Args,
    /// True if the machine's unit of length is the inch.
    pub(crate) is_inch: bool,
}

/// Longest text of an argument in bytes.
const MAX_TEXT: usize = 4096;

impl Input<'_> {
    /// Returns an argument as the engine reads it.
    fn text(&self, name: &str) -> Result<Option<String>, Error> {
        let malformed = |why: &str| Err(Error::new(Code::Malformed, format!("{name} {why}")));
        let text = match self.args.get(name) {
            None | Some(Json::Null) => return Ok(None),
            Some(Json::Bool(on)) => if *on { "TRUE" } else { "FALSE" }.to_owned(),
            Some(Json::Number(number)) => number.to_string(),
            Some(Json::String(text)) => text.clone(),
            Some(Json::Array(_) | Json::Object(_)) => {
                return malformed("is a number, a text, true or false");
            }
        };
        if text.len() > MAX_TEXT {
            return Err(Error::new(
                Code::TooLarge,
                format!("{name} has {} bytes, at most {MAX_TEXT}", text.len()),
            ));
        }
        if text.contains(['\n', '\r', '\0']) {
            return malformed("is one line");
        }
        Ok(Some(text))
    }

    fn needed(&self, name: &str) -> Result<String, Error> {
        let missing = || Error::new(Code::Malformed, format!("the command needs {name}"));
        self.text(name)?.ok_or_else(missing)
    }

    /// Returns an argument that is a finite number.
    fn number(&self, name: &str) -> Result<f64, Error> {
        let text = self.needed(name)?;
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let malformed = || Error::new(Code::Malformed, format!("{name} '{text}' is not a number"));
        number.ok_or_else(malformed)
    }

    /// Refuses arguments other than these.
    fn only(&self, names: &[&str]) -> Result<(), Error> {
        match self.args.keys().find(|key| !names.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => {
                Err(Error::new(Code::Malformed, format!("the command has no argument '{key}'")))
            }
        }
    }

    fn plain(&self, command: &str) -> Result<Vec<Request>, Error> {
        self.command(command, &[])
    }

    /// Returns a command of the engine with these arguments. Those with a question mark may be absent.
    pub(crate) fn command(&self, command: &str, names: &[&str]) -> Result<Vec<Request>, Error> {
        let plain: Vec<&str> = names.iter().map(|name| name.trim_end_matches('?')).collect();
        self.only(&plain)?;
        let mut args = Vec::new();
        for (name, plain) in names.iter().zip(plain) {
            let text = if *name == plain { Some(self.needed(plain)?) } else { self.text(plain)? };
            args.extend(text.map(|text| format!("{plain}={text}")));
        }
        Ok(vec![Request::Command { name: command.to_owned(), args }])
    }

    fn renamed(&self, command: &str, name: &str, as_name: &str) -> Result<Vec<Request>, Error> {
        self.only(&[name])?;
        let args = vec![format!("{as_name}={}", self.needed(name)?)];
        Ok(vec![Request::Command { name: command.to_owned(), args }])
    }

    /// Returns the command that jogs under this lease.
    pub(crate) fn jog(&self, lease: u64) -> Result<Vec<Request>, Error> {
        let names = ["joint?", "axis?", "velocity", "distance?", "position?"];
        let mut requests = self.command("remote.jog", &names)?;
        for request in &mut requests {
            if let Request::Command { args, .. } = request {
                args.push(format!("lease={lease}"));
            }
        }
        Ok(requests)
    }

    /// Returns the name of the program to open.
    pub(crate) fn program(&self) -> Result<String, Error> {
        self.only(&["program"])?;
        self.needed("program")
    }
}

/// Returns a length in inches or millimetres as an expression in the unit that is in force when its line is executed.
fn length(value: f64, is_inch: bool) -> String {
    let scale = if is_inch {
        "[#<_imperial> + #<_metric> * 25.4]"
    } else {
        "[#<_metric> + #<_imperial> / 25.4]"
    };
    format!("[{value} * {scale}]")
}

/// Sets a coordinate system so that an axis has this value where it is.
fn touch_off(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["axis", "value", "system"])?;
    let malformed = |text: String| Error::new(Code::Malformed, text);
    let axis = given.needed("axis")?.to_ascii_uppercase();
    if axis.len() != 1 || !"XYZABCUVW".contains(&axis) {
        return Err(malformed(format!("axis is {axis}, must be one of XYZABCUVW")));
    }
    let value = given.number("value")?;
    let value =
        if "ABC".contains(&axis) { value.to_string() } else { length(value, given.is_inch) };
    let system = given.text("system")?.unwrap_or_else(|| "0".to_owned());
    let system: u8 = system
        .parse()
        .ok()
        .filter(|n| *n <= 9)
        .ok_or_else(|| malformed(format!("system is {system}, must be 0 to 9")))?;
    let text = format!("text=G10 L20 P{system} {axis}{value}");
    Ok(vec![Request::Command { name: "task.mdi".to_owned(), args: vec![text] }])
}

/// Moves the machine to a place in mm, at its height: the camera then sees a mark.
fn align_go(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["x", "y"])?;
    let place = |name| Ok::<_, Error>(length(given.number(name)?, false));
    let text = format!("text=G53 G0 X{} Y{}", place("x")?, place("y")?);
    Ok(vec![Request::Command { name: "task.mdi".to_owned(), args: vec![text] }])
}

/// Sets the offset of a tool along axes, and its diameter.
fn tool_offset(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["tool", "x", "z", "diameter"])?;
    let tool: u32 = given
        .needed("tool")?
        .parse()
        .map_err(|_| Error::new(Code::Malformed, "tool is the number of a tool, from 1"))?;
    let mut text = format!("text=G10 L1 P{tool}");
    for (name, letter, share) in [("x", 'X', 1.0), ("z", 'Z', 1.0), ("diameter", 'R', 0.5)] {
        if given.text(name)?.is_some() {
            let value = given.number(name)? * share;
            text += &format!(" {letter}{}", length(value, given.is_inch));
        }
    }
    Ok(vec![Request::Command { name: "task.mdi".to_owned(), args: vec![text] }])
}

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

fn setp(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["name", "value"])?;
    guard(&given.needed("name")?)?;
    Ok(vec![Request::Set { name: given.needed("name")?, value: given.needed("value")? }])
}

fn sets(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["name", "value"])?;
    Ok(vec![Request::SetSignal { name: given.needed("name")?, value: given.needed("value")? }])
}

fn net(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["signal", "pins"])?;
    let pins: Vec<String> = given.needed("pins")?.split_whitespace().map(str::to_owned).collect();
    pins.iter().try_for_each(|pin| guard(pin))?;
    Ok(vec![Request::Net { signal: given.needed("signal")?, pins }])
}

fn linkp(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["pin", "signal"])?;
    guard(&given.needed("pin")?)?;
    Ok(vec![Request::Link { pin: given.needed("pin")?, signal: given.needed("signal")? }])
}

fn unlink(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["pin"])?;
    guard(&given.needed("pin")?)?;
    Ok(vec![Request::Unlink { pin: given.needed("pin")? }])
}

#[cfg(test)]
mod tests;
