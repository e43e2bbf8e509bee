//! Refusals of commands that a script does not wait for: they come later, and are reported with the line of the command.

use crate::{
    Error, Session,
    session::{open_command::OpenCommand, prompt::was_said},
};
use hal_protocol::{At, Reply, Request, TicketInfo};

/// Largest number of commands whose ends are awaited.
const MAX_OPEN: usize = 256;

/// Reason for which commands end that an abort, by a person or a script, has ended. It is no refusal.
const ABORTED: &str = "aborted";

/// Number of times that a client asks whether the machine has refused a command.
const EARLY_LOOKS: u32 = 10;
/// Time between these questions in milliseconds.
const EARLY_MS: u32 = 2;

impl Session<'_> {
    /// Returns the failure of a command that the machine refuses within its first cycles. A script does not wait for
    /// it: the refusal is reported when it comes.
    pub(super) fn early_refusal(&mut self, name: &str, id: u64) -> Result<(), Error> {
        if self.link.is_local() {
            self.report_later(name, id);
            return Ok(());
        }
        for _ in 0..EARLY_LOOKS {
            self.ask(Request::Idle { ms: EARLY_MS, flow: false })?;
            match self.ask(Request::Ticket { id, wait: false })? {
                Reply::Ticket(TicketInfo::Failed(why)) => {
                    return Err(Error::GivenUp { command: name.into(), why: why.into() });
                }
                Reply::Ticket(TicketInfo::Pending) => {}
                _ => return Ok(()),
            }
        }
        self.report_later(name, id);
        Ok(())
    }

    /// Keeps a command of the present line whose refusal is reported once it comes.
    pub(crate) fn report_later(&mut self, name: &str, ticket: u64) {
        if self.open_commands.len() < MAX_OPEN {
            let (file, line) = self.place();
            let at = At::new(file, line);
            self.open_commands.push(OpenCommand { ticket, name: name.to_owned(), at });
        }
    }

    /// Reports the commands that were refused since the last look, unless the log has the reason.
    pub(crate) fn tell_late_refusals(&mut self) {
        if self.open_commands.is_empty() || self.link.is_ending() {
            return;
        }
        let mut open = core::mem::take(&mut self.open_commands);
        open.retain(|command| {
            match self.call(Request::Ticket { id: command.ticket, wait: false }) {
                Ok(Reply::Ticket(TicketInfo::Pending)) => true,
                Ok(Reply::Ticket(TicketInfo::Failed(why))) => {
                    if why != ABORTED && !was_said(&why) {
                        let (command_name, why) = (command.name.as_str().into(), why.into());
                        self.refuse(&command.at, &Error::GivenUp { command: command_name, why });
                    }
                    false
                }
                _ => false,
            }
        });
        self.open_commands = open;
    }
}
