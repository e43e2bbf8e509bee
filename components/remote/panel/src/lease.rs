//! The control lease: which client may command the machine.

use crate::{
    engine::Engine,
    error::{Code, Error},
    session::{Role, Session},
};
use hal_protocol::{Reply, Request};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    sync::{Mutex, PoisonError},
    time::Duration,
};
use tokio::{sync::watch, time::Instant};

/// Time without an answer to a pulse after which an operator may take the lease from another.
const SILENCE: Duration = Duration::from_secs(5);

/// Age in milliseconds that a lease has when the servo thread has seen it for certain.
const SEEN_MS: u32 = 20;

/// Holder of the lease.
#[derive(Clone, Debug)]
pub(crate) struct Holder {
    pub(crate) client: u64,
    pub(crate) user: String,
    /// Number that the plugin `remote` gave.
    pub(crate) number: u64,
    answered: Instant,
    /// Pulse of the servo thread after the lease began, if the engine said it.
    begun: Option<u32>,
}

/// Report of the servo thread on the lease: the number that it sees, and a pulse that it had made by then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beating {
    pub(crate) lease: u32,
    pub(crate) pulse: u32,
}

/// A client: a page, another program at the socket, or a user of teleoperation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Client {
    pub(crate) client: u64,
    pub(crate) user: String,
    pub(crate) role: Role,
    /// False for a user of teleoperation, who has no page: the lease is theirs for a job alone.
    #[serde(skip)]
    pub(crate) has_page: bool,
}

#[derive(Debug, Default)]
struct Table {
    clients: BTreeMap<u64, Client>,
    last: u64,
    holder: Option<Holder>,
}

/// All clients of the socket, and the lease.
#[derive(Debug)]
pub(crate) struct Clients {
    table: Mutex<Table>,
    /// Kept while the engine is asked about the lease: one question after the other.
    asking: tokio::sync::Mutex<()>,
    changed: watch::Sender<u64>,
}

impl Default for Clients {
    fn default() -> Self {
        Self {
            table: Mutex::default(),
            asking: tokio::sync::Mutex::default(),
            changed: watch::Sender::new(0),
        }
    }
}

