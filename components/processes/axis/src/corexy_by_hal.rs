//! `corexy_by_hal`.
use hal_component::{Component, In, Out, Period, Update};

/// Transform between joints 0 and 1 and the two motors of a `CoreXY` machine.
///
/// With `trivkins coordinates=xyz`, joint 0 is X and joint 1 is Y, and the axes home to switches along X and Y.
///
/// # Example
///
/// ```hal
/// loadrt corexy_by_hal
/// loadrt threads name1=servo period1=1000000
/// addf corexy-by-hal.0 servo
/// setp corexy-by-hal.0.j0-motor-pos-cmd 10
/// setp corexy-by-hal.0.j1-motor-pos-cmd 3
/// start
/// run 1ms
/// getp corexy-by-hal.0.alpha-cmd # -> 6.5
/// getp corexy-by-hal.0.beta-cmd # -> 3.5
/// ```
#[derive(Component)]
pub(crate) struct CorexyByHal {
    /// Position of the first motor, in units.
    alpha_fb: In<f64>,
    /// Position of the second motor, in units.
    beta_fb: In<f64>,
    /// Commanded X position, in units, from `joint.0.motor-pos-cmd`.
    j0_motor_pos_cmd: In<f64>,
    /// Commanded Y position, in units, from `joint.1.motor-pos-cmd`.
    j1_motor_pos_cmd: In<f64>,
    /// X position, in units: the sum of the motors, for `joint.0.motor-pos-fb`.
    j0_motor_pos_fb: Out<f64>,
    /// Y position, in units: the difference of the motors, for `joint.1.motor-pos-fb`.
    j1_motor_pos_fb: Out<f64>,
    /// Commanded position of the first motor, in units: half the sum of X and Y.
    alpha_cmd: Out<f64>,
    /// Commanded position of the second motor, in units: half the difference of X and Y.
    beta_cmd: Out<f64>,
}

impl Update for CorexyByHal {
    fn update(&mut self, _: Period) {
        let (x, y) = (self.j0_motor_pos_cmd.get(), self.j1_motor_pos_cmd.get());
        self.alpha_cmd.set(0.5 * (x + y));
        self.beta_cmd.set(0.5 * (x - y));
        let (alpha, beta) = (self.alpha_fb.get(), self.beta_fb.get());
        self.j0_motor_pos_fb.set(alpha + beta);
        self.j1_motor_pos_fb.set(alpha - beta);
    }
}

#[cfg(test)]
mod tests {
    use super::CorexyByHal;
    use hal_bench::trace::replay;

    #[test]
    fn there_and_back() {
        let rows = "load corexy_by_hal
            run corexy-by-hal.0
            in corexy-by-hal.0.j0-motor-pos-cmd corexy-by-hal.0.j1-motor-pos-cmd corexy-by-hal.0.alpha-fb corexy-by-hal.0.beta-fb
            out corexy-by-hal.0.alpha-cmd corexy-by-hal.0.beta-cmd corexy-by-hal.0.j0-motor-pos-fb corexy-by-hal.0.j1-motor-pos-fb
            10 3 6.5 3.5 | 6.5 3.5 10 3
            -4 2 -1 -3 | -1 -3 -4 2";
        assert_eq!(replay::<CorexyByHal>(rows), 2);
    }
}
