//! The order of functions that their data flow implies, the cost of the user's own order, and the
//! delays of values on their path through the machine.
//!
//! This module changes nothing: the order of `addf` remains the user's decision. Call [`Study::of`]
//! once; its results are:
//!
//! - [`Study::late`]: each flow that costs a cycle in the user's order, and whether another order
//!   would avoid that;
//! - [`Study::moves`]: for each thread, the functions that would have to move, and their new
//!   positions;
//! - [`Timed::loops`] of [`Study::as_added`]: the feedback loops with their delays;
//! - [`Study::crossings`]: the flows from one thread to another.
//!
//! All results are indices into [`Machine::functs`] and [`Machine::flows`], whose entries refer to
//! nodes of the graph. [`Engine::order`](crate::Engine::order) returns the same with names and
//! script positions, as `halcmd order` prints it.

mod by_index;
mod delay;
mod draw;
mod flow_graph;
mod say;
mod sort;

pub(crate) use delay::{Chain, Timed, Wait};
pub(crate) use flow_graph::{By, Flow, FlowGraph};

use crate::graph::Graph;
use by_index::ByIndex;

/// A machine, and the best order found for each of its threads: the user's own unless another costs
/// less.
#[derive(Debug)]
pub(crate) struct Study {
    pub(crate) machine: FlowGraph,
    /// Indices of functions in their better order, for each thread.
    pub(crate) better: Vec<Vec<usize>>,
}

/// A flow that goes backwards in the user's order: its reader gets the value of the previous cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Late {
    /// Index of the flow.
    pub(crate) flow: usize,
    /// True if the flow is also late in the better order, because it closes a feedback loop.
    pub(crate) remains: bool,
}

/// New position of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Move {
    /// Index of the function.
    pub(crate) funct: usize,
    /// Position for `addf`, if first all functions that move are removed, and then the moves are
    /// made in order.
    pub(crate) position: usize,
}

impl Study {
    /// Analyses the machine of a graph. The run time is proportional to the number of links.
    pub(crate) fn of(graph: &Graph) -> Self {
        Self::new(FlowGraph::of(graph))
    }

    /// Analyses a machine.
    pub(crate) fn new(machine: FlowGraph) -> Self {
        let better = (0..machine.threads.len()).map(|t| better(&machine, t)).collect();
        let mut study = Self { machine, better };
        study.keep_loops_short();
        study
    }

    /// Takes the better orders back that make a value of a feedback loop wait longer than it does in the user's order.
    fn keep_loops_short(&mut self) {
        let loops: Vec<Vec<usize>> =
            self.as_added().loops().list.into_iter().map(|l| l.flows).collect();
        loop {
            let (user, better) = (self.as_added(), self.as_better());
            let longer = loops.iter().find(|flows| better.along(flows) > user.along(flows));
            let of = |i: &usize| Some(self.machine.thread_of(self.machine.flows.get(*i)?.from));
            let threads: Vec<usize> = longer.into_iter().flatten().filter_map(of).collect();
            let order = |t: &usize| Some((*t, self.machine.threads.get(*t)?.order.clone()));
            let user_orders: Vec<(usize, Vec<usize>)> = threads.iter().filter_map(order).collect();
            // With the user's orders in all of its threads, a loop is not longer.
            if user_orders.is_empty() {
                break;
            }
            for (thread, order) in user_orders {
                if let Some(better) = self.better.get_mut(thread) {
                    *better = order;
                }
            }
        }
    }

    /// Returns the flows that are late in the better order alone.
    pub(crate) fn later(&self) -> Vec<usize> {
        let (user, better) = (self.as_added(), self.as_better());
        let flows = self.machine.flows.iter().enumerate();
        let later = flows.filter(|(_, flow)| better.is_late(flow) && !user.is_late(flow));
        later.map(|(i, _)| i).collect()
    }

    /// Returns the delays in the user's order.
    pub(crate) fn as_added(&self) -> Timed<'_> {
        let orders: Vec<Vec<usize>> =
            self.machine.threads.iter().map(|t| t.order.clone()).collect();
        Timed::new(&self.machine, &orders)
    }

    /// Returns the delays in the better order.
    pub(crate) fn as_better(&self) -> Timed<'_> {
        Timed::new(&self.machine, &self.better)
    }

    /// Returns the flows that are late in the user's order, in the better order of their writers.
    pub(crate) fn late(&self) -> Vec<Late> {
        let (user, better) = (self.as_added(), self.as_better());
        let flows = self.machine.flows.iter().enumerate();
        let late = flows.filter(|(_, flow)| user.is_late(flow));
        let mut late: Vec<_> =
            late.map(|(i, flow)| (better.place(flow.from), i, better.is_late(flow))).collect();
        late.sort_unstable();
        late.into_iter().map(|(_, flow, remains)| Late { flow, remains }).collect()
    }

    /// Returns the moves in a thread. Empty if no order is better.
    pub(crate) fn moves(&self, thread: usize) -> Vec<Move> {
        let (Some(user), Some(better)) =
            (self.machine.threads.get(thread), self.better.get(thread))
        else {
            return Vec::new();
        };
        let place = ByIndex::places(&user.order, self.machine.functs.len());
        let places: Vec<usize> = better.iter().map(|f| place.at(*f)).collect();
        let stay = sort::unmoved(&places);
        let moved = better.iter().zip(&places).enumerate();
        moved
            .filter(|(_, (_, place))| stay.binary_search(place).is_err())
            .map(|(at, (funct, _))| Move { funct: *funct, position: at + 1 })
            .collect()
    }

    /// Returns the indices of the flows from one thread to another.
    pub(crate) fn crossings(&self) -> Vec<usize> {
        let flows = self.machine.flows.iter().enumerate();
        flows.filter(|(_, flow)| !self.machine.is_inside(flow)).map(|(i, _)| i).collect()
    }
}

/// Returns the better order of a thread.
fn better(machine: &FlowGraph, thread: usize) -> Vec<usize> {
    let Some(order) = machine.threads.get(thread).map(|t| &t.order) else { return Vec::new() };
    let place = ByIndex::places(order, machine.functs.len());
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
