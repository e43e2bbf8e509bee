//! Requests of clients: greetings, waits, and the pins of programs that are components.

use crate::{
    Engine, Error,
    change::stores::MAX_STORES,
    graph::Ix,
    graph::new_item::NewItem,
    name::Name,
    os,
    serve::client::{Client, Rights, WaitState},
    serve::dispatch::Answer,
    serve::hold::Hold,
    serve::pins::{Shared, publish_after, take_before},
    serve::polls::period,
};
use hal_protocol::{
    CommandLine, ComponentState, Direction, Failure, LATEST, MAX_AT_END, MAX_PAGE_PINS, OwnRequest,
    PinPageInfo, Reply, Request, Type, Value, WireRequest,
};

/// Longest sleep of a program, in nanoseconds of machine time.
const MAX_SLEEP_NS: i64 = 1_000_000_000_000;

/// Executes the request of a line of client `i`; returns `None` when the answer comes later.
pub(crate) fn respond(
    engine: &mut Engine,
    clients: &mut [Client],
    i: usize,
    line: &[u8],
) -> Option<Result<Reply, Failure>> {
    let wire = match serde_json::from_slice::<WireRequest>(line) {
        Ok(wire) => wire,
        Err(e) => {
            let why = format!("this is not a request: {e}").into();
            return Some(Err(Error::Protocol { why }.into()));
        }
    };
    // What a program has written before it sleeps is taken before the clock moves, not earlier.
    if !matches!(wire.request, Request::Sleep { .. }) {
        take_before(engine, clients, i);
    }
    let reply = execute(engine, clients.get_mut(i)?, wire);
    publish_after(engine, clients, i);
    reply
}

fn execute(
    engine: &mut Engine,
    c: &mut Client,
    wire: WireRequest,
) -> Option<Result<Reply, Failure>> {
    let before = engine.model.visit(wire.at.as_ref());
    let done = engine.dispatch(wire.request, Some(c));
    engine.model.resume(before);
    match done {
        Ok(Answer::Now(reply)) => Some(Ok(reply)),
        Ok(Answer::After(waits, advances_clock)) => {
            if matches!(waits, WaitState::Time(_) | WaitState::Ticket(_)) {
                has_started(engine, c);
            }
            (c.waits, c.advances_clock) = (waits, advances_clock);
            None
        }
        Err(e) => Some(Err(e.into())),
    }
}

/// Handles a request that concerns the client itself.
pub(crate) fn own(
    engine: &mut Engine,
    c: &mut Client,
    request: OwnRequest,
) -> Result<Answer, Error> {
    Ok(Answer::Now(match request {
        OwnRequest::Hello { protocol, name, pid } => hello(engine, c, protocol, &name, pid)?,
        OwnRequest::Join { name, poll_ns } => join(engine, c, &name, poll_ns)?,
        OwnRequest::NewPin { name, ty, direction } => new_pin(engine, c, &name, ty, direction)?,
        OwnRequest::Ready => ready(engine, c)?,
        OwnRequest::Unready => unready(engine, c)?,
        OwnRequest::Leave => remove(engine, c)?,
        OwnRequest::SharePins { pins } => share(engine, c, pins)?,
        OwnRequest::Sleep { ns } => return sleep(engine, c, ns),
        OwnRequest::Poll { writes } => return poll(engine, c, &writes),
        OwnRequest::Attach { name, count } => attach(engine, c, &name, count)?,
        OwnRequest::NewStream { name, depth, types } => {
            if engine.model.rings().keys().any(|n| n.as_str() == name) {
                return Err(Error::StreamTaken { name: name.into() });
            }
            let (info, fd) = engine.clients.own_rings.make(c.id, &name, depth, types)?;
            c.fd = Some(fd);
            Reply::Stream(info)
        }
        OwnRequest::Sample(spec) => {
            let (info, fd) = engine.begin_sample(c.id, &spec)?;
            c.fd = Some(fd);
            has_started(engine, c);
            Reply::Sample(info)
        }
        OwnRequest::AtEnd { commands } => at_end(engine, c, commands)?,
        OwnRequest::SpeakFromAfar => {
            c.rights = c.rights.max(Rights::FromAfar);
            Reply::Done
        }
        OwnRequest::MapSnapshot { name } => {
            let (info, fd) = engine.snapshots.page(&name)?;
            c.fd = Some(fd);
            Reply::SnapshotPage(Box::new(info))
        }
        OwnRequest::SampleState { id } => Reply::SampleState(engine.sample_state(c.id, id)?),
        OwnRequest::EndSample { id } => Reply::SampleState(engine.end_sample(c.id, id)?),
    }))
}

