//! The guard: an ordinary thread that keeps recordings when the process crashes, and ends the
//! process when a signal asks for that and the control side does not respond. A thread of its own
//! writes recordings while the control side is busy: a slow disk, or a pipe that nobody reads, may
//! hold up that thread, but never the guard.

use super::{
    crash::{self, Cause, Shot},
    doing::Doing,
    instance::{Instance, instances, known},
    process::{GUARD, WAKE, is_claimed, park},
    signals::{self, is_asked},
    sys::{self, Registers},
    text::Text,
    who,
};
use crate::{
    os::progress::{self, Turn, processor_time},
    sync::{Arc, Ordering},
};
use std::sync::{Mutex, MutexGuard, TryLockError};

/// Period at which recordings are written, in milliseconds.
const ROUND_MS: i32 = 500;
/// Period at which the control side is observed once it has been asked to respond, in milliseconds.
const LOOK_MS: i64 = 16;
/// Number of counted observations after which the control side is considered stuck. An observation
/// counts if the control side is still busy with the same work or waits; if it had no processor
/// time, the observation does not count.
const LOOKS: u32 = 4;
/// Total number of observations after which the control side is considered stuck, counted or not.
/// Those in which it computes for work that may take long are not among them.
const MAX_LOOKS: u32 = 125;
/// Processor time that the control side must have used between two observations, in nanoseconds.
const TURN_NS: i64 = 5_000_000;
/// Number of observations that a stop action may take.
const STOP_LOOKS: u32 = 32;
/// Time to wait for threads to leave their cycles, and for a lock that another thread holds, in
/// milliseconds.
const WAIT_MS: u32 = 100;
/// Longest wait for threads that are inside their cycles but get no processor, in milliseconds.
const LATE_WAIT_MS: u32 = 1000;
/// Longest wait for the recording, in milliseconds: another thread may be writing to a busy disk.
const TAPE_WAIT_MS: u32 = 1000;

/// Message for an end in the middle of the code that records: its data may be inconsistent.
const INTERRUPTED: &str = "the recorder is in the middle of its own work, such as a write that does not return: the recording \
                           ends at its last write, and the flight recorder keeps no file\n";

/// Stack size in bytes; small because all memory may be locked.
const STACK: usize = 512 << 10;

/// Cause of the crash, for recordings.
static WHY: Mutex<Option<Text>> = Mutex::new(None);

/// Stores the cause of the crash.
pub(super) fn keep(text: &Text) {
    // No other thread uses it yet.
    if let Ok(mut why) = WHY.try_lock() {
        *why = Some(*text);
    }
}

/// Returns the cause of the crash.
pub(super) fn why() -> Text {
    // The lock's owner may be the thread that has crashed.
    WHY.try_lock().ok().and_then(|why| *why).unwrap_or_else(Text::new)
}

/// Starts the guard and the thread that writes recordings. Does nothing if the system cannot create
/// the threads.
pub(super) fn begin() {
    for (name, body) in [("hal-guard", run as fn()), ("hal-tape", write_recordings)] {
        let named = std::thread::Builder::new().name(name.into()).stack_size(STACK);
        drop(named.spawn(body));
    }
}

/// Writes recordings from time to time, until the process ends.
fn write_recordings() {
    signals::leave_to_others();
    let _stack = sys::Stack::new();
    while !is_claimed() {
        known().iter().for_each(|instance| instance.look_after_tape());
        sys::nap(i64::from(ROUND_MS));
    }
}

fn run() {
    signals::leave_to_others();
    let _stack = sys::Stack::new();
    GUARD.store(sys::thread(), Ordering::Relaxed);
    let waker = WAKE.load(Ordering::Relaxed);
    while !is_claimed() && !is_asked() && signals::handed().is_none() {
        sys::wait(waker, ROUND_MS);
    }
    let mut look = Look::default();
    while !is_claimed() {
        let doing = if signals::handed().is_none() {
            sys::nap(LOOK_MS);
            look.take()
        } else {
            None
        };
        if doing.is_some() || signals::handed().is_some() {
            // In a thread of its own: a stop action may not return either.
            let named = std::thread::Builder::new().name("hal-end".into()).stack_size(STACK);
            if named.spawn(move || end(doing.as_ref())).is_err() {
                end(doing.as_ref());
            }
            while !is_claimed() {
                sys::nap(1);
            }
        }
    }
    attend()
}

/// Ends the process because another process sent it a crash signal, or because the control side does not respond.
fn end(doing: Option<&Text>) -> ! {
    let place = Registers { code: 0, stack: sys::stack() };
    if let Some((signal, by)) = signals::handed() {
        let (said, shot) = (signals::said(signal), Shot::From(by));
        crash::crash(&Cause::Signal { signal, said, shot }, place)
    }
    let signal = signals::asked().map_or(libc::SIGTERM, |a| a.0);
    crash::crash(&Cause::Asked { signal, doing: doing.unwrap_or(&Text::new()) }, place)
}

