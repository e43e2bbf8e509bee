//! `anglejog`.
use crate::planner::Planner;
use core::f64::consts::PI;
use hal_component::{
    Builder, Component, Error, In, Messages, Out, Period, Touch, Update, abi::component_flags,
    to_s32,
};

/// Permitted values of `iscale-factor` while the component runs.
const FACTORS: core::ops::RangeInclusive<i32> = 10..=100_000;

/// Jogs two axes together along an angle, with one hand wheel.
pub(crate) struct Anglejog;

impl Component for Anglejog {
    const NAME: &'static str = "anglejog";
    const DOC: &'static str = "Jogs two axes together along an angle, with one hand wheel.\n\n\
        While `enable-in` is true, each count of the wheel moves a point by `scale-in` along a line at \
        `angle-degrees-in`, with limits of speed and acceleration. `coscounts` and `sincounts` \
        are the positions of the point along the two axes, in counts for `axis.L.jog-counts`; \
        `current-scale-out` is the distance per count, and goes to `axis.L.jog-scale` of both. \
        `enable-out` goes to `jog-enable`, the two fractions to `jog-accel-fraction`. `max-vel` \
        and `max-accel` should be no more than the slower of the two axes can do. A machine that \
        jogs joints as well needs the same links for them.\n\n\
        Angle, scale and `iscale-factor` are read while `enable-in` is false. Meanwhile the point \
        slows down and stops, and movements of the wheel are ignored. When `enable-in` becomes \
        true, the point stops at once until the wheel turns, and then continues with the speed \
        that it had. Until the wheel has turned once since, a new angle has no effect on the \
        counts.\n\n\
        A scale of 0 or NaN makes counts of -2147483648.\n\n\
        # Example\n\n\
        One count of 0.1 at 30 degrees: 0.0866 along the first axis, 0.05 along the second.\n\n\
        ```hal\n\
        loadrt anglejog\n\
        loadrt threads name1=servo period1=1000000\n\
        addf anglejog.0 servo\n\
        setp anglejog.0.scale-in 0.1\n\
        setp anglejog.0.angle-degrees-in 30\n\
        setp anglejog.0.max-vel 1\n\
        setp anglejog.0.max-accel 50\n\
        start\n\
        run 1ms\n\
        setp anglejog.0.enable-in 1\n\
        run 1ms\n\
        setp anglejog.0.counts-in 1\n\
        run 1s\n\
        getp anglejog.0.coscounts # -> 8660\n\
        getp anglejog.0.sincounts # -> 4999\n\
        getp anglejog.0.current-scale-out # -> 1e-05\n\
        getp anglejog.0.active # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let jog = Jog {
            enable_in: b.item("enable-in", "True lets the wheel move the axes.", false)?,
            counts_in: b.item("counts-in", "Counts of the wheel; they may wrap.", 0)?,
            angle_degrees_in: b.item(
                "angle-degrees-in",
                "Direction of the line, in degrees from the first axis to the second.",
                0.0,
            )?,
            iscale_factor: b.item(
                "iscale-factor",
                "Counts of the outputs per count of the wheel: the higher, the closer to the line. \
                While running, a value outside 10 to 100000 is ignored; the initial value is \
                always accepted.",
                10_000,
            )?,
            scale_in: b.item("scale-in", "Distance per count of the wheel, in units.", 0.0)?,
            max_vel: b.item(
                "max-vel",
                "Highest speed along the line, in units per second; NaN counts as 0.",
                0.0,
            )?,
            max_accel: b.item(
                "max-accel",
                "Highest acceleration along the line, in units per second squared; NaN stops the \
                point at once.",
                0.0,
            )?,
            accel_fraction_in: b.item(
                "accel-fraction-in",
                "Fraction of the axes' acceleration that jogs may use, 0 to 1.",
                1.0,
            )?,
            enable_out: b.item("enable-out", "`enable-in`.", false)?,
            current_scale: b.item("current-scale", "The scale in use, in units per count.", 0.0)?,
            current_scale_out: b.item(
                "current-scale-out",
                "Distance per count of the outputs, in units: the scale divided by the factor.",
                0.0,
            )?,
            coscounts: b.item("coscounts", "Counts for the first axis.", 0)?,
            sincounts: b.item("sincounts", "Counts for the second axis.", 0)?,
            cos_accel_fraction: b.item(
                "cos-accel-fraction",
                "`accel-fraction-in` times the cosine, for the first axis; it has the cosine's \
                sign.",
                0.0,
            )?,
            sin_accel_fraction: b.item(
                "sin-accel-fraction",
                "`accel-fraction-in` times the sine, for the second axis; it has the sine's sign.",
                0.0,
            )?,
            active: b.item("active", "True while a jog is under way.", false)?,
            current_angle_degrees: b.item(
                "current-angle-degrees",
                "The angle in use, in degrees.",
                0.0,
            )?,
            current_mag: b.item(
                "current-mag",
                "Position of the point along the line, in units.",
                0.0,
            )?,
            current_vel: b.item("current-vel", "Speed of the point, in units per second.", 0.0)?,
            messages: b.messages(),
            state: State::default(),
        };
        b.function("", "Reads the wheel's counts and moves the point.", jog)
    }
}

