//! The guard: an ordinary thread that looks after recordings while the control side is busy, keeps
//! what was seen when the process crashes, and ends the process when a signal asks for that and
//! the control side does not come back.

use super::{
    GUARD, Instance, WAKE,
    crash::{self, Cause},
    instances, is_asked, known, signals, sys,
    text::Text,
    who::{self, Doing, Place},
};
use crate::{
    os::progress::{self, processor_time},
    sync::{Arc, Ordering},
};
use std::sync::{Mutex, MutexGuard, TryLockError};

/// How often it looks after recordings, in milliseconds.
const ROUND_MS: i32 = 500;
/// How often it looks at the control side that is to come back, in milliseconds.
const LOOK_MS: i64 = 16;
/// After how many looks that have seen the control side busy with the same, or waiting, it does not
/// come back. Looks at which it had no turn on a processor do not count.
const LOOKS: u32 = 4;
/// After how many looks in all, if none of these counts.
const MOST_LOOKS: u32 = 125;
/// What the control side must have used of a processor between two looks, in nanoseconds.
const TURN_NS: i64 = 5_000_000;
/// How many looks a stop action may take.
const STOP_LOOKS: u32 = 32;
/// How long it waits for threads to come out of their cycles, and for what another thread uses, in
/// milliseconds.
const WAIT_MS: u32 = 100;

/// How much stack it has, in bytes: all memory may be locked.
const STACK: usize = 512 << 10;

/// Why the process crashes, for those who keep it.
static WHY: Mutex<Option<Text>> = Mutex::new(None);

/// Keeps why the process crashes.
pub(super) fn keep(text: &Text) {
    // Nobody else is there yet.
    if let Ok(mut why) = WHY.try_lock() {
        *why = Some(*text);
    }
}

/// Why the process crashes.
pub(super) fn why() -> Text {
    // Its owner may be the thread that has crashed.
    WHY.try_lock().ok().and_then(|why| *why).unwrap_or_else(Text::new)
}

/// Begins to look; nothing, where the system has no thread for it.
pub(super) fn begin() {
    let named = std::thread::Builder::new().name("hal-guard".into()).stack_size(STACK);
    drop(named.spawn(run));
}

fn run() {
    signals::leave_to_others();
    let _stack = sys::Stack::new();
    GUARD.store(sys::thread(), Ordering::Relaxed);
    let waker = WAKE.load(Ordering::Relaxed);
    while !crash::is_claimed() && !is_asked() {
        known().iter().for_each(|instance| instance.look_after_tape());
        sys::wait(waker, ROUND_MS);
    }
    let mut look = Look::default();
    while !crash::is_claimed() {
        sys::nap(LOOK_MS);
        if let Some(text) = look.take() {
            // In a thread of its own: a stop action may not return either.
            let named = std::thread::Builder::new().name("hal-end".into()).stack_size(STACK);
            if named.spawn(move || end(&text)).is_err() {
                end(&text);
            }
            while !crash::is_claimed() {
                sys::nap(1);
            }
        }
    }
    attend()
}

/// Ends the process, because the control side does not come back.
fn end(doing: &Text) -> ! {
    let signal = signals::asked().map_or(libc::SIGTERM, |a| a.0);
    let place = Place { code: 0, stack: sys::stack() };
    crash::crash(&Cause::Asked { signal, doing }, place)
}

/// What was seen of the control side at the last look.
#[derive(Debug, Default)]
struct Look {
    beats: u64,
    used_ns: i64,
    /// Looks that count, and looks in all.
    counted: u32,
    all: u32,
}

