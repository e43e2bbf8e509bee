//! Sessions: who has signed in, with which role, and until when.

use crate::error::{Code, Error};
use axum::http::{HeaderMap, header};
use clap::ValueEnum;
use serde::Serialize;
use std::{
    collections::BTreeMap,
    sync::{Mutex, MutexGuard, PoisonError},
    time::Duration,
};
use tokio::time::Instant;

/// Longest life of a session.
const LIFE: Duration = Duration::from_hours(12);
/// Longest time without a request or message.
const IDLE: Duration = Duration::from_mins(30);
/// Number of sessions; the one that was idle longest ends for a new one.
const MAX_SESSIONS: usize = 256;
/// Time within which an attempt to sign in can be repeated.
const REPEAT: Duration = Duration::from_mins(1);
/// Header with the key of a session.
const KEY: &str = "x-ferrule-key";

/// Rights of a person, each with those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Sees everything, and aborts.
    Viewer,
    /// Works with the machine.
    Operator,
    /// Changes the machine's wiring and values.
    Integrator,
}

/// A person who has signed in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Session {
    /// Secret of the cookie.
    pub(crate) cookie: String,
    pub(crate) user: String,
    pub(crate) role: Role,
}

impl Session {
    /// Refuses what needs a higher role.
    pub(crate) fn needs(&self, role: Role) -> Result<(), Error> {
        if self.role >= role {
            return Ok(());
        }
        let text = format!("this needs the role {role:?}, and the session has {:?}", self.role);
        Err(Error::new(Code::Role, text.to_lowercase()))
    }
}

#[derive(Debug)]
struct Entry {
    session: Session,
    key: String,
    begun: Instant,
    used: Instant,
}

impl Entry {
    fn is_over(&self, now: Instant) -> bool {
        now - self.begun > LIFE || now - self.used > IDLE
    }
}

/// All sessions, and the one-time token.
#[derive(Debug, Default)]
pub(crate) struct Sessions {
    list: Mutex<BTreeMap<String, Entry>>,
    token: Mutex<Option<String>>,
    taken: Mutex<Option<Taken>>,
}

/// The one-time token that was taken last.
#[derive(Debug)]
struct Taken {
    token: String,
    attempt: String,
    at: Instant,
}

impl Sessions {
    fn list(&self) -> MutexGuard<'_, BTreeMap<String, Entry>> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the one-time token.
    pub(crate) fn set_token(&self, token: String) {
        *self.token.lock().unwrap_or_else(PoisonError::into_inner) = Some(token);
    }

    /// Takes the one-time token, if this is it.
    pub(crate) fn take_token(&self, given: &str) -> bool {
        let mut token = self.token.lock().unwrap_or_else(PoisonError::into_inner);
        token.take_if(|token| is_equal(token, given)).is_some()
    }

    /// Notes the attempt that has taken a token, if it can be repeated.
    pub(crate) fn note_taken(&self, token: &str, attempt: Option<&str>) {
        let note = |attempt: &str| Taken {
            token: token.to_owned(),
            attempt: attempt.to_owned(),
            at: Instant::now(),
        };
        *self.taken.lock().unwrap_or_else(PoisonError::into_inner) = attempt.map(note);
    }

    /// Returns whether this attempt has just taken this token: its answer was lost on the way.
    pub(crate) fn is_repeated(&self, given: &str, attempt: Option<&str>) -> bool {
        let taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let (Some(taken), Some(attempt)) = (&*taken, attempt) else { return false };
        let is_same = is_equal(&taken.token, given) & is_equal(&taken.attempt, attempt);
        is_same && taken.at.elapsed() <= REPEAT
    }

    /// Begins a session; returns it with its key.
    pub(crate) fn begin(&self, user: &str, role: Role) -> Result<(Session, String), String> {
        let (cookie, key, now) = (secret()?, secret()?, Instant::now());
        let session = Session { cookie: cookie.clone(), user: user.to_owned(), role };
        let mut list = self.list();
        list.retain(|_, entry| !entry.is_over(now));
        if list.len() >= MAX_SESSIONS {
            let oldest = list.iter().min_by_key(|(_, entry)| entry.used);
            let oldest = oldest.map(|(cookie, _)| cookie.clone());
            oldest.and_then(|cookie| list.remove(&cookie));
        }
        let entry = Entry { session: session.clone(), key: key.clone(), begun: now, used: now };
        list.insert(cookie, entry);
        Ok((session, key))
    }

    /// Returns the session of a cookie and key, and counts it as used.
    pub(crate) fn find(&self, cookie: &str, key: &str) -> Option<Session> {
        let now = Instant::now();
        let mut list = self.list();
        let entry = list.get_mut(cookie)?;
        if entry.is_over(now) {
            list.remove(cookie);
            return None;
        }
        if !is_equal(&entry.key, key) {
            return None;
        }
        entry.used = now;
        Some(entry.session.clone())
    }

    /// Returns the session of a request.
    pub(crate) fn of(&self, headers: &HeaderMap, port: u16) -> Result<Session, Error> {
        let key = headers.get(KEY).and_then(|key| key.to_str().ok()).unwrap_or_default();
        self.find(&cookie(headers, port), key)
            .ok_or_else(|| Error::new(Code::NoSession, "sign in first: there is no such session"))
    }

    /// Returns whether a session has not ended; does not count it as used.
    pub(crate) fn lives(&self, session: &Session) -> bool {
        let now = Instant::now();
        self.list().get(&session.cookie).is_some_and(|entry| !entry.is_over(now))
    }

    /// Ends a session.
    pub(crate) fn end(&self, session: &Session) {
        self.list().remove(&session.cookie);
    }
}

/// Returns the name of the cookie: one for each port, because browsers send cookies to all ports of a host.
pub(crate) fn cookie_name(port: u16) -> String {
    format!("ferrule-{port}")
}

/// Returns the value of the session's cookie, or nothing.
pub(crate) fn cookie(headers: &HeaderMap, port: u16) -> String {
    let name = cookie_name(port);
    let all = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    let pairs = all.flat_map(|value| value.split(';')).filter_map(|pair| pair.split_once('='));
    let mut found =
        pairs.filter(|(n, _)| n.trim() == name).map(|(_, value)| value.trim().to_owned());
    found.next().unwrap_or_default()
}

/// Returns 32 random bytes as text.
pub(crate) fn secret() -> Result<String, String> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes).map_err(|e| format!("the system has no random numbers: {e}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Compares two secrets in a time that does not depend on where they differ.
fn is_equal(a: &str, b: &str) -> bool {
    let pairs = a.bytes().zip(b.bytes());
    a.len() == b.len() && pairs.fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}
