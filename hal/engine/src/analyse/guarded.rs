//! Changes that people elsewhere may not make, found by the flow of values: through signals, and through functions by what
//! these declare, up to a component that takes commands or to one that drives the machine.

use crate::{
    Error,
    error::Guard,
    graph::{Component, Edge, Graph, Ix},
};
use hal_protocol::{Direction, Request, Type};
use petgraph::{Direction::Outgoing, visit::EdgeRef};
use std::collections::BTreeSet;

/// Refuses a request of a client that speaks for people elsewhere if it is not theirs to make.
///
/// Clients elsewhere begin and end motion by commands, which check the role, the lease and the stop epoch. A pin would pass
/// these checks by. `own`: the client's component, `may_end`: the client may end the instance.
pub(crate) fn permit(
    graph: &Graph,
    request: &Request,
    own: Option<Ix>,
    may_end: bool,
) -> Result<(), Error> {
    let flow = Flow { graph };
    match request {
        // Another reader changes no value.
        Request::Net { pins, .. }
            if !pins.is_empty() && pins.iter().all(|pin| flow.only_reads(own, pin)) =>
        {
            Ok(())
        }
        Request::Link { pin, .. } if flow.only_reads(own, pin) => Ok(()),
        Request::Set { name, .. } => flow.permit_item(name),
        Request::SetSignal { name, .. } => flow.permit_signal(name),
        Request::Net { signal, pins } => {
            flow.permit_signal(signal)?;
            pins.iter().try_for_each(|pin| flow.permit_item(pin))
        }
        Request::Link { pin, signal } => {
            flow.permit_signal(signal)?;
            flow.permit_item(pin)
        }
        Request::Unlink { pin } => flow.permit_item(pin),
        // They look, use their own component, and give commands.
        Request::NewSignal { .. }
        | Request::Hello { .. }
        | Request::Join { .. }
        | Request::NewPin { .. }
        | Request::Ready
        | Request::Unready
        | Request::Leave
        | Request::SharePins { .. }
        | Request::Sleep { .. }
        | Request::Poll { .. }
        | Request::Sample(_)
        | Request::SampleState { .. }
        | Request::EndSample { .. }
        | Request::AtEnd { .. }
        | Request::SpeakFromAfar
        | Request::MapSnapshot { .. }
        | Request::Ticket { .. }
        | Request::Idle { .. }
        | Request::Await { .. }
        | Request::Get { .. }
        | Request::GetSignal { .. }
        | Request::List { .. }
        | Request::Status
        | Request::Order
        | Request::Component { .. }
        | Request::FlightState
        | Request::Snapshot { .. }
        | Request::Check
        | Request::Command { .. } => Ok(()),
        Request::Shutdown if may_end => Ok(()),
        // The machine itself, its clock, and programs and files of this computer.
        Request::Shutdown
        | Request::Attach { .. }
        | Request::NewStream { .. }
        | Request::Run { .. }
        | Request::Load { .. }
        | Request::LoadForeign { .. }
        | Request::Unload { .. }
        | Request::UnloadAll
        | Request::DeleteSignal { .. }
        | Request::AddFunct { .. }
        | Request::RemoveFunct { .. }
        | Request::Start
        | Request::Alias { .. }
        | Request::Unalias { .. }
        | Request::SetLock { .. }
        | Request::ClearLock { .. }
        | Request::Stop
        | Request::Apply { .. }
        | Request::Timing { .. }
        | Request::MessageLevel { .. }
        | Request::Adopt { .. }
        | Request::EndProgram { .. }
        | Request::Record { .. }
        | Request::EndRecord
        | Request::Flight(_)
        | Request::EndFlight
        | Request::SaveFlight { .. } => Err(Error::NotFromAfar),
    }
}

/// The flow of values through a graph.
struct Flow<'g> {
    graph: &'g Graph,
}