/// Writes values of a program, and waits for its next poll.
fn poll(engine: &Engine, c: &mut Client, writes: &[(u32, Value)]) -> Result<Answer, Error> {
    // On the virtual clock a program's values are written at its poll, however fast the program
    // was.
    c.writes = checked(engine, c, writes)?;
    if !engine.runtime.is_virtual() {
        put_writes(engine, c);
    }
    let now = engine.runtime.now();
    let due = c.poll_due.take().unwrap_or(now.saturating_add(c.poll_ns));
    c.hold = Hold::NONE;
    Ok(Answer::After(WaitState::Poll(due.max(now)), false))
}

/// Sleeps until machine time has passed. A program with a page then owes its next sleep at once:
/// time stands still while the program works.
fn sleep(engine: &Engine, c: &mut Client, ns: u64) -> Result<Answer, Error> {
    member(engine, c)?;
    let ns = i64::try_from(ns).ok().filter(|ns| *ns <= MAX_SLEEP_NS).ok_or_else(|| {
        let why = format!("a program cannot sleep for {ns} ns; expected at most {MAX_SLEEP_NS} ns");
        Error::Protocol { why: why.into() }
    })?;
    (c.poll_due, c.hold) = (None, Hold::NONE);
    Ok(Answer::After(WaitState::Poll(engine.runtime.now().saturating_add(ns)), false))
}

/// Creates the page through which a program exchanges the values of its pins.
fn share(engine: &Engine, c: &mut Client, pins: u32) -> Result<Reply, Error> {
    member(engine, c)?;
    if pins == 0 || pins > MAX_PAGE_PINS {
        let why = format!("a page of {pins} pins is not possible; expected 1 to {MAX_PAGE_PINS}");
        return Err(Error::Protocol { why: why.into() });
    }
    let info = PinPageInfo { pins, is_virtual: engine.runtime.is_virtual() };
    let mut page = Shared::new(&info, c.page.as_ref())?;
    page.publish(engine.model.graph(), &c.pins);
    c.fd = Some(page.file()?);
    c.page = Some(page);
    Ok(Reply::PinPage(info))
}

/// Notes the commands that are executed when the client's connection ends.
fn at_end(engine: &Engine, c: &mut Client, commands: Vec<CommandLine>) -> Result<Reply, Error> {
    if commands.len() > MAX_AT_END {
        let n = commands.len();
        let why = format!("{n} commands at the end are too many; expected at most {MAX_AT_END}");
        return Err(Error::Protocol { why: why.into() });
    }
    for line in &commands {
        crate::graph::find(&engine.model.graph().commands, "command", &line.name)?;
    }
    c.at_end = commands;
    Ok(Reply::Done)
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
    c.pid = c.process(pid);
    let pid = c.pid;
    if !name.is_empty() && c.component.is_none() {
        let name = Name::parse("component", name)?;
        let ix = engine.model.new_component(name, Some(pid), None, false)?;
        if let Some(me) = engine.model.component_mut(ix) {
            me.state = ComponentState::Ready;
        }
        c.component = Some(ix);
    }
    let me = c.component.and_then(|ix| engine.model.graph().component(ix));
    Ok(Reply::Hello {
        protocol: LATEST,
        instance: engine.options.place.name().to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        id: me.map_or(0, |me| me.id),
    })
}

fn join(engine: &mut Engine, c: &mut Client, name: &str, poll_ns: u64) -> Result<Reply, Error> {
    let name = Name::parse("component", name)?;
    let poll_ns = period(poll_ns)?;
    if let Some(old) = c.component.take() {
        engine.remove_component(old);
    }
    c.pins.clear();
    c.writes.clear();
    (c.poll_due, c.poll_ns, c.page) = (None, 0, None);
    c.component = Some(engine.model.new_component(name, Some(c.pid), None, false)?);
    c.poll_ns = poll_ns;
    Ok(Reply::Done)
}

fn member(engine: &Engine, c: &Client) -> Result<Ix, Error> {
    c.component.filter(|ix| engine.model.graph().component(*ix).is_some()).ok_or(Error::NotAMember)
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
        safety: false,
        measured: false,
        doc: engine.model.doc(""),
    };
    let (ix, _) = engine.model.new_item(owner, new)?;
    engine.flight_is_stale();
    c.pins.push(ix);
    Ok(Reply::Done)
}

/// Ends the clock's wait for a program that has started its actual work.
fn has_started(engine: &mut Engine, c: &Client) {
    for p in &mut engine.clients.programs {
        p.joined |= p.pid == c.pid;
    }
}

fn ready(engine: &mut Engine, c: &mut Client) -> Result<Reply, Error> {
    let ix = member(engine, c)?;
    if let Some(me) = engine.model.component_mut(ix) {
        me.state = ComponentState::Ready;
    }
    has_started(engine, c);
    if c.poll_ns > 0 {
        c.poll_due = Some(engine.runtime.now().saturating_add(c.poll_after()));
    }
    Ok(Reply::Done)
}

