//! Bodies of the fuzz targets: each takes arbitrary bytes. `tests/fuzz` calls them with a fuzzer's inputs, and
//! `tests/tests/system/language/corpus.rs` calls them with the inputs that fuzzing has collected.
//!
//! Nothing here reaches beyond this process: no program is started, no file is written, no process is ended.

pub mod gcode;

use crate::machine::{bare, plain, with_libraries};
use hal_engine::{ClockKind, Engine};
use hal_protocol::{Kind, LATEST, Link, Place, Reply, Request, WireRequest};
use hal_trace::Format;
use halcmd::{
    Captured, Command, Outcome, Session, Style,
    ini::Ini,
    language::lex,
    language::table::parse_command,
    language::vars::{Values, replace},
};
use std::{
    io::{Read, Write},
    os::unix::net::UnixStream,
};

/// Length of the longest input that is processed, in bytes.
const MAX_LEN: usize = 2048;
/// Maximum number of lines that are executed.
const MAX_LINES: usize = 32;
/// Longest step of the clock, in nanoseconds.
const FURTHEST: u64 = 1_000_000;
/// Variables of the INI file.
const INI: &str = "[A]\nX = 5\nNAME = and2.0.in0\nBAD = \"x\nTWO = net s and2.0.out\n[B]\nX = #\n";

fn environment(name: &str) -> Option<String> {
    (name.len() < 4).then(|| format!("{name}.0 \"{name}"))
}

/// Executes lines of a script with an engine on a held virtual clock, and checks that a line that fails changes
/// nothing.
pub fn script(bytes: &[u8]) {
    let bytes = bytes.get(..MAX_LEN).unwrap_or(bytes);
    let mut engine = plain(ClockKind::Virtual);
    let ini = Ini::parse("fuzz.ini", INI.as_bytes()).unwrap();
    // Error messages quote the line and mark a position in it.
    let mut terminal = Captured { person: true, ..Captured::default() };
    let style = Style { verbose: true, ..Style::default() };
    let mut before = None;
    for line in lex::lines(bytes).into_iter().take(MAX_LINES) {
        let Ok(text) = line.text else { continue };
        if !stays_inside(&text, &ini) {
            continue;
        }
        let was = before.take().unwrap_or_else(|| state(&mut engine));
        let mut session = Session::new(&mut engine, &mut terminal, style, "fuzz");
        session.set_ini(&ini);
        session.set_environment(&environment);
        let outcome = session.line_at("fuzz.hal", line.number, &text);
        if outcome == Outcome::Failed {
            assert_eq!(was, state(&mut engine), "refused, but it changed something: {text}");
            before = Some(was);
        }
    }
    engine.close();
}

/// Returns the commands that would rebuild the state.
fn state(engine: &mut Engine) -> Vec<Reply> {
    let kinds = [Kind::Components, Kind::Pins, Kind::Signals, Kind::Params, Kind::Threads];
    let list = |kind| Request::List { kind, patterns: Vec::new(), ty: None };
    kinds.map(|kind| engine.call(list(kind)).unwrap()).into()
}

/// Returns whether a line affects nothing but the engine, and returns.
fn stays_inside(text: &str, ini: &Ini) -> bool {
    let values = Values { environment: &environment, ini: Some(ini) };
    let words = lex::without_comment(text)
        .and_then(|text| replace(text, values))
        .and_then(|text| lex::words(&text));
    let Ok(words) = words else { return true };
    if words.is_empty() {
        return true;
    }
    match parse_command(&words) {
        // The last two run until they are interrupted.
        Ok(
            Command::Launch(_)
            | Command::AwaitEnd(_)
            | Command::Source(_)
            | Command::Watch(_)
            | Command::Meter(_),
        ) => false,
        Ok(Command::Save(_, file)) => file.is_none(),
        Ok(Command::Send(request, _)) => is_harmless(&request),
        _ => true,
    }
}

