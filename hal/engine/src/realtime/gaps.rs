//! Realtime. Gaps in time: nothing of the instance ran for a while, and no thread was there to stop what moved.
//!
//! An overrun is a cycle that came late while the computer was busy; it stops nothing. A gap is a time in which the whole
//! process stood still. Each thread looks for one whenever it wakes, before its cycle, so that the first cycle after a gap
//! can know of it. What is a gap:
//!
//! - The process was stopped and continued (SIGSTOP, SIGTSTP of Ctrl-Z): SIGCONT is blocked in all threads of an instance,
//!   so that it is still pending when the first of them runs again, and a thread that has missed a cycle finds it. No
//!   delay by a busy computer leaves a SIGCONT. One that comes without a stop is dropped by a thread that is in time.
//! - The computer slept: `CLOCK_BOOTTIME` counts during a sleep, `CLOCK_MONOTONIC` does not.
//! - Nothing ran for `[HAL]MAX_GAP`, and this was not for want of a processor. A debugger, a frozen container and a paused
//!   virtual machine send no signal. Under `SCHED_FIFO` nothing else takes the processor for so long. Without it, the
//!   kernel counts for each thread how long it has run and how long it has waited for a processor (`schedstat`): on a busy
//!   computer a late thread has waited, in a process that stood still it has not.
//! - The threads were stopped and started again by command, or after a fault.

use crate::{
    os::{self, process, progress::Schedule},
    sync::{AtomicI64, AtomicU32, AtomicU64, Ordering},
};

/// Default of `[HAL]MAX_GAP`, in nanoseconds.
const MAX_GAP_NS: i64 = 500_000_000;
/// Least sleep of the computer, in nanoseconds: two clocks are read one after the other.
const SLEPT_NS: i64 = 1_000_000;
/// Time between two looks at what a thread needs only when it is late, in nanoseconds.
const LOOK_NS: i64 = 100_000_000;
/// Number of gaps that are kept until the control side has read them.
const KEPT: usize = 16;

/// Cause of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// The process was stopped and continued.
    Stopped,
    /// The process did not run, and did not wait for a processor.
    Stood,
    /// The computer slept.
    Slept,
    /// The threads were stopped and started by command.
    Commanded,
    /// The threads were started again after a fault.
    Faulted,
}

const CAUSES: [Cause; 5] =
    [Cause::Stopped, Cause::Stood, Cause::Slept, Cause::Commanded, Cause::Faulted];

impl Cause {
    /// Returns the cause in words.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Stopped => "it was stopped and continued (SIGSTOP, Ctrl-Z)",
            Self::Stood => {
                "it did not run, and did not wait for a processor (a debugger, a frozen container, \
                 a paused computer)"
            }
            Self::Slept => "the computer slept",
            Self::Commanded => "the threads were stopped and started by command",
            Self::Faulted => "the threads were stopped by a fault and started again",
        }
    }
}

/// A gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Gap {
    pub(crate) cause: Cause,
    /// Duration in nanoseconds.
    pub(crate) ns: i64,
    /// Machine time at its end, in nanoseconds.
    pub(crate) time_ns: i64,
}

/// Times that a thread sees when it wakes, or when a cycle has taken longer than its period, in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// Monotonic time at which it should have woken, or at which its cycle began.
    pub(crate) due_ns: i64,
    /// Monotonic time.
    pub(crate) now_ns: i64,
    /// Lead of the clock that counts while the computer sleeps over the monotonic one.
    pub(crate) lead_ns: i64,
    pub(crate) period_ns: i64,
    /// Machine time.
    pub(crate) time_ns: i64,
    /// True if threads run their functions.
    pub(crate) is_running: bool,
}

