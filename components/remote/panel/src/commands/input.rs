//! Arguments of a command, as requests to the engine.

use super::Args;
use crate::error::{Code, Error};
use hal_protocol::{Orders, Request};
use serde_json::Value as Json;

/// A command with its arguments.
pub(crate) struct Input<'a> {
    pub(crate) args: &'a Args,
    /// Commands of the machine.
    pub(crate) orders: &'a Orders,
    /// True if the machine's unit of length is the inch.
    pub(crate) is_inch: bool,
}

/// Longest text of an argument in bytes.
const MAX_TEXT: usize = 4096;
/// Argument that says what becomes of a job whose lease is lost.
const ON_LOSS: &str = "on_loss";
/// Values of the argument.
pub(crate) const LOSSES: [&str; 3] = ["hold", "continue", "abort"];

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

    pub(super) fn needed(&self, name: &str) -> Result<String, Error> {
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
    pub(crate) fn only(&self, names: &[&str]) -> Result<(), Error> {
        match self.args.keys().find(|key| !names.contains(&key.as_str())) {
            None => Ok(()),
            Some(key) => {
                Err(Error::new(Code::Malformed, format!("the command has no argument '{key}'")))
            }
        }
    }

    pub(crate) fn plain(&self, command: &str) -> Result<Vec<Request>, Error> {
        self.command(command, &[])
    }

    /// Returns a command of the engine with these arguments. Those with a question mark may be absent. On a machine without a
    /// task, one of the task becomes what motion does.
    pub(crate) fn command(&self, command: &str, names: &[&str]) -> Result<Vec<Request>, Error> {
        let plain: Vec<&str> = names.iter().map(|name| name.trim_end_matches('?')).collect();
        self.only(&plain)?;
        self.request(command, names)
    }

    /// Returns a command that begins a job: it may also say what becomes of the job when its lease is lost.
    pub(super) fn start(&self, command: &str, names: &[&str]) -> Result<Vec<Request>, Error> {
        let plain = names.iter().map(|name| name.trim_end_matches('?'));
        self.only(&plain.chain([ON_LOSS]).collect::<Vec<_>>())?;
        self.on_loss()?;
        self.request(command, names)
    }

    /// Returns what becomes of the job that begins when its lease is lost, if the command says so.
    pub(crate) fn on_loss(&self) -> Result<Option<String>, Error> {
        let given = self.text(ON_LOSS)?;
        match &given {
            Some(text) if !LOSSES.contains(&text.as_str()) => {
                let text = format!("{ON_LOSS} is {text}, must be {}", LOSSES.join(", "));
                Err(Error::new(Code::Malformed, text))
            }
            _ => Ok(given),
        }
    }

    fn request(&self, command: &str, names: &[&str]) -> Result<Vec<Request>, Error> {
        let mut args = Vec::new();
        for name in names {
            let plain = name.trim_end_matches('?');
            let text = if *name == plain { Some(self.needed(plain)?) } else { self.text(plain)? };
            args.extend(text.map(|text| format!("{plain}={text}")));
        }
        self.order(command, args)
    }

    fn order(&self, command: &str, args: Vec<String>) -> Result<Vec<Request>, Error> {
        Ok(self.orders.request(command, args)?.into_iter().collect())
    }

    /// Returns the command that executes a line of G-code.
    fn line(&self, text: &str) -> Result<Vec<Request>, Error> {
        self.order("task.mdi", vec![format!("text={text}")])
    }

    pub(super) fn renamed(
        &self,
        command: &str,
        name: &str,
        as_name: &str,
    ) -> Result<Vec<Request>, Error> {
        self.only(&[name])?;
        self.order(command, vec![format!("{as_name}={}", self.needed(name)?)])
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
pub(super) fn touch_off(given: &Input<'_>) -> Result<Vec<Request>, Error> {
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
    given.line(&format!("G10 L20 P{system} {axis}{value}"))
}

/// Moves the machine to a place in mm, at its height: the camera then sees a mark.
pub(super) fn align_go(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["x", "y"])?;
    let place = |name| Ok::<_, Error>(length(given.number(name)?, false));
    given.line(&format!("G53 G0 X{} Y{}", place("x")?, place("y")?))
}

/// Sets the offset of a tool along axes, and its diameter.
pub(super) fn tool_offset(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["tool", "x", "z", "diameter"])?;
    let tool: u32 = given
        .needed("tool")?
        .parse()
        .map_err(|_| Error::new(Code::Malformed, "tool is the number of a tool, from 1"))?;
    let mut text = format!("G10 L1 P{tool}");
    for (name, letter, share) in [("x", 'X', 1.0), ("z", 'Z', 1.0), ("diameter", 'R', 0.5)] {
        if given.text(name)?.is_some() {
            let value = given.number(name)? * share;
            text += &format!(" {letter}{}", length(value, given.is_inch));
        }
    }
    given.line(&text)
}
