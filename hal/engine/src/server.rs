//! The socket: clients, their requests one at a time, and programs that are components.

use crate::{
    Engine, Error,
    create::NewItem,
    graph::{Graph, Ix},
    name::Name,
    os,
};
use hal_protocol::{
    ComponentState, Direction, Failure, LATEST, Place, Reply, Request, TicketInfo, Type, Value,
    WireReply, WireRequest,
};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags},
};
use std::{
    fs::File,
    io::{ErrorKind, IoSlice, Read, Write},
    os::{
        fd::{AsFd, OwnedFd},
        unix::{
            fs::{DirBuilderExt, PermissionsExt},
            net::{UnixListener, UnixStream},
        },
    },
};

/// The longest request, in bytes.
const LONGEST: usize = 1 << 20;
/// The most answers that wait for a client that does not read, in bytes.
const MOST_UNREAD: usize = 64 << 20;
/// The most clients at once.
const MOST_CLIENTS: usize = 256;

/// What a client waits for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Waits {
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
struct Client {
    id: u64,
    socket: UnixStream,
    input: Vec<u8>,
    output: Vec<u8>,
    fd: Option<OwnedFd>,
    component: Option<Ix>,
    pid: i32,
    pins: Vec<Ix>,
    poll_ns: i64,
    /// When its next poll is owed, in machine time.
    owes: Option<i64>,
    waits: Waits,
    flows: bool,
    gone: bool,
    closing: bool,
}

/// The socket and its clients.
#[derive(Debug)]
pub(crate) struct Server {
    listener: UnixListener,
    place: Place,
    #[expect(dead_code, reason = "locked as long as the instance lives")]
    lock: File,
    clients: Vec<Client>,
    next: u64,
}

impl Server {
    /// Takes the socket of an instance, also over from an owner that has died.
    pub(crate) fn open(place: &Place) -> Result<Self, Error> {
        let system = |what: &'static str| {
            move |e: std::io::Error| Error::System { what, why: e.to_string().into() }
        };
        let mut builder = std::fs::DirBuilder::new();
        builder
            .recursive(true)
            .mode(0o700)
            .create(place.folder())
            .map_err(system("the runtime folder cannot be made"))?;
        let lock = File::options()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(place.lock())
            .map_err(system("the instance's lock cannot be opened"))?;
        let flock = rustix::fs::FlockOperation::NonBlockingLockExclusive;
        if rustix::fs::flock(&lock, flock).is_err() {
            return Err(Error::Running { instance: place.name().into() });
        }
        let path = place.socket();
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => {
                return Err(system("an old socket cannot be removed")(e));
            }
            _ => {}
        }
        let listener =
            UnixListener::bind(&path).map_err(system("the instance's socket cannot be made"))?;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600))
            .map_err(system("the instance's socket cannot be protected"))?;
        listener.set_nonblocking(true).map_err(system("the instance's socket"))?;
        Ok(Self { listener, place: place.clone(), lock, clients: Vec::new(), next: 1 })
    }

    /// Ends every connection: programs see it and leave.
    pub(crate) fn drop_clients(&mut self) {
        self.clients.clear();
    }

    fn accept(&mut self) {
        while let Ok((socket, _)) = self.listener.accept() {
            if self.clients.len() >= MOST_CLIENTS || socket.set_nonblocking(true).is_err() {
                continue;
            }
            self.clients.push(Client {
                id: self.next,
                socket,
                input: Vec::new(),
                output: Vec::new(),
                fd: None,
                component: None,
                pid: 0,
                pins: Vec::new(),
                poll_ns: 0,
                owes: None,
                waits: Waits::No,
                flows: false,
                gone: false,
                closing: false,
            });
            self.next += 1;
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // A file that has gone already is as good.
        for file in [self.place.socket(), self.place.lock()] {
            drop(std::fs::remove_file(file));
        }
    }
}

