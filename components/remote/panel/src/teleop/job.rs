//! A job: its start through the task, its end, and the lease meanwhile.

mod cancel;
mod readiness;

use self::readiness::Readiness;
use super::check::{self, Lengths};
use crate::{
    error::{Code as Kind, Error},
    server::Panel,
    session::Session,
    status::Joined,
};
use hal_protocol::{Reply, Request, TicketInfo};
use serde_json::{Map, Value as Json};
use std::{
    path::PathBuf,
    sync::{Arc, atomic::Ordering::Relaxed},
    time::Duration,
};
use teleop::{Code, Reason};
use tokio::{
    task::block_in_place,
    time::{Instant, sleep, timeout},
};

pub(super) use cancel::{MAX_END, cancel};

/// Time between two looks at a command that has not ended.
const LOOK: Duration = Duration::from_millis(20);
/// Longest time until the status shows the end of a job, or a stop.
const SETTLE: Duration = Duration::from_secs(1);

/// A user of the protocol, as the panel knows it.
#[derive(Clone, Debug)]
pub(super) struct User {
    pub(super) session: Session,
    /// Number among the clients of the panel.
    pub(super) client: u64,
}

/// A job that runs.
#[derive(Clone, Debug)]
pub(super) struct Begun {
    ticket: u64,
    file: PathBuf,
    /// Number of jobs that had ended before.
    before: u64,
    /// Numbers of stops when it was asked for.
    stops: Stops,
    pub(super) lengths: Lengths,
}

/// Returns who else has the control lease.
pub(super) fn leased(panel: &Panel, client: Option<u64>) -> Option<String> {
    let holder = panel.clients.view().1.filter(|holder| Some(holder.client) != client)?;
    Some(format!("{} has the control lease", holder.user))
}

/// Returns a number of a status; 0 if there is none.
pub(super) fn number(status: &Map<String, Json>, name: &str) -> u64 {
    status.get(name).and_then(Json::as_u64).unwrap_or_default()
}

/// Returns where the machine is, in machine units.
fn pose(panel: &Panel) -> [f64; 9] {
    let machine = panel.machine.borrow();
    let pose = machine.motion.as_ref().and_then(|motion| motion.get("pose")).cloned();
    pose.and_then(|pose| serde_json::from_value(pose).ok()).unwrap_or_default()
}

/// A start that is on its way.
#[derive(Clone, Copy, Debug)]
struct Start<'a> {
    panel: &'a Panel,
    client: u64,
    /// Numbers of stops when it was asked for.
    stops: Stops,
    /// Stop epoch of motion then.
    epoch: Option<u64>,
}

/// Numbers of stops so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stops {
    /// By this panel, also those that are on their way to the machine.
    panel: u64,
    /// From any source, as the status of the task shows.
    machine: u64,
}

impl Stops {
    pub(super) fn of(panel: &Panel) -> Self {
        let machine = panel.machine.borrow();
        let machine = machine.task.as_ref().map_or(0, |task| number(task, "stops"));
        Self { panel: panel.engine.stops(), machine }
    }
}

impl Start<'_> {
    /// Refuses the start if the machine is not ready, or not this client's, or anything has been stopped since.
    fn check(&self) -> Result<(), Reason> {
        let panel = self.panel;
        let traj = |name: &str| panel.info.get("ini")?.get("TRAJ")?.get(name)?.as_str();
        let readiness = Readiness {
            leased: leased(panel, Some(self.client)),
            is_allowed: panel.heart.allowed.load(Relaxed),
            is_stopped: Stops::of(panel) != self.stops,
            needs_homing: traj("NO_FORCE_HOMING").is_none_or(|text| text.trim() != "1"),
            machine: &panel.machine.borrow(),
        };
        readiness.refusal().map_or(Ok(()), Err)
    }

    /// Waits for something, as long as the start is not refused.
    async fn during<T>(&self, work: impl Future<Output = T>) -> Result<T, Reason> {
        let refused = async {
            loop {
                if let Err(why) = self.check() {
                    return why;
                }
                sleep(LOOK).await;
            }
        };
        tokio::select! {
            biased;
            why = refused => Err(why),
            end = work => Ok(end),
        }
    }
}

/// Checks a program and runs it under the control lease, unless something has been stopped since these numbers. From the
/// begin of the check on, the machine must stay ready and free: after a stop, switching it on again does not move it by a
/// request from before.
pub(super) async fn start(
    panel: &Arc<Panel>,
    user: &User,
    program: Vec<u8>,
    stops: Stops,
) -> Result<Begun, Reason> {
    let begun = check_and_begin(panel, user, program, stops).await;
    if begun.is_err() {
        stop_is_shown(panel, stops).await;
    }
    begun
}

/// Waits until the status shows a stop by this panel since these numbers: otherwise it would refuse the next start too.
async fn stop_is_shown(panel: &Panel, before: Stops) {
    let since = Instant::now();
    let is_shown = || {
        let now = Stops::of(panel);
        now.panel == before.panel || now.machine != before.machine
    };
    while !is_shown() && since.elapsed() < SETTLE {
        sleep(LOOK).await;
    }
}

async fn check_and_begin(
    panel: &Arc<Panel>,
    user: &User,
    program: Vec<u8>,
    stops: Stops,
) -> Result<Begun, Reason> {
    let epoch = panel.epochs.settled(panel.epochs.now()).await;
    // The status of the machine shall not be older than the request: the next one may be on its way already.
    let mut status = panel.machine.clone();
    for _ in 0..2 {
        status.mark_unchanged();
        drop(timeout(SETTLE, status.changed()).await);
    }
    let start = Start { panel, client: user.client, stops, epoch };
    start.check()?;
    let file = panel.teleop_file();
    let lengths = block_in_place(|| {
        let written = hal_output::install(&file, &program, 0o600);
        written.map_err(|e| {
            Reason::new(Code::Falla, format!("{}: {}", file.display(), hal_output::reason(&e)))
        })?;
        let ini = panel.options.ini_file.as_deref();
        check::read(ini, &file, pose(panel), &|| start.check())
    });
    let lengths = lengths?;
    let begun = begin(start, user, file, lengths).await;
    if begun.is_err() {
        has_not_begun(panel, user).await;
        end_lease(panel, user).await;
    }
    begun
}

