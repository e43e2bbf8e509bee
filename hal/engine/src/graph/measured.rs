//! Origin of the value of a pin: measured if it comes from a sensor, by whatever way, or from commands alone.
//!
//! The way leads from the pin to the pins that write its signal, from each of these to the functions that write it, and on
//! from the pins that these read. It ends at a pin that a sensor's component has marked ([`Item::is_measured`]): the value
//! is measured. It also ends at the component that asks, because its own commands measure nothing; and at a function that
//! reads no linked pin, such as that of a step generator, whose count it takes from another function. What a foreign
//! component reads is unknown: its values count as not measured.

use crate::graph::{Edge, Graph, Item, Ix, model::Model};
use hal_protocol::Direction;
use petgraph::{Direction::Incoming, visit::EdgeRef};
use std::collections::BTreeSet;

/// A question of a component about one of its pins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Question {
    /// The component and its number: a node may belong to another one later.
    component: Ix,
    id: u32,
    pin: Ix,
    /// Parameter that holds the answer.
    into: Ix,
}

impl Graph {
    /// Returns whether a sensor measures the value of a pin of `asker`.
    fn is_measured(&self, pin: Ix, asker: Ix) -> bool {
        let (mut seen, mut left) = (BTreeSet::from([pin]), vec![pin]);
        while let Some(reader) = left.pop() {
            let Some(signal) = self.signal_of(reader) else { continue };
            for writer in self.pins_of(signal) {
                let Some(item) = self.item(writer) else { continue };
                let writes = matches!(item.direction, Direction::Out | Direction::Io);
                if !writes || self.owner_of(writer) == Some(asker) {
                    continue;
                }
                if item.is_measured() {
                    return true;
                }
                let read = self.read_for(writer);
                left.extend(read.into_iter().filter(|ix| seen.insert(*ix)));
            }
        }
        false
    }

    /// Returns the pins that the functions read that write a pin.
    fn read_for(&self, pin: Ix) -> Vec<Ix> {
        let sources = |ix: Ix, edge: Edge| {
            let edges = self.g.edges_directed(ix, Incoming);
            edges.filter(move |e| *e.weight() == edge).map(|e| e.source())
        };
        let functs = sources(pin, Edge::Writes);
        functs.flat_map(|funct| sources(funct, Edge::Reads)).filter(|ix| *ix != pin).collect()
    }
}

impl Model {
    /// Adds a question of a component about one of its pins.
    pub(crate) fn ask_measured(&mut self, component: Ix, pin: Ix, into: Ix) {
        let id = self.graph.component(component).map_or(0, |c| c.id);
        self.questions.push(Question { component, id, pin, into });
    }

    /// Answers the questions of all components again, after the graph has changed.
    pub(crate) fn answer_measured(&mut self) {
        let graph = &self.graph;
        self.questions.retain(|q| graph.component(q.component).is_some_and(|c| c.id == q.id));
        for q in &self.questions {
            let answer = u64::from(graph.is_measured(q.pin, q.component));
            if let Some(item) = graph.item(q.into).filter(|i: &&Item| i.bits() != answer) {
                item.put(answer);
            }
        }
    }
}
