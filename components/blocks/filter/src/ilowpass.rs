//! `ilowpass`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Low-pass filter for a count, such as that of a hand wheel.
///
/// # Example
///
/// ```hal
/// loadrt ilowpass
/// loadrt threads name1=servo period1=1000000
/// addf ilowpass.0 servo
/// start
/// setp ilowpass.0.in 100
/// run 1ms
/// getp ilowpass.0.out # -> 51200
/// run 1ms
/// getp ilowpass.0.out # -> 76800
/// ```
#[derive(Component)]
pub(crate) struct Ilowpass {
    /// Input count.
    in_: In<i32>,
    /// Smoothed count, times `scale`; it wraps at 32 bits.
    out: Out<i32>,
    /// Factor of the smoothed count, which gives finer steps.
    #[hal(default = 1024.0)]
    scale: ParamRw<f64>,
    /// Fraction of the distance to the count that each cycle covers, 0 to 1.
    #[hal(default = 0.5)]
    gain: ParamRw<f64>,
    #[state]
    value: f64,
}

/// Magnitude from which a number does not fit in 64 bits; the output is then 0.
const TOO_LARGE: f64 = 9.223_372_036_854_776e18;

impl Update for Ilowpass {
    #[expect(clippy::cast_possible_truncation, reason = "the count wraps")]
    fn update(&mut self, _: Period) {
        self.value += (f64::from(self.in_.get()) - self.value) * self.gain.get();
        let whole = libm::floor(self.value * self.scale.get() + 0.5);
        let fits = whole.abs() < TOO_LARGE;
        self.out.set(if fits { whole as i64 as i32 } else { 0 });
    }
}

#[cfg(test)]
mod tests {
    use super::Ilowpass;
    use hal_bench::trace::replay;

    #[test]
    fn what_is_too_large_for_64_bits_is_zero() {
        let mut bench = hal_bench::Bench::new();
        bench.load::<Ilowpass>(&[]).unwrap();
        bench.set("ilowpass.0.in", 1);
        bench.set("ilowpass.0.scale", 1e30);
        bench.run("ilowpass.0", 1_000_000);
        assert_eq!(bench.get::<i32>("ilowpass.0.out"), 0);
    }

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Ilowpass>(include_str!("../traces/ilowpass.txt")), 240);
    }
}
