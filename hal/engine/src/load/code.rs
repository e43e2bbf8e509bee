//! Code that plugins give the engine to run, and the data that must live as long.

use crate::{
    Error,
    load::hardware::{self, FailedHardware},
    messages::mailbox::{Message, Spoken, Voice},
    realtime::shared::Shared,
    sync::{Arc, AtomicU64, Ordering},
};
use core::ffi::c_void;
use hal_abi::{ArgValue, CallHost, CommandRun, Free, Run, Status, Str, Ticket, Work, host_flags};
use std::{
    cell::{Cell, RefCell},
    path::Path,
};

/// Symbol by which a loader of files says which ones it would open where hardware is simulated. It may be missing.
const OPENS_SIMULATED: &[u8] = b"hal_opens_simulated";

/// A plugin library, open as long as anything from it is alive.
#[derive(Debug)]
pub(crate) enum Library {
    /// Linked into this program.
    Static,
    /// From a file.
    File(libloading::Library),
}

impl Library {
    /// Returns whether this loader of files would open a file on a machine with simulated hardware. Opening runs the
    /// file's initialisers, in whichever process.
    pub(crate) fn opens_simulated(&self, file: &Path) -> bool {
        type Opens = unsafe extern "C" fn(Str) -> bool;
        let Self::File(library) = self else { return true };
        // SAFETY: the contract defines the type of this symbol.
        let Ok(opens) = (unsafe { library.get::<Opens>(OPENS_SIMULATED) }) else { return true };
        // SAFETY: a function of the open library; the text lives across the call.
        file.to_str().is_none_or(|file| unsafe { opens(Str::borrow(file)) })
    }
}

/// A load of a component: the record through which its code calls the engine, and its library.
#[derive(Debug)]
pub(crate) struct LoadHandle {
    calls: CallHost,
    component: u32,
    voice: Arc<Voice>,
    shared: Arc<Shared>,
    /// Memory of the component itself in bytes, as it reports.
    memory: AtomicU64,
    pub(super) hardware: FailedHardware,
    #[expect(dead_code, reason = "held so that the code stays mapped; dropped last")]
    library: Arc<Library>,
}

// SAFETY: `calls` is immutable and points at this same record.
unsafe impl Send for LoadHandle {}
// SAFETY: as for `Send`.
unsafe impl Sync for LoadHandle {}

impl LoadHandle {
    pub(crate) fn new(component: u32, shared: Arc<Shared>, library: Arc<Library>) -> Arc<Self> {
        let flags = if shared.is_virtual() { host_flags::VIRTUAL } else { 0 };
        Arc::new_cyclic(|me: &std::sync::Weak<Self>| Self {
            calls: CallHost {
                size: hal_abi::size::<CallHost>(),
                flags,
                ctx: me.as_ptr().cast(),
                message: Some(message),
                now: Some(now),
                fail: Some(fail),
                arg: None,
                reply: None,
                ticket: None,
                awaited: None,
                ask_value: Some(ask_value),
                take_value: Some(take_value),
                gaps: Some(gaps),
                hardware: Some(hardware::note),
                failed_hardware: Some(hardware::count),
            },
            component,
            voice: Arc::default(),
            hardware: FailedHardware::new(shared.clone()),
            shared,
            memory: AtomicU64::new(0),
            library,
        })
    }

    /// Returns the component's own memory in bytes.
    pub(crate) fn memory(&self) -> u64 {
        self.memory.load(Ordering::Relaxed)
    }

    /// Returns the counts of the component's messages.
    pub(crate) const fn voice(&self) -> &Arc<Voice> {
        &self.voice
    }

    /// Returns the functions that the component may call later.
    pub(crate) const fn calls(&self) -> &CallHost {
        &self.calls
    }
}

pub(super) fn keep<'k>(ctx: *const c_void) -> &'k LoadHandle {
    // SAFETY: the context of a record made by `LoadHandle::new`, alive while its code can run.
    unsafe { &*ctx.cast::<LoadHandle>() }
}

/// Realtime. Sends a message of a component to the mailbox.
///
/// # Safety
/// Called by a component with the context it was given and `n` live numbers.
unsafe extern "C" fn message(
    ctx: *const c_void,
    level: u8,
    text: Str,
    numbers: *const f64,
    n: usize,
) {
    let k = keep(ctx);
    let mailbox = &k.shared.mailbox;
    if !mailbox.keeps(level) {
        return;
    }
    let (at, component) = (k.shared.now(), k.component);
    let mut m = Message { at, level, component, text, numbers: [0.0; 8], n: 0 };
    for (i, place) in m.numbers.iter_mut().enumerate().take(n) {
        // SAFETY: below `n`.
        let at = unsafe { numbers.add(i) };
        // SAFETY: a live number.
        *place = unsafe { at.read() };
        m.n = i + 1;
    }
    mailbox.send(&k.voice, m);
}

