//! `gantry` against the geometry of a beam: joints that follow their command at once, with a switch each that is pressed from a
//! place on. A joint that reaches its switch waits there for the last of the first two, and from then on all are as far from
//! their switches as they came to them. Steps are whole numbers of 1/64, which single precision keeps exactly.

use super::Gantry;
use hal_component::bench::{Bench, Random};

const STEP: f64 = 1.0 / 64.0;

struct Beam {
    bench: Bench,
    /// Where each joint's switch begins.
    switches: Vec<f64>,
    /// 1 searches upward, -1 downward.
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

    /// A period in which the command moves by so many steps.
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

/// At n steps a period, a joint is pressed after as many periods as its switch is away; a period later it waits.
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
                // It waits from its switch on until the last one is there.
                let waited = now.min(last) - now.min(*pressed);
                assert_eq!(beam.offset(i), waited * n * STEP * way, "{away:?} {i} in {period}");
                assert_eq!(beam.place(i), beam.command - beam.offset(i));
            }
        }
        // Back off: all come with the command, and the axis is where the joint that came last is, without its offset.
        let offsets = [beam.offset(0), beam.offset(1)];
        let late = usize::from(periods[1] > periods[0]);
        while beam.command != 0.0 {
            beam.go(-way);
            assert_eq!([beam.offset(0), beam.offset(1)], offsets);
        }
        assert!(!beam.is("home") && !beam.is("limit"));
        assert_eq!(offsets[late], 0.0);
        let fb: f64 = beam.bench.get("gantry.0.position-fb");
        // What is fed back is a period old.
        assert_eq!(fb, beam.command + way * STEP, "{away:?}");
        // Joints that lag differ: it is the last one that tells.
        for (i, lag) in [3.0, 5.0].iter().enumerate() {
            beam.bench.set(&format!("gantry.0.joint.{i:02}.pos-fb"), beam.place(i) - lag);
        }
        beam.bench.run("gantry.0.read", 1_000_000);
        let fb: f64 = beam.bench.get("gantry.0.position-fb");
        assert_eq!(fb, beam.command - [3.0, 5.0][late], "{away:?}");
    }
}

/// Away from the switches, at rest, or without a search nobody waits.
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
