//! `ddt`.
use hal_component::{Component, In, Out, Period, Update};

/// Rate of change of a number.
///
/// The output is the backward difference (x - previous x)/T, which is the rate in the middle of the last period.
///
/// # Example
///
/// ```hal
/// loadrt ddt
/// loadrt threads name1=servo period1=1000000
/// addf ddt.0 servo
/// start
/// setp ddt.0.in 1
/// run 1ms
/// setp ddt.0.in 3
/// run 1ms
/// getp ddt.0.out # -> 2000
/// ```
#[derive(Component)]
pub(crate) struct Ddt {
    /// The number, in units.
    in_: In<f64>,
    /// Change since the last cycle, in units per second; before the first cycle the input counts as 0.
    out: Out<f64>,
    #[state]
    old: f64,
}

impl Update for Ddt {
    fn update(&mut self, period: Period) {
        let x = self.in_.get();
        self.out.set((x - self.old) / period.secs());
        self.old = x;
    }
}

#[cfg(test)]
mod tests {
    use super::Ddt;
    use hal_bench::{Bench, trace::replay};

    /// The backward difference of a ramp is its slope, and that of a parabola x = a·t²/2 is a·(t - T/2): in the middle
    /// of the period.
    #[test]
    fn ramps_and_parabolas() {
        let mut bench = Bench::new();
        bench.load::<Ddt>(&["count=2"]).unwrap();
        let (slope, accel, dt) = (-3.7, 12.5, 0.001);
        for n in 1..=1000 {
            let t = f64::from(n) * dt;
            let given = [slope * t, 0.5 * accel * t * t];
            for (i, (x, wanted)) in
                given.into_iter().zip([slope, accel * (t - dt / 2.0)]).enumerate()
            {
                bench.set(&format!("ddt.{i}.in"), x);
                bench.run(&format!("ddt.{i}"), 1_000_000);
                let is: f64 = bench.get(&format!("ddt.{i}.out"));
                // Both numbers were rounded two or three times before the subtraction.
                let bound = 4.0 * f64::EPSILON * x.abs() / dt;
                assert!((is - wanted).abs() <= bound, "{i} at {t}: {is}, not {wanted}");
            }
        }
    }

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Ddt>(include_str!("../traces/ddt.txt")), 100);
    }
}
