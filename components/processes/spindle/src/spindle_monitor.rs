//! `spindle_monitor`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Monitor that reports whether a spindle has reached its speed, and whether the speed has dropped since.
///
/// # Example
///
/// ```hal
/// loadrt spindle_monitor
/// loadrt threads name1=servo period1=1000000
/// addf spindle-monitor.0 servo
/// setp spindle-monitor.0.threshold 10
/// setp spindle-monitor.0.spindle-command 100
/// setp spindle-monitor.0.spindle-is-on 1
/// start
/// run 2ms
/// getp spindle-monitor.0.spindle-at-speed # -> FALSE
/// setp spindle-monitor.0.spindle-feedback 95
/// run 1ms
/// getp spindle-monitor.0.spindle-at-speed # -> TRUE
/// setp spindle-monitor.0.spindle-feedback 85
/// run 1ms
/// getp spindle-monitor.0.spindle-underspeed # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct SpindleMonitor {
    /// TRUE while the spindle is switched on.
    spindle_is_on: In<bool>,
    /// Commanded speed, in any unit, such as turns per minute.
    spindle_command: In<f64>,
    /// Measured speed, in the same unit.
    spindle_feedback: In<f64>,
    /// True from reaching the speed until the spindle is switched on again.
    spindle_at_speed: Out<bool>,
    /// True from a drop below the speed until the spindle is switched on again.
    spindle_underspeed: Out<bool>,
    /// State: 0 off, 1 the spindle starts, 2 it has reached its speed; other values become 0.
    level: ParamRw<u32>,
    /// Largest deviation from `spindle-command` that counts as reached, and largest shortfall afterwards, in the same
    /// unit; with 0 the speed is never reached.
    threshold: ParamRw<f64>,
}

impl Update for SpindleMonitor {
    fn update(&mut self, _: Period) {
        let behind = self.spindle_command.get() - self.spindle_feedback.get();
        let threshold = self.threshold.get();
        let on = self.spindle_is_on.get();
        let next = match self.level.get() {
            0 => {
                self.spindle_at_speed.set(false);
                self.spindle_underspeed.set(false);
                u32::from(on)
            }
            1 | 2 if !on => 0,
            1 if libm::fabs(behind) < threshold => {
                self.spindle_at_speed.set(true);
                2
            }
            2 if behind > threshold => {
                self.spindle_underspeed.set(true);
                2
            }
            level @ 1..=2 => level,
            _ => 0,
        };
        self.level.set(next);
    }
}

#[cfg(test)]
mod tests {
    use super::SpindleMonitor;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert!(replay::<SpindleMonitor>(include_str!("../traces/spindle_monitor.txt")) > 20);
    }
}
