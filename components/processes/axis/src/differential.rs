//! `differential`.
use hal_component::{Component, In, Out, Period, Update};

/// Two motors that roll and pitch together, as in a differential.
///
/// One motor is commanded to the sum of roll and pitch, the other to the difference; the feedback is converted back.
///
/// # Example
///
/// ```hal
/// loadrt differential
/// loadrt threads name1=servo period1=1000000
/// addf differential.0 servo
/// setp differential.0.roll-cmd 10
/// setp differential.0.pitch-cmd 3
/// start
/// run 1ms
/// getp differential.0.motor0-cmd # -> 13
/// getp differential.0.motor1-cmd # -> 7
/// ```
#[derive(Component)]
pub(crate) struct Differential {
    /// Commanded roll, in degrees.
    roll_cmd: In<f64>,
    /// Commanded pitch, in degrees.
    pitch_cmd: In<f64>,
    /// Roll, in degrees: half the sum of the motors.
    roll_fb: Out<f64>,
    /// Pitch, in degrees: half the difference of the motors.
    pitch_fb: Out<f64>,
    /// Commanded position of the first motor, in degrees: `roll-cmd` + `pitch-cmd`.
    motor0_cmd: Out<f64>,
    /// Commanded position of the second motor, in degrees: `roll-cmd` - `pitch-cmd`.
    motor1_cmd: Out<f64>,
    /// Position of the first motor, in degrees.
    motor0_fb: In<f64>,
    /// Position of the second motor, in degrees.
    motor1_fb: In<f64>,
}

impl Update for Differential {
    fn update(&mut self, _: Period) {
        let (roll, pitch) = (self.roll_cmd.get(), self.pitch_cmd.get());
        self.motor0_cmd.set(roll + pitch);
        self.motor1_cmd.set(roll - pitch);
        let (first, second) = (self.motor0_fb.get(), self.motor1_fb.get());
        self.roll_fb.set((first + second) / 2.0);
        self.pitch_fb.set((first - second) / 2.0);
    }
}

#[cfg(test)]
mod tests {
    use super::Differential;
    use hal_bench::trace::replay;

    #[test]
    fn there_and_back() {
        let rows = "load differential
            run differential.0
            in differential.0.roll-cmd differential.0.pitch-cmd differential.0.motor0-fb differential.0.motor1-fb
            out differential.0.motor0-cmd differential.0.motor1-cmd differential.0.roll-fb differential.0.pitch-fb
            10 3 13 7 | 13 7 10 3
            -1 2 1 -3 | 1 -3 -1 2
            inf 0 0 0 | inf inf 0 0";
        assert_eq!(replay::<Differential>(rows), 3);
    }
}