/// Observation of the control side.
#[derive(Clone, Copy, Debug)]
struct Sight {
    /// Number of steps that the control side has made.
    beats: u64,
    /// Processor time that its thread has used, in nanoseconds.
    used_ns: i64,
    /// True if its thread waits.
    waits: bool,
    /// True if the control side runs code of a component.
    foreign: bool,
    /// True if it is in a wait, or in work, that ends by itself.
    patient: bool,
}

/// State of the control side at the latest observation.
#[derive(Debug, Default)]
struct Look {
    beats: u64,
    used_ns: i64,
    /// Number of counted observations, and of all observations.
    counted: u32,
    all: u32,
}

impl Look {
    /// Observes the control side. Returns a description of what it is doing once it is considered
    /// stuck.
    fn take(&mut self) -> Option<Text> {
        let Some(instance) = known().into_iter().next() else {
            // No instance is left or none exists yet, so there is no output to make safe.
            *self = Self::default();
            return None;
        };
        let control = &instance.control;
        let thread = instance.thread.load(Ordering::Relaxed);
        let doing = control.doing();
        let sight = Sight {
            beats: control.beats(),
            used_ns: processor_time(thread).unwrap_or(0),
            waits: progress::doing(thread) != progress::Doing::Runs,
            foreign: doing.is_some() || instance.cycle_of_control().is_some(),
            patient: control.is_patient(),
        };
        self.add(sight).then(|| instance.describe_control(doing.as_deref()))
    }

    /// Adds an observation. Returns whether the control side is now considered stuck.
    fn add(&mut self, now: Sight) -> bool {
        let Sight { beats, used_ns, waits, foreign, patient } = now;
        if beats != self.beats {
            *self = Self { beats, used_ns, ..Self::default() };
            return false;
        }
        let counts =
            if foreign { waits || used_ns - self.used_ns >= TURN_NS } else { waits && !patient };
        if counts {
            self.used_ns = used_ns;
            self.counted += 1;
        }
        // A patient control side that still computes makes progress.
        if waits || !patient {
            self.all += 1;
        }
        self.counted >= LOOKS || self.all >= MAX_LOOKS
    }
}

/// Keeps recordings while another thread handles a crash. If that thread gets stuck in a stop
/// action, this thread runs the remaining ones.
fn attend() -> ! {
    let (mut begun, mut looks) = (crash::begun(), 0);
    let mut alone = false;
    while !crash::outputs_are_safe() && !alone {
        sys::nap(LOOK_MS);
        let now = crash::begun();
        looks = if now == begun { looks + 1 } else { 0 };
        begun = now;
        alone = looks >= STOP_LOOKS;
    }
    if alone {
        crash::stop_outputs();
        crash::tell();
    }
    save();
    crash::have_saved();
    if alone {
        crash::finish();
    }
    park()
}

/// Keeps the recordings of every instance.
pub(super) fn save() {
    let why = why();
    for instance in instances() {
        instance.save(why.as_str());
    }
}

/// Takes a lock if it becomes free in time: its owner may be the thread that has crashed.
fn soon<T>(lock: &Mutex<T>, ms: u32) -> Option<MutexGuard<'_, T>> {
    for _ in 0..ms {
        match lock.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(poisoned)) => return Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => sys::nap(1),
        }
    }
    None
}

/// Reports that a recorder's data cannot be reached.
fn interrupted() {
    crash::has_written();
    sys::report(INTERRUPTED);
}

impl Instance {
    /// Writes the recording to its file, also while the control side is busy for long.
    fn look_after_tape(&self) {
        let tape = self.saved().tape.clone();
        if let Some(tape) = tape
            && let Ok(mut tape) = tape.try_lock()
        {
            tape.drain(false, self.shared.now());
        }
    }

    /// Returns the thread whose cycle the control side is running, on the virtual clock.
    fn cycle_of_control(&self) -> Option<Arc<crate::realtime::thread::Thread>> {
        let threads = self.shared.threads.load();
        let inside = threads.iter().find(|t| t.gate.is_inside()).cloned();
        inside.filter(|_| self.shared.is_virtual())
    }

    fn describe_control(&self, doing: Option<&Doing>) -> Text {
        let mut text = Text::new();
        if let Some(thread) = self.cycle_of_control() {
            who::describe_cycle(&mut text, &thread);
        } else if let Some(doing) = doing {
            doing.describe(&mut text);
        } else {
            text.add(format_args!("the control thread waits for something outside"));
        }
        text
    }

    /// Waits a little for the cycles in progress to end. Returns whether only the crashed one is
    /// left.
    fn is_still(&self) -> bool {
        let threads = self.shared.threads.load_full();
        let mut held: Option<(u32, Turn)> = None;
        for n in 0..LATE_WAIT_MS {
            let mut inside = threads.iter().filter(|t| t.gate.is_inside());
            let Some(thread) = inside.find(|t| !crash::has_crashed(t)) else { return true };
            let turn = held.filter(|h| h.0 == thread.id).map_or_else(|| thread.turn(), |h| h.1);
            held = Some((thread.id, turn));
            if n >= WAIT_MS && !turn.is_denied() {
                return false;
            }
            sys::nap(1);
        }
        false
    }

