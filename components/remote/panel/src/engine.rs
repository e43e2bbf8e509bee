//! The connection to the engine: one thread that calls it, and answers whom it concerns.

mod line;

use crate::error::{Code, Error};
use hal_protocol::{
    Answer, Client, Failure, Link as _, Orders, Place, Reply, Request, Stop, Unlisted,
};
use line::{Job, Next, PendingReply, RequestLine};
use std::{
    fmt, io,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};
use tokio::time::Instant;

/// Time between two looks at the components of the machine.
const LOOK: Duration = Duration::from_secs(1);
/// Refusal of a command after a stop.
pub(crate) const STOPPED: &str = "a stop has come meanwhile: give the command again";

/// A stop, which goes before everything that waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// A stop of the whole machine.
    Machine(Stop),
    /// A command that stops a robot alone.
    Robot(&'static str),
}

impl Ending {
    /// All of them, in the order in which they are sent.
    pub(crate) const ALL: [Self; 6] = [
        Self::Machine(Stop::Estop),
        Self::Machine(Stop::Off),
        Self::Machine(Stop::Abort),
        Self::Robot("robot.stop"),
        Self::Machine(Stop::Pause),
        Self::Robot("robot.pause"),
    ];

    fn requests(self, orders: &Orders) -> Vec<Request> {
        match self {
            Self::Machine(stop) => orders.stops().requests(stop).collect(),
            Self::Robot(name) => {
                vec![Request::Command { name: name.to_owned(), args: Vec::new() }]
            }
        }
    }
}

/// Reason why this program has no way to the engine, or none to its machine.
#[derive(Debug)]
pub(crate) enum Unjoined {
    /// There is no engine, or it refuses the client.
    Connect(Failure),
    /// The engine refuses to list its commands, or has ended.
    List(Error),
    /// The commands are not those of a machine that can be commanded.
    Unlisted(Unlisted),
    /// The thread cannot begin.
    Thread(io::Error),
}

impl fmt::Display for Unjoined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connect(why) => why.fmt(f),
            Self::List(why) => f.write_str(&why.text),
            Self::Unlisted(why) => why.fmt(f),
            Self::Thread(why) => f.write_str(&hal_output::reason(why)),
        }
    }
}

/// Answers of the machine to a stop: each command that was sent, with its end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stopped(pub(crate) Vec<(String, Result<Answer, Error>)>);

#[derive(Debug)]
struct Shared {
    line: Mutex<RequestLine>,
    /// Notified when something joins the line.
    joined: Condvar,
    orders: Mutex<Known>,
}

/// Commands of the machine.
#[derive(Debug)]
struct Known {
    orders: Arc<Orders>,
    /// Components that were loaded when they were found.
    components: Vec<(u32, String)>,
    /// Reason why they are those of a machine that has changed since.
    outdated: Option<String>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Takes what comes next, and waits for it.
    fn next(&self) -> Next {
        let mut line = lock(&self.line);
        loop {
            line = match line.next(Instant::now()) {
                Next::Wait(None) => self.joined.wait(line).unwrap_or_else(PoisonError::into_inner),
                Next::Wait(Some(time)) => {
                    let waited = self.joined.wait_timeout(line, time);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
                next => return next,
            }
        }
    }
}

/// The way to the engine, for all sessions.
#[derive(Clone, Debug)]
pub(crate) struct Engine(Arc<Ends>);

/// Ends the thread with the last way to it.
#[derive(Debug)]
struct Ends(Arc<Shared>);

impl Drop for Ends {
    fn drop(&mut self) {
        lock(&self.0.line).end();
        self.0.joined.notify_all();
    }
}

impl Engine {
    /// Connects for those who have signed in, and starts the thread. The engine refuses them what is not changed from afar.
    ///
    /// # Errors
    /// There is no engine, or the machine moves and cannot be stopped.
    pub(crate) fn join(place: &Place) -> Result<Self, Unjoined> {
        Self::on(Client::connect_from_afar(place).map_err(Unjoined::Connect)?)
    }

    /// Connects for links that this program makes by itself, and starts the thread.
    ///
    /// # Errors
    /// As [`Self::join`].
    pub(crate) fn join_for_wiring(place: &Place) -> Result<Self, Unjoined> {
        Self::on(Client::connect(place, "").map_err(Unjoined::Connect)?)
    }

    fn on(mut client: Client) -> Result<Self, Unjoined> {
        let mut call = move |request: Request| {
            (!client.is_gone()).then(|| client.call(request).map_err(Error::from))
        };
        let components = components(&mut call).unwrap_or_default();
        let orders = orders(&mut call)?;
        Self::start(orders, components, call)
    }

    fn start(
        orders: Orders,
        components: Vec<(u32, String)>,
        call: impl FnMut(Request) -> Option<Result<Reply, Error>> + Send + 'static,
    ) -> Result<Self, Unjoined> {
        let known = Known { orders: Arc::new(orders), components, outdated: None };
        let shared = Arc::new(Shared {
            line: Mutex::default(),
            joined: Condvar::new(),
            orders: Mutex::new(known),
        });
        let engine = Self(Arc::new(Ends(shared.clone())));
        let thread = thread::Builder::new().name("engine".to_owned());
        let begun = thread.spawn(move || serve(&shared, call));
        begun.map_err(Unjoined::Thread)?;
        Ok(engine)
    }

    fn line(&self) -> MutexGuard<'_, RequestLine> {
        lock(&self.0.0.line)
    }

    /// Returns the commands of the machine.
    pub(crate) fn orders(&self) -> Arc<Orders> {
        lock(&self.0.0.orders).orders.clone()
    }

    /// Returns why the machine cannot be stopped any more, if it has changed so.
    pub(crate) fn outdated(&self) -> Option<String> {
        lock(&self.0.0.orders).outdated.clone()
    }

