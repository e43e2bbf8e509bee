//! A table for one or a few components, without an engine: set pins, run functions, read pins.
//!
//! ```
//! # use hal_component::{Component, In, Out, Period, Update, bench::Bench};
//! # /// Inverts.
//! # #[derive(Component)]
//! # struct Not {
//! #     /// Input.
//! #     in_: In<bool>,
//! #     /// Output.
//! #     out: Out<bool>,
//! # }
//! # impl Update for Not {
//! #     fn update(&mut self, _: Period) {
//! #         self.out.set(!self.in_.get());
//! #     }
//! # }
//! let mut bench = Bench::new();
//! bench.load::<Not>(&["count=2"]).unwrap();
//! bench.set("not.1.in", false);
//! bench.run("not.1", 1_000_000);
//! assert!(bench.get::<bool>("not.1.out"));
//! ```

mod host;
mod random;
mod response;
mod table;

pub use random::Random;
pub use response::response;

use table::{Args, Laid, Table, int};

use crate::{
    Component, Value,
    abi::{
        self, CallHost, CommandRun, Host, PortQueue, Slot, Str, TicketState, Use, component_flags,
        host_flags,
    },
};
use core::ffi::c_void;
use std::{
    cell::RefCell,
    sync::atomic::{AtomicU8, Ordering::Relaxed},
};

/// From a slot to its signal's cell: beyond the slot, the own cell of the one after it.
const SIGNAL: i32 = 16 + Slot::OWN;
const _: () = assert!(size_of::<Slot>() == 16);

/// The table. Every method panics on a name that is not there, as a test should.
pub struct Bench {
    table: Box<RefCell<Table>>,
    calls: Box<CallHost>,
    flags: u32,
}

impl Default for Bench {
    fn default() -> Self {
        Self::new()
    }
}

impl core::fmt::Debug for Bench {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Bench").field("items", &self.names()).finish_non_exhaustive()
    }
}

#[expect(clippy::unwrap_used, clippy::panic, reason = "a table for tests")]
impl Bench {
    /// An empty table: hardware simulated, the clock virtual and at zero.
    #[must_use]
    pub fn new() -> Self {
        let table: Box<RefCell<Table>> = Box::default();
        let flags = host_flags::SIMULATED | host_flags::VIRTUAL;
        let calls = Box::new(CallHost {
            size: abi::size::<CallHost>(),
            flags,
            ctx: (&raw const *table).cast(),
            message: Some(host::message),
            now: Some(host::now),
            fail: Some(host::fail_call),
            arg: Some(host::arg_call),
            reply: Some(host::reply),
            ticket: Some(host::ticket),
            awaited: Some(host::awaited),
        });
        Self { table, calls, flags }
    }

    /// An empty table whose clock is real: each reading of it takes `tick_ns`.
    #[must_use]
    pub fn real_time(tick_ns: i64) -> Self {
        let mut bench = Self::new();
        bench.flags &= !host_flags::VIRTUAL;
        bench.calls.flags = bench.flags;
        bench.table.borrow_mut().tick = tick_ns;
        bench
    }

    /// The same table, with hardware that is not simulated.
    #[must_use]
    pub fn with_hardware(mut self) -> Self {
        self.flags &= !host_flags::SIMULATED;
        self.calls.flags = self.flags;
        self
    }

    /// The same table, as in a machine from an INI file: motion needs an interlock.
    #[must_use]
    pub fn with_interlock(mut self) -> Self {
        self.flags |= host_flags::INTERLOCK;
        self.calls.flags = self.flags;
        self
    }

    /// Creates instances as `loadrt` would, and opens them.
    ///
    /// # Errors
    /// What the component or its declaration refused.
    pub fn load<C: Component>(&mut self, args: &[&str]) -> Result<(), String> {
        self.create::<C>(args)?;
        self.open()
    }

