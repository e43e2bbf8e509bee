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

use crate::{
    Component, Value,
    abi::{
        self, ActionSpec, ArgSpec, ArgValue, CallHost, CommandRun, CommandSpec, Free, FunctSpec,
        Host, ItemSpec, PortQueue, Record, Ring, Run, ServiceSpec, Slot, Status, Str, StreamRef,
        StreamSpec, TaskSpec, ThreadSpec, Ticket, TicketState, Use, arg, component_flags,
        host_flags,
    },
};
use core::ffi::c_void;
use std::{
    cell::RefCell,
    collections::BTreeMap,
    sync::atomic::{AtomicI64, AtomicU8, Ordering::Relaxed},
};

/// A pin or parameter on the table.
struct Laid {
    slot: Box<Slot>,
    ty: u8,
    dir: u8,
}

struct Code<R> {
    run: R,
    state: *mut c_void,
    free: Option<Free>,
    uses: Vec<Use>,
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
struct Table {
    functs: BTreeMap<String, Code<Run>>,
    tasks: BTreeMap<String, (i64, Code<Run>)>,
    commands: BTreeMap<String, (Vec<ArgSpec>, Code<CommandRun>)>,
    opens: Vec<Code<CommandRun>>,
    stops: Vec<Code<CommandRun>>,
    services: BTreeMap<String, (u32, *const c_void, Option<Code<()>>)>,
    threads: Vec<(String, i64)>,
    items: BTreeMap<String, Laid>,
    old_names: BTreeMap<String, String>,
    rings: BTreeMap<String, (Vec<u64>, StreamRef)>,
    ports: Vec<(Box<PortQueue>, Box<[AtomicU8]>)>,
    args: Args,
    failed: String,
    now: AtomicI64,
    tick: i64,
    said: RefCell<Vec<String>>,
    fault: RefCell<String>,
    replies: RefCell<Vec<String>>,
    #[expect(clippy::vec_box, reason = "a ticket must not move")]
    tickets: RefCell<Vec<Box<Ticket>>>,
    call_args: RefCell<Args>,
}

/// Arguments as given, checked against their declaration, and what points into them.
#[derive(Default)]
struct Args {
    specs: Vec<ArgSpec>,
    given: BTreeMap<String, String>,
    ints: Vec<Box<[i64]>>,
    texts: Vec<Box<[Str]>>,
}

impl Args {
    fn new(specs: Vec<ArgSpec>, words: &[&str]) -> Result<Self, String> {
        let mut given = BTreeMap::new();
        for word in words {
            let (name, value) =
                word.split_once('=').ok_or_else(|| format!("Invalid parameter `{word}'"))?;
            // SAFETY: a declaration's strings are static.
            if !specs.iter().any(|s| unsafe { s.name.get() } == Some(name)) {
                return Err(format!("Unknown parameter `{word}'"));
            }
            given.insert(name.to_owned(), value.to_owned());
        }
        for s in &specs {
            // SAFETY: a declaration's strings are static.
            let name = unsafe { s.name.get() }.unwrap_or_default();
            if s.required != 0 && !given.contains_key(name) {
                return Err(format!("parameter `{name}' is missing"));
            }
        }
        Ok(Self { specs, given, ..Self::default() })
    }

    fn get(&mut self, name: &str) -> Option<ArgValue> {
        // SAFETY: a declaration's strings are static.
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

fn int(text: &str) -> Option<i64> {
    let hex = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    hex.map_or_else(|| text.parse().ok(), |h| i64::from_str_radix(h, 16).ok())
}

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
            message: Some(message),
            now: Some(now),
            fail: Some(fail_call),
            arg: Some(arg_call),
            reply: Some(reply),
            ticket: Some(ticket),
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
                fail: Some(fail),
                arg: Some(arg_value),
                item: Some(item),
                funct: Some(funct),
                thread: Some(thread),
                task: Some(task),
                command: Some(command),
                open: Some(open),
                stop: Some(stop),
                stream: Some(stream),
                offer: Some(offer),
                find: Some(find),
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
        &raw const *laid.slot
    }

    /// Sets a pin or parameter.
    pub fn set<T: Value>(&self, name: &str, value: T) {
        // SAFETY: a slot on the table, aimed at its own cell.
        unsafe { Slot::cell(self.slot::<T>(name)) }.store(value.to_bits());
    }

