//! `clarke3`.
use hal_component::{Component, In, Out, Period, Update};

/// Clarke transform of three phases to a vector in a plane and a common component.
///
/// The transform is `x` = (2·`a` - `b` - `c`) / 3, `y` = (`b` - `c`) / √3, `h` = √2 · (`a` + `b` + `c`) / 3. The
/// factors have 15 digits.
///
/// # Example
///
/// ```hal
/// loadrt clarke3
/// loadrt threads name1=servo period1=1000000
/// addf clarke3.0 servo
/// setp clarke3.0.a 3
/// start
/// run 1ms
/// getp clarke3.0.x # -> 2
/// getp clarke3.0.h # -> 1.414214
/// ```
#[derive(Component)]
pub(crate) struct Clarke3 {
    /// First phase, in any unit.
    a: In<f64>,
    /// Second phase, in the same unit.
    b: In<f64>,
    /// Third phase, in the same unit.
    c: In<f64>,
    /// First coordinate of the vector, along the first phase, in the same unit.
    x: Out<f64>,
    /// Second coordinate of the vector, a quarter turn ahead, in the same unit.
    y: Out<f64>,
    /// Common component of the phases, in the same unit; 0 if their sum is zero.
    h: Out<f64>,
}

const TWO_THIRDS: f64 = 0.666_666_666_666_667;
const THIRD: f64 = 0.333_333_333_333_333;
const Y: f64 = 0.577_350_269_189_626;
const H: f64 = 0.471_404_520_791_032;

impl Update for Clarke3 {
    fn update(&mut self, _: Period) {
        let (a, b, c) = (self.a.get(), self.b.get(), self.c.get());
        self.x.set(TWO_THIRDS * a - THIRD * (b + c));
        self.y.set(Y * (b - c));
        self.h.set(H * (a + b + c));
    }
}

#[cfg(test)]
mod tests {
    use super::Clarke3;
    use hal_bench::trace::replay;

    #[test]
    fn phases() {
        let rows = "load clarke3
            within 1e-14
            run clarke3.0
            in clarke3.0.a clarke3.0.b clarke3.0.c
            out clarke3.0.x clarke3.0.y clarke3.0.h
            1 -0.5 -0.5 | 1 0 0
            0 0.8660254037844386 -0.8660254037844386 | 0 1 0
            1 1 1 | 0 0 1.4142135623730951";
        assert_eq!(replay::<Clarke3>(rows), 3);
    }
}
