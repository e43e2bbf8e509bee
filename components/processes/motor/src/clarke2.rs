//! `clarke2`.
use hal_component::{Component, In, Out, Period, Update};

/// Clarke transform of two phases out of three, whose sum is zero, to a vector in a plane.
///
/// The transform applies to currents or voltages of three wires: `x` = `a`, and `y` = (`a` + 2·`b`) / √3. The factors
/// have 15 digits.
///
/// # Example
///
/// ```hal
/// loadrt clarke2
/// loadrt threads name1=servo period1=1000000
/// addf clarke2.0 servo
/// setp clarke2.0.a 1
/// setp clarke2.0.b -0.5
/// start
/// run 1ms
/// getp clarke2.0.x # -> 1
/// ```
#[derive(Component)]
pub(crate) struct Clarke2 {
    /// First phase, in any unit.
    a: In<f64>,
    /// Second phase, in the same unit.
    b: In<f64>,
    /// First coordinate of the vector, along the first phase, in the same unit.
    x: Out<f64>,
    /// Second coordinate of the vector, a quarter turn ahead, in the same unit.
    y: Out<f64>,
}

const A: f64 = 0.577_350_269_189_626;
const B: f64 = 1.154_700_538_379_25;

impl Update for Clarke2 {
    fn update(&mut self, _: Period) {
        let (a, b) = (self.a.get(), self.b.get());
        self.x.set(a);
        self.y.set(A * a + B * b);
    }
}

#[cfg(test)]
mod tests {
    use super::Clarke2;
    use hal_bench::trace::replay;

    #[test]
    fn phases() {
        let rows = "load clarke2
            within 1e-14
            run clarke2.0
            in clarke2.0.a clarke2.0.b
            out clarke2.0.x clarke2.0.y
            1 -0.5 | 1 0
            0 0.8660254037844386 | 0 1
            -0.5 1 | -0.5 0.8660254037844386
            nan 1 | nan nan";
        assert_eq!(replay::<Clarke2>(rows), 4);
    }
}
