//! `sim_spindle`.
use hal_component::{Component, In, Io, Out, ParamRw, Period, Update};

/// Spindle that follows its command at once, with an encoder.
///
/// # Example
///
/// 600 turns per minute for 50 milliseconds are half a turn.
///
/// ```hal
/// loadrt sim_spindle
/// loadrt threads name1=servo period1=1000000
/// addf sim-spindle.0 servo
/// setp sim-spindle.0.scale 0.0166666666666667
/// setp sim-spindle.0.velocity-cmd 600
/// start
/// run 50ms
/// getp sim-spindle.0.position-fb # -> 0.5
/// ```
#[derive(Component)]
pub(crate) struct SimSpindle {
    /// Commanded speed; multiplied by `scale`, it is in turns per second.
    velocity_cmd: In<f64>,
    /// Position of the spindle, in turns.
    position_fb: Out<f64>,
    /// While true, waits for the next full turn; there it becomes false, and the position counts from there.
    index_enable: Io<bool>,
    /// Turns per second per unit of `velocity-cmd`.
    #[hal(default = 1.0)]
    scale: ParamRw<f64>,
}

impl Update for SimSpindle {
    fn update(&mut self, period: Period) {
        let before = self.position_fb.get();
        let mut now = before + self.velocity_cmd.get() * period.secs() * self.scale.get();
        if self.index_enable.get() && libm::floor(before) != libm::floor(now) {
            self.index_enable.set(false);
            // The sign of the command gives the direction, whatever the sign of its scale.
            let forward = self.velocity_cmd.get() > 0.0;
            now -= if forward { libm::floor(now) } else { libm::ceil(now) };
        }
        self.position_fb.set(now);
    }
}

#[cfg(test)]
mod tests {
    use super::SimSpindle;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert!(replay::<SimSpindle>(include_str!("../traces/sim_spindle.txt")) > 50);
    }
}