#[derive(Touch)]
struct Jog {
    enable_in: In<bool>,
    counts_in: In<i32>,
    angle_degrees_in: In<f64>,
    iscale_factor: In<i32>,
    scale_in: In<f64>,
    max_vel: In<f64>,
    max_accel: In<f64>,
    accel_fraction_in: In<f64>,
    enable_out: Out<bool>,
    current_scale: Out<f64>,
    current_scale_out: Out<f64>,
    coscounts: Out<i32>,
    sincounts: Out<i32>,
    cos_accel_fraction: Out<f64>,
    sin_accel_fraction: Out<f64>,
    active: Out<bool>,
    current_angle_degrees: Out<f64>,
    current_mag: Out<f64>,
    current_vel: Out<f64>,
    messages: Messages,
    #[state]
    state: State,
}

/// Activity of the point that moves along the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    /// Slows down or is at rest.
    #[default]
    Off,
    /// Waits for the wheel to leave these counts, in fine counts as the outputs use them.
    Waits(i32),
    /// Follows the wheel; the value is the position at wheel count 0, in fine counts.
    Follows(i32),
}

#[derive(Debug, Default)]
struct State {
    phase: Phase,
    point: Planner,
    /// Factor in use, once there is one.
    factor: Option<i32>,
    /// True if an invalid factor has been reported.
    told: bool,
    begun: bool,
    was_enabled: bool,
}

impl Update for Jog {
    fn update(&mut self, period: Period) {
        let enabled = self.enable_in.get();
        let before = *self.state.factor.get_or_insert(self.iscale_factor.get());
        self.settle(enabled, before);
        let s = &mut self.state;
        let begins = enabled && !s.was_enabled;
        s.was_enabled = enabled;
        // A new factor applies from the next cycle on.
        let counts = self.counts_in.get().wrapping_mul(before);
        let unit = self.current_scale_out.get();
        if begins {
            s.phase = Phase::Waits(counts);
            self.active.set(false);
        }
        match s.phase {
            Phase::Waits(at) if at == counts => return,
            Phase::Waits(at) => {
                s.phase = Phase::Follows(to_s32(s.point.at / unit).wrapping_sub(at));
            }
            Phase::Off | Phase::Follows(_) => {}
        }
        let target = match s.phase {
            Phase::Follows(start) if enabled => Some(f64::from(start.wrapping_add(counts)) * unit),
            _ => {
                s.phase = Phase::Off;
                None
            }
        };
        let (most, accel) = (self.max_vel.get(), self.max_accel.get());
        self.active.set(s.point.go(target, most, accel, period.secs()));
        self.current_mag.set(s.point.at);
        self.current_vel.set(s.point.speed);
        let turn = self.current_angle_degrees.get() * PI / 180.0;
        let (cos, sin) = (libm::cos(turn), libm::sin(turn));
        self.coscounts.set(to_s32(s.point.at * cos / unit));
        self.sincounts.set(to_s32(s.point.at * sin / unit));
        let fraction = self.accel_fraction_in.get();
        self.cos_accel_fraction.set(fraction * cos);
        self.sin_accel_fraction.set(fraction * sin);
    }
}

