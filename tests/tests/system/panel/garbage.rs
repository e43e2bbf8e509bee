//! Random requests and messages: whatever arrives, the panel answers or ends the connection, lives, and changes nothing
//! for who may not.

use super::printer::{Printer, Session};
use hal_bench::Random;
use hal_tests::web::{self, Socket};
use serde_json::{Value, json};

/// Rounds in a run of all tests.
const ROUNDS: u32 = 250;
/// Machine time of the long run, in milliseconds: 20 minutes.
const LONG_MS: f64 = 1_200_000.0;
/// Rounds of the long run between two looks at the machine.
const LOOK: u32 = 200;
/// Messages of one connection; more in a second are refused.
const MESSAGES: u32 = 40;
/// Number from which the messages of the test itself count: no random message has it.
const OWN: u64 = 1 << 50;
/// Pieces that a mutation may insert.
const PIECES: &[&[u8]] = &[
    b"\0",
    b"\r\n",
    b"\r\n\r\n",
    b"{",
    b"}",
    b"[",
    b"]",
    b"\"",
    b"\\u0000",
    b"../",
    b"%00",
    b"%2e%2e%2f",
    b"-1",
    b"1e999",
    b"18446744073709551616",
    b"null",
    b"NaN",
    b"true",
    b"Content-Length: 5\r\n",
    b"Transfer-Encoding: chunked\r\n",
    b"\xff\xfe",
    b"\xc3",
    b"AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA",
    b"?pattern=[",
    b"*",
];

