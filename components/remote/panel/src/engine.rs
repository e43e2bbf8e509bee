//! The connection to the engine: one thread that calls it, and answers whom it concerns.

use crate::error::{Code, Error};
use hal_protocol::{Client, Link as _, Place, Reply, Request};
use std::{
    sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel},
    thread,
};
use tokio::sync::oneshot;

/// Number of requests that wait for the engine.
const MAX_WAITING: usize = 256;

struct Job {
    request: Request,
    answer: oneshot::Sender<Result<Reply, Error>>,
}

/// The way to the engine, for all sessions.
#[derive(Clone, Debug)]
pub(crate) struct Engine {
    jobs: SyncSender<Job>,
}

impl Engine {
    /// Connects, and starts the thread.
    pub(crate) fn join(place: Place) -> Result<Self, String> {
        let client = Client::connect(&place, "").map_err(|e| e.to_string())?;
        let (jobs, waiting) = sync_channel(MAX_WAITING);
        let thread = thread::Builder::new().name("engine".to_owned());
        let begun = thread.spawn(move || carry(client, &waiting));
        begun.map_err(|e| hal_output::reason(&e))?;
        Ok(Self { jobs })
    }

    /// Executes a request.
    pub(crate) async fn call(&self, request: Request) -> Result<Reply, Error> {
        let gone = || Error::new(Code::NoEngine, "the engine has ended");
        let (answer, reply) = oneshot::channel();
        match self.jobs.try_send(Job { request, answer }) {
            Ok(()) => reply.await.map_err(|_| gone())?,
            Err(TrySendError::Full(_)) => {
                Err(Error::new(Code::TooMany, "too many requests wait for the engine"))
            }
            Err(TrySendError::Disconnected(_)) => Err(gone()),
        }
    }
}

/// Executes requests until the engine or this program ends.
fn carry(mut client: Client, jobs: &Receiver<Job>) {
    while let Ok(job) = jobs.recv() {
        if client.is_gone() {
            return;
        }
        let result = client.call(job.request).map_err(Error::from);
        // A session that has ended meanwhile needs no answer.
        drop(job.answer.send(result));
    }
}
