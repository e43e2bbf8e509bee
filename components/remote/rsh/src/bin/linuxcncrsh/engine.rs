//! The machine of a session: snapshots, commands and control.

use crate::{
    connection::Input,
    control::Control,
    seats::{Seats, Taken},
};
use hal_lease::EpochPage;
use hal_protocol::{
    Client, Failure, Kind, Link as _, Orders, Place, Reply, Request, Snapshot, Stop, TicketInfo,
};
use rsh::{Facts, Jog, Machine, Passwords, Record, Snapshots};
use std::{
    net::TcpStream,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, SystemTime},
};

/// Command that opens a program.
const OPEN: &str = "task.open";
/// Time for which its end is waited for; a clock that is held does not reach it.
const OPENS: Duration = Duration::from_secs(1);
/// Time within which lines that were sent at once arrive.
const AT_ONCE: Duration = Duration::from_millis(100);

/// Data that all sessions share.
#[derive(Debug)]
pub(crate) struct Served {
    pub(crate) place: Place,
    pub(crate) facts: Facts,
    pub(crate) passwords: Passwords,
    pub(crate) control: Arc<Control>,
    /// Records of the machine, for sessions without a client of the engine.
    pub(crate) records: Mutex<Records>,
    /// The record of motion, for the stop epochs of lines.
    pub(crate) epochs: Mutex<Option<EpochPage>>,
    pub(crate) seats: Seats,
}

/// The records that sessions show.
#[derive(Debug)]
pub(crate) struct Records {
    motion: Snapshot,
    /// The record of the task, where there is one.
    task: Option<Snapshot>,
}

impl Records {
    pub(crate) fn open(client: &mut Client) -> Result<Self, Failure> {
        let motion = client.snapshot("motion.status")?;
        Ok(Self { motion, task: client.snapshot("task.status").ok() })
    }

    /// Returns a state without values.
    fn state(&self, facts: Facts) -> Snapshots {
        Snapshots {
            motion: Record::new(self.motion.info()),
            task: self.task.as_ref().map(|task| Record::new(task.info())).unwrap_or_default(),
            facts,
        }
    }

    fn read(&mut self, state: &mut Snapshots) {
        // A record that its component does not end is read the next time.
        self.motion.wait(state.motion.values_mut());
        match &self.task {
            Some(task) => drop(task.wait(state.task.values_mut())),
            None => state.fill_task(),
        }
    }
}

/// A session's client of the engine, which it has from its hello on.
struct Link {
    client: Client,
    records: Records,
    /// Commands of the machine.
    orders: Orders,
    /// Kept while the client lives.
    _seat: Taken,
}

/// The machine of one session.
pub(crate) struct Engine {
    source: Arc<Served>,
    link: Option<Link>,
    /// Stop epoch in which the line in execution has arrived.
    pub(crate) given: Option<u64>,
    state: Snapshots,
    session: u64,
    pub(crate) input: Input,
}

/// Error code (ENOTCONN) of a request without a client of the engine.
const ENOTCONN: i32 = -107;

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Engine {
    pub(crate) fn new(source: &Arc<Served>, session: u64, stream: TcpStream) -> Self {
        let state = lock(&source.records).state(source.facts.clone());
        let (source, input) = (source.clone(), Input::new(stream, source.clone()));
        Self { source, link: None, given: None, state, session, input }
    }

    /// Opens a client of the engine, once. `None` if it takes none, or enough sessions have one.
    pub(crate) fn link(&mut self) -> Option<()> {
        if self.link.is_none() {
            let seat = self.source.seats.link()?;
            let mut client = Client::connect_from_afar(&self.source.place).ok()?;
            let orders = hal_lease::orders(&mut client).ok()?;
            let records = Records::open(&mut client).ok()?;
            self.state = records.state(self.source.facts.clone());
            self.link = Some(Link { client, records, orders, _seat: seat });
        }
        Some(())
    }

    fn linked(&mut self) -> Result<&mut Link, Failure> {
        self.link.as_mut().ok_or_else(|| Failure::new(ENOTCONN, "hello comes first"))
    }

    fn ask(&mut self, request: Request) -> Result<Option<u64>, Failure> {
        match self.linked()?.client.call(request)? {
            Reply::Answer(answer) => Ok(answer.ticket),
            _ => Ok(None),
        }
    }

    /// Finds the commands of a machine that has changed.
    fn renew(&mut self) -> Result<(), String> {
        let link = self.linked().map_err(|why| why.text)?;
        link.orders = hal_lease::orders(&mut link.client).map_err(|why| why.to_string())?;
        Ok(())
    }
}

