//! The service `iocontrol`: the requests of the worker that controls jobs.

use crate::{
    changer::Tool,
    estop::{self, Shared},
    pins::Pins,
    task::Request,
};
use hal_component::{
    Gives, IoControl, IoRequest, IoResult, IoState, Receiver, Sender, TicketHandle, Touch, Uses,
};
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, Ordering::Relaxed},
};

/// Number of results that can wait; requests are refused beyond it.
pub(crate) const RESULTS: usize = 64;

/// Receiver of the result of a request.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reply {
    /// A user's command.
    Ticket(TicketHandle),
    /// A request of the service, with its number.
    Service(u64),
}

/// Reports results of requests.
#[derive(Clone, Debug)]
pub(crate) struct Results(pub(crate) Sender<IoResult>);

impl Results {
    /// Reports that a request has succeeded.
    pub(crate) fn done(&self, reply: Reply) {
        match reply {
            Reply::Ticket(ticket) => ticket.done(),
            Reply::Service(id) => self.send(id, None),
        }
    }

    /// Reports that a request has failed.
    pub(crate) fn fail(&self, reply: Reply, why: &'static str) {
        match reply {
            Reply::Ticket(ticket) => ticket.fail(why),
            Reply::Service(id) => self.send(id, Some(why)),
        }
    }

    fn send(&self, id: u64, failure: Option<&'static str>) {
        // The service admits no more requests than results have space.
        self.0.send(IoResult { id, failure }).unwrap_or_default();
    }
}

impl Touch for Results {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

/// The service.
pub(crate) struct Service {
    pub(crate) pins: Pins,
    pub(crate) shared: Gives<Shared>,
    pub(crate) to: Sender<(Request, Reply)>,
    results: Mutex<Receiver<IoResult>>,
    /// Number of the last request.
    last: AtomicU64,
    /// Number of results taken.
    taken: AtomicU64,
}

impl Service {
    pub(crate) const fn new(
        pins: Pins,
        shared: Gives<Shared>,
        to: Sender<(Request, Reply)>,
        results: Receiver<IoResult>,
    ) -> Self {
        let (last, taken) = (AtomicU64::new(0), AtomicU64::new(0));
        Self { pins, shared, to, results: Mutex::new(results), last, taken }
    }

    fn ask(&self, request: IoRequest) -> Request {
        match request {
            IoRequest::Estop => {
                estop::command(&self.shared, &self.pins);
                Request::Estop { reads: self.shared.reads() }
            }
            IoRequest::EstopReset => Request::EstopReset { stops: self.shared.stops() },
            IoRequest::Prepare { tool, pocket, index } => {
                Request::Prepare(Tool { number: tool, pocket, index })
            }
            IoRequest::Change => Request::Change,
            IoRequest::SetTool { tool, pocket } => {
                Request::SetTool(Tool { number: tool, pocket, index: pocket })
            }
            IoRequest::Coolant { mist, flood, lube } => Request::Coolant { mist, flood, lube },
            IoRequest::Abort => Request::Abort,
        }
    }
}

impl IoControl for Service {
    fn request(&self, request: IoRequest) -> Option<u64> {
        // The e-stop takes effect even if its result cannot be reported.
        let ask = self.ask(request);
        // Several workers may ask at once: this lock lets each have its own number.
        let results = self.results.lock().unwrap_or_else(PoisonError::into_inner);
        let last = self.last.load(Relaxed);
        if last - self.taken.load(Relaxed) >= RESULTS as u64 {
            return None;
        }
        let id = last + 1;
        self.to.send((ask, Reply::Service(id))).ok()?;
        self.last.store(id, Relaxed);
        drop(results);
        Some(id)
    }

    fn result(&self) -> Option<IoResult> {
        let result = self.results.lock().unwrap_or_else(PoisonError::into_inner).take();
        self.taken.fetch_add(u64::from(result.is_some()), Relaxed);
        result
    }

    fn state(&self) -> IoState {
        let p = &self.pins;
        IoState {
            estop: estop::state(&self.shared, p.emc_enable_in),
            mist: p.coolant_mist.get(),
            flood: p.coolant_flood.get(),
            lube: p.lube.get(),
            lube_level: p.lube_level.get(),
            tool: p.tool_number.get(),
            pocket: p.tool_from_pocket.get(),
            prepared: p.tool_prep_number.get(),
        }
    }
}

impl Touch for Service {
    fn touch(&self, uses: &mut Uses) {
        self.pins.touch(uses);
    }
}
