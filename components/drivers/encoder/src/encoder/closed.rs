//! Test of `encoder` against an ideal disc: at a position x in counts, A is on in quarters 1 and 2 of the cycle and B
//! in quarters 2 and 3. The expected counts, times and latched values follow from x.

#![expect(clippy::cast_possible_truncation, reason = "places are small")]

use super::Encoder;
use hal_bench::{Bench, Random};

/// Period of the fast function and of the slow function, in nanoseconds.
const BASE: i64 = 50_000;
const SERVO: i64 = 1_000_000;

struct Rig {
    bench: Bench,
    /// Present time, in nanoseconds.
    now: i64,
}

impl Rig {
    fn new() -> Self {
        let mut bench = Bench::new();
        bench.load::<Encoder>(&["names=x"]).unwrap();
        Self { bench, now: 0 }
    }

    /// Puts the disc at `x` and runs the fast function.
    fn see(&mut self, x: f64) {
        let quarter = (libm::floor(x) as i64).rem_euclid(4);
        self.bench.set("x.phase-A", matches!(quarter, 1 | 2));
        self.bench.set("x.phase-B", matches!(quarter, 2 | 3));
        self.look();
    }

    /// Runs the fast function, and after every servo period the slow one. Returns whether the slow one ran.
    fn look(&mut self) -> bool {
        self.bench.run("encoder.update-counters", BASE);
        self.now += BASE;
        let slow = self.now % SERVO == 0;
        if slow {
            self.bench.run("encoder.capture-position", SERVO);
        }
        slow
    }

    fn capture(&mut self) {
        while !self.look() {}
    }

    fn float(&self, name: &str) -> f64 {
        self.bench.get(&format!("x.{name}"))
    }

    fn int(&self, name: &str) -> i32 {
        self.bench.get(&format!("x.{name}"))
    }
}

/// Every quarter is a count, or one of four: where B falls with A false, an upward cycle begins.
#[test]
fn a_disc_that_turns_to_and_fro_is_counted() {
    for x4 in [true, false] {
        let mut random = Random::new(1);
        let mut rig = Rig::new();
        rig.bench.set("x.x4-mode", x4);
        let (mut x, mut cycles, mut speed) = (0_i64, 0, 1);
        for _ in 0..20_000 {
            if random.below(10) == 0 {
                speed = random.pick(&[-1, 0, 1]);
            }
            let next = x + speed;
            // One count per quadrature cycle: between the first quarter and the one before it.
            if x.rem_euclid(4) == 0 && next.rem_euclid(4) == 1 {
                cycles += 1;
            } else if x.rem_euclid(4) == 1 && next.rem_euclid(4) == 0 {
                cycles -= 1;
            }
            x = next;
            rig.see(x as f64);
            let wanted = if x4 { x } else { cycles };
            assert_eq!(i64::from(rig.int("rawcounts")), wanted, "x4 {x4} at {x}");
        }
    }
}

#[test]
fn counter_mode_counts_the_rising_edges_of_a() {
    let mut random = Random::new(2);
    let mut rig = Rig::new();
    rig.bench.set("x.counter-mode", true);
    let (mut a, mut count) = (false, 0);
    for _ in 0..5000 {
        let next = random.below(2) == 0;
        count += i32::from(next && !a);
        a = next;
        rig.bench.set("x.phase-A", a);
        rig.bench.set("x.phase-B", random.below(2) == 0);
        rig.look();
        assert_eq!(rig.int("rawcounts"), count);
    }
}

/// Returns the minimum time in nanoseconds between the counts that determine a speed: each is the last one before a
/// capture, up to one count away from the capture, and seen up to a fast period late.
fn span(speed: f64) -> f64 {
    f64::max(1e9 / speed, SERVO as f64 - 1e9 / speed) - BASE as f64
}

/// Returns whether enough captures had counts for a speed.
fn is_sure(now: i64, speed: f64) -> bool {
    now >= 4 * SERVO && now as f64 * 1e-9 * speed > 4.0
}

