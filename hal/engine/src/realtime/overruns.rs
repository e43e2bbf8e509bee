//! Messages about missed real time: the first overrun of each thread, then one a minute; and each gap.

use crate::realtime::gaps::{Cause, Gap};
use std::{collections::BTreeMap, fmt::Write};

/// Time between two messages, in nanoseconds.
const INTERVAL_NS: i64 = 60_000_000_000;

/// Current overruns of a thread.
#[derive(Clone, Debug)]
pub(crate) struct Overran {
    pub(crate) id: u32,
    pub(crate) thread: String,
    pub(crate) period_ns: i64,
    /// Cycles that ended after the next was due, and cycles that never began.
    pub(crate) overruns: u64,
    pub(crate) missed: u64,
    /// The function that took longest in the last overrun; `None` if the cycle itself began too
    /// late.
    pub(crate) guilty: Option<String>,
    pub(crate) late_ns: i64,
    pub(crate) took_ns: i64,
}

/// Overruns that have been reported.
#[derive(Debug, Default)]
pub(crate) struct Overruns {
    told: BTreeMap<u32, (u64, u64)>,
    last_ns: i64,
}

impl Overruns {
    /// Returns the messages that are due. `threads` are all that have overrun; one that is gone is forgotten. With
    /// `ends`, everything not yet reported is due now.
    pub(crate) fn look(&mut self, now_ns: i64, threads: &[Overran], ends: bool) -> Vec<String> {
        self.told.retain(|id, _| threads.iter().any(|t| t.id == *id));
        let mut messages = Vec::new();
        let is_due = ends || self.last_ns.saturating_add(INTERVAL_NS) <= now_ns;
        let mut more = String::new();
        for t in threads {
            let (overruns, missed) = self.told.get(&t.id).copied().unwrap_or_default();
            if t.overruns == overruns {
                continue;
            }
            if overruns == 0 {
                messages.push(format!(
                    "realtime: thread '{}' {}{}",
                    t.thread,
                    t.cause(),
                    t.left_out()
                ));
            } else if is_due {
                let n = t.overruns.saturating_sub(overruns);
                // Writing to a `String` cannot fail.
                let _: Result<(), std::fmt::Error> = write!(
                    more,
                    "{}thread '{}' overran {n} more {}, {} in all, {} missed; the last {}",
                    if more.is_empty() { "realtime: " } else { "; " },
                    t.thread,
                    if n == 1 { "time" } else { "times" },
                    t.overruns,
                    cycles(t.missed.saturating_sub(missed)),
                    t.cause()
                );
            } else {
                continue;
            }
            self.told.insert(t.id, (t.overruns, t.missed));
        }
        messages.extend(Some(more).filter(|m| !m.is_empty()));
        if !messages.is_empty() {
            self.last_ns = now_ns;
        }
        messages
    }
}

impl Overran {
    fn cause(&self) -> String {
        let us = |ns: i64| format!("{:.3} ms", ns as f64 / 1e6);
        let (took, late, period) = (us(self.took_ns), us(self.late_ns), us(self.period_ns));
        match &self.guilty {
            Some(funct) => {
                format!("took {took} of its {period}, function '{funct}' most of it")
            }
            None if self.late_ns > self.took_ns => {
                format!("woke {late} late, with a period of {period}")
            }
            None => format!("took {took} of its {period} ('timing on' shows in which function)"),
        }
    }

    fn left_out(&self) -> String {
        if self.missed == 0 { String::new() } else { format!("; {} missed", cycles(self.missed)) }
    }
}

/// Returns the message about a gap. Who stops and starts threads by command, or after a fault, knows it.
pub(crate) fn of_gap(gap: &Gap) -> Option<String> {
    let silent = matches!(gap.cause, Cause::Commanded | Cause::Faulted);
    let (seconds, why) = (gap.ns as f64 / 1e9, gap.cause.words());
    (!silent).then(|| format!("realtime: the process stood still for {seconds:.1} s: {why}"))
}

fn cycles(n: u64) -> String {
    format!("{n} {}", if n == 1 { "cycle" } else { "cycles" })
}

#[cfg(test)]
mod tests {
    use super::{INTERVAL_NS, Overran, Overruns};

