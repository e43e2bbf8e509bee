//! `edge`.
use hal_component::{Component, In, Out, ParamRo, ParamRw, Period, Update};

/// Detector of edges, which outputs a pulse for each edge.
///
/// The first cycle only reads the input. An edge during a pulse restarts the pulse.
///
/// # Example
///
/// ```hal
/// loadrt edge
/// loadrt threads name1=servo period1=1000000
/// addf edge.0 servo
/// start
/// setp edge.0.in-edge 0
/// setp edge.0.out-width-ns 3000000
/// run 1ms
/// setp edge.0.in 1
/// run 1ms
/// getp edge.0.out # -> TRUE
/// run 2ms
/// getp edge.0.out # -> TRUE
/// run 1ms
/// getp edge.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Edge {
    /// Input.
    in_: In<bool>,
    /// True at the edge and for `out-width-ns` after it, at least for one cycle.
    out: Out<bool>,
    /// The opposite of `out`.
    out_invert: Out<bool>,
    /// Edge to detect: TRUE the falling one, FALSE the rising one.
    #[hal(default = true)]
    in_edge: ParamRw<bool>,
    /// TRUE detects both edges, whatever `in-edge` is.
    both: ParamRw<bool>,
    /// Length of a pulse, in nanoseconds, rounded up to whole periods; 0 or less: one cycle.
    out_width_ns: ParamRw<i32>,
    /// Remaining time of the pulse, in nanoseconds.
    time_left_ns: ParamRo<i32>,
    /// Input in the last cycle.
    last_in: ParamRo<bool>,
    #[state]
    has_looked: bool,
}

impl Update for Edge {
    fn update(&mut self, period: Period) {
        let now = self.in_.get();
        let was = if self.has_looked { self.last_in.get() } else { now };
        self.has_looked = true;
        self.last_in.set(now);
        let wanted = now != was && (self.both.get() || was == self.in_edge.get());
        let out = if wanted {
            self.time_left_ns.set(self.out_width_ns.get());
            true
        } else {
            let left = i64::from(self.time_left_ns.get()).saturating_sub(period.ns());
            self.time_left_ns.set(i32::try_from(left.max(0)).unwrap_or(i32::MAX));
            left > 0
        };
        self.out.set(out);
        self.out_invert.set(!out);
    }
}

#[cfg(test)]
mod tests {
    use super::Edge;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Edge>(include_str!("../traces/edge.txt")), 619);
    }
}
