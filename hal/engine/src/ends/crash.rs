//! Steps of a crash before the process ends. They run in a signal handler that may interrupt any
//! code, so they take neither heap memory nor locks. Each step begins only once: if a step crashes,
//! the handler continues with the next step.

use super::{
    board, doing, guard,
    instance::{Instance, instances},
    notes,
    process::{self, GUARD, claim},
    signals,
    sys::{self, Registers},
    terminal,
    text::Text,
    who,
};
use crate::{
    os::progress::processor_time,
    realtime::thread::Thread,
    sync::{AtomicBool, AtomicI32, AtomicPtr, AtomicU32, AtomicU64, Ordering},
};
use core::{ffi::c_int, ptr};

/// Realtime thread that has crashed.
static CRASHED: AtomicPtr<Thread> = AtomicPtr::new(ptr::null_mut());
/// Signal by which the process ends; 0 if it ends with a status.
static SIGNAL: AtomicI32 = AtomicI32::new(0);
static STATUS: AtomicI32 = AtomicI32::new(1);
/// Returns the number of stop actions that have begun.
static BEGUN: AtomicU32 = AtomicU32::new(0);
/// Flags of finished steps: the report, all stop actions, and what the guard saves.
static TOLD: AtomicBool = AtomicBool::new(false);
static STOPPED: AtomicBool = AtomicBool::new(false);
static SAVED: AtomicBool = AtomicBool::new(false);
/// Counter that increases while the guard makes progress.
static PROGRESS: AtomicU64 = AtomicU64::new(0);
/// File that the guard is writing: none, the recording, or the flight recorder's file.
static WRITING: AtomicU32 = AtomicU32::new(NOTHING);
const NOTHING: u32 = 0;
const RECORDING: u32 = 1;
const FLIGHT: u32 = 2;

/// Time in seconds after which the process ends even if all else fails.
const LAST_RESORT_S: u32 = 10;
/// Distance in bytes between the stack pointer and a faulting address below which a stack overflow
/// is assumed.
const NEAR: usize = 64 << 10;
/// Number of polls, a millisecond apart, for which the guard may make no progress.
const TIMEOUT: u32 = 2000;

