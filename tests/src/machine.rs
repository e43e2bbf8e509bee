//! An engine inside a test, driven by lines of a script.

use crate::{
    plugins::plugins,
    programs::{own_test, passes},
    scratch::{REALTIME, Scratch},
};
use hal_engine::{ClockKind, Ended, Engine, Options, RealtimeOptions};
use hal_protocol::{
    Client, Direction, Edit, Failure, Kind, Link, Lock, Place, Reply, Request, StatusInfo,
    ThreadInfo, Type, Value,
};
use std::{process::Command, sync::mpsc, thread::JoinHandle};

/// An engine that finds the plugins of `tests/plugins`, `threads` and `logic`.
#[derive(Debug)]
pub struct Machine {
    /// The engine.
    pub engine: Engine,
}

/// Returns the options of an engine for a test.
pub fn options(place: Place, clock: ClockKind) -> Options {
    Options { path: vec![plugins().to_owned()], ..bare(place, clock) }
}

/// Returns the same options for an engine that looks for no file.
pub(crate) fn bare(place: Place, clock: ClockKind) -> Options {
    Options { realtime: realtime(), ..Options::simulated(place, clock) }
}

/// Returns the realtime options of tests. Many tests use functions that run for a long time; that alone stops no
/// machine.
pub fn realtime() -> RealtimeOptions {
    let hour = Some(3_600_000_000_000);
    RealtimeOptions { stuck_ns: hour, max_gap_ns: hour, ..RealtimeOptions::default() }
}

/// Returns an engine that has only `threads` and `logic`, looks for no file, and has no socket for clients.
pub fn plain(clock: ClockKind) -> Engine {
    let place = Place::at("/nonexistent", "plain").unwrap();
    with_libraries(Engine::without_socket(bare(place, clock)).unwrap())
}

/// Adds `threads` and `logic`, linked in.
pub(crate) fn with_libraries(mut engine: Engine) -> Engine {
    engine.add_static(&threads::HAL_LIBRARY);
    engine.add_static(&logic::HAL_LIBRARY);
    engine
}

impl Machine {
    /// Creates an engine on a clock of this kind, without a socket for clients.
    pub fn new(clock: ClockKind) -> Self {
        let place = Place::at("/nonexistent", "test").unwrap();
        Self { engine: with_libraries(Engine::without_socket(options(place, clock)).unwrap()) }
    }

    /// Creates an engine on the real clock with these realtime options, without a socket for clients.
    pub fn realtime(realtime: RealtimeOptions) -> Self {
        let place = Place::at("/nonexistent", "test").unwrap();
        let options = Options { realtime, ..options(place, ClockKind::Real) };
        Self { engine: with_libraries(Engine::without_socket(options).unwrap()) }
    }

    /// Runs lines that must succeed.
    pub fn script(&mut self, lines: &str) {
        script(&mut self.engine, lines);
    }

    /// Returns the messages since the last call, except those about real time: wakeup latency depends on this computer.
    pub fn said(&mut self) -> Vec<String> {
        let mut said = self.engine.take_messages();
        said.retain(|text| !text.starts_with(REALTIME));
        said
    }

    /// Ends the engine; returns its last messages.
    pub fn end(mut self) -> Vec<String> {
        let said = self.said();
        self.engine.close();
        said
    }
}

impl Link for Machine {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        self.engine.call(request)
    }
}

/// An engine in a thread of its own, with a socket for clients. Its virtual clock is held.
#[derive(Debug)]
pub struct Served {
    /// Location of its socket.
    pub place: Place,
    thread: Option<JoinHandle<(Ended, Vec<String>)>>,
}

impl Served {
    /// Starts the engine with the lines of a script; they must create a thread, or the engine ends at once.
    pub fn start(scratch: &Scratch, name: &str, lines: &str) -> Self {
        Self::on(ClockKind::Real, scratch, name, lines)
    }

    /// Starts the engine like [`Self::start`], on a clock of this kind.
    pub fn on(clock: ClockKind, scratch: &Scratch, name: &str, lines: &str) -> Self {
        let place = Place::at(scratch.path().join(".run/ferrule"), name).unwrap();
        let (there, lines) = (place.clone(), lines.to_owned());
        let (ready, is_ready) = mpsc::channel();
        let thread = std::thread::spawn(move || {
            let engine = Engine::new(options(there, clock)).unwrap();
            let mut machine = Machine { engine: with_libraries(engine) };
            machine.script(&lines);
            ready.send(()).unwrap();
            let ended = machine.engine.serve(None);
            (ended, machine.end())
        });
        // Fails if the script fails.
        is_ready.recv().unwrap_or_else(|_| panic!("the engine did not come up"));
        Self { place, thread: Some(thread) }
    }

