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

/// Longest life of a session, unless it keeps a job.
const LIFE: Duration = Duration::from_hours(12);
/// Longest time without input: then a session only looks, until its person signs in again.
const IDLE: Duration = Duration::from_mins(30);
/// Number of sessions; the one that was idle longest ends for a new one.
const MAX_SESSIONS: usize = 256;
/// Time within which an attempt to sign in can be repeated.
const REPEAT: Duration = Duration::from_mins(1);
/// Name of who opened the address with the one-time token.
pub(crate) const LOCAL: &str = "local";
/// Header with the key of a session.
pub(crate) const KEY: &str = "x-ferrule-key";

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
    /// Returns the name under which it has seats in the pool: all sessions of an account are one person, and sessions that
    /// a token has opened are one each.
    pub(crate) fn seated(&self) -> &str {
        if self.user == LOCAL { &self.cookie } else { &self.user }
    }

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
    /// Time of the last input, or of the last moment at which it kept a job.
    used: Instant,
    /// Time of the last moment at which it kept a job.
    kept: Option<Instant>,
}

impl Entry {
    fn is_over(&self, now: Instant) -> bool {
        now - self.begun > LIFE && self.kept.is_none_or(|kept| now - kept > IDLE)
    }

    /// Returns the role that it has now: after a time without input it only looks.
    fn role(&self, now: Instant) -> Role {
        if now - self.used > IDLE { Role::Viewer } else { self.session.role }
    }

    /// Notes input. What comes too late brings no rights back.
    fn note_input(&mut self, now: Instant) {
        if self.role(now) == self.session.role {
            self.used = now;
        }
    }

    fn session(&self, now: Instant) -> Session {
        Session { role: self.role(now), ..self.session.clone() }
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
        let entry =
            Entry { session: session.clone(), key: key.clone(), begun: now, used: now, kept: None };
        list.insert(cookie, entry);
        Ok((session, key))
    }

    /// Returns the session of a cookie and key, with the role that it has now.
    pub(crate) fn find(&self, cookie: &str, key: &str) -> Option<Session> {
        let now = Instant::now();
        let mut list = self.list();
        let entry = list.get_mut(cookie)?;
        if entry.is_over(now) {
            list.remove(cookie);
            return None;
        }
        is_equal(&entry.key, key).then(|| entry.session(now))
    }

    /// Returns the session of a request. One that changes something counts as input.
    pub(crate) fn of(
        &self,
        headers: &HeaderMap,
        port: u16,
        is_input: bool,
    ) -> Result<Session, Error> {
        let key = headers.get(KEY).and_then(|key| key.to_str().ok()).unwrap_or_default();
        let found = self.find(&cookie(headers, &cookie_name(port)), key);
        if let Some(session) = found.as_ref().filter(|_| is_input) {
            self.note_input(session);
        }
        found.ok_or_else(|| Error::new(Code::NoSession, "sign in first: there is no such session"))
    }

    /// Notes input of a session.
    pub(crate) fn note_input(&self, session: &Session) {
        if let Some(entry) = self.list().get_mut(&session.cookie) {
            entry.note_input(Instant::now());
        }
    }

    /// Notes that a session keeps a job: its page answers pulses under the lease while the job runs.
    pub(crate) fn keep(&self, session: &Session) {
        let now = Instant::now();
        if let Some(entry) = self.list().get_mut(&session.cookie) {
            entry.note_input(now);
            entry.kept = Some(now);
        }
    }

    /// Returns the role that a session has now; `None` if it has ended.
    pub(crate) fn role(&self, session: &Session) -> Option<Role> {
        let now = Instant::now();
        let list = self.list();
        list.get(&session.cookie).filter(|entry| !entry.is_over(now)).map(|entry| entry.role(now))
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

/// Returns the name of the cookie with the devices of accounts that this browser is.
pub(crate) fn device_name(port: u16) -> String {
    format!("ferrule-device-{port}")
}

/// Returns the value of a cookie, or nothing.
pub(crate) fn cookie(headers: &HeaderMap, name: &str) -> String {
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

#[cfg(test)]
mod tests;
