//! `gearchange`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Speed command of a spindle with two gears.
///
/// The magnitude of the speed is limited to the range of the gear, whatever its sign. In the second gear, the result is
/// divided by `scale2`, and the direction may be reversed. A speed that is NaN passes unchanged.
///
/// # Example
///
/// ```hal
/// loadrt gearchange
/// loadrt threads name1=servo period1=1000000
/// addf gearchange.0 servo
/// setp gearchange.0.max2 1000
/// setp gearchange.0.scale2 2.5
/// setp gearchange.0.sel 1
/// setp gearchange.0.speed-in 5000
/// start
/// run 1ms
/// getp gearchange.0.speed-out # -> 400
/// ```
#[derive(Component)]
pub(crate) struct Gearchange {
    /// Selected gear: FALSE the first, TRUE the second.
    sel: In<bool>,
    /// Requested speed of the spindle, in any unit, such as turns per minute.
    speed_in: In<f64>,
    /// Speed for the drive, converted to first gear, in the unit of `speed-in`.
    speed_out: Out<f64>,
    /// Requested direction.
    dir_in: In<bool>,
    /// Direction for the drive.
    dir_out: Out<bool>,
    /// Minimum speed in the first gear, in the unit of `speed-in`.
    min1: ParamRw<f64>,
    /// Maximum speed in the first gear, in the unit of `speed-in`; `min1` wins if the two are crossed.
    #[hal(default = 100_000.0)]
    max1: ParamRw<f64>,
    /// Minimum speed in the second gear, in the unit of `speed-in`.
    min2: ParamRw<f64>,
    /// Maximum speed in the second gear, in the unit of `speed-in`; `min2` wins if the two are crossed.
    #[hal(default = 100_000.0)]
    max2: ParamRw<f64>,
    /// Ratio of the second gear's speed to the first gear's; a value below 1 is set to 1.
    #[hal(default = 1.0)]
    scale2: ParamRw<f64>,
    /// TRUE: the second gear reverses the direction.
    reverse: ParamRw<bool>,
}

/// Limits the magnitude of a speed to a range.
fn within(speed: f64, low: f64, high: f64) -> f64 {
    if speed < 0.0 {
        if speed > -low {
            -low
        } else if speed < -high {
            -high
        } else {
            speed
        }
    } else if speed < low {
        low
    } else if speed > high {
        high
    } else {
        speed
    }
}

impl Update for Gearchange {
    fn update(&mut self, _: Period) {
        if self.scale2.get() < 1.0 {
            self.scale2.set(1.0);
        }
        let (speed, dir) = (self.speed_in.get(), self.dir_in.get());
        if self.sel.get() {
            let kept = within(speed, self.min2.get(), self.max2.get());
            self.speed_out.set(kept / self.scale2.get());
            self.dir_out.set(dir != self.reverse.get());
        } else {
            self.speed_out.set(within(speed, self.min1.get(), self.max1.get()));
            self.dir_out.set(dir);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Gearchange;
    use hal_bench::trace::replay;

    #[test]
    fn both_gears() {
        let rows = "load gearchange
            set gearchange.0.min1 10
            set gearchange.0.max1 500
            set gearchange.0.max2 1000
            set gearchange.0.scale2 2.5
            set gearchange.0.reverse 1
            run gearchange.0
            in gearchange.0.sel gearchange.0.speed-in gearchange.0.dir-in
            out gearchange.0.speed-out gearchange.0.dir-out
            0 100 0 | 100 0
            0 1 1 | 10 1
            0 -1 1 | -10 1
            0 600 0 | 500 0
            0 -600 0 | -500 0
            1 100 0 | 40 1
            1 -5 1 | -2 0
            1 5000 0 | 400 1
            1 nan 0 | nan 1
            set gearchange.0.scale2 0.5
            1 100 0 | 100 1
            expect gearchange.0.scale2 1";
        assert_eq!(replay::<Gearchange>(rows), 10);
    }
}
