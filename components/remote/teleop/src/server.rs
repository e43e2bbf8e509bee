//! The server: all sessions, and the one job.

use crate::{
    answer::{Answer, Reason},
    session::{Session, Wait},
    words::Code,
};
use std::collections::{BTreeMap, VecDeque};

/// Number of users that are logged in at the same time.
pub const MAX_SESSIONS: usize = 16;
/// Longest silence of the owner of a running job, in milliseconds.
pub const LIVENESS_MS: u64 = 10_000;
/// Number of bytes of a connection that may wait while a request is executed.
const MAX_WAITING: usize = 64 << 10;

/// The machine as the server knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Machine {
    /// Reason why nobody can begin a job, if that is known before a start is tried: somebody has the lease.
    pub busy: Option<String>,
    /// Progress of its job in percent; `None` without one.
    pub progress: Option<u8>,
}

/// Something that the server wants done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Check a login; [`Server::signed_in`] takes the result.
    SignIn {
        /// Number of the connection.
        id: u64,
        /// Name of the user.
        user: String,
        /// Token or password.
        secret: String,
    },
    /// Check a program and run it; [`Server::started`] takes the result, and [`Server::ended`] that of the job.
    Start {
        /// Number of the connection.
        id: u64,
        /// The program.
        program: Vec<u8>,
    },
    /// Brake and end the job.
    Cancel,
    /// The client of the job has vanished: treat the job as configured.
    Lose,
    /// Send the output of a connection, and close it.
    Close(u64),
}

/// Progress of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// The program is being checked and started.
    Starts,
    Runs,
    /// Cancelled, by its owner or by the end of the server.
    Ends {
        by_owner: bool,
    },
    /// Cancelled by its owner before it began: only the answer is missing.
    Cancelled,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct CurrentJob {
    /// Number of the connection that runs it; `None` once it is gone.
    pub(crate) owner: Option<u64>,
    pub(crate) phase: Phase,
    /// True once the machine executes it.
    has_begun: bool,
    /// True once the loss of its client has been told.
    lost: bool,
}

/// The server.
#[derive(Debug, Default)]
pub struct Server {
    pub(crate) sessions: BTreeMap<u64, Session>,
    pub(crate) last: u64,
    pub(crate) job: Option<CurrentJob>,
    pub(crate) machine: Machine,
    /// True after the first job.
    had_job: bool,
    pub(crate) stops: bool,
    pub(crate) actions: VecDeque<Action>,
}

impl Server {
    /// Takes bytes of a connection.
    pub fn receive(&mut self, id: u64, bytes: &[u8], now: u64) {
        if let Some(session) = self.sessions.get_mut(&id) {
            session.lines.push(bytes);
        }
        self.work(id, now);
    }

    /// Returns whether a connection has sent more than fits until the request before is answered.
    pub fn is_full(&self, id: u64) -> bool {
        self.sessions.get(&id).is_some_and(|s| s.lines.waiting() + s.held_bytes > MAX_WAITING)
    }

    /// Returns the bytes for a connection.
    pub fn output(&mut self, id: u64) -> Vec<u8> {
        self.sessions.get_mut(&id).map(|s| core::mem::take(&mut s.output)).unwrap_or_default()
    }

    /// Returns what is to be done next.
    pub fn action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// Removes a connection that has ended.
    pub fn gone(&mut self, id: u64) {
        self.sessions.remove(&id);
        if let Some(job) = &mut self.job
            && job.owner == Some(id)
        {
            job.owner = None;
            // A job that starts is treated so once it runs.
            if job.phase == Phase::Runs {
                self.lose();
            }
        }
    }