    /// Reads a pin or parameter.
    #[must_use]
    pub fn get<T: Value>(&self, name: &str) -> T {
        // SAFETY: a slot on the table, aimed at its own cell.
        T::from_bits(unsafe { Slot::cell(self.slot::<T>(name)) }.load())
    }

    /// Gives a pin of type port a queue of `size` bytes.
    pub fn port(&self, name: &str, size: usize) {
        let data: Box<[AtomicU8]> = (0..size).map(|_| AtomicU8::new(0)).collect();
        // SAFETY: both live as long as the table.
        let queue = Box::new(unsafe { PortQueue::new(data.as_ptr(), size as u64) });
        let bits = (&raw const *queue).expose_provenance() as u64;
        // SAFETY: a slot on the table, aimed at its own cell.
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
        self.act(run, state)?;
        Ok(core::mem::take(&mut *self.table.borrow().replies.borrow_mut()))
    }

    /// How far the last command that took a ticket has come.
    #[must_use]
    pub fn ticket(&self) -> Option<TicketState> {
        self.table.borrow().tickets.borrow().last().map(|t| t.state())
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
            let name = table.items.iter().find(|(_, l)| core::ptr::eq(&raw const *l.slot, u.slot));
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

fn table<'t>(ctx: *const c_void) -> &'t RefCell<Table> {
    // SAFETY: `ctx` is the table of the bench that made the record.
    unsafe { &*ctx.cast::<RefCell<Table>>() }
}

fn text(s: Str) -> String {
    // SAFETY: the component's string lives across its call.
    unsafe { s.get() }.unwrap_or_default().to_owned()
}

fn uses(list: *const Use, n: usize) -> Vec<Use> {
    if n == 0 {
        return Vec::new();
    }
    // SAFETY: the component's list lives across its call.
    unsafe { core::slice::from_raw_parts(list, n) }.to_vec()
}

macro_rules! spec {
    ($p:expr) => {{
        // SAFETY: the component's record lives across its call.
        let spec = unsafe { Record::read($p) };
        let Some(spec) = spec else { return Status::EINVAL };
        spec
    }};
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn fail(ctx: *mut c_void, why: Str) {
    table(ctx).borrow_mut().failed = text(why);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn arg_value(ctx: *mut c_void, name: Str, out: *mut ArgValue) -> Status {
    let value = table(ctx).borrow_mut().args.get(&text(name));
    let none = ArgValue { size: abi::size::<ArgValue>(), ..ArgValue::NONE };
    // SAFETY: a live place of the caller's.
    unsafe { out.write(value.unwrap_or(none)) };
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn item(
    ctx: *mut c_void,
    spec: *const ItemSpec,
    out: *mut *const Slot,
) -> Status {
    let spec: ItemSpec = spec!(spec);
    let (name, old) = (text(spec.name), text(spec.old_name));
    let mut t = table(ctx).borrow_mut();
    if name.len() > abi::NAME_LEN || t.items.contains_key(&name) {
        t.failed = format!("duplicate or too long name '{name}'");
        return Status::EEXIST;
    }
    let slot = Box::new(Slot::unlinked(spec.initial));
    // SAFETY: a live place of the caller's.
    unsafe { out.write(&raw const *slot) };
    if !old.is_empty() {
        t.old_names.insert(old, name.clone());
    }
    t.items.insert(name, Laid { slot, ty: spec.ty, dir: spec.dir });
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn funct(ctx: *mut c_void, spec: *const FunctSpec) -> Status {
    let s: FunctSpec = spec!(spec);
    let Some(run) = s.run else { return Status::EINVAL };
    let code = Code { run, state: s.state, free: s.free, uses: uses(s.uses, s.n_uses) };
    table(ctx).borrow_mut().functs.insert(text(s.name), code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn thread(ctx: *mut c_void, spec: *const ThreadSpec) -> Status {
    let s: ThreadSpec = spec!(spec);
    table(ctx).borrow_mut().threads.push((text(s.name), s.period_ns));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn task(ctx: *mut c_void, spec: *const TaskSpec) -> Status {
    let s: TaskSpec = spec!(spec);
    let Some(run) = s.run else { return Status::EINVAL };
    let code = Code { run, state: s.state, free: s.free, uses: uses(s.uses, s.n_uses) };
    table(ctx).borrow_mut().tasks.insert(text(s.name), (s.period_ns, code));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn command(ctx: *mut c_void, spec: *const CommandSpec) -> Status {
    let s: CommandSpec = spec!(spec);
    let Some(run) = s.run else { return Status::EINVAL };
    // SAFETY: the component's static list.
    let args = (0..s.args.len()).filter_map(|i| unsafe { s.args.get(i) }).collect();
    let code = Code { run, state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().commands.insert(text(s.name), (args, code));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn open(ctx: *mut c_void, spec: *const ActionSpec) -> Status {
    let s: ActionSpec = spec!(spec);
    let Some(run) = s.run else { return Status::OK };
    let code = Code { run, state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().opens.push(code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn stop(ctx: *mut c_void, spec: *const ActionSpec) -> Status {
    let s: ActionSpec = spec!(spec);
    let Some(run) = s.run else { return Status::OK };
    let code = Code { run, state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().stops.push(code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn stream(
    ctx: *mut c_void,
    spec: *const StreamSpec,
    out: *mut StreamRef,
) -> Status {
    let s: StreamSpec = spec!(spec);
    if s.depth < 2 || s.width == 0 || s.width as usize > abi::MAX_WIDTH {
        return Status::EINVAL;
    }
    // Room to align the head.
    let mut memory = vec![0_u64; Ring::bytes(s.depth, s.width) / 8 + 8];
    let at = memory.as_ptr().align_offset(64);
    // SAFETY: `align_offset` stays within the eight spare words.
    let ring = unsafe { memory.as_mut_ptr().add(at) }.cast::<Ring>();
    // SAFETY: in bounds, aligned, not yet used.
    unsafe { ring.write(Ring::new(s.depth, s.width, s.types)) };
    let made = StreamRef { ring, depth: s.depth, width: s.width };
    // SAFETY: a live place of the caller's.
    unsafe { out.write(made) };
    table(ctx).borrow_mut().rings.insert(text(s.name), (memory, made));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn offer(ctx: *mut c_void, spec: *const ServiceSpec) -> Status {
    let s: ServiceSpec = spec!(spec);
    let code = Code { run: (), state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().services.insert(text(s.name), (s.version, s.table, Some(code)));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn find(
    ctx: *mut c_void,
    name: Str,
    version: u32,
    out: *mut *const c_void,
) -> Status {
    let name = text(name);
    let mut t = table(ctx).borrow_mut();
    match t.services.get(&name) {
        Some((v, table, _)) if *v == version => {
            // SAFETY: a live place of the caller's.
            unsafe { out.write(*table) };
            Status::OK
        }
        _ => {
            t.failed = format!("no {name} loaded");
            Status::ENOENT
        }
    }
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn message(ctx: *const c_void, _: u8, say: Str, numbers: *const f64, n: usize) {
    let numbers: &[f64] = if n == 0 {
        &[]
    } else {
        // SAFETY: the component's numbers live across its call.
        unsafe { core::slice::from_raw_parts(numbers, n) }
    };
    let said = numbers.iter().fold(text(say), |s, x| s.replacen("{}", &x.to_string(), 1));
    table(ctx).borrow().said.borrow_mut().push(said);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn now(ctx: *const c_void) -> i64 {
    let t = table(ctx).borrow();
    t.now.fetch_add(t.tick, Relaxed)
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn fail_call(ctx: *const c_void, why: Str) {
    *table(ctx).borrow().fault.borrow_mut() = text(why);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn arg_call(ctx: *const c_void, name: Str, out: *mut ArgValue) -> Status {
    let value = table(ctx).borrow().call_args.borrow_mut().get(&text(name));
    let none = ArgValue { size: abi::size::<ArgValue>(), ..ArgValue::NONE };
    // SAFETY: a live place of the caller's.
    unsafe { out.write(value.unwrap_or(none)) };
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn reply(ctx: *const c_void, line: Str) {
    table(ctx).borrow().replies.borrow_mut().push(text(line));
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
unsafe extern "C" fn ticket(ctx: *const c_void) -> *const Ticket {
    let t = table(ctx).borrow();
    let mut tickets = t.tickets.borrow_mut();
    let made = Box::new(Ticket::new());
    let p = &raw const *made;
    tickets.push(made);
    p
}
