//! The machine of a session: snapshots, commands and control.

use crate::{connection::Input, control::Control};
use hal_protocol::{Client, Link as _, Place, Reply, Request, Snapshot, TicketInfo};
use rsh::{Facts, Jog, Machine, Passwords, Record, Snapshots};
use std::{
    sync::Arc,
    time::{Duration, SystemTime},
};

/// Time within which lines that were sent at once arrive.
const AT_ONCE: Duration = Duration::from_millis(100);

/// Data that all sessions share.
#[derive(Debug)]
pub(crate) struct Served {
    pub(crate) place: Place,
    pub(crate) facts: Facts,
    pub(crate) passwords: Passwords,
    pub(crate) control: Arc<Control>,
}

/// The machine of one session.
pub(crate) struct Engine {
    client: Client,
    motion: Snapshot,
    task: Snapshot,
    state: Snapshots,
    control: Arc<Control>,
    session: u64,
    pub(crate) input: Input,
}

impl Engine {
    pub(crate) fn new(source: &Served, session: u64, input: Input) -> Result<Self, String> {
        let mut client = Client::connect(&source.place, "").map_err(|e| e.to_string())?;
        let mut snapshot = |name: &str| client.snapshot(name).map_err(|e| e.to_string());
        let (motion, task) = (snapshot("motion.status")?, snapshot("task.status")?);
        let state = Snapshots {
            motion: Record::new(motion.info()),
            task: Record::new(task.info()),
            facts: source.facts.clone(),
        };
        let control = source.control.clone();
        Ok(Self { client, motion, task, state, control, session, input })
    }
}

impl Machine for Engine {
    fn poll(&mut self) {
        // A record that its component does not end is read the next time.
        self.motion.wait(self.state.motion.values_mut());
        self.task.wait(self.state.task.values_mut());
    }

    fn state(&self) -> &Snapshots {
        &self.state
    }

    fn command(&mut self, name: &str, args: Vec<String>) -> Result<Option<u64>, String> {
        match self.client.call(Request::Command { name: name.to_owned(), args }) {
            Ok(Reply::Answer(answer)) => Ok(answer.ticket),
            Ok(_) => Ok(None),
            Err(why) => Err(why.text),
        }
    }

    fn jog(&mut self, jog: Jog) -> Result<(), String> {
        let mut args = vec![jog.target.arg(), format!("velocity={}", jog.velocity)];
        args.extend(jog.distance.map(|distance| format!("distance={distance}")));
        self.control.jog(self.session, args)
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "the client has stated a time of its own, whatever the engine's clock shows"
    )]
    fn wait(&mut self, ticket: u64, most: Option<Duration>) -> Result<(), String> {
        let begun = std::time::Instant::now();
        loop {
            let reply = self.client.call(Request::Ticket { id: ticket, wait: false });
            match reply.map_err(|e| e.text)? {
                Reply::Ticket(TicketInfo::Pending) => {}
                Reply::Ticket(TicketInfo::Failed(why)) => return Err(why),
                _ => return Ok(()),
            }
            if most.is_some_and(|most| begun.elapsed() >= most) {
                return Err("the command takes longer than set timeout says".to_owned());
            }
            self.input.look(begun.elapsed() >= AT_ONCE)?;
        }
    }

    fn take(&mut self) -> Result<(), String> {
        self.control.take(self.session)
    }

    fn give(&mut self) {
        self.control.give(self.session);
    }

    fn has_control(&self) -> bool {
        self.control.has(self.session)
    }

    fn shut_down(&mut self) -> Result<(), String> {
        self.client.call(Request::Shutdown).map(drop).map_err(|e| e.text)
    }

    fn time(&self) -> f64 {
        SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default().as_secs_f64()
    }
}
