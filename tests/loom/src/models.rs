//! Changes at a boundary, starting and stopping.

use crate::handover::{Boundary, Gate};
use loom::{cell::UnsafeCell, model::Builder, sync::Arc, thread};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Model of the arena and the lists: written by changes, read by cycles.
#[derive(Debug)]
struct World {
    boundary: Boundary<Change>,
    fastest: Gate,
    other: Gate,
    value: UnsafeCell<u32>,
}

// SAFETY: the checker reports every access to `value` that is not ordered.
unsafe impl Sync for World {}
// SAFETY: as for `Sync`.
unsafe impl Send for World {}

/// A change: the value to be stored, itself written before it is offered and freed afterwards.
#[derive(Debug)]
struct Change(UnsafeCell<u32>);

// SAFETY: as for `World`.
unsafe impl Sync for Change {}
// SAFETY: as for `World`.
unsafe impl Send for Change {}

impl World {
    fn new() -> Arc<Self> {
        Arc::new(Self {
            boundary: Boundary::new(),
            fastest: Gate::new(),
            other: Gate::new(),
            value: UnsafeCell::new(0),
        })
    }

    fn read(&self) -> u32 {
        // SAFETY: checked.
        self.value.with(|v| unsafe { *v })
    }

    fn write(&self, value: u32) {
        // SAFETY: checked.
        self.value.with_mut(|v| unsafe { *v = value });
    }

    /// Runs a cycle of the thread behind a gate. Returns the value read, if the cycle ran. It reads
    /// twice: nothing may change in between.
    fn cycle(&self, gate: &Gate) -> Option<u32> {
        self.boundary.enter(gate).then(|| {
            let value = self.read();
            assert_eq!(value, self.read());
            gate.leave();
            value
        })
    }

    /// Does the work of the fastest thread before its cycle.
    fn take(&self) -> bool {
        self.boundary.take(|| self.other.is_inside(), |change| self.apply(change))
    }

    fn apply(&self, change: &Change) {
        // SAFETY: checked.
        self.write(change.0.with(|v| unsafe { *v }));
    }
}

impl Change {
    fn new(value: u32) -> Self {
        let change = Self(UnsafeCell::new(0));
        // Written late, so that a thread that does not synchronise would see the zero.
        // SAFETY: checked.
        change.0.with_mut(|v| unsafe { *v = value });
        change
    }

    /// Models the freeing of its memory.
    fn free(self) {
        // SAFETY: checked.
        self.0.with_mut(|v| unsafe { *v = u32::MAX });
    }
}

/// Runs a model: every interleaving with at most `switches` involuntary switches of thread.
///
/// Models never wait (a checker would try every length of the wait): where the engine waits for a
/// condition, a model checks once and continues if the condition holds.
fn check(switches: usize, model: impl Fn() + Sync + Send + 'static) {
    let mut builder = Builder::new();
    builder.preemption_bound = Some(switches);
    builder.check(model);
}

/// Number of interleavings in which something occurred. A model that never gets there proves
/// nothing.
struct Seen(AtomicUsize);

impl Seen {
    const fn new() -> Self {
        Self(AtomicUsize::new(0))
    }

    fn note(&self, is_so: bool) {
        self.0.fetch_add(usize::from(is_so), Ordering::Relaxed);
    }

    fn ever(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }
}

#[test]
fn a_change_is_carried_out_once_while_no_other_thread_is_inside() {
    static EARLY: Seen = Seen::new();
    static LATE: Seen = Seen::new();
    check(3, || {
        let w = World::new();
        w.boundary.start();
        let fast = w.clone();
        let fastest = thread::spawn(move || {
            let first = fast.take();
            fast.cycle(&fast.fastest);
            usize::from(first) + usize::from(fast.take())
        });
        let slow = w.clone();
        let other = thread::spawn(move || {
            let first = slow.cycle(&slow.other).unwrap();
            let second = slow.cycle(&slow.other).unwrap();
            assert!(first <= second, "a change is not undone");
            EARLY.note(first == 7);
            LATE.note(second == 0);
        });
        let change = Change::new(7);
        w.boundary.offer(&change);
        let times = if w.boundary.is_taken() {
            // From here on, the change belongs to the control side again.
            change.free();
            fastest.join().unwrap()
        } else {
            let times = fastest.join().unwrap();
            assert_eq!(times == 1, w.boundary.is_taken());
            times
        };
        assert!(times <= 1);
        other.join().unwrap();
        assert_eq!(w.read(), if times == 1 { 7 } else { 0 });
    });
    assert!(EARLY.ever() && LATE.ever(), "the model is too small");
}

