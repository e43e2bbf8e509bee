//! Logins of the protocol: with the panel's one-time token, or with a password.

use super::job::User;
use crate::{
    error::Error,
    limits::SignInPlace,
    server::Panel,
    session::{Role, Session},
};

/// Checks a login; returns its role. The token is for people on this computer, and under a name that is no account's.
pub(super) fn role(
    panel: &Panel,
    user: &str,
    secret: &str,
    source: &SignInPlace,
    is_network: bool,
) -> Result<Role, Error> {
    let accounts = panel.security.accounts.as_ref();
    let takes_token = !is_network && !accounts.is_some_and(|accounts| accounts.has(user));
    let (name, role) = match takes_token.then(|| panel.by_token(secret, None)) {
        Some(Ok(role)) => (format!("local ({user})"), Ok(role)),
        Some(Err(why)) if accounts.is_none() => (user.to_owned(), Err(why)),
        // A password cannot be a token: tokens are random, and of one length.
        Some(Err(_)) | None => (user.to_owned(), panel.by_password(user, secret, source)),
    };
    panel.audit.note_login(&name, "teleop sign-in", role.as_ref().map(|_| ()));
    role
}

/// Adds a user to the clients of the panel.
pub(super) fn enter(panel: &Panel, user: &str, role: Role) -> User {
    let session = Session { cookie: String::new(), user: user.to_owned(), role };
    let client = panel.clients.enter_without_page(&session);
    panel.count_clients();
    User { session, client }
}

#[cfg(test)]
mod tests {
    //! Uses of the token.

    use super::role;
    use crate::{engine::Engine, limits::SignInPlace, server::Panel, session::Role};
    use hal_protocol::Reply;

    #[test]
    fn the_token_is_for_this_computer_and_for_no_name_of_an_account() {
        let panel = Panel::that(Engine::that(|_| Ok(Reply::Done)), "sign-in");
        let folder = panel.place.folder().to_owned();
        let login = |user: &str, secret: &str, is_network| {
            panel.sessions.set_token("token".to_owned());
            role(&panel, user, secret, &SignInPlace::User(1), is_network).map_err(|why| why.text)
        };
        let wrong = || Err("the user or the password is wrong".to_owned());
        for (user, secret, is_network, right) in [
            ("pedro", "token", false, Ok(Role::Integrator)),
            ("pedro", "token", true, wrong()),
            ("ana", "token", false, wrong()),
            ("ana", "token", true, wrong()),
            ("ana", "correct horse", true, Ok(Role::Operator)),
            ("ana", "correct horse", false, Ok(Role::Operator)),
            ("pedro", "correct horse", false, wrong()),
        ] {
            assert_eq!(login(user, secret, is_network), right, "{user} {secret} {is_network}");
        }
        let audit = std::fs::read_to_string(folder.join("audit")).unwrap();
        assert_eq!(audit.matches("\"user\":\"local (pedro)\"").count(), 1, "{audit}");
        assert_eq!(audit.matches("\"end\":\"ok\"").count(), 3, "{audit}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
