//! Execution of commands, beside the connection.

use super::{Connection, message::LeaseAction};
use crate::{
    commands::{self, Action, Args, Given},
    error::{Code, Error},
    lease::no_lease,
    server::Panel,
    session::Session,
};
use hal_protocol::{Reply, Request, TicketInfo};
use serde_json::{Value as Json, json};
use std::{sync::Arc, time::Duration};
use tokio::{sync::mpsc, time::sleep};

/// Commands that the engine must know of as work under the lease.
const STARTS: &[&str] = &["run", "resume", "step", "mdi", "home", "touch-off"];
/// Time for which the button of the tool change is pressed.
const PRESS: Duration = Duration::from_millis(300);
/// Time between two looks at a command that has not ended.
const LOOK: Duration = Duration::from_millis(50);

/// A client that has given a command.
pub(super) struct Order {
    panel: Arc<Panel>,
    session: Session,
    client: u64,
    answers: mpsc::Sender<Json>,
}

impl Connection {
    /// Executes an order beside the connection, and answers it.
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
        });
        tokio::spawn(async move {
            let answer = match run(order.clone()).await {
                Ok(ok) => json!({ "type": "reply", "id": id, "ok": ok }),
                Err(e) => json!({ "type": "reply", "id": id, "error": e }),
            };
            // A client that has gone needs no answer.
            drop(order.answers.send(answer).await);
        });
    }
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
            LeaseAction::Take => clients.take(engine, self.client, &self.session, force).await,
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
        self.note(&json!({ "command": name, "args": args }), end.as_ref());
        end
    }

    fn note<T>(&self, what: &Json, end: Result<&T, &Error>) {
        self.panel.audit.note(&self.session.user, self.client, what, end.map(|_| ()));
    }

    async fn execute(&self, id: u64, name: &str, args: &Args) -> Result<Json, Error> {
        let row = commands::find(name)?;
        self.session.needs(row.role)?;
        let lease = self.panel.clients.number(self.client);
        if row.lease && lease.is_none() {
            return Err(no_lease());
        }
        let (given, lease) = (Given { args }, lease.unwrap_or(0));
        let requests = match row.action {
            Action::Engine(requests) => requests(&given)?,
            Action::Jog => given.jog(lease)?,
            Action::Open => {
                let path = self.panel.program(&given.program()?)?;
                let file = format!("file={}", path.display());
                vec![Request::Command { name: "task.open".to_owned(), args: vec![file] }]
            }
            Action::ToolChanged => return self.tool_changed().await,
        };
        let engine = &self.panel.engine;
        if STARTS.contains(&name) {
            if name == "resume" {
                let release = "remote.release".to_owned();
                engine.call(Request::Command { name: release, args: Vec::new() }).await?;
            }
            let args = vec![format!("lease={lease}")];
            engine.call(Request::Command { name: "remote.start".to_owned(), args }).await?;
        }
        let mut lines = Vec::new();
        let mut pending = None;
        for request in requests {
            if let Reply::Answer(answer) = engine.call(request).await? {
                lines.extend(answer.lines);
                pending = answer.ticket;
            }
        }
        let mut ok = json!({ "lines": lines });
        if let (Some(ticket), Json::Object(ok)) = (pending, &mut ok) {
            ok.insert("pending".to_owned(), true.into());
            self.follow(id, ticket);
        }
        Ok(ok)
    }

    /// Tells the client how a command ends that takes time.
    fn follow(&self, id: u64, ticket: u64) {
        let (panel, answers) = (self.panel.clone(), self.answers.clone());
        tokio::spawn(async move {
            let end = loop {
                sleep(LOOK).await;
                if answers.is_closed() {
                    return;
                }
                match panel.engine.call(Request::Ticket { id: ticket, wait: false }).await {
                    Ok(Reply::Ticket(TicketInfo::Pending)) => {}
                    Ok(Reply::Ticket(TicketInfo::Failed(why))) => {
                        break Err(Error::new(Code::Refused, why));
                    }
                    Ok(_) => break Ok(()),
                    Err(e) => break Err(e),
                }
            };
            let message = match end {
                Ok(()) => json!({ "type": "done", "id": id, "ok": {} }),
                Err(e) => json!({ "type": "done", "id": id, "error": e }),
            };
            // A client that has gone needs no answer.
            drop(answers.send(message).await);
        });
    }

    async fn tool_changed(&self) -> Result<Json, Error> {
        let press = |on: bool| Request::Set {
            name: "hal_manualtoolchange.change_button".to_owned(),
            value: if on { "TRUE" } else { "FALSE" }.to_owned(),
        };
        let engine = &self.panel.engine;
        engine.call(press(true)).await?;
        sleep(PRESS).await;
        // A button that stays pressed would answer the next tool change too.
        engine.call(press(false)).await?;
        Ok(json!({ "lines": [] }))
    }
}
