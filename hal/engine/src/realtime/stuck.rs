//! Detection of a thread that is stuck in a function on the real clock: the watch prevents further
//! cycles and drives outputs to their safe levels.
//!
//! Only the time that the function itself spends counts: on a processor, or waiting in a system
//! call of its own. Time in which its thread waits for a processor, or is stopped with its process
//! or by a debugger, does not count, so that a busy machine stops no outputs. Of the time between
//! two observations, at most the planned interval counts: if a whole machine is suspended, the
//! observations are as well. Before a verdict the observations are made on the processor of the
//! threads, so that each proves that this processor ran.

use crate::{
    os::{
        self,
        progress::{Doing, doing, processor_time},
    },
    realtime::resources::WATCH_PRIORITY,
    realtime::shared::{Cause, Shared},
    realtime::thread::{NOBODY, Thread},
    sync::{Arc, Ordering},
};
use std::{
    sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    thread::JoinHandle,
    time::Duration,
};

/// Shortest and longest time between two observations, in nanoseconds.
const STEPS_NS: (i64, i64) = (500_000, 100_000_000);
/// Number of observations after the first that must find the same call.
const LOOKS: u32 = 3;
/// Least limit, in nanoseconds, for a function that sets up hardware (`initf`), or that waits for a
/// disk or a device that cannot be interrupted.
const TIMEOUT_NS: i64 = 1_000_000_000;
/// Number of threads for which memory is reserved at the start.
const RESERVED_THREADS: usize = 64;

/// Observation of a thread that is inside a function.
#[derive(Clone, Copy, Debug)]
struct Sight {
    cycles: u64,
    funct: u32,
    /// True if the function runs once, before all others.
    init: bool,
    /// Processor time that the thread has used, in nanoseconds.
    ran_ns: i64,
    doing: Doing,
}

/// The time that one call of a function has spent, as far as observed.
#[derive(Clone, Copy, Debug)]
struct Case {
    thread: u32,
    seen: Sight,
    had_ns: i64,
    looks: u32,
    patient: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// The call is new.
    Fine,
    /// The thread was in the same call at the last observation.
    Suspect,
    /// The call has exceeded its limit.
    Stuck,
}

impl Case {
    const fn new(thread: u32, seen: Sight) -> Self {
        Self { thread, seen, had_ns: 0, looks: 0, patient: seen.init }
    }

    /// Adds an observation, planned for `step_ns` after the last one.
    fn look(&mut self, now: Sight, step_ns: i64, limit_ns: i64) -> Verdict {
        let last = self.seen;
        if (last.cycles, last.funct) != (now.cycles, now.funct) {
            *self = Self::new(self.thread, now);
            return Verdict::Fine;
        }
        let ran = now.ran_ns.saturating_sub(last.ran_ns).max(0);
        let waits = last.doing != Doing::Runs && now.doing != Doing::Runs;
        self.had_ns += if waits || ran > step_ns { step_ns } else { ran };
        self.patient |= waits && now.doing == Doing::WaitsForDevice;
        self.looks = self.looks.saturating_add(1);
        self.seen = now;
        let limit = if self.patient { limit_ns.max(TIMEOUT_NS) } else { limit_ns };
        if self.looks >= LOOKS && self.had_ns >= limit { Verdict::Stuck } else { Verdict::Suspect }
    }
}

/// The observing thread; it ends when this value is dropped.
#[derive(Debug)]
pub(crate) struct StuckWatch {
    end: Option<Sender<()>>,
    running: Option<JoinHandle<()>>,
}

impl StuckWatch {
    /// Starts observing threads that run on `cpu`, if they are bound to one; returns `None` if the
    /// system cannot start a thread for it.
    pub(crate) fn begin(shared: Arc<Shared>, fifo: bool, cpu: Option<usize>) -> Option<Self> {
        let (end, ended) = channel();
        let (ready, is_ready) = channel::<()>();
        let run = move || {
            let mut watch = Watch::new(shared, cpu);
            // Allocates all the memory that it needs now.
            let mut goes_on = watch.look(Duration::ZERO, &ended);
            if fifo {
                os::become_fifo(WATCH_PRIORITY);
            }
            drop(ready);
            while goes_on {
                let step = watch.step();
                goes_on = watch.look(step, &ended);
            }
        };
        let running = std::thread::Builder::new().name("hal-stuck".into()).spawn(run).ok()?;
        // Nothing is sent: the channel closes when the first observation is over.
        is_ready.recv().unwrap_or_default();
        Some(Self { end: Some(end), running: Some(running) })
    }

    /// Makes the watch observe now: there are threads that it may not have seen yet.
    pub(crate) fn poke(&self) {
        if let Some(end) = &self.end {
            // The receiving thread ends only after this value is dropped.
            let _: Result<(), _> = end.send(());
        }
    }
}

impl Drop for StuckWatch {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(running) = self.running.take() {
            drop(running.join());
        }
    }
}