    /// Returns the number of stops so far.
    pub(crate) fn stops(&self) -> u64 {
        self.line().stops()
    }

    /// Executes a request.
    pub(crate) async fn call(&self, request: Request) -> Result<Reply, Error> {
        self.answered(|line| line.join(request, None)).await
    }

    /// Executes a request, unless something has been stopped since there were this many stops.
    pub(crate) async fn call_unless_stopped(
        &self,
        request: Request,
        before: u64,
    ) -> Result<Reply, Error> {
        self.answered(|line| line.join(request, Some(before))).await
    }

    /// Executes a request that ends jogs alone, in the order of the requests, and for which there is always room.
    pub(crate) async fn end_jogs(&self, request: Request) -> Result<Reply, Error> {
        self.answered(|line| line.join_end(request)).await
    }

    async fn answered(
        &self,
        join: impl FnOnce(&mut RequestLine) -> Result<PendingReply, Error>,
    ) -> Result<Reply, Error> {
        let waits = join(&mut self.line())?;
        self.0.0.joined.notify_all();
        waits.await.map_err(|_| gone())?
    }

    /// Asks for a stop whose answer nobody reads.
    pub(crate) fn ask_stop(&self, ending: Ending) -> Result<(), Error> {
        drop(self.line().stop(ending)?);
        self.0.0.joined.notify_all();
        Ok(())
    }

    /// Stops: before everything that waits, which is refused if it begins motion. One that is asked for again before it is sent
    /// is one, and none is lost.
    pub(crate) async fn stop(&self, ending: Ending) -> Result<Stopped, Error> {
        let waits = self.line().stop(ending)?;
        self.0.0.joined.notify_all();
        waits.await.map_err(|_| gone())
    }
}

fn gone() -> Error {
    Error::new(Code::NoEngine, "the engine has ended")
}

/// Lists the components of the machine.
fn components(
    call: &mut impl FnMut(Request) -> Option<Result<Reply, Error>>,
) -> Option<Vec<(u32, String)>> {
    let list =
        Request::List { kind: hal_protocol::Kind::Components, patterns: Vec::new(), ty: None };
    match call(list)? {
        // Programs come and go, and have no commands.
        Ok(Reply::Components(list)) => {
            Some(list.into_iter().filter(|c| c.realtime).map(|c| (c.id, c.name)).collect())
        }
        _ => None,
    }
}

/// Finds the commands of the machine.
fn orders(
    call: &mut impl FnMut(Request) -> Option<Result<Reply, Error>>,
) -> Result<Orders, Unjoined> {
    let answer = call(Orders::list()).ok_or_else(gone).flatten().map_err(Unjoined::List)?;
    Orders::listed(&answer).map_err(Unjoined::Unlisted)
}

/// Executes requests until the engine or this program ends.
fn serve(shared: &Shared, mut call: impl FnMut(Request) -> Option<Result<Reply, Error>>) {
    let mut looked = Instant::now();
    loop {
        match shared.next() {
            Next::Stop(ending, waiting) => {
                let Some(stopped) = stop(shared, ending, &mut call) else { break };
                looked = Instant::now();
                for answer in waiting {
                    // A session that has ended meanwhile needs no answer.
                    drop(answer.send(stopped.clone()));
                }
            }
            Next::Job(Job { request, answer, .. }) => {
                if looked.elapsed() >= LOOK {
                    look(shared, &mut call);
                    looked = Instant::now();
                }
                let Some(result) = call(request) else { break };
                drop(answer.send(result));
            }
            Next::Refuse(job) => {
                drop(job.answer.send(Err(Error::new(Code::Conflict, STOPPED))));
            }
            Next::Wait(_) | Next::End => break,
        }
    }
    lock(&shared.line).end();
}

/// Sends a stop as a whole, whatever is refused of it. A machine that has changed since its commands were found gets the rest too.
fn stop(
    shared: &Shared,
    ending: Ending,
    call: &mut impl FnMut(Request) -> Option<Result<Reply, Error>>,
) -> Option<Stopped> {
    let mut stopped = Stopped::default();
    send(ending, &lock(&shared.orders).orders.clone(), &mut stopped, call)?;
    if look(shared, call) {
        send(ending, &lock(&shared.orders).orders.clone(), &mut stopped, call)?;
    }
    Some(stopped)
}

fn send(
    ending: Ending,
    orders: &Orders,
    stopped: &mut Stopped,
    call: &mut impl FnMut(Request) -> Option<Result<Reply, Error>>,
) -> Option<()> {
    for request in ending.requests(orders) {
        let Request::Command { name, .. } = &request else { continue };
        let name = name.clone();
        if stopped.0.iter().any(|(sent, end)| *sent == name && end.is_ok()) {
            continue;
        }
        let end = call(request)?.map(|reply| match reply {
            Reply::Answer(answer) => answer,
            _ => Answer { lines: Vec::new(), ticket: None, awaited: false },
        });
        stopped.0.retain(|(sent, _)| *sent != name);
        stopped.0.push((name, end));
    }
    Some(())
}

/// Finds the commands of the machine again if its components have changed; returns whether they have.
fn look(shared: &Shared, call: &mut impl FnMut(Request) -> Option<Result<Reply, Error>>) -> bool {
    let Some(components) = components(call) else { return false };
    if lock(&shared.orders).components == components {
        return false;
    }
    let found = orders(call);
    let mut known = lock(&shared.orders);
    known.components = components;
    match found {
        Ok(orders) => {
            known.orders = Arc::new(orders);
            known.outdated = None;
        }
        Err(why) => known.outdated = Some(why.to_string()),
    }
    true
}

#[cfg(test)]
pub(crate) mod tests;
