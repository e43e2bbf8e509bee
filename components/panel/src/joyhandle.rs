//! `joyhandle`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Curve of a joystick: slow near its middle, and a dead zone.
///
/// From `deadband` to 1 the curve is a·x^`power` + b·x, with a = 1 / (1 - `deadband`^(`power` - 1)) and
/// b = 1 - a, so that it begins with 0 and ends with 1; with a power of 1 it is a line. `inverse`
/// turns the curve around the middle of its range, so that it is fast there. The result is times `scale`,
/// plus `offset`; negative inputs give the same with the other sign. Within the dead zone it is 0,
/// beyond 1 it is that of 1.
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
    /// Where the handle is, from -1 to 1.
    in_: In<f64>,
    /// The curve at that point, in the unit of `scale`.
    out: Out<f64>,
    /// How far the curve bends, a number without a unit, 1 to about 5; below 1 it is set to 1.
    #[hal(default = 2.0)]
    power: ParamRw<f64>,
    /// Half the width of the dead zone, as a fraction of what the handle goes to either side; set
    /// to at least 0 and at most 0.99.
    deadband: ParamRw<f64>,
    /// Height of the curve at 1, without `offset`, in the unit that the output is to have.
    #[hal(default = 1.0)]
    scale: ParamRw<f64>,
    /// Height of the curve at the edge of the dead zone, in the unit of `scale`.
    offset: ParamRw<f64>,
    /// Whether the curve is turned around.
    inverse: ParamRw<bool>,
}

impl Joyhandle {
    /// The curve from `dead` to 1.
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
    use hal_component::trace::replay;

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
