//! Orders to a machine: its commands by the names that the task gives them, also where there is no task.

use crate::{CommandInfo, Kind, Missing, Reply, Request, Stops};
use std::{collections::BTreeMap, fmt};

/// Names of the commands that belong to a machine.
const PATTERNS: [&str; 5] = ["motion.*", "iocontrol.*", "task.*", "remote.*", "robot.*"];
/// Argument with the stop epoch in which an order was given.
const EPOCH: &str = "epoch";
/// The command whose presence says that there is motion, and the beginning of those of a robot behind its own controller.
const MOTION: &str = "motion.abort";
const ROBOT: &str = "robot.";
/// The command whose presence says that there is a task.
const TASK: &str = "task.run";
/// Reset of the e-stop on a machine without a task.
const RESET: &str = "iocontrol.estop-reset";

/// Effect of a command of the task on a machine without one.
enum Without {
    /// This command does it, with these arguments called otherwise.
    Command(&'static str, &'static [(&'static str, &'static str)]),
    /// The mode follows what moves: manual is in force always.
    Mode,
    /// Nothing: what is named needs a task.
    Needs(&'static str),
}

use Without::{Command, Mode, Needs};

const PROGRAMS: Without = Needs("programs");
const LINES: Without = Needs("lines of G-code (MDI)");

/// Commands of the task, and what they are on a machine without one.
const WITHOUT_TASK: &[(&str, Without)] = &[
    ("task.on", Command("motion.enable", &[])),
    ("task.estop-reset", Command(RESET, &[])),
    ("task.home", Command("motion.home", &[])),
    ("task.resume", Command("motion.resume", &[])),
    ("task.step", Command("motion.step", &[])),
    ("task.feed-override", Command("motion.feed", &[("scale", "override")])),
    ("task.rapid-override", Command("motion.feed", &[("scale", "rapid-override")])),
    ("task.spindle-override", Command("motion.spindle", &[("scale", "override")])),
    ("task.mode", Mode),
    ("task.open", PROGRAMS),
    ("task.run", PROGRAMS),
    ("task.run-from", PROGRAMS),
    ("task.recover", PROGRAMS),
    ("task.confirm", PROGRAMS),
    ("task.start", PROGRAMS),
    ("task.optional-stop", PROGRAMS),
    ("task.block-delete", PROGRAMS),
    ("task.mdi", LINES),
    ("task.mdi-brief", LINES),
];

/// Reason why a machine without a task cannot do something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unserved {
    /// A task is missing, which this needs.
    Task(&'static str),
    /// There is no e-stop that could be reset.
    Reset,
}

impl fmt::Display for Unserved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Task(what) => {
                write!(f, "{what} need a task, and this machine has none: loadrt task")
            }
            Self::Reset => {
                f.write_str("this machine has no e-stop that could be reset: switch it on")
            }
        }
    }
}

/// Reason why a machine cannot be commanded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unlisted {
    /// Answer of the engine that lists no commands.
    NoList,
    /// Something moves that its commands cannot stop.
    Missing(Missing),
}

impl fmt::Display for Unlisted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoList => f.write_str("the engine lists no commands"),
            Self::Missing(missing) => missing.fmt(f),
        }
    }
}

/// The commands that a machine offers, as its clients ask for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Orders {
    stops: Stops,
    /// Names of the commands; true for one that takes the stop epoch in which it was given.
    commands: BTreeMap<String, bool>,
}

impl Orders {
    /// Returns the request for the commands of a machine, from whose answer [`Self::listed`] finds its orders.
    #[must_use]
    pub fn list() -> Request {
        let patterns = PATTERNS.map(str::to_owned).to_vec();
        Request::List { kind: Kind::Commands, patterns, ty: None }
    }

