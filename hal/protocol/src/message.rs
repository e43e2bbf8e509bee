//! What a client may ask.

use crate::{Direction, FlightSpec, Kind, Lock, SampleSpec, Type, Value};
use serde::{Deserialize, Serialize};

/// The version of this protocol; both sides must agree.
pub const LATEST: u32 = 1;

/// The longest request on a socket, in bytes.
pub const LONGEST: usize = 4 << 20;

/// A line of a file that is applied, and what it asks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edit {
    /// The file, by its place in [`Request::Apply`]'s list.
    pub file: u32,
    /// The line in it.
    pub line: u32,
    /// What it asks.
    pub request: Request,
}

/// What a client may ask.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Request {
    /// Who calls; the first request on a socket. A client is listed as component NAME.
    /// Answer: [`crate::Reply::Hello`].
    Hello {
        /// [`LATEST`].
        protocol: u32,
        /// The name that `show comp` gives it, such as `halcmd1234`; empty: not listed.
        name: String,
        /// Its process.
        pid: i32,
    },
    /// `loadrt MODULE ARGS…`.
    Load {
        /// The component type.
        module: String,
        /// `NAME=VALUE` each.
        args: Vec<String>,
    },
    /// `loadrt --c [--prefix P] MODULE ARGS…`: a component in C, whatever plugin has its name.
    LoadForeign {
        /// The file, without its ending.
        module: String,
        /// `NAME=VALUE` each.
        args: Vec<String>,
        /// What every name that it makes begins with.
        prefix: String,
    },
    /// `unloadrt NAME`.
    Unload {
        /// The component.
        name: String,
    },
    /// `unloadrt all`: newest first.
    UnloadAll,
    /// `newsig`.
    NewSignal {
        /// Its name.
        name: String,
        /// Its type.
        ty: Type,
    },
    /// `delsig NAME`; `delsig all` when the name is absent.
    DeleteSignal {
        /// Its name, or all.
        name: Option<String>,
    },
    /// `net SIGNAL PINS…`, whole or not at all.
    Net {
        /// The signal, made if needed.
        signal: String,
        /// The pins, arrows removed.
        pins: Vec<String>,
    },
    /// `linkps PIN SIGNAL` and `linksp`.
    Link {
        /// The pin.
        pin: String,
        /// The signal.
        signal: String,
    },
    /// `unlinkp`.
    Unlink {
        /// The pin.
        pin: String,
    },
    /// `setp`: a pin or parameter; the text is parsed by its type.
    Set {
        /// The pin or parameter.
        name: String,
        /// As the user wrote it.
        value: String,
    },
    /// `getp`, `ptype`. Answer: [`crate::Reply::Value`].
    Get {
        /// The pin or parameter.
        name: String,
    },
    /// `sets`.
    SetSignal {
        /// The signal.
        name: String,
        /// As the user wrote it.
        value: String,
    },
    /// `gets`, `stype`. Answer: [`crate::Reply::Value`].
    GetSignal {
        /// The signal.
        name: String,
    },
    /// `addf FUNCT THREAD POSITION`.
    AddFunct {
        /// The function.
        funct: String,
        /// The thread.
        thread: String,
        /// N: the N-th from the start, -N: from the end; -1 is last.
        position: i64,
        /// Run once in the thread's first cycle instead (`initf`).
        init: bool,
    },
    /// `delf`.
    RemoveFunct {
        /// The function.
        funct: String,
        /// The thread; absent: all threads.
        thread: Option<String>,
    },
    /// `start`.
    Start,
    /// `stop`.
    Stop,
    /// `alias`.
    Alias {
        /// Whether it is a parameter.
        param: bool,
        /// The item.
        name: String,
        /// Its new name.
        alias: String,
    },
    /// `unalias`.
    Unalias {
        /// Whether it is a parameter.
        param: bool,
        /// The item or its alias.
        name: String,
    },
    /// `lock`, `unlock`: sets the level.
    SetLock {
        /// The new level.
        level: Lock,
    },
    /// `unlock`: takes bits away from the level.
    ClearLock {
        /// Those bits.
        bits: Lock,
    },
    /// `apply`: every edit at one boundary between cycles, or none. Answer: [`crate::Reply::Applied`] or
    /// [`crate::Reply::Refused`].
    Apply {
        /// The names of the files that the edits come from.
        files: Vec<String>,
        /// In order; each sees what those before it did.
        edits: Vec<Edit>,
        /// Only say whether it could be.
        dry: bool,
    },
    /// `show` and `list`. Answer: the list of the kind.
    List {
        /// Of what.
        kind: Kind,
        /// An item is listed if any matches; none: all.
        patterns: Vec<String>,
        /// Only items of this type.
        ty: Option<Type>,
    },
    /// `status`. Answer: [`crate::Reply::Status`].
    Status,
    /// `order`. Answer: [`crate::Reply::Order`].
    Order,
    /// One component. Answer: [`crate::Reply::Components`] with none or one.
    Component {
        /// Its name.
        name: String,
    },
    /// `timing on|off [THREAD]`: whether functions are timed (`.time`, `.tmax`).
    Timing {
        /// The thread; absent: all.
        thread: Option<String>,
        /// Whether they are.
        on: bool,
    },
    /// `debug LEVEL`: what components' messages are shown.
    MessageLevel {
        /// 0 none, 1 errors, 2 warnings, 3 information, 4 and 5 everything.
        level: u8,
    },
    /// `run T`: moves the virtual clock; answered when it has moved.
    Run {
        /// How far, in nanoseconds.
        ns: u64,
    },
    /// `COMPONENT.VERB name=value …`. Answer: [`crate::Reply::Answer`].
    Command {
        /// Such as `motion.jog`.
        name: String,
        /// `NAME=VALUE` each.
        args: Vec<String>,
    },
    /// How far a command has come. Answer: [`crate::Reply::Ticket`].
    Ticket {
        /// From [`crate::Answer::ticket`].
        id: u64,
        /// Answer only when it is no longer under way; the virtual clock moves meanwhile.
        wait: bool,
    },
    /// Waits; answered after that time on the wall.
    Idle {
        /// Milliseconds on the wall.
        ms: u32,
        /// Whether the virtual clock moves meanwhile.
        flow: bool,
    },
    /// As [`Self::Idle`] with a moving clock, while a script waits for the end of a program: if that
    /// one is at a shared ring, the clock moves no further than the program needs.
    Await {
        /// Milliseconds on the wall.
        ms: u32,
        /// The program's process.
        pid: i32,
    },
    /// A program that this client started: it ends with the engine, and the virtual clock waits
    /// until it has joined or ended, or has been running for a second.
    Adopt {
        /// Its process.
        pid: i32,
        /// Its name.
        program: String,
    },
    /// `unloadusr NAME`: SIGTERM to its process; absent: to all.
    EndProgram {
        /// The component, or all.
        name: Option<String>,
    },
    /// Starts recording to a VCD file; changes only.
    Record {
        /// The file; it is created or replaced.
        path: String,
        /// Which pins, signals and parameters; none: all but times.
        patterns: Vec<String>,
    },
    /// Ends the recording and closes the file.
    EndRecord,
    /// Makes this client a component with pins of its own.
    Join {
        /// The component's name.
        name: String,
        /// The period of its polls in nanoseconds of machine time, 1000 to 1000000000000; zero: it
        /// does not poll.
        poll_ns: u64,
    },
    /// Makes a pin of this client's component.
    NewPin {
        /// Absolute name.
        name: String,
        /// Its type.
        ty: Type,
        /// Its direction.
        direction: Direction,
    },
    /// This client's component is complete.
    Ready,
    /// Writes the pins of this client, which has joined with a period, then waits for its next poll
    /// and reads all of them, in order of creation. Answer: [`crate::Reply::Values`].
    Poll {
        /// Pin (by order of creation) and value.
        writes: Vec<(u32, Value)>,
    },
    /// Attaches to a shared ring; its file descriptor comes with the answer [`crate::Reply::Stream`].
    Attach {
        /// Such as `sampler.0`.
        name: String,
        /// How many records the program is going to take, if it knows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        count: Option<u64>,
    },
    /// `flight on`: keeps the latest changes of every pin and signal, and has them written when
    /// something happens.
    Flight(FlightSpec),
    /// `flight off`.
    EndFlight,
    /// `flight save`: begins to write what there is; [`Self::FlightState`] says what came of it.
    SaveFlight {
        /// The file; its ending says how.
        path: String,
        /// The last event, rather than what there is now.
        last: bool,
    },
    /// `flight`. Answer: [`crate::Reply::Flight`].
    FlightState,
    /// Samples pins, signals and parameters until [`Self::EndSample`] or this client goes; the file
    /// descriptor of the ring comes with the answer [`crate::Reply::Sample`].
    Sample(SampleSpec),
    /// How a sample of this client's is. Answer: [`crate::Reply::SampleState`].
    SampleState {
        /// From [`crate::SampleInfo::id`].
        id: u64,
    },
    /// Ends a sample of this client's. Answer: [`crate::Reply::SampleState`], as it was at the end.
    EndSample {
        /// From [`crate::SampleInfo::id`].
        id: u64,
    },
    /// `check`: what is wrong or odd with the machine as it is. Answer: [`crate::Reply::Findings`].
    Check,
    /// Ends the engine.
    Shutdown,
}
