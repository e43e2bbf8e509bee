//! `gearchange`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Speed command of a spindle with two gears.
///
/// The size of the speed is kept within the range of the gear, whatever its sign; in the second
/// gear the result is divided by `scale2`, and the direction may be reversed. A speed that is no
/// number goes through.
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
    /// Which gear: false for the first, true for the second.
    sel: In<bool>,
    /// The speed that is wanted at the spindle, such as in turns per minute.
    speed_in: In<f64>,
    /// The speed for the drive, as it would be in the first gear, in the unit of `speed-in`.
    speed_out: Out<f64>,
    /// The direction that is wanted.
    dir_in: In<bool>,
    /// The direction for the drive.
    dir_out: Out<bool>,
    /// Lowest speed in the first gear, in the unit of `speed-in`.
    min1: ParamRw<f64>,
    /// Highest speed in the first gear, in the unit of `speed-in`; it loses against `min1`.
    #[hal(default = 100_000.0)]
    max1: ParamRw<f64>,
    /// Lowest speed in the second gear, in the unit of `speed-in`.
    min2: ParamRw<f64>,
    /// Highest speed in the second gear, in the unit of `speed-in`; it loses against `min2`.
    #[hal(default = 100_000.0)]
    max2: ParamRw<f64>,
    /// How much faster the second gear is than the first, a ratio; below 1 it is set to 1.
    #[hal(default = 1.0)]
    scale2: ParamRw<f64>,
    /// Whether the second gear turns the other way.
    reverse: ParamRw<bool>,
}

/// A speed whose size is kept in a range.
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
    use hal_component::trace::replay;

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