impl Clients {
    fn with<T>(&self, f: impl FnOnce(&mut Table) -> T) -> T {
        f(&mut self.table.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn tell(&self) {
        self.changed.send_modify(|n| *n += 1);
    }

    /// Adds a client of the socket and returns its number.
    pub(crate) fn enter(&self, session: &Session) -> u64 {
        self.add(session, true)
    }

    /// Adds a user of teleoperation and returns their number.
    pub(crate) fn enter_without_page(&self, session: &Session) -> u64 {
        self.add(session, false)
    }

    fn add(&self, session: &Session, has_page: bool) -> u64 {
        let (user, role) = (session.user.clone(), session.role);
        let client = self.with(|table| {
            table.last += 1;
            let client = Client { client: table.last, user, role, has_page };
            table.clients.insert(table.last, client);
            table.last
        });
        self.tell();
        client
    }

    /// Removes a client, and gives back its lease.
    pub(crate) async fn leave(&self, engine: &Engine, client: u64) {
        self.with(|table| table.clients.remove(&client));
        // An engine that does not answer has no lease either.
        drop(self.give(engine, client).await);
        self.tell();
    }

    /// Notes the role that a client has now; who may not command the machine any more gives the lease back.
    pub(crate) async fn change_role(&self, engine: &Engine, client: u64, role: Role) {
        self.with(|table| {
            if let Some(of) = table.clients.get_mut(&client) {
                of.role = role;
            }
        });
        if role < Role::Operator {
            // An engine that does not answer has no lease either.
            drop(self.give(engine, client).await);
        }
        self.tell();
    }

    /// Returns what all clients see, and a number that changes with it.
    pub(crate) fn view(&self) -> (Vec<Client>, Option<Holder>) {
        self.with(|table| (table.clients.values().cloned().collect(), table.holder.clone()))
    }

    /// Returns the number of clients.
    pub(crate) fn count(&self) -> usize {
        self.with(|table| table.clients.len())
    }

    /// Returns the number of the lease, if this client holds it.
    pub(crate) fn number(&self, client: u64) -> Option<u64> {
        self.with(|table| table.holder.as_ref().filter(|h| h.client == client).map(|h| h.number))
    }

    /// Notes that the holder has answered a pulse, or is there for a teleoperated job; returns false for everybody else.
    pub(crate) fn answered(&self, client: u64) -> bool {
        self.with(|table| match &mut table.holder {
            Some(holder) if holder.client == client => {
                holder.answered = Instant::now();
                true
            }
            _ => false,
        })
    }

    /// Notes that the plugin has ended the lease.
    pub(crate) fn lost(&self, number: u64) {
        if self.with(|table| table.holder.take_if(|h| h.number == number).is_some()) {
            self.tell();
        }
    }

    /// Notes that the servo thread has ended the lease of this client: one that it had `confirmed`, or that it should have seen
    /// by now. This program may have stood still since the lease began.
    pub(crate) fn check(&self, client: u64, now: Beating, confirmed: &mut Option<u64>) {
        let held = self.with(|table| table.holder.clone()).filter(|h| h.client == client);
        let Some(held) = held else { return *confirmed = None };
        let is_old =
            |begun: u32| now.pulse.wrapping_sub(begun).cast_signed() > SEEN_MS.cast_signed();
        if held.number == u64::from(now.lease) {
            *confirmed = Some(held.number);
        } else if *confirmed == Some(held.number) || held.begun.is_some_and(is_old) {
            *confirmed = None;
            self.lost(held.number);
        }
    }

    /// Takes the lease for a client; `force` takes it from another.
    pub(crate) async fn take(
        &self,
        engine: &Engine,
        client: u64,
        session: &Session,
        force: bool,
    ) -> Result<(), Error> {
        if session.role < Role::Operator {
            return Err(Error::new(Code::Role, "a viewer cannot take the lease"));
        }
        let asking = self.asking.lock().await;
        if let Some(holder) = self.with(|table| table.holder.clone()) {
            if holder.client == client {
                return Ok(());
            }
            let silent = holder.answered.elapsed() > SILENCE;
            if !force || !(silent || session.role == Role::Integrator) {
                let text = format!("{} has the control lease", holder.user);
                return Err(Error::new(Code::Conflict, text));
            }
            self.end(engine, holder.number).await?;
        }
        let taken = self.begin(engine, client, &session.user).await;
        drop(asking);
        taken
    }

    /// Gives the lease back, if this client holds it.
    pub(crate) async fn give(&self, engine: &Engine, client: u64) -> Result<(), Error> {
        let asking = self.asking.lock().await;
        let given = match self.number(client) {
            Some(number) => self.end(engine, number).await,
            None => Ok(()),
        };
        drop(asking);
        given
    }

    /// Hands the lease to another client.
    pub(crate) async fn hand(&self, engine: &Engine, client: u64, to: u64) -> Result<(), Error> {
        let asking = self.asking.lock().await;
        let number = self.number(client).ok_or_else(no_lease)?;
        let to = self.with(|table| table.clients.get(&to).cloned());
        let to = to.filter(|to| to.role >= Role::Operator);
        let to = to.ok_or_else(|| Error::new(Code::NotFound, "there is no such operator"))?;
        if !to.has_page {
            let text =
                format!("{} has no page: a user of teleoperation has the lease for a job", to.user);
            return Err(Error::new(Code::Conflict, text));
        }
        self.end(engine, number).await?;
        let taken = self.begin(engine, to.client, &to.user).await;
        drop(asking);
        taken
    }

    async fn begin(&self, engine: &Engine, client: u64, user: &str) -> Result<(), Error> {
        let args = vec![format!("holder={user}")];
        let reply = engine.call(Request::Command { name: "remote.take".to_owned(), args }).await?;
        let Reply::Answer(answer) = reply else {
            return Err(Error::new(Code::Refused, "the engine gave no lease"));
        };
        let number = answer.lines.iter().find_map(|line| line.strip_prefix("lease=")?.parse().ok());
        let number = number.ok_or_else(|| Error::new(Code::Refused, "the engine gave no lease"))?;
        let args = vec![format!("lease={number}")];
        let beat = engine.call(Request::Command { name: "remote.beat".to_owned(), args }).await;
        let begun = match beat {
            Ok(Reply::Answer(answer)) => answer.lines.iter().find_map(|line| {
                line.split(' ').find_map(|word| word.strip_prefix("pulse=")?.parse().ok())
            }),
            _ => None,
        };
        let user = user.to_owned();
        let holder = Holder { client, user, number, answered: Instant::now(), begun };
        let there = self.with(|table| {
            let there = table.clients.contains_key(&client);
            if there {
                table.holder = Some(holder);
            }
            there
        });
        if !there {
            // The client has left meanwhile.
            return self.end(engine, number).await;
        }
        self.tell();
        Ok(())
    }

    async fn end(&self, engine: &Engine, number: u64) -> Result<(), Error> {
        self.lost(number);
        let args = vec![format!("lease={number}")];
        let given = engine.call(Request::Command { name: "remote.give".to_owned(), args }).await;
        given.map(drop)
    }
}

/// Returns the refusal of a command without the lease.
pub(crate) fn no_lease() -> Error {
    Error::new(Code::Lease, "this needs the control lease: take it first")
}

#[cfg(test)]
pub(crate) mod tests;