/// Cause of the termination.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cause<'d> {
    /// A signal that code raised or a process sent.
    Signal { signal: c_int, said: &'static str, shot: Shot },
    /// Code called a function that ends the process, by its name.
    Exit { function: &'static str, status: Option<c_int> },
    /// A signal asked for it, and the control side does not return from what it is doing.
    Asked { signal: c_int, doing: &'d Text },
}

/// Details of a signal.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shot {
    /// A fault at this address.
    At(usize),
    /// An instruction or address that the processor refuses, without a reported address.
    Protection,
    /// A port that may not be read or written.
    Port { port: u16, out: bool },
    /// Code of this thread raised it.
    Raised,
    /// A process sent it; the process may be this one.
    From(c_int),
}

/// Ends this process: drives the outputs to their safe levels, reports the cause and keeps
/// recordings.
pub(super) fn crash(cause: &Cause<'_>, place: Registers) -> ! {
    let first = claim();
    sys::end_in(LAST_RESORT_S);
    if first {
        let thread = doing::cycle().map_or(ptr::null(), ptr::from_ref);
        CRASHED.store(thread.cast_mut(), Ordering::Relaxed);
        match *cause {
            Cause::Signal { signal, .. } => SIGNAL.store(signal, Ordering::Relaxed),
            Cause::Exit { function: "abort", .. } => {
                SIGNAL.store(libc::SIGABRT, Ordering::Relaxed);
            }
            // A status of 0 would report success, although the machine is gone.
            Cause::Exit { status, .. } => {
                let status = status.filter(|s| s & 0xff != 0).unwrap_or(1);
                STATUS.store(status, Ordering::Relaxed);
            }
            Cause::Asked { signal, .. } if signals::is_unmeant(signal) => {
                SIGNAL.store(signal, Ordering::Relaxed);
            }
            Cause::Asked { .. } => {}
        }
        process::want();
        let mut text = Text::new();
        describe(&mut text, cause, place);
        guard::keep(&text);
    }
    stop_outputs();
    tell();
    STOPPED.store(true, Ordering::Release); // Pairs with `outputs_are_safe`.
    if GUARD.load(Ordering::Relaxed) == sys::thread() {
        if first {
            guard::save();
        }
    } else {
        wait_for_guard();
    }
    finish()
}

/// Reports on standard error why the process ends, once.
pub(super) fn tell() {
    if TOLD.swap(true, Ordering::Relaxed) {
        return;
    }
    let mut text = guard::why();
    text.add(format_args!("; outputs are at their safe levels, and this process ends\n"));
    sys::report(text.as_str());
    notes::have_told();
}

/// Describes the code that has crashed, and the cause.
fn describe(text: &mut Text, cause: &Cause<'_>, place: Registers) {
    if let Cause::Signal { signal, shot: Shot::From(by), .. } = *cause {
        let name = signals::Named(signal);
        if by == sys::process() {
            text.add(format_args!("{name}, which this process sent to itself"));
        } else {
            text.add(format_args!("{name}, sent by process {by}"));
        }
        return;
    }
    if let Cause::Asked { signal, doing } = *cause {
        let name = signals::Named(signal);
        text.add(format_args!("{name}, but this does not return: {}", doing.as_str()));
        return;
    }
    // The control side waits before it frees what is read here: see `is_claimed`.
    let remains = instances().find_map(|i| i.remains());
    who::describe(text, place, remains.map_or(&[], |r| &r.origins));
    match *cause {
        Cause::Signal { signal, said, shot } => match shot {
            Shot::At(at) if [libc::SIGSEGV, libc::SIGBUS].contains(&signal) => {
                text.add(format_args!(": {said} at address {at:#x}"));
                if at.abs_diff(place.stack) < NEAR {
                    text.add(format_args!(" (its stack is used up)"));
                }
            }
            Shot::Protection => text.add(format_args!(
                ": general protection fault (an instruction that only the system may use, or an \
                 address that cannot be)"
            )),
            Shot::Port { port, out } => {
                let done = if out { "written" } else { "read" };
                text.add(format_args!(
                    ": port {port:#06x} may not be {done}: this process has no permission to use it \
                     (run as root, or with CAP_SYS_RAWIO)"
                ));
            }
            Shot::Raised if signal != libc::SIGABRT => {
                text.add(format_args!(": it raised {}", signals::Named(signal)));
            }
            Shot::At(_) | Shot::Raised | Shot::From(_) => text.add(format_args!(": {said}")),
        },
        Cause::Exit { function, status: Some(status) } => {
            text.add(format_args!(": it called {function}({status})"));
        }
        Cause::Exit { .. } => text.add(format_args!(": it gave up (abort)")),
        Cause::Asked { .. } => {}
    }
}

/// Runs every stop action that has not begun yet.
pub(super) fn stop_outputs() {
    instances().for_each(Instance::stop_cycles);
    let mut number = 0;
    for remains in instances().filter_map(Instance::remains) {
        for stop in &remains.stops {
            let next = number + 1;
            let begun = BEGUN.compare_exchange(number, next, Ordering::Relaxed, Ordering::Relaxed);
            // This stop action itself may be what ends the process.
            if begun.is_ok() && !doing::is_in(stop) {
                stop.call_mute();
            }
            number = next;
        }
    }
}

/// Returns the number of stop actions that have begun.
pub(super) fn begun() -> u32 {
    BEGUN.load(Ordering::Relaxed)
}

/// Returns whether all stop actions are over.
pub(super) fn outputs_are_safe() -> bool {
    STOPPED.load(Ordering::Acquire) // Pairs with `crash`.
}

/// Returns whether a thread is the one that has crashed: it never leaves its cycle.
pub(super) fn has_crashed(thread: &Thread) -> bool {
    ptr::eq(CRASHED.load(Ordering::Relaxed), thread)
}

/// Notes that the guard has made progress. Called by the guard.
pub(super) fn come_on() {
    PROGRESS.fetch_add(1, Ordering::Relaxed);
    sys::end_in(LAST_RESORT_S);
}

/// Notes that recordings are kept. Called by the guard.
pub(super) fn have_saved() {
    SAVED.store(true, Ordering::Release); // Pairs with `wait_for_guard`.
}

/// Notes that the guard writes the recording. Called by the guard.
pub(super) fn writes_recording() {
    WRITING.store(RECORDING, Ordering::Relaxed);
    come_on();
}

/// Notes that the guard writes the flight recorder's file. Called by the guard.
pub(super) fn writes_flight() {
    WRITING.store(FLIGHT, Ordering::Relaxed);
    come_on();
}

/// Notes that the guard has written everything. Called by the guard.
pub(super) fn has_written() {
    WRITING.store(NOTHING, Ordering::Relaxed);
    come_on();
}

fn wait_for_guard() {
    let guard = GUARD.load(Ordering::Relaxed);
    if guard == 0 {
        return;
    }
    let (mut last, mut looks) = ((0, 0), 0);
    // Pairs with `have_saved`.
    while !SAVED.load(Ordering::Acquire) && looks < TIMEOUT {
        let used = processor_time(guard).unwrap_or(0);
        let progress = (PROGRESS.load(Ordering::Relaxed), used);
        looks = if progress == last { looks + 1 } else { 0 };
        if looks == 0 {
            sys::end_in(LAST_RESORT_S);
        }
        last = progress;
        sys::nap(1);
    }
}

/// Reports changes that the recording has lost, once.
fn tell_lost() {
    let lost = board::lost().map_or(0, |lost| lost.swap(0, Ordering::Relaxed));
    if lost > 0 {
        let mut text = Text::new();
        text.add(format_args!("the recording: {lost} changes were lost for want of room\n"));
        sys::report(text.as_str());
    }
}

/// Reports what the guard could not write in time.
fn tell_unwritten() {
    match WRITING.swap(NOTHING, Ordering::Relaxed) {
        RECORDING => sys::report(
            "the recording's file takes nothing: it ends at its last write, and the flight recorder keeps no file\n",
        ),
        FLIGHT => sys::report("the flight recorder's file takes nothing: its event is lost\n"),
        _ => {}
    }
}

/// Ends the process with the signal or status of its cause.
pub(super) fn finish() -> ! {
    tell_unwritten();
    tell_lost();
    leave_nothing();
    match SIGNAL.load(Ordering::Relaxed) {
        0 => sys::leave(STATUS.load(Ordering::Relaxed)),
        signal => sys::die(signal),
    }
}

/// Removes the files of all instances and restores the terminal.
fn leave_nothing() {
    instances().flat_map(|i| &i.files).for_each(|file| sys::remove(file));
    terminal::restore();
}
