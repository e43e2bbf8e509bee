//! The table of commands: who may give them, and what the engine is asked for them.

mod input;
mod wiring;

use crate::{
    engine::Ending,
    error::{Code, Error},
    session::Role,
};
use hal_protocol::{Request, Stop};
use input::{align_go, tool_offset, touch_off};
use serde_json::{Map, Value as Json};
use wiring::{linkp, net, setp, sets, unlink};

pub(crate) use input::{Input, LOSSES};

/// Arguments of a command, as a client sends them.
pub(crate) type Args = Map<String, Json>;

/// Effect of a command on the machine. It decides what a command needs, and what it is refused for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Begins motion: needs the lease and the permission of the machine's wiring, and is announced to the plugin `remote`.
    Begins,
    /// Gives power, or what motion waits for: needs the same, and is not announced.
    Powers,
    /// Ends motion: needs nothing.
    Ends,
    /// Changes a setting, and moves nothing: needs the lease.
    Changes,
}

/// A command of the API.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) effect: Effect,
    /// Least role that may give it.
    pub(crate) role: Role,
    pub(crate) action: Action,
}

/// Way in which a command is executed.
pub(crate) enum Action {
    /// Sends the engine these requests, one after the other; a refusal ends them.
    Engine(fn(&Input<'_>) -> Result<Vec<Request>, Error>),
    /// Stops, whatever waits.
    Stop(Ending),
    /// Ends jogs, in the order of the commands.
    EndJogs,
    /// Jogs, with the number of the lease.
    Jog,
    /// Gives this command of the engine the file of a program of the list.
    Open(&'static str),
    /// Presses the button of `hal_manualtoolchange` by the plugin.
    ToolChanged,
}

use Action::{EndJogs, Engine, Jog, Open, ToolChanged};
use Effect::{Begins, Changes, Ends, Powers};
use Role::{Integrator, Operator, Viewer};

const fn row(name: &'static str, effect: Effect, role: Role, action: Action) -> Row {
    Row { name, effect, role, action }
}

const fn stop(stop: Stop) -> Action {
    Action::Stop(Ending::Machine(stop))
}

const fn robot(name: &'static str) -> Action {
    Action::Stop(Ending::Robot(name))
}

/// All commands.
pub(crate) const ROWS: &[Row] = &[
    row("abort", Ends, Viewer, stop(Stop::Abort)),
    row("estop", Ends, Viewer, stop(Stop::Estop)),
    row("off", Ends, Operator, stop(Stop::Off)),
    row("pause", Ends, Operator, stop(Stop::Pause)),
    row("jog-stop", Ends, Operator, EndJogs),
    row("estop-reset", Powers, Operator, Engine(|g| g.plain("task.estop-reset"))),
    row("on", Powers, Operator, Engine(|g| g.plain("task.on"))),
    row("mode", Changes, Operator, Engine(|g| g.command("task.mode", &["mode"]))),
    row("home", Begins, Operator, Engine(|g| g.command("task.home", &["joint"]))),
    row("unhome", Changes, Operator, Engine(|g| g.command("motion.unhome", &["joint"]))),
    row("jog", Begins, Operator, Jog),
    row("open", Changes, Operator, Open("task.open")),
    row("run", Begins, Operator, Engine(|g| g.start("task.run", &[]))),
    row("run-from", Changes, Operator, Engine(|g| g.command("task.run-from", &["line", "pass?"]))),
    row("recover", Changes, Operator, Engine(|g| g.plain("task.recover"))),
    row("confirm", Begins, Operator, Engine(|g| g.start("task.confirm", &["token"]))),
    row("resume", Begins, Operator, Engine(|g| g.start("task.resume", &[]))),
    row("step", Begins, Operator, Engine(|g| g.plain("task.step"))),
    row("mdi", Begins, Operator, Engine(|g| g.command("task.mdi", &["text"]))),
    row("optional-stop", Changes, Operator, Engine(|g| g.command("task.optional-stop", &["on"]))),
    row("block-delete", Changes, Operator, Engine(|g| g.command("task.block-delete", &["on"]))),
    row(
        "feed-override",
        Changes,
        Operator,
        Engine(|g| g.command("task.feed-override", &["scale"])),
    ),
    row(
        "rapid-override",
        Changes,
        Operator,
        Engine(|g| g.command("task.rapid-override", &["scale"])),
    ),
    row(
        "spindle-override",
        Changes,
        Operator,
        Engine(|g| g.command("task.spindle-override", &["scale", "spindle?"])),
    ),
    row(
        "spindle",
        Powers,
        Operator,
        Engine(|g| g.command("motion.spindle", &["speed?", "brake?", "spindle?"])),
    ),
    row("mist", Changes, Operator, Engine(|g| g.renamed("iocontrol.coolant", "on", "mist"))),
    row("flood", Changes, Operator, Engine(|g| g.renamed("iocontrol.coolant", "on", "flood"))),
    row("override-limits", Powers, Operator, Engine(|g| g.plain("motion.override-limits"))),
    row("tool-changed", Powers, Operator, ToolChanged),
    row("touch-off", Begins, Operator, Engine(touch_off)),
    row("tool-offset", Begins, Operator, Engine(tool_offset)),
    row("align-look", Changes, Operator, Engine(|g| g.command("align.look", &["mark"]))),
    row("align-solve", Changes, Operator, Engine(|g| g.plain("align.solve"))),
    row("align-clear", Changes, Operator, Engine(|g| g.plain("align.clear"))),
    row("align-go", Begins, Operator, Engine(align_go)),
    row("align-sight", Changes, Integrator, Engine(|g| g.plain("align.sight"))),
    row("align-calibrate", Changes, Integrator, Engine(|g| g.plain("align.calibrate"))),
    row("robot-stop", Ends, Viewer, robot("robot.stop")),
    row("robot-pause", Ends, Operator, robot("robot.pause")),
    row("robot-connect", Begins, Operator, Engine(|g| g.plain("robot.connect"))),
    row("robot-disconnect", Changes, Operator, Engine(|g| g.plain("robot.disconnect"))),
    row("robot-load", Changes, Operator, Open("robot.load")),
    row("robot-run", Begins, Operator, Engine(|g| g.start("robot.run", &["from?"]))),
    row("robot-resume", Begins, Operator, Engine(|g| g.start("robot.resume", &[]))),
    row("setp", Changes, Integrator, Engine(setp)),
    row("sets", Changes, Integrator, Engine(sets)),
    row("net", Changes, Integrator, Engine(net)),
    row("linkp", Changes, Integrator, Engine(linkp)),
    row("unlink", Changes, Integrator, Engine(unlink)),
];

impl Row {
    /// Returns whether it needs the control lease: all but what ends motion do.
    pub(crate) const fn needs_lease(&self) -> bool {
        !matches!(self.effect, Ends)
    }

    /// Returns whether it needs the permission of the machine's wiring.
    pub(crate) fn needs_permission(&self, args: &Args) -> bool {
        // A spindle that is stopped needs none.
        let ends = self.name == "spindle" && args.get("speed").and_then(Json::as_f64) == Some(0.0);
        matches!(self.effect, Begins | Powers) && !ends
    }

    /// Returns whether the plugin `remote` judges the lease of it.
    pub(crate) const fn is_judged(&self) -> bool {
        self.is_announced() || matches!(self.action, Jog | ToolChanged)
    }

    /// Returns whether the plugin `remote` must know of it before it begins, as work that a lost lease ends. Of jogs it knows
    /// by itself.
    pub(crate) const fn is_announced(&self) -> bool {
        matches!((self.effect, &self.action), (Begins, Engine(_)))
    }
}

/// Returns the command of this name.
pub(crate) fn find(name: &str) -> Result<&'static Row, Error> {
    let missing = || Error::new(Code::NotFound, format!("there is no command '{name}'"));
    ROWS.iter().find(|row| row.name == name).ok_or_else(missing)
}

#[cfg(test)]
pub(crate) mod tests;
