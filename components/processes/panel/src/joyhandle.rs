//! `joyhandle`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Joystick curve with a dead zone and low sensitivity near the middle.
///
/// From `deadband` to 1, the curve is a·x^`power` + b·x, with a = 1 / (1 - `deadband`^(`power` - 1)) and b = 1 - a, so
/// that it runs from 0 to 1; with a power of 1 it is a straight line. `inverse` mirrors the curve, so that the
/// sensitivity is highest at the edge of the dead zone. The result is multiplied by `scale`, and `offset` is added;
/// negative inputs give the same result with the opposite sign. Within the dead zone the output is 0, and inputs beyond
/// 1 count as 1.
///
/// # Example
///
/// ```hal
/// loadrt joyhandle
/// loadrt threads name1=servo period1=1000000
/// addf joyhandle.0 servo
/// setp joyhandle.0.deadband 0.1
/// setp joyhandle.0.scale 9
/// setp joyhandle.0.in 0.5
/// start
/// run 1ms
/// getp joyhandle.0.out # -> 2
/// ```
#[derive(Component)]
pub(crate) struct Joyhandle {
    /// Position of the handle, from -1 to 1.
    in_: In<f64>,
    /// Output of the curve, in the unit of `scale`.
    out: Out<f64>,
    /// Exponent of the curve, without unit, 1 to about 5; a value below 1 is set to 1.
    #[hal(default = 2.0)]
    power: ParamRw<f64>,
    /// Half the width of the dead zone, as a fraction of the handle's range to either side; limited to 0 to 0.99.
    deadband: ParamRw<f64>,
    /// Output at full deflection without `offset`, in the unit of the output.
    #[hal(default = 1.0)]
    scale: ParamRw<f64>,
    /// Output at the edge of the dead zone, in the unit of `scale`.
    offset: ParamRw<f64>,
    /// TRUE mirrors the curve.
    inverse: ParamRw<bool>,
}

impl Joyhandle {
    /// Returns the value of the curve from `dead` to 1.
    fn curve(x: f64, power: f64, dead: f64) -> f64 {
        if power == 1.0 {
            return (x - dead) / (1.0 - dead);
        }
        let a = 1.0 / (1.0 - libm::pow(dead, power - 1.0));
        let b = 1.0 - a;
        a * libm::pow(x, power) + b * x
    }
}

impl Update for Joyhandle {
    fn update(&mut self, _: Period) {
        if self.power.get() < 1.0 {
            self.power.set(1.0);
        }
        if self.deadband.get() < 0.0 {
            self.deadband.set(0.0);
        }
        if self.deadband.get() > 0.99 {
            self.deadband.set(0.99);
        }
        let (power, dead) = (self.power.get(), self.deadband.get());
        let x = self.in_.get();
        let size = libm::fabs(x);
        let size = if size > 1.0 { 1.0 } else { size };
        if size <= dead || size.is_nan() {
            self.out.set(0.0);
            return;
        }
        let y = if self.inverse.get() {
            1.0 - Self::curve(1.0 + dead - size, power, dead)
        } else {
            Self::curve(size, power, dead)
        };
        let y = self.scale.get() * y + self.offset.get();
        self.out.set(if x < 0.0 { -y } else { y });
    }
}

#[cfg(test)]
mod tests {
    use super::Joyhandle;
    use hal_bench::trace::replay;

    #[test]
    fn curves() {
        let rows = "load joyhandle
            within 1e-9
            set joyhandle.0.offset 0.2
            run joyhandle.0
            in joyhandle.0.in joyhandle.0.power joyhandle.0.deadband joyhandle.0.scale joyhandle.0.inverse
            out joyhandle.0.out joyhandle.0.power joyhandle.0.deadband
            0.5 2 0 1 0 | 0.45 2 0
            0.5 2 0.1 9 0 | 2.2 2 0.1
            0.1 2 0.1 1 0 | 0 2 0.1
            -0.5 2 0.1 9 0 | -2.2 2 0.1
            1.5 2 0.1 3 0 | 3.2 2 0.1
            0.5 2 0.1 3 1 | 2.2 2 0.1
            0.5 0.5 0.1 9 0 | 4.2 1 0.1
            0.5 2 2 1 0 | 0 2 0.99
            0.5 2 -1 1 0 | 0.45 2 0
            nan 2 0 1 0 | 0 2 0";
        assert_eq!(replay::<Joyhandle>(rows), 10);
    }
}
