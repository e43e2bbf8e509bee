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
    body::Body,
    http::{Request, header},
};
use hal_golden::rights::RightsTable;
use hal_protocol::{Answer, Reply};
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use serde_json::{Value as Json, json};
use std::sync::Arc;

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
    all
}

fn asked(who: usize, panel: &Panel, method: &str, path: &str) -> Request<Body> {
    let (name, role) = WHO[who];
    let port = panel.address.port();
    let path = path.replace("{name}", "a.ngc").replace("{kind}", "pins");
    let mut request = Request::builder()
        .method(method)
        .uri(format!("/api/v1{path}"))
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