/// A constant speed is computed from whole counts and times that are up to one fast period late: over a span t, its
/// relative error is up to BASE/t. The interpolated position is off by the motion in that time, in total by less than
/// half a count.
#[test]
fn a_constant_speed() {
    for speed in [0.3, 3.0, 47.1, 500.0, 1234.5, 9000.0, -77.7, -8765.4] {
        let (scale, mut rig) = (40.0, Rig::new());
        rig.bench.set("x.position-scale", scale);
        // Below every speed used here, so that the encoder never counts as still.
        rig.bench.set("x.min-speed-estimate", 1e-3);
        let seconds = 5.0 / f64::abs(speed) + 1.0;
        let start = 0.5;
        while (rig.now as f64) < seconds * 1e9 {
            let x = start + speed * rig.now as f64 * 1e-9;
            rig.see(x);
            if rig.now % SERVO != 0 || !is_sure(rig.now, f64::abs(speed)) {
                continue;
            }
            let part = BASE as f64 / span(f64::abs(speed));
            let velocity = rig.float("velocity");
            let off = (velocity * scale / speed - 1.0).abs();
            assert!(off <= part, "{speed}: {velocity}, off by {off}, not {part}");
            assert!((rig.float("velocity-rpm") - velocity * 60.0).abs() <= 1e-12 * velocity.abs());
            let counts = rig.int("counts");
            assert_eq!(f64::from(counts), libm::floor(x), "{speed}");
            assert_eq!(rig.float("position"), f64::from(counts) * (1.0 / scale), "{speed}");
        }
    }
}

/// Between counts, the position advances with the speed. It is late by up to the fast period in which a count was seen,
/// and off by the speed's error since then; forward, it starts at the lower edge of a count, as the disc does.
#[test]
fn the_interpolated_position_is_within_half_a_count() {
    for speed in [47.1, 500.0, 1234.5, 2000.0] {
        let mut rig = Rig::new();
        rig.bench.set("x.min-speed-estimate", 1e-3);
        while rig.now < 2 * 1_000_000_000 {
            let x = 0.5 + speed * rig.now as f64 * 1e-9;
            rig.see(x);
            if rig.now % SERVO == 0 && is_sure(rig.now, speed) {
                // The slow function runs with the clock at the end of the fast one.
                let x = x + speed * BASE as f64 * 1e-9;
                let off = rig.float("position-interpolated") - x;
                assert!(off.abs() <= 0.5, "{speed}: off by {off} counts");
                let part = (1e9 / speed + BASE as f64) / span(speed);
                let late = speed * BASE as f64 * 1e-9 * (1.0 + part);
                assert!(off.abs() <= late + 1e-9, "{speed}: off by {off}, not {late}");
            }
        }
    }
}

/// In the time t since the last count, the disc has turned less than one count: the speed is at most 1/t counts, and 0
/// once t reaches `position-scale`/`min-speed-estimate`.
#[test]
fn a_speed_decays_when_nothing_is_counted() {
    let (scale, speed, least) = (10.0, 2000.0, 50.0);
    let mut rig = Rig::new();
    rig.bench.set("x.position-scale", scale);
    rig.bench.set("x.min-speed-estimate", least);
    let mut last = 0;
    for n in 0..4000 {
        if n % 10 == 0 && n < 2000 {
            last = rig.now;
        }
        rig.see(f64::from((n / 10).min(199)) + 0.5);
    }
    for _ in 0..2000 {
        rig.capture();
        let since = (rig.now - last) as f64 * 1e-9;
        let most = 1.0 / scale / since;
        let wanted = if since < scale / least { most.min(speed / scale) } else { 0.0 };
        let is = rig.float("velocity");
        assert!((is - wanted).abs() <= 1e-12 * speed, "{since} s: {is}, not {wanted}");
        if wanted == 0.0 {
            return;
        }
    }
    unreachable!("it never stands still");
}