impl Client {
    fn read(&mut self) {
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
    fn line(&mut self) -> Option<Result<Vec<u8>, Error>> {
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

    fn answer(&mut self, reply: Result<Reply, Failure>) {
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

    fn write(&mut self) {
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

/// Whether a client waits for the end of a command.
pub(crate) fn waits_for_ticket(engine: &Engine) -> bool {
    let clients = engine.server.iter().flat_map(|s| &s.clients);
    clients.into_iter().any(|c| matches!(c.waits, Waits::Ticket(_)))
}

/// When the next program is to poll, in machine time.
pub(crate) fn next_poll(engine: &Engine) -> i64 {
    let clients = engine.server.iter().flat_map(|s| &s.clients);
    let times = clients.filter_map(|c| match c.waits {
        Waits::Poll(t) | Waits::Time(t) => Some(t),
        Waits::No | Waits::Wall(_) | Waits::Ticket(_) => None,
    });
    times.min().unwrap_or(i64::MAX)
}

/// Whether a program has not polled yet that should have.
pub(crate) fn owes_poll(engine: &Engine) -> bool {
    let now = engine.shared.now();
    let clients = engine.server.iter().flat_map(|s| &s.clients);
    clients.into_iter().any(|c| c.owes.is_some_and(|t| t <= now) && c.waits == Waits::No)
}

/// How far clients' waits let the virtual clock move.
fn clients_target(server: &Server) -> i64 {
    let targets = server.clients.iter().filter_map(|c| match c.waits {
        Waits::Time(t) => Some(t),
        Waits::Ticket(_) => Some(i64::MAX),
        Waits::Wall(_) if c.flows => Some(i64::MAX),
        _ => None,
    });
    targets.max().unwrap_or(i64::MIN)
}

/// One look at the socket: waits at most `ms` for something to do, and does it.
pub(crate) fn serve_once(engine: &mut Engine, ms: i32) {
    let Some(mut server) = engine.server.take() else {
        if ms > 0 {
            drop(wait(&mut [], ms));
        }
        return;
    };
    let now = os::monotonic_ns();
    let mut ms = ms;
    for c in &server.clients {
        if let Waits::Wall(t) = c.waits {
            let left = i32::try_from((t - now) / 1_000_000 + 1).unwrap_or(i32::MAX);
            ms = ms.min(left.max(0));
        }
    }
    if !engine.shared.is_virtual() {
        let due = engine.next_task().min(next_poll_of(&server)) - engine.shared.now();
        ms = ms.min(i32::try_from(due / 1_000_000 + 1).unwrap_or(i32::MAX).max(0));
        if server.clients.iter().any(|c| matches!(c.waits, Waits::Ticket(_))) {
            ms = ms.min(1);
        }
        if engine.recording.is_some() {
            ms = ms.min(5);
        }
    }
    let mut fds = vec![PollFd::new(&server.listener, PollFlags::IN)];
    for c in &server.clients {
        let flags =
            if c.output.is_empty() { PollFlags::IN } else { PollFlags::IN | PollFlags::OUT };
        fds.push(PollFd::new(&c.socket, flags));
    }
    let ready = wait(&mut fds, ms).unwrap_or(false);
    let events: Vec<PollFlags> = fds.iter().map(PollFd::revents).collect();
    drop(fds);
    if ready {
        for (c, e) in server.clients.iter_mut().zip(events.iter().skip(1)) {
            if e.intersects(PollFlags::IN | PollFlags::HUP | PollFlags::ERR) {
                c.read();
            }
            if e.contains(PollFlags::OUT) {
                c.write();
            }
        }
        server.accept();
    }
    for c in &mut server.clients {
        settle(engine, c);
        while c.waits == Waits::No && !c.gone && !c.closing {
            let Some(line) = c.line() else { break };
            let reply = match line {
                Ok(line) => respond(engine, c, &line),
                Err(e) => Some(Err(e.into())),
            };
            if let Some(reply) = reply {
                c.answer(reply);
            }
        }
    }
    for c in server.clients.iter().filter(|c| c.gone) {
        leave(engine, c);
    }
    server.clients.retain(|c| !c.gone);
    engine.client_target = clients_target(&server);
    engine.server = Some(server);
}

fn next_poll_of(server: &Server) -> i64 {
    let times = server.clients.iter().filter_map(|c| match c.waits {
        Waits::Poll(t) => Some(t),
        _ => None,
    });
    times.min().unwrap_or(i64::MAX)
}

fn wait(fds: &mut [PollFd<'_>], ms: i32) -> std::io::Result<bool> {
    let ms = i64::from(ms);
    let limit = Timespec { tv_sec: ms / 1000, tv_nsec: ms % 1000 * 1_000_000 };
    Ok(poll(fds, Some(&limit))? > 0)
}

/// Answers a client whose wait is over.
fn settle(engine: &mut Engine, c: &mut Client) {
    let now = engine.shared.now();
    let reply = match c.waits {
        Waits::Wall(t) if os::monotonic_ns() >= t => Ok(Reply::Done),
        Waits::Time(t) if now >= t => Ok(Reply::Done),
        Waits::Poll(t) if now >= t => {
            c.owes = Some(now + c.poll_ns);
            Ok(values(engine, c))
        }
        Waits::Ticket(id) => match engine.ticket(id) {
            Ok(TicketInfo::Pending) if engine.fault.is_none() => return,
            other => other.map(Reply::Ticket).map_err(Failure::from),
        },
        Waits::No | Waits::Wall(_) | Waits::Time(_) | Waits::Poll(_) => return,
    };
    c.waits = Waits::No;
    c.flows = false;
    c.answer(reply);
}

fn values(engine: &Engine, c: &Client) -> Reply {
    let value = |ix: &Ix| engine.graph.item(*ix).map(|i| Graph::value(i.ty, i.bits()));
    let values = c.pins.iter().map(|ix| value(ix).unwrap_or(Value::Bit(false))).collect();
    Reply::Values { time: u64::try_from(engine.shared.now()).unwrap_or(0), values }
}

/// Carries out a request; `None` when the answer comes later.
fn respond(engine: &mut Engine, c: &mut Client, line: &[u8]) -> Option<Result<Reply, Failure>> {
    let request = match serde_json::from_slice::<WireRequest>(line) {
        Ok(wire) => wire.request,
        Err(e) => {
            let why = format!("this is not a request: {e}").into();
            return Some(Err(Error::Protocol { why }.into()));
        }
    };
    let done = match request {
        Request::Hello { protocol, name, pid } => hello(engine, c, protocol, &name, pid),
        Request::Run { ns } => match engine.run_end(ns) {
            Ok(end) => {
                c.waits = Waits::Time(end);
                return None;
            }
            Err(e) => Err(e),
        },
        Request::Ticket { id, wait } => match engine.ticket(id) {
            Ok(TicketInfo::Pending) if wait => {
                c.waits = Waits::Ticket(id);
                return None;
            }
            other => other.map(Reply::Ticket),
        },
        Request::Idle { ms, flow } => {
            c.waits = Waits::Wall(os::monotonic_ns() + i64::from(ms) * 1_000_000);
            c.flows = flow;
            return None;
        }
        Request::Join { name, poll_ns } => join(engine, c, &name, poll_ns),
        Request::NewPin { name, ty, direction } => new_pin(engine, c, &name, ty, direction),
        Request::Ready => ready(engine, c),
        Request::Poll { writes } => match write(engine, c, &writes) {
            Ok(()) => {
                let now = engine.shared.now();
                c.waits = Waits::Poll(c.owes.take().unwrap_or(now + c.poll_ns).max(now));
                return None;
            }
            Err(e) => Err(e),
        },
        Request::Attach { name } => attach(engine, c, &name),
        other => engine.carry(other),
    };
    Some(done.map_err(Failure::from))
}

fn hello(
    engine: &mut Engine,
    c: &mut Client,
    protocol: u32,
    name: &str,
    pid: i32,
) -> Result<Reply, Error> {
    if protocol != LATEST {
        c.closing = true;
        let why = format!("this engine speaks version {LATEST} of the protocol, not {protocol}");
        return Err(Error::Protocol { why: why.into() });
    }
    c.pid = pid;
    if !name.is_empty() && c.component.is_none() {
        let name = Name::parse("component", name)?;
        let ix = engine.new_component(name, Some(pid), None, false)?;
        if let Some(me) = engine.graph.component_mut(ix) {
            me.state = ComponentState::Ready;
        }
        c.component = Some(ix);
    }
    let me = c.component.and_then(|ix| engine.graph.component(ix));
    Ok(Reply::Hello {
        protocol: LATEST,
        instance: engine.options.place.name().to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        id: me.map_or(0, |me| me.id),
    })
}

fn join(engine: &mut Engine, c: &mut Client, name: &str, poll_ns: u64) -> Result<Reply, Error> {
    if let Some(old) = c.component.take() {
        engine.remove_component(old);
    }
    c.pins.clear();
    let name = Name::parse("component", name)?;
    c.component = Some(engine.new_component(name, Some(c.pid), None, false)?);
    c.poll_ns = i64::try_from(poll_ns).unwrap_or(i64::MAX);
    Ok(Reply::Done)
}

fn member(engine: &Engine, c: &Client) -> Result<Ix, Error> {
    c.component.filter(|ix| engine.graph.component(*ix).is_some()).ok_or(Error::NotAMember)
}

fn new_pin(
    engine: &mut Engine,
    c: &mut Client,
    name: &str,
    ty: Type,
    direction: Direction,
) -> Result<Reply, Error> {
    let owner = member(engine, c)?;
    let what = if direction.is_pin() { "pin" } else { "parameter" };
    let new = NewItem {
        name: Name::parse(what, name)?,
        other: None,
        ty,
        direction,
        initial: 0,
        storage: None,
        hidden: false,
        times: false,
        doc: engine.graph.doc(""),
    };
    let (ix, _) = engine.new_item(owner, new)?;
    c.pins.push(ix);
    Ok(Reply::Done)
}

fn ready(engine: &mut Engine, c: &mut Client) -> Result<Reply, Error> {
    let ix = member(engine, c)?;
    if let Some(me) = engine.graph.component_mut(ix) {
        me.state = ComponentState::Ready;
    }
    for p in &mut engine.programs {
        p.joined |= p.pid == c.pid;
    }
    if c.poll_ns > 0 {
        c.owes = Some(engine.shared.now() + c.poll_ns);
    }
    Ok(Reply::Done)
}

fn write(engine: &Engine, c: &Client, writes: &[(u32, Value)]) -> Result<(), Error> {
    let odd = |why: &str| Error::Protocol { why: why.into() };
    let mut all = Vec::new();
    for (which, value) in writes {
        let ix = c.pins.get(*which as usize).ok_or_else(|| odd("this client has no such pin"))?;
        let item = engine.graph.item(*ix).ok_or_else(|| odd("this client has no such pin"))?;
        if item.ty != value.ty() || item.ty == Type::Port {
            return Err(odd("a value has not the type of its pin"));
        }
        if matches!(item.direction, Direction::In | Direction::Rw) {
            return Err(odd("a program does not write its own input"));
        }
        all.push((item, value.bits()));
    }
    all.into_iter().for_each(|(item, bits)| item.put(bits));
    Ok(())
}

fn attach(engine: &mut Engine, c: &mut Client, name: &str) -> Result<Reply, Error> {
    let names = engine.rings.keys().map(Name::as_str);
    let near = crate::near::nearest(name, names);
    let ring = engine.rings.get_mut(name).ok_or_else(|| Error::NotFound {
        what: "stream",
        name: name.into(),
        near,
    })?;
    if ring.attached.is_some_and(|by| by != c.id) {
        return Err(Error::StreamTaken { name: name.into() });
    }
    c.fd = Some(ring.fd.try_clone().map_err(|e| Error::System {
        what: "the stream cannot be handed over",
        why: e.to_string().into(),
    })?);
    ring.attached = Some(c.id);
    Ok(Reply::Stream(ring.info(name)))
}

/// A client has gone: its component, its pins and its streams go with it.
fn leave(engine: &mut Engine, c: &Client) {
    for ring in engine.rings.values_mut() {
        if ring.attached == Some(c.id) {
            ring.attached = None;
        }
    }
    if let Some(ix) = c.component {
        engine.remove_component(ix);
    }
}
