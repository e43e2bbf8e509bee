//! The WebSocket: status, messages and commands.

mod message;
pub(crate) mod orders;
mod view;

use crate::{
    error::{Code, Error},
    scope::{MAX_SCOPES, Scope, Wanted},
    server::{Panel, SendBuffer},
    session::{Role, Session, cookie, cookie_name},
    values,
};
use axum::{
    Extension,
    extract::{
        State,
        ws::{Message, WebSocket, WebSocketUpgrade},
    },
    http::HeaderMap,
    response::Response,
};
use message::{Received, Watched};
use serde_json::{Map, Value as Json, json};
use std::{
    future::pending,
    sync::{Arc, atomic::Ordering::Relaxed},
    time::Duration,
};
use tokio::{
    sync::mpsc,
    time::{Interval, MissedTickBehavior, interval, timeout},
};
use view::View;

/// Pin of a robot behind its own controller that is TRUE while it runs a program.
const ROBOT_BUSY: &str = "robot.busy";
/// Longest message of a client in bytes.
const MAX_MESSAGE: usize = 64 << 10;
/// Number of answers of commands that wait to be sent.
const MAX_ANSWERS: usize = 64;
/// Longest time until the first message.
const HELLO_TIME: Duration = Duration::from_secs(5);
/// Longest time that a message to a client may take.
const SEND_TIME: Duration = Duration::from_secs(10);
/// Shortest time between two messages with the status.
const STATUS_INTERVAL: Duration = Duration::from_millis(50);
/// Time between two pulses.
const PULSE_INTERVAL: Duration = Duration::from_millis(20);
/// Shortest time between two messages with watched values.
const VALUES_INTERVAL: Duration = Duration::from_millis(100);
/// Messages that a client may send in a second.
const MAX_RATE: u32 = 400;
/// Stops of a client in a second that are answered one by one; the others are obeyed with them.
const MAX_STOPS: u32 = 50;

/// Opens the socket.
pub(crate) async fn open(
    State(panel): State<Arc<Panel>>,
    Extension(send_buffer): Extension<SendBuffer>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    send_buffer.shrink();
    let cookie = cookie(&headers, &cookie_name(panel.address.port()));
    let upgrade = upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    upgrade.on_upgrade(async move |mut socket| {
        let why = match sign_in(&panel, &mut socket, &cookie).await {
            Ok(session) => {
                let client = panel.clients.enter(&session);
                panel.count_clients();
                let mut connection = Connection::new(&panel, session, client);
                let end = connection.serve(&mut socket).await.err();
                panel.clients.leave(&panel.engine, client).await;
                panel.count_clients();
                end
            }
            Err(why) => Some(why),
        };
        if let Some(why) = why {
            // A client that has gone does not read why.
            send(&mut socket, &json!({ "type": "error", "error": why })).await.unwrap_or_default();
        }
        drop(timeout(SEND_TIME, socket.send(Message::Close(None))).await);
    })
}

impl Panel {
    /// Returns whether a job is in progress, also while it is paused.
    async fn works(&self) -> bool {
        let (task, motion) = {
            let machine = self.machine.borrow();
            (machine.task.clone(), machine.motion.clone())
        };
        let number = |of: &Map<String, Json>, name| of.get(name).and_then(Json::as_u64);
        let has = |of, name| number(of, name).is_some_and(|n| n != 0);
        match (task, motion) {
            (Some(task), _) if has(&task, "interpreter") || has(&task, "mdi_queue") => true,
            (_, Some(motion)) => {
                has(&motion, "queue") || motion.get("homing") == Some(&true.into())
            }
            (Some(_), None) => false,
            (None, None) => values::is_on(&self.engine, ROBOT_BUSY).await.unwrap_or(false),
        }
    }

    /// Shows the number of clients at its pin.
    pub(crate) fn count_clients(&self) {
        let count = u32::try_from(self.clients.count()).unwrap_or(u32::MAX);
        self.heart.clients.store(count, Relaxed);
    }
}

async fn sign_in(panel: &Panel, socket: &mut WebSocket, cookie: &str) -> Result<Session, Error> {
    let refuse =
        || Error::new(Code::NoSession, "the first message is hello with the session's key");
    let first = timeout(HELLO_TIME, socket.recv()).await;
    let Ok(Some(Ok(Message::Text(text)))) = first else { return Err(refuse()) };
    match serde_json::from_str(&text) {
        Ok(Received::Hello { key }) => panel.sessions.find(cookie, &key).ok_or_else(refuse),
        _ => Err(refuse()),
    }
}