    fn thread(id: u32, overruns: u64, missed: u64, guilty: Option<&str>) -> Overran {
        Overran {
            id,
            thread: format!("t{id}"),
            period_ns: 1_000_000,
            overruns,
            missed,
            guilty: guilty.map(str::to_owned),
            late_ns: if guilty.is_none() { 5_200_000 } else { 10_000 },
            took_ns: 1_500_000,
        }
    }

    #[test]
    fn the_first_then_one_a_minute() {
        let mut told = Overruns::default();
        let mut check = |seconds: i64, threads: &[Overran], ends, want: &[&str]| {
            let now = seconds * 1_000_000_000;
            assert_eq!(told.look(now, threads, ends), want, "at {seconds} s");
        };
        let busy = |n, missed| thread(1, n, missed, Some("busy.0"));
        let slow = |n, missed| thread(2, n, missed, None);
        check(1, &[busy(0, 0), slow(0, 0)], false, &[]);
        let first =
            "realtime: thread 't1' took 1.500 ms of its 1.000 ms, function 'busy.0' most of it";
        check(2, &[busy(1, 0), slow(0, 0)], false, &[first]);
        check(3, &[busy(40, 7), slow(0, 0)], false, &[]);
        // The first overrun of another thread is reported at once.
        let other =
            "realtime: thread 't2' woke 5.200 ms late, with a period of 1.000 ms; 1 cycle missed";
        check(4, &[busy(41, 7), slow(1, 1)], false, &[other]);
        check(63, &[busy(900, 7), slow(2, 1)], false, &[]);
        let both = "realtime: thread 't1' overran 999 more times, 1000 in all, 7 cycles missed; the \
                    last took 1.500 ms of its 1.000 ms, function 'busy.0' most of it; thread 't2' \
                    overran 1 more time, 2 in all, 0 cycles missed; the last woke 5.200 ms late, \
                    with a period of 1.000 ms";
        check(64, &[busy(1000, 7), slow(2, 1)], false, &[both]);
        // Without new overruns nothing is reported, however much time passes.
        check(500, &[busy(1000, 7), slow(2, 1)], false, &[]);
        let again = "realtime: thread 't1' overran 1 more time, 1001 in all, 2 cycles missed; the \
                     last took 1.500 ms of its 1.000 ms, function 'busy.0' most of it";
        check(501, &[busy(1001, 9), slow(2, 1)], false, &[again]);
        check(502, &[busy(1002, 9), slow(2, 1)], false, &[]);
        // At the end, everything left is reported.
        let last = "realtime: thread 't1' overran 1 more time, 1002 in all, 0 cycles missed; the \
                    last took 1.500 ms of its 1.000 ms, function 'busy.0' most of it";
        check(503, &[busy(1002, 9), slow(2, 1)], true, &[last]);
        check(504, &[busy(1002, 9), slow(2, 1)], true, &[]);
    }

    #[test]
    fn threads_that_are_gone_are_forgotten() {
        let mut told = Overruns::default();
        for id in 0..1000 {
            assert_eq!(told.look(0, &[thread(id, 1, 0, None)], false).len(), 1);
            assert_eq!(told.told.len(), 1);
        }
        assert_eq!(told.look(0, &[], false).len() + told.told.len(), 0);
    }

    #[test]
    fn an_hour_of_overruns_in_each_cycle_is_one_message_a_minute() {
        let mut told = Overruns::default();
        let mut messages = 0;
        for ms in 1..=3_600_000_u64 {
            let now = i64::try_from(ms).unwrap() * 1_000_000;
            messages += told.look(now, &[thread(1, ms, 0, Some("f"))], false).len();
        }
        assert_eq!(messages, 60);
        assert_eq!(INTERVAL_NS, 60_000_000_000);
    }

    #[test]
    fn functions_that_are_not_timed_are_not_accused() {
        let mut t = thread(1, 1, 0, None);
        t.late_ns = 0;
        let want = "realtime: thread 't1' took 1.500 ms of its 1.000 ms ('timing on' shows in \
                    which function)";
        assert_eq!(Overruns::default().look(0, &[t], false), [want]);
    }
}
