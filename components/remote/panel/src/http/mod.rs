//! Requests over HTTP.

mod align;
mod graph;
mod guard;
mod lists;
mod machine;
mod output;
pub(crate) mod pictures;
mod programs;
mod sent;
mod sign_in;
mod timed;

use crate::{
    error::{Code, Error},
    page,
    server::Panel,
    socket,
};
use axum::{
    Router,
    extract::{DefaultBodyLimit, Request, State},
    http::header,
    middleware,
    response::{IntoResponse as _, Response},
    routing::{any, get, post},
};
use std::sync::Arc;

/// Longest body of a request that is no upload.
const MAX_BODY: usize = 64 << 10;

/// The API as `OpenAPI` describes it.
const DOCUMENT: &str = include_str!("../../openapi.json");

/// Returns all routes.
pub(crate) fn router(panel: &Arc<Panel>) -> Router {
    let session = get(sign_in::who).post(sign_in::sign_in).delete(sign_in::sign_out);
    // The upload has its own limit.
    let program = get(programs::text)
        .put(programs::store)
        .delete(programs::remove)
        .layer(DefaultBodyLimit::disable());
    let api = Router::new()
        .route("/session", session)
        .route("/info", get(lists::info))
        .route("/status", get(lists::status))
        .route("/check", get(lists::check))
        .route("/order", get(lists::order))
        .route("/latency", get(lists::latency))
        .route("/openapi.json", get(document))
        .route("/start", get(lists::start))
        .route("/graph", get(graph::svg))
        .route("/flight", get(lists::flight))
        .route("/tools", get(machine::tools))
        .route("/offsets", get(machine::offsets))
        .route("/align", get(align::state))
        .route("/align/picture", get(align::picture))
        .route("/programs/{name}/align", post(align::rewrite))
        .route("/programs/{name}/path", get(machine::path))
        .route("/programs", get(programs::list))
        .route("/programs/{name}", program)
        .route("/output", get(output::list))
        .route("/output/{name}", get(output::file))
        .route("/socket", any(socket::open))
        .route("/{kind}", get(lists::list))
        .fallback(async || Error::new(Code::NotFound, "there is no such path").into_response());
    Router::new()
        .nest("/api/v1", api)
        .fallback(file)
        .layer(DefaultBodyLimit::max(MAX_BODY))
        .layer(middleware::from_fn_with_state(panel.clone(), guard::guard))
        .with_state(panel.clone())
}

/// Returns the description of this API.
async fn document() -> Response {
    ([(header::CONTENT_TYPE, "application/json")], DOCUMENT).into_response()
}

async fn file(State(panel): State<Arc<Panel>>, request: Request) -> Response {
    let path = request.uri().path().to_owned();
    if path.starts_with("/api/") {
        return Error::new(Code::NotFound, "there is no such path").into_response();
    }
    page::file(panel.options.page.as_deref(), &path, request.headers()).await
}

#[cfg(test)]
mod tests;
