//! The machine of a session: snapshots, commands and control.

use crate::{connection::Input, control::Control};
use hal_protocol::{
    Client, Failure, Kind, Link as _, Orders, Place, Reply, Request, Snapshot, Stop, TicketInfo,
};
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
    /// The record of the task, where there is one.
    task: Option<Snapshot>,
    /// Commands of the machine.
    orders: Orders,
    /// Stop epoch in which the line in execution has arrived.
    pub(crate) given: Option<u64>,
    state: Snapshots,
    control: Arc<Control>,
    session: u64,
    pub(crate) input: Input,
}

impl Engine {
    pub(crate) fn new(source: &Served, session: u64, input: Input) -> Result<Self, String> {
        let mut client = Client::connect_from_afar(&source.place).map_err(|e| e.to_string())?;
        let orders = hal_lease::orders(&mut client)?;
        let motion = client.snapshot("motion.status").map_err(|e| e.to_string())?;
        let task = client.snapshot("task.status").ok();
        let state = Snapshots {
            motion: Record::new(motion.info()),
            task: task.as_ref().map(|task| Record::new(task.info())).unwrap_or_default(),
            facts: source.facts.clone(),
        };
        let control = source.control.clone();
        Ok(Self { client, motion, task, orders, given: None, state, control, session, input })
    }

    fn ask(&mut self, request: Request) -> Result<Option<u64>, Failure> {
        match self.client.call(request)? {
            Reply::Answer(answer) => Ok(answer.ticket),
            _ => Ok(None),
        }
    }

    /// Finds the commands of a machine that has changed.
    fn renew(&mut self) -> Result<(), String> {
        self.orders = hal_lease::orders(&mut self.client)?;
        Ok(())
    }
}

impl Machine for Engine {
    fn poll(&mut self) {
        // A record that its component does not end is read the next time.
        self.motion.wait(self.state.motion.values_mut());
        match &self.task {
            Some(task) => drop(task.wait(self.state.task.values_mut())),
            None => self.state.fill_task(),
        }
    }

    fn state(&self) -> &Snapshots {
        &self.state
    }

    fn command(&mut self, name: &str, args: Vec<String>) -> Result<Option<u64>, String> {
        let request = self.orders.request(name, args).map_err(|why| why.to_string())?;
        let Some(request) = request else { return Ok(None) };
        let request = self.orders.stamped(request, self.given);
        self.ask(request).map_err(|why| why.text)
    }

    fn stop(&mut self, stop: Stop) -> Result<Option<u64>, String> {
        // What has arrived behind it is given after it.
        self.input.forget_epochs();
        let mut sent: Vec<&str> = Vec::new();
        let (mut tickets, mut refused) = (Vec::new(), Vec::new());
        // A machine that has changed since its commands were found has others.
        for round in 0..2 {
            let names: Vec<_> = self.orders.stops().commands(stop).to_vec();
            for name in names {
                if sent.contains(&name) {
                    continue;
                }
                let request = Request::Command { name: name.to_owned(), args: Vec::new() };
                match self.ask(request) {
                    Ok(ticket) => tickets.extend(ticket),
                    Err(why) if why.kind == Some(Kind::Commands) && round == 0 => continue,
                    Err(why) => refused.push(format!("{name}: {}", why.text)),
                }
                sent.push(name);
            }
            if round == 0 {
                self.renew()?;
            }
        }
        match (refused.is_empty(), sent.is_empty()) {
            (true, false) => Ok(tickets.first().copied()),
            (true, true) => Err("nothing of this machine can be stopped so".to_owned()),
            (false, _) => Err(refused.join("; ")),
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