    /// Takes the result of a login: whether the user may work, or why not.
    pub fn signed_in(&mut self, id: u64, result: Result<bool, String>, now: u64) {
        let Some(session) = self.sessions.get_mut(&id).filter(|s| !s.closes) else { return };
        let Some(Wait::SignIn(user)) = session.wait.take_if(|w| matches!(w, Wait::SignIn(_)))
        else {
            return;
        };
        match result {
            Err(why) => self.deny(id, Reason::new(Code::Permiso, why)),
            Ok(_) if self.has_user(&user) => {
                self.deny(id, Reason::new(Code::Ocupado, format!("{user} has a session")));
            }
            Ok(_) if self.users() >= MAX_SESSIONS => self.deny(id, full()),
            Ok(works) => {
                if let Some(session) = self.sessions.get_mut(&id) {
                    (session.user, session.works) = (Some(user), works);
                    session.say(&Answer::Aceptado);
                }
            }
        }
        self.work(id, now);
    }

    /// Takes the result of a start.
    pub fn started(&mut self, result: Result<(), Reason>, now: u64) {
        let Some(job) = &mut self.job else { return };
        let owner = job.owner;
        match (result, job.phase) {
            (Ok(()), phase) => {
                job.has_begun = true;
                // The owner could say nothing while the program was checked.
                if let Some(session) = owner.and_then(|id| self.sessions.get_mut(&id)) {
                    session.heard = now;
                }
                if phase == Phase::Starts {
                    job.phase = Phase::Runs;
                    if owner.is_none() {
                        self.lose();
                    }
                }
            }
            // The requests before its CANCELAR are answered first.
            (Err(_), Phase::Ends { by_owner: true }) if owner.is_some() => {
                job.phase = Phase::Cancelled;
            }
            (Err(why), phase) => {
                self.job = None;
                let stopped = phase == Phase::Ends { by_owner: false };
                let why = if stopped { stopping() } else { why };
                self.tell(owner, &Answer::ErrorEjecutar(why));
            }
        }
        self.go_on(owner, now);
    }

    /// Takes the end of the job.
    pub fn ended(&mut self, result: Result<(), Reason>, now: u64) {
        let Some(job) = self.job.take() else { return };
        self.had_job = true;
        self.machine.progress = None;
        let answer = match (job.phase, result) {
            (Phase::Ends { by_owner: true } | Phase::Cancelled, _) => Answer::Cancelado,
            (Phase::Ends { by_owner: false }, _) => Answer::ErrorEjecutar(stopping()),
            (Phase::Starts | Phase::Runs, Ok(())) => Answer::Terminado,
            (Phase::Starts | Phase::Runs, Err(why)) => Answer::ErrorEjecutar(why),
        };
        self.tell(job.owner, &answer);
        self.go_on(job.owner, now);
    }

    /// Takes the state of the machine.
    pub fn machine(&mut self, machine: Machine) {
        self.had_job |= self.machine.progress.is_some() && machine.progress.is_none();
        self.machine = machine;
    }

    /// Ends connections that do not log in and users who have been idle, and notes a silent owner.
    pub fn poll(&mut self, now: u64) {
        self.end_idle(now);
        let Some(CurrentJob { owner: Some(owner), phase: Phase::Runs, .. }) = self.job else {
            return;
        };
        if self.sessions.get(&owner).is_some_and(|s| now >= s.heard + LIVENESS_MS) {
            self.lose();
        }
    }

    /// Begins to stop: cancels the job, informs every client, and closes its connection.
    pub fn stop(&mut self, now: u64) {
        if core::mem::replace(&mut self.stops, true) {
            return;
        }
        match self.job {
            Some(CurrentJob { phase: Phase::Starts | Phase::Runs, .. }) => self.cancel(false),
            // Its owner, who cancelled it, is answered first.
            Some(_) => {}
            None => self.go_on(None, now),
        }
    }

    /// Returns whether the server has stopped, and every client has been told.
    pub fn is_stopped(&self) -> bool {
        self.stops && self.job.is_none()
    }

    /// Returns whether a job of this server runs.
    pub fn runs(&self) -> bool {
        self.job.is_some_and(|job| job.has_begun)
    }

    /// Returns whether the client of the running job is there and not silent; true without a job.
    pub fn is_linked(&self) -> bool {
        self.job.is_none_or(|job| !job.lost && job.owner.is_some())
    }

