//! Transcripts: `A> ` is a line of client A, `A< ` the next line that it gets, byte for byte.
//!
//! | line | meaning |
//! |---|---|
//! | `A> TEXT`, `A< TEXT` | a line to the server, a line from it; `A` may be any name in capitals, whose first letter is that of its computer |
//! | `A> TEXT *N` | the text N times, without a blank between |
//! | `A bytes FF 0A` | bytes to the server, in hexadecimal |
//! | `A closed`, `A gone` | the server closes the connection; the client vanishes |
//! | `A busy` | the server takes no connection |
//! | `* start`, `* cancel`, `* lose` | the next wish of the server; after `start`, the program's lines with `|` between |
//! | `* started`, `* refused CODE TEXT`, `* ended`, `* failed TEXT` | the result |
//! | `* progress N`, `* idle`, `* taken TEXT` | the machine |
//! | `* wait MS`, `* stop` | time passes; the operator stops the server |
//!
//! Secrets: `clave` is an operator's, `mirar` a viewer's, every other is wrong.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::{
    collections::BTreeMap,
    fs,
    net::{IpAddr, Ipv4Addr},
    path::Path,
};
use teleop::{Action, CODES, Code, Machine, Reason, Server};

/// Cut of the bytes of a client into segments.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    /// A segment for each line.
    Lines,
    /// A segment for each byte.
    Bytes,
    /// A segment for all lines that follow each other.
    Joined,
}

struct Stage {
    server: Server,
    now: u64,
    ids: BTreeMap<String, u64>,
    outputs: BTreeMap<String, Vec<u8>>,
    closed: Vec<u64>,
    actions: Vec<Action>,
    /// Bytes that wait to be sent together.
    held: Option<(String, Vec<u8>)>,
    cut: Cut,
    progress: Option<u8>,
}

impl Stage {
    fn new(cut: Cut) -> Self {
        Self {
            server: Server::default(),
            now: 0,
            ids: BTreeMap::new(),
            outputs: BTreeMap::new(),
            closed: Vec::new(),
            actions: Vec::new(),
            held: None,
            cut,
            progress: None,
        }
    }

    fn id(&mut self, client: &str) -> u64 {
        if let Some(id) = self.ids.get(client) {
            return *id;
        }
        let id = self.server.connect(computer(client), self.now).unwrap();
        self.ids.insert(client.to_owned(), id);
        id
    }

