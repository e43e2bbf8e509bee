//! `busy` and `stuck`: functions that take too long.
use hal_component::{Builder, Clock, Component, Error, In, Out, Period, Touch, Update};
use std::{thread::park_timeout, time::Duration};

/// Takes a requested time.
#[derive(Debug)]
pub(crate) struct Busy;

#[derive(Debug, Touch)]
struct Spin {
    ns: In<i64>,
    spun: Out<u32>,
    clock: Clock,
}

impl Component for Busy {
    const NAME: &'static str = "busy";
    const DOC: &'static str = "Takes as long as it is told to, on the real clock.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let spin = Spin {
            ns: b.item("ns", "How long each cycle takes, in nanoseconds.", 0)?,
            spun: b.item("spun", "How many cycles took that long.", 0)?,
            clock: b.clock(),
        };
        b.function("", "Takes its time.", spin)
    }
}

impl Update for Spin {
    fn update(&mut self, _: Period) {
        let ns = self.ns.get();
        if ns <= 0 || self.clock.is_virtual() {
            return;
        }
        let end = self.clock.now_ns().wrapping_add(ns);
        while self.clock.now_ns() < end {
            core::hint::spin_loop();
        }
        self.spun.set(self.spun.get().wrapping_add(1));
    }
}

/// Does not return while `hold` is true.
#[derive(Component)]
pub(crate) struct Stuck {
    /// While true, the function does not return.
    hold: In<bool>,
    /// True while the function runs.
    inside: Out<bool>,
    /// Number of completed cycles.
    cycles: Out<u32>,
    /// The system's number of the thread that runs the function.
    tid: Out<i32>,
}

impl Update for Stuck {
    fn update(&mut self, _: Period) {
        // SAFETY: returns a number.
        self.tid.set(unsafe { libc::gettid() });
        self.inside.set(true);
        while self.hold.get() {
            // As bad for the engine as spinning, but leaves the processor to others.
            park_timeout(Duration::from_millis(1));
        }
        self.inside.set(false);
        self.cycles.set(self.cycles.get().wrapping_add(1));
    }
}
