//! Parsed commands.

mod starter;

use self::starter::Starter;
use crate::graph::{Format, Wanted};
use hal_protocol::{Kind, Lock, Request, Type};

/// A parsed line.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// A request, and the lines that `-v` prints after it.
    Send(Request, Option<String>),
    /// A request whose value is printed.
    Value(Request),
    /// A request, of which the type of the value is printed.
    TypeOf(Request),
    /// `unload NAME`, for any kind of component.
    Unload(String),
    /// `unload all`.
    UnloadAll,
    /// `loadusr`.
    Launch(Launch),
    /// `waitusr`.
    AwaitEnd(String),
    /// `show`; `None` shows every section.
    Show(Option<ShowKind>, Option<Type>, Vec<String>),
    /// `list`.
    List(Kind, Vec<String>),
    /// `save`: parts and file.
    Save(SaveKind, Option<String>),
    /// `status`.
    Status(StatusKind),
    /// `order`: machine, and whether to print lines of a script.
    Order(Subject, bool),
    /// `graph`: machine, selection, format and file.
    Graph(Subject, Wanted, Format, Option<String>),
    /// `flight`, when it takes more than a single request.
    Flight(Flight),
    /// `check`, with its arguments.
    Check(Vec<String>),
    /// `explain`, with its arguments.
    Explain(Vec<String>),
    /// `man`, with its arguments.
    Man(Vec<String>),
    /// `print`.
    Print(Option<String>),
    /// `echo`, `unecho`.
    Echo(bool),
    /// `source`.
    Source(String),
    /// `apply`.
    Apply(Apply),
    /// `completion`: the file for a shell.
    Completion(&'static str),
    /// `watch`.
    Watch(Watch),
    /// `meter`: the item. With `None` the user chooses it.
    Meter(Option<String>),
    /// `help`.
    Help(Option<String>),
    /// `lock`: the new level, or the bits to clear; `None` for a word without a meaning.
    Lock(Option<LockChange>),
    /// `setexact_for_test_suite_only`.
    SetExact,
    /// A component's command.
    Component {
        /// Name, such as `motion.jog`.
        name: String,
        /// Arguments, each `NAME=VALUE`.
        args: Vec<String>,
        /// True to wait until the command is done.
        wait: bool,
    },
}

/// The machine that `order` or `graph` examines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Subject {
    /// Files of the machine; empty for the running instance.
    pub files: Vec<String>,
    /// INI file with the values that the files use.
    pub ini: Option<String>,
}

/// Arguments of `flight` that take more than a single request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flight {
    /// Without arguments: show the state.
    State,
    /// Write the present contents, or the last event.
    Save {
        /// The file.
        path: String,
        /// True for the last event.
        last: bool,
    },
}

/// Selection of values, and the interval.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Watch {
    /// Names, or patterns as in `show`.
    pub patterns: Vec<String>,
    /// Wall-clock interval between two readings, in milliseconds.
    pub every_ms: u32,
    /// Number of readings; `None` to continue until the user stops.
    pub count: Option<u64>,
}

/// Arguments of `apply`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Apply {
    /// File; `None` for standard input.
    pub file: Option<String>,
    /// INI file for values of `[SECTION]NAME`; `None` for the session's own.
    pub ini: Option<String>,
    /// True to check without applying.
    pub dry: bool,
}

/// Arguments of `loadusr`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Launch {
    /// True to wait until the program ends.
    pub until_end: bool,
    /// True to wait until the program's component is ready.
    pub until_ready: bool,
    /// Name of that component, if given.
    pub component: Option<String>,
    /// True to ignore the program's exit status.
    pub ignore_status: bool,
    /// Name or path of the program.
    pub program: String,
    /// Arguments of the program.
    pub args: Vec<String>,
}

/// Beginnings of the paths of devices that programs drive hardware with.
pub(crate) const DEVICES: &[&str] = &[
    "/dev/tty",
    "/dev/serial",
    "/dev/rfcomm",
    "/dev/usb",
    "/dev/hidraw",
    "/dev/input",
    "/dev/i2c",
    "/dev/spi",
    "/dev/gpio",
    "/dev/parport",
    "/dev/can",
    "/dev/comedi",
];

/// Returns the last part of a path.
fn base(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

impl Launch {
    /// Returns the name of the program without its folder; for one that starts another, such as `sudo` or `python3`, that of the
    /// other.
    pub(crate) fn name(&self) -> &str {
        let started = self.started().and_then(|at| self.args.get(at));
        base(started.unwrap_or(&self.program))
    }

    /// Returns the arguments of the program that [`Self::name`] names.
    pub(crate) fn own_args(&self) -> &[String] {
        let from = self.started().map_or(0, |at| at + 1);
        self.args.get(from..).unwrap_or_default()
    }

    /// Returns the place of the program among the arguments, if another one starts it.
    fn started(&self) -> Option<usize> {
        let first = Starter::of(base(&self.program))?.started(&self.args)?;
        let next = |at: &usize| {
            let rest = self.args.get(at + 1..)?;
            Some(at + 1 + Starter::of(base(self.args.get(*at)?))?.started(rest)?)
        };
        core::iter::successors(Some(first), next).last()
    }

    /// Returns whether an argument names a device of a port, a bus or a person's hand.
    pub(crate) fn names_device(&self) -> bool {
        let is_named = |arg: &String| DEVICES.iter().any(|device| arg.contains(device));
        self.args.iter().any(is_named)
    }

    /// Returns the name of the component that the program should make: the given name, or that of
    /// the program.
    #[must_use]
    pub fn expected(&self) -> String {
        self.component.clone().unwrap_or_else(|| {
            let base = base(&self.program);
            base.split('.').next().unwrap_or(base).to_owned()
        })
    }
}

/// A section of `show`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShowKind {
    /// Items of one kind.
    Of(Kind),
    /// Both kinds of aliases.
    Aliases,
}

/// Parts that `save` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveKind {
    /// `loadrt` lines.
    Components,
    /// Aliases.
    Aliases,
    /// Every signal.
    Signals,
    /// Signals without pins.
    LoneSignals,
    /// `linkps`, with arrows if set.
    Links(bool),
    /// `newsig` and `linksp`, with arrows if set.
    Nets(bool),
    /// `net`, with arrows if set.
    NetLines(bool),
    /// Parameters that can be set.
    Params,
    /// Functions in threads.
    Threads,
    /// Input pins without signal.
    LonePins,
    /// All parts that are needed to rebuild the state.
    All,
    /// Like [`Self::All`], with [`Self::LonePins`].
    AllWithPins,
}

/// A part of `status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// Everything.
    All,
    /// Locks.
    Lock,
    /// Counts and memory.
    Memory,
    /// The clock, the threads, faults.
    Instance,
}

/// Change of the lock level by `lock` or `unlock`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LockChange {
    /// Sets the level.
    To(Lock),
    /// Clears bits of the level.
    Without(Lock),
}
