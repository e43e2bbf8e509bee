//! Realtime. The loops that run the threads: one for the virtual clock, two for the real one.

use crate::{
    ends::is_wanted,
    observe::probes::Probes,
    os,
    realtime::gaps::Lookout,
    realtime::shared::Shared,
    realtime::thread::Thread,
    sync::{Arc, Ordering},
};

/// Longest single sleep, so that even a slow thread soon sees a request to end.
const MAX_SLEEP_NS: i64 = 10_000_000;

/// Runs the virtual clock up to `until`, for at most `instants` instants at which a thread is due.
/// Everything due at one instant runs, faster threads first. Returns early if a probe that must
/// lose nothing has no room, if the control side should take messages, if a function fails, or if
/// the control side must return from its current work ([`is_wanted`]).
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
        if is_wanted() || !probes.have_room() || shared.mailbox.is_filling() {
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
        probes.idle_probes().iter().for_each(|p| p.sample(next));
        if shared.fault.get().is_some() {
            return;
        }
    }
}

/// Performs all allocations on first use before the first cycle.
pub(crate) fn warm(shared: &Shared) {
    drop(shared.threads.load());
    for t in shared.threads.load().iter() {
        drop(t.list.load());
    }
    os::ticks();
}

/// Carries out an offered change before the cycle of the fastest thread.
fn boundary(shared: &Shared, me: &Thread, threads: &[Arc<Thread>]) {
    if threads.first().is_some_and(|t| t.id == me.id) {
        // Read again instead of using `threads`: a thread may have been added since.
        let inside = |t: &Arc<Thread>| t.id != me.id && t.gate.is_inside();
        let others_inside = || shared.threads.load().iter().any(inside);
        shared.boundary.take(others_inside, crate::change::stores::Change::apply);
    }
}

/// Runs the cycle that was due at `due`, and sets the time of the next.
fn beat(shared: &Shared, t: &Thread, threads: &[Arc<Thread>], due: i64, lookout: &mut Lookout) {
    let began = os::monotonic_ns();
    // Before anything moves: the functions of this cycle know of the gap.
    shared.gaps.look(&shared.sight(due, began, t.period_ns), lookout);
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
        // The next cycle is not late after a gap within this one.
        shared.gaps.look(&shared.sight(began, now, t.period_ns), lookout);
    }
    lookout.rest(began, now, t.period_ns);
    t.due.store(next, Ordering::Relaxed);
}

/// Begins the cycles of a thread. Where the system took so long to start the thread that its first cycle should have
/// begun already, a later one is the first: that is no late wake-up, and nothing has been missed.
fn begins(t: &Thread) {
    let due = t.due.load(Ordering::Relaxed);
    t.due.store(first_due(due, os::monotonic_ns(), t.period_ns), Ordering::Relaxed);
}

/// Returns the first due time from `now` on.
fn first_due(due: i64, now: i64, period_ns: i64) -> i64 {
    let passed = now.saturating_sub(due).max(0);
    let periods = passed.saturating_add(period_ns - 1) / period_ns;
    due.saturating_add(periods.saturating_mul(period_ns))
}

/// Runs one thread until it is asked to end.
pub(crate) fn run_one(shared: &Shared, t: &Thread) {
    t.tid.store(os::progress::this_thread(), Ordering::Relaxed);
    let mut lookout = Lookout::new(true);
    begins(t);
    let ends = || t.end.load(Ordering::Relaxed) || shared.quit.load(Ordering::Relaxed);
    while !ends() {
        let due = t.due.load(Ordering::Relaxed);
        if slept_until(due) && !ends() {
            let threads = shared.threads.load();
            beat(shared, t, &threads, due, &mut lookout);
        }
    }
}

/// Runs all threads in turn, from one timeline.
pub(crate) fn run_all(shared: &Shared) {
    let tid = os::progress::this_thread();
    let mut lookout = Lookout::new(false);
    shared.threads.load().iter().for_each(|t| begins(t));
    while !shared.quit.load(Ordering::Relaxed) {
        let next = |threads: &[Arc<Thread>]| {
            let dues = threads.iter().map(|t| t.due.load(Ordering::Relaxed));
            dues.min().unwrap_or(i64::MAX)
        };
        // The list is not held during the sleep: code that replaces it waits until nothing holds
        // it.
        let due = next(&shared.threads.load());
        if !slept_until(due) {
            continue;
        }
        let threads = shared.threads.load();
        for t in threads.iter() {
            let own = t.due.load(Ordering::Relaxed);
            if own <= due && !t.end.load(Ordering::Relaxed) {
                t.tid.store(tid, Ordering::Relaxed);
                beat(shared, t, &threads, own, &mut lookout);
            }
        }
    }
}

/// Sleeps until `due` and returns true, or sleeps for a part of a long wait and returns false.
fn slept_until(due: i64) -> bool {
    let far = os::monotonic_ns().saturating_add(MAX_SLEEP_NS);
    os::sleep_until(if due <= far { due } else { far });
    due <= far
}

#[cfg(test)]
mod tests {
    use super::first_due;

    #[test]
    fn a_thread_that_the_system_starts_late_begins_with_a_later_cycle() {
        for (due, now, first) in [
            (5000, 4000, 5000),
            (5000, 5000, 5000),
            (5000, 5001, 6000),
            (5000, 6000, 6000),
            (5000, 44_999, 45_000),
            (i64::MAX - 10, i64::MAX, i64::MAX),
        ] {
            assert_eq!(first_due(due, now, 1000), first, "{due} {now}");
        }
    }
}
