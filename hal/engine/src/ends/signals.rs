//! Signals that end a process, and the handling of each.

use super::{
    crash::{self, Cause, Shot},
    process::{GUARD, is_claimed, is_ours, want},
    sys,
};
use crate::sync::{AtomicI32, Ordering};
use core::ffi::{c_int, c_void};

/// Effect of a signal on an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    /// The usual way to end an instance: the instance shuts down in good order, and its exit status
    /// reports the result of its work.
    Ends,
    /// Not meant for an instance, but would end the process: the instance shuts down in good order,
    /// and the process ends by the signal.
    Unmeant,
    /// Code has failed; with the name of the failure.
    Crash(&'static str),
    /// None; the write that caused it fails.
    Ignored,
}

use Effect::{Crash, Ends, Ignored, Unmeant};

/// Every signal with a name that ends a process by default, but for SIGKILL.
const SIGNALS: &[(c_int, &str, Effect)] = &[
    (libc::SIGHUP, "SIGHUP", Ends),
    (libc::SIGINT, "SIGINT", Ends),
    (libc::SIGTERM, "SIGTERM", Ends),
    (libc::SIGQUIT, "SIGQUIT", Unmeant),
    (libc::SIGUSR1, "SIGUSR1", Unmeant),
    (libc::SIGUSR2, "SIGUSR2", Unmeant),
    (libc::SIGALRM, "SIGALRM", Unmeant),
    (libc::SIGVTALRM, "SIGVTALRM", Unmeant),
    (libc::SIGPROF, "SIGPROF", Unmeant),
    (libc::SIGXCPU, "SIGXCPU", Unmeant),
    (libc::SIGSTKFLT, "SIGSTKFLT", Unmeant),
    (libc::SIGIO, "SIGIO", Unmeant),
    (libc::SIGPWR, "SIGPWR", Unmeant),
    (libc::SIGSEGV, "SIGSEGV", Crash("segmentation fault")),
    (libc::SIGBUS, "SIGBUS", Crash("bus error")),
    (libc::SIGFPE, "SIGFPE", Crash("arithmetic fault")),
    (libc::SIGILL, "SIGILL", Crash("illegal instruction")),
    (libc::SIGABRT, "SIGABRT", Crash("it gave up (abort)")),
    (libc::SIGTRAP, "SIGTRAP", Crash("breakpoint")),
    (libc::SIGSYS, "SIGSYS", Crash("a system call that is not permitted")),
    (libc::SIGPIPE, "SIGPIPE", Ignored),
    (libc::SIGXFSZ, "SIGXFSZ", Ignored),
];

/// First signal that asked this process to end, and the process that sent it; 0 if none.
static ASKED: AtomicI32 = AtomicI32::new(0);
static SENDER: AtomicI32 = AtomicI32::new(0);

/// Value of [`HANDED_BY`] before a crash signal was left to the guard.
const UNKNOWN: c_int = -1;
/// Crash signal that was left to the guard, and the process that sent it.
static HANDED: AtomicI32 = AtomicI32::new(0);
static HANDED_BY: AtomicI32 = AtomicI32::new(UNKNOWN);

/// A signal, shown by its name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Named(pub(super) c_int);

impl core::fmt::Display for Named {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match SIGNALS.iter().find(|s| s.0 == self.0) {
            Some((_, name, _)) => f.write_str(name),
            None if self.0 == libc::SIGKILL => f.write_str("SIGKILL"),
            None if self.0 == libc::SIGRTMIN() => f.write_str("SIGRTMIN"),
            None => write!(f, "SIGRTMIN+{}", self.0.wrapping_sub(libc::SIGRTMIN())),
        }
    }
}

/// Returns the first signal that asked this process to end, and the process that sent it, if one
/// did.
pub(super) fn asked() -> Option<(c_int, Option<c_int>)> {
    let signal = ASKED.load(Ordering::Relaxed);
    let sender = SENDER.load(Ordering::Relaxed);
    (signal != 0).then_some((signal, (sender != 0).then_some(sender)))
}

/// Returns whether a signal has asked this process to end.
pub(crate) fn is_asked() -> bool {
    asked().is_some()
}

/// Returns whether the process ends by this signal after the instance has shut down in good order.
pub(super) fn is_unmeant(signal: c_int) -> bool {
    !SIGNALS.iter().any(|s| s.0 == signal && s.2 == Ends)
}

/// Installs the handlers of all signals.
pub(super) fn watch() {
    let realtime = libc::SIGRTMIN()..=libc::SIGRTMAX();
    let all = SIGNALS.iter().map(|s| (s.0, s.2)).chain(realtime.map(|s| (s, Unmeant)));
    for (signal, effect) in all {
        // A script's shell ignores SIGINT and SIGQUIT for what it starts in the background, but
        // people send them all the same.
        let meant = [libc::SIGINT, libc::SIGTERM, libc::SIGQUIT].contains(&signal);
        match effect {
            // Handled rather than ignored, because programs that are started from here would
            // inherit that.
            Ignored => sys::attend(signal, on_nothing, libc::SA_SIGINFO | libc::SA_RESTART),
            // The parent process has it ignored, so it ends nothing.
            Ends | Unmeant if !meant && sys::is_ignored(signal) => {}
            // Without SA_RESTART, so that it interrupts waits of this process.
            Ends | Unmeant => sys::attend(signal, on_asked, libc::SA_SIGINFO),
            // A component may have used up its stack, and the handling of a crash may itself crash.
            Crash(_) => {
                let flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_NODEFER;
                sys::attend(signal, on_crash, flags);
            }
        }
    }
}

