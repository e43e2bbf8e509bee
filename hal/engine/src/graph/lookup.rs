//! Look-ups of nodes by name, and changes of the indices.

use crate::{
    Error,
    graph::names::{Index, Names, hash},
    graph::{Graph, Ix, Node},
    name::Name,
};

impl Graph {
    /// Returns the names of a node: of items also the second name and the alias.
    fn names_of(&self, ix: Ix) -> impl Iterator<Item = &Name> {
        let names = match self.g.node_weight(ix) {
            Some(Node::Item(item)) => [Some(&item.name), item.other(), item.alias()],
            Some(Node::Signal(s)) => [Some(&s.name), None, None],
            Some(Node::Funct(f)) => [Some(&f.name), None, None],
            Some(Node::Component(_) | Node::Thread(_)) | None => [None; 3],
        };
        names.into_iter().flatten()
    }

    fn find_in(&self, names: &Names, name: &str) -> Option<Ix> {
        names.find(name, |ix| self.names_of(ix).any(|n| n.as_str() == name))
    }

    /// Returns the names of an index in order, with their nodes.
    fn sorted(&self, names: &Names) -> Vec<(&Name, Ix)> {
        let mut all = Vec::with_capacity(names.len());
        for (known, ix) in names.hashes() {
            let own = self.names_of(ix).filter(|n| hash(n.as_str()) == known);
            all.extend(own.map(|name| (name, ix)));
        }
        all.sort_unstable();
        all
    }

    /// Returns the pin with this name.
    pub(crate) fn pin_named(&self, name: &str) -> Option<Ix> {
        self.find_in(&self.pins, name)
    }

    /// Returns the parameter with this name if `param` is true, otherwise the pin.
    pub(crate) fn item_named(&self, param: bool, name: &str) -> Option<Ix> {
        self.find_in(if param { &self.params } else { &self.pins }, name)
    }

    /// Returns the name for a second or later load of a module that is loaded: `MODULE:2`, `MODULE:3`, …
    pub(crate) fn further_load(&self, module: &str) -> Result<Name, Error> {
        let name = |number: u32| Name::parse("component", &format!("{module}:{number}"));
        // A search by halves: the lower number is in use, the upper one is free.
        let (mut used, mut free) = (1_u32, 2);
        while self.components.contains_key(&name(free)?) {
            (used, free) = (free, free * 2);
        }
        while free - used > 1 {
            let middle = used + (free - used) / 2;
            if self.components.contains_key(&name(middle)?) {
                used = middle;
            } else {
                free = middle;
            }
        }
        name(free)
    }

    /// Returns the names of the second and later loads of a module.
    pub(crate) fn further_loads(&self, module: &str) -> Vec<Name> {
        let of =
            |name: &&Name| name.as_str().strip_prefix(module).is_some_and(|n| n.starts_with(':'));
        self.components.keys().filter(of).cloned().collect()
    }

    /// Returns the signal with this name.
    pub(crate) fn signal_named(&self, name: &str) -> Option<Ix> {
        self.find_in(&self.signals, name)
    }

    /// Returns the function with this name.
    pub(crate) fn funct_named(&self, name: &str) -> Option<Ix> {
        self.find_in(&self.functs, name)
    }

    /// Returns the names of parameters if `param` is true, otherwise those of pins, in order.
    pub(crate) fn item_names(&self, param: bool) -> Vec<(&Name, Ix)> {
        self.sorted(if param { &self.params } else { &self.pins })
    }

    /// Returns the names of pins in order, and then those of parameters.
    pub(crate) fn all_item_names(&self) -> impl Iterator<Item = (&Name, Ix)> {
        self.item_names(false).into_iter().chain(self.item_names(true))
    }

    /// Returns the names of signals in order.
    pub(crate) fn signal_names(&self) -> Vec<(&Name, Ix)> {
        self.sorted(&self.signals)
    }

    /// Returns the names of functions in order.
    pub(crate) fn funct_names(&self) -> Vec<(&Name, Ix)> {
        self.sorted(&self.functs)
    }

    /// Returns the number of signals.
    pub(crate) fn signal_count(&self) -> usize {
        self.signals.len()
    }

    /// Returns the number of functions.
    pub(crate) fn funct_count(&self) -> usize {
        self.functs.len()
    }

    /// Forgets the names of parameters, signals and functions at once, before all of them are freed.
    /// Messages may still name pins.
    pub(super) fn forget_all_but_pins(&mut self) {
        for names in [&mut self.params, &mut self.signals, &mut self.functs] {
            *names = Names::default();
        }
    }

    /// Adds a name of a node to its index.
    pub(crate) fn add_name(&mut self, index: Index, name: &Name, ix: Ix) {
        match index {
            Index::Pins => self.pins.insert(name.as_str(), ix),
            Index::Params => self.params.insert(name.as_str(), ix),
            Index::Signals => self.signals.insert(name.as_str(), ix),
            Index::Functs => self.functs.insert(name.as_str(), ix),
            Index::Components => drop(self.components.insert(name.clone(), ix)),
            Index::Threads => drop(self.threads.insert(name.clone(), ix)),
            Index::Commands => drop(self.commands.insert(name.clone(), ix)),
        }
    }

    /// Removes a name from its index, if it belongs to the node. Returns whether it did.
    pub(crate) fn remove_name(&mut self, index: Index, name: &Name, ix: Ix) -> bool {
        let few = match index {
            Index::Pins => return self.pins.remove(name.as_str(), ix),
            Index::Params => return self.params.remove(name.as_str(), ix),
            Index::Signals => return self.signals.remove(name.as_str(), ix),
            Index::Functs => return self.functs.remove(name.as_str(), ix),
            Index::Components => &mut self.components,
            Index::Threads => &mut self.threads,
            Index::Commands => &mut self.commands,
        };
        few.get(name) == Some(&ix) && few.remove(name).is_some()
    }
}
