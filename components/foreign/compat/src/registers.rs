//! Realtime. Simulated I/O ports in memory, with pins that show and drive their bits.
//!
//! A component that claims ports while it is loaded gets, for each byte, the pins `COMPONENT.sim.PORT` (the value last
//! written) and `COMPONENT.sim.PORT-in`, and for each bit the same with `-BIT`; PORT is the address in hexadecimal. A
//! read of a byte returns the value written, with every bit set that an input pin sets. Ports 0xCF8 and 0xCFC access
//! the PCI configuration: `COMPONENT.sim.config-RR` is the double word at RR, of any device. `COMPONENT.sim.reads` and
//! `.writes` count accesses. The initial contents come from the file beside the component's (see `board.rs`).

use crate::loading::{Loading, loading};
use core::ptr;
use hal_component::abi::{ItemSpec, Slot, Str, dir, item_flags, size, ty};
use std::sync::atomic::{
    AtomicPtr, AtomicU8, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

/// Ports of the PCI configuration's address and value.
const CONFIG_ADDRESS: u16 = 0xCF8;
const CONFIG_VALUE: u16 = 0xCFC;

/// Claimed ports of one component.
#[derive(Debug, Default)]
pub(crate) struct Registers {
    blocks: Kept<Block>,
    config: Kept<Word>,
    /// Address of the next access to the configuration.
    chosen: AtomicU32,
    reads: Count,
    writes: Count,
}

/// Pin that counts.
#[derive(Debug, Default)]
struct Count(AtomicPtr<Slot>);

/// Block of ports.
#[derive(Debug)]
struct Block {
    base: u16,
    bytes: Vec<Byte>,
}

#[derive(Debug)]
struct Byte {
    value: AtomicU8,
    shown: Pins,
    driven: Pins,
}

/// Pins of a byte and its bits.
#[derive(Debug)]
struct Pins {
    whole: *const Slot,
    bits: [*const Slot; 8],
}

/// Double word of PCI configuration.
#[derive(Debug)]
struct Word {
    register: u8,
    pin: *const Slot,
}

/// List that only grows, so that it can be read while something is added.
#[derive(Debug)]
struct Kept<T>(AtomicPtr<Node<T>>);

#[derive(Debug)]
struct Node<T> {
    thing: T,
    /// Fixed once the node is in the list.
    next: AtomicPtr<Self>,
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self(AtomicPtr::new(ptr::null_mut()))
    }
}

impl<T> Kept<T> {
    /// Adds an item at the front.
    fn keep(&self, thing: T) {
        let mut node = Box::new(Node { thing, next: AtomicPtr::new(self.0.load(Relaxed)) });
        loop {
            let next = *node.next.get_mut();
            let new = Box::into_raw(node);
            // Pairs with `each`.
            let Err(other) = self.0.compare_exchange(next, new, Release, Relaxed) else { return };
            // SAFETY: made above, and not published.
            node = unsafe { Box::from_raw(new) };
            *node.next.get_mut() = other;
        }
    }

    /// Iterates over the items, the latest first.
    fn each(&self) -> impl Iterator<Item = &T> {
        // Pairs with `keep`. SAFETY: made by `Box::into_raw`, freed with the list.
        let first = unsafe { self.0.load(Acquire).as_ref() };
        // SAFETY: as above.
        let next = |node: &&Node<T>| unsafe { node.next.load(Relaxed).as_ref() };
        let all = core::iter::successors(first, next);
        all.map(|node| &node.thing)
    }
}

impl<T> Drop for Kept<T> {
    fn drop(&mut self) {
        let mut next = *self.0.get_mut();
        while !next.is_null() {
            // SAFETY: made by `Box::into_raw` in `keep`, freed once.
            next = unsafe { Box::from_raw(next) }.next.into_inner();
        }
    }
}

impl Count {
    /// Makes its pin, unless it exists.
    fn show(&self, l: &Loading, name: &str, about: &str) {
        if self.0.load(Relaxed).is_null() {
            let slot = item(l, &format!("sim.{name}"), about, ty::U32, dir::OUT);
            self.0.store(slot.cast_mut(), Release); // Pairs with `more`.
        }
    }

    /// Realtime. Adds one.
    fn more(&self) {
        let slot = self.0.load(Acquire).cast_const(); // Pairs with `show`.
        store(slot, load(slot).wrapping_add(1) & u64::from(u32::MAX));
    }
}