    fn save(&self, why: &str) {
        crash::come_on();
        let still = self.is_still();
        self.say_rest();
        let Some(saved) = soon(&self.saved, WAIT_MS) else { return sys::report(INTERRUPTED) };
        saved.programs.iter().for_each(|pid| crate::os::end_process(*pid, false));
        let (tape, flight) = (saved.tape.clone(), saved.flight.clone());
        drop(saved);
        crash::come_on();
        if let Some(tape) = tape.as_deref() {
            crash::writes_recording();
            let Some(mut tape) = soon(tape, TAPE_WAIT_MS) else {
                return interrupted();
            };
            tape.salvage(still, self.shared.now());
            if let Some(stopped) = tape.stopped() {
                sys::report(&format!("{stopped}\n"));
            }
        }
        crash::come_on();
        if let Some(flight) = flight.as_deref() {
            crash::writes_flight();
            let Some(mut flight) = soon(flight, WAIT_MS) else { return interrupted() };
            let said = flight.salvage(still, self.shared.now(), why);
            said.iter().for_each(|text| sys::report(&format!("{text}\n")));
        }
        crash::has_written();
    }

    /// Prints messages of components that the control side has not yet read.
    fn say_rest(&self) {
        let name_of = |id: u32| {
            let names = self.remains().map_or(&[][..], |r| &r.names);
            names.iter().find(|n| n.0 == id).map_or("?", |n| n.1.as_str())
        };
        while let Some(message) = self.shared.mailbox.message() {
            let text = crate::messages::text::format(&message, name_of(message.component));
            sys::report(&(text + "\n"));
        }
        while let Some(message) = self.shared.mailbox.text() {
            let text = crate::messages::text::spoken(&message, name_of(message.component));
            sys::report(&(text + "\n"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LOOK_MS, LOOKS, Look, MAX_LOOKS, Sight};

    const MS: i64 = 1_000_000;

    /// Observes a control side `n` times, at the same step unless `step` says otherwise, and `ns` of processor time
    /// apart. Returns the index of the observation at which it counts as stuck.
    fn check(n: u32, ns: i64, seen: Sight, step: impl Fn(u32) -> u64) -> Option<u32> {
        let mut look = Look::default();
        (0..n).find(|i| {
            let used_ns = i64::from(*i) * ns;
            look.add(Sight { beats: step(*i), used_ns, ..seen })
        })
    }

    const fn seen(waits: bool, foreign: bool, patient: bool) -> Sight {
        Sight { beats: 0, used_ns: 0, waits, foreign, patient }
    }

    #[test]
    fn a_control_side_that_does_not_come_on_is_stuck_after_four_observations() {
        // It waits; it waits or computes in a component, also during an orderly shutdown.
        for (ns, seen) in [
            (0, seen(true, false, false)),
            (0, seen(true, true, false)),
            (0, seen(true, true, true)),
            (5 * MS, seen(false, true, false)),
            (5 * MS, seen(false, true, true)),
        ] {
            assert_eq!(check(1000, ns, seen, |_| 1), Some(LOOKS), "{seen:?}");
        }
        // A component that gets half of that time at each observation counts at every second one.
        let slow = check(1000, 5 * MS / 2, seen(false, true, false), |_| 1);
        assert_eq!(slow, Some(2 * LOOKS));
    }

    /// Each component may take its time as it ends.
    #[test]
    fn a_control_side_that_comes_on_is_never_stuck() {
        for waits in [true, false] {
            for foreign in [true, false] {
                for patient in [true, false] {
                    let seen = seen(waits, foreign, patient);
                    let steps = |i: u32| u64::from(i / LOOKS + 1);
                    assert_eq!(check(1000, 5 * MS, seen, steps), None, "{seen:?}");
                }
            }
        }
    }

    #[test]
    fn work_that_may_take_long_has_two_seconds_of_waits_and_any_time_to_compute() {
        assert_eq!(check(1000, 0, seen(true, false, true), |_| 1), Some(MAX_LOOKS));
        assert_eq!(check(1000, 16 * MS, seen(false, false, true), |_| 1), None);
        // Without that, an observation that is not counted still uses up the time.
        assert_eq!(check(1000, 16 * MS, seen(false, false, false), |_| 1), Some(MAX_LOOKS));
        assert_eq!(check(1000, 0, seen(false, true, false), |_| 1), Some(MAX_LOOKS));
    }

    /// A signal is heeded within a tenth of a second. The first observation counts nothing, because
    /// it only sees what the control side is doing. The rest of the time is for the processor and
    /// the stop actions.
    #[test]
    fn a_signal_is_heeded_in_time() {
        assert!(LOOK_MS * i64::from(LOOKS + 1) <= 80);
    }
}
