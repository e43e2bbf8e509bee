//! The order of functions that their data flow implies, what the user's own order costs, and how
//! long values wait on their way through the machine.
//!
//! `addf` stays the user's: nothing here changes anything. Whoever wants findings asks
//! [`Study::of`] once, and then:
//!
//! - [`Study::late`]: each flow that costs a cycle in the user's order, and whether another order
//!   would spare it;
//! - [`Study::moves`]: which functions would have to go where, thread by thread;
//! - [`Timed::loops`] of [`Study::as_added`]: the feedback loops with their delay;
//! - [`Study::crossings`]: the flows from one thread to another.
//!
//! All of them speak in numbers of [`Machine::functs`] and [`Machine::flows`], whose nodes name
//! everything in the graph. [`Engine::order`](crate::Engine::order) says the same with names and
//! places, as `halcmd order` prints it.

mod delay;
mod draw;
mod machine;
mod row;
mod say;
mod sort;

pub(crate) use delay::{Chain, Timed, Wait};
pub(crate) use machine::{By, Flow, Machine};

use crate::graph::Graph;
use row::Row;

/// A machine, and a better order for each of its threads: the user's own unless another costs less.
#[derive(Debug)]
pub(crate) struct Study {
    pub(crate) machine: Machine,
    /// Numbers of functions, for each thread.
    pub(crate) better: Vec<Vec<usize>>,
}

/// A flow that goes backwards in the user's order: its reader has what was written a cycle ago.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Late {
    /// The number of the flow.
    pub(crate) flow: usize,
    /// In the better order it is late as well: it closes a feedback loop.
    pub(crate) remains: bool,
}

/// Where a function would have to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Move {
    /// Its number.
    pub(crate) funct: usize,
    /// Its position for `addf`, when all that move were taken out first and the moves are carried
    /// out in their order.
    pub(crate) position: usize,
}

impl Study {
    /// Studies the machine of a graph. It takes time in proportion to what is linked.
    pub(crate) fn of(graph: &Graph) -> Self {
        Self::new(Machine::of(graph))
    }

    /// Studies a machine.
    pub(crate) fn new(machine: Machine) -> Self {
        let better = (0..machine.threads.len()).map(|t| better(&machine, t)).collect();
        Self { machine, better }
    }

    /// The waits in the user's order.
    pub(crate) fn as_added(&self) -> Timed<'_> {
        let orders: Vec<Vec<usize>> =
            self.machine.threads.iter().map(|t| t.order.clone()).collect();
        Timed::new(&self.machine, &orders)
    }

    /// The waits in the better order.
    pub(crate) fn as_better(&self) -> Timed<'_> {
        Timed::new(&self.machine, &self.better)
    }

    /// What the user's order makes late, in the order in which it should be written.
    pub(crate) fn late(&self) -> Vec<Late> {
        let (user, better) = (self.as_added(), self.as_better());
        let flows = self.machine.flows.iter().enumerate();
        let late = flows.filter(|(_, flow)| user.is_late(flow));
        let mut late: Vec<_> =
            late.map(|(i, flow)| (better.place(flow.from), i, better.is_late(flow))).collect();
        late.sort_unstable();
        late.into_iter().map(|(_, flow, remains)| Late { flow, remains }).collect()
    }

    /// What would have to move in a thread; empty where no order is better.
    pub(crate) fn moves(&self, thread: usize) -> Vec<Move> {
        let (Some(user), Some(better)) =
            (self.machine.threads.get(thread), self.better.get(thread))
        else {
            return Vec::new();
        };
        let place = Row::places(&user.order, self.machine.functs.len());
        let places: Vec<usize> = better.iter().map(|f| place.at(*f)).collect();
        let stay = sort::standing(&places);
        let moved = better.iter().zip(&places).enumerate();
        moved
            .filter(|(_, (_, place))| stay.binary_search(place).is_err())
            .map(|(at, (funct, _))| Move { funct: *funct, position: at + 1 })
            .collect()
    }

    /// The numbers of the flows from one thread to another.
    pub(crate) fn crossings(&self) -> Vec<usize> {
        let flows = self.machine.flows.iter().enumerate();
        flows.filter(|(_, flow)| !self.machine.is_inside(flow)).map(|(i, _)| i).collect()
    }
}

/// The better order of a thread.
fn better(machine: &Machine, thread: usize) -> Vec<usize> {
    let Some(order) = machine.threads.get(thread).map(|t| &t.order) else { return Vec::new() };
    let place = Row::places(order, machine.functs.len());
    let inside =
        |a: usize, b: usize| machine.thread_of(a) == thread && machine.thread_of(b) == thread;
    let flows = machine.flows.iter().filter(|f| inside(f.from, f.to));
    let flows = flows.map(|f| (place.at(f.from), place.at(f.to), f.weight()));
    let fixed = machine.fixed.iter().filter(|(a, b)| inside(*a, *b));
    let fixed = fixed.map(|(a, b)| (place.at(*a), place.at(*b), sort::FIXED));
    let arcs: Vec<sort::Arc> = flows.chain(fixed).collect();
    let sorted = sort::sorted(order.len(), &arcs);
    sorted.into_iter().filter_map(|at| order.get(at)).copied().collect()
}

#[cfg(test)]
mod tests;