impl Registers {
    /// Claims ports. They get pins only while the component is being loaded.
    pub(crate) fn claim(&self, base: u16, count: u16) {
        let Some(l) = loading() else { return };
        self.count(l);
        let mut bytes: Vec<Byte> = Vec::new();
        let end = base.saturating_add(count);
        for port in base..end {
            let free = self.byte(port).is_none();
            if free && !(CONFIG_ADDRESS..CONFIG_VALUE + 4).contains(&port) {
                bytes.push(Byte::new(l, port));
            } else {
                self.keep_block(port, &mut bytes);
            }
        }
        self.keep_block(end, &mut bytes);
    }

    /// Claims ports with an initial value of each byte.
    pub(crate) fn claim_as(&self, base: u16, count: u16, value: u8) {
        self.claim(base, count);
        for port in base..base.saturating_add(count) {
            if let Some(byte) = self.byte(port) {
                byte.set(value);
            }
        }
    }

    /// Sets the initial value of the configuration's double word at `register`.
    pub(crate) fn configure(&self, register: u8, value: u32) {
        if let Some(word) = self.word_at(register & !3) {
            word.set(value);
        }
    }

    fn count(&self, l: &Loading) {
        self.reads.show(l, "reads", "Reads of ports so far");
        self.writes.show(l, "writes", "Writes of ports so far");
    }

    /// Stores the ports before `end` as a block.
    fn keep_block(&self, end: u16, bytes: &mut Vec<Byte>) {
        let count = u16::try_from(bytes.len()).unwrap_or(0);
        if count > 0 {
            let bytes = core::mem::take(bytes);
            self.blocks.keep(Block { base: end.saturating_sub(count), bytes });
        }
    }

    fn byte(&self, port: u16) -> Option<&Byte> {
        self.blocks.each().find_map(|b| b.bytes.get(usize::from(port.checked_sub(b.base)?)))
    }

    /// Realtime. Reads a port of `width` bytes; returns all ones where no port is claimed.
    pub(crate) fn read(&self, port: u16, width: u16) -> u32 {
        self.reads.more();
        if port == CONFIG_ADDRESS && width == 4 {
            return self.chosen.load(Relaxed);
        }
        if (CONFIG_VALUE..CONFIG_VALUE + 4).contains(&port) {
            let shift = u32::from(port - CONFIG_VALUE) * 8;
            return self.word().map_or(0, Word::get) >> shift & ones(width);
        }
        (0..width).rev().fold(0, |value, i| {
            let byte = port.checked_add(i).and_then(|port| self.byte(port));
            value << 8 | u32::from(byte.map_or(0xFF, Byte::get))
        })
    }

    /// Realtime. Writes a port of `width` bytes; ignored where no port is claimed.
    pub(crate) fn write(&self, port: u16, width: u16, value: u32) {
        self.writes.more();
        if port == CONFIG_ADDRESS && width == 4 {
            self.chosen.store(value, Relaxed);
            return;
        }
        if (CONFIG_VALUE..CONFIG_VALUE + 4).contains(&port) {
            let shift = u32::from(port - CONFIG_VALUE) * 8;
            if let Some(word) = self.word() {
                let mask = ones(width) << shift;
                word.set(word.get() & !mask | value << shift & mask);
            }
            return;
        }
        for (i, b) in (0..width).zip(value.to_le_bytes()) {
            if let Some(byte) = port.checked_add(i).and_then(|port| self.byte(port)) {
                byte.set(b);
            }
        }
    }

    /// Returns the selected double word of configuration; makes it while the component is being loaded.
    fn word(&self) -> Option<&Word> {
        let [low, ..] = self.chosen.load(Relaxed).to_le_bytes();
        self.word_at(low & !3)
    }

    fn word_at(&self, register: u8) -> Option<&Word> {
        let find = || self.config.each().find(|w| w.register == register);
        if find().is_none() {
            let l = loading()?;
            self.count(l);
            let name = format!("sim.config-{register:02x}");
            let about = "Double word of the PCI configuration";
            let pin = item(l, &name, about, ty::U32, dir::IO);
            self.config.keep(Word { register, pin });
        }
        find()
    }
}

/// Returns a mask of this number of bytes.
const fn ones(width: u16) -> u32 {
    if width >= 4 { u32::MAX } else { (1 << (width * 8)) - 1 }
}

impl Byte {
    fn new(l: &Loading, port: u16) -> Self {
        let name = format!("sim.{port:04x}");
        Self {
            value: AtomicU8::new(0),
            shown: Pins::new(l, &name, "as last written", dir::OUT),
            driven: Pins::new(l, &format!("{name}-in"), "that the port reads as set", dir::IN),
        }
    }