/// Restores the default action of crash signals. No instance is left that they could affect.
pub(super) fn unwatch() {
    for (signal, _, effect) in SIGNALS {
        if matches!(effect, Crash(_)) {
            sys::set_default(*signal);
        }
    }
}

/// Blocks the signals that ask for the end in a thread of the engine, so that other threads receive
/// them.
pub(super) fn leave_to_others() {
    let mut set = sys::empty_set();
    let realtime = libc::SIGRTMIN()..=libc::SIGRTMAX();
    let asks = SIGNALS.iter().filter(|s| matches!(s.2, Ends | Unmeant)).map(|s| s.0);
    asks.chain(realtime).for_each(|signal| sys::add(&mut set, signal));
    sys::block(&set);
}

/// # Safety
/// Called by the system.
unsafe extern "C" fn on_asked(signal: c_int, info: *mut libc::siginfo_t, _: *mut c_void) {
    if !is_ours() {
        // This is a copy of the process that a component forked.
        sys::die(signal);
    }
    // SAFETY: the system's record.
    let info = unsafe { info.as_ref() };
    // Signals of timers and of the kernel have no sender.
    let sent =
        info.filter(|i| [libc::SI_USER, libc::SI_QUEUE, libc::SI_TKILL].contains(&i.si_code));
    if ASKED.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
        SENDER.store(sent.map_or(0, sender_of), Ordering::Relaxed);
    }
    sys::unseen(want);
}

/// # Safety
/// Called by the system.
unsafe extern "C" fn on_nothing(_: c_int, _: *mut libc::siginfo_t, _: *mut c_void) {}

/// # Safety
/// Called by the system.
unsafe extern "C" fn on_crash(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    if !is_ours() {
        sys::die(signal);
    }
    // SAFETY: the system's record.
    let info = unsafe { info.as_ref() };
    let code = info.map_or(0, |i| i.si_code);
    let (place, dx) = sys::place(context);
    let shot = if code > 0 {
        let kernel = [libc::SIGSEGV, libc::SIGBUS].contains(&signal) && code == SI_KERNEL;
        let port = if kernel { sys::port_at(place.code, dx) } else { None };
        // SAFETY: the record of a fault has an address.
        let address = info.map_or(0, |i| unsafe { i.si_addr() }.addr());
        match port {
            Some((port, out)) => Shot::Port { port, out },
            None if kernel => Shot::Protection,
            None => Shot::At(address),
        }
    } else {
        let by = info.map_or(0, sender_of);
        // `raise` and `abort` name the thread, `kill` does not.
        let own = by == sys::process();
        if !own && hand_over(signal, by) {
            return;
        }
        if own && code == libc::SI_TKILL { Shot::Raised } else { Shot::From(by) }
    };
    crash::crash(&Cause::Signal { signal, said: said(signal), shot }, place);
}

/// Returns the description of a crash signal.
pub(super) fn said(signal: c_int) -> &'static str {
    SIGNALS.iter().find(|s| s.0 == signal).map_or("fault", |s| match s.2 {
        Crash(said) => said,
        Ends | Unmeant | Ignored => "fault",
    })
}

/// Leaves a crash signal that another process sent to the guard. The thread that received it did nothing wrong and may hold
/// a lock that the guard needs, so it goes on. Returns false if this thread must handle the signal: there is no guard, this
/// is the guard, or the guard has not acted on an earlier signal.
fn hand_over(signal: c_int, by: c_int) -> bool {
    let guard = GUARD.load(Ordering::Relaxed);
    if guard == 0 || guard == sys::thread() || is_claimed() {
        return false;
    }
    if HANDED.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed).is_err() {
        return false;
    }
    HANDED_BY.store(by, Ordering::Release); // Pairs with `handed`.
    sys::unseen(want);
    true
}

/// Returns the crash signal that was left to the guard, and the process that sent it.
pub(super) fn handed() -> Option<(c_int, c_int)> {
    let by = HANDED_BY.load(Ordering::Acquire); // Pairs with `hand_over`.
    (by != UNKNOWN).then(|| (HANDED.load(Ordering::Relaxed), by))
}

/// `si_code` of a fault without an address.
const SI_KERNEL: c_int = 0x80;

fn sender_of(info: &libc::siginfo_t) -> c_int {
    // SAFETY: the record of a signal that a process sent has its number.
    unsafe { info.si_pid() }
}

#[cfg(test)]
mod tests {
    use super::{Named, SIGNALS, is_unmeant};

    #[test]
    fn every_signal_that_ends_a_process_is_here_once() {
        // Signals that stop, continue or do nothing by default, and those that cannot be caught.
        let others = [
            libc::SIGKILL,
            libc::SIGSTOP,
            libc::SIGTSTP,
            libc::SIGTTIN,
            libc::SIGTTOU,
            libc::SIGCONT,
            libc::SIGCHLD,
            libc::SIGURG,
            libc::SIGWINCH,
        ];
        for signal in 1..32 {
            let n = SIGNALS.iter().filter(|s| s.0 == signal).count();
            assert_eq!(n, usize::from(!others.contains(&signal)), "{signal}");
        }
    }

    #[test]
    fn signals_have_names() {
        let shown = |signal| Named(signal).to_string();
        assert_eq!(shown(libc::SIGQUIT), "SIGQUIT");
        assert_eq!(shown(libc::SIGRTMIN() + 2), "SIGRTMIN+2");
        assert!(is_unmeant(libc::SIGQUIT) && is_unmeant(64) && !is_unmeant(libc::SIGTERM));
    }
}
