//! `eoffset_per_angle`.
use core::f64::consts::PI;
use hal_component::{
    Builder, Component, Error, In, Messages, Out, Period, Touch, Update, abi::component_flags,
    to_s32,
};

/// Value used for `k` if it is 0.
const COUNTS: i32 = 10_000;

/// Offset of an axis that follows an angle, for polygons and the like.
pub(crate) struct EoffsetPerAngle;

impl Component for EoffsetPerAngle {
    const NAME: &'static str = "eoffset_per_angle";
    const DOC: &'static str = "An offset of an axis that follows an angle, such as to turn polygons.\n\n\
        The angle is that of a spindle or of a rotary axis, the offset an external offset of the \
        axis perpendicular to it: `kcounts` goes to `axis.L.eoffset-counts`, `kreciprocal` to \
        `axis.L.eoffset-scale`, `enable-out` to `axis.L.eoffset-enable`, `clear` to \
        `axis.L.eoffset-clear`, and `active` comes from `motion.eoffset-active`.\n\n\
        With r = `radius-ref`, a = `rfraction`, n = `fmult` and the angle φ since `start-angle`, `fnum` \
        chooses the offset:\n\n\
        | fnum | offset |\n\
        |---|---|\n\
        | 0, and any other | polygon of n sides around a circle: (1 + a)·r / cos θ - r |\n\
        | 1 | polygon of n sides within a circle: (1 + a)·r·cos(180°/n) / cos θ - r |\n\
        | 2 | wave: a·r·(1 - cos nφ) / 2 |\n\
        | 3 | steps: a·r where cos nφ is not above 0, else 0 |\n\n\
        θ is the angle from the middle of the side to φ. A polygon needs n above 2; with less the \
        offset goes back to 0, a message says so, and `enable-in` must become false and true \
        again. As `enable-in` becomes false the offset goes back to 0 as fast as the axis allows \
        for it, and `clear` is true until it is there. A machine that is off has no offset.\n\n\
        Fractions of a count are cut off. An offset that does not fit, or is NaN, becomes \
        -2147483648 counts.\n\n\
        LinuxCNC 2.9 takes θ up to 1.5 sides from the middle for angles below `start-angle`, where its \
        polygons have spikes. Here they are polygons at every angle.\n\n\
        # Example\n\n\
        A hexagon around a circle of radius 10: the radius is 10 in the middle of a side and 10 / cos 30° \
        at a corner.\n\n\
        ```hal\n\
        loadrt eoffset_per_angle names=hex\n\
        loadrt threads name1=servo period1=1000000\n\
        addf hex servo\n\
        setp hex.radius-ref 10\n\
        setp hex.rfraction 0\n\
        setp hex.is-on 1\n\
        start\n\
        run 2ms\n\
        setp hex.enable-in 1\n\
        run 2ms\n\
        getp hex.kcounts # -> 0\n\
        setp hex.angle 30\n\
        run 1ms\n\
        getp hex.kcounts # -> 15470\n\
        getp hex.state-dbg # -> 2\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let offset = Offset {
            active: b.item("active", "True while the axis has an offset.", false)?,
            is_on: b.item("is-on", "True while the machine is on.", false)?,
            enable_in: b.item("enable-in", "True makes the axis follow the angle.", false)?,
            radius_ref: b.item("radius-ref", "The radius r, in units.", 1.0)?,
            angle: b.item("angle", "The angle, in degrees; any number of turns.", 0.0)?,
            start_angle: b.item(
                "start-angle",
                "Angle from which the offset is computed, in degrees.",
                0.0,
            )?,
            fnum: b.item(
                "fnum",
                "Function of the offset, 0 to 3; any other number counts as 0.",
                0,
            )?,
            rfraction: b.item(
                "rfraction",
                "Size a of the offset, as a fraction of the radius.",
                0.1,
            )?,
            fmult: b.item("fmult", "Number of sides of a polygon, or of waves per turn.", 6.0)?,
            k: b.item(
                "k",
                "Counts per unit; 0 counts as 10000, and a value above 2147483647 as 4294967296 \
                less.",
                10_000,
            )?,
            is_off: b.item("is-off", "True while the machine is off.", false)?,
            enable_out: b.item("enable-out", "True while the axis may have an offset.", false)?,
            clear: b.item("clear", "True returns the offset to 0.", false)?,
            kcounts: b.item("kcounts", "The offset, in counts.", 0)?,
            kreciprocal: b.item(
                "kreciprocal",
                "Distance per count, in units: 1 / k, in single precision.",
                0.0,
            )?,
            eoffset_dbg: b.item("eoffset-dbg", "The offset, in units, for diagnosis.", 0.0)?,
            state_dbg: b.item(
                "state-dbg",
                "State at the beginning of the last run, for diagnosis: 0 machine off, 1 waiting \
                for `enable-in`, 2 following, 3 returning, 4 returned.",
                0,
            )?,
            messages: b.messages(),
            phase: Phase::Off,
            was_on: false,
        };
        b.function("", "Computes the offset.", offset)
    }
}

