//! Timers of IEC 61131-3: `ton`, `tof` and `tp`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

fn not_below_zero(time: &ParamRw<f64>) {
    if time.get() < 0.0 {
        time.set(0.0);
    }
}

/// Timer that delays a rising edge (on-delay).
///
/// # Example
///
/// ```hal
/// loadrt ton
/// loadrt threads name1=servo period1=1000000
/// addf ton.0 servo
/// start
/// setp ton.0.pt 0.01
/// setp ton.0.in 1
/// run 5ms
/// getp ton.0.q # -> FALSE
/// run 10ms
/// getp ton.0.q # -> TRUE
/// setp ton.0.in 0
/// run 1ms
/// getp ton.0.q # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Ton {
    /// Input.
    in_: In<bool>,
    /// True once the input has been true for `pt`, until it falls.
    q: Out<bool>,
    /// Time for which the input has been true, in seconds; it stops at `pt`.
    et: Out<f64>,
    /// Delay of a rising edge, in seconds; a value below 0 is set to 0.
    pt: ParamRw<f64>,
}

impl Update for Ton {
    fn update(&mut self, period: Period) {
        not_below_zero(&self.pt);
        if !self.in_.get() {
            self.et.set(0.0);
            self.q.set(false);
        } else if self.et.get() >= self.pt.get() {
            self.q.set(true);
        } else {
            self.et.set(self.et.get() + period.secs());
        }
    }
}

/// Timer that delays a falling edge (off-delay).
///
/// # Example
///
/// ```hal
/// # A fan runs on for a while.
/// loadrt tof
/// loadrt threads name1=servo period1=1000000
/// addf tof.0 servo
/// start
/// setp tof.0.pt 0.01
/// setp tof.0.in 1
/// run 1ms
/// setp tof.0.in 0
/// run 5ms
/// getp tof.0.q # -> TRUE
/// run 10ms
/// getp tof.0.q # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Tof {
    /// Input.
    in_: In<bool>,
    /// True while the input is true, and for `pt` after it fell.
    q: Out<bool>,
    /// Time for which the input has been false, in seconds; it stops at `pt`.
    et: Out<f64>,
    /// Delay of a falling edge, in seconds; a value below 0 is set to 0.
    pt: ParamRw<f64>,
}

impl Update for Tof {
    fn update(&mut self, period: Period) {
        not_below_zero(&self.pt);
        if self.in_.get() {
            self.et.set(0.0);
            self.q.set(true);
        } else if self.et.get() >= self.pt.get() {
            self.q.set(false);
        } else {
            self.et.set(self.et.get() + period.secs());
        }
    }
}

/// Timer that outputs a pulse of a given length at a rising edge.
///
/// An edge during the pulse has no effect.
///
/// # Example
///
/// ```hal
/// loadrt tp
/// loadrt threads name1=servo period1=1000000
/// addf tp.0 servo
/// start
/// setp tp.0.pt 0.01
/// setp tp.0.in 1
/// run 5ms
/// getp tp.0.q # -> TRUE
/// run 10ms
/// getp tp.0.q # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Tp {
    /// Input.
    in_: In<bool>,
    /// Pulse output.
    q: Out<bool>,
    /// Elapsed time of the pulse, in seconds; 0 without a pulse. For an edge in the cycle after a pulse, it continues
    /// from the end of that pulse.
    et: Out<f64>,
    /// Length of the pulse, in seconds; a value below 0 is set to 0: no pulse.
    pt: ParamRw<f64>,
    #[state]
    was: bool,
    #[state]
    active: bool,
}

impl Update for Tp {
    fn update(&mut self, period: Period) {
        not_below_zero(&self.pt);
        let now = self.in_.get();
        let rises = now && !self.was;
        self.was = now;
        self.active |= rises;
        if !self.active {
            self.et.set(0.0);
            self.q.set(false);
        } else if self.et.get() < self.pt.get() {
            self.q.set(true);
            self.et.set(self.et.get() + period.secs());
        } else {
            self.q.set(false);
            self.active = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Tof, Ton, Tp};
    use hal_bench::trace::replay;

    const MS: &str = "period 250000000\nset $.0.pt 0.75\nrun $.0\nin $.0.in\nout $.0.q $.0.et\n";

    fn table(name: &str, rows: &str) -> String {
        format!("load $\n{MS}{rows}").replace('$', name)
    }

    #[test]
    fn a_rising_edge_comes_later() {
        let rows = "1 | 0 0.25\n1 | 0 0.5\n1 | 0 0.75\n1 | 1 0.75\n1 | 1 0.75\n0 | 0 0\n\
            1 | 0 0.25\n0 | 0 0\nset $.0.pt 0\n1 | 1 0\nset $.0.pt nan\n1 | 1 0.25";
        assert_eq!(replay::<Ton>(&table("ton", rows)), 10);
    }

    #[test]
    fn a_falling_edge_comes_later() {
        let rows = "1 | 1 0\n1 | 1 0\n0 | 1 0.25\n0 | 1 0.5\n0 | 1 0.75\n0 | 0 0.75\n0 | 0 0.75\n\
            1 | 1 0\n0 | 1 0.25\n1 | 1 0\nset $.0.pt 0\n0 | 0 0";
        assert_eq!(replay::<Tof>(&table("tof", rows)), 11);
    }

    #[test]
    fn a_pulse_has_its_length() {
        let rows = "1 | 1 0.25\n0 | 1 0.5\n1 | 1 0.75\n1 | 0 0.75\n1 | 0 0\n0 | 0 0\n1 | 1 0.25\n\
            set $.0.pt 0.1\n1 | 0 0.25\n0 | 0 0\nset $.0.pt -1\n1 | 0 0";
        assert_eq!(replay::<Tp>(&table("tp", rows)), 10);
    }
}
