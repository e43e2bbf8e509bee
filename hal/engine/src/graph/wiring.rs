//! Signals and links: their rules, and the stores that carry them out.

use crate::{
    Error,
    change::staged::PendingRemoval,
    change::stores::Store,
    change::undo::Undo,
    graph::arena::Arena,
    graph::model::Model,
    graph::names::Index,
    graph::ptr::Ptr,
    graph::ptr::own_cell,
    graph::{Ix, Node, Signal},
    name::Name,
};
use hal_abi::Slot;
use hal_protocol::{Direction, Lock, Type};

impl Model {
    /// Executes `newsig`.
    pub(crate) fn new_signal(&mut self, name: &str, ty: Type) -> Result<Ix, Error> {
        self.unlocked(Lock::CONFIG, "signal_new")?;
        let name = Name::parse("signal", name)?;
        if self.graph.signal_named(name.as_str()).is_some() {
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
        let ix = self.graph.g.add_node(Node::Signal(Box::new(signal)));
        self.graph.sites.made(ix);
        self.graph.add_name(Index::Signals, &name, ix);
        self.staged.undo_by(Undo::Signal(ix));
        Ok(ix)
    }

    /// Executes `delsig`. Unlinks the pins of the signal first.
    pub(crate) fn delete_signal(&mut self, name: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "signal_delete")?;
        let ix = self.graph.find_signal(name)?;
        self.unlink_all(&self.graph.pins_of(ix));
        if let Some(s) = self.graph.signal(ix) {
            let name = s.name.clone();
            self.unname(Index::Signals, &name, ix);
        }
        self.staged.remove(PendingRemoval::Signal(ix));
        Ok(())
    }

    /// Executes `delsig all`.
    pub(crate) fn delete_all_signals(&mut self) -> Result<(), Error> {
        let names: Vec<Name> =
            self.graph.signal_names().into_iter().map(|(name, _)| name.clone()).collect();
        if names.is_empty() {
            return Err(Error::NoSignals);
        }
        names.iter().try_for_each(|n| self.delete_signal(n.as_str()))
    }

    /// Checks whether a pin may be linked to a signal. Returns false if it is already linked to
    /// that signal.
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

    /// Executes `linkps` and `linksp`.
    pub(crate) fn link(&mut self, pin: &str, signal: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "link")?;
        let pin = self.graph.find_pin(pin)?;
        let signal = self.graph.find_signal(signal)?;
        if self.may_link(pin, signal)? {
            self.link_all(&[pin], signal);
        }
        Ok(())
    }

    /// Links pins that have been checked.
    fn link_all(&mut self, pins: &[Ix], signal: Ix) {
        for pin in pins {
            let Some(s) = self.graph.signal(signal) else { continue };
            let Some(p) = self.graph.item(*pin) else { continue };
            let Some(slot) = p.slot() else { continue };
            let first =
                s.writers == 0 && s.bidirs == 0 && (p.direction != Direction::In || s.readers == 0);
            let cell = s.cell;
            if first && s.ty != Type::Port {
                self.staged.store(Store::CopyIn { slot: Ptr(slot), cell });
            }
            let distance = Arena::distance(slot, cell.0);
            self.staged.stores(Store::aimed(slot, distance, p.pointer(), cell));
            let link = self.graph.draw_link(*pin, signal);
            self.graph.sites.joined(link);
            self.staged.undo_by(Undo::Linked(*pin));
        }
    }

    /// Executes `unlinkp`.
    pub(crate) fn unlink(&mut self, pin: &str) -> Result<(), Error> {
        self.unlocked(Lock::CONFIG, "unlink")?;
        let pin = self.graph.find_pin(pin)?;
        self.unlink_all(&[pin]);
        Ok(())
    }

    /// Unlinks pins. Each keeps its signal's last value. Pins that are not linked are skipped.
    pub(crate) fn unlink_all(&mut self, pins: &[Ix]) {
        for pin in pins {
            let signal = self.graph.signal_of(*pin).and_then(|s| self.graph.signal(s));
            let item = self.graph.item(*pin);
            let slot = item.and_then(crate::graph::Item::slot);
            let (Some(signal), Some(slot)) = (signal, slot) else { continue };
            self.staged.store(if signal.ty == Type::Port {
                Store::Put { cell: own_cell(Ptr(slot)), bits: 0 }
            } else {
                Store::CopyOut { cell: signal.cell, slot: Ptr(slot) }
            });
            let (cell, pointer) = (own_cell(Ptr(slot)), item.and_then(crate::graph::Item::pointer));
            self.staged.stores(Store::aimed(slot, Slot::OWN, pointer, cell));
            if let Some((signal, site)) = self.graph.remove_link(*pin) {
                self.staged.undo_by(Undo::Unlinked(*pin, signal, site));
            }
        }
    }

    /// Executes `net`. Checks everything before anything changes.
    pub(crate) fn net(&mut self, name: &str, pins: &[String]) -> Result<(), Error> {
        if pins.is_empty() {
            return Err(Error::NoPins);
        }
        let signal = self.graph.signal_named(name);
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
            let ix = self.graph.pin_named(word).ok_or_else(|| {
                let names = self.graph.item_names(false);
                let names = names.into_iter().map(|(name, _)| name.as_str());
                Error::NoPin { name: word.as_str().into(), near: self.graph.near(word, names) }
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
        if self.graph.pin_named(name).is_some() {
            return Err(Error::SignalIsPin { name: name.into() });
        }
        self.unlocked(Lock::CONFIG, if signal.is_none() { "signal_new" } else { "link" })?;
        let signal = match (signal, ty) {
            (Some(s), _) => s,
            (None, Some(ty)) => self.new_signal(name, ty)?,
            (None, None) => return Err(Error::NoPins),
        };
        self.link_all(&new, signal);
        Ok(())
    }
}