#[derive(Touch)]
struct Offset {
    active: In<bool>,
    is_on: In<bool>,
    enable_in: In<bool>,
    radius_ref: In<f64>,
    angle: In<f64>,
    start_angle: In<f64>,
    fnum: In<i32>,
    rfraction: In<f64>,
    fmult: In<f64>,
    k: In<u32>,
    is_off: Out<bool>,
    enable_out: Out<bool>,
    clear: Out<bool>,
    kcounts: Out<i32>,
    kreciprocal: Out<f64>,
    eoffset_dbg: Out<f64>,
    state_dbg: Out<u32>,
    messages: Messages,
    #[state]
    phase: Phase,
    #[state]
    was_on: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Off,
    Waits,
    Follows,
    /// Holds true after a failure: `enable-in` must then turn false and true again.
    GoesBack(bool),
    IsBack(bool),
}

impl Phase {
    const fn number(self) -> u32 {
        match self {
            Self::Off => 0,
            Self::Waits => 1,
            Self::Follows => 2,
            Self::GoesBack(_) => 3,
            Self::IsBack(_) => 4,
        }
    }
}

impl Update for Offset {
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    fn update(&mut self, _: Period) {
        let k = match self.k.get().cast_signed() {
            0 => COUNTS,
            k => k,
        };
        let unit = f64::from((1.0 / f64::from(k)) as f32);
        self.kreciprocal.set(unit);
        self.state_dbg.set(self.phase.number());
        let on = self.is_on.get();
        if on && !self.was_on && self.enable_in.get() {
            let text = "eoffset_per_angle: enable-in is true before the machine is on, and must \
                        become false first";
            self.messages.warn(text, &[]);
        }
        self.was_on = on;
        self.is_off.set(!on);
        self.phase = if on { self.next(k) } else { Phase::Off };
        if !on {
            self.enable_out.set(false);
            self.kcounts.set(0);
        }
        self.eoffset_dbg.set(f64::from(self.kcounts.get()) * unit);
    }
}

impl Offset {
    /// Executes the phase while the machine is on. Returns the next phase.
    fn next(&self, k: i32) -> Phase {
        let enabled = self.enable_in.get();
        match self.phase {
            Phase::Off if enabled => Phase::Off,
            Phase::Waits if enabled => Phase::Follows,
            Phase::Off | Phase::Waits => Phase::Waits,
            Phase::Follows if enabled => {
                self.enable_out.set(true);
                let offset = self.offset();
                self.kcounts.set(offset.map_or(0, |o| to_s32(o * f64::from(k))));
                if offset.is_some() { Phase::Follows } else { Phase::GoesBack(true) }
            }
            Phase::Follows => {
                self.clear.set(true);
                self.kcounts.set(0);
                Phase::GoesBack(false)
            }
            Phase::GoesBack(_) if self.active.get() => self.phase,
            Phase::GoesBack(failed) => Phase::IsBack(failed),
            Phase::IsBack(failed) => {
                self.enable_out.set(false);
                self.clear.set(false);
                if failed { Phase::Off } else { Phase::Waits }
            }
        }
    }

    /// Returns the offset in units, or `None` if there is no such polygon.
    fn offset(&self) -> Option<f64> {
        let (r, a, n) = (self.radius_ref.get(), self.rfraction.get(), self.fmult.get());
        let angle = self.angle.get() - self.start_angle.get();
        let outer = (1.0 + a) * r;
        Some(match self.fnum.get() {
            1 => outer * libm::cos(PI / n) / libm::cos(self.within_side(angle, n)?) - r,
            2 => r * a * 0.5 * (1.0 - libm::cos(n * angle * (PI / 180.0))),
            3 if libm::sin((n * angle - 90.0) * PI / 180.0) >= 0.0 => r * a,
            3 => 0.0,
            _ => outer / libm::cos(self.within_side(angle, n)?) - r,
        })
    }

    /// Returns the distance of an angle from the middle of its polygon side, in radians.
    fn within_side(&self, angle: f64, n: f64) -> Option<f64> {
        if n <= 2.0 {
            let text = "eoffset_per_angle: fmult is {}, and a polygon has more than 2 sides; the \
                        offset goes back to 0 until enable-in becomes true again";
            self.messages.error(text, &[n]);
            return None;
        }
        let side = 360.0 / n;
        Some((angle - side * libm::floor(angle / side + 0.5)) * (PI / 180.0))
    }
}

#[cfg(test)]
mod tests {
    use super::EoffsetPerAngle;
    use hal_bench::{Bench, trace::replay};

    /// Returns a bench in state 2, with the machine on.
    fn following(settings: &[(&str, f64)]) -> Bench {
        let mut bench = Bench::new();
        bench.load::<EoffsetPerAngle>(&["names=e"]).unwrap();
        for (pin, value) in settings {
            bench.set(&format!("e.{pin}"), *value);
        }
        bench.set("e.is-on", true);
        bench.run("e", 1_000_000);
        bench.run("e", 1_000_000);
        bench.set("e.enable-in", true);
        bench.run("e", 1_000_000);
        bench
    }

