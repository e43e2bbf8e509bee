//! Random paths under the eyes of the watchman: overrides, holds, pauses, aborts, reversals, external offsets and wheel
//! jogs at random moments.

use super::{DT, LIMITS, Rig};
use hal_bench::Random;
use hal_component::MotionStatus;
use hal_watchman::{Limits, Report, Watchman};

/// A machine with random commands, and its judge.
struct Course {
    rig: Rig,
    random: Random,
    watch: Watchman<3>,
    /// End of the path that has been commanded, while it is known.
    at: Option<[f64; 3]>,
    line: u32,
    /// Number of the last segment that was reached, and of those reached so far.
    segment: u32,
    reached: u32,
    offset: i32,
    wheel: i32,
    aborts: u32,
    reversals: u32,
}

impl Course {
    fn new(seed: u64, jerk: [f64; 3]) -> Self {
        let mut rig = Rig::homed(&[]);
        for (n, jerk) in jerk.iter().enumerate().filter(|(_, j)| j.is_finite()) {
            rig.say(&format!("motion.configure joint={n} max-jerk={jerk}"));
        }
        rig.say("motion.configure max-feed-override=1.5");
        rig.say("motion.configure axis=x offset-av-ratio=0.2");
        for pin in ["axis.x.eoffset-scale", "axis.y.jog-scale"] {
            rig.bench.set(pin, 0.01);
        }
        rig.bench.set("axis.x.eoffset-enable", true);
        rig.bench.set("axis.y.jog-enable", true);
        rig.done("motion.move x=50 y=50 velocity=80");
        let mut limits = LIMITS.map(|(velocity, acceleration, ..)| Limits {
            velocity,
            acceleration,
            jerk: f64::INFINITY,
        });
        for (limits, jerk) in limits.iter_mut().zip(jerk) {
            limits.jerk = jerk * (1.0 + 1e-6);
        }
        let mut watch = Watchman::new(limits, DT, 300.0);
        watch.rest_at(&[0, 1, 2].map(|n| rig.joint(n, "motor-pos-cmd")));
        Self {
            rig,
            random: Random::new(seed),
            watch,
            at: Some([50.0, 50.0, 0.0]),
            line: 0,
            segment: 0,
            reached: 0,
            offset: 0,
            wheel: 0,
            aborts: 0,
            reversals: 0,
        }
    }

    fn status(&self) -> MotionStatus {
        self.rig.bench.snapshot("motion.status")
    }

    fn cycles(&mut self, n: u32) {
        for _ in 0..n {
            self.rig.cycle();
            let places = [0, 1, 2].map(|n| self.rig.joint(n, "motor-pos-cmd"));
            let s = self.status();
            assert!(self.watch.step(&places, s.line), "{:?}", self.watch.report());
            assert!(s.enabled, "{:?}", self.rig.bench.said());
            if s.segment > self.segment {
                self.segment = s.segment;
                self.reached += 1;
            }
        }
    }

    /// Commands a run of moves of one kind.
    fn moves(&mut self) {
        let Some(mut at) = self.at else { return };
        let r = &mut self.random;
        let mode = match r.below(4) {
            0 => "exact".to_owned(),
            1 => "stop".to_owned(),
            _ => format!("blend tolerance={}", r.pick(&[0.01, 0.1, 1.0])),
        };
        let feed = r.between(5.0, 120.0);
        let (kind, count) = (r.below(5), r.pick(&[1, 3, 10]));
        for _ in 0..count {
            let r = &mut self.random;
            self.line += 1;
            let line = self.line;
            let way = match kind {
                0 => 0.3,
                1 => 25.0,
                _ => 6.0,
            };
            let text = if kind == 4 && r.below(2) == 0 {
                let (angle, radius) =
                    (r.between(0.0, core::f64::consts::TAU), r.between(0.5, 12.0));
                let (x, y) = (at[0] + radius * angle.cos(), at[1] + radius * angle.sin());
                let z = r.between(-1.0, 1.0);
                at[2] = (at[2] + z).clamp_to(20.0);
                format!("motion.arc center-x={x} center-y={y} z={} clockwise={}", at[2], r.below(2))
            } else {
                for (n, place) in at.iter_mut().enumerate() {
                    let by = r.between(-way, way);
                    *place = if n == 2 {
                        (*place + 0.1 * by).clamp_to(20.0)
                    } else {
                        50.0 + (*place + by - 50.0).clamp_to(50.0)
                    };
                }
                format!("motion.move x={} y={} z={}", at[0], at[1], at[2])
            };
            let speed = if text.starts_with("motion.move") && r.below(4) == 0 {
                "rapid=1".to_owned()
            } else {
                format!("velocity={feed}")
            };
            self.rig.say(&format!("{text} {speed} mode={mode} line={line}"));
        }
        self.at = Some(at);
    }

