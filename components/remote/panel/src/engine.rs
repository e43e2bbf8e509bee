//! The connection to the engine: one thread that calls it, and answers whom it concerns.

use crate::error::{Code, Error};
use hal_protocol::{Client, Link as _, Place, Reply, Request};
use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
        mpsc::{Receiver, SyncSender, TrySendError, sync_channel},
    },
    thread,
};
use tokio::sync::oneshot;

/// Number of requests that wait for the engine.
const MAX_WAITING: usize = 256;
/// Number of further places, for what ends motion.
const MAX_STOPS: usize = 64;
/// Refusal of a command after a stop.
pub(crate) const STOPPED: &str = "a stop has come meanwhile: give the command again";

struct Job {
    request: Request,
    answer: oneshot::Sender<Result<Reply, Error>>,
}

/// The way to the engine, for all sessions.
#[derive(Clone, Debug)]
pub(crate) struct Engine {
    jobs: SyncSender<Job>,
    /// Number of requests that wait.
    waiting: Arc<AtomicUsize>,
    /// Number of stops so far. It is locked while a request joins those that wait.
    stops: Arc<Mutex<u64>>,
}

impl Engine {
    /// Connects, and starts the thread.
    pub(crate) fn join(place: Place) -> Result<Self, String> {
        let client = Client::connect(&place, "").map_err(|e| e.to_string())?;
        let (jobs, queue) = sync_channel(MAX_WAITING + MAX_STOPS);
        let waiting = Arc::new(AtomicUsize::new(0));
        let thread = thread::Builder::new().name("engine".to_owned());
        let left = waiting.clone();
        let begun = thread.spawn(move || serve(client, &queue, &left));
        begun.map_err(|e| hal_output::reason(&e))?;
        Ok(Self { jobs, waiting, stops: Arc::default() })
    }

    /// Returns the number of stops so far.
    pub(crate) fn stops(&self) -> u64 {
        *self.stops.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Executes a request.
    pub(crate) async fn call(&self, request: Request) -> Result<Reply, Error> {
        let waits = self.send(request, MAX_WAITING)?;
        waits.await.map_err(|_| gone())?
    }

    /// Executes a request, unless something has been stopped since there were this many stops.
    pub(crate) async fn call_unless_stopped(
        &self,
        request: Request,
        before: u64,
    ) -> Result<Reply, Error> {
        let waits = {
            let stops = self.stops.lock().unwrap_or_else(PoisonError::into_inner);
            if *stops != before {
                return Err(Error::new(Code::Conflict, STOPPED));
            }
            self.send(request, MAX_WAITING)?
        };
        waits.await.map_err(|_| gone())?
    }

    /// Executes a request that ends motion; with `work`, it also ends orders of which a part has not been sent.
    pub(crate) async fn stop(&self, request: Request, work: bool) -> Result<Reply, Error> {
        let waits = {
            let mut stops = self.stops.lock().unwrap_or_else(PoisonError::into_inner);
            *stops += u64::from(work);
            self.send(request, MAX_WAITING + MAX_STOPS)?
        };
        waits.await.map_err(|_| gone())?
    }

    fn send(&self, request: Request, most: usize) -> Result<PendingReply, Error> {
        let full = || Error::new(Code::TooMany, "too many requests wait for the engine");
        if self.waiting.fetch_add(1, Relaxed) >= most {
            self.waiting.fetch_sub(1, Relaxed);
            return Err(full());
        }
        let (answer, reply) = oneshot::channel();
        self.jobs.try_send(Job { request, answer }).map_err(|why| {
            self.waiting.fetch_sub(1, Relaxed);
            match why {
                TrySendError::Full(_) => full(),
                TrySendError::Disconnected(_) => gone(),
            }
        })?;
        Ok(reply)
    }
}

type PendingReply = oneshot::Receiver<Result<Reply, Error>>;

fn gone() -> Error {
    Error::new(Code::NoEngine, "the engine has ended")
}

/// Executes requests until the engine or this program ends.
fn serve(mut client: Client, jobs: &Receiver<Job>, waiting: &AtomicUsize) {
    while let Ok(job) = jobs.recv() {
        waiting.fetch_sub(1, Relaxed);
        if client.is_gone() {
            return;
        }
        let result = client.call(job.request).map_err(Error::from);
        // A session that has ended meanwhile needs no answer.
        drop(job.answer.send(result));
    }
}

#[cfg(test)]
mod tests {
    //! Stops, and requests that wait.

    use super::{
        Arc, AtomicUsize, Code, Engine, Error, Job, MAX_STOPS, MAX_WAITING, Relaxed, Reply,
        Request, sync_channel, thread,
    };
    use std::{
        pin::pin,
        task::{Context, Poll, Waker},
    };

    impl Engine {
        /// Returns the way to an engine that answers so.
        pub(crate) fn that(
            mut answer: impl FnMut(Request) -> Result<Reply, Error> + Send + 'static,
        ) -> Self {
            let (jobs, queue) = sync_channel::<Job>(MAX_WAITING + MAX_STOPS);
            let waiting = Arc::new(AtomicUsize::new(0));
            let left = waiting.clone();
            thread::spawn(move || {
                while let Ok(job) = queue.recv() {
                    left.fetch_sub(1, Relaxed);
                    drop(job.answer.send(answer(job.request)));
                }
            });
            Self { jobs, waiting, stops: Arc::default() }
        }
    }

    /// Sends a request; returns the refusal, or `None` while it waits for its answer.
    fn refusal(request: impl Future<Output = Result<Reply, Error>>) -> Option<Code> {
        match pin!(request).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Pending => None,
            Poll::Ready(end) => Some(end.unwrap_err().code),
        }
    }

    #[test]
    fn stops_end_what_is_half_sent_and_have_places_of_their_own() {
        let (jobs, queue) = sync_channel(MAX_WAITING + MAX_STOPS);
        let engine = Engine { jobs, waiting: Arc::default(), stops: Arc::default() };
        let before = engine.stops();
        assert_eq!(refusal(engine.call_unless_stopped(Request::Ready, before)), None);
        // The end of a jog ends no program that starts.
        assert_eq!(refusal(engine.stop(Request::Ready, false)), None);
        assert_eq!(refusal(engine.call_unless_stopped(Request::Ready, before)), None);
        assert_eq!(refusal(engine.stop(Request::Ready, true)), None);
        let late = engine.call_unless_stopped(Request::Ready, before);
        assert_eq!(refusal(late), Some(Code::Conflict));
        assert_eq!(refusal(engine.call_unless_stopped(Request::Ready, engine.stops())), None);
        for _ in 5..MAX_WAITING {
            assert_eq!(refusal(engine.call(Request::Ready)), None);
        }
        assert_eq!(refusal(engine.call(Request::Ready)), Some(Code::TooMany));
        assert_eq!(refusal(engine.stop(Request::Ready, true)), None);
        assert_eq!(queue.try_iter().count(), MAX_WAITING + 1);
    }
}
