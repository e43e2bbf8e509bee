//! The client's end of the engine's socket.

use crate::{
    At, Failure, Folder, FolderError, LATEST, Link, MAX_LEN, PinPage, Place, Reply, Request,
    SampleSpec, SampleState, Samples, Snapshot, Stream, Type, WireReply, WireRequest,
};
use rustix::{
    event::{PollFd, PollFlags, poll},
    io::Errno,
    net::{RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags},
    time::Timespec,
};
use std::{
    io::{IoSliceMut, Write},
    os::{fd::OwnedFd, unix::net::UnixStream},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

/// A connection to an engine.
#[derive(Debug)]
pub struct Client {
    socket: UnixStream,
    buffer: Vec<u8>,
    /// Number of answers to interrupted requests, which come before that to the next one.
    unread: u32,
    received: Option<OwnedFd>,
    id: u32,
    at: Option<At>,
    /// Set when nobody wants the answers any more.
    given_up: Option<Arc<AtomicBool>>,
}

/// Interval between two checks whether a reply is still wanted, while waiting for it.
const LOOK_NS: i64 = 50_000_000;
const EIO: i32 = -5;
/// Error code (EINTR) of a request whose answer is not wanted any more.
pub const INTERRUPTED: i32 = -4;
/// Error code (ECONNREFUSED) of a connection attempt when no such instance runs.
pub const NOT_RUNNING: i32 = -111;
/// Error code (EREMOTE) of a request that a client which speaks for people elsewhere may not make.
pub const NOT_FROM_AFAR: i32 = -66;
const EMSGSIZE: i32 = -90;
const EAGAIN: i32 = -11;
/// Variable with the reason why a program must not connect: its engine waits for it, and would not answer.
const NO_CLIENTS: &str = "HAL_NO_CLIENTS";
/// Variable that is set for programs which people start from elsewhere.
const FROM_AFAR: &str = "HAL_FROM_AFAR";

impl Client {
    /// Connects and registers this process as component `name`. With an empty name the client is
    /// not listed. Where the variable `HAL_FROM_AFAR` is set, the client speaks for people elsewhere
    /// ([`Request::SpeakFromAfar`]).
    ///
    /// # Errors
    /// Nothing listens ([`NOT_RUNNING`]); another user could have made the folder or the socket, or
    /// listens at the socket; or the engine speaks another protocol.
    pub fn connect(place: &Place, name: &str) -> Result<Self, Failure> {
        Self::connect_unless(place, name, None)
    }

    /// Connects as [`Self::connect`] does. Once the flag is set, this call and every later one fail
    /// if the engine does not answer at once, as one does not that is stopped by SIGSTOP.
    ///
    /// # Errors
    /// As [`Self::connect`]; or the flag is set.
    pub fn connect_unless(
        place: &Place,
        name: &str,
        given_up: Option<Arc<AtomicBool>>,
    ) -> Result<Self, Failure> {
        if let Ok(why) = std::env::var(NO_CLIENTS) {
            return Err(Failure::new(EAGAIN, why));
        }
        let socket = match Folder::open(place) {
            Ok(folder) => folder.connect(place)?,
            Err(FolderError::Missing { .. }) => None,
            Err(e) => return Err(e.into()),
        };
        let socket = socket.ok_or_else(|| {
            let mut f =
                Failure::new(NOT_RUNNING, format!("no instance '{}' is running", place.name()));
            let start = "start one with 'halrun FILE', or name another with --instance";
            let log = place.log();
            f.hint = Some(if log.exists() {
                format!("what it said in the background is in {}\n{start}", log.display())
            } else {
                start.to_owned()
            });
            f
        })?;
        let mut client = Self {
            socket,
            buffer: Vec::new(),
            unread: 0,
            received: None,
            id: 0,
            at: None,
            given_up,
        };
        let pid = rustix::process::getpid().as_raw_nonzero().get();
        let hello = Request::Hello { protocol: LATEST, name: name.to_owned(), pid };
        match client.call(hello)? {
            Reply::Hello { protocol: LATEST, id, .. } => {
                client.id = id;
                if std::env::var_os(FROM_AFAR).is_some() {
                    client.call(Request::SpeakFromAfar)?;
                }
                Ok(client)
            }
            _ => Err(Failure::new(EIO, "the engine speaks another protocol")),
        }
    }

    /// Connects without a name as a client that speaks for people elsewhere ([`Request::SpeakFromAfar`]).
    ///
    /// # Errors
    /// As [`Self::connect`].
    pub fn connect_from_afar(place: &Place) -> Result<Self, Failure> {
        let mut client = Self::connect(place, "")?;
        client.call(Request::SpeakFromAfar)?;
        Ok(client)
    }

    /// Returns the number of this client's component.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// Attaches to a shared ring. `count` is the number of records that the client will take, if
    /// it is known.
    ///
    /// # Errors
    /// No ring has this name, another program is attached to it, or the engine did not send a valid
    /// ring.
    pub fn attach(&mut self, name: &str, count: Option<u64>) -> Result<Stream, Failure> {
        self.stream(name, Request::Attach { name: name.to_owned(), count })
    }

    /// Makes a ring to which one other client attaches by its name. Either end may write or read it.
    ///
    /// # Errors
    /// Another client has a ring of this name, the shape is out of range, or the engine did not send a valid ring.
    pub fn new_stream(
        &mut self,
        name: &str,
        depth: u32,
        types: Vec<Type>,
    ) -> Result<Stream, Failure> {
        self.stream(name, Request::NewStream { name: name.to_owned(), depth, types })
    }

    fn stream(&mut self, name: &str, request: Request) -> Result<Stream, Failure> {
        let reply = self.call(request)?;
        match (reply, self.received.take()) {
            (Reply::Stream(info), Some(fd)) => {
                Stream::map(&fd, info).map_err(|e| Failure::new(EIO, e))
            }
            _ => Err(Failure::new(EIO, format!("the engine sent no ring for '{name}'"))),
        }
    }

    /// Maps a snapshot, whose latest record this client then reads without further requests.
    ///
    /// # Errors
    /// No snapshot has this name, or the engine did not send a valid page.
    pub fn snapshot(&mut self, name: &str) -> Result<Snapshot, Failure> {
        let reply = self.call(Request::MapSnapshot { name: name.to_owned() })?;
        match (reply, self.received.take()) {
            (Reply::SnapshotPage(info), Some(fd)) => {
                Snapshot::map(&fd, *info).map_err(|e| Failure::new(EIO, e))
            }
            _ => Err(Failure::new(EIO, format!("the engine sent no page for '{name}'"))),
        }
    }

    /// Maps a page with space for this number of pins of this client. It replaces the page `before`, whose counts of
    /// writes it continues; if this fails, that page stays in use.
    ///
    /// # Errors
    /// This client has not joined, the number is out of range, or the engine did not send a valid
    /// page.
    pub fn share_pins(&mut self, pins: u32, before: Option<&PinPage>) -> Result<PinPage, Failure> {
        let reply = self.call(Request::SharePins { pins })?;
        match (reply, self.received.take()) {
            (Reply::PinPage(info), Some(fd)) => {
                PinPage::map(&fd, info, before).map_err(|e| Failure::new(EIO, e))
            }
            _ => Err(Failure::new(EIO, "the engine sent no page for this client's pins")),
        }
    }

    /// Starts a sample.
    ///
    /// # Errors
    /// A name, the thread or the depth is invalid, or the engine did not send a valid ring.
    pub fn sample(&mut self, spec: SampleSpec) -> Result<Samples, Failure> {
        let reply = self.call(Request::Sample(spec))?;
        match (reply, self.received.take()) {
            (Reply::Sample(info), Some(fd)) => {
                Samples::map(&fd, info).map_err(|e| Failure::new(EIO, e))
            }
            _ => Err(Failure::new(EIO, "the engine sent no ring for the sample")),
        }
    }

    /// Returns the state of one of this client's samples: samples taken, samples lost, and the
    /// reason if it has ended.
    ///
    /// # Errors
    /// This client has no such sample, or the connection to the engine is lost.
    pub fn sample_state(&mut self, id: u64) -> Result<SampleState, Failure> {
        self.state(Request::SampleState { id })
    }

    /// Ends one of this client's samples. Records that are still in its ring can be read
    /// afterwards.
    ///
    /// # Errors
    /// As [`Self::sample_state`].
    pub fn end_sample(&mut self, id: u64) -> Result<SampleState, Failure> {
        self.state(Request::EndSample { id })
    }

    fn state(&mut self, request: Request) -> Result<SampleState, Failure> {
        match self.call(request)? {
            Reply::SampleState(state) => Ok(state),
            _ => Err(Failure::new(EIO, "the engine's answer does not match the request")),
        }
    }

    /// Returns whether the engine has ended or closed this connection. Does not wait.
    #[must_use]
    pub fn is_gone(&self) -> bool {
        let flags = RecvFlags::PEEK | RecvFlags::DONTWAIT;
        match rustix::net::recv(&self.socket, &mut [0_u8; 1], flags) {
            Ok((_, n)) => n == 0,
            Err(e) => !matches!(e, Errno::AGAIN | Errno::INTR),
        }
    }

    /// Waits until there is something to read, or nobody wants it any more.
    fn wait(&self, wanted: &mut Option<&mut dyn FnMut() -> bool>) -> Result<(), Failure> {
        if self.given_up.is_none() && wanted.is_none() {
            return Ok(());
        }
        loop {
            // In this order: what is there is read.
            let is_given_up = self.given_up.as_ref().is_some_and(|flag| flag.load(Relaxed))
                || wanted.as_mut().is_some_and(|wanted| !wanted());
            let mut fds = [PollFd::new(&self.socket, PollFlags::IN)];
            let time = Timespec { tv_sec: 0, tv_nsec: LOOK_NS };
            match poll(&mut fds, Some(&time)) {
                Ok(0) if is_given_up => return Err(Failure::new(INTERRUPTED, "interrupted")),
                Ok(0) | Err(Errno::INTR) => {}
                // The read says what is wrong.
                Ok(_) | Err(_) => return Ok(()),
            }
        }
    }

    fn line(&mut self, mut wanted: Option<&mut dyn FnMut() -> bool>) -> Result<Vec<u8>, Failure> {
        let gone = || Failure::new(EIO, "the engine has closed the connection");
        let (mut searched, mut chunk) = (0, vec![0; 65536]);
        loop {
            let new = self.buffer.get(searched..).unwrap_or_default();
            if let Some(at) = new.iter().position(|b| *b == b'\n') {
                let rest = self.buffer.split_off(searched + at + 1);
                let line = core::mem::replace(&mut self.buffer, rest);
                if self.unread == 0 {
                    return Ok(line);
                }
                (self.unread, searched) = (self.unread - 1, 0);
                continue;
            }
            searched = self.buffer.len();
            if let Err(interrupted) = self.wait(&mut wanted) {
                self.unread += 1;
                return Err(interrupted);
            }
            let mut space = [core::mem::MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
            let mut control = RecvAncillaryBuffer::new(&mut space);
            let got = rustix::net::recvmsg(
                &self.socket,
                &mut [IoSliceMut::new(&mut chunk)],
                &mut control,
                RecvFlags::CMSG_CLOEXEC,
            );
            let n = match got {
                Ok(m) => m.bytes,
                Err(Errno::INTR) => continue,
                Err(_) => return Err(gone()),
            };
            for message in control.drain() {
                if let RecvAncillaryMessage::ScmRights(fds) = message {
                    self.received = fds.last();
                }
            }
            if n == 0 {
                return Err(gone());
            }
            self.buffer.extend_from_slice(chunk.get(..n).unwrap_or_default());
        }
    }

    fn exchange(
        &mut self,
        request: Request,
        wanted: Option<&mut dyn FnMut() -> bool>,
    ) -> Result<Reply, Failure> {
        let bad = |e: serde_json::Error| Failure::new(EIO, format!("unreadable answer: {e}"));
        let mut line =
            serde_json::to_vec(&WireRequest { request, at: self.at.clone() }).map_err(bad)?;
        if line.len() > MAX_LEN {
            let text = format!("this takes {} bytes at once, {MAX_LEN} are read", line.len());
            let mut failure = Failure::new(EMSGSIZE, text);
            failure.hint = Some("divide it".to_owned());
            return Err(failure);
        }
        line.push(b'\n');
        self.socket
            .write_all(&line)
            .map_err(|_| Failure::new(EIO, "the engine has closed the connection"))?;
        match serde_json::from_slice(&self.line(wanted)?).map_err(bad)? {
            WireReply::Ok(reply) => Ok(reply),
            WireReply::Error(failure) => Err(failure),
        }
    }
}

impl Link for Client {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        self.exchange(request, None)
    }

    fn call_while(
        &mut self,
        request: Request,
        wanted: &mut dyn FnMut() -> bool,
    ) -> Result<Reply, Failure> {
        self.exchange(request, Some(wanted))
    }

    fn at(&mut self, file: &str, line: u32) {
        At::keep(&mut self.at, file, line);
    }
}