impl Flow<'_> {
    /// Returns whether a name is that of a pin of this component which only reads.
    fn only_reads(&self, own: Option<Ix>, name: &str) -> bool {
        let Ok(ix) = self.graph.find_item(name) else { return false };
        let reads = self.graph.item(ix).is_some_and(|item| item.direction == Direction::In);
        reads && own == Some(self.loaded(ix))
    }

    /// Refuses a pin or parameter. A name that does not exist is refused later, with a better reason.
    fn permit_item(&self, name: &str) -> Result<(), Error> {
        let Ok(ix) = self.graph.find_item(name) else { return Ok(()) };
        let Some(item) = self.graph.item(ix) else { return Ok(()) };
        if item.direction.is_pin() {
            return self.permit("pin", name, vec![ix]);
        }
        // Parameters are settings, but for those of who decides, and of lines, which they invert.
        let owner = self.loaded(ix);
        let guard = if self.takes_commands(owner) { Some(Guard::Commands) } else { None };
        let drives = || self.component(owner).is_some_and(is_driver).then_some(Guard::Drives);
        let own = guard.or_else(drives).map(|guard| (owner, guard));
        // A setting of a gate or filter before an enable, a limit switch or an e-stop holds it as a pin there would. That of
        // what moves by itself, such as a limit of stepgen, is tuned.
        let elsewhere = || self.end(vec![ix], Some(Type::Bit)).filter(|(end, _)| *end != owner);
        match own.or_else(elsewhere) {
            Some((owner, guard)) if !item.times => {
                Err(self.refusal("parameter", name, owner, guard))
            }
            _ => Ok(()),
        }
    }

    fn permit_signal(&self, name: &str) -> Result<(), Error> {
        let signal = self.graph.signal_named(name);
        signal.map_or(Ok(()), |ix| self.permit("signal", name, self.readers_of(ix)))
    }

    /// Refuses what begins at these pins and leads to a component that guards.
    fn permit(&self, what: &'static str, name: &str, begin: Vec<Ix>) -> Result<(), Error> {
        match self.end(begin, None) {
            None => Ok(()),
            Some((owner, guard)) => Err(self.refusal(what, name, owner, guard)),
        }
    }

    fn refusal(&self, what: &'static str, name: &str, owner: Ix, guard: Guard) -> Error {
        let to = self.component(owner).map_or("", |c| c.name.as_str());
        Error::Guarded { what, name: name.into(), to: to.into(), guard }
    }

    /// Follows the values of pins, and behind those of `begin` only values of this type if there is one; returns the first
    /// component on their way that guards.
    fn end(&self, begin: Vec<Ix>, only: Option<Type>) -> Option<(Ix, Guard)> {
        let mut seen: BTreeSet<Ix> = begin.iter().copied().collect();
        let mut left = begin;
        while let Some(pin) = left.pop() {
            let Some(item) = self.graph.item(pin) else { continue };
            let mut next = Vec::new();
            if item.direction != Direction::Out
                && let Some(end) = self.enter(pin, &mut next)
            {
                return Some(end);
            }
            if item.direction != Direction::In {
                next.extend(self.graph.signal_of(pin).into_iter().flat_map(|s| self.readers_of(s)));
            }
            let is_followed = |pin: Ix| {
                only.is_none_or(|ty| self.graph.item(pin).is_some_and(|item| item.ty == ty))
            };
            left.extend(next.into_iter().filter(|pin| is_followed(*pin) && seen.insert(*pin)));
        }
        None
    }

    /// Follows a value into the component that reads it: returns the component if it guards, otherwise adds the pins that it
    /// writes with this value.
    fn enter(&self, pin: Ix, next: &mut Vec<Ix>) -> Option<(Ix, Guard)> {
        let owner = self.loaded(pin);
        let component = self.component(owner)?;
        if self.takes_commands(owner) {
            return Some((owner, Guard::Commands));
        }
        if is_driver(component) || component.foreign.is_some() {
            return Some((owner, Guard::Drives));
        }
        let readers = self.joined(pin, Edge::Reads);
        let is_unknown = |f: &Ix| self.graph.funct(*f).is_none_or(|funct| funct.unknown);
        if readers.is_empty() || readers.iter().any(is_unknown) {
            // A program, or a task of the control side: it may pass the value to each of its outputs.
            next.extend(self.graph.owned(owner).into_iter().filter(|ix| self.is_written(*ix)));
        }
        let takers = readers.iter().flat_map(|f| self.joined(*f, Edge::HandsOver));
        for funct in readers.iter().copied().chain(takers) {
            let written = self.joined(funct, Edge::Writes);
            let known = self.graph.funct(funct);
            if known.is_some_and(|f| f.told) {
                return Some((owner, Guard::Commands));
            }
            // What a fast function writes, such as steps, leaves the machine.
            if known.is_some_and(|f| f.fast) && written.iter().any(|ix| self.is_written(*ix)) {
                return Some((owner, Guard::Drives));
            }
            next.extend(written);
        }
        None
    }

    /// Returns whether a component takes commands: it offers some, or uses a service of one that does.
    fn takes_commands(&self, component: Ix) -> bool {
        let offers = |ix: Ix| self.component(ix).is_some_and(|c| !c.commands.is_empty());
        offers(component) || self.joined(component, Edge::Needs).into_iter().any(offers)
    }

    fn component(&self, ix: Ix) -> Option<&Component> {
        self.graph.component(ix)
    }

    /// Returns the component whose load created a node.
    fn loaded(&self, node: Ix) -> Ix {
        let mut owner = node;
        while let Some(above) = self.graph.owner_of(owner) {
            owner = above;
        }
        owner
    }

    fn readers_of(&self, signal: Ix) -> Vec<Ix> {
        let mut pins = self.graph.pins_of(signal);
        pins.retain(|pin| self.graph.item(*pin).is_some_and(|i| i.direction != Direction::Out));
        pins
    }

    /// Returns whether an item is a pin that its component writes.
    fn is_written(&self, item: Ix) -> bool {
        let item = self.graph.item(item);
        item.is_some_and(|i| matches!(i.direction, Direction::Out | Direction::Io))
    }

    /// Returns the nodes to which edges of this kind lead from this one.
    fn joined(&self, node: Ix, kind: Edge) -> Vec<Ix> {
        let edges = self.graph.g.edges_directed(node, Outgoing);
        edges.filter(|e| *e.weight() == kind).map(|e| e.target()).collect()
    }
}

/// Returns whether a component drives hardware lines, which is so if it declares a stop action.
fn is_driver(component: &Component) -> bool {
    !component.stops.is_empty()
}
