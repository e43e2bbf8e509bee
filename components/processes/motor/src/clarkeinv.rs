//! `clarkeinv`.
use hal_component::{Component, In, Out, Period, Update};

/// Inverse Clarke transform: a vector in a plane, rotated by an angle, to three phases.
///
/// The transform inverts `clarke3` after a rotation by `theta`: with (`x'`, `y'`) the rotated vector, `a` = `x'` +
/// `h`/√2, `b` = -`x'`/2 + `y'`·√3/2 + `h`/√2, and `c` the same with -`y'`.
///
/// # Example
///
/// ```hal
/// loadrt clarkeinv
/// loadrt threads name1=servo period1=1000000
/// addf clarkeinv.0 servo
/// setp clarkeinv.0.x 1
/// start
/// run 1ms
/// getp clarkeinv.0.a # -> 1
/// getp clarkeinv.0.b # -> -0.5
/// ```
#[derive(Component)]
pub(crate) struct Clarkeinv {
    /// First coordinate, in any unit.
    x: In<f64>,
    /// Second coordinate, in the same unit.
    y: In<f64>,
    /// Common component of the phases, in the same unit, as from `clarke3`; 0 with three wires.
    h: In<f64>,
    /// Angle of rotation, in turns.
    theta: In<f64>,
    /// First phase, in the same unit.
    a: Out<f64>,
    /// Second phase, in the same unit.
    b: Out<f64>,
    /// Third phase, in the same unit.
    c: Out<f64>,
}

/// Full turn in radians, with LinuxCNC's ten digits.
const TURN: f64 = 6.283_185_308;
#[expect(clippy::approx_constant, reason = "15 digits are what is meant")]
const H: f64 = 0.707_106_781_186_547;
const Y: f64 = 0.866_025_403_784_439;

impl Update for Clarkeinv {
    fn update(&mut self, _: Period) {
        let angle = self.theta.get() * TURN;
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let (x, y) = (self.x.get(), self.y.get());
        let (x, y) = (x * cos - y * sin, x * sin + y * cos);
        let h = H * self.h.get();
        self.a.set(x + h);
        self.b.set(-0.5 * x + Y * y + h);
        self.c.set(-0.5 * x - Y * y + h);
    }
}

#[cfg(test)]
mod tests {
    use super::Clarkeinv;
    use hal_bench::trace::replay;

    #[test]
    fn phases() {
        let rows = "load clarkeinv
            within 1e-9
            run clarkeinv.0
            in clarkeinv.0.x clarkeinv.0.y clarkeinv.0.h clarkeinv.0.theta
            out clarkeinv.0.a clarkeinv.0.b clarkeinv.0.c
            1 0 0 0 | 1 -0.5 -0.5
            0 1 0 0 | 0 0.8660254037844386 -0.8660254037844386
            0 0 1 0 | 0.7071067811865475 0.7071067811865475 0.7071067811865475
            1 0 0 0.25 | 0 0.8660254037844386 -0.8660254037844386
            1 0 0 -0.5 | -1 0.5 0.5";
        assert_eq!(replay::<Clarkeinv>(rows), 5);
    }
}