    /// Creates instances as `loadrt` would, and does not open them.
    ///
    /// # Errors
    /// What the component or its declaration refused.
    pub fn create<C: Component>(&mut self, args: &[&str]) -> Result<(), String> {
        let once = C::FLAGS & component_flags::ONCE != 0;
        let (mut names, mut personality, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        for a in args {
            match a.split_once('=') {
                Some(("count", n)) if !once => {
                    let n: u32 = n.parse().map_err(|_| format!("`{n}' invalid"))?;
                    names.extend((0..n).map(|i| format!("{}.{i}", C::NAME.replace('_', "-"))));
                }
                Some(("names", list)) if !once => names.extend(list.split(',').map(str::to_owned)),
                Some(("personality", list)) => {
                    personality = list.split(',').map(|p| int(p).unwrap()).collect();
                }
                _ => rest.push(*a),
            }
        }
        if names.is_empty() {
            let name = C::NAME.replace('_', "-");
            names.push(if once { name } else { format!("{name}.0") });
        }
        self.table.borrow_mut().args = Args::new(C::ARGS.iter().map(|a| **a).collect(), &rest)?;
        for (i, name) in names.iter().enumerate() {
            let host = Host {
                size: abi::size::<Host>(),
                abi_minor: abi::ABI_MINOR,
                flags: self.flags,
                index: u32::try_from(i).unwrap(),
                personality: personality.get(i).copied().unwrap_or(0),
                prefix: Str::borrow(name),
                ctx: (&raw const *self.table).cast_mut().cast(),
                calls: &raw const *self.calls,
                fail: Some(host::fail),
                arg: Some(host::arg_value),
                item: Some(host::item),
                funct: Some(host::funct),
                thread: Some(host::thread),
                task: Some(host::task),
                command: Some(host::command),
                open: Some(host::open),
                stop: Some(host::stop),
                stream: Some(host::stream),
                offer: Some(host::offer),
                find: Some(host::find),
                bind: Some(host::bind),
            };
            // SAFETY: `host` lives across the call.
            let status = unsafe { crate::create::<C>(&raw const host) };
            if !status.is_ok() {
                let text = core::mem::take(&mut self.table.borrow_mut().failed);
                return Err(if text.is_empty() { format!("{status:?}") } else { text });
            }
        }
        Ok(())
    }

    /// Opens what was created.
    ///
    /// # Errors
    /// What the component met.
    pub fn open(&mut self) -> Result<(), String> {
        let opens: Vec<_> = self.table.borrow().opens.iter().map(|c| (c.run, c.state)).collect();
        opens.into_iter().try_for_each(|(run, state)| self.act(run, state))
    }

    fn act(&self, run: CommandRun, state: *mut c_void) -> Result<(), String> {
        // SAFETY: the component's code with its state; the record lives across the call.
        let status = unsafe { run(state, &raw const *self.calls) };
        if status.is_ok() {
            Ok(())
        } else {
            Err(core::mem::take(&mut *self.table.borrow().fault.borrow_mut()))
        }
    }

    /// Runs every stop action.
    pub fn stop(&self) {
        let stops: Vec<_> = self.table.borrow().stops.iter().map(|c| (c.run, c.state)).collect();
        for (run, state) in stops {
            self.act(run, state).unwrap();
        }
    }

    fn slot<T: Value>(&self, name: &str) -> *const Slot {
        let table = self.table.borrow();
        let name = table.old_names.get(name).map_or(name, String::as_str);
        let laid = table.items.get(name).unwrap_or_else(|| panic!("no pin {name}"));
        assert_eq!(laid.ty, T::TYPE, "{name} has another type");
        laid.slots.as_ptr()
    }

    /// Sets a pin or parameter.
    pub fn set<T: Value>(&self, name: &str, value: T) {
        // SAFETY: a slot on the table, aimed at its own cell or its signal's.
        unsafe { Slot::cell(self.slot::<T>(name)) }.store(value.to_bits());
    }

    /// Reads a pin or parameter.
    #[must_use]
    pub fn get<T: Value>(&self, name: &str) -> T {
        // SAFETY: a slot on the table, aimed at its own cell or its signal's.
        T::from_bits(unsafe { Slot::cell(self.slot::<T>(name)) }.load())
    }

    /// Links a pin to a signal of its own, which takes over its value.
    pub fn link(&self, name: &str) {
        let table = self.table.borrow();
        let laid = table.items.get(name).unwrap_or_else(|| panic!("no pin {name}"));
        let [slot, signal] = &*laid.slots;
        signal.own().store(slot.own().load());
        slot.aim(SIGNAL);
    }

    /// Gives a pin of type port a queue of `size` bytes.
    pub fn port(&self, name: &str, size: usize) {
        let data: Box<[AtomicU8]> = (0..size).map(|_| AtomicU8::new(0)).collect();
        // SAFETY: both live as long as the table.
        let queue = Box::new(unsafe { PortQueue::new(data.as_ptr(), size as u64) });
        let bits = (&raw const *queue).expose_provenance() as u64;
        // SAFETY: a slot on the table, aimed at its own cell or its signal's.
        unsafe { Slot::cell(self.slot::<crate::Port>(name)) }.store(bits);
        self.table.borrow_mut().ports.push((queue, data));
    }

    /// Runs a function or task once; the clock does not move.
    pub fn run(&self, name: &str, period_ns: i64) {
        self.try_run(name, period_ns).unwrap();
    }

    /// Runs a function or task once.
    ///
    /// # Errors
    /// The text of its panic.
    pub fn try_run(&self, name: &str, period_ns: i64) -> Result<(), String> {
        let (run, state) = {
            let table = self.table.borrow();
            let code = table.functs.get(name).or_else(|| table.tasks.get(name).map(|t| &t.1));
            let code = code.unwrap_or_else(|| panic!("no function {name}"));
            (code.run, code.state)
        };
        // SAFETY: the component's code with its state, one call at a time.
        if unsafe { run(state, period_ns) }.is_ok() {
            return Ok(());
        }
        Err(core::mem::take(&mut *self.table.borrow().fault.borrow_mut()))
    }

    /// Moves the clock.
    pub fn pass(&self, ns: i64) {
        self.table.borrow().now.fetch_add(ns, Relaxed);
    }

    /// Carries out a command: the lines of its answer.
    ///
    /// # Errors
    /// Why it was refused.
    pub fn command(&self, name: &str, args: &[&str]) -> Result<Vec<String>, String> {
        let (specs, run, state) = {
            let table = self.table.borrow();
            let (specs, code) =
                table.commands.get(name).unwrap_or_else(|| panic!("no command {name}"));
            (specs.clone(), code.run, code.state)
        };
        *self.table.borrow().call_args.borrow_mut() = Args::new(specs, args)?;
        self.table.borrow().awaited.set(false);
        self.act(run, state)?;
        Ok(core::mem::take(&mut *self.table.borrow().replies.borrow_mut()))
    }

    /// How far the last command that took a ticket has come.
    #[must_use]
    pub fn ticket(&self) -> Option<TicketState> {
        self.table.borrow().tickets.borrow().last().map(|t| t.state())
    }

    /// Why the last command that took a ticket failed, with its numbers.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let table = self.table.borrow();
        let tickets = table.tickets.borrow();
        let ticket = tickets.last()?;
        let TicketState::Failed(why) = ticket.state() else { return None };
        let (numbers, count) = ticket.numbers();
        let filled = |s: String, x: &f64| s.replacen("{}", &x.to_string(), 1);
        Some(numbers.iter().take(count).fold(why.to_owned(), filled))
    }

