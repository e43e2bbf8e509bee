//! The dispatcher of requests: each is handled as its class says, for clients and for scripts alike.

use crate::{
    Engine, Error,
    analyse::guarded,
    os,
    realtime::shared::MAX_TIME_NS,
    serve::client::{Client, Rights, WaitState},
    serve::session,
};
use hal_protocol::{ByClass, Class, Reply, Request, TicketInfo, WaitRequest};

/// The answer to a request.
#[derive(Debug)]
pub(crate) enum Answer {
    /// Given at once.
    Now(Reply),
    /// Given when a wait is over; true if the virtual clock runs meanwhile.
    After(WaitState, bool),
}

impl Engine {
    /// Handles a request of a client, or of the script if there is no client.
    pub(crate) fn dispatch(
        &mut self,
        request: Request,
        client: Option<&mut Client>,
    ) -> Result<Answer, Error> {
        let rights = client.as_ref().map_or(Rights::Own, |c| c.rights);
        let is_from_afar = rights > Rights::Own;
        if is_from_afar {
            let own = client.as_ref().and_then(|c| c.component);
            guarded::permit(self.model.graph(), &request, own, rights != Rights::Guest)?;
        }
        if let Some(reply) = self.dry_run_reply(&request) {
            return reply.map(Answer::Now);
        }
        if !matches!(request.class(), Class::Own | Class::Wait) {
            self.notice_fault();
        }
        match request.by_class() {
            ByClass::Own(request) => match client {
                Some(client) => session::own(self, client, request),
                None => self.own_of_script(request).map(Answer::Now),
            },
            ByClass::Wait(request) => self.wait(&request),
            ByClass::Edit(request) => self.edit(request).map(Answer::Now),
            ByClass::Query(request) => self.query(request).map(Answer::Now),
            ByClass::Action(request) => self.act(request, is_from_afar).map(Answer::Now),
            ByClass::Outside(request) => self.act_outside(request).map(Answer::Now),
        }
    }

    /// Handles a request that is answered after a wait.
    fn wait(&mut self, request: &WaitRequest) -> Result<Answer, Error> {
        let wall = |ms: u32| WaitState::Wall(os::monotonic_ns() + i64::from(ms) * 1_000_000);
        Ok(match *request {
            WaitRequest::Run { ns } => Answer::After(WaitState::Time(self.run_end(ns)?), false),
            WaitRequest::Ticket { id, wait } => match self.result(id)? {
                TicketInfo::Pending if wait => Answer::After(WaitState::Ticket(id), false),
                info => Answer::Now(Reply::Ticket(info)),
            },
            WaitRequest::Idle { ms, flow } => Answer::After(wall(ms), flow && !self.options.hold),
            WaitRequest::Await { ms, .. } => Answer::After(wall(ms), !self.options.hold),
        })
    }

    /// Returns the machine time at which a `run` of `ns` nanoseconds ends.
    fn run_end(&self, ns: u64) -> Result<i64, Error> {
        if !self.runtime.is_virtual() {
            return Err(Error::NotVirtual);
        }
        let now = self.runtime.now();
        let end = i64::try_from(ns).ok().and_then(|ns| now.checked_add(ns));
        end.filter(|end| *end <= MAX_TIME_NS).ok_or_else(|| Error::OutOfRange {
            what: "time",
            name: format!("{ns} ns").into(),
            expects: "the virtual clock ends after 146 years",
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{ClockKind, Engine, Options, serve::dispatch::Answer};
    use hal_protocol::{Edit, Place, Reply, Request, Type};

    fn engine() -> Engine {
        let options = Options {
            hold: false,
            ..Options::simulated(
                Place::at(std::env::temp_dir(), "dispatch").unwrap(),
                ClockKind::Virtual,
            )
        };
        Engine::without_socket(options).unwrap()
    }

    #[test]
    fn only_edits_can_be_lines_of_an_applied_file() {
        let apply = |request: Request| {
            let edits = vec![Edit { file: 0, line: 1, request }];
            let reply = engine()
                .dispatch(Request::Apply { files: vec!["a.hal".into()], edits, dry: false }, None);
            match reply {
                Ok(Answer::Now(Reply::Refused { failure, .. })) => failure.text,
                other => format!("{other:?}"),
            }
        };
        let refused = "this does not change the graph";
        for request in [
            Request::Status,
            Request::Ready,
            Request::Stop,
            Request::EndRecord,
            Request::Run { ns: 1 },
        ] {
            assert!(apply(request.clone()).contains(refused), "{request:?}");
        }
        let edit = Request::NewSignal { name: "a".into(), ty: Type::Bit };
        assert!(apply(edit).contains("Applied"));
    }
}