fn is_harmless(request: &Request) -> bool {
    match request {
        Request::Record { .. } | Request::EndProgram { .. } | Request::Adopt { .. } => false,
        Request::Hello { pid, .. } => *pid == 0,
        Request::Run { ns } => *ns <= FURTHEST,
        Request::Load { args, .. } => args.iter().all(|a| is_small(a)),
        Request::SetSignal { value, .. } => is_small(value),
        _ => true,
    }
}

/// Returns whether an argument holds no large number, periods aside.
fn is_small(arg: &str) -> bool {
    let most = if arg.starts_with("period") { 18 } else { 2 };
    arg.split(|c: char| !c.is_ascii_hexdigit()).all(|digits| digits.len() <= most)
}

/// Parses an INI file; after a zero byte, the input is a line whose variables are looked up in that file.
pub fn ini(bytes: &[u8]) {
    let bytes = bytes.get(..MAX_LEN).unwrap_or(bytes);
    let (text, line) = match bytes.iter().position(|b| *b == 0) {
        Some(at) => bytes.split_at(at),
        None => (bytes, &b"[A]X [](Y) $Z"[..]),
    };
    // Inputs that include other files are skipped.
    if text.windows(8).any(|w| w == b"#INCLUDE") {
        return;
    }
    let ini = Ini::parse("fuzz.ini", text).ok();
    let line = String::from_utf8_lossy(line);
    let values = Values { environment: &environment, ini: ini.as_ref() };
    let read = lex::without_comment(&line)
        .and_then(|text| replace(text, values))
        .and_then(|text| lex::words(&text));
    if let Some(ini) = ini {
        for name in ini.names() {
            let (section, name) = name.split_once(']').unwrap();
            assert!(ini.get(section.trim_start_matches('['), name).is_some());
        }
    }
    drop(read);
}

/// Sends the bytes to an engine's server as a client would.
pub fn protocol(bytes: &[u8]) {
    let folder = std::env::temp_dir().join(format!("ferrule-fuzz-{}", std::process::id()));
    let place = Place::at(folder, "fuzz").unwrap();
    let socket = place.socket();
    let mut engine = with_libraries(Engine::new(bare(place, ClockKind::Virtual)).unwrap());
    for (module, args) in [("threads", "period1=1000000"), ("and2", "count=2")] {
        let (module, args) = (module.to_owned(), vec![args.to_owned()]);
        engine.call(Request::Load { module, args }).unwrap();
    }
    let mut client = UnixStream::connect(socket).unwrap();
    let hello = Request::Hello { protocol: LATEST, name: "fuzz".to_owned(), pid: 0 };
    let mut said = serde_json::to_vec(&WireRequest { request: hello, at: None }).unwrap();
    said.push(b'\n');
    for line in bytes.get(..MAX_LEN).unwrap_or(bytes).split_inclusive(|b| *b == b'\n') {
        let outward = |wire: WireRequest| !is_harmless(&wire.request);
        if !serde_json::from_slice(line).is_ok_and(outward) {
            said.extend_from_slice(line);
        }
    }
    client.write_all(&said).unwrap();
    client.set_nonblocking(true).unwrap();
    let mut answers = Vec::new();
    for turn in 0..64 {
        engine.call(Request::Idle { ms: 0, flow: true }).unwrap();
        if turn == 48 {
            client.shutdown(std::net::Shutdown::Write).unwrap();
        }
        // No bytes may have arrived yet, or the client has hung up: the engine decides.
        drop(client.read_to_end(&mut answers));
    }
    assert!(answers.ends_with(b"\n"), "an answer ends with its line");
    drop(client);
    engine.call(Request::Idle { ms: 0, flow: true }).unwrap();
    engine.close();
}

/// Reads a recording. The first byte selects its format. A recording that is read completely must survive a round trip
/// through JSON.
pub fn trace(bytes: &[u8]) {
    let Some((kind, file)) = bytes.split_first() else { return };
    let format = Format::ALL[usize::from(*kind) % Format::ALL.len()];
    let Ok(trace) = format.read(file).whole() else { return };
    let mut json = Vec::new();
    // Values that JSON cannot hold are refused with a message.
    if Format::Json.write(&mut json, &trace).is_ok() {
        assert_eq!(Format::Json.read(&json).whole().as_ref(), Ok(&trace));
    }
}
