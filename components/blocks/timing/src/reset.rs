//! `reset`.
use hal_component::{Component, In, Io, Period, Update};

/// Sets signals of several types to given values at an edge of the trigger.
///
/// # Example
///
/// ```hal
/// loadrt reset
/// loadrt threads name1=servo period1=1000000
/// addf reset.0 servo
/// net speed reset.0.out-float
/// sets speed 120
/// start
/// setp reset.0.reset-float 5
/// run 1ms
/// gets speed # -> 120
/// setp reset.0.trigger 1
/// run 1ms
/// gets speed # -> 5
/// sets speed 30
/// run 1ms
/// gets speed # -> 30
/// ```
#[derive(Component)]
pub(crate) struct Reset {
    /// Trigger input.
    trigger: In<bool>,
    /// TRUE: the rising edge of `trigger` sets the outputs.
    #[hal(default = true)]
    rising: In<bool>,
    /// TRUE: the falling edge of `trigger` sets the outputs.
    falling: In<bool>,
    /// TRUE: every edge sets the outputs; FALSE: only the first one does.
    #[hal(default = true)]
    retriggerable: In<bool>,
    /// Value for `out-bit`.
    reset_bit: In<bool>,
    /// Value for `out-float`, in any unit.
    reset_float: In<f64>,
    /// Value for `out-s32`.
    reset_s32: In<i32>,
    /// Value for `out-u32`.
    reset_u32: In<u32>,
    /// Bit that is set at an edge; between edges others may write it.
    out_bit: Io<bool>,
    /// Number that is set at an edge, in any unit; between edges others may write it.
    out_float: Io<f64>,
    /// Signed 32-bit number that is set at an edge; between edges others may write it.
    out_s32: Io<i32>,
    /// Unsigned 32-bit number that is set at an edge; between edges others may write it.
    out_u32: Io<u32>,
    #[state]
    was: bool,
    #[state]
    done: bool,
}

impl Update for Reset {
    fn update(&mut self, _: Period) {
        let now = self.trigger.get();
        let rises = now && !self.was && self.rising.get();
        let falls = !now && self.was && self.falling.get();
        self.was = now;
        self.done &= !self.retriggerable.get();
        if (rises || falls) && !self.done {
            self.done = true;
            self.out_bit.set(self.reset_bit.get());
            self.out_float.set(self.reset_float.get());
            self.out_s32.set(self.reset_s32.get());
            self.out_u32.set(self.reset_u32.get());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Reset;
    use hal_bench::trace::replay;

    #[test]
    fn at_edges_alone() {
        let rows = replay::<Reset>(
            "load reset
             set reset.0.reset-bit 1
             set reset.0.reset-s32 -7
             set reset.0.reset-u32 7
             set reset.0.reset-float 0.5
             run reset.0
             in reset.0.trigger reset.0.rising reset.0.falling
             out reset.0.out-s32 reset.0.out-u32 reset.0.out-float reset.0.out-bit
             0 1 0 | 0 0 0 0
             1 1 0 | -7 7 0.5 1
             set reset.0.out-s32 3
             1 1 0 | 3 7 0.5 1
             0 1 0 | 3 7 0.5 1
             1 1 0 | -7 7 0.5 1
             set reset.0.out-s32 3
             0 0 1 | -7 7 0.5 1
             set reset.0.retriggerable 0
             set reset.0.out-s32 3
             1 1 1 | 3 7 0.5 1
             set reset.0.retriggerable 1
             0 1 1 | -7 7 0.5 1",
        );
        assert_eq!(rows, 8);
    }
}