    /// Finds the orders of a machine from the answer to [`Self::list`].
    ///
    /// # Errors
    /// The answer has no commands, or something moves that they cannot stop.
    pub fn listed(answer: &Reply) -> Result<Self, Unlisted> {
        match answer {
            Reply::Commands(commands) => Self::of(commands).map_err(Unlisted::Missing),
            _ => Err(Unlisted::NoList),
        }
    }

    /// Finds the orders of a machine that offers these commands.
    ///
    /// # Errors
    /// Something moves that these commands cannot stop.
    pub fn of(commands: &[CommandInfo]) -> Result<Self, Missing> {
        let stops = Stops::of(commands)?;
        // Beside motion, whose epoch is known, that of a robot is another one.
        let has_motion = commands.iter().any(|c| c.name == MOTION);
        let takes = |c: &CommandInfo| {
            c.args.iter().any(|arg| arg.name == EPOCH) && !(has_motion && c.name.starts_with(ROBOT))
        };
        let commands = commands.iter().map(|c| (c.name.clone(), takes(c))).collect();
        Ok(Self { stops, commands })
    }

    /// Returns the stops.
    #[must_use]
    pub const fn stops(&self) -> &Stops {
        &self.stops
    }

    /// Returns whether the machine offers a command of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.commands.contains_key(name)
    }

    /// Returns whether the machine has a task.
    #[must_use]
    pub fn has_task(&self) -> bool {
        self.has(TASK)
    }

    /// Returns the request for a command. On a machine without a task, a command of the task becomes the one that does the
    /// same, and `None` where there is nothing to do.
    ///
    /// # Errors
    /// It needs a task, or there is no e-stop that could be reset.
    pub fn request(&self, name: &str, args: Vec<String>) -> Result<Option<Request>, Unserved> {
        let plain = |name: &str, args| Ok(Some(Request::Command { name: name.to_owned(), args }));
        let row = WITHOUT_TASK.iter().find(|(task, _)| *task == name && !self.has(name));
        match row.map(|(_, without)| without) {
            None => plain(name, args),
            Some(Command(RESET, _)) if !self.has(RESET) => Err(Unserved::Reset),
            Some(Command(other, names)) => {
                plain(other, args.into_iter().map(|arg| renamed(arg, names)).collect())
            }
            Some(Mode) if args.iter().all(|arg| arg == "mode=manual") => Ok(None),
            Some(Mode) => Err(Unserved::Task("programs and lines of G-code (MDI)")),
            Some(Needs(what)) => Err(Unserved::Task(what)),
        }
    }

    /// Stamps a request with the stop epoch in which it was given, if its command takes one: after a stop since then it is
    /// refused.
    #[must_use]
    pub fn stamped(&self, mut request: Request, epoch: Option<u64>) -> Request {
        if let (Request::Command { name, args }, Some(epoch)) = (&mut request, epoch)
            && self.commands.get(name) == Some(&true)
        {
            args.push(format!("{EPOCH}={epoch}"));
        }
        request
    }
}

/// Returns an argument `NAME=VALUE` under the name that the other command has for it.
fn renamed(arg: String, names: &[(&str, &str)]) -> String {
    let Some((name, value)) = arg.split_once('=') else { return arg };
    match names.iter().find(|(from, _)| *from == name) {
        Some((_, to)) => format!("{to}={value}"),
        None => arg,
    }
}

#[cfg(test)]
mod tests {
    use super::{Orders, WITHOUT_TASK};
    use crate::{ArgInfo, Bounds, CommandInfo, Reply, Request};

    fn info(name: &str) -> CommandInfo {
        let (name, args) = name.split_once(' ').unwrap_or((name, ""));
        let args = args.split_whitespace().map(|name| ArgInfo {
            name: name.to_owned(),
            ty: "int".to_owned(),
            doc: String::new(),
            required: false,
            default: None,
            bounds: Bounds::default(),
            unit: String::new(),
        });
        CommandInfo { name: name.to_owned(), doc: String::new(), args: args.collect() }
    }

