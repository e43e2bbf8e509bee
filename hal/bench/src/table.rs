//! State of the bench, and the arguments of components and commands.

use core::ffi::c_void;
use hal_component::abi::{
    self, ArgSpec, ArgValue, CommandRun, Free, PortQueue, Run, Slot, Str, StreamRef, Ticket, Use,
    Work, arg,
};
use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    sync::atomic::{AtomicI64, AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed},
};

/// A pin or parameter on the bench.
pub(super) struct Laid {
    /// Slot of the item, and a second slot whose own cell serves as the signal that the item may be
    /// linked to.
    pub(super) slots: Box<[Slot; 2]>,
    pub(super) ty: u8,
    pub(super) dir: u8,
}

pub(super) struct Code<R> {
    pub(super) run: R,
    pub(super) state: *mut c_void,
    pub(super) free: Option<Free>,
    pub(super) uses: Vec<Use>,
}

impl<R> Drop for Code<R> {
    fn drop(&mut self) {
        if let Some(free) = self.free {
            // SAFETY: the state came with this function and is freed once.
            unsafe { free(self.state) };
        }
    }
}

#[derive(Default)]
pub(super) struct Table {
    pub(super) functs: BTreeMap<String, Code<Run>>,
    pub(super) tasks: BTreeMap<String, (i64, Code<Run>)>,
    pub(super) workers: BTreeMap<String, Code<Work>>,
    pub(super) snapshots: BTreeMap<String, super::work::Memory>,
    pub(super) commands: BTreeMap<String, (Vec<ArgSpec>, Code<CommandRun>)>,
    pub(super) opens: Vec<Code<CommandRun>>,
    pub(super) stops: Vec<Code<CommandRun>>,
    pub(super) services: BTreeMap<String, (u32, *const c_void, Option<Code<()>>)>,
    pub(super) threads: Vec<(String, i64)>,
    pub(super) items: BTreeMap<String, Laid>,
    pub(super) old_names: BTreeMap<String, String>,
    pub(super) rings: BTreeMap<String, (Vec<u64>, StreamRef)>,
    pub(super) ports: Vec<(Box<PortQueue>, Box<[AtomicU8]>)>,
    pub(super) args: Args,
    pub(super) failed: String,
    pub(super) now: AtomicI64,
    pub(super) gaps: AtomicU32,
    pub(super) failed_hardware: AtomicU64,
    pub(super) tick: i64,
    pub(super) said: RefCell<Vec<String>>,
    pub(super) fault: RefCell<String>,
    pub(super) replies: RefCell<Vec<String>>,
    #[expect(clippy::vec_box, reason = "a ticket must not move")]
    pub(super) tickets: RefCell<Vec<Box<Ticket>>>,
    pub(super) awaited: Cell<bool>,
    pub(super) call_args: RefCell<Args>,
    /// People elsewhere have given the command.
    pub(super) is_from_afar: Cell<bool>,
}

impl Table {
    /// Counts a part of hardware that has failed, or that works again.
    pub(super) fn note_hardware(&self, failed: bool) {
        let change = if failed { abi::HARDWARE_FAILURE | 1 } else { u64::MAX };
        self.failed_hardware.fetch_add(change, Relaxed);
    }
}

/// Arguments as given, checked against their declaration, and the lists that argument values point
/// to.
#[derive(Default)]
pub(super) struct Args {
    pub(super) specs: Vec<ArgSpec>,
    pub(super) given: BTreeMap<String, String>,
    pub(super) ints: Vec<Box<[i64]>>,
    pub(super) texts: Vec<Box<[Str]>>,
}

impl Args {
    pub(super) fn new(specs: Vec<ArgSpec>, words: &[&str]) -> Result<Self, String> {
        let mut given = BTreeMap::new();
        for word in words {
            let (name, value) =
                word.split_once('=').ok_or_else(|| format!("Invalid parameter `{word}'"))?;
            // SAFETY: the strings of a declaration are static.
            if !specs.iter().any(|s| unsafe { s.name.get() } == Some(name)) {
                return Err(format!("Unknown parameter `{word}'"));
            }
            given.insert(name.to_owned(), value.to_owned());
        }
        for s in &specs {
            // SAFETY: the strings of a declaration are static.
            let name = unsafe { s.name.get() }.unwrap_or_default();
            if s.required != 0 && !given.contains_key(name) {
                return Err(format!("parameter `{name}' is missing"));
            }
            let text = given.get(name).map_or("", String::as_str);
            let wrong = text.split(',').find(|item| {
                let number = match s.kind {
                    arg::INT | arg::INTS => int(item).map(|n| n as f64),
                    arg::FLOAT => item.parse().ok(),
                    _ => None,
                };
                number.is_some_and(|n| !s.allows(n))
            });
            if let Some(wrong) = wrong {
                return Err(format!("`{wrong}' out of range for parameter `{name}={text}'"));
            }
        }
        Ok(Self { specs, given, ..Self::default() })
    }

    pub(super) fn get(&mut self, name: &str) -> Option<ArgValue> {
        // SAFETY: the strings of a declaration are static.
        let spec = self.specs.iter().find(|s| unsafe { s.name.get() } == Some(name))?;
        // SAFETY: as above.
        let default = unsafe { spec.default.get() }.filter(|d| !d.is_empty());
        let text = self.given.get(name).map(String::as_str).or(default)?;
        let mut value = ArgValue { size: abi::size::<ArgValue>(), given: 1, ..ArgValue::NONE };
        match spec.kind {
            arg::INT => value.int = int(text)?,
            arg::BIT => value.int = i64::from(matches!(text, "1" | "TRUE" | "true" | "yes" | "on")),
            arg::FLOAT => value.float = text.parse().ok()?,
            arg::INTS => {
                let list: Option<Box<[i64]>> = text.split(',').map(int).collect();
                let list = list?;
                (value.ints, value.len) = (list.as_ptr(), list.len());
                self.ints.push(list);
            }
            arg::TEXTS => {
                let list: Box<[Str]> = text.split(',').map(Str::borrow).collect();
                (value.texts, value.len) = (list.as_ptr(), list.len());
                self.texts.push(list);
            }
            _ => value.text = Str::borrow(text),
        }
        Some(value)
    }
}

pub(super) fn int(text: &str) -> Option<i64> {
    let hex = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    hex.map_or_else(|| text.parse().ok(), |h| i64::from_str_radix(h, 16).ok())
}
