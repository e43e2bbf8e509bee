//! One client's connection: lines in, answers out.

use crate::{Error, graph::Ix};
use hal_protocol::{Failure, Reply, WireReply};
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags};
use std::{
    io::{ErrorKind, IoSlice, Read, Write},
    os::{
        fd::{AsFd, OwnedFd},
        unix::net::UnixStream,
    },
};

/// The longest request, in bytes.
const LONGEST: usize = 1 << 20;
/// The most answers that wait for a client that does not read, in bytes.
const MOST_UNREAD: usize = 64 << 20;

/// What a client waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Waits {
    No,
    /// Until this moment on the wall.
    Wall(i64),
    /// Until machine time is this.
    Time(i64),
    /// Until this ticket is no longer under way.
    Ticket(u64),
    /// For its poll, due at this machine time.
    Poll(i64),
}

#[derive(Debug)]
pub(crate) struct Client {
    pub(crate) id: u64,
    pub(crate) socket: UnixStream,
    pub(crate) input: Vec<u8>,
    pub(crate) output: Vec<u8>,
    pub(crate) fd: Option<OwnedFd>,
    pub(crate) component: Option<Ix>,
    pub(crate) pid: i32,
    pub(crate) pins: Vec<Ix>,
    pub(crate) poll_ns: i64,
    /// When its next poll is owed, in machine time.
    pub(crate) owes: Option<i64>,
    pub(crate) waits: Waits,
    pub(crate) flows: bool,
    pub(crate) gone: bool,
    pub(crate) closing: bool,
}

impl Client {
    pub(crate) fn read(&mut self) {
        let mut chunk = [0; 65536];
        while self.input.len() <= LONGEST {
            match self.socket.read(&mut chunk) {
                Ok(0) => {
                    self.gone = true;
                    return;
                }
                Ok(n) => self.input.extend_from_slice(chunk.get(..n).unwrap_or_default()),
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if e.kind() == ErrorKind::WouldBlock => return,
                Err(_) => {
                    self.gone = true;
                    return;
                }
            }
        }
    }

    /// The next whole line, or why there will never be one.
    pub(crate) fn line(&mut self) -> Option<Result<Vec<u8>, Error>> {
        let Some(end) = self.input.iter().position(|b| *b == b'\n') else {
            if self.input.len() > LONGEST {
                self.input = Vec::new();
                self.closing = true;
                let why = format!("a request is longer than {LONGEST} bytes").into();
                return Some(Err(Error::Protocol { why }));
            }
            return None;
        };
        let rest = self.input.split_off(end + 1);
        Some(Ok(core::mem::replace(&mut self.input, rest)))
    }

    pub(crate) fn answer(&mut self, reply: Result<Reply, Failure>) {
        let wire = match reply {
            Ok(reply) => WireReply::Ok(reply),
            Err(failure) => WireReply::Error(failure),
        };
        if let Ok(mut line) = serde_json::to_vec(&wire) {
            line.push(b'\n');
            self.output.extend_from_slice(&line);
        }
        if self.output.len() > MOST_UNREAD {
            self.gone = true;
        }
        self.write();
    }

    pub(crate) fn write(&mut self) {
        while !self.output.is_empty() && !self.gone {
            let wrote = match self.fd.take() {
                Some(fd) => {
                    let sent = self.send(&fd);
                    if matches!(sent, Err(ref e) if e.kind() == ErrorKind::WouldBlock) {
                        self.fd = Some(fd);
                    }
                    sent
                }
                None => self.socket.write(&self.output),
            };
            match wrote {
                Ok(n) => drop(self.output.drain(..n)),
                Err(e) if e.kind() == ErrorKind::WouldBlock => return,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(_) => self.gone = true,
            }
        }
        if self.closing && self.output.is_empty() {
            self.gone = true;
        }
    }

    fn send(&self, fd: &OwnedFd) -> std::io::Result<usize> {
        let mut space = [core::mem::MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut control = SendAncillaryBuffer::new(&mut space);
        let fds = [fd.as_fd()];
        control.push(SendAncillaryMessage::ScmRights(&fds));
        let data = [IoSlice::new(&self.output)];
        Ok(rustix::net::sendmsg(&self.socket, &data, &mut control, SendFlags::NOSIGNAL)?)
    }
}
