//! Signals and links: the rules, and the changes they make.

use crate::{
    Engine, Error,
    arena::Arena,
    change::{Change, Store},
    code::Ptr,
    graph::{Edge, Graph, Ix, Node, Queue, Signal},
    name::Name,
};
use hal_abi::{PortQueue, Slot};
use hal_protocol::{Direction, Lock, Type, Value, ValueError};
use petgraph::{Direction::Outgoing, visit::EdgeRef};

impl Engine {
    /// `newsig`.
    pub(crate) fn new_signal(&mut self, name: &str, ty: Type) -> Result<Ix, Error> {
        self.unlocked(Lock::CONFIG, "signal_new")?;
        let name = Name::parse("signal", name)?;
        if self.graph.signals.contains_key(&name) {
            return Err(Error::Duplicate { what: "signal", name: name.as_str().into() });
        }
        let cell = self.arena.cell(0)?;
        let signal = Signal {
            name: name.clone(),
            ty,
            cell: Ptr(cell),
            queue: None,
            readers: 0,
            writers: 0,
            bidirs: 0,
        };
        let ix = self.graph.g.add_node(Node::Signal(signal));
        self.graph.sites.made(ix);
        self.graph.signals.insert(name, ix);
        Ok(ix)
    }

    /// `delsig`: unlinks its pins first.
    pub(crate) fn delete_signal(&mut self, name: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "signal_delete")?;
        let ix = self.graph.find_signal(name)?;
        let pins = self.graph.pins_of(ix);
        self.unlink_all(&pins)?;
        self.forget_signal(ix);
        Ok(())
    }

    fn forget_signal(&mut self, ix: Ix) {
        if let Some(Node::Signal(s)) = self.graph.g.remove_node(ix) {
            self.graph.signals.remove(&s.name);
            self.graph.sites.forget(ix);
            self.arena.give_cell(s.cell.0);
            drop(s.queue);
        }
    }

    /// `delsig all`.
    pub(crate) fn delete_all_signals(&mut self) -> Result<(), Error> {
        let names: Vec<Name> = self.graph.signals.keys().cloned().collect();
        if names.is_empty() {
            return Err(Error::NoSignals);
        }
        names.iter().try_for_each(|n| self.delete_signal(n.as_str()))
    }

    /// Whether a pin may be linked to a signal.
    fn may_link(&self, pin: Ix, signal: Ix) -> Result<bool, Error> {
        let (Some(p), Some(s)) = (self.graph.item(pin), self.graph.signal(signal)) else {
            return Ok(false);
        };
        let (pin_name, signal_name) = (p.shown().as_str(), s.name.as_str());
        if let Some(old) = self.graph.signal_of(pin) {
            if old == signal {
                return Ok(false);
            }
            let old = self.graph.signal(old).map_or("", |s| s.name.as_str());
            return Err(Error::LinkedElsewhere {
                pin: pin_name.into(),
                signal: old.into(),
                wanted: signal_name.into(),
            });
        }
        if p.ty != s.ty {
            return Err(Error::TypeMismatch {
                pin: pin_name.into(),
                pin_type: p.ty,
                signal: signal_name.into(),
                signal_type: s.ty,
            });
        }
        match p.direction {
            Direction::Out if s.writers + s.bidirs > 0 => {
                Err(Error::HasWriter { signal: signal_name.into(), io: false })
            }
            Direction::Io if s.writers > 0 => {
                Err(Error::HasWriter { signal: signal_name.into(), io: true })
            }
            Direction::Io if s.ty == Type::Port => {
                Err(Error::PortIo { signal: signal_name.into() })
            }
            Direction::In if s.ty == Type::Port && s.readers > 0 => {
                Err(Error::PortReaders { signal: signal_name.into() })
            }
            _ => Ok(true),
        }
    }

    /// `linkps`, `linksp`.
    pub(crate) fn link(&mut self, pin: &str, signal: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "link")?;
        let pin = self.graph.find_pin(pin)?;
        let signal = self.graph.find_signal(signal)?;
        if self.may_link(pin, signal)? {
            self.link_all(&[pin], signal)?;
        }
        Ok(())
    }

    /// Links pins that may be linked: whole or not at all.
    fn link_all(&mut self, pins: &[Ix], signal: Ix) -> Result<(), Error> {
        let mut change = Change::default();
        let Some(s) = self.graph.signal(signal) else { return Ok(()) };
        let (cell, port) = (s.cell, s.ty == Type::Port);
        let (mut readers, mut writers, mut bidirs) = (s.readers, s.writers, s.bidirs);
        for pin in pins {
            let Some((slot, direction)) =
                self.graph.item(*pin).and_then(|p| Some((p.slot()?, p.direction)))
            else {
                continue;
            };
            let first = writers == 0 && bidirs == 0 && (direction != Direction::In || readers == 0);
            if first && !port {
                change.stores.push(Store::Bring { slot: Ptr(slot), cell });
            }
            match direction {
                Direction::In => readers += 1,
                Direction::Out => writers += 1,
                _ => {
                    bidirs += 1;
                    readers += 1;
                }
            }
            let distance = Arena::distance(slot, cell.0);
            change.stores.push(Store::Aim { slot: Ptr(slot), distance });
        }
        self.carry_out(change)?;
        for pin in pins {
            let direction = self.graph.item(*pin).map(|p| p.direction);
            let link = self.graph.g.add_edge(*pin, signal, Edge::Links);
            self.graph.sites.joined(link);
            if let (Some(d), Some(s)) = (direction, self.graph.signal_mut(signal)) {
                s.count(d, true);
            }
        }
        Ok(())
    }

    /// `unlinkp`.
    pub(crate) fn unlink(&mut self, pin: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "unlink")?;
        let pin = self.graph.find_pin(pin)?;
        self.unlink_all(&[pin])
    }

    /// Unlinks pins, those that are linked: whole or not at all.
    pub(crate) fn unlink_all(&mut self, pins: &[Ix]) -> Result<(), Error> {
        let change = Change { stores: self.unlinking(pins), lists: Vec::new() };
        self.carry_out(change)?;
        self.forget_links(pins);
        Ok(())
    }

    /// The stores that unlink pins: each keeps its signal's last value.
    pub(crate) fn unlinking(&self, pins: &[Ix]) -> Vec<Store> {
        let mut stores = Vec::new();
        for pin in pins {
            let signal = self.graph.signal_of(*pin).and_then(|s| self.graph.signal(s));
            let slot = self.graph.item(*pin).and_then(crate::graph::Item::slot);
            let (Some(signal), Some(slot)) = (signal, slot) else { continue };
            stores.push(if signal.ty == Type::Port {
                Store::Put { cell: crate::item::own_cell(Ptr(slot)), bits: 0 }
            } else {
                Store::Keep { cell: signal.cell, slot: Ptr(slot) }
            });
            stores.push(Store::Aim { slot: Ptr(slot), distance: Slot::OWN });
        }
        stores
    }

    /// Removes the links of pins that were unlinked.
    pub(crate) fn forget_links(&mut self, pins: &[Ix]) {
        for pin in pins {
            let link = self.graph.g.edges_directed(*pin, Outgoing);
            let link = link.into_iter().find(|e| *e.weight() == Edge::Links);
            let Some((edge, signal)) = link.map(|e| (e.id(), e.target())) else { continue };
            self.graph.g.remove_edge(edge);
            self.graph.sites.parted(edge);
            let direction = self.graph.item(*pin).map(|p| p.direction);
            if let (Some(d), Some(s)) = (direction, self.graph.signal_mut(signal)) {
                s.count(d, false);
            }
        }
    }

    /// `net`: everything is checked before anything changes.
    pub(crate) fn net(&mut self, name: &str, pins: &[String]) -> Result<(), Error> {
        if pins.is_empty() {
            return Err(Error::NoPins);
        }
        let signal = self.graph.signals.get(name).copied();
        let seen = signal.and_then(|ix| self.graph.signal(ix));
        let mut ty = seen.map(|s| s.ty);
        let mut writer: Option<Box<str>> = None;
        let mut bidir: Option<Box<str>> = None;
        let mut readers = seen.map_or(0, |s| s.readers);
        if let Some(ix) = signal {
            for pin in self.graph.pins_of(ix) {
                let Some(p) = self.graph.item(pin) else { continue };
                match p.direction {
                    Direction::Out => writer = Some(p.shown().as_str().into()),
                    Direction::Io => bidir = Some(p.shown().as_str().into()),
                    _ => {}
                }
            }
        }
        let mut new: Vec<Ix> = Vec::new();
        for word in pins {
            let ix = self.graph.pins.get(word.as_str()).copied().ok_or_else(|| {
                let names = self.graph.pins.keys().map(Name::as_str);
                Error::NoPin { name: word.as_str().into(), near: crate::near::nearest(word, names) }
            })?;
            let Some(p) = self.graph.item(ix) else { continue };
            if let Some(old) = self.graph.signal_of(ix) {
                if Some(old) == signal {
                    continue;
                }
                let old = self.graph.signal(old).map_or("", |s| s.name.as_str());
                return Err(Error::AlreadyLinked { pin: word.as_str().into(), signal: old.into() });
            }
            if new.contains(&ix) {
                continue;
            }
            let want = *ty.get_or_insert(p.ty);
            if want != p.ty {
                return Err(Error::CannotAdd {
                    signal: name.into(),
                    ty: want,
                    pin: word.as_str().into(),
                    pin_type: p.ty,
                });
            }
            let second = |other_direction: &'static str, other: &str| Error::SecondWriter {
                signal: name.into(),
                direction: p.direction.name(),
                pin: word.as_str().into(),
                other_direction,
                other: other.into(),
            };
            match (p.direction, &writer, &bidir) {
                (Direction::Out | Direction::Io, Some(w), _) => return Err(second("OUT", w)),
                (Direction::Out, None, Some(b)) => return Err(second("I/O", b)),
                (Direction::Out, None, None) => writer = Some(p.shown().as_str().into()),
                (Direction::Io, None, _) => {
                    if p.ty == Type::Port {
                        return Err(Error::PortIo { signal: name.into() });
                    }
                    bidir = Some(p.shown().as_str().into());
                    readers += 1;
                }
                _ => {
                    if p.ty == Type::Port && readers > 0 {
                        return Err(Error::PortReaders { signal: name.into() });
                    }
                    readers += 1;
                }
            }
            new.push(ix);
        }
        if self.graph.pins.contains_key(name) {
            return Err(Error::SignalIsPin { name: name.into() });
        }
        self.unlocked(Lock::CONFIG, if signal.is_none() { "signal_new" } else { "link" })?;
        let made = signal.is_none();
        let signal = match (signal, ty) {
            (Some(s), _) => s,
            (None, Some(ty)) => self.new_signal(name, ty)?,
            (None, None) => return Err(Error::NoPins),
        };
        let linked = self.link_all(&new, signal);
        if linked.is_err() && made {
            self.forget_signal(signal);
        }
        linked
    }

    /// `setp`.
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
        item.put(value.bits());
        self.graph.sites.assigned(ix, value.bits());
        Ok(())
    }

    /// `getp`.
    pub(crate) fn get_item(&self, name: &str) -> Result<Value, Error> {
        let ix = self.graph.find_item(name)?;
        let item = self.graph.item(ix);
        Ok(item.map_or(Value::Bit(false), |i| Graph::value(i.ty, i.bits())))
    }

    /// `gets`.
    pub(crate) fn get_signal(&self, name: &str) -> Result<Value, Error> {
        let ix = self.graph.find_signal(name).map_err(Error::of_value)?;
        let signal = self.graph.signal(ix);
        Ok(signal.map_or(Value::Bit(false), |s| Graph::value(s.ty, s.bits())))
    }

    /// `sets`; for a port, the size of its queue, once.
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
        self.graph.sites.assigned(ix, bits);
        if let Value::Port(size) = value {
            let data: Box<[crate::sync::AtomicU8]> =
                (0..size).map(|_| crate::sync::AtomicU8::new(0)).collect();
            // SAFETY: both live in the signal until no cell holds the address.
            let queue = Box::new(unsafe { PortQueue::new(data.as_ptr(), size) });
            bits = (&raw const *queue).expose_provenance() as u64;
            if let Some(s) = self.graph.signal_mut(ix) {
                s.queue = Some(Queue { queue, data });
            }
        }
        // SAFETY: a live cell of the arena.
        unsafe { cell.0.as_ref() }.store(bits);
        Ok(())
    }

    /// `alias`.
    pub(crate) fn alias(&mut self, param: bool, name: &str, alias: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, if param { "param_alias" } else { "pin_alias" })?;
        let what = if param { "parameter" } else { "pin" };
        let alias = Name::parse(what, alias)?;
        let ix = crate::graph::find(self.graph.names(param), what, name)?;
        if self.graph.names(param).contains_key(&alias) {
            return Err(Error::Duplicate { what: "pin/alias name", name: alias.as_str().into() });
        }
        let old = self.graph.item_mut(ix).and_then(|i| i.alias.replace(alias.clone()));
        let names = self.graph.names_mut(param);
        if let Some(old) = old {
            names.remove(&old);
        }
        names.insert(alias, ix);
        self.graph.sites.named(ix);
        Ok(())
    }

    /// `unalias`.
    pub(crate) fn unalias(&mut self, param: bool, name: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, if param { "param_alias" } else { "pin_alias" })?;
        let what = if param { "parameter" } else { "pin" };
        let ix = crate::graph::find(self.graph.names(param), what, name)?;
        if let Some(old) = self.graph.item_mut(ix).and_then(|i| i.alias.take()) {
            self.graph.names_mut(param).remove(&old);
        }
        Ok(())
    }
}

/// A user's text as a value of a type.
pub(crate) fn parse(what: &'static str, name: &str, ty: Type, text: &str) -> Result<Value, Error> {
    let expects = ty.expects();
    Value::parse(ty, text).map_err(|e| match e {
        ValueError::Invalid => Error::InvalidValue { what, name: name.into(), expects },
        ValueError::Range => Error::OutOfRange { what, name: name.into(), expects },
    })
}
