//! Checks of every request, and headers of every answer.

use crate::{
    error::{Code, Error},
    server::Panel,
};
use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderName, HeaderValue, header},
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
        Ok(()) => next.run(request).await,
        Err(e) => e.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

fn check(panel: &Panel, headers: &HeaderMap) -> Result<(), Error> {
    let foreign = |text: String| Err(Error::new(Code::ForeignOrigin, text));
    let text = |value: &HeaderValue| String::from_utf8_lossy(value.as_bytes()).into_owned();
    let mut hosts = headers.get_all(header::HOST).iter();
    let (Some(host), None) = (hosts.next().map(text), hosts.next()) else {
        return foreign("a request names one host".to_owned());
    };
    if !panel.is_host(&host) {
        return foreign(format!("this server is not {host}"));
    }
    let mut origins = headers.get_all(header::ORIGIN).iter().map(text);
    if let Some(origin) = origins.find(|origin| *origin != format!("http://{host}")) {
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

impl Panel {
    /// Returns whether a request for this host is for this server.
    fn is_host(&self, host: &str) -> bool {
        let port = self.address.port();
        host == self.address.to_string()
            || host == format!("localhost:{port}")
            || (port == 80 && (host == "localhost" || host == self.address.ip().to_string()))
    }
}
