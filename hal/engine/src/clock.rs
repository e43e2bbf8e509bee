//! Realtime. The loops that run the threads: the virtual clock, and those of the real one.

use crate::{
    ends, os,
    shared::Shared,
    sync::{Arc, Ordering},
    thread::Thread,
    watch::Probes,
};

/// The longest sleep: whoever is told to end does so that soon, however slow it is.
const LONGEST_SLEEP_NS: i64 = 10_000_000;

/// Runs the virtual clock up to `until`, at most `instants` moments that do something. Everything
/// due at one moment runs, faster threads first. Returns early when a probe that must lose nothing
/// has no room, when messages should be taken, a function fails, or the control side is to come back.
pub(crate) fn turn(shared: &Shared, probes: &Probes, until: i64, instants: u32) {
    let threads = shared.threads.load();
    let idle = !shared.boundary.is_running() || shared.fault.get().is_some();
    if threads.is_empty() || idle {
        shared.set_now(until);
        for t in threads.iter() {
            let due = t.due.load(Ordering::Relaxed);
            if due <= until {
                let missed = (until - due) / t.period_ns + 1;
                let due = due.saturating_add(missed.saturating_mul(t.period_ns));
                t.due.store(due, Ordering::Relaxed);
            }
        }
        return;
    }
    for _ in 0..instants {
        if ends::is_wanted() || !probes.have_room() || shared.mailbox.is_filling() {
            return;
        }
        let next = threads.iter().map(|t| t.due.load(Ordering::Relaxed)).min().unwrap_or(until);
        if next > until {
            shared.set_now(until);
            return;
        }
        shared.set_now(next);
        for t in threads.iter() {
            if t.due.load(Ordering::Relaxed) == next {
                t.due.store(next + t.period_ns, Ordering::Relaxed);
                t.cycle(shared, next);
            }
        }
        probes.moments.iter().for_each(|p| p.look(next));
        if shared.fault.get().is_some() {
            return;
        }
    }
}

/// Whatever allocates on first use does so before the first cycle.
pub(crate) fn warm(shared: &Shared) {
    drop(shared.threads.load());
    for t in shared.threads.load().iter() {
        drop(t.list.load());
    }
    os::ticks();
}

/// The fastest thread's duty before its cycle.
fn boundary(shared: &Shared, me: &Thread, threads: &[Arc<Thread>]) {
    if threads.first().is_some_and(|t| t.id == me.id) {
        // Not `threads`: one may have been added since they were loaded.
        let inside = |t: &Arc<Thread>| t.id != me.id && t.gate.is_inside();
        let others_inside = || shared.threads.load().iter().any(inside);
        shared.boundary.take(others_inside, crate::change::Change::carry_out);
    }
}

/// One cycle that was due at `due`; sets when the next is due.
fn beat(shared: &Shared, t: &Thread, threads: &[Arc<Thread>], due: i64) {
    let began = os::monotonic_ns();
    t.woke(began - due);
    boundary(shared, t, threads);
    let longest = t.cycle(shared, due - shared.origin());
    let mut next = due + t.period_ns;
    let now = os::monotonic_ns();
    if now > next {
        let missed = (now - next) / t.period_ns;
        if shared.boundary.is_running() {
            t.overran(longest, began - due, now - began, missed);
        }
        next += missed * t.period_ns;
    }
    t.due.store(next, Ordering::Relaxed);
}

/// One thread, until it is told to end.
pub(crate) fn run_one(shared: &Shared, t: &Thread) {
    t.tid.store(os::progress::this_thread(), Ordering::Relaxed);
    let ends = || t.end.load(Ordering::Relaxed) || shared.quit.load(Ordering::Relaxed);
    while !ends() {
        let due = t.due.load(Ordering::Relaxed);
        if slept_until(due) && !ends() {
            let threads = shared.threads.load();
            beat(shared, t, &threads, due);
        }
    }
}

/// All threads in turn, from one timeline.
pub(crate) fn run_all(shared: &Shared) {
    let tid = os::progress::this_thread();
    while !shared.quit.load(Ordering::Relaxed) {
        let next = |threads: &[Arc<Thread>]| {
            let dues = threads.iter().map(|t| t.due.load(Ordering::Relaxed));
            dues.min().unwrap_or(i64::MAX)
        };
        // The list is not held meanwhile: whoever replaces it waits until nobody does.
        let due = next(&shared.threads.load());
        if !slept_until(due) {
            continue;
        }
        let threads = shared.threads.load();
        for t in threads.iter() {
            let own = t.due.load(Ordering::Relaxed);
            if own <= due && !t.end.load(Ordering::Relaxed) {
                t.tid.store(tid, Ordering::Relaxed);
                beat(shared, t, &threads, own);
            }
        }
    }
}

/// Sleeps until `due`, or, where that is far, for a part of it: false.
fn slept_until(due: i64) -> bool {
    let far = os::monotonic_ns().saturating_add(LONGEST_SLEEP_NS);
    os::sleep_until(if due <= far { due } else { far });
    due <= far
}
