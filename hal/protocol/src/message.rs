//! Requests of clients.

use crate::class::requests;
use crate::{CommandLine, Direction, FlightSpec, Kind, Lock, SampleSpec, Type, Value};
use serde::{Deserialize, Serialize};

/// Version of this protocol. Both sides must use the same version.
pub const LATEST: u32 = 1;

/// Maximum length of a request on a socket, in bytes.
pub const MAX_LEN: usize = 4 << 20;

/// A line of an applied file, with its request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edit {
    /// Index of the file in the list of [`Request::Apply`].
    pub file: u32,
    /// Line number in the file.
    pub line: u32,
    /// Request of the line.
    pub request: Request,
}

requests! {
    /// Concerns the client itself: its greeting, its component, its streams and samples.
    Own: OwnRequest {
        /// Introduces the client; the first request on a socket. The client is listed as component
        /// `name`. Answer: [`crate::Reply::Hello`].
        Hello {
            /// Protocol version of the client, [`LATEST`].
            protocol: u32,
            /// Component name that `show comp` prints, such as `halcmd1234`. If empty, the client is
            /// not listed.
            name: String,
            /// Process id of the client.
            pid: i32,
        },
        /// Makes this client a component with its own pins.
        Join {
            /// Name of the component.
            name: String,
            /// Poll period in nanoseconds of machine time, 1000 to 1000000000000. Zero if the client
            /// does not poll.
            poll_ns: u64,
        },
        /// Creates a pin of this client's component.
        NewPin {
            /// Full name of the pin.
            name: String,
            /// Type of the pin.
            ty: Type,
            /// Direction of the pin.
            direction: Direction,
        },
        /// Declares this client's component complete.
        Ready,
        /// Declares this client's component incomplete again: it may create pins.
        Unready,
        /// Removes this client's component and its pins. The connection stays.
        Leave,
        /// Creates the page of shared memory through which this client exchanges the values of its pins ([`crate::PinPage`]), in place
        /// of an older one. On the real clock, the engine exchanges them at the client's poll period and at each request; on the virtual
        /// clock, at the client's own requests and while it sleeps. The file descriptor comes with the answer [`crate::Reply::PinPage`].
        SharePins {
            /// Number of pins that fit, 1 to 32768.
            pins: u32,
        },
        /// Sleeps for this time of the machine. The clock waits for a client with a page whenever that client does
        /// not sleep. Answer: as that of [`Self::Poll`].
        Sleep {
            /// Machine time in nanoseconds, at most 1000000000000.
            ns: u64,
        },
        /// Writes pins of this client, which has joined with a period; then waits for its next poll and
        /// reads all of its pins, in order of creation. Answer: [`crate::Reply::Values`], or
        /// [`crate::Reply::Done`] if the client has a page.
        Poll {
            /// Values to write, each with the index of its pin (in order of creation).
            writes: Vec<(u32, Value)>,
        },
        /// Attaches to a shared ring. Its file descriptor comes with the answer
        /// [`crate::Reply::Stream`].
        Attach {
            /// Name of the ring, such as `sampler.0`.
            name: String,
            /// Number of records that the program will take, if it is known.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            count: Option<u64>,
        },
        /// Makes a ring between this client and another one, which attaches by its name; it is there until this
        /// client disconnects. Each of the two may write or read it. Its file descriptor comes with the answer
        /// [`crate::Reply::Stream`].
        NewStream {
            /// Name of the ring; one of this client is replaced.
            name: String,
            /// Number of slots, of which one always stays empty: 1 to 65536.
            depth: u32,
            /// Type of each value of a record, 1 to 21.
            types: Vec<Type>,
        },
        /// Samples pins, signals and parameters until [`Self::EndSample`] or until this client
        /// disconnects. The file descriptor of the ring comes with the answer [`crate::Reply::Sample`].
        Sample(spec: SampleSpec),
        /// Returns the state of one of this client's samples. Answer: [`crate::Reply::SampleState`].
        SampleState {
            /// Id from [`crate::SampleInfo::id`].
            id: u64,
        },
        /// Ends one of this client's samples. Answer: [`crate::Reply::SampleState`] with the final
        /// state.
        EndSample {
            /// Id from [`crate::SampleInfo::id`].
            id: u64,
        },
        /// Sets the commands that the engine executes when this client's connection ends, in whatever way, in place of
        /// those before: a client that begins a motion which lasts only with it first gives the command that ends it.
        AtEnd {
            /// The commands, at most [`crate::MAX_AT_END`].
            commands: Vec<CommandLine>,
        },
        /// Declares for good that this client speaks for people elsewhere: what they must not change is refused ([`crate::NOT_FROM_AFAR`]).
        SpeakFromAfar,
        /// Maps the page of a snapshot, which this client then reads without further requests. A file descriptor that can only read
        /// comes with the answer [`crate::Reply::SnapshotPage`].
        MapSnapshot {
            /// Name of the snapshot.
            name: String,
        },
    }

    /// Is answered after a wait.
    Wait: WaitRequest {
        /// `run T`: advances the virtual clock. The answer is sent when the clock has advanced.
        Run {
            /// Time to advance, in nanoseconds.
            ns: u64,
        },
        /// Returns the progress of a command. Answer: [`crate::Reply::Ticket`].
        Ticket {
            /// Ticket number, from [`crate::Answer::ticket`].
            id: u64,
            /// Answer only when the command has ended. The virtual clock runs meanwhile.
            wait: bool,
        },
        /// Waits. The answer is sent after this wall-clock time.
        Idle {
            /// Wall-clock time in milliseconds.
            ms: u32,
            /// True if the virtual clock runs meanwhile.
            flow: bool,
        },
        /// As [`Self::Idle`] with a running clock, while a script waits for a program to end. If the
        /// program is attached to a shared ring, the clock advances no further than the program needs.
        Await {
            /// Wall-clock time in milliseconds.
            ms: u32,
            /// Process id of the program.
            pid: i32,
        },
    }

    /// Changes graph, values or locks, and can be reverted: a line of a script for `apply`.
    Edit: EditRequest {
        /// `loadrt MODULE ARGS…`.
        Load {
            /// Component type.
            module: String,
            /// Arguments, each `NAME=VALUE`.
            args: Vec<String>,
        },
        /// `loadrt --c [--prefix P] MODULE ARGS…`: a component in C, even if a plugin has the same
        /// name.
        LoadForeign {
            /// File name without extension.
            module: String,
            /// Arguments, each `NAME=VALUE`.
            args: Vec<String>,
            /// Prefix of every name that the component creates.
            prefix: String,
        },
        /// `unloadrt NAME`.
        Unload {
            /// Name of the component.
            name: String,
        },
        /// `unloadrt all`: unloads all components, newest first.
        UnloadAll,
        /// `newsig`.
        NewSignal {
            /// Name of the signal.
            name: String,
            /// Type of the signal.
            ty: Type,
        },
        /// `delsig NAME`; `delsig all` when the name is absent.
        DeleteSignal {
            /// Name of the signal, or `None` for all signals.
            name: Option<String>,
        },
        /// `net SIGNAL PINS…`. Links all pins or none.
        Net {
            /// Name of the signal. It is created if needed.
            signal: String,
            /// Names of the pins, without arrows.
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
        /// `setp`: sets a pin or parameter. The text is parsed according to its type.
        Set {
            /// The pin or parameter.
            name: String,
            /// Value, as the user wrote it.
            value: String,
        },
        /// `sets`.
        SetSignal {
            /// The signal.
            name: String,
            /// Value, as the user wrote it.
            value: String,
        },
        /// `addf FUNCT THREAD POSITION`.
        AddFunct {
            /// The function.
            funct: String,
            /// The thread.
            thread: String,
            /// Position: N counts from the start, -N from the end; -1 is last.
            position: i64,
            /// Run once in the thread's first cycle instead of in every cycle (`initf`).
            init: bool,
        },
        /// `delf`.
        RemoveFunct {
            /// The function.
            funct: String,
            /// The thread. If absent, all threads.
            thread: Option<String>,
        },
        /// `start`.
        Start,
        /// `alias`.
        Alias {
            /// True for a parameter, false for a pin.
            param: bool,
            /// Name of the pin or parameter.
            name: String,
            /// Alias to give to it.
            alias: String,
        },
        /// `unalias`.
        Unalias {
            /// True for a parameter, false for a pin.
            param: bool,
            /// Name or alias of the pin or parameter.
            name: String,
        },
        /// `lock`, `unlock`: sets the level.
        SetLock {
            /// New level.
            level: Lock,
        },
        /// `unlock`: clears bits of the level.
        ClearLock {
            /// Bits to clear.
            bits: Lock,
        },
    }

    /// Changes nothing.
    Query: QueryRequest {
        /// `getp`, `ptype`. Answer: [`crate::Reply::Value`].
        Get {
            /// The pin or parameter.
            name: String,
        },
        /// `gets`, `stype`. Answer: [`crate::Reply::Value`].
        GetSignal {
            /// The signal.
            name: String,
        },
        /// `show` and `list`. Answer: the list for that kind.
        List {
            /// Kind of things to list.
            kind: Kind,
            /// Patterns. An item is listed if any pattern matches, or if there are none.
            patterns: Vec<String>,
            /// List only items of this type.
            ty: Option<Type>,
        },
        /// `status`. Answer: [`crate::Reply::Status`].
        Status,
        /// `order`. Answer: [`crate::Reply::Order`].
        Order,
        /// Returns one component. Answer: [`crate::Reply::Components`] with zero or one entry.
        Component {
            /// Name of the component.
            name: String,
        },
        /// `flight`. Answer: [`crate::Reply::Flight`].
        FlightState,
        /// `snapshot`: returns the latest record of a snapshot. Answer: [`crate::Reply::Snapshot`].
        Snapshot {
            /// Name of the snapshot, such as `motion.status`.
            name: String,
        },
        /// `check`: looks for problems of the machine in its current state. Answer:
        /// [`crate::Reply::Findings`].
        Check,
    }

    /// Acts on the machine, and cannot be reverted.
    Action: ActionRequest {
        /// `stop`.
        Stop,
        /// `apply`: carries out all edits at one boundary between cycles, or none of them. Answer:
        /// [`crate::Reply::Applied`] or [`crate::Reply::Refused`].
        Apply {
            /// Names of the files that contain the edits.
            files: Vec<String>,
            /// Edits in order. Each edit sees the effect of those before it.
            edits: Vec<Edit>,
            /// Only check whether the edits could be applied.
            dry: bool,
        },
        /// `timing on|off [THREAD]`: switches the timing of functions (`.time`, `.tmax`).
        Timing {
            /// The thread. If absent, all threads.
            thread: Option<String>,
            /// True to switch timing on.
            on: bool,
        },
        /// `debug LEVEL`: sets which messages of components are shown.
        MessageLevel {
            /// Level: 0 none, 1 errors, 2 warnings, 3 information, 4 and 5 everything.
            level: u8,
        },
        /// `COMPONENT.VERB name=value …`. Answer: [`crate::Reply::Answer`].
        Command {
            /// Name, such as `motion.jog`.
            name: String,
            /// Arguments, each `NAME=VALUE`.
            args: Vec<String>,
        },
        /// Ends the engine.
        Shutdown,
    }

    /// Acts on programs or files outside the engine. A dry run leaves it out.
    Outside: OutsideRequest {
        /// Reports a program that this client started. The program ends with the engine. The virtual
        /// clock waits until the program has joined, has ended, or has run for a second.
        Adopt {
            /// Process id of the program.
            pid: i32,
            /// Name of the program.
            program: String,
        },
        /// `unloadusr NAME`: sends SIGTERM to the program's process, or to all programs if the name is
        /// absent.
        EndProgram {
            /// Name of the component, or `None` for all.
            name: Option<String>,
        },
        /// Starts recording changes to a VCD file.
        Record {
            /// Path of the file. It is created or replaced.
            path: String,
            /// Patterns of the pins, signals and parameters to record. If empty, everything except
            /// function times is recorded.
            patterns: Vec<String>,
        },
        /// Ends the recording and closes the file.
        EndRecord,
        /// `flight on`: keeps the latest changes of every pin and signal and writes them to a file when
        /// an event happens.
        Flight(spec: FlightSpec),
        /// `flight off`.
        EndFlight,
        /// `flight save`: starts to write the recorded changes. [`Self::FlightState`] reports the
        /// result.
        SaveFlight {
            /// Path of the file. The extension selects the format.
            path: String,
            /// Write the last event instead of the current recording.
            last: bool,
        },
    }
}
