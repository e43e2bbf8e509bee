//! Connection of a client: request lines in, answers out.

use crate::{Error, graph::Ix, serve::hold::Hold, serve::pins::Shared};
use hal_protocol::{CommandLine, Failure, MAX_LEN, Reply, WireReply, peer_process};
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags};
use std::{
    io::{ErrorKind, IoSlice, Read, Write},
    os::{
        fd::{AsFd, OwnedFd},
        unix::net::UnixStream,
    },
};

/// A process id that no process has.
const NO_PROCESS: i32 = i32::MAX;

/// The condition that a client waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WaitState {
    No,
    /// Until this monotonic wall-clock time, in nanoseconds.
    Wall(i64),
    /// Until machine time reaches this.
    Time(i64),
    /// Until this ticket is no longer pending.
    Ticket(u64),
    /// For its poll, due at this machine time.
    Poll(i64),
}

/// Rights of a client, from the most to the fewest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Rights {
    /// Everything.
    Own,
    /// The rights of people elsewhere, for whom the client has said that it speaks.
    FromAfar,
    /// The rights of people elsewhere without the end of the instance: the client is another user's, whom a system service lets in.
    Guest,
}

#[derive(Debug)]
pub(crate) struct Client {
    pub(crate) id: u64,
    pub(crate) socket: UnixStream,
    input: Vec<u8>,
    /// Number of input bytes already consumed, and of those searched without finding a newline.
    taken: usize,
    searched: usize,
    output: Vec<u8>,
    /// Number of output bytes already sent.
    sent: usize,
    pub(crate) fd: Option<OwnedFd>,
    pub(crate) component: Option<Ix>,
    pub(crate) pid: i32,
    pub(crate) pins: Vec<Ix>,
    pub(crate) poll_ns: i64,
    /// Machine time by which the next poll is due.
    pub(crate) poll_due: Option<i64>,
    /// Time that the virtual clock has waited for that poll.
    pub(crate) hold: Hold,
    /// Values that the client writes when that poll is due.
    pub(crate) writes: Vec<(Ix, u64)>,
    /// The page through which the client exchanges its values.
    pub(crate) page: Option<Shared>,
    /// Commands that are executed when the connection ends.
    pub(crate) at_end: Vec<CommandLine>,
    /// Requests that the client may make.
    pub(crate) rights: Rights,
    pub(crate) waits: WaitState,
    pub(crate) advances_clock: bool,
    pub(crate) gone: bool,
    /// True if the client sends nothing more.
    ended: bool,
    /// True if the client does not read any more, either.
    pub(crate) hung: bool,
    pub(crate) closing: bool,
}

impl Client {
    pub(crate) const fn new(id: u64, socket: UnixStream) -> Self {
        Self {
            id,
            socket,
            input: Vec::new(),
            taken: 0,
            searched: 0,
            output: Vec::new(),
            sent: 0,
            fd: None,
            component: None,
            pid: 0,
            pins: Vec::new(),
            poll_ns: 0,
            poll_due: None,
            hold: Hold::NONE,
            writes: Vec::new(),
            page: None,
            at_end: Vec::new(),
            rights: Rights::Own,
            waits: WaitState::No,
            advances_clock: false,
            gone: false,
            ended: false,
            hung: false,
            closing: false,
        }
    }

    /// Returns the process of the client: `said` by itself, and for a guest, which cannot name another one, as the kernel
    /// says, or [`NO_PROCESS`] if this process does not see it.
    pub(crate) fn process(&self, said: i32) -> i32 {
        match self.rights {
            Rights::Own | Rights::FromAfar => said,
            Rights::Guest => {
                let seen = peer_process(&self.socket).ok().filter(|pid| *pid > 0);
                seen.unwrap_or(NO_PROCESS)
            }
        }
    }

    /// Returns whether more input is wanted. The server reads nothing more from a client that does
    /// not read its answers.
    pub(crate) const fn listens(&self) -> bool {
        let room = self.input.len() - self.taken <= MAX_LEN;
        room && !self.has_output() && !self.ended && !self.closing && !self.gone
    }

    /// Returns whether an answer waits to be sent.
    pub(crate) const fn has_output(&self) -> bool {
        !self.output.is_empty()
    }

    /// Returns whether the client's next request may be executed now.
    pub(crate) fn is_served(&self) -> bool {
        self.waits == WaitState::No && !self.has_output() && !self.closing && !self.gone
    }

    pub(crate) fn read(&mut self) {
        self.input.drain(..self.taken);
        self.searched -= self.taken;
        self.taken = 0;
        let mut chunk = [0; 65536];
        while self.input.len() <= MAX_LEN {
            match self.socket.read(&mut chunk) {
                Ok(0) => {
                    self.ended = true;
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

    /// Returns whether `line` has a result: a whole line, or the error that it is too long.
    pub(crate) fn has_line(&mut self) -> bool {
        let rest = self.input.get(self.searched..).unwrap_or_default();
        match rest.iter().position(|b| *b == b'\n') {
            Some(at) => self.searched += at,
            None => self.searched = self.input.len(),
        }
        self.searched < self.input.len() || self.input.len() - self.taken > MAX_LEN
    }

    /// Returns the next whole line, or an error if the line is too long.
    pub(crate) fn line(&mut self) -> Option<Result<Vec<u8>, Error>> {
        if !self.has_line() {
            return None;
        }
        if self.searched == self.input.len() {
            self.closing = true;
            let why = format!("a request is longer than {MAX_LEN} bytes").into();
            return Some(Err(Error::Protocol { why }));
        }
        let line = self.input.get(self.taken..self.searched).unwrap_or_default().to_vec();
        self.searched += 1;
        self.taken = self.searched;
        Some(Ok(line))
    }

    /// Marks the client for removal when it sends nothing more and every request is answered, or
    /// when it has hung up during a wait.
    pub(crate) fn part(&mut self) {
        let answered = self.is_served() && !self.has_line();
        self.gone |= self.ended && answered || self.hung && self.waits != WaitState::No;
    }

    pub(crate) fn answer(&mut self, reply: Result<Reply, Failure>) {
        let wire = match reply {
            Ok(reply) => WireReply::Ok(reply),
            Err(failure) => WireReply::Error(failure),
        };
        if let Ok(line) = serde_json::to_vec(&wire) {
            self.output.extend_from_slice(&line);
            self.output.push(b'\n');
        }
        self.write();
    }

    pub(crate) fn write(&mut self) {
        while self.sent < self.output.len() && !self.gone {
            let rest = self.output.get(self.sent..).unwrap_or_default();
            let wrote = match self.fd.take() {
                Some(fd) => {
                    let sent = send(&self.socket, rest, &fd);
                    if matches!(sent, Err(ref e) if e.kind() == ErrorKind::WouldBlock) {
                        self.fd = Some(fd);
                    }
                    sent
                }
                None => (&self.socket).write(rest),
            };
            match wrote {
                Ok(n) => self.sent += n,
                Err(e) if e.kind() == ErrorKind::WouldBlock => return,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(_) => self.gone = true,
            }
        }
        self.output = Vec::new();
        self.sent = 0;
        self.gone |= self.closing;
    }
}

/// Sends bytes together with a file descriptor.
fn send(socket: &UnixStream, bytes: &[u8], fd: &OwnedFd) -> std::io::Result<usize> {
    let mut space = [core::mem::MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    let fds = [fd.as_fd()];
    control.push(SendAncillaryMessage::ScmRights(&fds));
    Ok(rustix::net::sendmsg(socket, &[IoSlice::new(bytes)], &mut control, SendFlags::NOSIGNAL)?)
}