    fn get(&self) -> u8 {
        self.value.load(Relaxed) | self.driven.get()
    }

    fn set(&self, value: u8) {
        self.value.store(value, Relaxed);
        self.shown.set(value);
    }
}

impl Pins {
    fn new(l: &Loading, name: &str, about: &str, dir: u8) -> Self {
        let bit = |i: usize| {
            item(l, &format!("{name}-{i}"), &format!("Raw bit {i} {about}"), ty::BIT, dir)
        };
        let whole = item(l, name, &format!("Raw byte {about}, 0 to 255"), ty::U32, dir);
        Self { whole, bits: core::array::from_fn(bit) }
    }

    fn set(&self, value: u8) {
        store(self.whole, u64::from(value));
        for (i, pin) in self.bits.iter().enumerate() {
            store(*pin, u64::from(value >> i & 1));
        }
    }

    fn get(&self) -> u8 {
        let [whole, ..] = load(self.whole).to_le_bytes();
        let set = |(i, pin): (usize, &*const Slot)| u8::from(load(*pin) & 0xFF != 0) << i;
        self.bits.iter().enumerate().map(set).fold(whole, |all, bit| all | bit)
    }
}

impl Word {
    fn get(&self) -> u32 {
        let [a, b, c, d, ..] = load(self.pin).to_le_bytes();
        u32::from_le_bytes([a, b, c, d])
    }

    fn set(&self, value: u32) {
        store(self.pin, u64::from(value));
    }
}

fn load(slot: *const Slot) -> u64 {
    if slot.is_null() {
        return 0;
    }
    // SAFETY: a slot of the engine's, which outlives the component.
    unsafe { Slot::cell(slot) }.load()
}

fn store(slot: *const Slot, bits: u64) {
    if !slot.is_null() {
        // SAFETY: as above.
        unsafe { Slot::cell(slot) }.store(bits);
    }
}

/// Makes a pin of simulated hardware; null if the engine refused it.
fn item(l: &Loading, name: &str, about: &str, ty: u8, dir: u8) -> *const Slot {
    let name = format!("{}.{name}", l.module.name.to_string_lossy());
    let spec = ItemSpec {
        size: size::<ItemSpec>(),
        flags: item_flags::HIDDEN,
        name: Str::borrow(&name),
        doc: Str::borrow(about),
        old_name: Str::NONE,
        initial: 0,
        storage: ptr::null_mut(),
        ty,
        dir,
    };
    let mut slot = ptr::null();
    if let Some(make) = l.host.item {
        // SAFETY: the engine's function; both records live across the call.
        unsafe { make(l.host.ctx, &raw const spec, &raw mut slot) };
    }
    slot
}

#[cfg(test)]
mod tests {
    use super::{Block, Byte, Pins, Registers};
    use std::sync::atomic::AtomicU8;

    fn bare() -> Byte {
        let pins = || Pins { whole: core::ptr::null(), bits: [core::ptr::null(); 8] };
        Byte { value: AtomicU8::new(0), shown: pins(), driven: pins() }
    }

    #[test]
    fn wide_accesses_reach_every_byte() {
        let r = Registers::default();
        r.blocks.keep(Block { base: 0x10, bytes: vec![bare(), bare(), bare()] });
        r.write(0x11, 4, 0xAABB_CCDD);
        assert_eq!(r.read(0x10, 1), 0);
        assert_eq!(r.read(0x10, 4), 0xFFCC_DD00);
        assert_eq!(r.read(0x12, 2), 0xFFCC);
        assert_eq!(r.read(0x20, 1), 0xFF);
        r.write(0xCF8, 4, 0x8000_8888);
        assert_eq!((r.read(0xCF8, 4), r.read(0xCFC, 4)), (0x8000_8888, 0));
    }

    #[test]
    fn every_claim_is_kept() {
        let r = Registers::default();
        for base in (0x1000..0x2000).step_by(4) {
            r.blocks.keep(Block { base, bytes: vec![bare(), bare()] });
        }
        for (base, value) in (0x1000..0x2000).step_by(4).zip(0_u32..) {
            r.write(base, 2, value);
        }
        for (base, value) in (0x1000..0x2000).step_by(4).zip(0_u32..) {
            assert_eq!(r.read(base, 4), 0xFFFF_0000 | value, "{base:#x}");
        }
    }
}
