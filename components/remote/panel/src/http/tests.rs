//! The table of rights of the API: every path and method by strangers, pages of others and every role.

use super::{DOCUMENT, router};
use crate::{
    engine::Engine,
    folders::Folders,
    lease::tests::run,
    limits::Peer,
    server::{Panel, SendBuffer},
    session::{KEY, Role, cookie_name},
    socket::orders::rights::file,
};
use axum::{
    body::{Body, Bytes, HttpBody},
    http::{Request, header},
};
use hal_golden::rights::RightsTable;
use hal_protocol::{Answer, Reply};
use hyper::{body::Frame, service::Service as _};
use hyper_util::service::TowerToHyperService;
use serde_json::{Value as Json, json};
use std::{
    convert::Infallible,
    pin::Pin,
    sync::Arc,
    task::{Context, Poll},
    time::Duration,
};
use tokio::{
    runtime,
    time::{Instant, Interval, interval},
};

const WHO: [(&str, Role); 6] = [
    ("stranger", Role::Viewer),
    ("foreign-page", Role::Integrator),
    ("without-key", Role::Integrator),
    ("viewer", Role::Viewer),
    ("operator", Role::Operator),
    ("integrator", Role::Integrator),
];
const STATES: [&str; 3] = ["ready", "running", "gone"];

/// Requests of the document, with names where it has places for them.
fn requests() -> Vec<(String, String)> {
    let document: Json = serde_json::from_str(DOCUMENT).unwrap();
    let mut all = Vec::new();
    for (path, methods) in document["paths"].as_object().unwrap() {
        for method in methods.as_object().unwrap().keys() {
            let method = method.to_uppercase();
            if ["GET", "PUT", "POST", "DELETE"].contains(&&*method) {
                all.push((method, path.clone()));
            }
        }
    }
    all.extend(OUTSIDE.map(|path| ("GET".to_owned(), path.to_owned())));
    all
}

/// Files that are no part of the API.
const OUTSIDE: [&str; 2] = ["/index.html", "/manual/index.html"];

fn asked(who: usize, panel: &Panel, method: &str, path: &str) -> Request<Body> {
    let (name, role) = WHO[who];
    let port = panel.address.port();
    let path = path.replace("{name}", "a.ngc").replace("{kind}", "pins");
    let mut request = Request::builder()
        .method(method)
        .uri(if OUTSIDE.contains(&&*path) { path.clone() } else { format!("/api/v1{path}") })
        .header(header::HOST, panel.address.to_string())
        .header(header::CONTENT_TYPE, "application/json");
    if name != "stranger" {
        let (session, key) = panel.sessions.begin("ana", role).unwrap();
        let cookie = format!("{}={}", cookie_name(port), session.cookie);
        request = request.header(header::COOKIE, cookie);
        if name != "without-key" {
            request = request.header(KEY, key);
        }
    }
    if name == "foreign-page" {
        request = request.header(header::ORIGIN, "http://evil.example");
    }
    let body = match (method, &*path) {
        ("POST", "/session") => json!({ "user": "ana", "password": "correct horse" }).to_string(),
        ("PUT", _) => "G0 X1\nM2\n".to_owned(),
        _ => "{}".to_owned(),
    };
    let mut request = request.body(Body::from(body)).unwrap();
    let (theirs, ours) = ("192.0.2.9:4000".parse().unwrap(), panel.address);
    request.extensions_mut().insert(Peer { theirs, ours });
    request.extensions_mut().insert(SendBuffer::default());
    request
}

/// Returns a panel of these circumstances.
fn panel(who: usize, state: &str) -> Panel {
    let engine = Engine::that(|_| {
        Ok(Reply::Answer(Answer { lines: vec!["{}".to_owned()], ticket: None, awaited: false }))
    });
    let mut panel = Panel::that(engine, &format!("api-{who}-{state}"));
    panel.folders = Folders::of(panel.place.folder().to_owned());
    // A picture that is there is not waited for.
    std::fs::write(panel.view_file(), "{\"number\": 1}\nx").unwrap();
    let task = json!({ "interpreter": u64::from(state == "running") });
    let task = task.as_object().cloned();
    let machine = crate::status::Machine { task, ..crate::status::Machine::default() };
    panel.machine = tokio::sync::watch::channel(Arc::new(machine)).1;
    if state == "gone" {
        panel.engine.end();
    }
    panel
}

async fn end(panel: &Arc<Panel>, request: Request<Body>) -> String {
    let answer = TowerToHyperService::new(router(panel)).call(request).await.unwrap();
    let is_right = answer.status().is_success();
    let bytes = axum::body::to_bytes(answer.into_body(), 64 << 20).await.unwrap();
    let code = serde_json::from_slice::<Json>(&bytes).unwrap_or_default();
    let code = code["error"]["code"].as_str().unwrap_or("without a code").to_owned();
    if is_right { "ok".to_owned() } else { code }
}

#[test]
fn every_path_has_the_rights_of_its_rule() {
    let mut table = RightsTable::of(&file("api.rules"));
    run(async {
        for (who, (name, _)) in WHO.iter().enumerate() {
            for state in STATES {
                let panel = Arc::new(panel(who, state));
                for (method, path) in requests() {
                    // Others remove it.
                    let uploads = panel.place.folder().join("uploads");
                    std::fs::create_dir_all(&uploads).unwrap();
                    std::fs::write(uploads.join("a.ngc"), "M2\n").unwrap();
                    let request = asked(who, &panel, &method, &path);
                    let ended = panel.clone();
                    let end = tokio::spawn(async move { end(&ended, request).await });
                    table.row(&format!("{method} {path}"), &[name, state], &end.await.unwrap());
                }
                std::fs::remove_dir_all(panel.place.folder()).unwrap();
            }
        }
    });
    table.finish(&file("api.md"));
}

/// A body that sends a byte with each tick, and never ends.
struct Slow(Interval);

impl HttpBody for Slow {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        self.0.poll_tick(context).map(|_| Some(Ok(Frame::data(Bytes::from_static(b" ")))))
    }
}

#[test]
fn a_body_that_does_not_come_is_not_awaited() {
    let panel = Arc::new(Panel::that(Engine::that(|_| Ok(Reply::Done)), "slow-bodies"));
    let mut runtime = runtime::Builder::new_current_thread();
    let runtime = runtime.enable_time().start_paused(true).build().unwrap();
    runtime.block_on(async {
        let service = TowerToHyperService::new(router(&panel));
        for (path, every, wanted) in [
            ("/session", 1_000_000, (400, 10)),
            ("/session", 1, (400, 10)),
            // What needs no body does not wait for one.
            ("/tools", 1_000_000, (405, 0)),
        ] {
            let mut ticks = interval(Duration::from_secs(every));
            ticks.reset();
            let request = asked(0, &panel, "POST", path).map(|_| Body::new(Slow(ticks)));
            let began = Instant::now();
            let answer = service.call(request).await.unwrap();
            let found = (answer.status().as_u16(), began.elapsed().as_secs());
            assert_eq!(found, wanted, "{path}, a byte every {every} s");
        }
    });
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
}
