//! Values and aliases: `setp`, `sets`, `getp`, `gets`, `alias`.

use crate::{
    Error,
    change::stores::Store,
    change::undo::Undo,
    graph::model::Model,
    graph::names::Index,
    graph::ptr::Ptr,
    graph::ptr::own_cell,
    graph::{Graph, Ix, Queue, Storage},
    name::Name,
};
use hal_abi::PortQueue;
use hal_protocol::{Direction, Lock, Type, Value, ValueError};

impl Model {
    /// Executes `setp`.
    pub(crate) fn set_item(&mut self, name: &str, text: &str) -> Result<(), Error> {
        let ix = self.graph.find_item(name)?;
        let Some(item) = self.graph.item(ix) else { return Ok(()) };
        let what = if item.direction.is_pin() { "pin" } else { "parameter" };
        let refuse = |why| Err(Error::NotWritable { what, name: name.into(), why });
        match item.direction {
            Direction::Out => return refuse("it is an output of its component"),
            Direction::Ro => return refuse("its component reports it"),
            _ if self.graph.signal_of(ix).is_some() => {
                return refuse("it is linked to a signal: 'sets' sets that, 'unlinkp' frees it");
            }
            _ if item.ty == Type::Port => return refuse("it is a port: link it to a signal"),
            Direction::In | Direction::Io | Direction::Rw => {}
        }
        let value = parse(what, name, item.ty, text)?;
        let (storage, ty) = (item.storage(), item.ty);
        self.assigned(ix, value.bits());
        self.staged.store(match storage {
            // An unlinked item uses its own cell, now or after the earlier stores of this
            // transaction.
            Storage::Slot(slot) => Store::Put { cell: own_cell(slot), bits: value.bits() },
            Storage::Own(p) => Store::PutOwn { place: Ptr(p), ty, bits: value.bits() },
        });
        Ok(())
    }

    /// Executes `getp`.
    pub(crate) fn get_item(&self, name: &str) -> Result<Value, Error> {
        let ix = self.graph.find_item(name)?;
        let item = self.graph.item(ix);
        Ok(item.map_or(Value::Bit(false), |i| Graph::value(i.ty, i.bits())))
    }

    /// Executes `gets`.
    pub(crate) fn get_signal(&self, name: &str) -> Result<Value, Error> {
        let ix = self.graph.find_signal(name).map_err(Error::of_value)?;
        let signal = self.graph.signal(ix);
        Ok(signal.map_or(Value::Bit(false), |s| Graph::value(s.ty, s.bits())))
    }

    /// Returns the value of a pin, a parameter or a signal as a number; `None` if there is none of this name, or if it is a
    /// port.
    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        self.get_item(name).or_else(|_| self.get_signal(name)).ok()?.as_number()
    }

    /// Executes `sets`. For a port it sets the size of the queue, which is possible only once.
    pub(crate) fn set_signal(&mut self, name: &str, text: &str) -> Result<(), Error> {
        let ix = self.graph.find_signal(name).map_err(Error::of_value)?;
        let Some(signal) = self.graph.signal(ix) else { return Ok(()) };
        if signal.ty != Type::Port && signal.writers > 0 {
            let why = "an output writes it";
            return Err(Error::NotWritable { what: "signal", name: name.into(), why });
        }
        if signal.queue.is_some() {
            return Err(Error::QueueAllocated { name: name.into() });
        }
        let value = parse("signal", name, signal.ty, text)?;
        let cell = signal.cell;
        let mut bits = value.bits();
        self.assigned(ix, bits);
        if let Value::Port(size) = value {
            let data: Box<[crate::sync::AtomicU8]> =
                (0..size).map(|_| crate::sync::AtomicU8::new(0)).collect();
            // SAFETY: both live in the signal until no cell holds the address of the queue.
            let queue = Box::new(unsafe { PortQueue::new(data.as_ptr(), size) });
            bits = (&raw const *queue).expose_provenance() as u64;
            if let Some(s) = self.graph.signal_mut(ix) {
                s.queue = Some(Queue { queue, data });
            }
            self.staged.undo_by(Undo::Queued(ix));
        }
        self.staged.store(Store::Put { cell, bits });
        Ok(())
    }

    /// Records that a script line sets a node.
    fn assigned(&mut self, ix: Ix, bits: u64) {
        self.staged.undo_by(Undo::Assigned(ix, self.graph.sites.of_values(ix)));
        self.graph.sites.assigned(ix, bits);
    }

    /// Executes `alias`.
    pub(crate) fn alias(&mut self, param: bool, name: &str, alias: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, if param { "param_alias" } else { "pin_alias" })?;
        let what = if param { "param" } else { "pin" };
        let alias = Name::parse(what, alias)?;
        let ix = self.graph.find_of(param, what, name)?;
        if self.graph.item_named(param, alias.as_str()).is_some() {
            return Err(Error::Duplicate { what: "pin/alias name", name: alias.as_str().into() });
        }
        self.set_alias(param, ix, Some(alias));
        Ok(())
    }

    fn set_alias(&mut self, param: bool, ix: Ix, alias: Option<Name>) {
        let Some(item) = self.graph.item_mut(ix) else { return };
        let old = item.set_alias(alias.clone());
        let site = self.graph.sites.of_named(ix);
        self.staged.undo_by(Undo::Aliased(ix, old.clone(), site));
        let index = Index::of_items(param);
        if let Some(old) = old {
            self.unname(index, &old, ix);
        }
        if let Some(alias) = alias {
            self.name_node(index, alias, ix);
            self.graph.sites.named(ix);
        }
    }

    /// Executes `unalias`.
    pub(crate) fn unalias(&mut self, param: bool, name: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, if param { "param_alias" } else { "pin_alias" })?;
        let what = if param { "param" } else { "pin" };
        let ix = self.graph.find_of(param, what, name)?;
        self.set_alias(param, ix, None);
        Ok(())
    }
}

/// Parses a user's text as a value of a type.
pub(crate) fn parse(what: &'static str, name: &str, ty: Type, text: &str) -> Result<Value, Error> {
    let expects = ty.expects();
    Value::parse(ty, text).map_err(|e| match e {
        ValueError::Invalid => Error::InvalidValue { what, name: name.into(), expects },
        ValueError::Range => Error::OutOfRange { what, name: name.into(), expects },
    })
}