    /// Returns the progress as a client receives it, in percent.
    pub fn progress(&self) -> u8 {
        match (self.machine.progress, self.job) {
            (Some(percent), _) => percent.min(99),
            (None, Some(_)) => 0,
            (None, None) => {
                if self.had_job {
                    100
                } else {
                    0
                }
            }
        }
    }

    /// Returns the number of users that are logged in.
    pub fn users(&self) -> usize {
        self.sessions.values().filter(|s| s.user.is_some() && !s.closes).count()
    }

    /// Returns the user of a connection that has logged in.
    pub fn user(&self, id: u64) -> Option<&str> {
        self.sessions.get(&id).filter(|s| !s.closes)?.user.as_deref()
    }

    /// Returns the time in milliseconds up to which pulses are answered for the client of the job, as if it had answered
    /// them itself: in the past once it has vanished or is silent.
    ///
    /// While a start is checked, and while the client waits for the end of a job that it has cancelled, it may say nothing:
    /// it counts as there as long as its connection lasts.
    pub fn answers_until(&self, now: u64) -> u64 {
        let gone = now.saturating_sub(1);
        let Some(job) = self.job else { return gone };
        let Some(session) = job.owner.and_then(|id| self.sessions.get(&id)) else { return gone };
        let is_waiting = !job.has_begun || job.phase == Phase::Ends { by_owner: true };
        let heard = if is_waiting { now } else { session.heard };
        heard + LIVENESS_MS
    }

    pub(crate) fn has_user(&self, user: &str) -> bool {
        self.sessions.values().any(|s| !s.closes && s.user.as_deref() == Some(user))
    }

    /// Cancels the job that starts or runs.
    pub(crate) fn cancel(&mut self, by_owner: bool) {
        if let Some(job) = &mut self.job {
            job.phase = Phase::Ends { by_owner };
            self.actions.push_back(Action::Cancel);
        }
    }

    /// Begins a job of a connection.
    pub(crate) fn begin(&mut self, id: u64, program: Vec<u8>) {
        self.job = Some(CurrentJob {
            owner: Some(id),
            phase: Phase::Starts,
            has_begun: false,
            lost: false,
        });
        self.actions.push_back(Action::Start { id, program });
    }

    pub(crate) fn deny(&mut self, id: u64, why: Reason) {
        self.tell(Some(id), &Answer::Denegado(why));
        self.close(id);
    }

    pub(crate) fn close(&mut self, id: u64) {
        if let Some(session) = self.sessions.get_mut(&id)
            && !core::mem::replace(&mut session.closes, true)
        {
            self.actions.push_back(Action::Close(id));
        }
    }

    pub(crate) fn tell(&mut self, id: Option<u64>, answer: &Answer) {
        if let Some(session) = id.and_then(|id| self.sessions.get_mut(&id)) {
            session.say(answer);
        }
    }

    /// Tells once that the client of the job has vanished.
    fn lose(&mut self) {
        if let Some(job) = &mut self.job
            && !core::mem::replace(&mut job.lost, true)
        {
            self.actions.push_back(Action::Lose);
        }
    }

    /// Reads the requests that have waited for the start or the end of a job; at the end of the server, tells everybody.
    fn go_on(&mut self, owner: Option<u64>, now: u64) {
        if let Some(id) = owner.filter(|_| !self.is_stopped()) {
            let waits = |wait: &mut Wait| matches!(wait, Wait::Start | Wait::Cancel);
            if let Some(session) = self.sessions.get_mut(&id) {
                drop(session.wait.take_if(waits));
            }
            self.work(id, now);
        }
        if self.is_stopped() {
            let all: Vec<u64> =
                self.sessions.iter().filter(|(_, s)| !s.closes).map(|(id, _)| *id).collect();
            for id in all {
                self.tell(Some(id), &Answer::Desconexion);
                self.close(id);
            }
        }
    }
}

/// Returns the reason for the end of a job that the server has ended.
fn stopping() -> Reason {
    Reason::new(Code::Detenido, "the server stops")
}

/// Returns the refusal of a login when all sessions are taken.
pub(crate) fn full() -> Reason {
    Reason::new(Code::Ocupado, format!("there are {MAX_SESSIONS} sessions"))
}