impl Engine {
    /// Returns whether a command has not ended yet.
    fn is_pending(&mut self, ticket: u64) -> bool {
        let Ok(link) = self.linked() else { return false };
        let reply = link.client.call(Request::Ticket { id: ticket, wait: false });
        matches!(reply, Ok(Reply::Ticket(TicketInfo::Pending)))
    }
}

impl Machine for Engine {
    fn poll(&mut self) {
        match &mut self.link {
            Some(link) => link.records.read(&mut self.state),
            None => lock(&self.source.records).read(&mut self.state),
        }
    }

    fn state(&self) -> &Snapshots {
        &self.state
    }

    fn command(&mut self, name: &str, args: Vec<String>) -> Result<Option<u64>, String> {
        // A client is elsewhere, and be it of the user who runs this program: the engine opens files of the folder of programs
        // for it. Without an INI file nothing says which folder that is.
        if name == OPEN && self.source.facts.path.is_empty() {
            return Err("programs are opened below [DISPLAY]PROGRAM_PREFIX, and linuxcncrsh was started without an INI \
                        file: linuxcncrsh -- -ini FILE"
                .to_owned());
        }
        let given = self.given;
        let orders = &self.linked().map_err(|why| why.text)?.orders;
        let request = orders.request(name, args).map_err(|why| why.to_string())?;
        let Some(request) = request else { return Ok(None) };
        let request = orders.stamped(request, given);
        let ticket = self.ask(request).map_err(|why| why.text)?;
        match ticket {
            // It ends at once, and a refusal must reach a client that waits for nothing.
            Some(ticket) if name == OPEN => match self.wait(ticket, Some(OPENS)) {
                Err(why) if !self.is_pending(ticket) => Err(why),
                _ => Ok(Some(ticket)),
            },
            ticket => Ok(ticket),
        }
    }

    fn stop(&mut self, stop: Stop) -> Result<Option<u64>, String> {
        // What has arrived behind it is given after it.
        self.input.forget_epochs();
        let mut sent: Vec<&str> = Vec::new();
        let (mut tickets, mut refused) = (Vec::new(), Vec::new());
        // A machine that has changed since its commands were found has others.
        for round in 0..2 {
            let orders = &self.linked().map_err(|why| why.text)?.orders;
            let names: Vec<_> = orders.stops().commands(stop).to_vec();
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
        self.source.control.jog(self.session, args)
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "the client has stated a time of its own, whatever the engine's clock shows"
    )]
    fn wait(&mut self, ticket: u64, most: Option<Duration>) -> Result<(), String> {
        let begun = std::time::Instant::now();
        loop {
            let link = self.linked().map_err(|why| why.text)?;
            let reply = link.client.call(Request::Ticket { id: ticket, wait: false });
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
        self.source.control.take(self.session)
    }

    fn give(&mut self) {
        self.source.control.give(self.session);
    }

    fn has_control(&self) -> bool {
        self.source.control.has(self.session)
    }

    fn shut_down(&mut self) -> Result<(), String> {
        let link = self.linked().map_err(|why| why.text)?;
        link.client.call(Request::Shutdown).map(drop).map_err(|e| e.text)
    }

    fn time(&self) -> f64 {
        SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default().as_secs_f64()
    }
}
