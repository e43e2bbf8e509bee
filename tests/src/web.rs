//! Requests over HTTP and messages of a WebSocket, byte by byte: tests send what a browser would not.

use serde_json::{Value, json};
use std::{
    io::{Read as _, Write as _},
    net::{Ipv4Addr, Shutdown, SocketAddr, TcpStream},
    time::Duration,
};

/// Longest time in which a server answers.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Status of a connection that is a WebSocket from then on.
const SWITCHED: u16 = 101;

/// Answer to a request.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Status of HTTP; 0 if the connection ended without one.
    pub status: u16,
    /// Lines before the body.
    pub head: String,
    /// Body.
    pub body: Vec<u8>,
}

impl Answer {
    /// Reads an answer; its body is as long as it says, or lasts until the connection ends.
    fn read(stream: &mut TcpStream) -> Self {
        let mut head = Vec::new();
        let mut byte = [0];
        while !head.ends_with(b"\r\n\r\n") && stream.read(&mut byte).is_ok_and(|n| n == 1) {
            head.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&head).into_owned();
        let status = head.split(' ').nth(1).and_then(|n| n.parse().ok()).unwrap_or(0);
        let mut answer = Self { status, head, body: Vec::new() };
        let length = answer.header("content-length").and_then(|n| n.parse().ok());
        if status != SWITCHED {
            let mut rest = stream.take(length.unwrap_or(u64::MAX));
            drop(rest.read_to_end(&mut answer.body));
        }
        answer
    }

    /// Returns the body as JSON; null if it is none.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_default()
    }

    /// Returns the code of a refusal.
    pub fn code(&self) -> String {
        self.json()["error"]["code"].as_str().unwrap_or_default().to_owned()
    }

    /// Returns the value of a header.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut lines = self.head.lines().filter_map(|line| line.split_once(':'));
        lines.find_map(|(n, value)| n.eq_ignore_ascii_case(name).then_some(value.trim()))
    }
}

/// Connects to a server of this computer.
fn connect(port: u16) -> TcpStream {
    connect_at((Ipv4Addr::LOCALHOST, port).into())
}

fn connect_at(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    stream
}

/// Sends these bytes, and returns the answer.
pub fn raw(port: u16, bytes: &[u8]) -> Answer {
    let mut stream = connect(port);
    // A server that refuses a long body does not read it to its end.
    drop(stream.write_all(bytes));
    Answer::read(&mut stream)
}

/// Sends these bytes and nothing more, and returns the answer once the server has ended the connection.
pub fn cut(port: u16, bytes: &[u8]) -> Answer {
    let mut stream = connect(port);
    // A server that refuses the first bytes may end the connection before the others.
    drop(stream.write_all(bytes));
    drop(stream.shutdown(Shutdown::Write));
    let answer = Answer::read(&mut stream);
    drop(stream.read_to_end(&mut Vec::new()));
    answer
}

/// Returns a text with percent signs for everything but letters, digits and some signs.
pub fn encoded(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_./%".contains(&byte);
    text.bytes()
        .map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}

/// Returns a frame of a client: 1 is a text, 2 is binary.
pub fn frame(opcode: u8, bytes: &[u8]) -> Vec<u8> {
    let mut frame = vec![0x80 | opcode];
    match u16::try_from(bytes.len()) {
        Ok(n @ 0..126) => frame.push(0x80 | u8::try_from(n).unwrap()),
        Ok(n) => {
            frame.push(0x80 | 126);
            frame.extend(n.to_be_bytes());
        }
        Err(_) => {
            frame.push(0x80 | 127);
            frame.extend((bytes.len() as u64).to_be_bytes());
        }
    }
    // A mask of zeros leaves the bytes as they are.
    frame.extend([0; 4]);
    frame.extend(bytes);
    frame
}

/// Sends a request with these lines as its headers, and returns the answer.
pub fn request(port: u16, method: &str, path: &str, headers: &str, body: &[u8]) -> Answer {
    let length = body.len();
    let head = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n{headers}");
    let mut bytes = format!("{head}Content-Length: {length}\r\n\r\n").into_bytes();
    bytes.extend(body);
    raw(port, &bytes)
}