    /// Returns a client that is not listed.
    pub fn client(&self) -> Client {
        Client::connect(&self.place, "").unwrap()
    }

    /// Ends the engine; returns its messages.
    pub fn end(mut self) -> Vec<String> {
        self.client().call(Request::Shutdown).unwrap();
        let (ended, said) = self.thread.take().unwrap().join().unwrap();
        assert_eq!(ended, Ended::Shutdown);
        said
    }
}

/// Runs lines that must succeed.
pub fn script(link: &mut impl Link, lines: &str) {
    for line in lines.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')) {
        link.call(request(line)).unwrap_or_else(|e| panic!("{line}: {e}"));
    }
}

/// Returns the result of a line: `ok`, a value, an answer, or the refusal with its hint.
pub fn says(link: &mut impl Link, line: &str) -> String {
    match link.call(request(line)) {
        Ok(Reply::Value(value)) => value.to_string(),
        Ok(Reply::Answer(answer)) => answer.lines.join("\n"),
        Ok(_) => "ok".to_owned(),
        Err(failure) => failure.to_string(),
    }
}

/// Returns the request that applies these lines all at once or not at all.
pub fn edits(lines: &str, dry: bool) -> Request {
    let edit = |(i, line)| Edit { file: 0, line: i, request: request(line) };
    let edits = (1..).zip(lines.lines().map(str::trim)).map(edit).collect();
    Request::Apply { files: vec!["lines".to_owned()], edits, dry }
}

/// Applies lines; returns `ok`, or the refusal with the number of its line.
pub fn applied(link: &mut impl Link, lines: &str) -> String {
    match link.call(edits(lines, false)) {
        Ok(Reply::Applied { .. }) => "ok".to_owned(),
        Ok(Reply::Refused { edit, failure }) => format!("{}: {}", edit + 1, failure.text),
        Ok(other) => format!("{other:?}"),
        Err(failure) => failure.text,
    }
}

/// Returns the visible state of an instance: its items, their values, and the commands it accepts.
pub fn seen(link: &mut impl Link) -> Vec<String> {
    let mut all = vec![format!("{:?}", link.call(Request::Status))];
    for kind in [
        Kind::Components,
        Kind::Pins,
        Kind::Params,
        Kind::Signals,
        Kind::Functs,
        Kind::Threads,
        Kind::PinAliases,
        Kind::ParamAliases,
        Kind::Commands,
        Kind::Streams,
        Kind::Workers,
        Kind::Snapshots,
    ] {
        all.push(format!(
            "{:?}",
            link.call(Request::List { kind, patterns: Vec::new(), ty: None })
        ));
    }
    all
}

/// Returns the value of a pin or parameter.
pub fn get(link: &mut impl Link, name: &str) -> Value {
    match link.call(Request::Get { name: name.to_owned() }) {
        Ok(Reply::Value(value)) => value,
        other => panic!("getp {name}: {other:?}"),
    }
}

/// Returns the value of a pin or parameter that is a counter.
pub fn count(link: &mut impl Link, name: &str) -> u64 {
    match get(link, name) {
        Value::U32(n) => u64::from(n),
        Value::S32(n) => u64::try_from(n).unwrap(),
        Value::S64(n) => u64::try_from(n).unwrap(),
        Value::U64(n) => n,
        other => panic!("{name} does not count: {other:?}"),
    }
}

/// Returns the value of a bit.
pub fn bit(link: &mut impl Link, name: &str) -> bool {
    get(link, name) == Value::Bit(true)
}

/// Returns the status of the instance.
pub fn status(link: &mut impl Link) -> StatusInfo {
    match link.call(Request::Status) {
        Ok(Reply::Status(status)) => *status,
        other => panic!("status: {other:?}"),
    }
}

/// Returns a thread as `show thread` lists it.
pub fn thread(link: &mut impl Link, name: &str) -> ThreadInfo {
    let kind = Kind::Threads;
    match link.call(Request::List { kind, patterns: vec![name.to_owned()], ty: None }) {
        Ok(Reply::Threads(list)) => {
            list.into_iter().find(|t| t.name == name).unwrap_or_else(|| panic!("no thread {name}"))
        }
        other => panic!("show thread {name}: {other:?}"),
    }
}

