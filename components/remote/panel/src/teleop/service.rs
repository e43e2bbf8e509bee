//! The service between connections, the state machine of the protocol, and the machine.

use super::{
    check::Progress,
    connection,
    job::{self, Begun, User, number},
    settings::Settings,
    sign_in,
};
use crate::{error::Error, limits::Peer, server::Panel, session::Role, status::Joined};
use serde_json::Value as Json;
use std::{
    collections::BTreeMap,
    net::SocketAddr,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    time::Duration,
};
use teleop::{Action, Machine, Reason, Server};
use tokio::{
    io::AsyncWriteExt as _,
    net::{TcpListener, TcpStream},
    sync::{Semaphore, mpsc, watch},
    time::{MissedTickBehavior, interval, timeout},
};
use tokio_rustls::TlsAcceptor;

/// Time between two looks at the machine.
const LOOK: Duration = Duration::from_millis(20);
/// Number of segments that wait to be read, and of answers of a connection that wait to be sent.
const MAX_SEGMENTS: usize = 256;
const MAX_ANSWERS: usize = 64;
/// Longest time for the beginning of TLS.
const TLS_TIME: Duration = Duration::from_secs(10);
/// Modes of the task's status in which a program runs.
const AUTO: u64 = 1;

/// Answers to clients that are not served.
const FULL: &str = "DENEGADO OCUPADO too many connections, or the server stops\r\n";
const NOT_ALLOWED: &str = "DENEGADO PERMISO [REMOTE]TELEOP_ALLOW does not have this address\r\n";

/// Something that has happened beside the service.
enum Notice {
    Bytes(u64, Vec<u8>),
    Gone(u64),
    SignedIn(u64, String, Result<Role, Error>),
    Started(Result<Begun, Reason>),
    Ended(Result<(), Reason>),
}

struct Connection {
    peer: Peer,
    answers: mpsc::Sender<Vec<u8>>,
    /// Permits to read a segment.
    permits: Arc<Semaphore>,
    /// True if the permit is kept until the server has room.
    waits: bool,
    user: Option<User>,
}

/// The service.
pub(super) struct Service {
    panel: Arc<Panel>,
    is_network: bool,
    /// TLS, at a network address.
    tls: Option<TlsAcceptor>,
    settings: Settings,
    server: Server,
    connections: BTreeMap<u64, Connection>,
    events: mpsc::Sender<Notice>,
    happened: mpsc::Receiver<Notice>,
    /// User whose job starts or runs; it outlives the connection.
    owner: Option<User>,
    /// True once that job is over, or has not begun.
    is_over: Arc<AtomicBool>,
    progress: Progress,
    /// Lease of the owner that the engine has confirmed.
    confirmed: Option<u64>,
    /// Machine time in milliseconds.
    now: u64,
}

impl Service {
    pub(super) fn new(panel: &Arc<Panel>, is_network: bool, settings: Settings) -> Self {
        let (events, happened) = mpsc::channel(MAX_SEGMENTS);
        Self {
            panel: panel.clone(),
            is_network,
            tls: panel.security.tls.as_ref().filter(|_| is_network).map(|t| t.acceptor.clone()),
            settings,
            server: Server::default(),
            connections: BTreeMap::new(),
            events,
            happened,
            owner: None,
            is_over: Arc::default(),
            progress: Progress::default(),
            confirmed: None,
            now: panel.heart.pulse.load(Relaxed).into(),
        }
    }

    /// Serves clients until the pin, this program or the engine ends the service.
    pub(super) async fn run(mut self, listener: &TcpListener, end: &watch::Receiver<bool>) {
        let mut look = interval(LOOK);
        look.set_missed_tick_behavior(MissedTickBehavior::Delay);
        while !(self.server.is_stopped() && self.connections.is_empty()) {
            tokio::select! {
                biased;
                _ = look.tick() => self.look(*end.borrow()),
                Some(event) = self.happened.recv() => self.take(event),
                Ok((stream, peer)) = listener.accept() => if self.settings.admits(peer.ip()) {
                    self.connect(stream, peer);
                } else {
                    refuse(stream, self.tls.is_none(), NOT_ALLOWED);
                },
            }
            self.act();
        }
        let pins = &self.panel.heart.teleop;
        pins.listening.store(0, Relaxed);
        self.show();
    }

    /// Follows machine time.
    fn advance(&mut self) {
        let pulse = self.panel.heart.pulse.load(Relaxed);
        self.now += u64::from(pulse.wrapping_sub(low(self.now)));
    }

    /// Follows the machine.
    fn look(&mut self, ends: bool) {
        self.advance();
        let is_gone = self.panel.machine.borrow().engine == Joined::Gone;
        if ends || is_gone || !self.panel.heart.teleop.serve.load(Relaxed) {
            self.server.stop(self.now);
        }
        let machine = self.machine();
        self.server.machine(machine);
        self.server.poll(self.now);
        self.check_lease();
        self.show();
    }