    fn orders(names: &[&str]) -> Orders {
        Orders::of(&names.iter().map(|name| info(name)).collect::<Vec<_>>()).unwrap()
    }

    fn text(request: Request) -> String {
        let Request::Command { name, args } = request else { return format!("{request:?}") };
        [&[name][..], &args].concat().join(" ")
    }

    fn check(orders: &Orders, line: &str, expected: &str) {
        let mut words = line.split(' ');
        let name = words.next().unwrap();
        let got = match orders.request(name, words.map(str::to_owned).collect()) {
            Ok(Some(request)) => text(request),
            Ok(None) => "nothing".to_owned(),
            Err(why) => why.to_string(),
        };
        assert_eq!(got, expected, "{line}");
    }

    #[test]
    fn a_machine_without_a_task_does_what_motion_and_iocontrol_do() {
        let bare = orders(&["motion.enable", "motion.home joint epoch", "iocontrol.estop-reset"]);
        assert!(!bare.has_task());
        for (line, expected) in [
            ("task.on", "motion.enable"),
            ("task.estop-reset", "iocontrol.estop-reset"),
            ("task.home joint=all", "motion.home joint=all"),
            ("task.resume", "motion.resume"),
            ("task.feed-override scale=0.5", "motion.feed override=0.5"),
            ("task.rapid-override scale=0.5", "motion.feed rapid-override=0.5"),
            ("task.spindle-override scale=2 spindle=1", "motion.spindle override=2 spindle=1"),
            ("task.mode mode=manual", "nothing"),
            (
                "task.mode mode=auto",
                "programs and lines of G-code (MDI) need a task, and this machine has none: loadrt task",
            ),
            ("task.run", "programs need a task, and this machine has none: loadrt task"),
            (
                "task.mdi text=G0",
                "lines of G-code (MDI) need a task, and this machine has none: loadrt task",
            ),
            ("motion.spindle speed=0", "motion.spindle speed=0"),
        ] {
            check(&bare, line, expected);
        }
        let why = "this machine has no e-stop that could be reset: switch it on";
        check(&orders(&["motion.enable"]), "task.estop-reset", why);
    }

    #[test]
    fn a_machine_with_a_task_asks_the_task() {
        let names: Vec<&str> = WITHOUT_TASK.iter().map(|(name, _)| *name).collect();
        let whole = orders(&names);
        assert!(whole.has_task());
        for name in names {
            check(&whole, name, name);
        }
    }

    #[test]
    fn a_machine_that_is_not_listed_or_cannot_be_stopped_has_no_orders() {
        let commands = |names: &[&str]| Reply::Commands(names.iter().map(|n| info(n)).collect());
        assert!(Orders::listed(&commands(&["motion.enable"])).is_ok());
        let why = |answer| Orders::listed(&answer).unwrap_err().to_string();
        assert_eq!(why(Reply::Done), "the engine lists no commands");
        assert!(why(commands(&["motion.jog"])).contains("motion.jog"));
    }

    #[test]
    fn an_order_is_stamped_where_its_command_takes_the_epoch() {
        let orders = orders(&["motion.enable epoch", "motion.feed"]);
        for (name, epoch, expected) in [
            ("motion.enable", Some(7), "motion.enable epoch=7"),
            ("motion.enable", None, "motion.enable"),
            ("motion.feed", Some(7), "motion.feed"),
        ] {
            let request = orders.request(name, Vec::new()).unwrap().unwrap();
            assert_eq!(text(orders.stamped(request, epoch)), expected);
        }
        // Beside motion, a robot's epoch is not the one that is known.
        for (motion, expected) in
            [("motion.feed", "robot.run epoch=7"), ("motion.abort", "robot.run")]
        {
            let machine =
                super::tests::orders(&["robot.run epoch", "robot.stop", "robot.pause", motion]);
            let request = Request::Command { name: "robot.run".to_owned(), args: Vec::new() };
            assert_eq!(text(machine.stamped(request, Some(7))), expected);
        }
    }
}
