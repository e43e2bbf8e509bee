//! Checks of every request, and headers of every answer.

use crate::{
    error::{Code, Error},
    server::Panel,
};
use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header},
    middleware::Next,
    response::{IntoResponse as _, Response},
};
use std::sync::Arc;

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
        Ok(()) => named(next.run(request).await),
        Err(e) => e.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
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
