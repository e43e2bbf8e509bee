//! Test of `gantry` against the geometry of a beam: joints follow their command at once, and each has a switch that is
//! pressed from some position on. A joint that reaches its switch waits there for the later of the first two joints;
//! from then on, all joints keep the distances from their switches. Steps are multiples of 1/64, which single precision
//! holds exactly.

use super::Gantry;
use hal_bench::{Bench, Random};

const STEP: f64 = 1.0 / 64.0;

struct Beam {
    bench: Bench,
    /// Position of each joint's switch.
    switches: Vec<f64>,
    /// Direction of the search: 1 upward, -1 downward.
    way: f64,
    command: f64,
}

impl Beam {
    fn new(switches: &[f64], way: f64) -> Self {
        let mut bench = Bench::new();
        bench.load::<Gantry>(&[&format!("personality={}", switches.len())]).unwrap();
        bench.set("gantry.0.search-vel", 3.0 * way);
        Self { bench, switches: switches.to_vec(), way, command: 0.0 }
    }

    fn place(&self, joint: usize) -> f64 {
        self.bench.get(&format!("gantry.0.joint.{joint:02}.pos-cmd"))
    }

    fn offset(&self, joint: usize) -> f64 {
        self.bench.get(&format!("gantry.0.joint.{joint:02}.offset"))
    }

    /// Runs one period in which the command moves by this number of steps.
    fn go(&mut self, steps: f64) {
        for (i, switch) in self.switches.iter().enumerate() {
            let at = self.place(i);
            self.bench.set(&format!("gantry.0.joint.{i:02}.pos-fb"), at);
            let pressed = (at - switch) * self.way >= 0.0;
            self.bench.set(&format!("gantry.0.joint.{i:02}.home"), pressed);
        }
        self.bench.run("gantry.0.read", 1_000_000);
        self.command += steps * STEP;
        self.bench.set("gantry.0.position-cmd", self.command);
        self.bench.run("gantry.0.write", 1_000_000);
    }

    fn is(&self, pin: &str) -> bool {
        self.bench.get(&format!("gantry.0.{pin}"))
    }
}

/// At n steps per period, a joint reaches its switch after as many periods as the switch is away, and waits from the
/// next period on.
#[test]
fn a_beam_is_squared_at_its_switches() {
    let mut random = Random::new(1);
    for _ in 0..200 {
        let way = random.pick(&[-1.0, 1.0]);
        let n = random.pick(&[1.0, 2.0, 3.0]);
        let away: Vec<f64> = (0..2).map(|_| (random.below(300) + 1) as f64).collect();
        let switches: Vec<f64> = away.iter().map(|steps| steps * STEP * way).collect();
        let mut beam = Beam::new(&switches, way);
        let periods: Vec<f64> = away.iter().map(|steps| libm::ceil(steps / n)).collect();
        let last = periods[0].max(periods[1]);
        for period in 1..=400 {
            beam.go(n * way);
            let now = f64::from(period);
            let (any, all) = (now > periods[0].min(periods[1]), now > last);
            assert_eq!((beam.is("limit"), beam.is("home")), (any, all), "{away:?} in {period}");
            for (i, pressed) in periods.iter().enumerate() {
                // The joint waits from its own switch until the last one is reached.
                let waited = now.min(last) - now.min(*pressed);
                assert_eq!(beam.offset(i), waited * n * STEP * way, "{away:?} {i} in {period}");
                assert_eq!(beam.place(i), beam.command - beam.offset(i));
            }
        }
        // Backing off: all joints follow the command, and the axis is at the last joint's position without its offset.
        let offsets = [beam.offset(0), beam.offset(1)];
        let late = usize::from(periods[1] > periods[0]);
        while beam.command != 0.0 {
            beam.go(-way);
            assert_eq!([beam.offset(0), beam.offset(1)], offsets);
        }
        assert!(!beam.is("home") && !beam.is("limit"));
        assert_eq!(offsets[late], 0.0);
        let fb: f64 = beam.bench.get("gantry.0.position-fb");
        // The feedback is one period old.
        assert_eq!(fb, beam.command + way * STEP, "{away:?}");
        // With different lags, the last joint's position counts.
        for (i, lag) in [3.0, 5.0].iter().enumerate() {
            beam.bench.set(&format!("gantry.0.joint.{i:02}.pos-fb"), beam.place(i) - lag);
        }
        beam.bench.run("gantry.0.read", 1_000_000);
        let fb: f64 = beam.bench.get("gantry.0.position-fb");
        assert_eq!(fb, beam.command - [3.0, 5.0][late], "{away:?}");
    }
}

/// No joint waits when away from the switches, at rest, or without a search.
#[test]
fn only_a_search_waits() {
    for (search, steps) in [(-3.0, 1.0), (3.0, -1.0), (0.0, 1.0), (0.0, -1.0), (-3.0, 0.0)] {
        let mut beam = Beam::new(&[0.0, 100.0], 1.0);
        beam.bench.set("gantry.0.search-vel", search);
        for _ in 0..50 {
            beam.go(steps);
            assert_eq!([beam.offset(0), beam.offset(1)], [0.0; 2], "{search} {steps}");
        }
    }
}
