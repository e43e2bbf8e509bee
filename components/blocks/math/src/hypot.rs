//! `hypot`.
use hal_component::{Component, In, Out, Period, Update};

/// Length of a vector of up to three coordinates.
///
/// # Example
///
/// ```hal
/// loadrt hypot
/// loadrt threads name1=servo period1=1000000
/// addf hypot.0 servo
/// start
/// setp hypot.0.in0 3
/// setp hypot.0.in1 4
/// setp hypot.0.in2 12
/// run 1ms
/// getp hypot.0.out # -> 13
/// ```
#[derive(Component)]
pub(crate) struct Hypot {
    /// First coordinate, in any unit.
    in0: In<f64>,
    /// Second coordinate, in the same unit.
    in1: In<f64>,
    /// Third coordinate, in the same unit; leave it unlinked for two.
    in2: In<f64>,
    /// Square root of the sum of the squares, in the same unit.
    out: Out<f64>,
}

impl Update for Hypot {
    fn update(&mut self, _: Period) {
        let (x, y, z) = (self.in0.get(), self.in1.get(), self.in2.get());
        self.out.set(libm::sqrt(x * x + y * y + z * z));
    }
}

#[cfg(test)]
mod tests {
    use super::Hypot;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Hypot>(include_str!("../traces/hypot.txt")), 40);
    }
}
