//! A connection to an engine that can carry arbitrary bytes.

use crate::machine::Served;
use rustix::net::{RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, recvmsg};
use std::{
    fs::File,
    io::{BufRead, BufReader, IoSliceMut, Write},
    mem::MaybeUninit,
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

/// Returns a connection, and the memory of the ring that the engine passes over it for this request.
pub fn ring(served: &Served, request: &str) -> (UnixStream, File) {
    let mut socket = UnixStream::connect(served.place.socket()).unwrap();
    writeln!(socket, "{{\"request\":{request}}}").unwrap();
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut control = RecvAncillaryBuffer::new(&mut space);
    let mut bytes = [0; 4096];
    let mut bytes = [IoSliceMut::new(&mut bytes)];
    recvmsg(&socket, &mut bytes, &mut control, RecvFlags::CMSG_CLOEXEC).unwrap();
    let fd = control.drain().find_map(|m| match m {
        RecvAncillaryMessage::ScmRights(mut fds) => fds.next(),
        _ => None,
    });
    (socket, File::from(fd.unwrap()))
}
