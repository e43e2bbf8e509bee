//! Test bench for one or a few components without an engine: set pins, run functions, read pins.
//!
//! ```
//! # use hal_bench::Bench;
//! # use hal_component::{Component, In, Out, Period, Update};
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

#![expect(unsafe_code, reason = "calls components through the binary contract")]

mod describe;
mod find;
pub mod history;
mod host;
mod random;
mod response;
mod table;
mod time;
pub mod trace;
mod work;

pub use describe::Described;
pub use find::Service;
pub use random::Random;
pub use response::response;

use core::ffi::c_void;
use hal_component::{
    Component, Value,
    abi::{
        self, CallHost, CommandRun, Host, PortQueue, Slot, Str, TicketState, Use, component_flags,
        host_flags,
    },
};
use std::{cell::RefCell, sync::atomic::AtomicU8};
use table::{Args, Laid, Table, int};

/// Distance from a slot to the cell of its signal: the own cell of the next slot.
const SIGNAL: i32 = 16 + Slot::OWN;
const _: () = assert!(size_of::<Slot>() == 16);

/// The test bench. Every method panics on an unknown name, as a test should.
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

#[expect(clippy::unwrap_used, clippy::panic, reason = "a table for tests")]
impl Bench {
    /// Returns an empty bench with simulated hardware and a virtual clock at zero.
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
            ask_value: None,
            take_value: None,
            gaps: Some(host::gaps),
            hardware: Some(host::hardware),
            failed_hardware: Some(host::failed_hardware),
        });
        Self { table, calls, flags }
    }

    /// Returns an empty bench with a real clock, which each reading advances by `tick_ns`.
    #[must_use]
    pub fn real_time(tick_ns: i64) -> Self {
        let mut bench = Self::new();
        bench.flags &= !host_flags::VIRTUAL;
        bench.calls.flags = bench.flags;
        bench.table.borrow_mut().tick = tick_ns;
        bench
    }

    /// Declares that the hardware is not simulated.
    #[must_use]
    pub fn with_hardware(mut self) -> Self {
        self.flags &= !host_flags::SIMULATED;
        self.calls.flags = self.flags;
        self
    }

    /// Declares a machine from an INI file, in which motion needs an interlock.
    #[must_use]
    pub fn with_interlock(mut self) -> Self {
        self.flags |= host_flags::INTERLOCK;
        self.calls.flags = self.flags;
        self
    }

    /// Creates instances as `loadrt` would, and opens them.
    ///
    /// # Errors
    /// The reason why the component or its declaration was refused.
    pub fn load<C: Component>(&mut self, args: &[&str]) -> Result<(), String> {
        self.create::<C>(args)?;
        self.open()
    }

    /// Creates instances as `loadrt` would, without opening them.
    ///
    /// # Errors
    /// The reason why the component or its declaration was refused.
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
                worker: Some(work::worker),
                snapshot: Some(work::snapshot),
                measured: None,
            };
            // SAFETY: `host` lives for the duration of the call.
            let status = unsafe { hal_component::create::<C>(&raw const host) };
            if !status.is_ok() {
                let text = core::mem::take(&mut self.table.borrow_mut().failed);
                return Err(if text.is_empty() { format!("{status:?}") } else { text });
            }
        }
        Ok(())
    }

    /// Opens the created instances.
    ///
    /// # Errors
    /// The error that the component returned.
    pub fn open(&mut self) -> Result<(), String> {
        let opens: Vec<_> = self.table.borrow().opens.iter().map(|c| (c.run, c.state)).collect();
        opens.into_iter().try_for_each(|(run, state)| self.act(run, state))
    }

    fn act(&self, run: CommandRun, state: *mut c_void) -> Result<(), String> {
        // SAFETY: the component's code with its own state; the record lives during the call.
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

    /// Sets the value of a pin or parameter.
    pub fn set<T: Value>(&self, name: &str, value: T) {
        // SAFETY: the slot belongs to the bench and points at its own or its signal's cell.
        unsafe { Slot::cell(self.slot::<T>(name)) }.store(value.to_bits());
    }

    /// Returns the value of a pin or parameter.
    #[must_use]
    pub fn get<T: Value>(&self, name: &str) -> T {
        // SAFETY: the slot belongs to the bench and points at its own or its signal's cell.
        T::from_bits(unsafe { Slot::cell(self.slot::<T>(name)) }.load())
    }

    /// Links a pin to a new signal, which takes over the value of the pin.
    pub fn link(&self, name: &str) {
        let table = self.table.borrow();
        let laid = table.items.get(name).unwrap_or_else(|| panic!("no pin {name}"));
        let [slot, signal] = &*laid.slots;
        signal.own().store(slot.own().load());
        slot.aim(SIGNAL);
    }

    /// Gives a pin of type `port` a queue of `size` bytes.
    pub fn port(&self, name: &str, size: usize) {
        let data: Box<[AtomicU8]> = (0..size).map(|_| AtomicU8::new(0)).collect();
        // SAFETY: both live as long as the bench.
        let queue = Box::new(unsafe { PortQueue::new(data.as_ptr(), size as u64) });
        let bits = (&raw const *queue).expose_provenance() as u64;
        // SAFETY: the slot belongs to the bench and points at its own or its signal's cell.
        unsafe { Slot::cell(self.slot::<hal_component::Port>(name)) }.store(bits);
        self.table.borrow_mut().ports.push((queue, data));
    }

    /// Runs a function or task once. The clock does not advance.
    pub fn run(&self, name: &str, period_ns: i64) {
        self.try_run(name, period_ns).unwrap();
    }

    /// Runs a function or task once.
    ///
    /// # Errors
    /// The text of the panic.
    pub fn try_run(&self, name: &str, period_ns: i64) -> Result<(), String> {
        let (run, state) = {
            let table = self.table.borrow();
            let code = table.functs.get(name).or_else(|| table.tasks.get(name).map(|t| &t.1));
            let code = code.unwrap_or_else(|| panic!("no function {name}"));
            (code.run, code.state)
        };
        // SAFETY: this is the component's code with its own state; calls do not overlap.
        if unsafe { run(state, period_ns) }.is_ok() {
            return Ok(());
        }
        Err(core::mem::take(&mut *self.table.borrow().fault.borrow_mut()))
    }

    /// Runs a command and returns the lines of its answer.
    ///
    /// # Errors
    /// The reason why the command failed.
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

    /// Returns the progress of the last command that took a ticket.
    #[must_use]
    pub fn ticket(&self) -> Option<TicketState> {
        self.table.borrow().tickets.borrow().last().map(|t| t.state())
    }

    /// Returns the reason why the last command that took a ticket failed, including its numbers.
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

    /// Returns the progress of each command that took a ticket, in order.
    #[must_use]
    pub fn tickets(&self) -> Vec<TicketState> {
        self.table.borrow().tickets.borrow().iter().map(|t| t.state()).collect()
    }

    /// Returns whether the last command makes its caller wait for the ticket in any case.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        self.table.borrow().awaited.get()
    }

    /// Returns the messages logged since the last call.
    #[must_use]
    pub fn said(&self) -> Vec<String> {
        core::mem::take(&mut *self.table.borrow().said.borrow_mut())
    }

    /// Returns every pin and parameter as `NAME type dir`.
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

    /// Returns the names of all functions, sorted.
    #[must_use]
    pub fn functs(&self) -> Vec<String> {
        self.table.borrow().functs.keys().cloned().collect()
    }

    /// Returns all threads with their periods, in order of creation.
    #[must_use]
    pub fn threads(&self) -> Vec<(String, i64)> {
        self.table.borrow().threads.clone()
    }

    /// Returns the items that a function or a task accesses, as `NAME rw`. Hidden state is named `#`.
    #[must_use]
    pub fn touches(&self, funct: &str) -> Vec<String> {
        let table = self.table.borrow();
        let code = table.functs.get(funct).or_else(|| table.tasks.get(funct).map(|t| &t.1));
        let code = code.unwrap_or_else(|| panic!("no function {funct}"));
        let line = |u: &Use| {
            let access = ["", "r", "w", "rw"].get(u.access as usize).unwrap_or(&"?");
            let name = table.items.iter().find(|(_, l)| core::ptr::eq(l.slots.as_ptr(), u.slot));
            format!("{} {access}", name.map_or("#", |n| n.0))
        };
        code.uses.iter().map(line).collect()
    }

    /// Returns the program's end of a ring that a component writes.
    #[must_use]
    pub fn reader(&self, name: &str) -> abi::Consumer {
        let r = self.table.borrow().rings.get(name).unwrap_or_else(|| panic!("no ring {name}")).1;
        // SAFETY: the ring lives as long as the bench, and a test uses one reader.
        unsafe { abi::Consumer::new(r.ring, r.depth, r.width) }
    }

    /// Returns the program's end of a ring that a component reads.
    #[must_use]
    pub fn writer(&self, name: &str) -> abi::Producer {
        let r = self.table.borrow().rings.get(name).unwrap_or_else(|| panic!("no ring {name}")).1;
        // SAFETY: the ring lives as long as the bench, and a test uses one writer.
        unsafe { abi::Producer::new(r.ring, r.depth, r.width) }
    }
}
