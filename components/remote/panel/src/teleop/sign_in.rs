//! Logins of the protocol: with the panel's one-time token, or with a password.

use super::job::User;
use crate::{
    error::Error,
    server::Panel,
    session::{Role, Session},
};
use serde_json::json;

/// Checks a login; returns its role.
pub(super) fn role(panel: &Panel, user: &str, secret: &str) -> Result<Role, Error> {
    let role = match panel.by_token(secret) {
        // A password cannot be a token: tokens are random, and of one length.
        Err(_) if panel.security.accounts.is_some() => panel.by_password(user, secret),
        by_token => by_token,
    };
    panel.audit.note(user, 0, &json!("teleop sign-in"), role.as_ref().map(|_| ()));
    role
}

/// Adds a user to the clients of the panel.
pub(super) fn enter(panel: &Panel, user: &str, role: Role) -> User {
    let session = Session { cookie: String::new(), user: user.to_owned(), role };
    let client = panel.clients.enter(&session);
    panel.count_clients();
    User { session, client }
}