/// Waits, in wall time and thereby on the real clock, until a condition holds. The timeout is so long that only a
/// failure reaches it.
pub fn wait<L: Link>(link: &mut L, what: &str, mut look: impl FnMut(&mut L) -> bool) {
    for _ in 0..60_000 {
        if look(link) {
            return;
        }
        link.call(Request::Idle { ms: 1, flow: false }).unwrap();
    }
    panic!("timed out: {what}");
}

/// Waits until a thread has run this many more cycles.
pub fn cycles(link: &mut impl Link, name: &str, n: u64) {
    let end = thread(link, name).cycles + n;
    wait(link, "cycles", |link| thread(link, name).cycles >= end);
}

/// Runs all other tests of a module again in a process in which nobody may use `SCHED_FIFO`: one thread of the system
/// then runs all threads. `module` is `module_path!()`.
pub fn without_fifo(module: &str, this_test: &str) {
    let no_fifo = "HAL_NO_FIFO";
    if std::env::var_os(no_fifo).is_none() {
        let mut again = Command::new(std::env::current_exe().unwrap());
        again.arg(own_test(module, "")).args(["--skip", &own_test(module, this_test)]);
        passes(again.env(no_fifo, "1"));
    }
}

/// Parses a line of a script into a request; covers only the part of the language that tests need.
pub fn request(line: &str) -> Request {
    let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
    let at = |i: usize| words.get(i).cloned().unwrap_or_else(|| panic!("{line}: too short"));
    let rest = |i: usize| words.get(i..).unwrap_or_default().to_vec();
    let position = |i: usize| words.get(i).map_or(-1, |w| w.parse().unwrap());
    match at(0).as_str() {
        "loadrt" => Request::Load { module: at(1), args: rest(2) },
        "unloadrt" if at(1) == "all" => Request::UnloadAll,
        "unloadrt" => Request::Unload { name: at(1) },
        "newsig" => Request::NewSignal { name: at(1), ty: Type::parse(&at(2)).unwrap() },
        "delsig" => Request::DeleteSignal { name: Some(at(1)) },
        "net" => Request::Net { signal: at(1), pins: rest(2) },
        "linkps" => Request::Link { pin: at(1), signal: at(2) },
        "unlinkp" => Request::Unlink { pin: at(1) },
        "setp" => Request::Set { name: at(1), value: at(2) },
        "getp" => Request::Get { name: at(1) },
        "sets" => Request::SetSignal { name: at(1), value: at(2) },
        "gets" => Request::GetSignal { name: at(1) },
        "addf" | "initf" => {
            let init = at(0) == "initf";
            Request::AddFunct { funct: at(1), thread: at(2), position: position(3), init }
        }
        "delf" => Request::RemoveFunct { funct: at(1), thread: words.get(2).cloned() },
        "start" => Request::Start,
        "stop" => Request::Stop,
        "alias" => Request::Alias { param: at(1) == "param", name: at(2), alias: at(3) },
        "unalias" => Request::Unalias { param: at(1) == "param", name: at(2) },
        "lock" => Request::SetLock {
            level: match at(1).as_str() {
                "none" => Lock::NONE,
                "tune" => Lock::TUNE,
                "all" => Lock::ALL,
                "load" => Lock::LOAD,
                "config" => Lock::CONFIG,
                "params" => Lock::PARAMS,
                "run" => Lock::RUN,
                other => panic!("{line}: no lock {other}"),
            },
        },
        "run" => Request::Run { ns: at(1).parse().unwrap() },
        "idle" => Request::Idle { ms: at(1).parse().unwrap(), flow: false },
        "record" => Request::Record { path: at(1), patterns: rest(2) },
        "join" => Request::Join { name: at(1), poll_ns: 0 },
        "ready" => Request::Ready,
        "newpin" => Request::NewPin {
            name: at(1),
            ty: Type::parse(&at(2)).unwrap(),
            direction: if at(3) == "in" { Direction::In } else { Direction::Out },
        },
        "status" => Request::Status,
        verb if verb.contains('.') => Request::Command { name: at(0), args: rest(1) },
        other => panic!("{line}: what is {other}?"),
    }
}
