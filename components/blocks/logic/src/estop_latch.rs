//! `estop_latch`.
use hal_component::{Component, In, Out, Period, Update};

/// Latch of an emergency-stop chain.
///
/// The latch starts in the fault state. A rising edge of `reset` while `ok-in` is true and `fault-in` is false changes
/// it to OK. It returns to the fault state as soon as `ok-in` is false or `fault-in` is true, and stays there until the
/// next reset.
///
/// # Example
///
/// ```hal
/// loadrt estop_latch
/// loadrt threads name1=servo period1=1000000
/// addf estop-latch.0 servo
/// start
/// setp estop-latch.0.ok-in 1
/// run 1ms
/// getp estop-latch.0.ok-out # -> FALSE
/// setp estop-latch.0.reset 1
/// run 1ms
/// getp estop-latch.0.ok-out # -> TRUE
/// setp estop-latch.0.ok-in 0
/// run 1ms
/// getp estop-latch.0.ok-out # -> FALSE
/// getp estop-latch.0.fault-out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct EstopLatch {
    /// TRUE while the chain before this latch is closed.
    #[hal(default = true, safety)]
    ok_in: In<bool>,
    /// TRUE reports a fault.
    fault_in: In<bool>,
    /// Rising edge leaves the fault state, if there is no fault any more.
    reset: In<bool>,
    /// True in the OK state; for `ok-in` of the next latch.
    ok_out: Out<bool>,
    /// True in the fault state.
    #[hal(default = true)]
    fault_out: Out<bool>,
    /// Toggles in every cycle while OK; for an external charge pump.
    watchdog: Out<bool>,
    #[state]
    reset_was: bool,
}

impl Update for EstopLatch {
    fn update(&mut self, _: Period) {
        let reset = self.reset.get();
        let rising = reset && !self.reset_was;
        self.reset_was = reset;
        let good = self.ok_in.get() && !self.fault_in.get();
        let ok = good && (rising || self.ok_out.get());
        self.ok_out.set(ok);
        self.fault_out.set(!ok);
        if ok {
            self.watchdog.set(!self.watchdog.get());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::EstopLatch;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<EstopLatch>(include_str!("../traces/estop_latch.txt")), 82);
    }

    #[test]
    fn starts_in_fault() {
        let mut bench = Bench::new();
        bench.load::<EstopLatch>(&[]).unwrap();
        assert!(bench.get::<bool>("estop-latch.0.fault-out"));
        assert!(!bench.get::<bool>("estop-latch.0.ok-out"));
    }
}