/// Evidence that distinguishes a process that stood still from a busy computer.
pub(crate) trait Witness {
    /// Returns whether the thread looks for the first time: it may have begun late.
    fn begins(&mut self) -> bool;
    /// Returns whether the process was continued since it was last asked to forget that.
    fn was_continued(&mut self) -> bool;
    /// Forgets that the process was continued; returns whether it was, also since it was asked.
    fn forget(&mut self) -> bool;
    /// Returns whether nothing but a standstill can delay the thread for long.
    fn is_fifo(&self) -> bool;
    /// Returns for how long the thread has run or waited for a processor since its last look, and somewhat before; `None`
    /// if the system does not tell.
    fn busy_ns(&mut self) -> Option<i64>;
}

/// The gaps of an instance.
#[derive(Debug)]
pub(crate) struct Gaps {
    /// Number of gaps in the upper half; in the lower half what identifies the last one, so that two threads that notice
    /// the same gap count it once.
    state: AtomicU64,
    /// Monotonic time at which a thread last ran.
    ran_ns: AtomicI64,
    /// Last known lead of the clock that counts while the computer sleeps.
    lead_ns: AtomicI64,
    /// `[HAL]MAX_GAP` in nanoseconds.
    max_ns: AtomicI64,
    kept: [Kept; KEPT],
}

/// A gap until the control side has read it.
#[derive(Debug)]
struct Kept {
    number: AtomicU32,
    cause: AtomicU32,
    ns: AtomicI64,
    time_ns: AtomicI64,
}

impl Gaps {
    pub(crate) fn new() -> Self {
        let kept = || Kept {
            number: AtomicU32::new(0),
            cause: AtomicU32::new(0),
            ns: AtomicI64::new(0),
            time_ns: AtomicI64::new(0),
        };
        Self {
            state: AtomicU64::new(0),
            ran_ns: AtomicI64::new(0),
            lead_ns: AtomicI64::new(os::boot_ns() - os::monotonic_ns()),
            max_ns: AtomicI64::new(MAX_GAP_NS),
            kept: core::array::from_fn(|_| kept()),
        }
    }

    /// Control side: sets `[HAL]MAX_GAP`.
    pub(crate) fn set_max(&self, ns: i64) {
        self.max_ns.store(ns, Ordering::Relaxed);
    }

    /// Returns the number of gaps so far.
    pub(crate) fn count(&self) -> u32 {
        upper(self.state.load(Ordering::Relaxed))
    }

    /// Returns the lead of the clock that counts while the computer sleeps. `now_ns` was read just before.
    pub(crate) fn lead(&self, now_ns: i64) -> i64 {
        let boot = os::boot_ns();
        let lead = boot - now_ns;
        if lead - self.lead_ns.load(Ordering::Relaxed) < SLEPT_NS {
            return lead;
        }
        // The thread may have been held up between the two readings. The lead is at least this.
        boot - os::monotonic_ns()
    }

    /// Looks for a gap, before the cycle that comes next.
    pub(crate) fn look(&self, sight: &Sight, witness: &mut impl Witness) {
        let ran = self.ran_ns.load(Ordering::Relaxed);
        let from = if ran > sight.due_ns { ran } else { sight.due_ns };
        let stood = sight.now_ns - from;
        let lead = self.lead_ns.load(Ordering::Relaxed);
        let slept = sight.lead_ns - lead;
        let missed = !witness.begins() && stood >= sight.period_ns;
        let found = if slept >= SLEPT_NS {
            Some((Cause::Slept, slept, lead))
        } else if missed && witness.was_continued() {
            Some((Cause::Stopped, stood, ran))
        } else if missed && stood >= self.max_ns.load(Ordering::Relaxed) {
            self.was_idle(stood, witness).then_some((Cause::Stood, stood, ran))
        } else {
            None
        };
        let note = |(cause, ns, before)| {
            if sight.is_running {
                self.note(Gap { cause, ns, time_ns: sight.time_ns }, Some(key(before)));
            }
        };
        found.into_iter().for_each(note);
        if slept >= SLEPT_NS {
            self.lead_ns.store(sight.lead_ns, Ordering::Relaxed);
        }
        // Other threads no longer see that the process was continued, but what was noted. A stop since the question above is
        // a gap as well: nothing else will tell of it.
        if missed && witness.forget() && found.is_none() {
            note((Cause::Stopped, stood, ran));
        }
        self.ran_ns.store(sight.now_ns, Ordering::Relaxed);
    }

