//! What a word of a command may be: completion reads it from the table of commands.

/// What one argument of a command may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// One of these.
    One(&'static [&'static str]),
    /// What any of these may be.
    Any(&'static [Word]),
    /// From here on, each is one of these.
    Many(&'static [Word]),
    /// Something that nobody can guess: a new name, a number, a text.
    Free,
    /// A component type that `loadrt` finds.
    Module,
    /// An argument of the component type that was named before.
    ModuleArg,
    /// A component that is loaded.
    Component,
    /// A component of a plugin.
    RealtimeComponent,
    /// A component of a program.
    ProgramComponent,
    /// A program that can be started.
    Program,
    /// A pin.
    Pin,
    /// A pin without signal.
    LonePin,
    /// A pin with a signal.
    LinkedPin,
    /// A pin that may join the signal that was named first.
    PinForSignal,
    /// A pin or parameter.
    Item,
    /// A pin or parameter that can be set.
    SettableItem,
    /// A pin or, after `param`, a parameter.
    ItemOfKind,
    /// The same, with a second name.
    AliasOfKind,
    /// A signal.
    Signal,
    /// A signal that no pin writes.
    SettableSignal,
    /// A signal that the pin that was named first may join.
    SignalForPin,
    /// A value for the pin, parameter or signal that was named before.
    Value,
    /// A function that can be added to a thread.
    FreeFunct,
    /// A function in a thread.
    UsedFunct,
    /// A thread.
    Thread,
    /// A thread that has the function that was named first.
    ThreadOfFunct,
    /// A type of signals.
    Type,
    /// What the kind of thing that was named first is called.
    NameOfKind,
    /// A pin, signal or parameter.
    Variable,
    /// A command that components offer.
    ComponentCommand,
    /// A command of the table.
    Topic,
    /// A file.
    File,
}
