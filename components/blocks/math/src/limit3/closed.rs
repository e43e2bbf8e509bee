//! Test of `limit3` against time-optimal moves: full acceleration, maximum speed, full braking.
//!
//! With speed v and acceleration a, a distance d from rest to rest takes 2·√(d/a), or d/v + v/a if d is above v²/a. The
//! limiter decides once per period T. It computes the stopping distance from a speed u·a·T as u²/2 + u/2, in units of
//! a·T², which is the displacement added by one period of acceleration. In whole periods the distance is (m + 1)(u -
//! m/2) for u = m + f, which is f·(1 - f)/2 more: the limiter overshoots its target by up to an eighth of a·T², and
//! then has to come back. The times are therefore measured to the last 4·a·T², which is two decisions wide.

#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "how many runs")]

use super::{Limit3, NEAR};
use hal_bench::{Bench, Random};

/// Distance from the target at which a time ends, as a multiple of a·T².
const LAST: f64 = 4.0;
/// Number of periods that a move may take longer: one in which neither full force is right, and one to arrive.
const LATE: f64 = 2.0;

/// Limiter at rest at 0.
struct Rig {
    bench: Bench,
    ns: i64,
    v: f64,
    a: f64,
    /// Last two positions.
    was: [f64; 2],
    /// Largest distance from 0 so far.
    far: f64,
}

impl Rig {
    fn new(ns: i64, v: f64, a: f64) -> Self {
        let mut bench = Bench::new();
        bench.load::<Limit3>(&[]).unwrap();
        bench.set("limit3.0.maxv", v);
        bench.set("limit3.0.maxa", a);
        Self { bench, ns, v, a, was: [0.0; 2], far: 0.0 }
    }

    /// Returns a random limiter whose a·T² is a thousand times the tolerance of the limiter.
    fn random(random: &mut Random) -> Self {
        let ns = random.pick(&[1_000_000, 2_000_000, 7_000_000]);
        Self::new(ns, random.scaled(0.1, 100.0), random.scaled(1.0, 1000.0))
    }

    fn dt(&self) -> f64 {
        self.ns as f64 * 1e-9
    }

    /// Returns the displacement added by one period of acceleration.
    fn grain(&self) -> f64 {
        self.a * self.dt() * self.dt()
    }

    fn at(&self) -> f64 {
        self.was[1]
    }

    fn speed(&self) -> f64 {
        (self.was[1] - self.was[0]) / self.dt()
    }

    /// Returns a bound of a cycle's rounding error: positions have a resolution of 2^-52 and are differenced twice.
    fn rounding(&self) -> f64 {
        8.0 * f64::EPSILON * self.far
    }

    /// Runs one cycle, and asserts that it keeps the limits.
    fn step(&mut self, to: f64) -> f64 {
        self.bench.set("limit3.0.in", to);
        self.bench.run("limit3.0", self.ns);
        let [before, last] = self.was;
        let now: f64 = self.bench.get("limit3.0.out");
        self.far = self.far.max(now.abs());
        let (moved, bent) = (now - last, now - 2.0 * last + before);
        let fast = self.v * self.dt();
        assert!(moved.abs() <= fast + self.rounding(), "{moved} is faster than {fast}");
        assert!(bent.abs() <= self.grain() + self.rounding(), "{bent} is above {}", self.grain());
        self.was = [last, now];
        now
    }

    /// Moves to `to`, which should take `wanted` seconds, and watches a while longer.
    fn go(&mut self, to: f64, wanted: f64) {
        let periods = wanted / self.dt();
        let mut last = 0;
        for n in 1..=periods as u32 + 100 {
            if (self.step(to) - to).abs() > LAST * self.grain() {
                last = n;
            }
        }
        let off = f64::from(last + 1) - periods;
        let (v, a) = (self.v, self.a);
        assert!(off <= LATE, "to {to} at {v} and {a} every {} ns: {off} periods late", self.ns);
        // Near the end it may overshoot: braking over 2·LAST and returning, both at full force, take four times √LAST
        // periods, plus the time lost by the limit v.
        let soon = 4.0 * libm::sqrt(LAST) + LAST * self.grain() / (v * self.dt()) + LATE;
        assert!(-soon <= off, "to {to} at {v} and {a} every {} ns: {off} periods late", self.ns);
    }

    /// Returns a bound of the overshoot.
    fn over(&self) -> f64 {
        self.grain() / 8.0 + NEAR + self.rounding()
    }
}

/// Returns the shortest time from rest to rest.
fn shortest(d: f64, v: f64, a: f64) -> f64 {
    if d <= v * v / a { 2.0 * libm::sqrt(d / a) } else { d / v + v / a }
}

/// Returns the shortest time from a speed w towards (negative: away from) a position d ahead. With the peak speed p =
/// √(a·d + w²/2) it is (p - w)/a + p/a; if p is above v, the part cut off is made up at v. If it is too late to stop,
/// the position is passed and returned to.
fn shortest_from(w: f64, d: f64, v: f64, a: f64) -> f64 {
    let stop = w * w.abs() / (2.0 * a);
    let (w, d) = if d >= stop { (w, d) } else { (-w, -d) };
    let peak = libm::sqrt(a * d + w * w / 2.0);
    let over = if peak > v { (peak - v) * (peak - v) / (a * v) } else { 0.0 };
    (2.0 * peak - w) / a + over
}