    /// Returns whether a thread that did not run for this long did so without waiting for a processor.
    fn was_idle(&self, stood_ns: i64, witness: &mut impl Witness) -> bool {
        let max = self.max_ns.load(Ordering::Relaxed);
        witness.is_fifo() || witness.busy_ns().is_some_and(|busy| stood_ns - busy >= max)
    }

    /// Counts a gap, unless another thread has counted the same one.
    pub(crate) fn note(&self, gap: Gap, key: Option<u32>) {
        let mut before = self.state.load(Ordering::Relaxed);
        let number = loop {
            let number = upper(before).wrapping_add(1);
            let its = key.unwrap_or(lower(before));
            if key.is_some() && upper(before) != 0 && lower(before) == its {
                return;
            }
            let after = u64::from(number) << 32 | u64::from(its);
            let order = (Ordering::Relaxed, Ordering::Relaxed);
            match self.state.compare_exchange(before, after, order.0, order.1) {
                Ok(_) => break number,
                Err(now) => before = now,
            }
        };
        if let Some(kept) = self.kept.get(number as usize % KEPT) {
            let cause = CAUSES.iter().position(|c| *c == gap.cause).unwrap_or(0);
            kept.cause.store(u32::try_from(cause).unwrap_or(0), Ordering::Relaxed);
            kept.ns.store(gap.ns, Ordering::Relaxed);
            kept.time_ns.store(gap.time_ns, Ordering::Relaxed);
            kept.number.store(number, Ordering::Release); // Pairs with `get`.
        }
    }

    /// Control side: returns a gap by its number, from 1; `None` if it is not kept.
    pub(crate) fn get(&self, number: u32) -> Option<Gap> {
        let kept = self.kept.get(number as usize % KEPT)?;
        // Pairs with `note`.
        if number == 0 || kept.number.load(Ordering::Acquire) != number {
            return None;
        }
        let cause = *CAUSES.get(kept.cause.load(Ordering::Relaxed) as usize)?;
        let (ns, time_ns) = (kept.ns.load(Ordering::Relaxed), kept.time_ns.load(Ordering::Relaxed));
        Some(Gap { cause, ns, time_ns })
    }

    /// Control side: returns the gaps after the first `told` ones, as far as they are kept.
    pub(crate) fn since(&self, told: u32) -> impl Iterator<Item = Gap> {
        let last = self.count();
        let first = last.saturating_sub(u32::try_from(KEPT).unwrap_or(0));
        let first = if told > first { told } else { first };
        (first..last).filter_map(|n| self.get(n + 1))
    }
}

fn upper(state: u64) -> u32 {
    u32::try_from(state >> 32).unwrap_or(0)
}

fn lower(state: u64) -> u32 {
    u32::try_from(state & u64::from(u32::MAX)).unwrap_or(0)
}

/// Returns what identifies a gap: when threads last ran before it, or the lead of the clock that counts in a sleep.
fn key(before_ns: i64) -> u32 {
    u32::try_from((before_ns / 1000) & i64::from(u32::MAX)).unwrap_or(0)
}

/// The witness of a thread that runs cycles: what the system tells about it.
#[derive(Debug)]
pub(crate) struct Lookout {
    fifo: bool,
    begins: bool,
    /// True if a SIGCONT was taken that may belong to a stop.
    continued: bool,
    /// Without FIFO: run time and waiting time of the thread, and their sum at the last look.
    schedule: Option<(Schedule, i64)>,
    next_ns: i64,
}

