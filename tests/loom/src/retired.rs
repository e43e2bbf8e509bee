//! Freeing of lists that threads may still use.
//!
//! The engine keeps a replaced list until its strong count is one (`runtime/threads.rs`). `arc-swap` does the
//! replacement and guarantees that a thread that loaded the old list before the swap holds a
//! reference after it; here a lock models that guarantee. This checks the engine's own rule: the
//! last reference is the control side's, and freeing happens after every use.

use loom::{
    cell::UnsafeCell,
    sync::{Arc, Mutex},
    thread,
};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A list of functions: used by a thread, freed with its last reference.
struct List {
    entries: UnsafeCell<u32>,
    control: thread::ThreadId,
}

// SAFETY: the checker reports every access that is not ordered.
unsafe impl Sync for List {}
// SAFETY: as for `Sync`.
unsafe impl Send for List {}

impl Drop for List {
    fn drop(&mut self) {
        // SAFETY: checked.
        self.entries.with_mut(|e| unsafe { *e = u32::MAX });
        assert_eq!(thread::current().id(), self.control, "freed in a realtime thread");
    }
}

#[test]
fn a_list_is_freed_by_the_control_side_after_its_last_use() {
    static AT_ONCE: AtomicUsize = AtomicUsize::new(0);
    loom::model(|| {
        let control = thread::current().id();
        let list = |n| Arc::new(List { entries: UnsafeCell::new(n), control });
        let current = Arc::new(Mutex::new(list(1)));
        let (shown, mut threads) = (current.clone(), Vec::new());
        for _ in 0..2 {
            let current = shown.clone();
            threads.push(thread::spawn(move || {
                for _ in 0..2 {
                    let list = current.lock().unwrap().clone();
                    // SAFETY: checked.
                    let n = list.entries.with(|e| unsafe { *e });
                    assert!(n == 1 || n == 2);
                }
            }));
        }
        let old = std::mem::replace(&mut *current.lock().unwrap(), list(2));
        let free = Arc::strong_count(&old) == 1;
        AT_ONCE.fetch_add(usize::from(free), Ordering::Relaxed);
        // Like the engine, check again later.
        let kept = if free { None } else { Some(old) };
        for t in threads {
            t.join().unwrap();
        }
        assert!(kept.is_none_or(|k| Arc::strong_count(&k) == 1));
    });
    assert!(AT_ONCE.load(Ordering::Relaxed) > 0, "the model is too small");
}
