//! A connection to an engine that can carry arbitrary bytes.

use crate::machine::Served;
use std::{
    io::{BufRead, BufReader, Write},
    os::unix::net::UnixStream,
    time::Duration,
};

/// Both directions of the connection.
#[derive(Debug)]
pub struct Raw {
    /// Bytes to the engine.
    pub socket: UnixStream,
    /// Lines from the engine.
    pub answers: BufReader<UnixStream>,
}

impl Raw {
    /// Connects to an engine.
    pub fn connect(served: &Served) -> Self {
        let socket = UnixStream::connect(served.place.socket()).unwrap();
        // A test that fails must not wait forever.
        socket.set_read_timeout(Some(Duration::from_secs(100))).unwrap();
        let answers = BufReader::new(socket.try_clone().unwrap());
        Self { socket, answers }
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: impl AsRef<[u8]>) {
        self.socket.write_all(bytes.as_ref()).unwrap();
    }

    /// Returns the next answer; empty if the engine has closed the connection.
    pub fn answer(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap_or(0);
        line
    }

    /// Sends a request, as JSON, and returns its answer without the end of the line.
    pub fn ask(&mut self, request: &str) -> String {
        self.send(format!("{{\"request\":{request}}}\n"));
        self.answer().trim_end().to_owned()
    }
}
