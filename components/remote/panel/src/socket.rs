//! The WebSocket: status, messages and commands.

use crate::{
    error::{Code, Error},
    server::Panel,
    session::{Session, cookie},
    status::{Machine, changes},
};
use axum::{
    extract::{
        State,
        ws::{Message, WebSocket, WebSocketUpgrade},
    },
    http::HeaderMap,
    response::Response,
};
use hal_protocol::{Reply, Request};
use serde::Deserialize;
use serde_json::{Map, Value as Json, json};
use std::{sync::Arc, time::Duration};
use tokio::time::timeout;

/// Longest message of a client in bytes.
const MAX_MESSAGE: usize = 64 << 10;
/// Longest time until the first message.
const HELLO_TIME: Duration = Duration::from_secs(5);
/// Shortest time between two messages with the status.
const STATUS_INTERVAL: Duration = Duration::from_millis(50);

/// A message of a client.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
enum Received {
    Hello { key: String },
    Command { id: u64, name: String, args: Map<String, Json> },
}

/// Opens the socket.
pub(crate) async fn open(
    State(panel): State<Arc<Panel>>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let cookie = cookie(&headers, panel.address.port());
    let upgrade = upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    upgrade.on_upgrade(async move |mut socket| {
        let why = match sign_in(&panel, &mut socket, &cookie).await {
            Ok(session) => serve(&panel, &mut socket, &session).await.err(),
            Err(why) => Some(why),
        };
        if let Some(why) = why {
            // A client that has gone does not read why.
            drop(send(&mut socket, &json!({ "type": "error", "error": why })).await);
        }
        drop(socket.send(Message::Close(None)).await);
    })
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

async fn serve(panel: &Panel, socket: &mut WebSocket, session: &Session) -> Result<(), Error> {
    let hello = json!({ "type": "hello", "api": 1, "role": session.role, "user": session.user });
    if send(socket, &hello).await.is_err() {
        return Ok(());
    }
    let mut machine = panel.machine.clone();
    machine.mark_changed();
    let mut before = Machine::default();
    let mut pace = tokio::time::interval(STATUS_INTERVAL);
    pace.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            _ = pace.tick() => {
                if !panel.sessions.lives(session) {
                    return Err(Error::new(Code::NoSession, "the session has ended"));
                }
                let now = machine.borrow_and_update().clone();
                let Some(status) = status(&before, &now) else { continue };
                before = now.as_ref().clone();
                if send(socket, &status).await.is_err() {
                    return Ok(());
                }
            }
            message = socket.recv() => {
                let text = match message {
                    Some(Ok(Message::Text(text))) => text,
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                    Some(Ok(Message::Binary(_))) => {
                        return Err(Error::new(Code::Malformed, "messages are texts"));
                    }
                    Some(Ok(Message::Close(_)) | Err(_)) | None => return Ok(()),
                };
                let received = serde_json::from_str(&text)
                    .map_err(|e| Error::new(Code::Malformed, format!("this is no message: {e}")))?;
                let answer = match received {
                    Received::Hello { .. } => {
                        return Err(Error::new(Code::Malformed, "hello comes first, and once"));
                    }
                    Received::Command { id, name, args } => match command(panel, &name, &args).await {
                        Ok(ok) => json!({ "type": "reply", "id": id, "ok": ok }),
                        Err(e) => json!({ "type": "reply", "id": id, "error": e }),
                    },
                };
                if send(socket, &answer).await.is_err() {
                    return Ok(());
                }
            }
        }
    }
}

async fn command(panel: &Panel, name: &str, _args: &Map<String, Json>) -> Result<Json, Error> {
    if name != "abort" {
        return Err(Error::new(Code::NotFound, format!("there is no command '{name}'")));
    }
    let request = Request::Command { name: "task.abort".to_owned(), args: Vec::new() };
    match panel.engine.call(request).await? {
        Reply::Answer(answer) => Ok(json!({ "lines": answer.lines })),
        _ => Ok(json!({})),
    }
}

/// Returns the message with what has changed.
fn status(before: &Machine, now: &Machine) -> Option<Json> {
    let motion = changes(before.motion.as_ref(), now.motion.as_ref());
    let task = changes(before.task.as_ref(), now.task.as_ref());
    let panel = (before.engine != now.engine).then(|| json!({ "engine": now.engine }));
    let parts = [("motion", motion), ("task", task), ("panel", panel)];
    let parts = parts.into_iter().filter_map(|(name, part)| Some((name.to_owned(), part?)));
    let mut message: Map<String, Json> = parts.collect();
    if message.is_empty() {
        return None;
    }
    message.insert("type".to_owned(), "status".into());
    Some(message.into())
}

async fn send(socket: &mut WebSocket, message: &Json) -> Result<(), axum::Error> {
    socket.send(Message::text(message.to_string())).await
}
