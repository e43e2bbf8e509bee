//! Execution of commands, beside the connection.

use super::{Connection, message::LeaseAction};
use crate::{
    commands::{self, Action, Args, Input},
    epoch::Given,
    error::{Code, Error},
    lease::no_lease,
    server::Panel,
    session::{Role, Session},
    values,
};
use hal_protocol::{Kind, Reply, Request, TicketInfo, Value};
use serde_json::{Value as Json, json};
use std::{
    pin::Pin,
    sync::{Arc, atomic::Ordering::Relaxed},
    task::{Context, Poll, Waker},
    time::Duration,
};
use tokio::{sync::mpsc, time::sleep};

/// State of the interpreter in the task's status that waits in a pause.
const PAUSED: u64 = 2;
/// Longest name of a command in the audit log, in characters.
const MAX_NAME: usize = 64;
/// Request of a tool change, and the pin of the plugin that reads it.
const TOOL_CHANGE: (&str, &str) = ("hal_manualtoolchange.change", "remote.tool-change");
/// Pin of the plugin that answers a tool change (its command has the same name), with the signal and the button.
const TOOL_CHANGED: (&str, &str, &str) =
    ("remote.tool-changed", "remote-tool-changed", "hal_manualtoolchange.change_button");
/// Pin of a robot behind its own controller that holds its run.
const ROBOT_HOLD: &str = "robot.hold";
/// Time between two looks at a command that has not ended.
const LOOK: Duration = Duration::from_millis(50);
/// Largest number of looks at a hold whose end is on its way.
const MAX_LOOKS: u32 = 100;

/// A client that has given a command.
pub(super) struct Order {
    panel: Arc<Panel>,
    session: Session,
    client: u64,
    answers: mpsc::Sender<Json>,
    /// Number of stops of this panel when its message arrived.
    stops: u64,
    /// Stop epoch of motion then.
    given: Given,
}

impl Connection {
    /// Executes an order beside the connection, and answers it.
    ///
    /// Its first request joins those that wait for the engine before this returns: a stop that follows a jog reaches
    /// the engine after it.
    pub(super) fn order<F, R>(&self, id: u64, run: F)
    where
        F: FnOnce(Arc<Order>) -> R + Send + 'static,
        R: Future<Output = Result<Json, Error>> + Send,
    {
        let order = Arc::new(Order {
            panel: self.panel.clone(),
            session: self.session.clone(),
            client: self.client,
            answers: self.answers.clone(),
            stops: self.panel.engine.stops(),
            given: self.panel.epochs.now(),
        });
        let mut work = Box::pin(async move {
            let answer = match run(order.clone()).await {
                Ok(mut ok) => {
                    let pending = ok.as_object_mut().and_then(|ok| ok.remove("pending"));
                    let mut reply = json!({ "type": "reply", "id": id, "ok": ok });
                    if let (Some(pending), Json::Object(reply)) = (pending, &mut reply) {
                        reply.insert("pending".to_owned(), pending);
                    }
                    reply
                }
                Err(e) => json!({ "type": "reply", "id": id, "error": e }),
            };
            // A client that has gone needs no answer.
            drop(order.answers.send(answer).await);
        });
        if !begin(&mut work) {
            tokio::spawn(work);
        }
    }
}

/// Runs a future until it waits; returns whether it has ended. Who spawns it then wakes it.
fn begin<F: Future<Output = ()> + Unpin>(work: &mut F) -> bool {
    Pin::new(work).poll(&mut Context::from_waker(Waker::noop())) == Poll::Ready(())
}

/// Returns the refusal of a command where the machine's wiring permits no motion from afar.
fn not_allowed() -> Error {
    Error::new(Code::Remote, "remote.allow-motion is FALSE: the machine permits no remote motion")
}

impl Order {
    pub(super) async fn lease(
        &self,
        action: LeaseAction,
        to: Option<u64>,
        force: bool,
    ) -> Result<(), Error> {
        let (clients, engine) = (&self.panel.clients, &self.panel.engine);
        let end = match action {
            LeaseAction::Take => match self.needs(Role::Operator) {
                Ok(()) => clients.take(engine, self.client, &self.session, force).await,
                Err(why) => Err(why),
            },
            LeaseAction::Give => clients.give(engine, self.client).await,
            LeaseAction::Hand => match to {
                Some(to) => clients.hand(engine, self.client, to).await,
                None => Err(Error::new(Code::Malformed, "hand needs 'to', the number of a client")),
            },
        };
        let what =
            json!({ "lease": format!("{action:?}").to_lowercase(), "to": to, "force": force });
        self.note(&what, end.as_ref().map(|()| &()));
        end
    }

    pub(super) async fn command(&self, id: u64, name: &str, args: &Args) -> Result<Json, Error> {
        let end = self.execute(id, name, args).await;
        // Of a command that was refused nothing is known to be short.
        let what = match &end {
            Ok(_) => json!({ "command": name, "args": args }),
            Err(_) => json!({ "command": name.chars().take(MAX_NAME).collect::<String>() }),
        };
        self.note(&what, end.as_ref());
        end
    }

