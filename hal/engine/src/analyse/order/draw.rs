//! Construction of a [`FlowGraph`] from the graph: functions, threads and flows.

use super::flow_graph::{By, Flow, FlowGraph, Funct, Thread};
use crate::graph::{Edge, Graph, Ix};
use hal_protocol::{Direction, Type};
use petgraph::{
    Direction::{Incoming, Outgoing},
    visit::EdgeRef,
};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of writer-reader pairs of a signal. Beyond it, the functions are connected in a
/// ring instead of each with each.
const MAX_PAIRS: usize = 4096;

impl FlowGraph {
    /// Returns the functions in threads and their flows.
    pub(crate) fn of(graph: &Graph) -> Self {
        let mut machine = Self::default();
        for (number, ix) in graph.threads_by_age().into_iter().enumerate() {
            let Some(node) = graph.thread(ix) else { continue };
            let period = u64::try_from(node.thread.period_ns).unwrap_or(1);
            let mut edges: Vec<_> = graph
                .g
                .edges_directed(ix, Outgoing)
                .filter_map(|e| match *e.weight() {
                    Edge::Runs(at) => Some((at, e.target(), e.id())),
                    _ => None,
                })
                .collect();
            edges.sort_unstable();
            let mut order = Vec::new();
            for (_, f, edge) in edges {
                let Some(funct) = graph.funct(f) else { continue };
                order.push(machine.functs.len());
                machine.functs.push(Funct {
                    ix: f,
                    edge: Some(edge),
                    owner: graph.owner_of(f),
                    thread: number,
                    unknown: funct.unknown,
                    drives: funct.fast && has_outputs(graph, f),
                    told: funct.told,
                });
            }
            machine.threads.push(Thread { ix, period, order });
        }
        let mut places: BTreeMap<Ix, Vec<usize>> = BTreeMap::new();
        for (i, f) in machine.functs.iter().enumerate() {
            places.entry(f.ix).or_default().push(i);
        }
        // A function that runs in several places is treated as unknown, because it runs at
        // different times.
        for list in places.values().filter(|list| list.len() > 1) {
            for i in list {
                if let Some(f) = machine.functs.get_mut(*i) {
                    f.unknown = true;
                }
            }
        }
        let known: BTreeMap<Ix, usize> = places
            .iter()
            .filter_map(|(ix, list)| match list.as_slice() {
                [i] if machine.functs.get(*i).is_some_and(|f| !f.unknown) => Some((*ix, *i)),
                _ => None,
            })
            .collect();
        machine.flows = flows(graph, &known);
        machine.fixed = fixed(graph, &machine, &known);
        machine
    }
}

fn has_outputs(graph: &Graph, funct: Ix) -> bool {
    let mut writes =
        graph.g.edges_directed(funct, Outgoing).filter(|e| *e.weight() == Edge::Writes);
    writes.any(|e| graph.item(e.target()).is_some_and(|i| i.direction == Direction::Out))
}

/// Returns the known functions that read or write a pin.
fn touching(graph: &Graph, pin: Ix, known: &BTreeMap<Ix, usize>, writes: bool) -> Vec<usize> {
    let (way, wanted) = if writes { (Incoming, Edge::Writes) } else { (Outgoing, Edge::Reads) };
    let edges = graph.g.edges_directed(pin, way).filter(|e| *e.weight() == wanted);
    let functs = edges.map(|e| if writes { e.source() } else { e.target() });
    functs.filter_map(|f| known.get(&f).copied()).collect()
}