/// A WebSocket.
#[derive(Debug)]
pub struct Socket {
    stream: TcpStream,
    next: u64,
}

impl Socket {
    /// Opens the socket of a path, with these lines as further headers.
    ///
    /// # Errors
    /// The server refuses: its answer.
    pub fn open(port: u16, path: &str, headers: &str) -> Result<Self, Answer> {
        Self::open_at((Ipv4Addr::LOCALHOST, port).into(), path, headers)
    }

    /// Opens the socket of a server at this address, as `open` does.
    ///
    /// # Errors
    /// The server refuses: its answer.
    pub fn open_at(address: SocketAddr, path: &str, headers: &str) -> Result<Self, Answer> {
        let mut stream = connect_at(address);
        let head = format!(
            "GET {path} HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n{headers}\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        let answer = Answer::read(&mut stream);
        if answer.status == SWITCHED { Ok(Self { stream, next: 0 }) } else { Err(answer) }
    }

    /// Sends a frame: 1 is a text, 2 is binary. The server may have gone.
    pub fn frame(&mut self, opcode: u8, bytes: &[u8]) {
        drop(self.stream.write_all(&frame(opcode, bytes)));
    }

    /// Sends these bytes and nothing more, and waits until the server ends the connection.
    pub fn cut(mut self, bytes: &[u8]) {
        drop(self.stream.write_all(bytes));
        drop(self.stream.shutdown(Shutdown::Write));
        drop(self.stream.read_to_end(&mut Vec::new()));
    }

    /// Makes the system keep only a few messages that the server has sent and nobody has read.
    pub fn narrow(&self) {
        rustix::net::sockopt::set_socket_recv_buffer_size(&self.stream, 4 << 10).unwrap();
    }

    /// Sends a message.
    pub fn send(&mut self, message: &Value) {
        self.frame(1, message.to_string().as_bytes());
    }

    /// Returns the next message; `None` at the end of the connection.
    pub fn receive(&mut self) -> Option<Value> {
        loop {
            let [first, second] = self.read()?;
            let length = match second & 0x7f {
                126 => u64::from(u16::from_be_bytes(self.read()?)),
                127 => u64::from_be_bytes(self.read()?),
                n => u64::from(n),
            };
            let mut bytes = vec![0; usize::try_from(length).unwrap()];
            self.stream.read_exact(&mut bytes).ok()?;
            match first & 0xf {
                1 => return Some(serde_json::from_slice(&bytes).unwrap()),
                8 => return None,
                _ => {}
            }
        }
    }

    fn read<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = [0; N];
        self.stream.read_exact(&mut bytes).ok()?;
        Some(bytes)
    }

    /// Returns the first message that fits, and answers pulses meanwhile.
    pub fn wait(&mut self, fits: impl Fn(&Value) -> bool) -> Option<Value> {
        loop {
            let message = self.receive()?;
            if fits(&message) {
                return Some(message);
            }
            if message["type"] == "pulse" {
                self.send(&json!({ "type": "beat", "n": message["n"] }));
            }
        }
    }

    /// Sends a message with a new `id`; returns its reply, or null if the connection ends.
    pub fn ask(&mut self, mut message: Value) -> Value {
        self.next += 1;
        let id = self.next;
        message["id"] = id.into();
        self.send(&message);
        self.wait(|m| m["type"] == "reply" && m["id"] == id).unwrap_or_default()
    }

    /// Executes a command; returns the code of its refusal, or nothing.
    pub fn command(&mut self, name: &str, args: &Value) -> String {
        let reply = self.ask(json!({ "type": "command", "name": name, "args": args }));
        reply["error"]["code"].as_str().unwrap_or_default().to_owned()
    }

    /// Returns the code of the error with which the server ends the connection.
    pub fn last_error(&mut self) -> String {
        let error = self.wait(|m| m["type"] == "error").unwrap_or_default();
        error["error"]["code"].as_str().unwrap_or_default().to_owned()
    }
}