/// Returns requests that are right.
fn requests(session: &Session) -> Vec<Vec<u8>> {
    let headers = session.headers();
    let request = |method: &str, path: &str, body: &str| {
        let length = body.len();
        format!(
            "{method} /api/v1{path} HTTP/1.1\r\n{headers}Content-Length: {length}\r\n\r\n{body}"
        )
        .into_bytes()
    };
    vec![
        request("GET", "/info", ""),
        request("GET", "/pins?pattern=axis.*&pattern=remote.*", ""),
        request("GET", "/graph?pattern=xpos*", ""),
        request("GET", "/programs/a.ngc/path?tolerance=0.01", ""),
        request("PUT", "/programs/a.ngc", "G21 G90\nG1 X1 F100\nM2\n"),
        request("DELETE", "/programs/a.ngc", ""),
        request("GET", "/latency", ""),
        request("POST", "/session", r#"{"token": "0000000000000000"}"#),
        request("POST", "/session", r#"{"user": "ana", "password": "correct horse"}"#),
    ]
}

/// Returns messages that are right.
fn messages() -> Vec<Vec<u8>> {
    let all = [
        json!({ "type": "lease", "id": 1, "do": "take", "force": true }),
        json!({ "type": "lease", "id": 2, "do": "hand", "to": 3 }),
        json!({ "type": "command", "id": 3, "name": "jog", "args": { "axis": "X", "velocity": 5, "distance": 1 } }),
        json!({ "type": "command", "id": 4, "name": "mdi", "args": { "text": "G1 X1 F100" } }),
        json!({ "type": "command", "id": 5, "name": "setp", "args": { "name": "stepgen.0.maxaccel", "value": "1" } }),
        json!({ "type": "command", "id": 6, "name": "net", "args": { "signal": "a", "pins": "b.0 c.0" } }),
        json!({ "type": "command", "id": 7, "name": "touch-off", "args": { "axis": "X", "value": 1.5, "system": 1 } }),
        json!({ "type": "command", "id": 8, "name": "open", "args": { "program": "a.ngc" } }),
        json!({ "type": "watch", "names": ["remote.pulse", "sig:xpos-cmd"] }),
        json!({ "type": "scope", "id": 9, "capture": { "names": ["xpos-cmd"], "seconds": 0.1, "every": 1,
            "trigger": { "when": "xpos-cmd rises through 0.5", "before": 0.05, "auto": true } } }),
        json!({ "type": "beat", "n": 12 }),
    ];
    all.iter().map(|message: &Value| message.to_string().into_bytes()).collect()
}

/// Changes one of the inputs at some places.
fn mutated(random: &mut Random, inputs: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = inputs[random.index(inputs.len())].clone();
    for _ in 0..=random.index(4) {
        if bytes.is_empty() {
            return bytes;
        }
        let at = random.index(bytes.len());
        let len = random.index((bytes.len() - at).min(32) + 1);
        match random.index(7) {
            0 => bytes[at] = random.word().to_le_bytes()[0],
            1 => drop(bytes.drain(at..at + len)),
            2 => {
                let part = bytes[at..at + len].to_vec();
                bytes.splice(at..at, part.repeat(1 + random.index(40)));
            }
            3 | 4 => {
                let piece = PIECES[random.index(PIECES.len())];
                bytes.splice(at..at, piece.iter().copied());
            }
            5 => bytes.truncate(at),
            _ => {
                let other = &inputs[random.index(inputs.len())];
                let from = random.index(other.len());
                bytes.splice(at.., other[from..].iter().copied());
            }
        }
    }
    bytes
}

/// A panel under random input.
struct Victim {
    printer: Printer,
    session: Session,
    socket: Option<Socket>,
    random: Random,
    sent: u32,
    /// Messages behind which the connection still served.
    served: u32,
}

impl Victim {
    fn new(role: &str, seed: u64) -> Self {
        let printer = Printer::start(role);
        let session = printer.sign_in();
        Self { printer, session, socket: None, random: Random::new(seed), sent: 0, served: 0 }
    }

    /// Sends a request, a message and a frame.
    fn round(&mut self, messages: &[Vec<u8>]) {
        let bytes = mutated(&mut self.random, &requests(&self.session));
        let answer = web::cut(self.printer.port, &bytes);
        let shown = String::from_utf8_lossy(&bytes);
        assert!(answer.status < 500, "{shown}: {answer:?}");
        if 400 <= answer.status && !answer.body.is_empty() {
            assert!(!answer.code().is_empty(), "a refusal without a name: {shown}: {answer:?}");
        }
        let text = mutated(&mut self.random, messages);
        let mut socket = self.socket.take().unwrap_or_else(|| self.open());
        self.sent += 1;
        socket.frame(if self.random.index(10) == 0 { 2 } else { 1 }, &text);
        // The connection has ended with a reason, or it serves.
        let id = OWN + u64::from(self.sent);
        socket.send(&json!({ "type": "command", "id": id, "name": "no-such-command" }));
        let reply = |m: &Value| m["type"] == "reply" && m["id"] == id;
        let shown = String::from_utf8_lossy(&text);
        match socket.wait(|m| m["type"] == "error" || reply(m)) {
            // A frame of a text that is none.
            None => assert!(
                std::str::from_utf8(&text).is_err(),
                "the connection ended without a reason: {shown}"
            ),
            Some(answer) if reply(&answer) => {
                assert!(answer["error"]["code"] == "not-found", "{shown}: {answer}");
                self.served += 1;
                if self.sent.is_multiple_of(MESSAGES) {
                    let frame = mutated(&mut self.random, &[web::frame(1, &text)]);
                    socket.cut(&frame);
                } else {
                    self.socket = Some(socket);
                }
            }
            Some(error) => assert!(error["error"]["code"].is_string(), "{shown}: {error}"),
        }
    }

    /// Opens the socket; the session may have been ended by a request.
    fn open(&mut self) -> Socket {
        let headers = self.session.headers();
        if self.printer.request("GET", "/api/v1/session", &headers, b"").status != 200 {
            self.session = self.printer.sign_in();
        }
        self.session.socket()
    }

    /// Checks that the panel and the machine live.
    fn lives(&self) {
        // Most random messages are malformed, which ends a connection.
        assert!(self.sent < 25 * self.served, "{} of {} served", self.served, self.sent);
        let session = self.printer.sign_in();
        let info = self.printer.request("GET", "/api/v1/info", &session.headers(), b"");
        assert_eq!(info.status, 200, "{info:?}");
        assert_eq!(session.socket().command("abort", &json!({})), "");
        self.printer.halcmd("task.status");
    }
}

#[test]
fn random_input_of_a_viewer_changes_nothing() {
    let mut victim = Victim::new("viewer", 5);
    // Times of functions change by themselves.
    let is_time = |line: &&str| line.contains(".tmax") || line.contains(".time");
    let save = |victim: &Victim| -> String {
        let saved = victim.printer.halcmd("save all");
        saved.lines().filter(|line| !is_time(line)).collect::<Vec<_>>().join("\n")
    };
    let before = save(&victim);
    let messages = messages();
    for _ in 0..ROUNDS {
        victim.round(&messages);
    }
    victim.lives();
    assert_eq!(save(&victim), before);
    assert_eq!(victim.printer.number("getp joint.0.pos-cmd"), 0.0);
    let programs = victim.printer.scratch.path().join("programs");
    assert!(programs.read_dir().unwrap().next().is_none(), "a viewer has stored a program");
}

#[test]
fn random_input_of_an_integrator_ends_no_program() {
    let mut victim = Victim::new("integrator", 6);
    let messages = messages();
    for _ in 0..ROUNDS {
        victim.round(&messages);
    }
    victim.lives();
}

#[test]
#[ignore = "it takes 20 minutes: cargo test -p hal-tests --test system panel::garbage::twenty -- --ignored --nocapture"]
fn twenty_minutes_of_random_input() {
    let mut victim = Victim::new("integrator", u64::from(std::process::id()));
    let messages = messages();
    let pulse = |victim: &Victim| victim.printer.number("getp remote.pulse");
    let begun = pulse(&victim);
    let mut rounds = 0;
    while pulse(&victim) < begun + LONG_MS {
        for _ in 0..LOOK {
            victim.round(&messages);
        }
        rounds += LOOK;
        victim.lives();
    }
    println!("{rounds} random requests, and as many messages");
}
