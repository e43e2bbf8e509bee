//! Begin and end of sessions.

use crate::{
    error::{Code, Error},
    server::Panel,
    session::{Session, cookie_name},
};
use axum::{
    Json,
    body::Bytes,
    extract::{FromRequestParts, State},
    http::{HeaderMap, header, request::Parts},
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;

/// Name of who opened the address with the one-time token.
const LOCAL: &str = "local";

impl FromRequestParts<Arc<Panel>> for Session {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, panel: &Arc<Panel>) -> Result<Self, Error> {
        panel.sessions.of(&parts.headers, panel.address.port())
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Login {
    token: String,
}

/// Begins a session.
pub(crate) async fn sign_in(
    State(panel): State<Arc<Panel>>,
    body: Bytes,
) -> Result<Response, Error> {
    let login: Login = serde_json::from_slice(&body)
        .map_err(|e| Error::new(Code::Malformed, format!("this is no login: {e}")))?;
    if !panel.sessions.take_token(&login.token) {
        return Err(Error::new(Code::WrongLogin, "the token is wrong, or has been used"));
    }
    let fail = |text: String| Error::new(Code::Disk, text);
    if let Err(why) = panel.renew_token() {
        // The file still has this token.
        panel.sessions.set_token(login.token);
        return Err(fail(why));
    }
    let (session, key) = panel.sessions.begin(LOCAL, panel.options.role).map_err(fail)?;
    let name = cookie_name(panel.address.port());
    let cookie = format!("{name}={}; HttpOnly; SameSite=Strict; Path=/", session.cookie);
    let body = json!({ "role": session.role, "user": session.user, "key": key });
    Ok(([(header::SET_COOKIE, cookie)], Json(body)).into_response())
}

/// Tells whose session it is.
pub(crate) async fn who(session: Session) -> impl IntoResponse {
    Json(json!({ "role": session.role, "user": session.user }))
}

/// Ends a session.
pub(crate) async fn sign_out(
    State(panel): State<Arc<Panel>>,
    session: Session,
) -> impl IntoResponse {
    panel.sessions.end(&session);
    let mut headers = HeaderMap::new();
    let name = cookie_name(panel.address.port());
    let gone = format!("{name}=; HttpOnly; SameSite=Strict; Path=/; Max-Age=0");
    if let Ok(gone) = gone.parse() {
        headers.insert(header::SET_COOKIE, gone);
    }
    (headers, Json(json!({})))
}
