//! Possible values of a command's argument, which completion reads from the table of commands.

/// Possible values of an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// A word from this list.
    One(&'static [&'static str]),
    /// Any value of these kinds.
    Any(&'static [Word]),
    /// This and every further argument is a value of these kinds.
    Many(&'static [Word]),
    /// A value that cannot be completed: a new name, a number or a text.
    Free,
    /// A component type that `loadrt` finds.
    Module,
    /// A component type that has a manual page; needs no instance.
    Manual,
    /// The code of a finding.
    Code,
    /// An argument of the component type named before.
    ModuleArg,
    /// A loaded component.
    Component,
    /// A component of a plugin.
    RealtimeComponent,
    /// A component of a program.
    ProgramComponent,
    /// A program that can be started.
    Program,
    /// A pin.
    Pin,
    /// A pin without a signal.
    LonePin,
    /// A pin with a signal.
    LinkedPin,
    /// A pin that may join the signal named first.
    PinForSignal,
    /// A pin or parameter.
    Item,
    /// A pin or parameter that can be set.
    SettableItem,
    /// A pin or, after `param`, a parameter.
    ItemOfKind,
    /// A pin or, after `param`, a parameter that has an alias.
    AliasOfKind,
    /// A signal.
    Signal,
    /// A signal that no pin writes.
    SettableSignal,
    /// A signal that the pin named first may join.
    SignalForPin,
    /// A value for the pin, parameter or signal named before.
    Value,
    /// A function that can be added to a thread.
    FreeFunct,
    /// A function in a thread.
    UsedFunct,
    /// A thread.
    Thread,
    /// A thread that has the function named first.
    ThreadOfFunct,
    /// A snapshot of a component.
    Snapshot,
    /// A signal type.
    Type,
    /// The name of an item of the kind named first.
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