/// Realtime. Returns machine time in nanoseconds.
///
/// # Safety
/// Called by a component with the context it was given.
unsafe extern "C" fn now(ctx: *const c_void) -> i64 {
    keep(ctx).shared.now()
}

/// Realtime. Returns the number of gaps in time so far.
///
/// # Safety
/// Called by a component with the context it was given.
unsafe extern "C" fn gaps(ctx: *const c_void) -> u32 {
    keep(ctx).shared.gaps.count()
}

/// Asks for a value by its name.
///
/// # Safety
/// Called by a component with the context it was given and a live text.
unsafe extern "C" fn ask_value(ctx: *const c_void, name: Str) -> u64 {
    // SAFETY: the caller's promise.
    keep(ctx).shared.questions.ask(unsafe { name.get() }.unwrap_or_default())
}

/// Takes the answer to a question.
///
/// # Safety
/// Called by a component with the context it was given and a live number.
unsafe extern "C" fn take_value(ctx: *const c_void, question: u64, out: *mut f64) -> Status {
    match keep(ctx).shared.questions.take(question) {
        None => Status::EAGAIN,
        Some(None) => Status::ENOENT,
        Some(Some(value)) => {
            // SAFETY: the caller's promise.
            unsafe { out.write(value) };
            Status::OK
        }
    }
}

/// Realtime. Stores the text of a panic.
///
/// # Safety
/// Called by a component with the context it was given and a live text.
unsafe extern "C" fn fail(ctx: *const c_void, text: Str) {
    // SAFETY: the caller's promise.
    keep(ctx).shared.cause.store(unsafe { text.get() }.unwrap_or("failed"));
}

/// Realtime. Sends a text of a loader's component to the mailbox.
///
/// # Safety
/// Called by a loader with the context it was given and a live text.
pub(crate) unsafe extern "C" fn say(ctx: *const c_void, level: u8, text: Str) {
    let k = keep(ctx);
    let mailbox = &k.shared.mailbox;
    if mailbox.keeps(level) {
        // SAFETY: the caller's promise.
        let text = unsafe { text.get() }.unwrap_or("?");
        mailbox.say_text(&k.voice, Spoken::new(k.shared.now(), level, k.component, text));
    }
}

/// Realtime. Sets the message level, unless the argument is out of range, and returns the previous
/// one.
///
/// # Safety
/// Called by a loader with the context it was given.
pub(crate) unsafe extern "C" fn level(ctx: *const c_void, level: i32) -> i32 {
    let known = &keep(ctx).shared.mailbox.level;
    let before = known.load(Ordering::Relaxed);
    if let Ok(level) = u8::try_from(level) {
        known.store(level, Ordering::Relaxed);
    }
    i32::from(before)
}

/// # Safety
/// Called by a loader with the context it was given.
pub(crate) unsafe extern "C" fn account(ctx: *const c_void, bytes: i64) {
    keep(ctx).memory.fetch_add(bytes.cast_unsigned(), Ordering::Relaxed);
}

/// A function, task, command or action with its state.
#[derive(Debug)]
pub(crate) struct Code<R> {
    pub(crate) run: R,
    pub(crate) state: *mut c_void,
    free: Option<Free>,
    keep: Option<Arc<LoadHandle>>,
}

// SAFETY: the contract lets a state move between threads; one runs it at a time.
unsafe impl<R: Send> Send for Code<R> {}
// SAFETY: a shared `Code` is only run through a list, by one thread.
unsafe impl<R: Sync> Sync for Code<R> {}

impl<R> Code<R> {
    /// Takes ownership of a state.
    pub(crate) const fn new(
        run: R,
        state: *mut c_void,
        free: Option<Free>,
        keep: Arc<LoadHandle>,
    ) -> Self {
        Self { run, state, free, keep: Some(keep) }
    }
}

impl<R> Drop for Code<R> {
    fn drop(&mut self) {
        if let Some(free) = self.free {
            // SAFETY: the state came with `free`; it is freed once, and its library is still open.
            unsafe { free(self.state) };
        }
        drop(self.keep.take());
    }
}

impl Code<Work> {
    /// Makes one step of a worker.
    pub(crate) fn work(&self, items: u32) -> Status {
        // SAFETY: the component's code with its state, which only its worker uses.
        unsafe { (self.run)(self.state, items) }
    }
}