    /// Refuses what needs a role that the session does not have, or has lost because nobody used its page.
    fn needs(&self, role: Role) -> Result<(), Error> {
        self.session.needs(role)?;
        match self.panel.sessions.role(&self.session) {
            Some(now) if now < role => Err(Error::new(
                Code::Role,
                "half an hour has passed without input: sign in again to move the machine",
            )),
            _ => Ok(()),
        }
    }

    fn note<T>(&self, what: &Json, end: Result<&T, &Error>) {
        self.panel.audit.note(&self.session.user, self.client, what, end.map(|_| ()));
    }

    async fn execute(&self, id: u64, name: &str, args: &Args) -> Result<Json, Error> {
        let row = commands::find(name)?;
        self.needs(row.role)?;
        let orders = self.panel.engine.orders();
        let given = Input { args, orders: &orders, is_inch: self.panel.is_inch };
        if let Action::Stop(ending) = row.action {
            given.only(&[])?;
            let told = self.panel.stop(ending).await?;
            return Ok(self.done(id, &told.lines, told.tickets));
        }
        let lease = self.panel.clients.number(self.client);
        if row.needs_lease() && lease.is_none() {
            return Err(no_lease());
        }
        if row.needs_permission(args) && !self.panel.heart.allowed.load(Relaxed) {
            return Err(not_allowed());
        }
        let lease = lease.unwrap_or(0);
        if row.needs_lease() && !row.is_judged() {
            self.confirm(lease).await?;
        }
        let requests = match row.action {
            Action::Engine(requests) => requests(&given)?,
            Action::Jog => given.jog(lease)?,
            Action::Open(command) => {
                let program = self.panel.folders.program(&given.program()?)?;
                // What is no file is refused here by name, and a link leads nowhere.
                drop(program.open()?);
                let file = format!("file={}", program.path().display());
                orders.request(command, vec![file])?.into_iter().collect()
            }
            Action::ToolChanged => return self.tool_changed(lease).await,
            Action::Stop(_) | Action::EndJogs => given.plain("motion.jog-stop")?,
        };
        let mut epoch = match self.given {
            Given::In(epoch) => epoch,
            Given::AfterStop => None,
        };
        if row.is_announced() {
            epoch = self.panel.epochs.settled(self.given).await;
            if self.announce(name, lease, given.on_loss()?, epoch).await? {
                return Ok(json!({ "lines": [] }));
            }
        }
        let (mut lines, mut tickets) = (Vec::new(), Vec::new());
        for request in requests {
            let request = orders.stamped(request, epoch);
            let reply = match row.action {
                Action::EndJogs => self.panel.engine.end_jogs(request).await?,
                // The name was that of a program of this panel's folder, which need not be the engine's.
                Action::Open(_) => self.panel.wiring.call(request).await?,
                _ => self.panel.engine.call_unless_stopped(request, self.stops).await?,
            };
            if let Reply::Answer(answer) = reply {
                lines.extend(answer.lines);
                tickets.extend(answer.ticket);
            }
        }
        Ok(self.done(id, &lines, tickets))
    }

    /// Asks the plugin `remote` whether this is still its lease. This program may have stood still meanwhile, and somebody else may have taken
    /// the lease by another program.
    async fn confirm(&self, lease: u64) -> Result<(), Error> {
        let args = vec![format!("lease={lease}")];
        let asked = Request::Command { name: "remote.beat".to_owned(), args };
        match self.panel.engine.call_unless_stopped(asked, self.stops).await {
            Err(why) if why.code == Code::Refused => {
                self.panel.clients.lost(lease);
                Err(no_lease())
            }
            asked => asked.map(drop),
        }
    }

    /// Tells the plugin `remote` that work begins under the lease, and ends a hold for what resumes it. Returns whether that
    /// is enough: a program that is held, and not paused, goes on by the release alone.
    async fn announce(
        &self,
        name: &str,
        lease: u64,
        on_loss: Option<String>,
        epoch: Option<u64>,
    ) -> Result<bool, Error> {
        let engine = &self.panel.engine;
        let is_enough =
            name == "resume" && self.panel.heart.hold.load(Relaxed) && !self.is_paused();
        let is_held =
            name == "robot-resume" && values::is_on(&self.panel.engine, ROBOT_HOLD).await?;
        let mut args = vec![format!("lease={lease}")];
        if matches!(name, "resume" | "robot-resume") {
            args.push("release=TRUE".to_owned());
        }
        args.extend(on_loss.as_ref().map(|on_loss| format!("on-loss={on_loss}")));
        let start = Request::Command { name: "remote.start".to_owned(), args };
        let start = engine.orders().stamped(start, epoch);
        let reply = engine.call_unless_stopped(start, self.stops).await?;
        if let Reply::Answer(answer) = reply {
            self.panel.note_loss(&answer.lines);
        }
        if is_held {
            self.let_go().await?;
        }
        Ok(is_enough)
    }