    fn send(&mut self, client: &str, bytes: &[u8]) {
        if self.held.as_ref().is_some_and(|(held, _)| held != client) {
            self.flush();
        }
        let held = self.held.get_or_insert_with(|| (client.to_owned(), Vec::new()));
        held.1.extend_from_slice(bytes);
        if self.cut != Cut::Joined {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let Some((client, bytes)) = self.held.take() else { return };
        let id = self.id(&client);
        let size = if self.cut == Cut::Bytes { 1 } else { bytes.len() };
        for segment in bytes.chunks(size) {
            self.server.receive(id, segment, self.now);
            self.settle();
        }
    }

    /// Answers logins, and collects the rest.
    fn settle(&mut self) {
        while let Some(action) = self.server.action() {
            match action {
                Action::SignIn { id, secret, .. } => {
                    let result = match secret.as_str() {
                        "clave" => Ok(true),
                        "mirar" => Ok(false),
                        _ => Err("the token is wrong, or has been used".to_owned()),
                    };
                    self.server.signed_in(id, result, self.now);
                }
                Action::Close(id) => self.closed.push(id),
                other => self.actions.push(other),
            }
        }
        for (client, id) in &self.ids {
            let bytes = self.server.output(*id);
            self.outputs.entry(client.clone()).or_default().extend(bytes);
        }
    }

    fn line(&mut self, client: &str) -> String {
        let output = self.outputs.entry(client.to_owned()).or_default();
        let Some(end) = output.windows(2).position(|two| two == b"\r\n") else {
            assert!(output.is_empty(), "a line without its end: {output:?}");
            return "(nothing)".to_owned();
        };
        let line: Vec<u8> = output.drain(..end + 2).take(end).collect();
        String::from_utf8(line).unwrap()
    }

    fn wish(&mut self, word: &str, text: &str) {
        assert!(!self.actions.is_empty(), "the server does not wish {word}");
        let action = self.actions.remove(0);
        if let Action::Start { program, .. } = &action
            && !text.is_empty()
        {
            assert_eq!(String::from_utf8_lossy(program).replace('\n', "|"), text);
        }
        let right = match word {
            "start" => matches!(action, Action::Start { .. }),
            "cancel" => action == Action::Cancel,
            _ => action == Action::Lose,
        };
        assert!(right, "the server wishes {action:?}");
    }

    fn machine(&mut self, progress: Option<u8>, busy: Option<String>) {
        self.progress = progress;
        self.server.machine(Machine { busy, progress });
    }

    fn step(&mut self, line: &str) {
        let (who, rest) = line.split_once(' ').unwrap();
        if let Some(client) = who.strip_suffix('>') {
            let text = match rest.rsplit_once(" *") {
                Some((text, count)) => text.repeat(count.parse().unwrap()),
                None => rest.to_owned(),
            };
            return self.send(client, format!("{text}\r\n").as_bytes());
        }
        if rest.starts_with("bytes ") {
            let bytes = rest.split(' ').skip(1).map(|b| u8::from_str_radix(b, 16).unwrap());
            return self.send(who, &bytes.collect::<Vec<_>>());
        }
        self.flush();
        if let Some(client) = who.strip_suffix('<') {
            assert_eq!(self.line(client), rest);
            return;
        }
        let (word, text) = rest.split_once(' ').unwrap_or((rest, ""));
        match (who, word) {
            ("*", "start" | "cancel" | "lose") => self.wish(word, text),
            ("*", "started") => self.server.started(Ok(()), self.now),
            ("*", "refused") => {
                let (code, text) = text.split_once(' ').unwrap();
                let why = Reason::new(Code::parse(code).unwrap(), text);
                self.server.started(Err(why), self.now);
            }
            ("*", "ended") => self.server.ended(Ok(()), self.now),
            ("*", "failed") => self.server.ended(Err(Reason::new(Code::Falla, text)), self.now),
            ("*", "progress") => self.machine(Some(text.parse().unwrap()), None),
            ("*", "idle") => self.machine(None, None),
            ("*", "taken") => self.machine(None, Some(text.to_owned())),
            ("*", "wait") => {
                self.now += text.parse::<u64>().unwrap();
                self.server.poll(self.now);
            }
            ("*", "stop") => self.server.stop(self.now),
            (client, "closed") => {
                assert_eq!(self.line(client), "(nothing)");
                let id = self.ids.remove(client).unwrap();
                assert!(self.closed.contains(&id), "{client} is not closed");
                self.server.gone(id);
            }
            (client, "gone") => {
                let id = self.ids.remove(client).unwrap();
                self.server.gone(id);
            }
            (client, "busy") => {
                assert_eq!(
                    self.server.connect(computer(client), self.now),
                    None,
                    "{client} is connected"
                );
            }
            _ => panic!("this is no line of a transcript"),
        }
        self.settle();
    }
}

/// Returns the address of a client's computer.
fn computer(client: &str) -> IpAddr {
    Ipv4Addr::new(192, 0, 2, *client.as_bytes().first().unwrap()).into()
}

fn transcripts() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/transcripts");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 10, "only {} transcripts", files.len());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    files.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect()
}

fn play(name: &str, text: &str, cut: Cut) {
    let mut stage = Stage::new(cut);
    for (n, line) in (1..).zip(text.lines()) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let at = format!("{name}:{n}: {line} ({cut:?})");
        let step = std::panic::catch_unwind(core::panic::AssertUnwindSafe(|| stage.step(line)));
        assert!(step.is_ok(), "{at}");
    }
    stage.flush();
    assert_eq!(stage.actions, [], "{name}: wishes that nobody expects ({cut:?})");
    for client in stage.ids.keys().cloned().collect::<Vec<_>>() {
        assert_eq!(stage.line(&client), "(nothing)", "{name}: {client} ({cut:?})");
    }
}

#[test]
fn every_transcript_is_the_same_however_the_network_cuts_it() {
    for (name, text) in transcripts() {
        for cut in [Cut::Lines, Cut::Bytes, Cut::Joined] {
            play(&name, &text, cut);
        }
    }
}

#[test]
fn the_transcripts_show_every_refusal() {
    let all: String = transcripts().into_iter().map(|(_, text)| text).collect();
    let answers: Vec<&str> =
        all.lines().filter_map(|line| Some(line.split_once("< ")?.1)).collect();
    for row in CODES {
        let shows = |line: &&str| line.split(' ').nth(1) == Some(row.text);
        assert!(answers.iter().any(shows), "no transcript shows {}", row.text);
    }
    for word in
        ["DENEGADO", "ERROR_NUEVO", "ERROR_AGREGAR", "ERROR_EJECUTAR", "ERROR", "DESCONEXION"]
    {
        let shows = |line: &&str| line.split(' ').next() == Some(word);
        assert!(answers.iter().any(shows), "no transcript shows {word}");
    }
}