impl Look {
    /// Looks at the control side; what it does, once it does not come back from that.
    fn take(&mut self) -> Option<Text> {
        let Some(instance) = known().into_iter().next() else {
            // None is left, or none is there yet: there is no output to be safe.
            *self = Self::default();
            return None;
        };
        let control = &instance.control;
        let thread = instance.thread.load(Ordering::Relaxed);
        let (beats, used_ns) = (control.beats(), processor_time(thread).unwrap_or(0));
        if beats != self.beats {
            *self = Self { beats, used_ns, ..Self::default() };
            return None;
        }
        let doing = control.doing();
        let inside = instance.cycle_of_control().is_some();
        let waits = progress::doing(thread) != progress::Doing::Runs;
        let foreign = doing.is_some() || inside;
        let counts = if foreign {
            waits || used_ns - self.used_ns >= TURN_NS
        } else {
            waits && !control.is_patient()
        };
        if counts {
            self.used_ns = used_ns;
            self.counted += 1;
        }
        self.all += 1;
        (self.counted >= LOOKS || self.all >= MOST_LOOKS)
            .then(|| instance.describe_control(doing.as_deref()))
    }
}

/// A crash is under way in another thread: keeps what was seen. Should the other thread not come
/// through with stop actions, this one goes on with them.
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
    crash::park()
}

/// Keeps what was seen, of every instance.
pub(super) fn save() {
    let why = why();
    for instance in instances() {
        instance.save(why.as_str());
    }
}

/// Takes a lock if that can be had in time: its owner may be the thread that has crashed.
fn soon<T>(lock: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    for _ in 0..WAIT_MS {
        match lock.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(poisoned)) => return Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => sys::nap(1),
        }
    }
    None
}

impl Instance {
    /// The control side may be busy for long: recordings reach their files all the same.
    fn look_after_tape(&self) {
        let tape = self.saved().tape.clone();
        if let Some(tape) = tape
            && let Ok(mut tape) = tape.try_lock()
        {
            tape.drain(false, self.shared.now());
        }
    }

    /// The thread in whose cycle the control side is: on the virtual clock it runs them.
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

    /// Whether no cycle is under way but that which has crashed, or soon.
    fn is_still(&self) -> bool {
        let threads = self.shared.threads.load_full();
        (0..WAIT_MS).any(|_| {
            let still = threads.iter().all(|t| !t.gate.is_inside() || crash::has_crashed(t));
            if !still {
                sys::nap(1);
            }
            still
        })
    }

    fn save(&self, why: &str) {
        crash::come_on();
        let still = self.is_still();
        self.say_rest();
        let Some(saved) = soon(&self.saved) else { return };
        saved.programs.iter().for_each(|pid| crate::os::end_process(*pid, false));
        let (tape, flight) = (saved.tape.clone(), saved.flight.clone());
        drop(saved);
        crash::come_on();
        if let Some(mut tape) = tape.as_deref().and_then(soon) {
            tape.salvage(still, self.shared.now());
            if let Some(stopped) = tape.stopped() {
                sys::complain(&format!("{stopped}\n"));
            }
        }
        crash::come_on();
        if let Some(mut flight) = flight.as_deref().and_then(soon) {
            let said = flight.salvage(still, self.shared.now(), why);
            said.iter().for_each(|text| sys::complain(&format!("{text}\n")));
        }
        crash::come_on();
    }

    /// Says what components have said and the control side has not heard.
    fn say_rest(&self) {
        let name_of = |id: u32| {
            let names = self.remains().map_or(&[][..], |r| &r.names);
            names.iter().find(|n| n.0 == id).map_or("?", |n| n.1.as_str())
        };
        while let Some(message) = self.shared.mailbox.message() {
            let text = crate::messages::worded(&message, name_of(message.component));
            sys::complain(&(text + "\n"));
        }
        while let Some(message) = self.shared.mailbox.text() {
            let text = crate::messages::spoken(&message, name_of(message.component));
            sys::complain(&(text + "\n"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LOOK_MS, LOOKS};

    /// Within a tenth of a second. The first look counts nothing: it sees where the control side
    /// is. The rest of the time is for the processor and the stop actions.
    #[test]
    fn a_signal_is_heeded_in_time() {
        assert!(LOOK_MS * i64::from(LOOKS + 1) <= 80);
    }
}