    /// Returns the machine as the server shall know it. What moves there is judged by the start itself, whose status is
    /// no older than the request.
    fn machine(&mut self) -> Machine {
        let busy = job::leased(&self.panel, None);
        let machine = self.panel.machine.borrow();
        let (Some(task), Some(motion)) = (&machine.task, &machine.motion) else {
            return Machine { busy, progress: None };
        };
        if self.server.runs() {
            let to_go = motion.get("distance_to_go").and_then(Json::as_f64).unwrap_or(0.0);
            let line = u32::try_from(number(motion, "line")).unwrap_or(0);
            self.progress.look(line, to_go);
            return Machine { busy, progress: Some(self.progress.percent()) };
        }
        // A job of somebody else: by its time, as its path is not known here.
        let runs = number(task, "interpreter") != 0 && number(task, "mode") == AUTO;
        let seconds = |name: &str| task.get(name).and_then(Json::as_f64).unwrap_or(-1.0);
        let (passed, left) = (seconds("job_time"), seconds("time_left"));
        let share = if left >= 0.0 { 100.0 * passed / (passed + left) } else { 0.0 };
        let progress = (0..99).take_while(|n| f64::from(*n) + 1.0 <= share).count();
        Machine { busy, progress: runs.then(|| u8::try_from(progress).unwrap_or(99)) }
    }

    /// Notes that the engine has ended the lease of the owner.
    fn check_lease(&mut self) {
        let Some(owner) = &self.owner else { return };
        let clients = &self.panel.clients;
        clients.check(owner.client, self.panel.heart.beating(), &mut self.confirmed);
    }

    /// Shows the state at the pins, and keeps the lease of an owner that is there.
    fn show(&self) {
        let pins = &self.panel.heart.teleop;
        pins.sessions.store(u32::try_from(self.server.users()).unwrap_or(u32::MAX), Relaxed);
        pins.running.store(self.server.runs(), Relaxed);
        pins.link_ok.store(self.server.is_linked(), Relaxed);
        pins.progress.store(self.server.progress().into(), Relaxed);
        let until = self.server.answers_until(self.now);
        self.panel.heart.answers_until.store(low(until), Relaxed);
        if let Some(owner) = self.owner.as_ref().filter(|_| self.now <= until) {
            // Who is there for a job has no page that could answer.
            self.panel.clients.answered(owner.client);
        }
    }

    fn connect(&mut self, stream: TcpStream, peer: SocketAddr) {
        let tls = self.tls.clone();
        // Without it, small answers wait for the acknowledgement of the one before.
        drop(stream.set_nodelay(true));
        connection::keep_alive(&stream);
        let Some(id) = self.server.connect(peer.ip().to_canonical(), self.now) else {
            return refuse(stream, tls.is_none(), FULL);
        };
        let ours = stream.local_addr().unwrap_or(peer);
        let peer = Peer { theirs: peer, ours };
        let (answers, mut queue) = mpsc::channel(MAX_ANSWERS);
        let permits = Arc::new(Semaphore::new(1));
        let connection =
            Connection { peer, answers, permits: permits.clone(), waits: false, user: None };
        self.connections.insert(id, connection);
        let events = self.events.clone();
        tokio::spawn(async move {
            let (to, event) = (events.clone(), move |bytes| Notice::Bytes(id, bytes));
            match tls {
                None => connection::serve(stream, permits, to, event, queue).await,
                Some(tls) => {
                    let accepted = tokio::select! {
                        accepted = timeout(TLS_TIME, tls.accept(stream)) => accepted.ok(),
                        // It ends before it has begun.
                        _ = queue.recv() => None,
                    };
                    if let Some(Ok(stream)) = accepted {
                        connection::serve(stream, permits, to, event, queue).await;
                    }
                }
            }
            drop(events.send(Notice::Gone(id)).await);
        });
    }

