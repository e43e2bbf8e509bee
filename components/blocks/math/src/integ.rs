//! `integ`.
use crate::bounds::{larger, smaller};
use hal_component::{Component, In, Out, Period, Update};

/// Integral of a number over time.
///
/// Each cycle adds `gain`·`in`·T: the present number counts for the whole of the last period.
///
/// # Example
///
/// ```hal
/// loadrt integ
/// loadrt threads name1=servo period1=1000000
/// addf integ.0 servo
/// start
/// setp integ.0.in 5
/// run 100ms
/// getp integ.0.out # -> 0.5
/// ```
#[derive(Component)]
pub(crate) struct Integ {
    /// The number, in units per second.
    in_: In<f64>,
    /// Factor of the input, without unit.
    #[hal(default = 1.0)]
    gain: In<f64>,
    /// While true, the integral is 0 (within the bounds).
    reset: In<bool>,
    /// Minimum of the integral, in units; it wins if the bounds are crossed.
    #[hal(default = -1e20)]
    min_: In<f64>,
    /// Maximum of the integral, in units.
    #[hal(default = 1e20)]
    max_: In<f64>,
    /// Integral, in units, limited to the bounds in every cycle.
    out: Out<f64>,
}

impl Update for Integ {
    fn update(&mut self, period: Period) {
        let sum = if self.reset.get() {
            0.0
        } else {
            self.out.get() + self.gain.get() * self.in_.get() * period.secs()
        };
        self.out.set(larger(smaller(sum, self.max_.get()), self.min_.get()));
    }
}

#[cfg(test)]
mod tests {
    use super::Integ;
    use hal_bench::{Bench, trace::replay};

    /// Each cycle adds a rectangle: a constant c gives c·t, a ramp r·t gives r·t·(t + T)/2, and a full cycle of a sine
    /// gives 0.
    #[test]
    fn areas() {
        let mut bench = Bench::new();
        bench.load::<Integ>(&["count=3"]).unwrap();
        let (gain, constant, slope, dt) = (0.7, 4.2, -9.1, 0.001);
        for n in 1..=1000 {
            let t = f64::from(n) * dt;
            let sine = libm::sin(core::f64::consts::TAU * t);
            let given = [constant, slope * t, sine];
            let wanted = [constant * t, slope * t * (t + dt) / 2.0, 0.0];
            for (i, (x, wanted)) in given.into_iter().zip(wanted).enumerate() {
                bench.set(&format!("integ.{i}.gain"), gain);
                bench.set(&format!("integ.{i}.in"), x);
                bench.run(&format!("integ.{i}"), 1_000_000);
                let is: f64 = bench.get(&format!("integ.{i}.out"));
                // Each cycle rounds the addend four times and the sum once; no sum is above 5.
                let bound = f64::from(n) * (4.0 * 0.01 + 5.0) * f64::EPSILON / 2.0;
                if i < 2 || n == 1000 {
                    assert!((is - gain * wanted).abs() <= bound, "{i} at {t}: {is}, not {wanted}");
                }
            }
        }
    }

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Integ>(include_str!("../traces/integ.txt")), 143);
    }
}
