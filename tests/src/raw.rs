//! A connection to an engine on which any bytes can be sent.

use crate::machine::Served;
use std::{
    io::{BufRead, BufReader, Write},
    os::unix::net::UnixStream,
    time::Duration,
};

/// The two ends of the connection.
#[derive(Debug)]
pub struct Raw {
    /// Bytes to the engine.
    pub socket: UnixStream,
    /// Lines from the engine.
    pub answers: BufReader<UnixStream>,
}

impl Raw {
    /// Connects.
    pub fn connect(served: &Served) -> Self {
        let socket = UnixStream::connect(served.place.socket()).unwrap();
        // A test that goes wrong fails instead of waiting for ever.
        socket.set_read_timeout(Some(Duration::from_secs(100))).unwrap();
        let answers = BufReader::new(socket.try_clone().unwrap());
        Self { socket, answers }
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: impl AsRef<[u8]>) {
        self.socket.write_all(bytes.as_ref()).unwrap();
    }

    /// Returns the next answer; empty when the engine has hung up.
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
