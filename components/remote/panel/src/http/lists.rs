//! Lists of the engine, and its analyses.

use crate::{
    error::{Code, Error},
    server::Panel,
    session::Session,
};
use axum::{
    Json,
    extract::{Path, RawQuery, State},
    http::header,
    response::{IntoResponse as _, Response},
};
use hal_protocol::{Failure, Kind, Reply, Request, ThreadInfo};
use halcmd::programs::latency_test::Band;
use serde::Serialize;
use serde_json::json;
use std::sync::Arc;

/// Kinds of lists, by their path.
const KINDS: &[(&str, Kind)] = &[
    ("components", Kind::Components),
    ("pins", Kind::Pins),
    ("params", Kind::Params),
    ("signals", Kind::Signals),
    ("functs", Kind::Functs),
    ("threads", Kind::Threads),
    ("commands", Kind::Commands),
    ("snapshots", Kind::Snapshots),
];
/// Number of patterns in a request.
const MAX_PATTERNS: usize = 100;

/// Describes the machine.
pub(crate) async fn info(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let mut info = panel.info.clone();
    if let Reply::Status(status) = panel.engine.call(Request::Status).await? {
        info.insert("clock".to_owned(), status.clock.into());
        info.insert("simulated".to_owned(), status.simulated.into());
    }
    Ok(Json(info).into_response())
}

/// Lists things of one kind.
pub(crate) async fn list(
    State(panel): State<Arc<Panel>>,
    _: Session,
    Path(name): Path<String>,
    RawQuery(query): RawQuery,
) -> Result<Response, Error> {
    let missing = || Error::new(Code::NotFound, format!("there is no list '{name}'"));
    let (_, kind) = KINDS.iter().find(|(n, _)| *n == name).ok_or_else(missing)?;
    let patterns = patterns(query.as_deref().unwrap_or_default())?;
    answer(panel.engine.call(Request::List { kind: *kind, patterns, ty: None }).await?)
}

/// Returns the patterns of a query `pattern=…&pattern=…`.
pub(crate) fn patterns(query: &str) -> Result<Vec<String>, Error> {
    let mut patterns = Vec::new();
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        let Some(text) = pair.strip_prefix("pattern=") else {
            return Err(Error::new(Code::Malformed, format!("'{pair}' is not pattern=TEXT")));
        };
        patterns.push(decoded(text));
    }
    if patterns.len() > MAX_PATTERNS {
        return Err(Error::new(Code::TooLarge, format!("at most {MAX_PATTERNS} patterns")));
    }
    Ok(patterns)
}

/// Returns a text without its percent signs.
pub(crate) fn decoded(text: &str) -> String {
    let bytes = text.as_bytes();
    let (mut out, mut at) = (Vec::new(), 0);
    while let Some(byte) = bytes.get(at) {
        let hex = bytes.get(at + 1..at + 3).and_then(|hex| core::str::from_utf8(hex).ok());
        let code = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        match (byte, code) {
            (b'%', Some(code)) => {
                out.push(code);
                at += 3;
                continue;
            }
            (b'+', _) => out.push(b' '),
            _ => out.push(*byte),
        }
        at += 1;
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// State of the instance.
pub(crate) async fn status(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    answer(panel.engine.call(Request::Status).await?)
}

/// Problems of the machine.
pub(crate) async fn check(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    answer(panel.engine.call(Request::Check).await?)
}

/// Order of functions.
pub(crate) async fn order(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    answer(panel.engine.call(Request::Order).await?)
}

/// Start in the middle of a program that the task proposes.
pub(crate) async fn start(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    let args = vec!["json=TRUE".to_owned()];
    let asked = Request::Command { name: "task.start".to_owned(), args };
    let reply = panel.engine.call(asked).await?;
    match &reply {
        Reply::Answer(shown) => {
            let json = shown.lines.concat();
            Ok(([(header::CONTENT_TYPE, "application/json")], json).into_response())
        }
        _ => answer(reply),
    }
}

/// Largest delay of the wake-ups of each thread, with the verdict of `latency-test`.
pub(crate) async fn latency(
    State(panel): State<Arc<Panel>>,
    _: Session,
) -> Result<Response, Error> {
    let list = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
    let Reply::Threads(threads) = panel.engine.call(list).await? else {
        return Err(Error::new(Code::Refused, "the engine lists no threads"));
    };
    let row = |thread: ThreadInfo| {
        let band = Band::of(thread.latency_max);
        json!({
            "thread": thread.name, "period": thread.period, "cycles": thread.cycles,
            "late": thread.latency_max, "verdict": band.name(), "words": band.words(),
        })
    };
    Ok(Json(threads.into_iter().map(row).collect::<Vec<_>>()).into_response())
}

/// State of the flight recorder.
pub(crate) async fn flight(State(panel): State<Arc<Panel>>, _: Session) -> Result<Response, Error> {
    answer(panel.engine.call(Request::FlightState).await?)
}

/// Returns what a reply holds.
fn answer(reply: Reply) -> Result<Response, Error> {
    fn json(value: impl Serialize) -> Response {
        Json(value).into_response()
    }
    Ok(match reply {
        Reply::Components(list) => json(list),
        Reply::Items(list) => json(list),
        Reply::Signals(list) => json(list),
        Reply::Functs(list) => json(list),
        Reply::Threads(list) => json(list),
        Reply::Commands(list) => json(list),
        Reply::Snapshots(list) => json(list),
        Reply::Findings(list) => json(list),
        Reply::Status(status) => json(status),
        Reply::Order(order) => json(order),
        Reply::Flight(flight) => json(flight),
        other => {
            let text = format!("the engine has answered {other:?}");
            return Err(Failure::new(-5, text).into());
        }
    })
}
