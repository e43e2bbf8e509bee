//! `near`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Comparator for nearly equal numbers.
///
/// # Example
///
/// ```hal
/// loadrt near
/// loadrt threads name1=servo period1=1000000
/// addf near.0 servo
/// start
/// setp near.0.in1 10
/// setp near.0.in2 10.4
/// setp near.0.difference 0.5
/// run 1ms
/// getp near.0.out # -> TRUE
/// setp near.0.in2 11
/// run 1ms
/// getp near.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Near {
    /// First number, in any unit.
    in1: In<f64>,
    /// Second number, in the same unit.
    in2: In<f64>,
    /// True when the numbers are within a factor of `scale`, or no more than `difference` apart.
    out: Out<bool>,
    /// Factor, for numbers of the same sign; with 1 or less, only `difference` counts.
    #[hal(default = 1.0)]
    scale: ParamRw<f64>,
    /// Largest difference that counts as near, in units.
    difference: ParamRw<f64>,
}

impl Update for Near {
    fn update(&mut self, _: Period) {
        let (mut a, mut b) = (self.in1.get(), self.in2.get());
        let far = (a - b).abs();
        if a < 0.0 {
            (a, b) = (-a, -b);
        }
        let scale = self.scale.get();
        let in_scale = scale > 1.0 && a / scale <= b && b <= a * scale;
        self.out.set(in_scale || far <= self.difference.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Near;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Near>(include_str!("../traces/near.txt")), 165);
    }
}