impl Jog {
    /// Updates angle, scale and factor, which are fixed while enabled.
    fn settle(&mut self, enabled: bool, before: i32) {
        self.enable_out.set(enabled);
        let s = &mut self.state;
        if enabled && s.begun {
            return;
        }
        s.begun = true;
        let (scale, wanted) = (self.scale_in.get(), self.iscale_factor.get());
        let mut factor = before;
        if FACTORS.contains(&wanted) {
            factor = wanted;
            s.told = false;
        } else if factor != wanted && !s.told {
            s.told = true;
            let text = "anglejog: iscale-factor is {}, and must be 10 to 100000; it stays {}";
            self.messages.warn(text, &[f64::from(wanted), f64::from(factor)]);
        }
        s.factor = Some(factor);
        self.current_scale.set(scale);
        self.current_angle_degrees.set(self.angle_degrees_in.get());
        self.current_scale_out.set(scale / f64::from(factor));
    }
}

#[cfg(test)]
mod tests {
    use super::Anglejog;
    use hal_bench::{Bench, trace::replay};

    const PINS: &str = "run anglejog.0
        in anglejog.0.enable-in anglejog.0.counts-in
        out anglejog.0.current-mag anglejog.0.current-vel anglejog.0.coscounts anglejog.0.active\n";

    fn table(settings: &str, rows: &str) -> String {
        format!("load anglejog\nwithin 1e-12\n{settings}\n{PINS}{rows}")
    }

    /// Settings are in thousandths so that the numbers are short: one wheel count is one unit, of 1000 fine counts.
    #[test]
    fn follows_the_wheel() {
        let settings = "set anglejog.0.scale-in 1
            set anglejog.0.iscale-factor 1000
            set anglejog.0.max-vel 2
            set anglejog.0.max-accel 1000";
        let rows = "0 7 | 0 0 0 0
            1 9 | 0 0 0 0
            1 9 | 0 0 0 0
            1 10 | 0.001 1 1 1
            1 . | 0.003 2 3 1
            1 . | 0.005 2 5 1
            0 . | 0.006 1 6 1
            0 50 | 0.006 0 6 0
            0 . | 0.006 0 6 0
            1 . | 0.006 0 6 0
            1 49 | 0.005 -1 5 1";
        assert_eq!(replay::<Anglejog>(&table(settings, rows)), 11);
    }

    #[test]
    fn stands_at_once_when_it_is_enabled_again() {
        let settings = "set anglejog.0.scale-in 1
            set anglejog.0.max-vel 9
            set anglejog.0.max-accel 1000";
        let rows = "0 0 | 0 0 . 0
            1 0 | 0 0 . 0
            1 1 | 0.001 1 . 1
            1 . | 0.003 2 . 1
            1 . | 0.006 3 . 1
            0 . | 0.008 2 . 1
            1 . | 0.008 2 . 0
            1 . | 0.008 2 . 0
            1 2 | 0.011 3 . 1";
        assert_eq!(replay::<Anglejog>(&table(settings, rows)), 9);
    }

