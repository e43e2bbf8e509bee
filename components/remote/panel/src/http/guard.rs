//! Checks of every request, and headers of every answer.

use super::timed::{self, CutOff, Limit};
use crate::{
    error::{Code, Error},
    server::{HEAD_TIME, Panel},
};
use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse as _, Response},
};
use std::{sync::Arc, time::Duration};

/// Longest time that the body of a request may take, and the longest time between two parts of an upload.
const BODY_TIME: Duration = HEAD_TIME;
const PART_TIME: Duration = Duration::from_secs(30);

/// Headers of every answer.
const HEADERS: &[(&str, &str)] = &[
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; \
         connect-src 'self'; worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(), geolocation=(), microphone=(), payment=(), usb=()"),
];

/// Refuses requests that were not meant for this server, or that a page of another server has sent.
pub(crate) async fn guard(
    State(panel): State<Arc<Panel>>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match check(&panel, request.headers()) {
        Ok(()) => in_time(request, next).await,
        Err(e) => e.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

/// Answers a request whose body comes in time. An upload may be long, and an operator's: it goes on as long as something of it comes.
async fn in_time(request: Request, next: Next) -> Response {
    let is_upload = request.method() == Method::PUT;
    let limit = if is_upload { Limit::EachPart(PART_TIME) } else { Limit::Whole(BODY_TIME) };
    let mut cut_off = CutOff::default();
    let request = request.map(|body| {
        let (body, its) = timed::body(body, limit);
        cut_off = its;
        body
    });
    let response = next.run(request).await;
    if cut_off.has_happened() && !is_upload {
        let seconds = BODY_TIME.as_secs();
        let text = format!("the body of the request has not come within {seconds} s");
        return Error::new(Code::Malformed, text).into_response();
    }
    named(response)
}

/// Gives a refusal of the libraries below, which is a text, the form of all others.
fn named(response: Response) -> Response {
    let status = response.status();
    let json = HeaderValue::from_static("application/json");
    if !status.is_client_error() || response.headers().get(header::CONTENT_TYPE) == Some(&json) {
        return response;
    }
    let (code, text) = match status {
        StatusCode::PAYLOAD_TOO_LARGE => (Code::TooLarge, "the body of the request is too long"),
        StatusCode::NOT_FOUND => (Code::NotFound, "there is no such path"),
        StatusCode::METHOD_NOT_ALLOWED => (Code::Malformed, "this path has no such method"),
        _ => (Code::Malformed, "the request cannot be read"),
    };
    let mut named = Error::new(code, text).into_response();
    *named.status_mut() = status;
    named
}

fn check(panel: &Panel, headers: &HeaderMap) -> Result<(), Error> {
    let foreign = |text: String| Err(Error::new(Code::ForeignOrigin, text));
    let text = |value: &HeaderValue| String::from_utf8_lossy(value.as_bytes()).into_owned();
    let mut hosts = headers.get_all(header::HOST).iter();
    let (Some(host), None) = (hosts.next().map(text), hosts.next()) else {
        return foreign("a request names one host".to_owned());
    };
    if !panel.security.is_host(panel.address, &host) {
        return foreign(format!("this server is not {host}"));
    }
    let mut origins = headers.get_all(header::ORIGIN).iter().map(text);
    if let Some(origin) =
        origins.find(|origin| *origin != format!("{}://{host}", panel.security.scheme()))
    {
        return foreign(format!("a page of {origin} has sent this request"));
    }
    let site = headers.get("sec-fetch-site").map(text);
    let mode = headers.get("sec-fetch-mode").map(text);
    match (site.as_deref(), mode.as_deref()) {
        // Opening a link of another page only shows the page, which has no session then.
        (Some("cross-site" | "same-site"), mode) if mode != Some("navigate") => {
            foreign("a page of another server has sent this request".to_owned())
        }
        _ => Ok(()),
    }
}