/// A client that has signed in.
struct Connection {
    panel: Arc<Panel>,
    session: Session,
    /// Role that the session has now.
    role: Role,
    client: u64,
    view: View,
    watched: Watched,
    scope: Option<Scope>,
    /// Number of messages received in the current second.
    rate: u32,
    /// Number of stops received in the current second.
    stops: u32,
    /// True after input of a person in the current second.
    used: bool,
    /// Number of the last beat.
    beat: u32,
    /// Lease of this client that the engine has confirmed.
    confirmed: Option<u64>,
    answers: mpsc::Sender<Json>,
    ready: mpsc::Receiver<Json>,
}

/// Reason for the end of a connection; `None` if the client has gone.
type End = Option<Error>;

impl Connection {
    fn new(panel: &Arc<Panel>, session: Session, client: u64) -> Self {
        let (answers, ready) = mpsc::channel(MAX_ANSWERS);
        Self {
            panel: panel.clone(),
            role: session.role,
            session,
            client,
            view: View::default(),
            watched: Watched::default(),
            scope: None,
            rate: 0,
            stops: 0,
            used: false,
            beat: 0,
            confirmed: None,
            answers,
            ready,
        }
    }

    async fn serve(&mut self, socket: &mut WebSocket) -> Result<(), Error> {
        let end = self.run(socket).await;
        match end {
            Ok(()) | Err(None) => Ok(()),
            Err(Some(why)) => Err(why),
        }
    }

    async fn run(&mut self, socket: &mut WebSocket) -> Result<(), End> {
        let hello = json!({
            "type": "hello", "api": 1, "role": self.session.role, "user": self.session.user,
            "client": self.client,
        });
        give(socket, &hello).await?;
        let mut status = ticks(STATUS_INTERVAL);
        let mut pulse = ticks(PULSE_INTERVAL);
        let mut values = ticks(VALUES_INTERVAL);
        let mut second = ticks(Duration::from_secs(1));
        loop {
            tokio::select! {
                // Beats and commands first.
                biased;
                message = socket.recv() => {
                    let text = match message {
                        Some(Ok(Message::Text(text))) => text,
                        Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                        Some(Ok(Message::Binary(_))) => return Err(malformed("messages are texts")),
                        Some(Ok(Message::Close(_)) | Err(_)) | None => return Err(None),
                    };
                    self.receive(&text)?;
                }
                Some(answer) = self.ready.recv() => give(socket, &answer).await?,
                _ = pulse.tick() => {
                    if self.panel.clients.number(self.client).is_some() {
                        let n = self.panel.heart.pulse.load(Relaxed);
                        give(socket, &json!({ "type": "pulse", "n": n })).await?;
                    }
                }
                _ = status.tick() => {
                    self.check_lease();
                    if let Some(message) = self.view.changes(&self.panel, self.client, self.role) {
                        give(socket, &message).await?;
                    }
                }
                _ = values.tick(), if !self.watched.names.is_empty() => {
                    if let Some(message) = self.changed_values().await {
                        give(socket, &message).await?;
                    }
                }
                Some(samples) = next(&mut self.scope) => give(socket, &samples).await?,
                _ = second.tick() => self.second().await?,
            }
        }
    }

    /// Follows the session once a second: input keeps its role, and beats keep it while a job runs. Without both its person
    /// only looks in the end, and the lease goes back.
    async fn second(&mut self) -> Result<(), End> {
        (self.rate, self.stops) = (0, 0);
        let panel = self.panel.clone();
        if core::mem::take(&mut self.used) {
            panel.sessions.note_input(&self.session);
        }
        if panel.clients.number(self.client).is_some() && panel.works().await {
            panel.sessions.keep(&self.session);
        }
        let over = || Some(Error::new(Code::NoSession, "the session has ended"));
        let role = panel.sessions.role(&self.session).ok_or_else(over)?;
        if role != self.role {
            self.role = role;
            panel.clients.change_role(&panel.engine, self.client, role).await;
        }
        Ok(())
    }

