//! C side of the bench: the functions in the `Host` and `CallHost` records.

use super::table::{Code, Laid, Table};
use core::ffi::c_void;
use hal_component::abi::{
    self, ActionSpec, ArgValue, CommandSpec, FunctSpec, ItemSpec, Record, Ring, ServiceRef,
    ServiceSpec, Slot, Status, Str, StreamRef, StreamSpec, TaskSpec, ThreadSpec, Ticket, Use,
};
use std::{cell::RefCell, sync::atomic::Ordering::Relaxed};

pub(super) fn table<'t>(ctx: *const c_void) -> &'t RefCell<Table> {
    // SAFETY: `ctx` is the table of the bench that created the record.
    unsafe { &*ctx.cast::<RefCell<Table>>() }
}

pub(super) fn text(s: Str) -> String {
    // SAFETY: the component's string lives for the duration of its call.
    unsafe { s.get() }.unwrap_or_default().to_owned()
}

pub(super) fn uses(list: *const Use, n: usize) -> Vec<Use> {
    if n == 0 {
        return Vec::new();
    }
    // SAFETY: the component's list lives for the duration of its call.
    unsafe { core::slice::from_raw_parts(list, n) }.to_vec()
}

macro_rules! spec {
    ($p:expr) => {{
        // SAFETY: the component's record lives for the duration of its call.
        let spec = unsafe { Record::read($p) };
        let Some(spec) = spec else { return Status::EINVAL };
        spec
    }};
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn fail(ctx: *mut c_void, why: Str) {
    table(ctx).borrow_mut().failed = text(why);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn arg_value(
    ctx: *mut c_void,
    name: Str,
    out: *mut ArgValue,
) -> Status {
    let value = table(ctx).borrow_mut().args.get(&text(name));
    let none = ArgValue { size: abi::size::<ArgValue>(), ..ArgValue::NONE };
    // SAFETY: the caller passes a pointer to a live value.
    unsafe { out.write(value.unwrap_or(none)) };
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn item(
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
    let slots = Box::new([Slot::unlinked(spec.initial), Slot::unlinked(0)]);
    // SAFETY: the caller passes a pointer to a live value.
    unsafe { out.write(slots.as_ptr()) };
    if !old.is_empty() {
        t.old_names.insert(old, name.clone());
    }
    t.items.insert(name, Laid { slots, ty: spec.ty, dir: spec.dir });
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn funct(ctx: *mut c_void, spec: *const FunctSpec) -> Status {
    let s: FunctSpec = spec!(spec);
    let Some(run) = s.run else { return Status::EINVAL };
    let code = Code { run, state: s.state, free: s.free, uses: uses(s.uses, s.n_uses) };
    table(ctx).borrow_mut().functs.insert(text(s.name), code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn thread(ctx: *mut c_void, spec: *const ThreadSpec) -> Status {
    let s: ThreadSpec = spec!(spec);
    table(ctx).borrow_mut().threads.push((text(s.name), s.period_ns));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn task(ctx: *mut c_void, spec: *const TaskSpec) -> Status {
    let s: TaskSpec = spec!(spec);
    let Some(run) = s.run else { return Status::EINVAL };
    let code = Code { run, state: s.state, free: s.free, uses: uses(s.uses, s.n_uses) };
    table(ctx).borrow_mut().tasks.insert(text(s.name), (s.period_ns, code));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn command(ctx: *mut c_void, spec: *const CommandSpec) -> Status {
    let s: CommandSpec = spec!(spec);
    let Some(run) = s.run else { return Status::EINVAL };
    // SAFETY: the component's list is static.
    let args = (0..s.args.len()).filter_map(|i| unsafe { s.args.get(i) }).collect();
    let code = Code { run, state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().commands.insert(text(s.name), (args, code));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn open(ctx: *mut c_void, spec: *const ActionSpec) -> Status {
    let s: ActionSpec = spec!(spec);
    let Some(run) = s.run else { return Status::OK };
    let code = Code { run, state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().opens.push(code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn stop(ctx: *mut c_void, spec: *const ActionSpec) -> Status {
    let s: ActionSpec = spec!(spec);
    let Some(run) = s.run else { return Status::OK };
    let code = Code { run, state: s.state, free: s.free, uses: Vec::new() };
    table(ctx).borrow_mut().stops.push(code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn stream(
    ctx: *mut c_void,
    spec: *const StreamSpec,
    out: *mut StreamRef,
) -> Status {
    let s: StreamSpec = spec!(spec);
    if s.depth < 2 || s.width == 0 || s.width as usize > abi::MAX_WIDTH {
        return Status::EINVAL;
    }
    // Extra words for the alignment of the header.
    let mut memory = vec![0_u64; Ring::bytes(s.depth, s.width) / 8 + 8];
    let at = memory.as_ptr().align_offset(64);
    // SAFETY: `align_offset` stays within the eight spare words.
    let ring = unsafe { memory.as_mut_ptr().add(at) }.cast::<Ring>();
    // SAFETY: the pointer is in bounds and aligned, and the memory is not used yet.
    unsafe { ring.write(Ring::new(s.depth, s.width, s.types)) };
    let made = StreamRef { ring, depth: s.depth, width: s.width };
    // SAFETY: the caller passes a pointer to a live value.
    unsafe { out.write(made) };
    table(ctx).borrow_mut().rings.insert(text(s.name), (memory, made));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn offer(ctx: *mut c_void, spec: *const ServiceSpec) -> Status {
    let s: ServiceSpec = spec!(spec);
    let code = Code { run: (), state: s.state, free: s.free, uses: uses(s.uses, s.n_uses) };
    table(ctx).borrow_mut().services.insert(text(s.name), (s.version, s.table, Some(code)));
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn find(
    ctx: *mut c_void,
    name: Str,
    version: u32,
    out: *mut *const c_void,
) -> Status {
    let name = text(name);
    let mut t = table(ctx).borrow_mut();
    match t.services.get(&name) {
        Some((v, table, _)) if *v == version => {
            // SAFETY: the caller passes a pointer to a live value.
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
pub(super) unsafe extern "C" fn bind(
    ctx: *mut c_void,
    name: Str,
    version: u32,
    out: *mut ServiceRef,
) -> Status {
    let name = text(name);
    let mut t = table(ctx).borrow_mut();
    let mut found = ServiceRef { table: core::ptr::null(), uses: core::ptr::null(), n_uses: 0 };
    match t.services.get(&name) {
        Some((v, table, code)) if *v == version => {
            let uses = code.as_ref().map_or(&[][..], |code| &code.uses);
            found = ServiceRef { table: *table, uses: uses.as_ptr(), n_uses: uses.len() };
        }
        Some((v, ..)) => {
            t.failed = format!("{name} is of version {v}, not {version}");
            return Status::ENOENT;
        }
        None => {}
    }
    // SAFETY: the caller passes a pointer to a live value.
    unsafe { out.write(found) };
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn awaited(ctx: *const c_void) {
    table(ctx).borrow().awaited.set(true);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn message(
    ctx: *const c_void,
    _: u8,
    say: Str,
    numbers: *const f64,
    n: usize,
) {
    let numbers: &[f64] = if n == 0 {
        &[]
    } else {
        // SAFETY: the component's numbers live for the duration of its call.
        unsafe { core::slice::from_raw_parts(numbers, n) }
    };
    let said = numbers.iter().fold(text(say), |s, x| s.replacen("{}", &x.to_string(), 1));
    table(ctx).borrow().said.borrow_mut().push(said);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn now(ctx: *const c_void) -> i64 {
    let t = table(ctx).borrow();
    t.now.fetch_add(t.tick, Relaxed)
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn gaps(ctx: *const c_void) -> u32 {
    table(ctx).borrow().gaps.load(Relaxed)
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn hardware(ctx: *const c_void, failed: u32) {
    table(ctx).borrow().note_hardware(failed != 0);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn failed_hardware(ctx: *const c_void) -> u64 {
    table(ctx).borrow().failed_hardware.load(Relaxed)
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn fail_call(ctx: *const c_void, why: Str) {
    *table(ctx).borrow().fault.borrow_mut() = text(why);
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn arg_call(
    ctx: *const c_void,
    name: Str,
    out: *mut ArgValue,
) -> Status {
    let value = match &*text(name) {
        abi::FROM_AFAR if table(ctx).borrow().is_from_afar.get() => {
            Some(ArgValue { given: 1, int: 1, size: abi::size::<ArgValue>(), ..ArgValue::NONE })
        }
        name => table(ctx).borrow().call_args.borrow_mut().get(name),
    };
    let none = ArgValue { size: abi::size::<ArgValue>(), ..ArgValue::NONE };
    // SAFETY: the caller passes a pointer to a live value.
    unsafe { out.write(value.unwrap_or(none)) };
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn reply(ctx: *const c_void, line: Str) {
    table(ctx).borrow().replies.borrow_mut().push(text(line));
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn ticket(ctx: *const c_void) -> *const Ticket {
    let t = table(ctx).borrow();
    let mut tickets = t.tickets.borrow_mut();
    let made = Box::new(Ticket::new());
    let p = &raw const *made;
    tickets.push(made);
    p
}
