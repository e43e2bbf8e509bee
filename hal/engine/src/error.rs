//! Every error of a request, in the user's words.

pub(crate) mod hint;
pub(crate) mod loading;
pub(crate) mod near;
pub(crate) mod plugin;
mod text;
pub(crate) mod watch;

use hal_protocol::Type;

/// The reason why a pin, signal or parameter is not changed by people elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// The component at the end of its values takes commands.
    Commands,
    /// The component at the end of its values drives the machine.
    Drives,
}

/// The reason why a request was refused. Messages that users know are worded as in LinuxCNC.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum Error {
    NameTooLong {
        what: &'static str,
        name: Box<str>,
    },
    BadName {
        what: &'static str,
        name: Box<str>,
    },
    Duplicate {
        what: &'static str,
        name: Box<str>,
    },
    NotFound {
        what: &'static str,
        name: Box<str>,
        near: Option<Box<str>>,
    },
    NoItem {
        what: &'static str,
        name: Box<str>,
        near: Option<Box<str>>,
    },
    NoPin {
        name: Box<str>,
        near: Option<Box<str>>,
    },
    Locked {
        what: &'static str,
    },
    LinkedElsewhere {
        pin: Box<str>,
        signal: Box<str>,
        wanted: Box<str>,
    },
    AlreadyLinked {
        pin: Box<str>,
        signal: Box<str>,
    },
    TypeMismatch {
        pin: Box<str>,
        pin_type: Type,
        signal: Box<str>,
        signal_type: Type,
    },
    CannotAdd {
        signal: Box<str>,
        ty: Type,
        pin: Box<str>,
        pin_type: Type,
    },
    HasWriter {
        signal: Box<str>,
        io: bool,
    },
    SecondWriter {
        signal: Box<str>,
        direction: &'static str,
        pin: Box<str>,
        other_direction: &'static str,
        other: Box<str>,
    },
    PortIo {
        signal: Box<str>,
    },
    PortReaders {
        signal: Box<str>,
    },
    NoPins,
    SignalIsPin {
        name: Box<str>,
    },
    NoSignals,
    NotWritable {
        what: &'static str,
        name: Box<str>,
        why: &'static str,
    },
    InvalidValue {
        what: &'static str,
        name: Box<str>,
        expects: &'static str,
    },
    OutOfRange {
        what: &'static str,
        name: Box<str>,
        expects: &'static str,
    },
    QueueAllocated {
        name: Box<str>,
    },
    BadPosition(i64),
    PositionTooFar {
        position: i64,
        most: i64,
    },
    OneThreadOnly {
        funct: Box<str>,
    },
    NeedsFp(Box<str>, Box<str>),
    NotInUse {
        funct: Box<str>,
    },
    NotInThread {
        funct: Box<str>,
        thread: Box<str>,
    },
    InitDone {
        thread: Box<str>,
        funct: Box<str>,
    },
    PeriodTooShort {
        name: Box<str>,
        period: i64,
        existing: i64,
    },
    BadPeriod {
        name: Box<str>,
        period: i64,
    },
    ModuleExists {
        name: Box<str>,
        /// True if a second load with other names of instances is possible.
        again: bool,
    },
    NoModule {
        name: Box<str>,
        searched: Box<str>,
        near: Option<Box<str>>,
    },
    Plugin(crate::PluginError),
    UnknownParameter {
        word: Box<str>,
        near: Option<Box<str>>,
        takes: Box<str>,
    },
    InvalidParameter {
        word: Box<str>,
    },
    InvalidArgument {
        value: Box<str>,
        word: Box<str>,
        expects: &'static str,
        doc: Box<str>,
    },
    ArgumentRange {
        value: Box<str>,
        word: Box<str>,
        expects: Box<str>,
        doc: Box<str>,
    },
    TooManyItems {
        name: Box<str>,
        most: u32,
    },
    TooManyComponents {
        name: Box<str>,
        most: usize,
    },
    MissingArgument {
        name: Box<str>,
        doc: Box<str>,
    },
    CountAndNames,
    InitFailed {
        name: Box<str>,
        why: Box<str>,
        code: i32,
    },
    OpenFailed {
        name: Box<str>,
        why: Box<str>,
    },
    NotLoaded {
        name: Box<str>,
    },
    NotRealtime {
        name: Box<str>,
    },
    NotAProgram {
        name: Box<str>,
    },
    InUseBy {
        name: Box<str>,
        user: Box<str>,
    },
    Stuck {
        thread: Box<str>,
        funct: Box<str>,
    },
    ThreadsLate,
    WorkerStuck {
        worker: Box<str>,
        component: Box<str>,
    },
    TooManyStores {
        stores: usize,
    },
    Faulted {
        funct: Box<str>,
    },
    WorkerFailed {
        worker: Box<str>,
    },
    OutOfMemory,
    CommandFailed {
        why: Box<str>,
        code: i32,
    },
    NoTicket {
        id: u64,
    },
    NotVirtual,
    NotStarted,
    NotAMember,
    Guarded {
        what: &'static str,
        name: Box<str>,
        to: Box<str>,
        guard: Guard,
    },
    NotFromAfar,
    NoSocket,
    StreamTaken {
        name: Box<str>,
    },
    File {
        path: Box<str>,
        why: Box<str>,
    },
    Watch(crate::WatchError),
    Loading(Box<crate::Loading>),
    System {
        what: &'static str,
        why: Box<str>,
    },
    Protocol {
        why: Box<str>,
    },
    ServiceTaken {
        name: Box<str>,
        by: Box<str>,
    },
    NoService {
        name: Box<str>,
        version: u32,
    },
}