struct Watch {
    shared: Arc<Shared>,
    cpu: Option<usize>,
    others: Vec<usize>,
    cases: Vec<Case>,
    /// True if some thread was in the same call at the last two observations: the watch then runs
    /// on the threads' processor.
    near: bool,
    /// Threads that were inside a cycle when outputs were driven to their safe levels.
    left_inside: Vec<u32>,
    /// The stuck thread, which others no longer wait for.
    lowered: Option<Lowered>,
}

/// A thread that has lost `SCHED_FIFO` until its function returns.
#[derive(Clone, Copy, Debug)]
struct Lowered {
    thread: u32,
    tid: i32,
    priority: i32,
}

impl Watch {
    fn new(shared: Arc<Shared>, cpu: Option<usize>) -> Self {
        let mut others = os::processors::cpus();
        others.retain(|c| Some(*c) != cpu);
        if !others.is_empty() {
            os::processors::stay_among(&others);
        }
        let (cases, left_inside) =
            (Vec::with_capacity(RESERVED_THREADS), Vec::with_capacity(RESERVED_THREADS));
        Self { shared, cpu, others, cases, near: false, left_inside, lowered: None }
    }

    /// Returns the time until the next observation.
    fn step(&self) -> Duration {
        let part = if self.near || !self.left_inside.is_empty() { 4 } else { 2 };
        let (least, most) = STEPS_NS;
        let step = match self.shared.stuck_limit() {
            // There is no thread.
            0 => most,
            limit => (limit / part).max(least).min(most),
        };
        Duration::from_nanos(step.unsigned_abs())
    }

    /// Waits and observes; returns false when the watch is to end.
    fn look(&mut self, step: Duration, ended: &Receiver<()>) -> bool {
        match ended.recv_timeout(step) {
            Ok(()) => return true,
            Err(RecvTimeoutError::Disconnected) => return false,
            Err(RecvTimeoutError::Timeout) => {}
        }
        let threads = self.shared.threads.load_full();
        self.rest_again(&threads);
        let step_ns = i64::try_from(step.as_nanos()).unwrap_or(i64::MAX);
        let limit = self.shared.stuck_limit();
        let (mut near, mut stuck) = (false, None);
        self.cases.retain(|c| threads.iter().any(|t| t.id == c.thread));
        for t in threads.iter() {
            let known = self.cases.iter_mut().find(|c| c.thread == t.id);
            let Some(sight) = sight(t, known.as_deref()) else {
                self.cases.retain(|c| c.thread != t.id);
                continue;
            };
            let Some(case) = known else {
                self.cases.push(Case::new(t.id, sight));
                continue;
            };
            match case.look(sight, step_ns, limit) {
                Verdict::Fine => {}
                Verdict::Suspect => near = true,
                Verdict::Stuck => stuck = stuck.or(Some((t, sight.funct))),
            }
        }
        if let Some((thread, funct)) = stuck {
            if !self.shared.fault.is_abandoned() {
                self.stop(thread, funct, limit, &threads);
            }
        } else if near != self.near {
            self.near = near;
            self.move_over();
        }
        true
    }

    /// Moves the watch to the processor of the threads, or away from it.
    fn move_over(&self) {
        match self.cpu {
            Some(cpu) if self.near => os::processors::stay_on(cpu),
            _ if !self.others.is_empty() => os::processors::stay_among(&self.others),
            _ => true,
        };
    }

    /// Makes every cycle end after its current function, prevents further cycles and drives outputs
    /// to their safe levels.
    fn stop(&mut self, thread: &Thread, funct: u32, limit: i64, threads: &[Arc<Thread>]) {
        let cause = Cause::new();
        let us = limit / 1000;
        let mut text = [0; 64];
        cause.store(reason_text(&mut text, us));
        self.shared.fault.set(thread.id, funct, &cause);
        self.shared.fault.abandon();
        // Recorded before the outputs are driven: if one of these threads leaves its cycle later,
        // they are driven again.
        let inside = threads.iter().filter(|t| t.gate.is_inside()).map(|t| t.id);
        self.left_inside.clear();
        self.left_inside.extend(inside);
        self.shared.stop_outputs();
        // Otherwise a function that runs in circles keeps the processor from everything that could end the process, and
        // on a computer with one processor from the whole system.
        let tid = thread.tid.load(Ordering::Relaxed);
        let lowered = |priority| Lowered { thread: thread.id, tid, priority };
        self.lowered = os::take_fifo(tid).map(lowered);
    }

    /// Drives the outputs again when a function returns that may have written to them meanwhile.
    fn rest_again(&mut self, threads: &[Arc<Thread>]) {
        let before = self.left_inside.len();
        let inside = |id: &u32| threads.iter().any(|t| t.id == *id && t.gate.is_inside());
        self.left_inside.retain(&inside);
        if self.left_inside.len() != before {
            self.shared.stop_outputs();
        }
        if let Some(lowered) = self.lowered.take_if(|l| !inside(&l.thread))
            && threads.iter().any(|t| t.id == lowered.thread)
        {
            os::give_fifo(lowered.tid, lowered.priority);
        }
    }
}