impl Lookout {
    /// Creates the witness of the calling thread.
    pub(crate) fn new(fifo: bool) -> Self {
        let schedule = if fifo { None } else { Schedule::of_this_thread() };
        let schedule = schedule.and_then(|s| s.busy_ns().map(|busy| (s, busy)));
        Self { fifo, begins: true, continued: false, schedule, next_ns: 0 }
    }

    /// Ends a cycle that was in time: drops a SIGCONT without a stop, and begins to count the waiting time again.
    pub(crate) fn rest(&mut self, began_ns: i64, now_ns: i64, period_ns: i64) {
        if now_ns < self.next_ns {
            return;
        }
        self.next_ns = now_ns + LOOK_NS;
        self.continued = false;
        if process::is_continue_pending() {
            process::take_continue();
            // The stop was after the last reading of the clock. It shows at the next wake-up.
            self.continued = os::monotonic_ns() - began_ns >= period_ns;
        }
        if let Some((schedule, busy)) = &mut self.schedule {
            *busy = schedule.busy_ns().unwrap_or(*busy);
        }
    }
}

impl Witness for Lookout {
    fn begins(&mut self) -> bool {
        core::mem::take(&mut self.begins)
    }

    fn was_continued(&mut self) -> bool {
        self.continued || process::is_continue_pending()
    }

    fn forget(&mut self) -> bool {
        let continued = core::mem::take(&mut self.continued);
        process::take_continue() || continued
    }

    fn is_fifo(&self) -> bool {
        self.fifo
    }

    fn busy_ns(&mut self) -> Option<i64> {
        let (schedule, before) = self.schedule.as_ref()?;
        Some(schedule.busy_ns()? - before)
    }
}

#[cfg(test)]
mod tests {
    use super::{Cause, Gap, Gaps, KEPT, Sight, Witness};
    use crate::realtime::overruns::of_gap;

    const MS: i64 = 1_000_000;

    /// Answers that a test lets the system give.
    #[derive(Clone, Copy, Debug, Default)]
    struct Told {
        fifo: bool,
        begins: bool,
        continued: bool,
        busy_ms: Option<i64>,
        /// True if the process is stopped and continued behind the question whether it was.
        late: bool,
        /// Number of reads of what costs a system call.
        asked: u32,
    }

    impl Witness for Told {
        fn begins(&mut self) -> bool {
            core::mem::take(&mut self.begins)
        }
        fn was_continued(&mut self) -> bool {
            self.asked += 1;
            self.continued
        }
        fn forget(&mut self) -> bool {
            core::mem::take(&mut self.continued) || core::mem::take(&mut self.late)
        }
        fn is_fifo(&self) -> bool {
            self.fifo
        }
        fn busy_ns(&mut self) -> Option<i64> {
            self.asked += 1;
            self.busy_ms.map(|ms| ms * MS)
        }
    }

    const FIFO: Told =
        Told { fifo: true, begins: false, continued: false, busy_ms: None, late: false, asked: 0 };
    const ORDINARY: Told = Told { fifo: false, ..FIFO };

    /// A machine with a clock of its own and a thread of 1 ms.
    struct Machine {
        gaps: Gaps,
        now_ms: i64,
        lead_ms: i64,
    }

    impl Machine {
        fn new() -> Self {
            let gaps = Gaps::new();
            gaps.lead_ns.store(0, super::Ordering::Relaxed);
            let mut m = Self { gaps, now_ms: 1_000, lead_ms: 0 };
            m.wake(0, &mut FIFO.clone());
            m
        }

        /// Wakes a thread that was due one period after it last ran, this much later. Returns the new gap.
        fn wake(&mut self, late_ms: i64, witness: &mut impl Witness) -> Option<Gap> {
            let due_ms = self.now_ms + 1;
            self.now_ms = due_ms + late_ms;
            self.look(due_ms, witness)
        }

