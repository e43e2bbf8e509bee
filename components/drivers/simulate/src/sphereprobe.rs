//! `sphereprobe`.
use hal_component::{Component, In, Out, Period, Update};

/// Probe that touches a sphere on a table.
///
/// The table is the plane through the sphere's centre; beside the sphere, every position below the table counts as
/// contact.
///
/// # Example
///
/// ```hal
/// loadrt sphereprobe
/// loadrt threads name1=servo period1=1000000
/// addf sphereprobe.0 servo
/// setp sphereprobe.0.r 1000
/// setp sphereprobe.0.px 600
/// setp sphereprobe.0.pz 900
/// start
/// run 1ms
/// getp sphereprobe.0.probe-out # -> FALSE
/// setp sphereprobe.0.pz 700
/// run 1ms
/// getp sphereprobe.0.probe-out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Sphereprobe {
    /// X of the probe, in counts.
    px: In<i32>,
    /// Y of the probe, in counts.
    py: In<i32>,
    /// Z of the probe, in counts.
    pz: In<i32>,
    /// X of the sphere's centre, in counts.
    cx: In<i32>,
    /// Y of the sphere's centre, in counts.
    cy: In<i32>,
    /// Z of the sphere's centre and of the table, in counts.
    cz: In<i32>,
    /// Radius of the sphere, in counts.
    r: In<i32>,
    /// True while the probe is within the sphere, or beside it and below the table.
    probe_out: Out<bool>,
}

impl Update for Sphereprobe {
    fn update(&mut self, _: Period) {
        let far = |p: &In<i32>, c: &In<i32>| p.get().wrapping_sub(c.get());
        let (x, y, z) = (far(&self.px, &self.cx), far(&self.py, &self.cy), far(&self.pz, &self.cz));
        let square = |n: i32| i128::from(n) * i128::from(n);
        let (beside, r) = (square(x) + square(y), square(self.r.get()));
        let out = if beside > r { self.pz.get() < self.cz.get() } else { beside + square(z) <= r };
        self.probe_out.set(out);
    }
}

#[cfg(test)]
mod tests {
    use super::Sphereprobe;
    use hal_bench::trace::replay;

    #[test]
    fn table_and_sphere() {
        let rows = "load sphereprobe
            set sphereprobe.0.r 10
            run sphereprobe.0
            in sphereprobe.0.px sphereprobe.0.py sphereprobe.0.pz
            out sphereprobe.0.probe-out
            0 0 10 | 1
            0 0 11 | 0
            6 0 8 | 1
            6 1 8 | 0
            50 0 1 | 0
            50 0 0 | 0
            50 0 -1 | 1
            0 0 -11 | 0";
        assert_eq!(replay::<Sphereprobe>(rows), 8);
    }
}
