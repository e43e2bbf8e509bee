//! An engine in a dry run: components are created but never opened, threads declared but never run.

use crate::{ClockKind, Engine, Error, Options, graph::new_item::NewItem, name::Name};
use hal_protocol::{Class, ComponentState, Failure, Reply, Request, TicketInfo};

impl Engine {
    /// Creates an instance that executes a script and touches nothing outside: for `check`, `order`
    /// and `graph`. It has no socket, its clock does not move, `loadrt` creates components and
    /// never opens them, no stop action runs, nothing is recorded, and no process is ended. The
    /// owner may join as a program and create that program's pins.
    ///
    /// # Errors
    /// The system refuses.
    pub fn dry_run(mut options: Options) -> Result<Self, Failure> {
        options.clock = ClockKind::Virtual;
        options.hold = true;
        options.simulate = true;
        let mut engine = Self::without_socket(options)?;
        engine.runtime.set_dry_run();
        Ok(engine)
    }

    /// Handles a request that would reach outside or move the clock; returns `None` for all others.
    pub(crate) fn dry_run_reply(&mut self, request: &Request) -> Option<Result<Reply, Error>> {
        if !self.runtime.is_dry_run() {
            return None;
        }
        if let Request::Run { .. } = request {
            self.model.has_run();
        }
        let done = match request {
            Request::Ticket { .. } => return Some(Ok(Reply::Ticket(TicketInfo::Done))),
            _ if matches!(request.class(), Class::Wait | Class::Outside) => Ok(()),
            Request::Join { name, .. } => Name::parse("component", name)
                .and_then(|name| self.model.new_component(name, None, None, false))
                .map(|member| self.tried = Some(member)),
            Request::NewPin { name, ty, direction } => {
                let member = self.tried;
                let what = if direction.is_pin() { "pin" } else { "parameter" };
                member.ok_or(Error::NotAMember).and_then(|member| {
                    let new = NewItem {
                        name: Name::parse(what, name)?,
                        other: None,
                        ty: *ty,
                        direction: *direction,
                        initial: 0,
                        storage: None,
                        hidden: false,
                        times: false,
                        safety: false,
                        measured: false,
                        doc: self.model.doc(""),
                    };
                    self.model.new_item(member, new).map(|_| ())
                })
            }
            Request::Ready => {
                let member = self.tried.take();
                if let Some(c) = member.and_then(|ix| self.model.component_mut(ix)) {
                    c.state = ComponentState::Ready;
                }
                Ok(())
            }
            _ => return None,
        };
        Some(done.map(|()| Reply::Done))
    }
}