async fn begin(
    start: Start<'_>,
    user: &User,
    file: PathBuf,
    lengths: Lengths,
) -> Result<Begun, Reason> {
    let Start { panel, client, stops, epoch } = start;
    let (engine, clients) = (&panel.engine, &panel.clients);
    clients.take(engine, client, &user.session, false).await.map_err(refused)?;
    let lost = || Reason::new(Code::Ocupado, "the control lease has ended");
    let lease = clients.number(client).ok_or_else(lost)?;
    // From here on the beats of this program keep the lease.
    panel.heart.keep(lease);
    let command = |name: &str, args: Vec<String>| Request::Command { name: name.to_owned(), args };
    let open = format!("file={}", file.display());
    let before = {
        let machine = panel.machine.borrow();
        machine.task.as_ref().map_or(0, |task| number(task, "jobs"))
    };
    for request in [
        command("task.mode", vec!["mode=auto".to_owned()]),
        command("task.open", vec![open]),
        command("remote.start", vec![format!("lease={lease}")]),
    ] {
        start.check()?;
        let request = engine.orders().stamped(request, epoch);
        let opens = matches!(&request, Request::Command { name, .. } if name == "task.open");
        let reply = match opens {
            // The file is this program's own, which nobody elsewhere has named.
            true => panel.wiring.call(request).await,
            false => engine.call_unless_stopped(request, stops.panel).await,
        };
        if let Some(ticket) = ticket(reply.map_err(refused)?) {
            let end = start.during(finish(panel, ticket)).await?;
            end.map_err(|text| Reason::new(Code::Falla, text))?;
        }
    }
    start.check()?;
    // A stop that the status does not show yet is seen by the task.
    let run = command("task.run", vec![format!("stops={}", stops.machine)]);
    let run = engine.orders().stamped(run, epoch);
    let run = engine.call_unless_stopped(run, stops.panel).await;
    let reply = run.map_err(|e| match e.code {
        Kind::Refused => check::reason(&file, &e.text),
        _ => refused(e),
    })?;
    let none = || Reason::new(Code::Falla, "the task does not say when the job ends");
    let ticket = ticket(reply).ok_or_else(none)?;
    Ok(Begun { ticket, file, before, stops, lengths })
}

/// Tells the plugin that a job which was announced has not begun: there is nothing to hold.
async fn has_not_begun(panel: &Panel, user: &User) {
    let Some(lease) = panel.clients.number(user.client) else { return };
    let args = vec![format!("lease={lease}")];
    let refused = Request::Command { name: "remote.refused".to_owned(), args };
    // An engine that does not answer holds nothing.
    drop(panel.engine.call(refused).await);
}

/// Waits for the end of a job, and gives the lease back.
pub(super) async fn follow(panel: &Panel, user: &User, begun: &Begun) -> Result<(), Reason> {
    let end = finish(panel, begun.ticket).await;
    // The next client shall see that nothing runs.
    let since = Instant::now();
    let is_over = || {
        let machine = panel.machine.borrow();
        // A status that cannot be read at this moment is no sign of an end.
        let Some(task) = &machine.task else { return machine.engine == Joined::Gone };
        number(task, "interpreter") == 0 && (end.is_err() || number(task, "jobs") != begun.before)
    };
    while !is_over() && since.elapsed() < SETTLE {
        sleep(LOOK).await;
    }
    let has_run = {
        let machine = panel.machine.borrow();
        machine.task.as_ref().is_some_and(|task| number(task, "jobs") != begun.before)
    };
    if !has_run {
        has_not_begun(panel, user).await;
    }
    end_lease(panel, user).await;
    end.map_err(|text| match has_run {
        true => Reason::new(Code::Falla, text),
        false if Stops::of(panel) != begun.stops => Reason::new(Code::Ocupado, text),
        false => check::reason(&begun.file, &text),
    })
}

/// Gives the lease back.
pub(super) async fn end_lease(panel: &Panel, user: &User) {
    panel.heart.keep(0);
    // An engine that does not answer has no lease either.
    drop(panel.clients.give(&panel.engine, user.client).await);
}

/// Waits for the end of a command.
async fn finish(panel: &Panel, ticket: u64) -> Result<(), String> {
    loop {
        match panel.engine.call(Request::Ticket { id: ticket, wait: false }).await {
            Ok(Reply::Ticket(TicketInfo::Pending)) => sleep(LOOK).await,
            Ok(Reply::Ticket(TicketInfo::Failed(why))) => return Err(why),
            Ok(_) => return Ok(()),
            // Other requests fill the queue: look again.
            Err(e) if e.code == Kind::TooMany => sleep(LOOK).await,
            Err(e) => return Err(e.text),
        }
    }
}

fn ticket(reply: Reply) -> Option<u64> {
    if let Reply::Answer(answer) = reply { answer.ticket } else { None }
}

fn refused(error: Error) -> Reason {
    let code = match error.code {
        Kind::Conflict | Kind::Lease => Code::Ocupado,
        Kind::Remote => Code::Apagado,
        Kind::Role => Code::Permiso,
        _ => Code::Falla,
    };
    Reason::new(code, error.text)
}

#[cfg(test)]
mod tests;