    /// Returns the reply to a command, and follows it to its end if it takes time.
    fn done(&self, id: u64, lines: &[String], tickets: Vec<u64>) -> Json {
        let mut ok = json!({ "lines": lines });
        if let (false, Json::Object(ok)) = (tickets.is_empty(), &mut ok) {
            ok.insert("pending".to_owned(), true.into());
            self.follow(id, tickets);
        }
        ok
    }

    /// Waits until the end of a hold has reached the robot, which resumes nothing before. A hold by another lasts: the robot
    /// then refuses to resume.
    async fn let_go(&self) -> Result<(), Error> {
        for _ in 0..MAX_LOOKS {
            sleep(LOOK).await;
            if !values::is_on(&self.panel.engine, ROBOT_HOLD).await? {
                break;
            }
        }
        Ok(())
    }

    /// Returns whether the job, or the path of a machine without a task, waits in a pause.
    fn is_paused(&self) -> bool {
        let machine = self.panel.machine.borrow();
        match (&machine.task, &machine.motion) {
            (Some(task), _) => task.get("interpreter").and_then(Json::as_u64) == Some(PAUSED),
            (None, Some(motion)) => motion.get("paused") == Some(&Json::Bool(true)),
            (None, None) => false,
        }
    }

    /// Tells the client how commands end that take time.
    fn follow(&self, id: u64, tickets: Vec<u64>) {
        let (panel, answers) = (self.panel.clone(), self.answers.clone());
        tokio::spawn(async move {
            let mut end = Ok(());
            for ticket in tickets {
                let Some(one) = follow(&panel, &answers, ticket).await else { return };
                end = end.and(one);
            }
            let message = match end {
                Ok(()) => json!({ "type": "done", "id": id, "ok": {} }),
                Err(e) => json!({ "type": "done", "id": id, "error": e }),
            };
            // A client that has gone needs no answer.
            drop(answers.send(message).await);
        });
    }

    /// Presses the button of the tool change. The plugin releases it, whatever becomes of this program.
    async fn tool_changed(&self, lease: u64) -> Result<Json, Error> {
        let (engine, wiring) = (&self.panel.engine, &self.panel.wiring);
        let pressing = self.panel.pressing.lock().await;
        let list = Request::List { kind: Kind::Pins, patterns: Vec::new(), ty: None };
        let Reply::Items(pins) = engine.call(list).await? else {
            return Err(Error::new(Code::Refused, "the engine lists no pins"));
        };
        let pin = |name: &str| pins.iter().find(|pin| pin.name == name);
        let request = pin(TOOL_CHANGE.0).filter(|pin| pin.value == Value::Bit(true));
        let Some(request) = request else {
            // A press now would answer the next change, before its tool is there.
            return Err(Error::new(Code::Conflict, "no tool change waits for its answer"));
        };
        // The program that asks for the tool may have joined after this one.
        if let Some(signal) = request.signal.clone()
            && pin(TOOL_CHANGE.1).is_some_and(|pin| pin.signal.is_none())
        {
            let pins = vec![TOOL_CHANGE.1.to_owned()];
            wiring.call(Request::Net { signal, pins }).await?;
        }
        let link = hal_lease::join(&pins, TOOL_CHANGED);
        let link = link.map_err(|why| Error::new(Code::Refused, why.to_string()))?;
        let is_linked_here = link.is_some();
        if let Some(link) = link {
            wiring.call(link).await?;
        }
        let args = vec![format!("lease={lease}")];
        let pressed = Request::Command { name: TOOL_CHANGED.0.to_owned(), args };
        let pressed = engine.call(pressed).await.map(|_| json!({ "lines": [] }));
        if is_linked_here {
            // A person at the machine may set the button too.
            while values::is_on(engine, TOOL_CHANGED.0).await? {
                sleep(LOOK).await;
            }
            wiring.call(Request::Unlink { pin: TOOL_CHANGED.2.to_owned() }).await?;
        }
        drop(pressing);
        pressed
    }
}

/// Waits for the end of a command; `None` once its client has gone.
async fn follow(
    panel: &Panel,
    answers: &mpsc::Sender<Json>,
    ticket: u64,
) -> Option<Result<(), Error>> {
    loop {
        sleep(LOOK).await;
        if answers.is_closed() {
            return None;
        }
        match panel.engine.call(Request::Ticket { id: ticket, wait: false }).await {
            Ok(Reply::Ticket(TicketInfo::Pending)) => {}
            Ok(Reply::Ticket(TicketInfo::Failed(why))) => {
                return Some(Err(Error::new(Code::Refused, why)));
            }
            // Other requests fill the line: look again.
            Err(e) if e.code == Code::TooMany => {}
            Ok(_) => return Some(Ok(())),
            Err(e) => return Some(Err(e)),
        }
    }
}

#[cfg(test)]
pub(crate) mod rights;
#[cfg(test)]
mod tests;