    /// How far each command that took a ticket has come, in order.
    #[must_use]
    pub fn tickets(&self) -> Vec<TicketState> {
        self.table.borrow().tickets.borrow().iter().map(|t| t.state()).collect()
    }

    /// Whether the last command has its caller wait for the ticket, asked to or not.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        self.table.borrow().awaited.get()
    }

    /// What was said since the last call.
    #[must_use]
    pub fn said(&self) -> Vec<String> {
        core::mem::take(&mut *self.table.borrow().said.borrow_mut())
    }

    /// Every pin and parameter: `NAME type dir`.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let ty = ["", "bit", "float", "s32", "u32", "port", "s64", "u64"];
        let table = self.table.borrow();
        let line = |(name, laid): (&String, &Laid)| {
            let dir = match laid.dir {
                abi::dir::IN => "IN",
                abi::dir::OUT => "OUT",
                abi::dir::IO => "I/O",
                abi::dir::RO => "RO",
                _ => "RW",
            };
            format!("{name} {} {dir}", ty.get(usize::from(laid.ty)).unwrap_or(&"?"))
        };
        table.items.iter().map(line).collect()
    }

    /// Every function, sorted.
    #[must_use]
    pub fn functs(&self) -> Vec<String> {
        self.table.borrow().functs.keys().cloned().collect()
    }

    /// Every thread with its period, in order of creation.
    #[must_use]
    pub fn threads(&self) -> Vec<(String, i64)> {
        self.table.borrow().threads.clone()
    }

    /// What a function touches: names of items, with `r`, `w` or `rw`; hidden state as `#`.
    #[must_use]
    pub fn touches(&self, funct: &str) -> Vec<String> {
        let table = self.table.borrow();
        let code = table.functs.get(funct).unwrap_or_else(|| panic!("no function {funct}"));
        let line = |u: &Use| {
            let access = ["", "r", "w", "rw"].get(u.access as usize).unwrap_or(&"?");
            let name = table.items.iter().find(|(_, l)| core::ptr::eq(l.slots.as_ptr(), u.slot));
            format!("{} {access}", name.map_or("#", |n| n.0))
        };
        code.uses.iter().map(line).collect()
    }

    /// The program's end of a ring that a component writes.
    #[must_use]
    pub fn reader(&self, name: &str) -> abi::Consumer {
        let r = self.table.borrow().rings.get(name).unwrap_or_else(|| panic!("no ring {name}")).1;
        // SAFETY: the ring lives as long as the table, and a test takes one reader.
        unsafe { abi::Consumer::new(r.ring, r.depth, r.width) }
    }

    /// The program's end of a ring that a component reads.
    #[must_use]
    pub fn writer(&self, name: &str) -> abi::Producer {
        let r = self.table.borrow().rings.get(name).unwrap_or_else(|| panic!("no ring {name}")).1;
        // SAFETY: the ring lives as long as the table, and a test takes one writer.
        unsafe { abi::Producer::new(r.ring, r.depth, r.width) }
    }
}
