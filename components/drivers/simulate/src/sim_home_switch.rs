//! `sim_home_switch`.
use hal_component::{Component, In, Io, Out, Period, Update};

/// Home switch at a position, with hysteresis, and a simulated index pulse.
///
/// The switch is pressed beyond `home-pos`, on the side away from zero.
///
/// # Example
///
/// ```hal
/// loadrt sim_home_switch
/// loadrt threads name1=servo period1=1000000
/// addf sim-home-switch.0 servo
/// setp sim-home-switch.0.cur-pos 1.01
/// start
/// run 1ms
/// getp sim-home-switch.0.home-sw # -> TRUE
/// setp sim-home-switch.0.cur-pos 0.95
/// run 1ms
/// getp sim-home-switch.0.home-sw # -> TRUE
/// setp sim-home-switch.0.cur-pos 0.85
/// run 1ms
/// getp sim-home-switch.0.home-sw # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct SimHomeSwitch {
    /// Position of the joint, in units, such as `joint.0.motor-pos-fb`.
    cur_pos: In<f64>,
    /// Position of the switch, in units.
    #[hal(default = 1.0)]
    home_pos: In<f64>,
    /// Hysteresis: distance back from the switch at which it opens, in units.
    #[hal(default = 0.1)]
    hysteresis: In<f64>,
    /// True while the switch is pressed.
    home_sw: Out<bool>,
    /// Set true to wait for the index; becomes false after `index-delay-ms`.
    index_enable: Io<bool>,
    /// Time for which `index-enable` stays true, in milliseconds, read on its rising edge; 0 or less: it never becomes
    /// false.
    #[hal(default = 10.0)]
    index_delay_ms: In<f64>,
    #[state]
    was_index: bool,
    /// Remaining time for which `index-enable` stays true, in milliseconds.
    #[state]
    left_ms: f64,
}

impl Update for SimHomeSwitch {
    fn update(&mut self, period: Period) {
        let (at, home, back) = (self.cur_pos.get(), self.home_pos.get(), self.hysteresis.get());
        let (reached, left) = if home >= 0.0 {
            (at >= home, at <= home - back)
        } else {
            (at <= home, at >= home + back)
        };
        if reached || left {
            self.home_sw.set(reached);
        }
        let index = self.index_enable.get();
        if index && !self.was_index {
            self.left_ms = self.index_delay_ms.get();
        } else if self.left_ms > 0.0 {
            self.left_ms -= period.ns() as f64 * 1e-6;
            if self.left_ms <= 0.0 {
                self.index_enable.set(false);
            }
        }
        self.was_index = index;
    }
}

#[cfg(test)]
mod tests {
    use super::SimHomeSwitch;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert!(replay::<SimHomeSwitch>(include_str!("../traces/sim_home_switch.txt")) > 50);
    }
}
