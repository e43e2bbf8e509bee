//! Script positions at which things were loaded, linked, added, named or set.

use crate::{graph::Ix, sync::Arc};
use hal_protocol::At;
use petgraph::stable_graph::EdgeIndex;
use std::collections::BTreeMap;

/// Maximum number of files that are recorded, and maximum length of a file name in bytes.
const MAX_FILES: usize = 4096;
const MAX_NAME: usize = 4096;

/// A line of a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Site {
    file: u32,
    line: u32,
}

/// A value that a script line has set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Assigned {
    pub(crate) site: Option<Site>,
    pub(crate) bits: u64,
    /// Number of times the machine had been run before.
    moment: u32,
}

/// Values that script lines have set for a pin, parameter or signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Assignments {
    pub(crate) last: Assigned,
    /// The last different value before it, if the machine did not run in between.
    pub(crate) other: Option<Assigned>,
}

/// Script positions of everything. Things that no script made have no position.
#[derive(Debug, Default)]
pub(crate) struct Sites {
    files: Vec<Arc<str>>,
    numbers: BTreeMap<Arc<str>, u32>,
    now: Option<Site>,
    moment: u32,
    nodes: BTreeMap<Ix, Site>,
    edges: BTreeMap<EdgeIndex<u32>, Site>,
    aliases: BTreeMap<Ix, Site>,
    values: BTreeMap<Ix, Assignments>,
}

impl Sites {
    /// Sets the position for everything that is created from here on.
    pub(crate) fn stand(&mut self, file: &str, line: u32) {
        if let Some(now) = &mut self.now
            && self.files.get(now.file as usize).is_some_and(|f| **f == *file)
        {
            now.line = line;
            return;
        }
        self.now = self.number(file).map(|file| Site { file, line });
    }

    /// Sets the position for one request, or none if the client gave none. Returns the previous
    /// position, for [`Self::resume`].
    pub(crate) fn visit(&mut self, at: Option<&At>) -> Option<Site> {
        let before = self.now.take();
        if let Some(at) = at {
            self.stand(&at.file, at.line);
        }
        before
    }

    /// Restores the position that [`Self::visit`] returned.
    pub(crate) const fn resume(&mut self, before: Option<Site>) {
        self.now = before;
    }

    fn number(&mut self, file: &str) -> Option<u32> {
        if let Some(n) = self.numbers.get(file) {
            return Some(*n);
        }
        if self.files.len() >= MAX_FILES || file.len() > MAX_NAME {
            return None;
        }
        let n = u32::try_from(self.files.len()).ok()?;
        let name: Arc<str> = file.into();
        self.files.push(name.clone());
        self.numbers.insert(name, n);
        Some(n)
    }

    /// Records that a component, signal or thread is created here.
    pub(crate) fn made(&mut self, node: Ix) {
        keep(&mut self.nodes, node, self.now);
    }

    /// Records that a pin is linked or a function is added here.
    pub(crate) fn joined(&mut self, edge: EdgeIndex<u32>) {
        keep(&mut self.edges, edge, self.now);
    }

    /// Records that a pin or parameter is given an alias here.
    pub(crate) fn named(&mut self, item: Ix) {
        keep(&mut self.aliases, item, self.now);
    }

    /// Records that a pin, parameter or signal is set here.
    pub(crate) fn assigned(&mut self, node: Ix, bits: u64) {
        let last = Assigned { site: self.now, bits, moment: self.moment };
        let before = self.values.get(&node).filter(|b| b.last.moment == self.moment).copied();
        let other = match before {
            Some(b) if b.last.bits != bits => Some(b.last),
            Some(b) => b.other,
            None => None,
        };
        self.values.insert(node, Assignments { last, other });
    }

    /// Records that the machine has run. Values that are set afterwards are intended changes.
    pub(crate) const fn has_run(&mut self) {
        self.moment = self.moment.wrapping_add(1);
    }

    /// Removes a node.
    pub(crate) fn forget(&mut self, node: Ix) {
        self.nodes.remove(&node);
        self.aliases.remove(&node);
        self.values.remove(&node);
    }

    /// Removes a link, or a function in a thread.
    pub(crate) fn parted(&mut self, edge: EdgeIndex<u32>) {
        self.edges.remove(&edge);
    }
}