    /// Disturbs the motion.
    fn event(&mut self) {
        match self.random.below(12) {
            0..=2 => {
                let scale = self.random.pick(&[0.0, 0.1, 0.6, 1.0, 1.5]);
                let which = self.random.pick(&["override", "rapid-override"]);
                let scale = if which == "override" || scale <= 1.0 { scale } else { 0.05 };
                self.rig.say(&format!("motion.feed {which}={scale}"));
            }
            3 => self.rig.bench.set("motion.feed-hold", true),
            4 => drop(self.rig.say("motion.pause")),
            5 => {
                drop(self.rig.try_say("motion.reverse"));
                self.reversals += 1;
            }
            6 => drop(self.rig.say("motion.step")),
            7 => {
                self.offset = self.random.pick(&[-200, -40, 0, 25, 160]);
                self.rig.bench.set("axis.x.eoffset-counts", self.offset);
            }
            8 => self.abort(),
            _ => self.calm(),
        }
    }

    fn calm(&mut self) {
        self.rig.say("motion.feed override=1 rapid-override=1");
        self.rig.say("motion.resume");
        self.rig.say("motion.forward");
        self.rig.bench.set("motion.feed-hold", false);
    }

    /// Aborts, and sometimes jogs an axis by its wheel before the next path.
    fn abort(&mut self) {
        self.rig.say("motion.abort");
        self.aborts += 1;
        self.rest();
        if self.random.below(2) == 0 {
            self.rig.say("motion.mode mode=teleop");
            self.cycles(2);
            let inside = self.status().pose[1] < 50.0;
            self.wheel += if inside { 300 } else { -300 };
            self.rig.bench.set("axis.y.jog-counts", self.wheel);
            self.cycles(200);
            self.rest();
        }
        let [x, y, z, ..] = self.status().pose;
        self.at = Some([x, y, z]);
    }

    fn rest(&mut self) {
        for _ in 0..200_000 {
            self.cycles(1);
            if self.rig.is("motion.in-position") {
                return;
            }
        }
        panic!("never rests: {:?}", self.status())
    }

    fn run(mut self, segments: u32) -> (Report, u32) {
        while self.reached < segments {
            if self.status().queue < 30 {
                self.moves();
            }
            let n = self.random.pick(&[3, 20, 60]);
            self.cycles(n);
            if self.random.below(5) == 0 {
                self.event();
            }
            // What the planner refuses, with an offset near a limit, ends the path there.
            if self.rig.is("motion.coord-error") {
                self.calm();
                self.rest();
                let [x, y, z, ..] = self.status().pose;
                self.at = Some([x, y, z]);
            }
        }
        self.calm();
        self.rest();
        assert!(self.aborts > segments / 200 && self.reversals > segments / 200);
        (*self.watch.report(), self.reached)
    }
}

trait ClampTo {
    fn clamp_to(self, size: f64) -> f64;
}

impl ClampTo for f64 {
    fn clamp_to(self, size: f64) -> f64 {
        if self > size {
            size
        } else if self < -size {
            -size
        } else {
            self
        }
    }
}

const NO_JERK: [f64; 3] = [f64::INFINITY; 3];

const JERK: [f64; 3] = [50_000.0, 20_000.0, 2_000.0];

#[test]
fn random_segments_keep_every_limit_of_jerk() {
    for seed in 200..203 {
        let (report, reached) = Course::new(seed, JERK).run(300);
        assert_eq!(report.violations, 0);
        assert!(reached >= 300 && report.jerk.ratio > 0.7, "{report:?}");
    }
}

#[test]
fn random_segments_keep_every_limit() {
    for seed in 0..4 {
        let (report, reached) = Course::new(seed, NO_JERK).run(400);
        assert_eq!(report.violations, 0);
        assert!(reached >= 400 && report.acceleration.ratio > 0.9, "{report:?}");
    }
}

/// Prints the segments, cycles and worst ratios.
#[expect(clippy::print_stdout, reason = "figures for the reader of the test")]
#[test]
#[ignore = "65 times the segments of `random_segments_keep_every_limit`, which every run has: cargo test -p motion segments -- --ignored --nocapture"]
fn a_hundred_thousand_random_segments_keep_every_limit() {
    let (mut segments, mut cycles) = (0, 0);
    let mut worst = [0.0_f64; 3];
    for seed in 100..150 {
        // Every other machine has limits of jerk.
        let jerk = if seed % 2 == 0 { NO_JERK } else { JERK };
        let (report, reached) = Course::new(seed, jerk).run(2100);
        assert_eq!(report.violations, 0, "seed {seed}");
        segments += reached;
        cycles += report.cycles;
        worst[0] = worst[0].max(report.velocity.ratio);
        worst[1] = worst[1].max(report.acceleration.ratio);
        worst[2] = worst[2].max(report.jerk.ratio);
    }
    println!("{segments} segments, {cycles} cycles, 0 violations, worst v, a and j {worst:?}");
    assert!(segments >= 100_000);
}