impl Code<Run> {
    /// Runs a task once.
    pub(crate) fn run(&self, period_ns: i64) -> Status {
        // SAFETY: the component's code with its state, on the control side only.
        unsafe { (self.run)(self.state, period_ns) }
    }
}

/// A command or action in progress: its arguments and its answer.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    args: RefCell<crate::load::args::Args>,
    lines: RefCell<Vec<String>>,
    failed: RefCell<String>,
    ticket: RefCell<Option<Box<Ticket>>>,
    awaited: Cell<bool>,
}

/// The answer of a command.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) lines: Vec<String>,
    pub(crate) ticket: Option<Box<Ticket>>,
    /// True if the caller waits for the ticket even without asking to.
    pub(crate) awaited: bool,
}

impl Code<CommandRun> {
    /// Realtime. Runs an action that takes no arguments and gives no answer.
    pub(crate) fn call_mute(&self) {
        let calls = CallHost {
            size: hal_abi::size::<CallHost>(),
            flags: self.keep.as_ref().map_or(0, |k| k.calls.flags),
            ctx: core::ptr::null(),
            message: None,
            now: None,
            fail: None,
            arg: None,
            reply: None,
            ticket: None,
            awaited: None,
            ask_value: None,
            take_value: None,
            gaps: None,
            hardware: None,
            failed_hardware: None,
        };
        // SAFETY: the component's code with its state; stop actions take no lock.
        unsafe { (self.run)(self.state, &raw const calls) };
    }

    /// Runs a command or action on the control side.
    pub(crate) fn call(&self, args: crate::load::args::Args) -> Result<Outcome, Error> {
        let frame = Frame { args: RefCell::new(args), ..Frame::default() };
        let (base, flags) = self.keep.as_ref().map_or((None, 0), |k| (Some(k), k.calls.flags));
        let calls = CallHost {
            size: hal_abi::size::<CallHost>(),
            flags,
            ctx: (&raw const frame).cast(),
            message: None,
            now: None,
            fail: Some(frame_fail),
            arg: Some(frame_arg),
            reply: Some(frame_reply),
            ticket: Some(frame_ticket),
            awaited: Some(frame_awaited),
            ask_value: None,
            take_value: None,
            gaps: None,
            hardware: None,
            failed_hardware: None,
        };
        // SAFETY: the component's code with its state, on the control side only.
        let status = unsafe { (self.run)(self.state, &raw const calls) };
        let _held = base;
        if status.is_ok() {
            return Ok(Outcome {
                lines: frame.lines.into_inner(),
                ticket: frame.ticket.into_inner(),
                awaited: frame.awaited.get(),
            });
        }
        let why = frame.failed.into_inner();
        let why = if why.is_empty() { format!("refused ({})", status.0) } else { why };
        Err(Error::CommandFailed { why: why.into(), code: status.0 })
    }
}

fn frame<'f>(ctx: *const c_void) -> &'f Frame {
    // SAFETY: the context of a record made by `Code::call`, alive during the call.
    unsafe { &*ctx.cast::<Frame>() }
}

/// # Safety
/// Called by a component with the context it was given and a live text.
unsafe extern "C" fn frame_fail(ctx: *const c_void, text: Str) {
    // SAFETY: the caller's promise.
    unsafe { text.get() }.unwrap_or("failed").clone_into(&mut frame(ctx).failed.borrow_mut());
}

/// # Safety
/// Called by a component with the context it was given and live texts.
unsafe extern "C" fn frame_reply(ctx: *const c_void, text: Str) {
    // SAFETY: the caller's promise.
    frame(ctx).lines.borrow_mut().push(unsafe { text.get() }.unwrap_or_default().to_owned());
}

/// # Safety
/// Called by a component with the context it was given, a live name and a live place.
unsafe extern "C" fn frame_arg(ctx: *const c_void, name: Str, out: *mut ArgValue) -> Status {
    // SAFETY: the caller's promise.
    let name = unsafe { name.get() }.unwrap_or_default();
    let value = frame(ctx).args.borrow_mut().get(name);
    // SAFETY: the caller's promise.
    unsafe { out.write(value) };
    Status::OK
}

/// # Safety
/// Called by a component with the context it was given.
unsafe extern "C" fn frame_ticket(ctx: *const c_void) -> *const Ticket {
    let mut place = frame(ctx).ticket.borrow_mut();
    let ticket = place.get_or_insert_with(|| Box::new(Ticket::new()));
    &raw const **ticket
}

/// # Safety
/// Called by a component with the context it was given.
unsafe extern "C" fn frame_awaited(ctx: *const c_void) {
    frame(ctx).awaited.set(true);
}