fn flows(graph: &Graph, known: &BTreeMap<Ix, usize>) -> Vec<Flow> {
    let mut pairs: Vec<(usize, usize, By)> = Vec::new();
    for (ix, from) in known {
        for edge in graph.g.edges_directed(*ix, Outgoing) {
            match *edge.weight() {
                Edge::HandsOver => {
                    let to = known.get(&edge.target()).copied();
                    pairs.extend(to.map(|to| (*from, to, By::Hidden)));
                }
                Edge::Writes if graph.signal_of(edge.target()).is_none() => {
                    let two_way = graph.item(edge.target()).map(|i| i.direction);
                    let by = match two_way {
                        Some(Direction::Io) => By::Pin(edge.target()),
                        // A correction that a component makes to its own input or setting is not a
                        // flow.
                        Some(Direction::In | Direction::Rw) | None => continue,
                        Some(Direction::Out | Direction::Ro) => By::Hidden,
                    };
                    let readers = touching(graph, edge.target(), known, false);
                    pairs.extend(readers.into_iter().map(|to| (*from, to, by)));
                }
                _ => {}
            }
        }
    }
    for (_, ix) in &graph.signal_names() {
        let (mut out, mut io, mut readers) = (Vec::new(), Vec::new(), Vec::new());
        for pin in graph.pins_of(*ix) {
            match graph.item(pin).map(|item| item.direction) {
                Some(Direction::Out) => out.extend(touching(graph, pin, known, true)),
                Some(Direction::Io) => io.extend(touching(graph, pin, known, true)),
                _ => {}
            }
            readers.extend(touching(graph, pin, known, false));
        }
        between(&mut pairs, &out, &readers, By::Signal(*ix));
        between(&mut pairs, &io, &readers, By::Shared(*ix));
    }
    pairs.retain(|(from, to, _)| from != to);
    pairs.sort_unstable();
    pairs.dedup();
    let mut flows: Vec<Flow> = Vec::new();
    for (from, to, by) in pairs {
        match flows.last_mut() {
            Some(flow) if (flow.from, flow.to) == (from, to) => flow.by.push(by),
            _ => flows.push(Flow { from, to, by: vec![by], numbers: false }),
        }
    }
    for flow in &mut flows {
        flow.numbers = flow.by.iter().any(|by| match by {
            By::Signal(ix) | By::Shared(ix) => graph.signal(*ix).is_some_and(|s| s.ty != Type::Bit),
            By::Pin(_) => false,
            By::Hidden => true,
        });
    }
    flows
}

/// Adds a flow from each writer to each reader.
fn between(pairs: &mut Vec<(usize, usize, By)>, from: &[usize], to: &[usize], by: By) {
    if from.len() > 1 && from.len().saturating_mul(to.len()) > MAX_PAIRS {
        let all: BTreeSet<usize> = from.iter().chain(to).copied().collect();
        let next = all.iter().cycle().skip(1);
        pairs.extend(all.iter().zip(next).map(|(a, b)| (*a, *b, by)));
        return;
    }
    for from in from {
        pairs.extend(to.iter().map(|to| (*from, *to, by)));
    }
}

/// Returns the pairs whose order must not change. An unknown function may read and write every pin
/// of its component. Every function that shares a signal with that component therefore stays on the
/// same side of it.
fn fixed(graph: &Graph, machine: &FlowGraph, known: &BTreeMap<Ix, usize>) -> Vec<(usize, usize)> {
    let mut strange: BTreeMap<Ix, BTreeSet<usize>> = BTreeMap::new();
    for (i, f) in machine.functs.iter().enumerate().filter(|(_, f)| f.unknown) {
        strange.entry(f.owner.unwrap_or(f.ix)).or_default().insert(i);
    }
    let mut near: BTreeMap<Ix, BTreeSet<usize>> =
        strange.iter().map(|(ix, functs)| (*ix, functs.clone())).collect();
    if strange.is_empty() {
        return Vec::new();
    }
    for (_, ix) in &graph.signal_names() {
        let (mut parties, mut owners) = (BTreeSet::new(), BTreeSet::new());
        for pin in graph.pins_of(*ix) {
            match graph.owner_of(pin).and_then(|owner| Some((owner, strange.get(&owner)?))) {
                Some((owner, functs)) => {
                    owners.insert(owner);
                    parties.extend(functs.iter().copied());
                }
                None => {
                    parties.extend(touching(graph, pin, known, false));
                    parties.extend(touching(graph, pin, known, true));
                }
            }
        }
        for owner in owners {
            near.entry(owner).or_default().extend(parties.iter().copied());
        }
    }
    let mut out = Vec::new();
    for (owner, functs) in &near {
        let Some(strange) = strange.get(owner) else { continue };
        for thread in &machine.threads {
            let order = thread.order.iter().copied().filter(|i| functs.contains(i));
            side_by_side(&mut out, order, strange);
        }
    }
    for thread in &machine.threads {
        // `delf` removes all occurrences of a function that is in a thread twice.
        let once: BTreeSet<Ix> =
            thread.order.iter().filter_map(|i| machine.functs.get(*i)).map(|f| f.ix).collect();
        if once.len() < thread.order.len() {
            out.extend(thread.order.iter().copied().zip(thread.order.iter().copied().skip(1)));
        }
    }
    out.sort_unstable();
    out.dedup();
    out
}

/// Adds pairs that keep each function between the unknown functions before and after it.
fn side_by_side(
    out: &mut Vec<(usize, usize)>,
    order: impl Iterator<Item = usize>,
    strange: &BTreeSet<usize>,
) {
    let mut last = None;
    let mut between: Vec<usize> = Vec::new();
    for i in order {
        if strange.contains(&i) {
            out.extend(between.drain(..).chain(last).map(|before| (before, i)));
            last = Some(i);
        } else {
            out.extend(last.map(|before| (before, i)));
            between.push(i);
        }
    }
}