fn unready(engine: &mut Engine, c: &mut Client) -> Result<Reply, Error> {
    let ix = member(engine, c)?;
    if let Some(me) = engine.model.component_mut(ix) {
        me.state = ComponentState::Initializing;
    }
    (c.poll_due, c.hold) = (None, Hold::NONE);
    Ok(Reply::Done)
}

/// Removes the component of a program that stays connected.
fn remove(engine: &mut Engine, c: &mut Client) -> Result<Reply, Error> {
    let ix = member(engine, c)?;
    (c.poll_due, c.hold, c.page, c.component) = (None, Hold::NONE, None, None);
    c.pins.clear();
    c.writes.clear();
    engine.model.has_left([ix]);
    forget_left(engine);
    Ok(Reply::Done)
}

/// Writes the values that a program has sent.
pub(crate) fn put_writes(engine: &Engine, c: &mut Client) {
    for (ix, bits) in c.writes.drain(..) {
        if let Some(item) = engine.model.graph().item(ix) {
            item.put(bits);
        }
    }
}

/// Checks the writes of a poll, and that this client may poll at all.
fn checked(engine: &Engine, c: &Client, writes: &[(u32, Value)]) -> Result<Vec<(Ix, u64)>, Error> {
    let malformed = |why: &str| Error::Protocol { why: why.into() };
    member(engine, c)?;
    let mut all = Vec::new();
    for (which, value) in writes {
        let ix =
            c.pins.get(*which as usize).ok_or_else(|| malformed("this client has no such pin"))?;
        let item = engine
            .model
            .graph()
            .item(*ix)
            .ok_or_else(|| malformed("this client has no such pin"))?;
        if item.ty != value.ty() || item.ty == Type::Port {
            return Err(malformed("the value's type does not match its pin"));
        }
        if matches!(item.direction, Direction::In | Direction::Rw) {
            return Err(malformed("a program does not write its own input"));
        }
        all.push((*ix, value.bits()));
    }
    if c.poll_ns == 0 {
        return Err(malformed(
            "this program has joined without a period for its polls (poll_ns is 0)",
        ));
    }
    Ok(all)
}

fn attach(
    engine: &mut Engine,
    c: &mut Client,
    name: &str,
    count: Option<u64>,
) -> Result<Reply, Error> {
    // A component's ring comes first: a program may have made one of its name before the component was loaded.
    if engine.model.ring_mut(name).is_none()
        && let Some(own) = engine.clients.own_rings.attach(c.id, name)
    {
        let (info, fd) = own?;
        c.fd = Some(fd);
        return Ok(Reply::Stream(info));
    }
    let names = engine.model.rings().keys().map(Name::as_str);
    let near = crate::error::near::nearest(name, names);
    let ring = engine.model.ring_mut(name).ok_or_else(|| Error::NotFound {
        what: "stream",
        name: name.into(),
        near,
    })?;
    if ring.attached.is_some_and(|by| by != c.id) {
        return Err(Error::StreamTaken { name: name.into() });
    }
    c.fd = Some(ring.memory.file().map_err(|e| Error::System {
        what: "the stream cannot be handed over",
        why: os::said(&e),
    })?);
    ring.attach(c.id, c.pid, count);
    let info = ring.info(name);
    has_started(engine, c);
    Ok(Reply::Stream(info))
}

/// Removes a disconnected client: its component, its pins and its streams.
pub(crate) fn leave(engine: &mut Engine, c: &mut Client) {
    for line in core::mem::take(&mut c.at_end) {
        // What has ended by itself needs no end: nobody is left to tell.
        drop(engine.command(&line.name, &line.args, c.rights > Rights::Own));
    }
    c.take_page(engine);
    for ring in engine.model.rings_mut().map(|(_, ring)| ring) {
        if ring.attached == Some(c.id) {
            ring.attached = None;
        }
    }
    engine.end_samples_of(c.id);
    engine.clients.own_rings.leave(c.id);
    if let Some(ix) = c.component {
        engine.model.has_left([ix]);
        forget_left(engine);
    }
}

/// Removes components whose programs have disconnected; those that a stuck thread holds are kept
/// for later.
pub(crate) fn forget_left(engine: &mut Engine) {
    for ix in engine.model.take_left() {
        // A few pins at a time: within the limit of stores, so that running threads need not stop.
        let pins: Vec<Ix> = engine.model.graph().owned(ix);
        let unlinked = pins.chunks(MAX_STORES / 2).try_for_each(|some| {
            let unlinked = engine.transact(|e| {
                e.model.unlink_all(some);
                Ok(())
            });
            unlinked.map(|_| ())
        });
        if unlinked.is_ok() {
            engine.remove_component(ix);
        }
        if engine.model.graph().component(ix).is_some() {
            engine.model.has_left([ix]);
        }
    }
}
