//! `check`: problems that the graph shows before the machine moves.

mod components;
mod earlier;
mod estop;
mod exchanged;
mod flow;
mod functs;
mod halves;
mod inputs;
mod protection;
mod signals;
mod sisters;
mod steps;
mod values;

use crate::{
    Engine,
    graph::{Edge, Graph, Item, Ix},
};
use hal_protocol::{At, Code, Direction, Finding, Type, Value};
use petgraph::{
    Direction::{Incoming, Outgoing},
    visit::EdgeRef,
};
use std::rc::Rc;

impl Engine {
    /// Returns all problems and oddities of the machine in its current state, in no particular
    /// order.
    pub(crate) fn check(&self) -> Vec<Finding> {
        let graph = self.model.graph();
        let mut look =
            Look { graph, items: items(graph), runs: self.runtime.is_running(), found: Vec::new() };
        look.signals();
        look.values();
        if !self.options.earlier_values {
            look.earlier();
        }
        look.functs();
        look.threads();
        look.components();
        look.protection();
        look.estop();
        look.steps();
        look.inputs();
        look.halves();
        look.sisters();
        look.exchanged();
        look.flow(&self.order());
        look.found
    }
}

/// A check in progress: the graph, and the findings so far.
struct Look<'g> {
    graph: &'g Graph,
    /// All pins and parameters in order of their names, each once under its own name, without
    /// simulated registers and the engine's time items.
    items: Rc<[(Ix, &'g Item)]>,
    /// True if threads are started.
    runs: bool,
    found: Vec<Finding>,
}

impl<'g> Look<'g> {
    fn add(&mut self, finding: Finding) {
        self.found.push(finding);
    }

    /// Returns all pins and parameters, in a list that does not borrow the check.
    fn items(&self) -> Rc<[(Ix, &'g Item)]> {
        Rc::clone(&self.items)
    }

    /// Returns the pin or parameter with this name.
    fn item(&self, name: &str) -> Option<(Ix, &'g Item)> {
        let ix = self.graph.find_item(name).ok()?;
        Some((ix, self.graph.item(ix)?))
    }

    /// Returns the name of an item that users see.
    fn shown(&self, item: Ix) -> &'g str {
        self.graph.item(item).map_or("", |i| i.shown().as_str())
    }

    /// Returns the name of a signal.
    fn signal_name(&self, signal: Ix) -> &'g str {
        self.graph.signal(signal).map_or("", |s| s.name.as_str())
    }

    /// Returns the name of a function.
    fn funct_name(&self, funct: Ix) -> &'g str {
        self.graph.funct(funct).map_or("", |f| f.name.as_str())
    }

    /// Returns the name of a thread.
    fn thread_name(&self, thread: Ix) -> &'g str {
        self.graph.thread(thread).map_or("", |t| t.name.as_str())
    }

    /// Returns the period of a thread in nanoseconds.
    fn period(&self, thread: Ix) -> i64 {
        self.graph.thread(thread).map_or(0, |t| t.thread.period_ns)
    }

    /// Returns the pins that write a signal, and the pins that read it. An I/O pin is in both
    /// lists.
    fn ends(&self, signal: Ix) -> (Vec<Ix>, Vec<Ix>) {
        let mut pins = self.graph.pins_of(signal);
        pins.sort_by_key(|pin| self.shown(*pin));
        let is = |pin: &Ix, not: Direction| {
            self.graph.item(*pin).is_some_and(|item| item.direction != not)
        };
        let writers = pins.iter().copied().filter(|pin| is(pin, Direction::In)).collect();
        let readers = pins.iter().copied().filter(|pin| is(pin, Direction::Out)).collect();
        (writers, readers)
    }

    /// Returns the functions that write a pin or parameter.
    fn writers(&self, item: Ix) -> Vec<Ix> {
        let edges = self.graph.g.edges_directed(item, Incoming);
        edges.filter(|e| *e.weight() == Edge::Writes).map(|e| e.source()).collect()
    }

    /// Returns the functions that read a pin or parameter.
    fn readers(&self, item: Ix) -> Vec<Ix> {
        let edges = self.graph.g.edges_directed(item, Outgoing);
        edges.filter(|e| *e.weight() == Edge::Reads).map(|e| e.target()).collect()
    }

    /// Returns the items that a function reads, and the items that it writes.
    fn touched(&self, funct: Ix) -> (Vec<Ix>, Vec<Ix>) {
        let g = &self.graph.g;
        let reads = g.edges_directed(funct, Incoming).filter(|e| *e.weight() == Edge::Reads);
        let writes = g.edges_directed(funct, Outgoing).filter(|e| *e.weight() == Edge::Writes);
        (reads.map(|e| e.source()).collect(), writes.map(|e| e.target()).collect())
    }

    /// Returns whether a pin is linked or a script line has set its value.
    fn is_used(&self, item: Ix) -> bool {
        self.graph.signal_of(item).is_some() || self.graph.sites.values_of(item).is_some()
    }

    /// Returns whether an item is not linked and no script line has set its value.
    fn is_idle(&self, item: Ix) -> bool {
        !self.is_used(item)
    }

    /// Returns the outermost owner of a node: the component that was loaded.
    fn loaded(&self, node: Ix) -> Ix {
        let mut owner = node;
        while let Some(above) = self.graph.owner_of(owner) {
            owner = above;
        }
        owner
    }

    /// Returns the name of the module whose load created a node.
    fn loaded_by(&self, node: Ix) -> &'g str {
        self.graph.component(self.loaded(node)).map_or("", |c| c.name.as_str())
    }

    /// Returns the position at which a component was loaded. `node` may also be something that the
    /// component created.
    fn loaded_at(&self, node: Ix) -> Option<At> {
        self.graph.sites.of(self.loaded(node))
    }

    /// Returns the position at which a pin was linked.
    fn linked_at(&self, pin: Ix) -> Option<At> {
        let mut edges = self.graph.g.edges_directed(pin, Outgoing);
        let link = edges.find(|e| *e.weight() == Edge::Links)?;
        self.graph.sites.of_edge(link.id())
    }

    /// Returns the position at which a function was added to a thread.
    fn added_at(&self, thread: Ix, funct: Ix) -> Option<At> {
        let mut edges = self.graph.g.edges_connecting(thread, funct);
        let run = edges.find(|e| matches!(e.weight(), Edge::Runs(_) | Edge::Begins(_)))?;
        self.graph.sites.of_edge(run.id())
    }

    /// Returns the position at which a script line last set the value of a node.
    fn set_at(&self, node: Ix) -> Option<At> {
        let sites = &self.graph.sites;
        sites.values_of(node).and_then(|v| sites.at(v.last.site))
    }

    /// Returns the value of an item of any type as a float. Returns `None` for a port.
    fn number(&self, item: Ix) -> Option<f64> {
        let item = self.graph.item(item)?;
        Value::from_bits(item.ty, item.bits()).as_number()
    }

    /// Returns the value of the item with this name as a float.
    fn number_of(&self, name: &str) -> Option<f64> {
        self.number(self.item(name)?.0)
    }

    /// Formats a value as users see it.
    fn value(&self, node: Ix, bits: u64) -> String {
        let ty = match (self.graph.item(node), self.graph.signal(node)) {
            (Some(item), _) => item.ty,
            (None, Some(signal)) => signal.ty,
            (None, None) => Type::U64,
        };
        Value::from_bits(ty, bits).to_string()
    }
}

/// Returns the pins and parameters that checks look at.
fn items(graph: &Graph) -> Rc<[(Ix, &Item)]> {
    let all = graph.all_item_names();
    all.filter_map(|(name, ix)| Some((name, ix, graph.item(ix)?)))
        .filter(|(name, _, item)| item.name == **name && !item.hidden() && !item.times)
        .map(|(_, ix, item)| (ix, item))
        .collect()
}

/// Returns the first few names for a sentence, and how many more there are.
fn names<'n>(all: impl IntoIterator<Item = &'n str>) -> String {
    const MAX: usize = 6;
    let all: Vec<&str> = all.into_iter().collect();
    let mut text = String::new();
    for (i, name) in all.iter().take(MAX).enumerate() {
        text.push_str(if i == 0 { "'" } else { ", '" });
        text.push_str(name);
        text.push('\'');
    }
    match all.len().checked_sub(MAX) {
        Some(more) if more > 0 => format!("{text} and {more} more"),
        _ => text,
    }
}

/// Returns a finding at the level of its code.
fn finding(code: Code, subject: &str, text: String) -> Finding {
    Finding::new(code, subject, text)
}
