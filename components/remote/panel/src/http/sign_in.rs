//! Begin and end of sessions.

use crate::{
    accounts::Wrong,
    error::{Code, Error},
    limits::{Peer, SignInPlace},
    server::Panel,
    session::{LOCAL, Role, Session, cookie, cookie_name, device_name},
};
use axum::{
    Extension, Json,
    body::Bytes,
    extract::{FromRequestParts, State},
    http::{HeaderMap, Method, header, request::Parts},
    response::{AppendHeaders, IntoResponse, Response},
};
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;
use tokio::task::{block_in_place, spawn_blocking};

impl FromRequestParts<Arc<Panel>> for Session {
    type Rejection = Error;

    async fn from_request_parts(parts: &mut Parts, panel: &Arc<Panel>) -> Result<Self, Error> {
        // A page asks by itself, too.
        let is_input = parts.method != Method::GET && parts.method != Method::HEAD;
        panel.sessions.of(&parts.headers, panel.address.port(), is_input)
    }
}

/// Path of sign-ins, to which browsers send the devices that they keep, and the time for which they keep them in seconds.
const PATH: &str = "/api/v1/session";
const YEAR: u32 = 365 * 24 * 3600;
/// Longest name of a user in the audit log, in characters.
const MAX_NAME: usize = 64;

#[derive(Deserialize)]
#[serde(untagged)]
enum Login {
    Token(Token),
    Password(Password),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Token {
    token: String,
    /// Random text that is the same when a lost request is sent again.
    attempt: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Password {
    user: String,
    password: String,
}

impl Panel {
    /// Returns the role of who has the one-time token, which is replaced. The same attempt may take it again for a while.
    pub(crate) fn by_token(&self, token: &str, attempt: Option<&str>) -> Result<Role, Error> {
        if self.sessions.is_repeated(token, attempt) {
            return Ok(self.options.role);
        }
        if !self.sessions.take_token(token) {
            return Err(Error::new(Code::WrongLogin, "the token is wrong, or has been used"));
        }
        if let Err(why) = self.renew_token() {
            // The file still has this token.
            self.sessions.set_token(token.to_owned());
            return Err(Error::new(Code::Disk, why));
        }
        self.sessions.note_taken(token, attempt);
        Ok(self.options.role)
    }

    /// Returns the role of who has this password.
    pub(crate) fn by_password(
        &self,
        user: &str,
        password: &str,
        source: &SignInPlace,
    ) -> Result<Role, Error> {
        let accounts = self.security.accounts.as_ref().ok_or_else(|| {
            Error::new(Code::WrongLogin, "there are no accounts: sign in with the token")
        })?;
        // Hashing a password takes a while, and memory: one after the other.
        block_in_place(|| accounts.check(user, password, source)).map_err(|why| match why {
            Wrong::Login => Error::new(Code::WrongLogin, "the user or the password is wrong"),
            Wrong::Haste(wait) => {
                let seconds = wait.as_secs_f64().ceil();
                let text = format!("too many sign-ins have failed from there: wait {seconds} s");
                Error::new(Code::TooMany, text)
            }
        })
    }
}

/// Begins a session.
pub(crate) async fn sign_in(
    State(panel): State<Arc<Panel>>,
    Extension(peer): Extension<Peer>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Error> {
    let login: Login = serde_json::from_slice(&body)
        .map_err(|e| Error::new(Code::Malformed, format!("this is no login: {e}")))?;
    let port = panel.address.port();
    let (kept, mut device) = (cookie(&headers, &device_name(port)), None);
    let (user, role) = match login {
        Login::Token(login) => {
            (LOCAL.to_owned(), panel.by_token(&login.token, login.attempt.as_deref()))
        }
        Login::Password(login) => {
            let accounts = panel.security.accounts.as_ref();
            // Tables of the system are read beside the threads that serve requests.
            let from = spawn_blocking(move || peer.source()).await;
            let from = from.unwrap_or_else(|_| SignInPlace::at(peer.theirs.ip()));
            let source = match accounts {
                Some(accounts) => accounts.source(&login.user, &kept, from),
                None => from,
            };
            let role = panel.by_password(&login.user, &login.password, &source);
            if role.is_ok() {
                device = accounts.and_then(|accounts| accounts.with_device(&login.user, &kept));
            }
            (login.user, role)
        }
    };
    let shown: String = user.chars().take(MAX_NAME).collect();
    panel.audit.note_login(&shown, "sign-in", role.as_ref().map(|_| ()));
    let begun = panel.sessions.begin(&user, role?);
    let (session, key) = begun.map_err(|why| Error::new(Code::Disk, why))?;
    let secure = if panel.security.tls.is_some() { "; Secure" } else { "" };
    let name = cookie_name(port);
    let mut cookies =
        vec![format!("{name}={}; HttpOnly; SameSite=Strict; Path=/{secure}", session.cookie)];
    cookies.extend(device.map(|device| {
        let name = device_name(port);
        format!("{name}={device}; HttpOnly; SameSite=Strict; Path={PATH}; Max-Age={YEAR}{secure}")
    }));
    let body = json!({ "role": session.role, "user": session.user, "key": key });
    let cookies = AppendHeaders(cookies.into_iter().map(|cookie| (header::SET_COOKIE, cookie)));
    Ok((cookies, Json(body)).into_response())
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

#[cfg(test)]
mod tests {
    //! Attempts that are repeated.

    use crate::{engine::Engine, server::Panel};
    use hal_protocol::Reply;

    #[test]
    fn only_the_same_attempt_takes_the_token_again() {
        let panel = Panel::that(Engine::that(|_| Ok(Reply::Done)), "attempts");
        panel.sessions.set_token("one".to_owned());
        let by = |token: &str, attempt| panel.by_token(token, attempt).is_ok();
        assert!(!by("two", Some("a")));
        assert!(by("one", Some("a")));
        // The next token is in the file, and is no use of this one.
        assert!(!by("one", None) && !by("one", Some("")) && !by("one", Some("b")));
        assert!(by("one", Some("a")));
        panel.sessions.set_token("two".to_owned());
        assert!(by("two", Some("b")));
        assert!(!by("one", Some("a")) && !by("two", Some("a")));
        panel.sessions.set_token("three".to_owned());
        assert!(by("three", None));
        assert!(!by("three", None) && !by("three", Some("")) && !by("one", Some("a")));
        // A token that could not be replaced has not been taken, and the same attempt replaces it.
        panel.sessions.set_token("four".to_owned());
        std::fs::remove_file(&panel.address_file).unwrap();
        std::fs::create_dir(&panel.address_file).unwrap();
        assert!(!by("four", Some("d")) && !by("four", Some("d")));
        std::fs::remove_dir(&panel.address_file).unwrap();
        assert!(by("four", Some("d")));
        let file = std::fs::read_to_string(&panel.address_file).unwrap();
        assert!(!file.contains("four") && !by("four", Some("e")), "{file}");
        std::fs::remove_dir_all(panel.place.folder()).unwrap();
    }
}
