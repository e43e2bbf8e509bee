//! The worker of an inverter and a stop from another thread.

#[path = "../../../components/modbus/modbus/src/hy/flags.rs"]
mod real;

use loom::{sync::Arc, thread};
use real::RunFlags;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A command to run that leaves is seen by a stop that comes at the same time, or does not leave.
#[test]
fn a_command_to_run_and_a_stop_never_miss_each_other() {
    static LEFT: AtomicUsize = AtomicUsize::new(0);
    static HELD: AtomicUsize = AtomicUsize::new(0);
    loom::model(|| {
        let flags = Arc::new(RunFlags::new());
        let stop = {
            let flags = Arc::clone(&flags);
            thread::spawn(move || flags.begin())
        };
        let leaves = flags.may_send(true);
        let is_seen = stop.join().unwrap();
        assert!(!leaves || is_seen, "the inverter turns, and nobody has stopped it");
        // The worker notices the stop in its next step.
        assert!(flags.notice() && !flags.notice() && flags.may_run());
        let seen = if leaves { &LEFT } else { &HELD };
        seen.fetch_add(1, Ordering::Relaxed);
    });
    let seen = (LEFT.load(Ordering::Relaxed), HELD.load(Ordering::Relaxed));
    assert!(seen.0 > 0 && seen.1 > 0, "the model is too small: {seen:?}");
}
