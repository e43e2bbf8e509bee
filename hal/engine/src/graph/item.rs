//! Creation of pins and parameters.

use crate::{
    Error,
    graph::model::Model,
    graph::names::Index,
    graph::new_item::NewItem,
    graph::ptr::Ptr,
    graph::ptr::own_cell,
    graph::{Edge, Item, Ix, Node, Storage},
    name::Name,
    realtime::account::Account,
};
use core::ptr::NonNull;
use hal_abi::Slot;
use hal_protocol::{Direction, Type};

impl Model {
    /// Creates a pin or parameter. An item with its own storage has no slot.
    pub(crate) fn new_item(
        &mut self,
        owner: Ix,
        new: NewItem,
    ) -> Result<(Ix, Option<NonNull<Slot>>), Error> {
        let param = !new.direction.is_pin();
        let what = if param { "parameter" } else { "pin" };
        for name in [Some(&new.name), new.other.as_ref()].into_iter().flatten() {
            if self.graph.item_named(param, name.as_str()).is_some() {
                return Err(Error::Duplicate { what, name: name.as_str().into() });
            }
        }
        let (storage, slot) = match new.storage {
            Some(own) if param => {
                self.staged.owns(own.addr().get());
                (Storage::Own(own), None)
            }
            _ => {
                let slot = self.arena.slot(new.initial)?;
                (Storage::Slot(Ptr(slot)), Some(slot))
            }
        };
        let (name, other) = (new.name.clone(), new.other.clone());
        let ix = self.graph.g.add_node(Node::Item(Item::new(new, storage)));
        self.graph.g.add_edge(owner, ix, Edge::Owns);
        for name in [Some(name), other].into_iter().flatten() {
            self.graph.add_name(Index::of_items(param), &name, ix);
        }
        if param {
            self.counters.params += 1;
        } else {
            self.counters.pins += 1;
        }
        Ok((ix, slot))
    }

    /// Creates the pins and parameters that show the run times of a function or thread.
    pub(crate) fn new_account(
        &mut self,
        owner: Ix,
        name: &Name,
        funct: bool,
    ) -> Result<Account, Error> {
        let mut add = |suffix: &str, ty, direction, doc: &str| {
            let what = if direction == Direction::Out { "pin" } else { "parameter" };
            let name = Name::parse(what, &format!("{name}.{suffix}"))?;
            let doc = self.graph.docs.number(doc);
            let new = NewItem {
                name,
                other: None,
                ty,
                direction,
                initial: 0,
                storage: None,
                hidden: false,
                times: true,
                safety: false,
                measured: false,
                doc,
            };
            let (_, slot) = self.new_item(owner, new)?;
            slot.map(Ptr).ok_or(Error::OutOfMemory)
        };
        let time = add("time", Type::S32, Direction::Out, "Last run time, in ns.")?;
        let doc = "Longest run time, in ns; write 0 to reset.";
        let tmax = own_cell(add("tmax", Type::S32, Direction::Rw, doc)?);
        let increased = if funct {
            let doc = "Whether the longest run time grew in the last run.";
            Some(own_cell(add("tmax-increased", Type::Bit, Direction::Ro, doc)?))
        } else {
            None
        };
        Ok(Account { time, tmax, increased })
    }
}