    fn at(bench: &mut Bench, angle: f64) -> f64 {
        bench.set("e.angle", angle);
        bench.run("e", 1_000_000);
        f64::from(bench.get::<i32>("e.kcounts")) / 1e6
    }

    #[test]
    fn is_enabled_and_stops() {
        let rows = "load eoffset_per_angle names=e
            run e
            in e.is-on e.enable-in e.active
            out e.state-dbg e.is-off e.enable-out e.clear e.kcounts
            0 0 0 | 0 1 0 0 0
            1 1 0 | 0 0 0 0 0
            1 1 0 | 0 0 0 0 0
            1 0 0 | 0 0 0 0 0
            1 0 0 | 1 0 0 0 0
            1 1 0 | 1 0 0 0 0
            1 1 0 | 2 0 1 0 1000
            1 1 1 | 2 0 1 0 1000
            1 0 1 | 2 0 1 1 0
            1 0 1 | 3 0 1 1 0
            1 1 0 | 3 0 1 1 0
            1 1 0 | 4 0 0 0 0
            1 1 0 | 1 0 0 0 0
            1 1 0 | 2 0 1 0 1000
            0 1 0 | 2 1 0 0 0
            1 1 0 | 0 0 0 0 0";
        assert_eq!(replay::<EoffsetPerAngle>(rows), 16);
    }

    #[test]
    fn without_a_polygon_it_goes_back_until_enabled_anew() {
        let rows = "load eoffset_per_angle names=e
            run e
            in e.is-on e.enable-in e.active e.fmult
            out e.state-dbg e.enable-out e.clear e.kcounts
            1 0 1 6 | 0 0 0 0
            1 1 1 6 | 1 0 0 0
            1 1 1 6 | 2 1 0 1000
            1 1 1 2 | 2 1 0 0
            1 1 1 6 | 3 1 0 0
            1 1 0 6 | 3 1 0 0
            1 1 0 6 | 4 0 0 0
            1 1 0 6 | 0 0 0 0
            1 0 0 6 | 0 0 0 0
            1 1 0 6 | 1 0 0 0
            1 1 0 6 | 2 1 0 1000";
        assert_eq!(replay::<EoffsetPerAngle>(rows), 11);
    }

    /// The corners of a polygon lie on a circle, and its sides are straight, at every angle.
    #[test]
    fn polygons_are_polygons() {
        for (fnum, sides) in [(0, 3.0), (0, 6.0), (1, 4.0), (1, 5.0), (9, 6.0)] {
            let mut b = following(&[("radius-ref", 2.0), ("rfraction", 0.1), ("fmult", sides)]);
            b.set("e.k", 1_000_000_u32);
            b.set("e.fnum", fnum);
            let half = core::f64::consts::PI / sides;
            // Distance of a side from the axis.
            let side = if fnum == 1 { 2.2 * libm::cos(half) } else { 2.2 };
            for i in -720..720 {
                let angle = f64::from(i) + 0.25;
                let radius = 2.0 + at(&mut b, angle);
                let turn = angle.to_radians();
                let nearest = libm::round(turn / (2.0 * half)) * 2.0 * half;
                assert!((radius * libm::cos(turn - nearest) - side).abs() < 2e-6, "{angle}");
            }
        }
    }

    #[test]
    fn waves_and_steps() {
        let mut b = following(&[("radius-ref", 2.0), ("rfraction", 0.1), ("fmult", 3.0)]);
        b.set("e.k", 1_000_000_u32);
        b.set("e.fnum", 2);
        b.set("e.start-angle", 10.0);
        for (angle, is) in [(10.0, 0.0), (30.0, 0.05), (40.0, 0.1), (70.0, 0.2), (-50.0, 0.2)] {
            assert!((at(&mut b, angle) - is).abs() < 2e-6, "{angle}");
        }
        b.set("e.fnum", 3);
        for (angle, is) in [(10.0, 0.0), (39.0, 0.0), (41.0, 0.2), (99.0, 0.2), (101.0, 0.0)] {
            assert!((at(&mut b, angle) - is).abs() < 2e-6, "{angle}");
        }
    }

    #[test]
    fn edges() {
        let mut b = following(&[]);
        for pin in ["e.angle", "e.start-angle", "e.radius-ref", "e.rfraction", "e.fmult"] {
            for value in [f64::NAN, f64::INFINITY] {
                b.set(pin, value);
                b.run("e", 1_000_000);
                assert_eq!(b.get::<i32>("e.kcounts"), i32::MIN, "{pin} {value}");
            }
            b = following(&[]);
        }
        for (k, counts, unit) in [
            (0, 1000, f64::from(1e-4_f32)),
            (1, 0, 1.0),
            (u32::MAX, 0, -1.0),
            (2_147_483_648, -214_748_364, -1.0 / 2_147_483_648.0),
        ] {
            b.set("e.k", k);
            b.run("e", 1_000_000);
            assert_eq!(b.get::<f64>("e.kreciprocal"), unit, "{k}");
            assert_eq!(b.get::<i32>("e.kcounts"), counts, "{k}");
            assert_eq!(b.get::<f64>("e.eoffset-dbg"), f64::from(counts) * unit);
        }
    }
}