    fn receive(&mut self, text: &str) -> Result<(), End> {
        let received = serde_json::from_str::<Received>(text);
        let stop = received.as_ref().ok().and_then(Received::stop);
        if let Some((ending, role)) = stop {
            self.stops += 1;
            if self.stops > MAX_STOPS && self.role >= role {
                // It is one with those that are on their way, or goes behind them.
                return self.panel.engine.ask_stop(ending).map_err(Some);
            }
        } else {
            self.rate += 1;
        }
        if self.rate > MAX_RATE {
            let why = format!("more than {MAX_RATE} messages in a second");
            return Err(Some(Error::new(Code::TooMany, why)));
        }
        let received = match received {
            Ok(received) => received,
            Err(e) => return self.refuse(text, &format!("this is no message: {e}")),
        };
        self.used |= !matches!(received, Received::Beat { .. } | Received::Watch { .. });
        match received {
            Received::Input {} => {}
            Received::Hello { .. } => return Err(malformed("hello comes first, and once")),
            Received::Beat { n } => {
                let heart = &self.panel.heart;
                // Only what the servo thread has made, and each number once.
                let newer = n.wrapping_sub(self.beat).cast_signed() > 0 || self.beat == 0;
                let made = heart.pulse.load(Relaxed).wrapping_sub(n).cast_signed() >= 0;
                if newer && made && self.panel.clients.answered(self.client) {
                    self.beat = n;
                    heart.beat.store(n, Relaxed);
                }
            }
            Received::Watch { names } => {
                self.watched = Watched::new(names).map_err(Some)?;
            }
            Received::Lease { id, action, to, force } => self.order(id, async move |order| {
                order.lease(action, to, force).await.map(|()| json!({}))
            }),
            Received::Scope { id, capture } => {
                if let Err(e) = self.start_scope(id, capture) {
                    let reply = json!({ "type": "reply", "id": id, "error": e });
                    drop(self.answers.try_send(reply));
                }
            }
            Received::Command { id, name, args } => {
                self.order(id, async move |order| order.command(id, &name, &args).await);
            }
        }
        Ok(())
    }

    /// Ends the scope of this client, and starts another if one is wanted.
    fn start_scope(&mut self, id: u64, wanted: Option<Wanted>) -> Result<(), Error> {
        self.scope = None;
        Session { role: self.role, ..self.session.clone() }.needs(Role::Operator)?;
        let Some(wanted) = wanted else {
            drop(self.answers.try_send(json!({ "type": "reply", "id": id, "ok": {} })));
            return Ok(());
        };
        let full = |_| Error::new(Code::TooMany, format!("{MAX_SCOPES} scopes run already"));
        let permit = self.panel.scopes.clone().try_acquire_owned().map_err(full)?;
        let seat = self.panel.pool.seat(self.session.seated())?;
        let (place, answers) = (self.panel.place.clone(), self.answers.clone());
        self.scope = Some(Scope::start(place, id, wanted, answers, (permit, seat))?);
        Ok(())
    }

    /// Refuses a message that cannot be read. With an `id` it has an answer; without one the connection ends.
    fn refuse(&self, text: &str, why: &str) -> Result<(), End> {
        let id = message::id(text).ok_or_else(|| malformed(why))?;
        let error = Error::new(Code::Malformed, why);
        // A client that reads no answers gets none.
        drop(self.answers.try_send(json!({ "type": "reply", "id": id, "error": error })));
        Ok(())
    }

    /// Notes that the engine has ended the lease of this client.
    fn check_lease(&mut self) {
        let now = self.panel.heart.beating();
        self.panel.clients.check(self.client, now, &mut self.confirmed);
    }

    async fn changed_values(&mut self) -> Option<Json> {
        let now = values::read(&self.panel.engine, &self.watched.names).await.ok()?;
        let changed = self.watched.changes(now);
        (!changed.is_empty()).then(|| json!({ "type": "values", "values": changed }))
    }
}

/// Returns the next samples; never without a scope.
async fn next(scope: &mut Option<Scope>) -> Option<Json> {
    match scope {
        Some(scope) => scope.samples.recv().await,
        None => pending().await,
    }
}

fn ticks(period: Duration) -> Interval {
    let mut ticks = interval(period);
    // A client that reads slowly gets fewer messages.
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    ticks
}

fn malformed(text: &str) -> End {
    Some(Error::new(Code::Malformed, text))
}

/// Sends a message to a client that may have gone.
async fn give(socket: &mut WebSocket, message: &Json) -> Result<(), End> {
    send(socket, message).await.map_err(|()| None)
}

async fn send(socket: &mut WebSocket, message: &Json) -> Result<(), ()> {
    match timeout(SEND_TIME, socket.send(Message::text(message.to_string()))).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(()),
    }
}

#[cfg(test)]
mod tests;
