//! A machine with a remote operator, whose pulses and beats take time.

use crate::{Remote, numbers};
use hal_bench::Bench;
use hal_component::{MotionRef, MotionToken};
use motion::Motmod;
use std::collections::VecDeque;
use trivkins::Trivkins;

/// Period of the servo thread in nanoseconds.
pub(super) const PERIOD: i64 = 1_000_000;
/// Velocity and acceleration of joints.
pub(super) const VELOCITY: f64 = 20.0;
pub(super) const ACCELERATION: f64 = 400.0;

/// The machine, and the way between the servo thread and the operator's page.
pub(super) struct Rig {
    pub(super) bench: Bench,
    pub(super) motion: MotionRef,
    pub(super) token: MotionToken,
    /// Cycles that a pulse takes to the page and back.
    pub(super) delay: usize,
    /// False after a cut: what is on the way back still arrives.
    pub(super) answers: bool,
    /// Cycles from one pulse that is sent to the next.
    pub(super) every: usize,
    way: VecDeque<(usize, u32)>,
    pub(super) cycle: usize,
}

impl Rig {
    pub(super) fn new(args: &[&str]) -> Self {
        numbers::begin_anew();
        let mut bench = Bench::new();
        bench.load::<Trivkins>(&["coordinates=xyz"]).unwrap();
        bench.load::<Motmod>(&["num_joints=3"]).unwrap();
        bench.load::<Remote>(args).unwrap();
        for n in 0..3 {
            let joint = format!("joint={n}");
            let args = [
                &*joint,
                "max-velocity=100",
                "max-acceleration=400",
                "min-limit=-5000",
                "max-limit=5000",
                "ferror=1",
                "min-ferror=1",
            ];
            bench.command("motion.configure", &args).unwrap();
        }
        bench.command("motion.configure", &["max-velocity=80"]).unwrap();
        let motion: MotionRef = bench.find();
        let token = motion.acquire("task").unwrap();
        let way = VecDeque::new();
        let mut rig =
            Self { bench, motion, token, delay: 10, answers: true, every: 20, way, cycle: 0 };
        rig.cycles(5);
        rig.bench.command("motion.enable", &[]).unwrap();
        rig.cycles(5);
        rig
    }

    /// Returns a machine whose lease has number 1, with beats.
    pub(super) fn leased(args: &[&str]) -> Self {
        let mut rig = Self::new(args);
        assert_eq!(rig.command("remote.take", "holder=ana"), Ok(vec!["lease=1".to_owned()]));
        rig.cycles(100);
        rig
    }

    pub(super) fn command(&self, name: &str, args: &str) -> Result<Vec<String>, String> {
        let args: Vec<&str> = args.split_whitespace().collect();
        self.bench.command(name, &args)
    }

    /// Runs the machine; pulses go to the page and back.
    pub(super) fn cycles(&mut self, n: usize) {
        for _ in 0..n {
            self.cycle += 1;
            while self.way.front().is_some_and(|(at, _)| *at <= self.cycle) {
                let beat = self.way.pop_front().map_or(0, |(_, n)| n);
                self.bench.set("remote.beat", beat);
            }
            self.bench.pass(PERIOD);
            self.bench.run("motion-command-handler", PERIOD);
            self.bench.run("remote", PERIOD);
            let stop: bool = self.bench.get("remote.jog-stop");
            self.bench.set("motion.jog-stop", stop);
            let hold: bool = self.bench.get("remote.hold");
            self.bench.set("motion.feed-inhibit", hold);
            self.bench.run("motion-controller", PERIOD);
            self.bench.work("motmod.planner", 64).unwrap();
            for joint in 0..3 {
                let cmd: f64 = self.bench.get(&format!("joint.{joint}.motor-pos-cmd"));
                self.bench.set(&format!("joint.{joint}.motor-pos-fb"), cmd);
            }
            if self.cycle.is_multiple_of(10) {
                self.bench.run("remote-keeper", 10 * PERIOD);
            }
            if self.answers && self.cycle.is_multiple_of(self.every) {
                let pulse: u32 = self.bench.get("remote.pulse");
                self.way.push_back((self.cycle + self.delay, pulse));
            }
        }
    }

    /// Loses the link, with all that is on its way.
    pub(super) fn lose(&mut self) {
        self.answers = false;
        self.way.clear();
    }

    pub(super) fn at(&self, joint: usize) -> f64 {
        self.bench.get(&format!("joint.{joint}.pos-cmd"))
    }

    pub(super) fn is(&self, pin: &str) -> bool {
        self.bench.get(&format!("remote.{pin}"))
    }

    /// Runs until joint 0 stands still; returns the number of cycles.
    pub(super) fn rest(&mut self) -> usize {
        for n in 0..20_000 {
            let before = self.at(0);
            self.cycles(1);
            if self.at(0) == before && self.motion.status().unwrap().in_position {
                return n;
            }
        }
        panic!("joint 0 does not come to rest");
    }
}