        fn look(&self, due_ms: i64, witness: &mut impl Witness) -> Option<Gap> {
            let before = self.gaps.count();
            let sight = Sight {
                due_ns: due_ms * MS,
                now_ns: self.now_ms * MS,
                lead_ns: self.lead_ms * MS,
                period_ns: MS,
                time_ns: (self.now_ms - 1_000) * MS,
                is_running: true,
            };
            self.gaps.look(&sight, witness);
            let found = self.gaps.since(before).last();
            assert_eq!(self.gaps.count() - before, u32::from(found.is_some()));
            found
        }
    }

    fn check(late_ms: i64, mut witness: Told, want: Option<Cause>) {
        let mut m = Machine::new();
        let found = m.wake(late_ms, &mut witness);
        assert_eq!(found.map(|g| g.cause), want, "{late_ms} ms: {witness:?}");
        assert!(found.is_none_or(|g| g.ns == late_ms * MS));
        assert!(!witness.continued || late_ms == 0, "only a late thread takes the signal");
    }

    #[test]
    fn a_process_that_was_stopped_and_continued_stood_still_however_briefly() {
        for witness in [FIFO, ORDINARY] {
            for ms in [1, 3, 600, 3_600_000] {
                check(ms, Told { continued: true, ..witness }, Some(Cause::Stopped));
            }
            // No cycle was missed: a signal alone is no gap.
            check(0, Told { continued: true, ..witness }, None);
        }
    }

    #[test]
    fn a_stop_behind_the_question_whether_there_was_one_is_not_lost() {
        check(3, Told { late: true, ..FIFO }, Some(Cause::Stopped));
        check(600, Told { late: true, ..ORDINARY }, Some(Cause::Stopped));
    }

    #[test]
    fn half_a_second_without_a_reason_is_a_gap() {
        for (ms, want) in
            [(1, None), (499, None), (500, Some(Cause::Stood)), (3_000, Some(Cause::Stood))]
        {
            check(ms, FIFO, want);
            check(ms, Told { busy_ms: Some(0), ..ORDINARY }, want);
        }
    }

    #[test]
    fn a_busy_computer_without_fifo_makes_overruns_and_no_gaps() {
        for ms in [500, 3_000, 60_000] {
            // The thread has waited for a processor for all of the time, or nearly.
            check(ms, Told { busy_ms: Some(ms), ..ORDINARY }, None);
            check(ms, Told { busy_ms: Some(ms - 499), ..ORDINARY }, None);
            // The kernel does not tell: the computer may have been busy.
            check(ms, ORDINARY, None);
        }
        check(3_000, Told { busy_ms: Some(2_500), ..ORDINARY }, Some(Cause::Stood));
    }

    #[test]
    fn the_limit_can_be_set() {
        let mut m = Machine::new();
        m.gaps.set_max(20 * MS);
        assert_eq!(m.wake(19, &mut FIFO.clone()), None);
        assert!(m.wake(20, &mut FIFO.clone()).is_some());
    }

    #[test]
    fn a_computer_that_slept_is_seen_at_the_first_wake_up_though_that_is_not_late() {
        let mut m = Machine::new();
        let mut witness = FIFO;
        assert_eq!(m.wake(0, &mut witness), None);
        m.lead_ms += 3_600_000;
        let want = Gap { cause: Cause::Slept, ns: 3_600_000 * MS, time_ns: 2 * MS };
        assert_eq!(m.wake(0, &mut witness).map(|g| Gap { time_ns: 2 * MS, ..g }), Some(want));
        assert_eq!(m.wake(0, &mut witness), None, "once");
        // Two readings of clocks are never at the same time.
        m.lead_ms += 0;
        assert_eq!(m.wake(400, &mut witness), None);
    }