#[test]
fn two_changes_one_after_the_other() {
    static BOTH: Seen = Seen::new();
    check(4, || {
        let w = World::new();
        w.boundary.start();
        let fast = w.clone();
        let fastest = thread::spawn(move || usize::from(fast.take()) + usize::from(fast.take()));
        let first = Change::new(1);
        w.boundary.offer(&first);
        if !w.boundary.is_taken() {
            fastest.join().unwrap();
            return;
        }
        first.free();
        let second = Change::new(2);
        w.boundary.offer(&second);
        if w.boundary.is_taken() {
            second.free();
            assert_eq!(fastest.join().unwrap(), 2);
        } else {
            let times = fastest.join().unwrap();
            assert_eq!(times == 2, w.boundary.is_taken(), "the first says nothing of the second");
        }
        BOTH.note(w.read() == 2);
    });
    assert!(BOTH.ever(), "the model is too small");
}

#[test]
fn a_change_is_taken_or_withdrawn_and_never_both() {
    static TAKEN: Seen = Seen::new();
    static WITHDRAWN: Seen = Seen::new();
    check(4, || {
        let w = World::new();
        w.boundary.start();
        let fast = w.clone();
        let fastest = thread::spawn(move || {
            let taken = fast.take();
            fast.cycle(&fast.fastest);
            taken
        });
        let change = Change::new(7);
        w.boundary.offer(&change);
        let withdrawn = w.boundary.withdraw();
        let taken = if withdrawn || w.boundary.is_taken() {
            // No thread reads the change any more, whichever won.
            change.free();
            fastest.join().unwrap()
        } else {
            fastest.join().unwrap()
        };
        assert_ne!(taken, withdrawn);
        assert_eq!(taken, w.boundary.is_taken());
        assert_eq!(w.read(), if taken { 7 } else { 0 });
        TAKEN.note(taken);
        WITHDRAWN.note(withdrawn);
    });
    assert!(TAKEN.ever() && WITHDRAWN.ever(), "the model is too small");
}

#[test]
fn after_a_stop_no_cycle_runs_until_the_next_start() {
    static CALM: Seen = Seen::new();
    static RESUMED: Seen = Seen::new();
    check(4, || {
        let w = World::new();
        w.write(1);
        w.boundary.start();
        let slow = w.clone();
        let other = thread::spawn(move || {
            let first = slow.cycle(&slow.other);
            let second = slow.cycle(&slow.other);
            let in_order = first.is_none_or(|f| second.is_none_or(|s| f <= s));
            assert!(in_order, "{first:?} {second:?}");
            RESUMED.note(second == Some(2));
        });
        w.boundary.stop();
        assert!(!w.boundary.is_running());
        if !w.other.is_inside() {
            // Written directly, as the engine does while threads are stopped.
            w.write(2);
            w.boundary.start();
            CALM.note(true);
        }
        other.join().unwrap();
    });
    assert!(CALM.ever() && RESUMED.ever(), "the model is too small");
}

#[test]
fn a_thread_that_is_added_is_not_overlooked() {
    // The fastest thread may have read the list of threads before the other was added. The list at
    // the time when it asks which threads are inside counts.
    static ALONE: Seen = Seen::new();
    static KEPT_OUT: Seen = Seen::new();
    check(4, || {
        let w = World::new();
        w.boundary.start();
        let added = Arc::new(loom::sync::atomic::AtomicBool::new(false));
        let (fast, list) = (w.clone(), added.clone());
        let fastest = thread::spawn(move || {
            let known = || list.load(Ordering::Acquire);
            let taken = fast
                .boundary
                .take(|| known() && fast.other.is_inside(), |change| fast.apply(change));
            ALONE.note(taken && !known());
            taken
        });
        let change = Change::new(7);
        w.boundary.offer(&change);
        added.store(true, Ordering::Release);
        let value = w.cycle(&w.other).unwrap();
        let taken = fastest.join().unwrap();
        assert_eq!(w.boundary.is_taken(), taken);
        assert!(taken || value == 0);
        KEPT_OUT.note(!taken);
    });
    assert!(ALONE.ever() && KEPT_OUT.ever(), "the model is too small");
}
