//! Owner of motion, and the commands that have not ended or have ended lately.

use super::MotionEnd;
use crate::abi::{Ticket, TicketState};

/// Number of commands whose progress is known.
const SLOTS: u64 = 4096;

/// State of the service, used by one caller at a time.
pub(super) struct CommandTickets {
    owner: Option<(u64, String)>,
    last_token: u64,
    last_id: u64,
    /// Numbers of the commands. The command with the number `n` is at the place `n % SLOTS`.
    ids: Vec<Option<u64>>,
    /// Tickets of the commands. None is freed before the commands, because a provider may keep a handle.
    tickets: Box<[Ticket]>,
}

impl Default for CommandTickets {
    fn default() -> Self {
        let (ids, tickets) = (0..SLOTS).map(|_| (None, Ticket::new())).unzip::<_, _, _, Vec<_>>();
        Self { owner: None, last_token: 0, last_id: 0, ids, tickets: tickets.into() }
    }
}

impl CommandTickets {
    /// Returns the token of a new owner.
    pub(super) fn acquire(&mut self, name: &str) -> Result<u64, String> {
        if let Some((_, owner)) = self.owner.as_ref().filter(|(_, owner)| owner != name) {
            return Err(format!("motion belongs to {owner}"));
        }
        self.last_token = self.last_token.wrapping_add(1).max(1);
        self.owner = Some((self.last_token, name.to_owned()));
        Ok(self.last_token)
    }

    /// Ends the ownership. Returns false if the token is void.
    pub(super) fn release(&mut self, token: u64) -> bool {
        let owns = self.owns(token);
        if owns {
            self.owner = None;
        }
        owns
    }

    pub(super) fn owns(&self, token: u64) -> bool {
        self.owner.as_ref().is_some_and(|(owner, _)| *owner == token)
    }

    /// Returns the number and the ticket of a new command. Returns `None` if all places belong to
    /// commands that have not ended.
    pub(super) fn open(&mut self) -> Option<(u64, *const Ticket)> {
        for id in (1..=SLOTS).map(|n| self.last_id.wrapping_add(n)) {
            let (at, ticket) = (self.ids.get_mut(place(id))?, self.tickets.get(place(id))?);
            if at.is_none() || ticket.state() != TicketState::Pending {
                ticket.reopen();
                (*at, self.last_id) = (Some(id), id);
                return Some((id, &raw const *ticket));
            }
        }
        None
    }

    pub(super) fn end_of(&self, id: u64) -> MotionEnd {
        let known = self.ids.get(place(id)) == Some(&Some(id));
        let Some(ticket) = self.tickets.get(place(id)).filter(|_| known) else {
            return MotionEnd::Forgotten;
        };
        match ticket.state() {
            TicketState::Pending => MotionEnd::Pending,
            TicketState::Done => MotionEnd::Done,
            TicketState::Failed(why) => {
                let (numbers, count) = ticket.numbers();
                let filled = |s: String, x: &f64| s.replacen("{}", &x.to_string(), 1);
                let text = numbers.iter().take(count).fold(why.to_owned(), filled);
                // Braces mark names of pins.
                MotionEnd::Failed(text.replace(['{', '}'], ""))
            }
        }
    }
}

fn place(id: u64) -> usize {
    usize::try_from(id % SLOTS).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::{CommandTickets, MotionEnd, SLOTS};

    fn ticket(commands: &mut CommandTickets) -> (u64, &'static super::Ticket) {
        let (id, ticket) = commands.open().unwrap();
        // SAFETY: the commands outlives every test's use of it.
        (id, unsafe { &*ticket })
    }

    #[test]
    fn one_owner_holds_the_token() {
        let mut commands = CommandTickets::default();
        assert!(!commands.owns(0) && !commands.owns(1) && !commands.release(1));
        let first = commands.acquire("task").unwrap();
        assert_eq!(commands.acquire("other").unwrap_err(), "motion belongs to task");
        let again = commands.acquire("task").unwrap();
        assert!(
            again != first && commands.owns(again) && !commands.owns(first) && !commands.owns(0)
        );
        assert!(!commands.release(first) && commands.owns(again));
        assert!(commands.release(again) && !commands.owns(again));
        assert!(commands.acquire("other").is_ok());
    }

    #[test]
    fn ends_are_known_until_the_place_is_needed() {
        let mut commands = CommandTickets::default();
        assert_eq!(commands.end_of(0), MotionEnd::Forgotten);
        let (first, held) = ticket(&mut commands);
        let (second, done) = ticket(&mut commands);
        assert_eq!(
            (commands.end_of(first), commands.end_of(second)),
            (MotionEnd::Pending, MotionEnd::Pending)
        );
        done.fail_with("no {} in {pin} at {}", &[1.5, 2.0]);
        assert_eq!(commands.end_of(second), MotionEnd::Failed("no 1.5 in pin at 2".to_owned()));
        let mut others = Vec::new();
        for _ in 2..SLOTS {
            others.push(ticket(&mut commands).1);
        }
        // The place of the second is free, that of the first is not.
        let (next, ticket_of_next) = ticket(&mut commands);
        assert_eq!((next, commands.end_of(second)), (SLOTS + 2, MotionEnd::Forgotten));
        assert!(commands.open().is_none(), "all commands are in progress");
        ticket_of_next.done();
        held.done();
        assert_eq!(
            (commands.end_of(next), commands.end_of(first)),
            (MotionEnd::Done, MotionEnd::Done)
        );
        assert!(commands.open().is_some());
        others.iter().for_each(|t| t.done());
    }
}