    fn take(&mut self, event: Notice) {
        self.advance();
        let now = self.now;
        match event {
            Notice::Bytes(id, bytes) => {
                self.server.receive(id, &bytes, now);
                if let Some(connection) = self.connections.get_mut(&id) {
                    connection.waits = true;
                }
            }
            Notice::Gone(id) => {
                self.server.gone(id);
                if let Some(user) = self.connections.remove(&id).and_then(|c| c.user) {
                    let panel = self.panel.clone();
                    tokio::spawn(async move {
                        panel.clients.leave(&panel.engine, user.client).await;
                        panel.count_clients();
                    });
                }
            }
            Notice::SignedIn(id, user, role) => {
                let result = role.as_ref().map(|role| *role >= Role::Operator);
                self.server.signed_in(id, result.map_err(|e| e.text.clone()), now);
                let is_in = self.server.user(id) == Some(user.as_str());
                if let (Ok(role), true, Some(c)) = (role, is_in, self.connections.get_mut(&id)) {
                    c.user = Some(sign_in::enter(&self.panel, &user, role));
                }
            }
            Notice::Started(Ok(begun)) => {
                self.progress = Progress::new(begun.lengths.clone());
                self.server.started(Ok(()), now);
                if let Some(owner) = self.owner.clone() {
                    let (panel, events) = (self.panel.clone(), self.events.clone());
                    tokio::spawn(async move {
                        let end = job::follow(&panel, &owner, &begun).await;
                        drop(events.send(Notice::Ended(end)).await);
                    });
                }
            }
            Notice::Started(Err(why)) => {
                self.owner = None;
                self.is_over.store(true, Relaxed);
                self.is_free();
                self.server.started(Err(why), now);
            }
            Notice::Ended(end) => {
                self.owner = None;
                self.is_over.store(true, Relaxed);
                self.confirmed = None;
                self.is_free();
                self.server.ended(end, now);
            }
        }
    }

    /// Shows the machine to the server after a job: the next request may have arrived already.
    fn is_free(&mut self) {
        let busy = job::leased(&self.panel, None);
        self.server.machine(Machine { busy, progress: None });
    }

    /// Does what the state machine wants, and sends its answers.
    fn act(&mut self) {
        while let Some(action) = self.server.action() {
            match action {
                Action::SignIn { id, user, secret } => {
                    let (panel, events) = (self.panel.clone(), self.events.clone());
                    let is_network = self.is_network;
                    let Some(peer) = self.connections.get(&id).map(|c| c.peer) else { continue };
                    tokio::spawn(async move {
                        // Hashing a password takes a while.
                        let role = tokio::task::block_in_place(|| {
                            sign_in::role(&panel, &user, &secret, &peer.source(), is_network)
                        });
                        drop(events.send(Notice::SignedIn(id, user, role)).await);
                    });
                }
                Action::Start { id, program } => self.start(id, program),
                Action::Cancel => {
                    let (panel, owner) = (self.panel.clone(), self.owner.clone());
                    let is_over = self.is_over.clone();
                    let end = self.settings.ends_command.then_some(job::MAX_END);
                    tokio::spawn(async move {
                        job::cancel(&panel, owner.as_ref(), &is_over, end).await;
                    });
                }
                Action::Lose => self.lose(),
                Action::Close(id) => {
                    self.flush(id);
                    if let Some(connection) = self.connections.get_mut(&id) {
                        // The connection ends behind what is sent already.
                        connection.answers = mpsc::channel(1).0;
                    }
                }
            }
        }
        for id in self.connections.keys().copied().collect::<Vec<_>>() {
            self.flush(id);
            if let Some(connection) = self.connections.get_mut(&id)
                && connection.waits
                && !self.server.is_full(id)
            {
                connection.waits = false;
                connection.permits.add_permits(1);
            }
        }
    }

    /// Sends the answers of a connection; one that reads nothing ends.
    fn flush(&mut self, id: u64) {
        let output = self.server.output(id);
        if output.is_empty() {
            return;
        }
        if let Some(connection) = self.connections.get(&id)
            && connection.answers.try_send(output).is_err()
        {
            connection.permits.close();
        }
    }

    fn start(&mut self, id: u64, program: Vec<u8>) {
        let user = self.connections.get(&id).and_then(|c| c.user.clone());
        self.owner.clone_from(&user);
        self.is_over = Arc::default();
        self.show();
        let (panel, events) = (self.panel.clone(), self.events.clone());
        // A stop from here on stops this start too.
        let stops = job::Stops::of(&panel);
        tokio::spawn(async move {
            let begun = match &user {
                Some(user) => job::start(&panel, user, program, stops).await,
                None => Err(Reason::new(teleop::Code::Orden, "log in first")),
            };
            drop(events.send(Notice::Started(begun)).await);
        });
    }

    /// Gives the lease of a vanished client back: its job ends as `[REMOTE]ON_LOSS` says.
    fn lose(&self) {
        let Some(owner) = self.owner.clone() else { return };
        let panel = self.panel.clone();
        tokio::spawn(async move { job::end_lease(&panel, &owner).await });
    }
}

/// Answers a client that is not served; one that would have to begin TLS for that gets no answer.
fn refuse(mut stream: TcpStream, is_plain: bool, answer: &'static str) {
    if is_plain {
        tokio::spawn(async move {
            // A client that has gone needs no answer.
            drop(timeout(TLS_TIME, stream.write_all(answer.as_bytes())).await);
        });
    }
}

/// Returns the lower half of a time, as pulses have it.
fn low(time: u64) -> u32 {
    u32::try_from(time & u64::from(u32::MAX)).unwrap_or_default()
}

#[cfg(test)]
mod tests;
