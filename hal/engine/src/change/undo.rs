//! Log of a transaction's steps in the graph: each entry says how to revert its step.

use crate::{
    graph::names::Index,
    graph::sites::{Assignments, Site},
    graph::{Edge, Ix},
    name::Name,
    observe::ring::SharedRing,
};

/// A step of a transaction, with the data to revert it.
#[derive(Debug)]
pub(crate) enum Undo {
    /// A component was created, with everything that it owns.
    Made(Ix),
    /// The component's devices were opened.
    Opened(Ix),
    /// A signal was created.
    Signal(Ix),
    /// A name of a node was added to an index.
    Named(Index, Name, Ix),
    /// A name was removed from a node.
    Unnamed(Index, Name, Ix),
    /// A pin was linked.
    Linked(Ix),
    /// A pin was unlinked from a signal; with the script position of the link.
    Unlinked(Ix, Ix, Option<Site>),
    /// A queue was added to a signal.
    Queued(Ix),
    /// A pin or parameter had this alias, set at this script position.
    Aliased(Ix, Option<Name>, Option<Site>),
    /// Script lines had set a pin, parameter or signal to this.
    Assigned(Ix, Option<Assignments>),
    /// A component no longer counts as a user of another.
    Released(Ix, Ix),
    /// A ring was removed from the list of rings.
    Ring(Name, Box<SharedRing>),
}

/// The functions of a thread before the transaction changed them.
#[derive(Debug)]
pub(crate) struct Order {
    /// `None` as long as functions are only added at the end.
    pub(crate) functs: Option<Vec<(Ix, Edge, Option<Site>)>>,
    pub(crate) next: u32,
    pub(crate) stale: bool,
}