/// An index sets the position to zero at exactly the count where it rose, however late the capture; a latch stores the
/// count at its edges.
#[test]
fn an_index_and_a_latch_note_their_count() {
    let mut random = Random::new(4);
    for _ in 0..50 {
        let mut rig = Rig::new();
        let speed = random.between(-0.9, 0.9);
        let (index, rise, fall) =
            (random.below(900) + 40, random.below(900) + 40, random.below(900) + 40);
        rig.bench.set("x.index-enable", true);
        rig.bench.set("x.latch-rising", true);
        rig.bench.set("x.latch-falling", random.below(2) == 0);
        let falling: bool = rig.bench.get("x.latch-falling");
        rig.capture();
        let count = |n: u64| libm::floor(0.5 + speed * n as f64) as i32;
        for n in 0..1000 {
            rig.bench.set("x.phase-Z", n >= index);
            // High between the two times, whichever comes first.
            let high = if rise < fall {
                (rise..fall).contains(&n)
            } else {
                !(fall..rise).contains(&n) && n >= 1
            };
            rig.bench.set("x.latch-input", high);
            rig.see(0.5 + speed * n as f64);
        }
        rig.capture();
        let zero = count(index);
        assert!(!rig.bench.get::<bool>("x.index-enable"));
        assert_eq!(rig.int("counts"), count(999) - zero);
        // The last stored count: that of the later edge, if it is enabled.
        let (first, second) = if rise < fall { (rise, fall) } else { (fall, rise) };
        let noted = match (rise < fall, falling) {
            (true, true) | (false, _) => second,
            (true, false) => first,
        };
        if rise != fall {
            assert_eq!(rig.int("counts-latched"), count(noted) - zero, "{rise} {fall} {falling}");
        }
    }
}

/// Gear with a number of teeth of which the last are missing, and the number of fast periods per tooth; the tooth shows
/// for half of them.
struct Gear {
    teeth: i32,
    missing: i32,
    tooth: i32,
}

impl Gear {
    /// Turns by tooth number n.
    fn turn(&self, rig: &mut Rig, n: i32) {
        for part in 0..self.tooth {
            let shows = n % self.teeth < self.teeth - self.missing && 2 * part < self.tooth;
            rig.bench.set("x.phase-A", shows);
            rig.look();
        }
    }

    /// Returns the count when tooth n has begun: missing teeth are counted with the first one after the gap.
    fn counted(&self, n: i32) -> i32 {
        n / self.teeth * self.teeth + (n % self.teeth).min(self.teeth - self.missing - 1) + 1
    }
}

/// Once the speed is known, a gap is distinguished from the pause between teeth if a pause of `missing-teeth` and a
/// half is longer than the time between two teeth. Each turn is then counted completely, with the index at the first
/// tooth.
#[test]
fn a_gear_with_missing_teeth_makes_whole_turns() {
    for (teeth, missing, tooth) in [(60, 2, 8), (36, 1, 10), (60, 2, 26), (24, 3, 4), (12, 1, 40)] {
        let mut rig = Rig::new();
        rig.bench.set("x.counter-mode", true);
        rig.bench.set("x.position-scale", f64::from(teeth));
        rig.bench.set("x.min-speed-estimate", 1e-3);
        rig.bench.set("x.index-enable", true);
        // A complete gear, at a quarter of the speed: half of its tooth lasts longer than a whole tooth later.
        let slow = Gear { teeth, missing: 0, tooth: 4 * tooth };
        (0..200).for_each(|n| slow.turn(&mut rig, n));
        let gear = Gear { teeth, missing, tooth };
        gear.turn(&mut rig, 0);
        rig.bench.set("x.missing-teeth", missing);
        let before = rig.int("rawcounts") - gear.counted(0);
        let last = 8 * teeth - 1;
        let speed = 1e9 / f64::from(tooth * teeth) / BASE as f64;
        for n in 1..=last {
            gear.turn(&mut rig, n);
            let is = rig.int("rawcounts") - before;
            assert_eq!(is, gear.counted(n), "{teeth}-{missing}, tooth {n}");
            // The speed holds in the gap as well: a whole number of fast periods gives it exactly.
            let velocity = rig.float("velocity");
            let off = (velocity / speed - 1.0).abs();
            assert!(
                n < teeth || off <= 1e-12,
                "{teeth}-{missing}, tooth {n}: {velocity}, not {speed}"
            );
        }
        rig.capture();
        assert!(!rig.bench.get::<bool>("x.index-enable"), "{teeth}-{missing}");
        // From the first tooth after the first gap.
        let turns = f64::from(gear.counted(last) - gear.counted(teeth)) / f64::from(teeth);
        assert!((rig.float("position") - turns).abs() <= 1e-12, "{teeth}-{missing}");
    }
}