    #[test]
    fn counts_of_the_wheel_wrap() {
        let mut bench = Bench::new();
        bench.load::<Anglejog>(&["names=wheel"]).unwrap();
        bench.set("wheel.scale-in", 0.5);
        bench.set("wheel.max-vel", 10.0);
        bench.set("wheel.max-accel", 100.0);
        bench.set("wheel.counts-in", i32::MAX);
        bench.run("wheel", 1_000_000);
        bench.set("wheel.enable-in", true);
        bench.run("wheel", 1_000_000);
        for (counts, is) in [(i32::MIN, 0.5), (i32::MIN + 2, 1.5), (i32::MAX - 1, -0.5)] {
            bench.set("wheel.counts-in", counts);
            for _ in 0..1000 {
                bench.run("wheel", 1_000_000);
            }
            assert!((bench.get::<f64>("wheel.current-mag") - is).abs() < 1e-6, "{counts}");
        }
    }

    #[test]
    fn angle_and_scale_are_taken_while_it_is_not_enabled() {
        let rows = "load anglejog
            within 1e-15
            run anglejog.0
            set anglejog.0.accel-fraction-in 0.5
            in anglejog.0.enable-in anglejog.0.angle-degrees-in anglejog.0.scale-in
            out anglejog.0.enable-out anglejog.0.current-angle-degrees anglejog.0.current-scale anglejog.0.current-scale-out anglejog.0.cos-accel-fraction anglejog.0.sin-accel-fraction
            0 60 2 | 0 60 2 0.0002 0.25 0.4330127018922193
            1 90 4 | 1 60 2 0.0002 0.25 0.4330127018922193
            0 180 inf | 0 180 inf inf . .
            0 nan 0 | 0 nan 0 0 . .";
        assert_eq!(replay::<Anglejog>(rows), 4);
    }

    #[test]
    fn a_scale_of_0_makes_the_lowest_counts() {
        let rows = "load anglejog
            run anglejog.0
            in anglejog.0.scale-in
            out anglejog.0.coscounts anglejog.0.sincounts
            0 | -2147483648 -2147483648
            nan | -2147483648 -2147483648
            inf | 0 0
            1 | 0 0";
        assert_eq!(replay::<Anglejog>(rows), 4);
    }

    #[test]
    fn a_factor_must_be_in_range() {
        let rows = "load anglejog
            set anglejog.0.scale-in 1
            run anglejog.0
            in anglejog.0.iscale-factor
            out anglejog.0.current-scale-out
            5 | 0.2
            6 | 0.2
            10 | 0.1
            9 | 0.1
            -1 | 0.1
            100000 | 0.00001
            100001 | 0.00001";
        assert_eq!(replay::<Anglejog>(rows), 7);
    }

    #[test]
    fn two_axes_follow_the_line() {
        let mut bench = Bench::new();
        bench.load::<Anglejog>(&["names=wheel"]).unwrap();
        bench.set("wheel.scale-in", 0.5);
        bench.set("wheel.angle-degrees-in", 200.0);
        bench.set("wheel.max-vel", 10.0);
        bench.set("wheel.max-accel", 100.0);
        bench.run("wheel", 1_000_000);
        bench.set("wheel.enable-in", true);
        bench.run("wheel", 1_000_000);
        bench.set("wheel.counts-in", 8);
        let unit = bench.get::<f64>("wheel.current-scale-out");
        let mut last = 0.0;
        for _ in 0..2000 {
            bench.run("wheel", 1_000_000);
            let speed = bench.get::<f64>("wheel.current-vel");
            assert!(speed <= 10.0 && (speed - last).abs() <= 0.1 + 1e-12);
            last = speed;
            let along = bench.get::<f64>("wheel.current-mag");
            for (pin, part) in [
                ("wheel.coscounts", -0.939_692_620_785_908_4),
                ("wheel.sincounts", -0.342_020_143_325_668_7),
            ] {
                let at = f64::from(bench.get::<i32>(pin)) * unit;
                assert!((at - along * part).abs() <= unit);
            }
        }
        assert!((bench.get::<f64>("wheel.current-mag") - 4.0).abs() < 1e-6);
        assert!(!bench.get::<bool>("wheel.active"));
    }
}