/// Observes a thread, if it is inside a function. The expensive query of its activity is made only
/// if the thread was in the same call before.
fn sight(t: &Thread, known: Option<&Case>) -> Option<Sight> {
    let funct = t.current.load(Ordering::Relaxed);
    if funct == NOBODY || !t.gate.is_inside() {
        return None;
    }
    let cycles = t.cycles.load(Ordering::Relaxed);
    let tid = t.tid.load(Ordering::Relaxed);
    let same = known.is_some_and(|c| (c.seen.cycles, c.seen.funct) == (cycles, funct));
    Some(Sight {
        cycles,
        funct,
        init: !t.init_done.load(Ordering::Relaxed),
        ran_ns: processor_time(tid)?,
        doing: if same { doing(tid) } else { Doing::Runs },
    })
}

fn reason_text(room: &mut [u8; 64], us: i64) -> &str {
    use std::io::Write;
    let mut rest = &mut room[..];
    let (ms, part) = (us / 1000, us % 1000);
    let written = if part == 0 {
        write!(rest, "it did not come back within {ms} ms")
    } else {
        write!(rest, "it did not come back within {ms}.{part:03} ms")
    };
    let left = rest.len();
    let used = if written.is_ok() { room.len() - left } else { 0 };
    core::str::from_utf8(room.get(..used).unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{Case, Sight, Verdict, reason_text};
    use crate::os::progress::Doing;

    const MS: i64 = 1_000_000;

    /// Observes a thread every 0.5 ms, with a limit of 2 ms. Each observation holds the cycle, the
    /// processor time in µs since the previous one, and the activity: runs, waits, or waits for a
    /// device. Returns the index of the observation at which the thread counts as stuck.
    fn check(init: bool, looks: impl IntoIterator<Item = (u64, i64, char)>) -> Option<usize> {
        let mut case: Option<Case> = None;
        let mut ran_ns = 0;
        for (i, (cycles, us, doing)) in looks.into_iter().enumerate() {
            ran_ns += us * 1000;
            let doing = match doing {
                'r' => Doing::Runs,
                'w' => Doing::Waits,
                'd' => Doing::WaitsForDevice,
                other => unreachable!("{other}"),
            };
            let sight = Sight { cycles, funct: 7, init, ran_ns, doing };
            let Some(case) = &mut case else {
                case = Some(Case::new(1, sight));
                continue;
            };
            if case.look(sight, MS / 2, 2 * MS) == Verdict::Stuck {
                return Some(i);
            }
        }
        None
    }

    fn same(n: usize, us: i64, doing: char) -> impl Iterator<Item = (u64, i64, char)> {
        core::iter::repeat_n((1, us, doing), n)
    }

    #[test]
    fn a_function_that_computes_or_waits_for_ever_is_stuck_after_its_time() {
        assert_eq!(check(false, same(100, 500, 'r')), Some(4));
        assert_eq!(check(false, same(100, 0, 'w')), Some(4));
        // Another thread uses the processor for half of the time.
        assert_eq!(check(false, same(100, 250, 'r')), Some(8));
        // The function computes and sleeps in turn.
        let turns = (0..100).map(|i| if i % 2 == 0 { (1, 300, 'r') } else { (1, 100, 'w') });
        assert_eq!(check(false, turns), Some(10));
    }

    #[test]
    fn a_verdict_needs_three_more_observations_however_rare_they_are() {
        let seen = |ran_ns| Sight { cycles: 1, funct: 7, init: false, ran_ns, doing: Doing::Runs };
        let mut case = Case::new(1, seen(0));
        let verdicts = [1, 2, 3].map(|n| case.look(seen(n * 10 * MS), 10 * MS, 2 * MS));
        assert_eq!(verdicts, [Verdict::Suspect, Verdict::Suspect, Verdict::Stuck]);
    }

    #[test]
    fn a_thread_that_gets_no_time_is_late_and_not_stuck() {
        // The thread waits for a processor, is stopped, or is held by a debugger.
        assert_eq!(check(false, same(100_000, 0, 'r')), None);
        // A jump of the clock by a second, as in a virtual machine that was paused, seen once.
        let mut looks: Vec<_> = same(3, 10, 'r').collect();
        looks.push((1, 1_000_000, 'r'));
        looks.extend(same(50, 10, 'r'));
        assert_eq!(check(false, looks), None);
        // Each cycle is a separate call, however many there are.
        assert_eq!(check(false, (0..1000).map(|i| (i / 4, 500, 'r'))), None);
    }

    #[test]
    fn disks_and_hardware_that_is_set_up_have_a_second() {
        assert_eq!(check(false, same(1900, 0, 'd')), None);
        assert_eq!(check(false, same(2100, 0, 'd')), Some(2000));
        assert_eq!(check(true, same(1900, 500, 'r')), None);
        assert_eq!(check(true, same(2100, 500, 'r')), Some(2000));
    }

    #[test]
    fn the_message_has_the_time() {
        for (us, want) in [
            (2000, "it did not come back within 2 ms"),
            (1500, "it did not come back within 1.500 ms"),
            (3_600_000_000, "it did not come back within 3600000 ms"),
        ] {
            assert_eq!(reason_text(&mut [0; 64], us), want);
        }
    }
}
