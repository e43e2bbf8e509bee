//! Connections that come, and those that end because nobody speaks.

use crate::{
    answer::{Answer, Reason},
    server::Server,
    session::Session,
    words::Code,
};
use std::{cmp::Reverse, collections::BTreeMap, net::IpAddr};

/// Longest time from the connection to the login, in milliseconds.
pub const LOGIN_MS: u64 = 60_000;
/// Longest silence of a user without a job, in milliseconds: that of the panel's sessions.
pub const IDLE_MS: u64 = 30 * 60_000;
/// Number of connections that have not logged in yet: of all computers together, and of one.
const MAX_STRANGERS: usize = 16;
const MAX_STRANGERS_OF_ONE: usize = 4;
/// Number of all connections, with those that are being closed.
const MAX_CONNECTIONS: usize = 256;

impl Server {
    /// Adds a connection of a computer; `None` if there are too many. Of those that have not logged in, the oldest may
    /// end for it: of the same computer, or else of the one with the most.
    pub fn connect(&mut self, peer: IpAddr, now: u64) -> Option<u64> {
        if self.stops || self.sessions.len() >= MAX_CONNECTIONS {
            return None;
        }
        let mut strangers = BTreeMap::<IpAddr, Vec<u64>>::new();
        for (id, session) in self.sessions.iter().filter(|(_, s)| s.user.is_none() && !s.closes) {
            strangers.entry(session.peer).or_default().push(*id);
        }
        let all = strangers.values().map(Vec::len).sum::<usize>();
        let full = |ids: &&Vec<u64>| ids.len() >= MAX_STRANGERS_OF_ONE;
        let most = || strangers.values().max_by_key(|ids| (ids.len(), Reverse(ids.first())));
        let crowd = strangers.get(&peer).filter(full);
        if let Some(ids) = crowd.or_else(|| most().filter(|_| all >= MAX_STRANGERS)) {
            // A login that is being checked is about to end by itself.
            let idle = |id: &&u64| self.sessions.get(*id).is_some_and(|s| s.wait.is_none());
            let oldest = *ids.iter().find(idle)?;
            let text = "too many connections that have not logged in";
            self.deny(oldest, Reason::new(Code::Ocupado, text));
        }
        self.last += 1;
        self.sessions.insert(self.last, Session::new(peer, now));
        Some(self.last)
    }

    /// Ends connections that do not log in, and users without a job who say nothing.
    pub(crate) fn end_idle(&mut self, now: u64) {
        let owner = self.job.and_then(|job| job.owner);
        let late = |s: &Session| s.user.is_none() && now >= s.since + LOGIN_MS;
        let idle = |s: &Session| s.user.is_some() && now >= s.heard + IDLE_MS;
        let text = |s: &Session| match s {
            _ if late(s) => Some("nobody has logged in for a minute"),
            _ if idle(s) => Some("you have said nothing for 30 minutes"),
            _ => None,
        };
        let open = self.sessions.iter().filter(|(id, s)| !s.closes && owner != Some(**id));
        let over: Vec<_> = open.filter_map(|(id, s)| Some((*id, text(s)?))).collect();
        for (id, text) in over {
            self.tell(Some(id), &Answer::Error(Reason::new(Code::Orden, text)));
            self.close(id);
        }
    }
}
