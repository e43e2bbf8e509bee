//! The dispatcher of requests: each is handled as its class says, for clients and for scripts alike.

use crate::{
    Engine, Error, os,
    realtime::shared::MAX_TIME_NS,
    serve::client::{Client, WaitState},
    serve::session,
};
use hal_protocol::{Class, Reply, Request, TicketInfo};

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
        let class = request.class();
        if let Some(reply) = self.try_only(&request) {
            return reply.map(Answer::Now);
        }
        if !matches!(class, Class::Own | Class::Wait) {
            self.notice_fault();
        }
        match class {
            Class::Own => match client {
                Some(client) => session::own(self, client, request),
                None => self.own_of_script(request).map(Answer::Now),
            },
            Class::Wait => self.wait(&request),
            Class::Edit => self.edit(&request).map(Answer::Now),
            Class::Query => self.query(request).map(Answer::Now),
            Class::Action => self.act(request).map(Answer::Now),
            Class::Outside => self.act_outside(request).map(Answer::Now),
        }
    }

    /// Handles a request that is answered after a wait.
    fn wait(&mut self, request: &Request) -> Result<Answer, Error> {
        let wall = |ms: u32| WaitState::Wall(os::monotonic_ns() + i64::from(ms) * 1_000_000);
        Ok(match *request {
            Request::Run { ns } => Answer::After(WaitState::Time(self.run_end(ns)?), false),
            Request::Ticket { id, wait } => match self.result(id)? {
                TicketInfo::Pending if wait => Answer::After(WaitState::Ticket(id), false),
                info => Answer::Now(Reply::Ticket(info)),
            },
            Request::Idle { ms, flow } => Answer::After(wall(ms), flow && !self.options.hold),
            Request::Await { ms, .. } => Answer::After(wall(ms), !self.options.hold),
            _ => return Err(misplaced()),
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

/// Returns the error for a request that the code for its class does not know.
pub(crate) fn misplaced() -> Error {
    Error::Protocol { why: "this engine has no code for this request".into() }
}

#[cfg(test)]
mod tests {
    use super::misplaced;
    use crate::{
        ClockKind, Engine, Error, Options,
        serve::{client::Client, dispatch::Answer},
    };
    use hal_protocol::{Class, Failure, Place, Request};
    use std::{collections::BTreeSet, os::unix::net::UnixStream};

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

    /// Returns one request of each kind, as clients write them.
    fn requests() -> Vec<Request> {
        let lines = r#"
            {"hello": {"protocol": 0, "name": "", "pid": 0}}
            {"join": {"name": "a", "poll_ns": 0}}
            {"new-pin": {"name": "a", "ty": "bit", "direction": "in"}}
            "ready"
            "unready"
            "leave"
            {"share-pins": {"pins": 1}}
            {"sleep": {"ns": 1}}
            {"poll": {"writes": []}}
            {"attach": {"name": "a"}}
            {"sample": {"names": ["a"], "thread": null, "every": 1, "depth": 0, "wait": false}}
            {"sample-state": {"id": 1}}
            {"end-sample": {"id": 1}}
            {"map-snapshot": {"name": "a"}}
            {"run": {"ns": 1}}
            {"ticket": {"id": 1, "wait": true}}
            {"idle": {"ms": 1, "flow": false}}
            {"await": {"ms": 1, "pid": 1}}
            {"load": {"module": "a", "args": []}}
            {"load-foreign": {"module": "a", "args": [], "prefix": ""}}
            {"unload": {"name": "a"}}
            "unload-all"
            {"new-signal": {"name": "a", "ty": "bit"}}
            {"delete-signal": {"name": null}}
            {"net": {"signal": "b", "pins": ["a"]}}
            {"link": {"pin": "a", "signal": "b"}}
            {"unlink": {"pin": "a"}}
            {"set": {"name": "a", "value": "1"}}
            {"set-signal": {"name": "a", "value": "1"}}
            {"add-funct": {"funct": "a", "thread": "b", "position": -1, "init": false}}
            {"remove-funct": {"funct": "a", "thread": null}}
            "start"
            {"alias": {"param": false, "name": "a", "alias": "b"}}
            {"unalias": {"param": false, "name": "a"}}
            {"set-lock": {"level": 0}}
            {"clear-lock": {"bits": 0}}
            {"get": {"name": "a"}}
            {"get-signal": {"name": "a"}}
            {"list": {"kind": "pins", "patterns": [], "ty": null}}
            "status"
            "order"
            {"component": {"name": "a"}}
            "flight-state"
            {"snapshot": {"name": "a"}}
            "check"
            {"apply": {"files": [], "edits": [], "dry": true}}
            "stop"
            {"timing": {"thread": null, "on": true}}
            {"message-level": {"level": 3}}
            {"command": {"name": "a.b", "args": []}}
            {"adopt": {"pid": 0, "program": "a"}}
            {"end-program": {"name": "a"}}
            {"record": {"path": "/", "patterns": []}}
            "end-record"
            {"flight": {"bytes": 1, "before_ns": null, "after_ns": 0, "file": null, "when": []}}
            "end-flight"
            {"save-flight": {"path": "/", "last": false}}
            "shutdown"
        "#;
        let lines = || lines.lines().map(str::trim).filter(|l| !l.is_empty());
        // The error for an unknown request lists all kinds.
        let kinds = serde_json::from_str::<Request>("\"unknown\"").unwrap_err().to_string();
        let kinds: BTreeSet<&str> = kinds.split('`').skip(3).step_by(2).collect();
        let listed: BTreeSet<&str> = lines().filter_map(|l| l.split('"').nth(1)).collect();
        assert_eq!(listed, kinds, "requests without a line here");
        lines().map(|l| serde_json::from_str(l).unwrap_or_else(|e| panic!("{l}: {e}"))).collect()
    }

    #[test]
    fn each_request_is_known_to_the_code_of_its_class() {
        let unknown = Failure::from(misplaced()).text;
        let said = |e: Error| Failure::from(e).text;
        let mut classes = Vec::new();
        for request in requests() {
            let (mut engine, shown) = (engine(), format!("{request:?}"));
            let (near, _far) = UnixStream::pair().unwrap();
            let mut client = Client::new(1, near);
            let class = request.class();
            classes.push(class);
            match engine.dispatch(request.clone(), Some(&mut client)) {
                Ok(Answer::After(..)) => {
                    assert!(class == Class::Wait, "{shown}");
                }
                Ok(Answer::Now(_)) => {}
                Err(e) => assert_ne!(said(e), unknown, "{shown}"),
            }
            // A line of a script that is not an edit is refused as a whole.
            let staged = engine.transact(|e| e.stage(&request)).err().map(said);
            let refused = staged.is_some_and(|text| text.contains("does not change the graph"));
            assert_eq!(refused, class != Class::Edit, "{shown}");
        }
        for class in
            [Class::Own, Class::Wait, Class::Edit, Class::Query, Class::Action, Class::Outside]
        {
            assert!(classes.contains(&class), "{class:?}");
        }
    }
}
