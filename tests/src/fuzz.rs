//! What the fuzz targets do with bytes that mean anything or nothing. `tests/fuzz` calls it with
//! what a fuzzer thinks of, `tests/tests/corpus.rs` with what it has found.
//!
//! Nothing here reaches beyond this process: programs are not started, files not written, processes
//! not ended.

use crate::machine::{bare, plain, with_libraries};
use hal_engine::{ClockKind, Engine};
use hal_protocol::{Kind, LATEST, Link, Place, Reply, Request, WireRequest};
use hal_trace::Format;
use halcmd::{
    Captured, Command, Outcome, Session, Style,
    ini::Ini,
    lex,
    table::understand,
    vars::{Values, replace},
};
use std::{
    io::{Read, Write},
    os::unix::net::UnixStream,
};

/// The longest input that is looked at.
const LONGEST: usize = 2048;
/// The most lines that are carried out.
const MOST_LINES: usize = 32;
/// The furthest that the clock is moved at once, in nanoseconds.
const FURTHEST: u64 = 1_000_000;
/// The values of variables.
const INI: &str = "[A]\nX = 5\nNAME = and2.0.in0\nBAD = \"x\nTWO = net s and2.0.out\n[B]\nX = #\n";

fn environment(name: &str) -> Option<String> {
    (name.len() < 4).then(|| format!("{name}.0 \"{name}"))
}

/// Lines of a script, carried out by an engine on a held virtual clock. A line that fails leaves
/// everything as it was.
pub fn script(bytes: &[u8]) {
    let bytes = bytes.get(..LONGEST).unwrap_or(bytes);
    let mut engine = plain(ClockKind::Virtual);
    let ini = Ini::parse("fuzz.ini", INI.as_bytes()).unwrap();
    // Errors show the line and point into it.
    let mut terminal = Captured { person: true, ..Captured::default() };
    let style = Style { verbose: true, ..Style::default() };
    let mut before = None;
    for line in lex::lines(bytes).into_iter().take(MOST_LINES) {
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

/// The commands that would rebuild the state.
fn state(engine: &mut Engine) -> Vec<Reply> {
    let kinds = [Kind::Components, Kind::Pins, Kind::Signals, Kind::Params, Kind::Threads];
    let list = |kind| Request::List { kind, patterns: Vec::new(), ty: None };
    kinds.map(|kind| engine.call(list(kind)).unwrap()).into()
}

/// Whether a line does nothing but to the engine, and that not for ever.
fn stays_inside(text: &str, ini: &Ini) -> bool {
    let values = Values { environment: &environment, ini: Some(ini) };
    let words = lex::without_comment(text)
        .and_then(|text| replace(text, values))
        .and_then(|text| lex::words(&text));
    let Ok(words) = words else { return true };
    if words.is_empty() {
        return true;
    }
    match understand(&words) {
        // The last two end when somebody ends them.
        Ok(
            Command::Launch(_)
            | Command::AwaitEnd(_)
            | Command::Source(_)
            | Command::Watch(_)
            | Command::Meter(_),
        ) => false,
        Ok(Command::Save(_, file)) => file.is_none(),
        Ok(Command::Ask(request, _)) => is_harmless(&request),
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

/// Whether no number in it is large, but for periods.
fn is_small(arg: &str) -> bool {
    let most = if arg.starts_with("period") { 18 } else { 2 };
    arg.split(|c: char| !c.is_ascii_hexdigit()).all(|digits| digits.len() <= most)
}

/// An INI file; after a zero byte, a line with variables to be found in it.
pub fn ini(bytes: &[u8]) {
    let bytes = bytes.get(..LONGEST).unwrap_or(bytes);
    let (text, line) = match bytes.iter().position(|b| *b == 0) {
        Some(at) => bytes.split_at(at),
        None => (bytes, &b"[A]X [](Y) $Z"[..]),
    };
    // Other files are none of this.
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

/// What a client writes, as the server of an engine takes it.
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
    for line in bytes.get(..LONGEST).unwrap_or(bytes).split_inclusive(|b| *b == b'\n') {
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
        // Nothing is there yet, or it has hung up: the engine decides.
        drop(client.read_to_end(&mut answers));
    }
    assert!(answers.ends_with(b"\n"), "an answer ends with its line");
    drop(client);
    engine.call(Request::Idle { ms: 0, flow: true }).unwrap();
    engine.close();
}

/// A recording: the first byte says of which format. What is read whole is the same in JSON.
pub fn trace(bytes: &[u8]) {
    let Some((kind, file)) = bytes.split_first() else { return };
    let format = Format::ALL[usize::from(*kind) % Format::ALL.len()];
    let Ok(trace) = format.read(file).whole() else { return };
    let mut json = Vec::new();
    // What JSON cannot hold is refused with a word.
    if Format::Json.write(&mut json, &trace).is_ok() {
        assert_eq!(Format::Json.read(&json).whole().as_ref(), Ok(&trace));
    }
}
