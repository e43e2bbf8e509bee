//! The stop that needs no worker.

use super::flags::RunFlags;
use crate::line::{OpenLine, pause};
use core::time::Duration;
use hal_component::Clock;
use hal_modbus::huanyang::{Ask, STOP, find, state};
use port::Exchange as _;
use std::sync::{
    Arc, Mutex, MutexGuard, PoisonError, TryLockError,
    atomic::{AtomicI64, Ordering::Relaxed},
};

/// Longest time for which the stop action lets a request and its answer pass.
const LONGEST_NS: i64 = 150_000_000;
/// Number of last stops.
const LAST: usize = 3;
/// Time before each of them in which the line may still be busy, in nanoseconds.
const BUSY_NS: i64 = 60_000_000;
/// Time for the answer to each of them, in nanoseconds.
const ANSWER_NS: i64 = 100_000_000;
/// Time without bytes after which the line is quiet.
const QUIET: Duration = Duration::from_millis(40);
/// Largest number of pieces that are taken in one attempt, where the clock stands still.
const PIECES: usize = 1000;
/// Number of the latest bytes among which the answer is looked for.
const KEPT: usize = 128;

/// Line of an inverter, for those who stop it while its worker may be dead.
#[derive(Debug)]
pub(crate) struct Halt {
    unit: u8,
    frame: Vec<u8>,
    line: Mutex<Option<Arc<OpenLine>>>,
    clock: Clock,
    pub(crate) flags: RunFlags,
    /// Machine time from which the inverter hears a frame.
    quiet_at: AtomicI64,
}

impl Halt {
    pub(crate) fn new(unit: u8, clock: Clock) -> Self {
        Self {
            unit,
            frame: Ask::Control(STOP).frame(unit),
            line: Mutex::new(None),
            clock,
            flags: RunFlags::new(),
            quiet_at: AtomicI64::new(i64::MIN),
        }
    }

    /// Notes the line.
    pub(crate) fn on(&self, line: Option<Arc<OpenLine>>) {
        let mut held = self.line.lock().unwrap_or_else(PoisonError::into_inner);
        let before = core::mem::replace(&mut *held, line);
        // The line is closed here, and not while a stop would find the lock taken.
        drop(held);
        drop(before);
    }

    /// Notes from when on the inverter hears a frame.
    pub(crate) fn set_quiet_at(&self, quiet_at: i64) {
        self.quiet_at.store(quiet_at, Relaxed);
    }

    /// Returns the line, unless the worker opens or closes it just now.
    fn try_line(&self) -> Option<MutexGuard<'_, Option<Arc<OpenLine>>>> {
        match self.line.try_lock() {
            Ok(line) => Some(line),
            Err(TryLockError::Poisoned(line)) => Some(line.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Sends a stop now. Allocates nothing, frees nothing and waits for no lock.
    fn send(&self) {
        let Some(line) = self.try_line() else { return };
        if let Some(line) = &*line {
            // A lost line takes nothing; the inverter's own time-out is what is left then.
            let _ = line.send_now(&self.frame, self.clock.now_ns());
        }
    }

    /// Lets so many nanoseconds pass on the line. Returns whether the line sends a stop by itself then, as a simulated one does.
    /// The lock is free meanwhile: the worker may close the line, and its end finds it.
    fn wait(&self, wait_ns: i64) -> bool {
        let wait = Duration::from_nanos(u64::try_from(wait_ns).unwrap_or_default());
        if wait.is_zero() {
            return false;
        }
        let now = self.clock.now_ns();
        let is_sent = self.try_line().is_some_and(|line| {
            line.as_ref().is_some_and(|line| line.send_later(&self.frame, wait, now))
        });
        if !is_sent {
            pause(wait);
        }
        is_sent
    }

    /// Realtime. Sends a stop if the inverter may turn: one system call, which does not wait.
    pub(crate) fn stop(&self) {
        if self.flags.begin() {
            self.send();
        }
    }

    /// Sends a stop if the inverter may turn, once the request under way and its answer have passed: 0.15 s later at most.
    pub(crate) fn stop_action(&self) {
        if self.flags.begin() {
            let left = self.quiet_at.load(Relaxed).saturating_sub(self.clock.now_ns());
            if !self.wait(left.min(LONGEST_NS)) {
                self.send();
            }
        }
    }

    /// Sends stops until one is answered, at most three: when the component goes. Takes 0.5 s at most.
    pub(crate) fn last_stop(&self) {
        let line = self.line.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(line) = line.filter(|_| self.flags.may_run()) else { return };
        for _ in 0..LAST {
            line.advance(self.clock.now_ns());
            // What comes before the stop is sent answers something else.
            let mut busy = Budget::new(&self.clock, BUSY_NS);
            for _ in 0..PIECES {
                if busy.piece(&line, QUIET).is_none_or(|piece| piece.is_empty()) {
                    break;
                }
            }
            if line.send(&self.frame).is_err() {
                return;
            }
            if self.is_answered(&line) {
                self.flags.set_may_run(false);
                return;
            }
        }
    }

    /// Waits for the answer to a stop.
    fn is_answered(&self, line: &OpenLine) -> bool {
        let mut budget = Budget::new(&self.clock, ANSWER_NS);
        let mut came = Vec::new();
        for _ in 0..PIECES {
            let Some(piece) = budget.piece(line, Duration::MAX) else { return false };
            came.extend(piece);
            came.drain(..came.len().saturating_sub(KEPT));
            match find(self.unit, Ask::Control(STOP), &came) {
                Some(answer) if answer & u16::from(state::RUN) == 0 => return true,
                // The late answer to a command to run.
                Some(_) => came.clear(),
                None => {}
            }
        }
        false
    }
}

/// Time that may still be waited: by the clock, and by what was waited, as the clock may stand still.
struct Budget<'c> {
    clock: &'c Clock,
    until: i64,
    left: Duration,
}

impl<'c> Budget<'c> {
    fn new(clock: &'c Clock, time_ns: i64) -> Self {
        let left = Duration::from_nanos(u64::try_from(time_ns).unwrap_or_default());
        Self { clock, until: clock.now_ns().saturating_add(time_ns), left }
    }

    /// Returns the bytes that come next, after at most so long. Returns nothing when the time is over, or the line lost.
    fn piece(&mut self, line: &OpenLine, most: Duration) -> Option<Vec<u8>> {
        let left = u64::try_from(self.until.saturating_sub(self.clock.now_ns())).ok()?;
        let wait = Duration::from_nanos(left).min(self.left).min(most);
        if wait.is_zero() {
            return None;
        }
        let mut into = [0; 64];
        let count = line.receive(&mut into, wait).ok()?;
        if count == 0 {
            self.left = self.left.saturating_sub(wait);
        }
        into.get(..count).map(<[u8]>::to_vec)
    }
}
