//! The sentence of each error.

use super::{Error, Guard, hint};

impl core::fmt::Display for Error {
    #[expect(clippy::too_many_lines, reason = "one line for each sentence")]
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NameTooLong { what, name } => write!(f, "{what} name '{name}' is too long"),
            Self::BadName { what, name } => write!(f, "'{name}' cannot be the name of a {what}"),
            Self::Duplicate { what, name } => write!(f, "duplicate {what} '{name}'"),
            Self::NotFound { what, name, .. } => write!(f, "{what} '{name}' not found"),
            Self::NoItem { what, name, .. } => write!(f, "{what} '{name}': not found"),
            Self::NoPin { name, .. } => write!(f, "Pin '{name}' does not exist"),
            Self::Locked { what } => f.write_str(&hint::locked(what)),
            Self::LinkedElsewhere { pin, signal, wanted } => {
                write!(f, "pin '{pin}' is linked to '{signal}', cannot link to '{wanted}'")
            }
            Self::AlreadyLinked { pin, signal } => {
                write!(f, "Pin '{pin}' was already linked to signal '{signal}'")
            }
            Self::TypeMismatch { pin, signal, .. } => {
                write!(f, "type mismatch '{pin}' <- '{signal}'")
            }
            Self::CannotAdd { signal, ty, pin, pin_type } => write!(
                f,
                "Signal '{signal}' of type '{}' cannot add pin '{pin}' of type '{}'",
                ty.name(),
                pin_type.name()
            ),
            Self::HasWriter { signal, io: false } => {
                write!(f, "signal '{signal}' already has output or I/O pin(s)")
            }
            Self::HasWriter { signal, io: true } => {
                write!(f, "signal '{signal}' already has output pin")
            }
            Self::SecondWriter { signal, direction, pin, other_direction, other } => write!(
                f,
                "Signal '{signal}' can not add {direction} pin '{pin}', it already has \
                 {other_direction} pin '{other}'"
            ),
            Self::PortIo { signal } => {
                write!(f, "signal '{signal}' is a port and cannot have I/O pin(s)")
            }
            Self::PortReaders { signal } => {
                write!(f, "signal '{signal}' is a port and can only have one input pin")
            }
            Self::NoPins => f.write_str("'net' requires at least one pin, none given"),
            Self::SignalIsPin { name } => write!(
                f,
                "Signal name '{name}' must not be the same as a pin.  Did you omit the signal \
                 name?"
            ),
            Self::NoSignals => f.write_str("no signals found to be deleted"),
            Self::NotWritable { what, name, .. } => write!(f, "{what} '{name}': not writable"),
            Self::InvalidValue { what, name, .. } => write!(f, "{what} '{name}': invalid argument"),
            Self::OutOfRange { what, name, .. } => {
                write!(f, "{what} '{name}': value out of range")
            }
            Self::QueueAllocated { name } => {
                write!(f, "signal '{name}': queue already allocated")
            }
            Self::BadPosition(position) => write!(f, "bad position: {position}"),
            Self::PositionTooFar { position, .. } => {
                let way = if *position > 0 { "high" } else { "low" };
                write!(f, "position '{position}' is too {way}")
            }
            Self::OneThreadOnly { funct } => {
                write!(f, "function '{funct}' may only be added to one thread")
            }
            Self::NeedsFp(funct, _) => write!(f, "function '{funct}' needs FP"),
            Self::NotInUse { funct } => write!(f, "function '{funct}' is not in use"),
            Self::NotInThread { funct, thread } => {
                write!(f, "thread '{thread}' doesn't use {funct}")
            }
            Self::InitDone { thread, funct } => write!(
                f,
                "initf: thread '{thread}' init cycle already executed; '{funct}' was NOT registered"
            ),
            Self::PeriodTooShort { period, existing, .. } => write!(
                f,
                "new thread period {period} is less than existing thread period {existing}"
            ),
            Self::BadPeriod { name, period } => {
                write!(f, "thread '{name}' cannot have the period {period} ns")
            }
            Self::ModuleExists { name, .. } => write!(f, "{name}: already exists"),
            Self::NoModule { name, searched, .. } => {
                write!(f, "{name}: no plugin library offers this component (searched {searched})")
            }
            Self::Plugin(e) => e.fmt(f),
            Self::UnknownParameter { word, .. } => write!(f, "Unknown parameter `{word}'"),
            Self::InvalidParameter { word } => write!(f, "Invalid parameter `{word}'"),
            Self::InvalidArgument { value, word, .. } => {
                write!(f, "`{value}' invalid for parameter `{word}'")
            }
            Self::ArgumentRange { value, word, .. } => {
                write!(f, "`{value}' out of range for parameter `{word}'")
            }
            Self::TooManyItems { name, most } => {
                write!(f, "{name}: can only take {most} arguments")
            }
            Self::TooManyComponents { name, most } => {
                write!(
                    f,
                    "{name}: there are {most} components already, and an instance has no more"
                )
            }
            Self::MissingArgument { name, .. } => write!(f, "parameter `{name}' is missing"),
            Self::CountAndNames => f.write_str("count= and names= are mutually exclusive"),
            Self::InitFailed { name, why, .. } | Self::OpenFailed { name, why } => {
                write!(f, "{name}: {why}")
            }
            Self::NotLoaded { name } => write!(f, "component '{name}' is not loaded"),
            Self::NotRealtime { name } => write!(f, "component '{name}' is not a realtime module"),
            Self::NotAProgram { name } => write!(f, "'{name}' is not a userspace component"),
            Self::InUseBy { name, user } => {
                write!(f, "component '{name}' is in use by component '{user}'")
            }
            Self::Stuck { thread, funct } => {
                write!(f, "thread '{thread}' is stuck in its cycle, in function '{funct}'")
            }
            Self::ThreadsLate => f.write_str(
                "no thread has begun a cycle: this computer gives them no time; try again when it \
                 is less busy",
            ),
            Self::WorkerStuck { worker, component } => {
                write!(f, "worker '{worker}' of component '{component}' does not return")
            }
            Self::TooManyStores { stores } => write!(
                f,
                "this change takes {stores} stores at once; at most 256 are made while threads run"
            ),
            Self::Faulted { funct } => {
                write!(f, "function '{funct}' has failed: threads stay stopped")
            }
            Self::WorkerFailed { worker } => {
                write!(f, "worker '{worker}' has failed: threads stay stopped")
            }
            Self::OutOfMemory => f.write_str("insufficient memory"),
            Self::CommandFailed { why, .. } | Self::Protocol { why } => f.write_str(why),
            Self::NoTicket { id } => write!(f, "no command with ticket {id} is known"),
            Self::NotVirtual => f.write_str("'run' moves the virtual clock; this one is real"),
            Self::NotStarted => {
                f.write_str("the threads are not running, so the command cannot execute")
            }
            Self::NoSocket => f.write_str("pages go to programs: ask for them on the socket"),
            Self::NotAMember => f.write_str("this client has not joined as a component"),
            Self::Guarded { what, name, to, guard } => {
                let does = match guard {
                    Guard::Commands => "takes commands",
                    Guard::Drives => "drives the machine",
                };
                write!(
                    f,
                    "{what} '{name}' leads to '{to}', which {does}: it is not changed from afar"
                )
            }
            Self::NotFromAfar => f.write_str("this is done at the machine, and not from afar"),
            Self::StreamTaken { name } => {
                write!(f, "stream '{name}' is in use by another program")
            }
            Self::File { path, why } => write!(f, "{path}: {why}"),
            Self::Watch(e) => e.fmt(f),
            Self::Loading(e) => e.fmt(f),
            Self::System { what, why } => write!(f, "{what}: {why}"),
            Self::ServiceTaken { name, by } => {
                let are = if name.ends_with('s') { "are" } else { "is" };
                write!(f, "{name} {are} loaded already, by component '{by}'")
            }
            Self::NoService { name, version } => {
                write!(f, "no {name} (version {version}) are loaded")
            }
        }
    }
}
