//! Turns of the transactions of a line: by their rates, and such that a silent device starves none.

use super::config::TransactionConfig;

/// Time in which the late answer of a silent device on a serial line would be taken for that to the next request.
const LATE_NS: i64 = 500_000_000;
/// Shortest time from a refused request to the next of its transaction.
const REFUSED_NS: i64 = 1_000_000_000;
/// Longest time for which a device that does not answer is left alone.
const LONGEST_NS: i64 = 8_000_000_000;
/// Number of times that a request is repeated at once, whose answer was broken.
const RETRIES: u32 = 2;

/// State of a transaction.
#[derive(Clone, Copy, Debug)]
struct Turn {
    unit: u8,
    period_ns: i64,
    timeout_ns: i64,
    due: i64,
    /// Number of broken answers since the last good one.
    broken: u32,
}

/// Device that does not answer.
#[derive(Clone, Copy, Debug, Default)]
struct Silence {
    /// Number of requests without an answer, one after the other.
    count: u32,
    /// Time until which it is left alone.
    until: i64,
}

/// Turns of all transactions of a line.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    turns: Vec<Turn>,
    silences: Vec<Silence>,
    /// Answers carry the number of their request.
    is_numbered: bool,
}

impl Schedule {
    pub(crate) fn new<'t>(
        all: impl Iterator<Item = &'t TransactionConfig>,
        is_numbered: bool,
    ) -> Self {
        let turn = |of: &TransactionConfig| Turn {
            unit: of.unit,
            period_ns: of.period_ns,
            timeout_ns: of.timeout_ns,
            due: 0,
            broken: 0,
        };
        Self {
            turns: all.map(turn).collect(),
            silences: vec![Silence::default(); 256],
            is_numbered,
        }
    }

    fn silence(&self, unit: u8) -> Silence {
        self.silences.get(usize::from(unit)).copied().unwrap_or_default()
    }

    /// Returns whether a device has not answered its last request.
    pub(crate) fn is_silent(&self, unit: u8) -> bool {
        self.silence(unit).count != 0
    }

    /// Returns the transaction that has waited longest of those that are due.
    pub(crate) fn next(&self, now: i64) -> Option<usize> {
        let is_ready = |turn: &Turn| turn.due <= now && self.silence(turn.unit).until <= now;
        let ready = self.turns.iter().enumerate().filter(|(_, turn)| is_ready(turn));
        ready.min_by_key(|(_, turn)| turn.due).map(|(n, _)| n)
    }

    /// Notes an answer.
    pub(crate) fn answered(&mut self, n: usize, now: i64) {
        let Some(turn) = self.turns.get_mut(n) else { return };
        turn.broken = 0;
        turn.due = after(turn.due, turn.period_ns, now);
        if let Some(silence) = self.silences.get_mut(usize::from(turn.unit)) {
            *silence = Silence::default();
        }
    }

    /// Notes that a device refuses a transaction. It answers: its other transactions keep their rates.
    pub(crate) fn refused(&mut self, n: usize, now: i64) {
        self.answered(n, now);
        if let Some(turn) = self.turns.get_mut(n) {
            turn.due = turn.due.max(now.saturating_add(REFUSED_NS));
        }
    }

    /// Notes that a device has not answered: the others go first, the longer the more often that happens.
    pub(crate) fn silent(&mut self, n: usize, now: i64) {
        let Some(turn) = self.turns.get_mut(n) else { return };
        turn.due = after(turn.due, turn.period_ns, now);
        let Some(silence) = self.silences.get_mut(usize::from(turn.unit)) else { return };
        silence.count = silence.count.saturating_add(1);
        let doublings = silence.count.saturating_sub(1).min(10);
        let wait = match (self.is_numbered, silence.count) {
            (true, 1) => 0,
            _ => turn.timeout_ns.max(LATE_NS).saturating_mul(1 << doublings).min(LONGEST_NS),
        };
        silence.until = now.saturating_add(wait);
    }

    /// Notes a broken answer: the request is repeated at once, but not without an end.
    pub(crate) fn broken(&mut self, n: usize, now: i64) {
        let Some(turn) = self.turns.get_mut(n) else { return };
        turn.broken = turn.broken.saturating_add(1);
        if turn.broken % (RETRIES + 1) == 0 {
            turn.due = after(turn.due, turn.period_ns, now);
        }
    }
}

/// Returns when a transaction is due again. Periods that were missed are left out.
const fn after(due: i64, period_ns: i64, now: i64) -> i64 {
    let next = due.saturating_add(period_ns);
    if period_ns == 0 || next.saturating_add(period_ns) < now {
        now.saturating_add(period_ns)
    } else {
        next
    }
}
