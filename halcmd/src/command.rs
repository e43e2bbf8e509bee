//! Commands, parsed.

use crate::{
    flight::Flight,
    graph::{Format, Wanted},
    watch::Watch,
};
use hal_protocol::{Kind, Lock, Request, Type};

/// A line that was understood.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// One request, and what `-v` says when it is done, in lines.
    Ask(Request, Option<String>),
    /// One request whose value is printed.
    Value(Request),
    /// One request whose value's type is printed.
    TypeOf(Request),
    /// `unload NAME`: whichever kind of component that is.
    Unload(String),
    /// `unload all`.
    UnloadAll,
    /// `loadusr`.
    Launch(Launch),
    /// `waitusr`.
    AwaitEnd(String),
    /// `show`; absent: every section.
    Show(Option<ShowKind>, Option<Type>, Vec<String>),
    /// `list`.
    List(Kind, Vec<String>),
    /// `save`: what, and the file.
    Save(SaveKind, Option<String>),
    /// `status`.
    Status(StatusKind),
    /// `order`: of what, and whether as lines of a script.
    Order(Subject, bool),
    /// `graph`: of what, what of it, how, and the file.
    Graph(Subject, Wanted, Format, Option<String>),
    /// `flight`, when it is no single request.
    Flight(Flight),
    /// `check`, with its words.
    Check(Vec<String>),
    /// `explain`, with its words.
    Explain(Vec<String>),
    /// `man`, with its words.
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
    /// `meter`: what; absent: it is chosen.
    Meter(Option<String>),
    /// `help`.
    Help(Option<String>),
    /// `lock`: the new level, or the bits to clear; absent: a word that means nothing.
    Lock(Option<LockChange>),
    /// `setexact_for_test_suite_only`.
    SetExact,
    /// A component's command.
    Component {
        /// Such as `motion.jog`.
        name: String,
        /// `NAME=VALUE` each.
        args: Vec<String>,
        /// Whether to wait until it is carried out.
        wait: bool,
    },
}

/// A machine to be looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Subject {
    /// The files it is made of; none: the running one.
    pub files: Vec<String>,
    /// The INI file of whose values the files speak.
    pub ini: Option<String>,
}

/// What `apply` was told.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Apply {
    /// The file; absent: standard input.
    pub file: Option<String>,
    /// Where values of `[SECTION]NAME` come from, if not from where they came before.
    pub ini: Option<String>,
    /// Only check.
    pub dry: bool,
}

/// What `loadusr` was told.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Launch {
    /// Wait until the program ends.
    pub until_end: bool,
    /// Wait until its component is ready.
    pub until_ready: bool,
    /// That component's name, if given.
    pub component: Option<String>,
    /// Its status does not matter.
    pub ignore_status: bool,
    /// The program.
    pub program: String,
    /// Its arguments.
    pub args: Vec<String>,
}

impl Launch {
    /// The component it is expected to make: named, or after the program.
    #[must_use]
    pub fn expected(&self) -> String {
        self.component.clone().unwrap_or_else(|| {
            let base = self.program.rsplit('/').next().unwrap_or(&self.program);
            base.split('.').next().unwrap_or(base).to_owned()
        })
    }
}

/// A section of `show`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShowKind {
    /// Things of one kind.
    Of(Kind),
    /// Both kinds of aliases.
    Aliases,
}

/// What `save` writes.
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
    /// What rebuilds the state.
    All,
    /// The same with [`Self::LonePins`].
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

/// What `lock` and `unlock` do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LockChange {
    /// Sets the level.
    To(Lock),
    /// Takes bits away from the level.
    Without(Lock),
}
