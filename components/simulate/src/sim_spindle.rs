//! `sim_spindle`.
use hal_component::{Component, In, Io, Out, ParamRw, Period, Update};

/// A spindle that follows its command at once, with an encoder.
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
    /// The speed that is wanted, in whatever unit `scale` makes turns per second of.
    velocity_cmd: In<f64>,
    /// Where the spindle is, in turns.
    position_fb: Out<f64>,
    /// Waits for the next whole turn while true; becomes false there, and the position counts from
    /// there on.
    index_enable: Io<bool>,
    /// What makes turns per second of `velocity-cmd`.
    #[hal(default = 1.0)]
    scale: ParamRw<f64>,
}

impl Update for SimSpindle {
    fn update(&mut self, period: Period) {
        let before = self.position_fb.get();
        let mut now = before + self.velocity_cmd.get() * period.secs() * self.scale.get();
        if self.index_enable.get() && libm::floor(before) != libm::floor(now) {
            self.index_enable.set(false);
            // Which way it turns is what the command says, whatever the sign of its scale.
            let forward = self.velocity_cmd.get() > 0.0;
            now -= if forward { libm::floor(now) } else { libm::ceil(now) };
        }
        self.position_fb.set(now);
    }
}

#[cfg(test)]
mod tests {
    use super::SimSpindle;
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert!(replay::<SimSpindle>(include_str!("../traces/sim_spindle.txt")) > 50);
    }
}