/// State that is saved and restored when a change is reverted.
impl Sites {
    /// Returns where a link was made or a function was added.
    pub(crate) fn of_joined(&self, edge: EdgeIndex<u32>) -> Option<Site> {
        self.edges.get(&edge).copied()
    }

    /// Restores where a link was made or a function was added.
    pub(crate) fn joined_at(&mut self, edge: EdgeIndex<u32>, site: Option<Site>) {
        keep(&mut self.edges, edge, site);
    }

    /// Returns where a pin or parameter was given its alias.
    pub(crate) fn of_named(&self, item: Ix) -> Option<Site> {
        self.aliases.get(&item).copied()
    }

    /// Restores where a pin or parameter was given its alias.
    pub(crate) fn named_at(&mut self, item: Ix, site: Option<Site>) {
        keep(&mut self.aliases, item, site);
    }

    /// Returns the values that script lines have set for a pin, parameter or signal.
    pub(crate) fn of_values(&self, node: Ix) -> Option<Assignments> {
        self.values.get(&node).copied()
    }

    /// Restores the values that script lines had set.
    pub(crate) fn assigned_before(&mut self, node: Ix, values: Option<Assignments>) {
        match values {
            Some(values) => {
                self.values.insert(node, values);
            }
            None => {
                self.values.remove(&node);
            }
        }
    }
}

impl Sites {
    /// Returns the position at which a pin was linked or a function was added.
    pub(crate) fn of_edge(&self, edge: EdgeIndex<u32>) -> Option<At> {
        self.at(self.edges.get(&edge).copied())
    }

    /// Returns a position with its file name.
    pub(crate) fn at(&self, site: Option<Site>) -> Option<At> {
        let site = site?;
        let file = self.files.get(site.file as usize)?;
        Some(At::new(file, site.line))
    }
}

impl Sites {
    /// Returns the position at which a component, signal or thread was created.
    pub(crate) fn of(&self, node: Ix) -> Option<At> {
        self.at(self.nodes.get(&node).copied())
    }

    /// Returns the position at which a pin or parameter was given its alias.
    pub(crate) fn of_alias(&self, item: Ix) -> Option<At> {
        self.at(self.aliases.get(&item).copied())
    }

    /// Returns the values that script lines have set for a node.
    pub(crate) fn values_of(&self, node: Ix) -> Option<Assignments> {
        self.values.get(&node).copied()
    }
}

fn keep<K: Ord>(map: &mut BTreeMap<K, Site>, key: K, site: Option<Site>) {
    match site {
        Some(site) => {
            map.insert(key, site);
        }
        // The index may have belonged to something else before.
        None => {
            map.remove(&key);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(at: Option<At>) -> String {
        at.map_or_else(|| "none".to_owned(), |at| at.to_string())
    }

    #[test]
    fn places_are_kept_until_their_thing_is_gone() {
        let (mut sites, node) = (Sites::default(), Ix::new(7));
        sites.made(node);
        assert_eq!(shown(sites.of(node)), "none");
        sites.stand("a.hal", 3);
        sites.made(node);
        sites.stand("a.hal", 4);
        sites.stand("b.hal", 1);
        let before = sites.visit(Some(&At::new("a.hal", 9)));
        sites.assigned(node, 1);
        sites.resume(before);
        let before = sites.visit(None);
        sites.assigned(node, 2);
        sites.assigned(node, 2);
        sites.resume(before);
        sites.named(node);
        assert_eq!(shown(sites.of(node)), "a.hal:3");
        assert_eq!(shown(sites.of_alias(node)), "b.hal:1");
        let values = sites.values_of(node).unwrap();
        assert_eq!((values.last.bits, shown(sites.at(values.last.site))), (2, "none".to_owned()));
        let other = values.other.unwrap();
        assert_eq!((other.bits, shown(sites.at(other.site))), (1, "a.hal:9".to_owned()));
        sites.forget(node);
        assert_eq!(shown(sites.of(node)), "none");
        assert_eq!(sites.values_of(node), None);
    }

    #[test]
    fn names_of_files_are_bounded() {
        let mut sites = Sites::default();
        sites.stand(&"x".repeat(MAX_NAME + 1), 1);
        assert_eq!(sites.now, None);
        for n in 0..MAX_FILES + 10 {
            sites.stand(&n.to_string(), 1);
        }
        assert_eq!((sites.files.len(), sites.now), (MAX_FILES, None));
        sites.stand("0", 2);
        assert!(sites.now.is_some());
    }
}