    #[test]
    fn the_clock_that_sleeps_is_read_again_when_a_thread_was_held_up_between_two_readings() {
        let gaps = Gaps::new();
        let now = crate::os::monotonic_ns();
        // Read an hour ago, as it seems.
        let lead = gaps.lead(now - 3_600_000 * MS);
        let slept = lead - gaps.lead_ns.load(super::Ordering::Relaxed);
        assert!(slept < MS, "{slept}");
    }

    #[test]
    fn a_gap_within_a_cycle_is_seen_at_its_end() {
        let mut m = Machine::new();
        let mut witness = FIFO;
        let began = m.now_ms;
        m.now_ms += 3_000;
        let gap = m.look(began, &mut witness).unwrap();
        assert_eq!((gap.cause, gap.ns), (Cause::Stood, 3_000 * MS));
        // The next cycle is in time, and sees the count.
        assert_eq!((m.wake(0, &mut witness), m.gaps.count()), (None, 1));
    }

    #[test]
    fn two_threads_that_see_the_same_gap_count_it_once() {
        let mut m = Machine::new();
        // The slower thread is interrupted between its look and what it stores.
        let before = m.gaps.ran_ns.load(super::Ordering::Relaxed);
        assert!(m.wake(600, &mut FIFO.clone()).is_some());
        m.gaps.ran_ns.store(before, super::Ordering::Relaxed);
        assert_eq!(m.wake(0, &mut FIFO.clone()), None);
        assert_eq!(m.gaps.count(), 1);
        // The next one is another.
        assert!(m.wake(600, &mut FIFO.clone()).is_some());
        // While one thread runs, another that gets no turn is late, and nothing stood still.
        let due = m.now_ms - 5_000;
        assert_eq!(m.look(due, &mut FIFO.clone()), None);
    }

    #[test]
    fn a_thread_that_has_just_been_started_may_begin_late() {
        check(3_000, Told { begins: true, ..FIFO }, None);
    }

    #[test]
    fn a_thread_in_time_asks_the_system_nothing() {
        let mut m = Machine::new();
        let mut witness = FIFO;
        for _ in 0..100 {
            m.wake(0, &mut witness);
        }
        assert_eq!(witness.asked, 0);
    }

    #[test]
    fn threads_that_are_stopped_have_no_gaps_but_count_as_one_when_they_start() {
        let m = Machine::new();
        let sight = Sight {
            due_ns: 0,
            now_ns: 60_000 * MS,
            lead_ns: 60_000 * MS,
            period_ns: MS,
            time_ns: 0,
            is_running: false,
        };
        m.gaps.look(&sight, &mut FIFO.clone());
        assert_eq!(m.gaps.count(), 0);
        let gap = |cause| Gap { cause, ns: 3_000 * MS, time_ns: 7 };
        m.gaps.note(gap(Cause::Commanded), None);
        m.gaps.note(gap(Cause::Commanded), None);
        assert_eq!((m.gaps.count(), m.gaps.get(2)), (2, Some(gap(Cause::Commanded))));
        assert_eq!(of_gap(&gap(Cause::Commanded)), None, "who did it knows");
        let said = of_gap(&gap(Cause::Stopped)).unwrap();
        assert_eq!(
            said,
            "realtime: the process stood still for 3.0 s: it was stopped and continued (SIGSTOP, \
             Ctrl-Z)"
        );
    }

    #[test]
    fn the_last_gaps_are_kept() {
        let m = Machine::new();
        for n in 1..=40 {
            m.gaps.note(Gap { cause: Cause::Stood, ns: n, time_ns: n }, None);
        }
        let kept: Vec<i64> = m.gaps.since(0).map(|g| g.ns).collect();
        assert_eq!(kept.len(), KEPT);
        assert_eq!(kept.last(), Some(&40));
        assert_eq!(m.gaps.since(39).count() + m.gaps.since(40).count(), 1);
        assert_eq!((m.gaps.get(0), m.gaps.get(1), m.gaps.get(41)), (None, None, None));
    }
}