#[test]
fn a_triangle_and_a_trapezoid() {
    for (d, v, a, wanted) in [
        (5.0, 10.0, 20.0, 1.0),
        (20.0, 10.0, 20.0, 2.5),
        (0.1, 100.0, 1000.0, 0.02),
        (0.9, 0.5, 0.5, 2.8),
    ] {
        assert!((shortest(d, v, a) - wanted).abs() < 1e-12);
        Rig::new(1_000_000, v, a).go(d, wanted);
        Rig::new(1_000_000, v, a).go(-d, wanted);
    }
}

#[test]
fn moves_from_rest_take_the_shortest_time() {
    let mut random = Random::new(1);
    for _ in 0..300 {
        let mut rig = Rig::random(&mut random);
        let (v, a) = (rig.v, rig.a);
        let d = random.scaled(LAST * rig.grain(), 2.0 * v * v / a + 100.0 * v * rig.dt());
        rig.go(d, shortest(d, v, a));
    }
}

#[test]
fn moves_that_change_their_mind_take_the_shortest_time() {
    let mut random = Random::new(2);
    for _ in 0..300 {
        let mut rig = Rig::random(&mut random);
        let (v, a) = (rig.v, rig.a);
        let size = v * v / a + 100.0 * v * rig.dt();
        let first = random.between(-size, size);
        let runs = random.between(1.0, shortest(first.abs(), v, a) / rig.dt());
        for _ in 0..runs as u32 {
            rig.step(first);
        }
        let to = random.between(-size, size);
        let wanted = shortest_from(rig.speed(), to - rig.at(), v, a);
        rig.go(to, wanted);
    }
}

/// If it can stop in time, it overshoots its target by no more than the resolution of its decisions.
#[test]
fn goals_are_not_passed() {
    let mut random = Random::new(3);
    for _ in 0..300 {
        let mut rig = Rig::random(&mut random);
        rig.bench.set("limit3.0.smooth-steps", random.pick(&[0_u32, 2, 10]));
        let (v, a) = (rig.v, rig.a);
        let d = random.scaled(0.1 * rig.grain(), 2.0 * v * v / a);
        for _ in 0..(shortest(d, v, a) / rig.dt()) as u32 + 100 {
            let at = rig.step(d);
            assert!(at - d <= rig.over(), "{d} at {v} and {a} every {} ns: {}", rig.ns, at - d);
        }
    }
}

/// A ramp of speed s is met after (1 + √2)·s/a: the lag s²/2a of the acceleration is made up with up to s/√2 of extra
/// speed; if v does not allow that, with v - s for a while. From then on, the output equals the ramp.
#[test]
fn ramps_are_met_and_then_followed() {
    for (s, v, a) in [
        (5.0, 100.0, 20.0),
        (5.0, 6.0, 20.0),
        (-0.3, 1.0, 10.0),
        (-9.0, 9.5, 1000.0),
        (1.0, 3.0, 50.0),
    ] {
        let mut rig = Rig::new(1_000_000, v, a);
        let (fast, spare) = (f64::abs(s), v - f64::abs(s));
        let periods = (fast / a + shortest(fast * fast / (2.0 * a), spare, a)) / rig.dt();
        // A speed that grows once per period has a lag smaller by s·T/2, to be made up at v - s.
        let late = LATE + fast / (2.0 * spare);
        for n in 1..=periods as u32 + 1000 {
            let to = s * f64::from(n) * rig.dt();
            let at = rig.step(to);
            assert!((at - to) * s.signum() <= rig.over(), "{s} {v} {a}: {} ahead", at - to);
            let met = at == to;
            assert!(met || f64::from(n) <= periods + late, "{s} {v} {a}: not met in run {n}");
            assert!(!met || f64::from(n) >= periods - late, "{s} {v} {a}: met in run {n}");
        }
    }
}

/// The output stops at a limit as at any target, however far beyond it the input is.
#[test]
fn limits_are_goals() {
    for (max, v, a) in [(5.0, 10.0, 20.0), (20.0, 10.0, 20.0), (0.3, 4.0, 100.0)] {
        let mut rig = Rig::new(1_000_000, v, a);
        rig.bench.set("limit3.0.max", max);
        let periods = shortest(max, v, a) / rig.dt();
        for n in 1..=periods as u32 + 100 {
            let at = rig.step(1000.0);
            assert!(at <= max + rig.over(), "{at} is beyond {max}");
            let near = at >= max - LAST * rig.grain();
            assert!(near || f64::from(n) <= periods + LATE, "{max} {v} {a}: {at} in run {n}");
        }
    }
}

/// With enough steps the sawtooth around the target is smoothed away: the output comes to rest exactly there.
#[test]
fn smoothing_ends_at_rest() {
    let mut random = Random::new(4);
    for _ in 0..100 {
        let mut rig = Rig::random(&mut random);
        rig.bench.set("limit3.0.smooth-steps", 10_u32);
        let (v, a) = (rig.v, rig.a);
        let d = random.scaled(rig.grain(), 2.0 * v * v / a);
        for _ in 0..(shortest(d, v, a) / rig.dt()) as u32 + 100 {
            rig.step(d);
        }
        assert_eq!(rig.was, [d; 2], "at {v} and {a} every {} ns", rig.ns);
    }
}
