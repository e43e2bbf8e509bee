//! `moveoff`.

use crate::{
    follower::Follower,
    waypoints::{EPSILON, MAX, MAX_TEST_WAYPOINTS, MAX_WAYPOINTS, Path, Phase},
};
use hal_component::{
    Builder, Clock, Component, Error, Gives, In, Messages, Out, Period, Takes, Touch, Update,
    abi::component_flags,
};
use std::sync::atomic::{AtomicI32, AtomicU8, AtomicU64, Ordering::Relaxed};

/// Default number of joints.
const DEFAULT: usize = 3;

/// Values of the order to `write-outputs`.
const FOLLOW: u8 = 2;
const FREEZE: u8 = 1;
const CLEAR: u8 = 0;

/// Offsets of joints, applied and removed while a program is paused.
pub(crate) struct Moveoff;

impl Component for Moveoff {
    const NAME: &'static str = "moveoff";
    const DOC: &'static str = include_str!("moveoff.md");
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = match b.personality() {
            0 => DEFAULT,
            n => usize::try_from(n).ok().filter(|n| *n <= MAX).ok_or_else(|| {
                Error::new(format!("personality is {n}, and must be 1 to {MAX} joints"))
            })?,
        };
        let (gives, takes) = b.shared(Order::default());
        let epsilon = "Largest offset that counts as 0, in units; at least 0.0001.";
        let epsilon: In<f64> = b.item("epsilon", epsilon, 0.0005)?;
        let applied = "True while an offset exceeds `epsilon`.";
        let offset_applied: Out<bool> = b.item("offset-applied", applied, false)?;
        let full = "True while no more waypoints fit, so that the offsets stop; until a waypoint \
            is passed on return, or no offset is applied.";
        let waypoint_limit: Out<bool> = b.item("waypoint-limit", full, false)?;
        let mut read = Read {
            power_on: b.item(
                "power-on",
                "True while the machine is on; otherwise all outputs are 0.",
                false,
            )?,
            move_enable: b.item("move-enable", "True requests offsets.", false)?,
            apply_offsets: b.item("apply-offsets", "True permits offsets.", false)?,
            backtrack_enable: b.item(
                "backtrack-enable",
                "True returns along the waypoints.",
                true,
            )?,
            epsilon,
            waypoint_threshold: b.item(
                "waypoint-threshold",
                "Distance of a joint from one waypoint to the next, in units.",
                0.02,
            )?,
            waypoint_sample_secs: b.item(
                "waypoint-sample-secs",
                "Shortest time from one waypoint to the next, in seconds; NaN counts as no \
                minimum.",
                0.02,
            )?,
            warning: b.item(
                "warning",
                "True if `apply-offsets` became false before the offsets had returned to 0.",
                false,
            )?,
            offset_applied,
            waypoint_limit,
            dbg_waypoint_limit_test: b.item(
                "dbg-waypoint-limit-test",
                "Reserves memory for 50 waypoints instead of 1000.",
                false,
            )?,
            inputs: Vec::new(),
            offsets: Vec::new(),
            order: gives,
            messages: b.messages(),
            clock: b.clock(),
            path: Path::default(),
        };
        let mut write = Write {
            joints: Vec::new(),
            offset_applied,
            waypoint_limit,
            waypoint_ct: b.item("waypoint-ct", "Number of waypoints.", 0)?,
            waypoint_percent_used: b.item(
                "waypoint-percent-used",
                "Percentage of the waypoints' memory in use.",
                0,
            )?,
            dbg_state: b.item(
                "dbg-state",
                "State at the beginning of the last run: 0 waiting, 1 applying offsets, 2 \
                returning.",
                0,
            )?,
            order: takes,
        };
        for i in 0..n {
            let offset: Out<f64> =
                b.item(&format!("offset-current-{i}"), "The joint's offset, in units.", 0.0)?;
            let wanted = b.item(
                &format!("offset-in-{i}"),
                "Requested offset, in units; NaN leaves the offset as it is.",
                0.0,
            )?;
            read.inputs.push(wanted);
            read.offsets.push(offset);
            write.joints.push(Joint {
                pos: b.item(&format!("pos-{i}"), "Position command of the joint, in units.", 0.0)?,
                fb: b.item(&format!("fb-{i}"), "Position feedback of the joint, in units.", 0.0)?,
                offset,
                pos_plus: b.item(
                    &format!("pos-plusoffset-{i}"),
                    "Position command with the offset, in units.",
                    0.0,
                )?,
                fb_minus: b.item(
                    &format!("fb-minusoffset-{i}"),
                    "Position feedback minus the offset of the previous run, in units.",
                    0.0,
                )?,
                vel: b.item(
                    &format!("offset-vel-{i}"),
                    "Highest speed of the offset, in units per second; 0 or less stops it at once.",
                    10.0,
                )?,
                accel: b.item(
                    &format!("offset-accel-{i}"),
                    "Highest acceleration of the offset, in units per second squared; 0 or less stops it at once.",
                    100.0,
                )?,
                min: b.item(&format!("offset-min-{i}"), "Lowest offset, in units.", -1e20)?,
                max: b.item(&format!("offset-max-{i}"), "Highest offset, in units; takes \
                    precedence over `offset-min`.", 1e20)?,
                follower: Follower::default(),
            });
        }
        b.function("read-inputs", "Decides on the targets of the offsets.", read)?;
        b.function("write-outputs", "Moves the offsets, and adds them.", write)
    }
}

/// Data that one function passes to the other.
#[derive(Debug, Default)]
struct Order {
    what: AtomicU8,
    phase: AtomicI32,
    epsilon: AtomicU64,
    count: AtomicI32,
    room: AtomicI32,
    targets: [AtomicU64; MAX],
}

#[derive(Touch)]
struct Read {
    power_on: In<bool>,
    move_enable: In<bool>,
    apply_offsets: In<bool>,
    backtrack_enable: In<bool>,
    epsilon: In<f64>,
    waypoint_threshold: In<f64>,
    waypoint_sample_secs: In<f64>,
    warning: Out<bool>,
    offset_applied: Out<bool>,
    waypoint_limit: Out<bool>,
    dbg_waypoint_limit_test: In<bool>,
    inputs: Vec<In<f64>>,
    offsets: Vec<Out<f64>>,
    order: Gives<Order>,
    messages: Messages,
    clock: Clock,
    #[state]
    path: Path,
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        let phase = self.path.phase as i32;
        self.warn();
        if !self.offset_applied.get() {
            self.path.count = 0;
            self.path.noted.1 = [0.0; MAX];
        }
        let what = if self.power_on.get() { self.step() } else { self.clear() };
        for (to, target) in self.order.targets.iter().zip(self.path.target) {
            to.store(target.to_bits(), Relaxed);
        }
        self.order.what.store(what, Relaxed);
        self.order.phase.store(phase, Relaxed);
        self.order.epsilon.store(self.path.epsilon.to_bits(), Relaxed);
        self.order.count.store(i32::try_from(self.path.count).unwrap_or(0), Relaxed);
        self.order.room.store(i32::try_from(self.path.room).unwrap_or(1), Relaxed);
    }
}

impl Read {
    fn warn(&mut self) {
        let warning = self.offset_applied.get() && !self.apply_offsets.get();
        if warning && !self.path.warned {
            let text = "moveoff: apply-offsets became false before the offsets were back";
            self.messages.error(text, &[]);
        }
        self.path.warned = warning;
        self.warning.set(warning);
    }

    fn clear(&mut self) -> u8 {
        self.path.phase = Phase::Waits;
        self.path.count = 0;
        self.path.target = [0.0; MAX];
        self.warning.set(false);
        self.offset_applied.set(false);
        CLEAR
    }

    fn step(&mut self) -> u8 {
        let enabled = self.move_enable.get() && self.apply_offsets.get();
        match self.path.phase {
            Phase::Waits => {
                let p = &mut self.path;
                let epsilon = self.epsilon.get();
                p.epsilon = if epsilon > EPSILON { epsilon } else { EPSILON };
                p.seconds = self.waypoint_sample_secs.get();
                p.threshold = self.waypoint_threshold.get();
                p.room = if self.dbg_waypoint_limit_test.get() {
                    MAX_TEST_WAYPOINTS
                } else {
                    MAX_WAYPOINTS
                };
                p.count = 0;
                if !enabled {
                    return CLEAR;
                }
                p.phase = Phase::Offsets;
                p.noted = (self.clock.now_ns(), [0.0; MAX]);
                self.aim();
                FOLLOW
            }
            Phase::Offsets => {
                if self.path.count < self.path.room {
                    self.note();
                }
                if enabled {
                    self.aim();
                } else {
                    self.turn_back();
                }
                let full = self.path.count >= self.path.room;
                self.waypoint_limit.set(full);
                if full { FREEZE } else { FOLLOW }
            }
            Phase::GoesBack => self.go_back(),
        }
    }

    fn go_back(&mut self) -> u8 {
        if !self.offset_applied.get() {
            self.clear();
            return CLEAR;
        }
        if self.path.count == 0 || !self.backtrack_enable.get() {
            self.path.target = [0.0; MAX];
        } else if self.is_there() {
            self.take();
            self.path.count -= 1;
        }
        FOLLOW
    }

    fn turn_back(&mut self) {
        self.path.phase = Phase::GoesBack;
        self.path.target = [0.0; MAX];
        if self.backtrack_enable.get() && self.path.count > 0 {
            self.path.count -= 1;
            self.take();
        }
    }

    /// Makes the waypoint after the last remaining one the target.
    fn take(&mut self) {
        let p = &mut self.path;
        if let Some(waypoint) = p.waypoints.get(p.count) {
            p.target = *waypoint;
        }
    }

    fn is_there(&self) -> bool {
        let p = &self.path;
        self.offsets.iter().zip(p.target).all(|(o, t)| (o.get() - t).abs() <= p.epsilon)
    }

    fn aim(&mut self) {
        for (to, wanted) in self.path.target.iter_mut().zip(&self.inputs) {
            *to = wanted.get();
        }
    }

    /// Records a waypoint if enough time has passed and the offsets have moved far enough.
    fn note(&mut self) {
        let now = self.clock.now_ns();
        let p = &mut self.path;
        let mut here = [0.0; MAX];
        for (to, offset) in here.iter_mut().zip(&self.offsets) {
            *to = offset.get();
        }
        let (when, last) = p.noted;
        let far = here.iter().zip(last).any(|(a, b)| (a - b).abs() > p.threshold);
        let soon = (now.wrapping_sub(when) as f64 * 1e-9) < p.seconds;
        if far && !soon {
            if let Some(waypoint) = p.waypoints.get_mut(p.count) {
                *waypoint = here;
                p.count += 1;
            }
            p.noted = (now, here);
        }
    }
}

#[derive(Touch)]
struct Joint {
    pos: In<f64>,
    fb: In<f64>,
    offset: Out<f64>,
    pos_plus: Out<f64>,
    fb_minus: Out<f64>,
    vel: In<f64>,
    accel: In<f64>,
    min: In<f64>,
    max: In<f64>,
    #[state]
    follower: Follower,
}

#[derive(Touch)]
struct Write {
    joints: Vec<Joint>,
    offset_applied: Out<bool>,
    waypoint_limit: Out<bool>,
    waypoint_ct: Out<i32>,
    waypoint_percent_used: Out<i32>,
    dbg_state: Out<i32>,
    order: Takes<Order>,
}

impl Update for Write {
    fn update(&mut self, period: Period) {
        let what = self.order.what.load(Relaxed);
        let epsilon = f64::from_bits(self.order.epsilon.load(Relaxed));
        let mut applied = false;
        for (joint, target) in self.joints.iter_mut().zip(&self.order.targets) {
            if what == CLEAR {
                joint.follower = Follower::default();
                joint.offset.set(0.0);
            }
            let before = joint.offset.get();
            if what == FOLLOW {
                let wanted = f64::from_bits(target.load(Relaxed));
                let (min, max) = (joint.min.get(), joint.max.get());
                // If the limits contradict each other, the maximum wins.
                let target = if wanted > max {
                    max
                } else if wanted < min {
                    min
                } else {
                    wanted
                };
                let (vel, accel) = (joint.vel.get(), joint.accel.get());
                joint.offset.set(joint.follower.go(target, vel, accel, period.secs()));
            }
            if what == FREEZE {
                joint.follower.stop();
            }
            let offset = joint.offset.get();
            // The order of operations is LinuxCNC's, because it affects rounding.
            joint.fb_minus.set((joint.fb.get() - offset) + (offset - before));
            joint.pos_plus.set(joint.pos.get() + offset);
            applied |= offset.abs() > epsilon;
        }
        self.offset_applied.set(applied);
        // Without an offset, there is no path back.
        let count = if applied { self.order.count.load(Relaxed) } else { 0 };
        if !applied {
            self.waypoint_limit.set(false);
        }
        self.dbg_state.set(self.order.phase.load(Relaxed));
        self.waypoint_ct.set(count);
        self.waypoint_percent_used.set(100 * count / self.order.room.load(Relaxed).max(1));
    }
}

#[cfg(test)]
mod tests {
    use super::Moveoff;
    use hal_bench::{Bench, trace::replay};

    const SERVO: i64 = 1_000_000;

    fn on(settings: &[(&str, f64)]) -> Bench {
        let mut bench = Bench::new();
        bench.load::<Moveoff>(&["names=m", "personality=2"]).unwrap();
        for pin in ["power-on", "move-enable", "apply-offsets"] {
            bench.set(&format!("m.{pin}"), true);
        }
        for (pin, value) in settings {
            bench.set(&format!("m.{pin}"), *value);
        }
        bench
    }

    fn run(bench: &mut Bench, cycles: usize) {
        for _ in 0..cycles {
            bench.run("m.read-inputs", SERVO);
            bench.run("m.write-outputs", SERVO);
        }
    }

    fn offset(bench: &Bench, joint: usize) -> f64 {
        bench.get(&format!("m.offset-current-{joint}"))
    }

    #[test]
    fn as_recorded() {
        assert!(replay::<Moveoff>(include_str!("../traces/moveoff.txt")) > 250);
    }

    /// LinuxCNC 2.9 differs here: it stays at a waypoint while the pin is false.
    #[test]
    fn without_waypoints_at_one_of_them_it_goes_straight_back() {
        let mut bench = on(&[("offset-in-0", 1.0), ("waypoint-sample-secs", 0.0)]);
        run(&mut bench, 500);
        bench.set("m.move-enable", false);
        run(&mut bench, 2);
        assert!(bench.get::<i32>("m.waypoint-ct") > 10);
        bench.set("m.backtrack-enable", false);
        run(&mut bench, 300);
        assert_eq!(offset(&bench, 0), 0.0);
    }

    #[test]
    fn waypoints_are_no_sooner_than_their_time() {
        for (secs, most) in [(0.05, 10), (0.1, 5), (0.0, 500), (f64::NAN, 500)] {
            let settings = [
                ("offset-in-0", 1000.0),
                ("waypoint-sample-secs", secs),
                ("waypoint-threshold", -1.0),
                ("epsilon", 0.0001),
            ];
            let mut bench = on(&settings);
            for _ in 0..501 {
                bench.pass(SERVO);
                run(&mut bench, 1);
            }
            // The first cycle begins and records nothing.
            assert_eq!(bench.get::<i32>("m.waypoint-ct"), most, "{secs}");
        }
    }

    #[test]
    fn offsets_come_and_go_within_their_limits() {
        // Half of 0.2 at 100 units per second squared, then the same time to stop; the same on the way back.
        let rows = "load moveoff names=m personality=1
            period 10000000
            within 1e-12
            set m.backtrack-enable 0
            run m.read-inputs m.write-outputs
            in m.power-on m.move-enable m.apply-offsets m.offset-in-0 m.pos-0 m.fb-0
            out m.dbg-state m.offset-current-0 m.pos-plusoffset-0 m.fb-minusoffset-0 m.offset-applied m.warning
            0 1 1 0.04 5 5 | 0 0 5 5 0 0
            1 1 0 0.04 5 5 | 0 0 5 5 0 0
            1 0 1 0.04 5 5 | 0 0 5 5 0 0
            1 1 1 0.04 5 5 | 0 0.01 5.01 5 1 0
            1 1 1 .    6 6 | 1 0.03 6.03 5.99 1 0
            1 1 1 .    6 6 | 1 0.04 6.04 5.97 1 0
            1 1 1 .    6 6 | 1 0.04 6.04 5.96 1 0
            1 1 0 .    6 6 | 1 0.03 6.03 5.96 1 1
            1 1 1 .    6 6 | 2 0.01 6.01 5.97 1 0
            1 0 1 .    6 6 | 2 0 6 5.99 0 0
            1 0 1 .    6 6 | 2 0 6 6 0 0
            1 0 1 .    6 6 | 0 0 6 6 0 0";
        assert_eq!(replay::<Moveoff>(rows), 12);
    }

    #[test]
    fn the_machine_off_takes_all_offsets_at_once() {
        let mut bench = on(&[("offset-in-0", 1.0)]);
        run(&mut bench, 500);
        assert_eq!(offset(&bench, 0), 1.0);
        bench.set("m.power-on", false);
        run(&mut bench, 1);
        assert_eq!(offset(&bench, 0), 0.0);
        assert!(!bench.get::<bool>("m.offset-applied"));
    }

    #[test]
    fn bounds() {
        let bounds = |min, max| {
            let mut bench =
                on(&[("offset-in-0", 1.0), ("offset-min-0", min), ("offset-max-0", max)]);
            run(&mut bench, 1000);
            offset(&bench, 0)
        };
        assert_eq!(bounds(-0.5, 0.5), 0.5);
        assert_eq!(bounds(1.5, 2.5), 1.5);
        assert_eq!(bounds(2.0, 0.5), 0.5);
        assert_eq!(bounds(f64::NAN, f64::NAN), 1.0);
    }

    /// Moves joint 0, then joint 1. Returns the position of the first joint when the second is half way back.
    fn corner(backtrack: bool) -> f64 {
        let mut bench = on(&[("offset-in-0", 1.0), ("waypoint-sample-secs", 0.0)]);
        bench.set("m.backtrack-enable", backtrack);
        run(&mut bench, 500);
        bench.set("m.offset-in-1", 1.0);
        run(&mut bench, 500);
        assert!(bench.get::<i32>("m.waypoint-ct") > 20);
        bench.set("m.move-enable", false);
        while offset(&bench, 1) > 0.5 {
            run(&mut bench, 1);
        }
        let there = offset(&bench, 0);
        run(&mut bench, 5000);
        assert_eq!((offset(&bench, 0), offset(&bench, 1)), (0.0, 0.0));
        assert_eq!(bench.get::<i32>("m.waypoint-ct"), 0);
        there
    }

    #[test]
    fn the_way_back_goes_by_the_waypoints() {
        assert!((corner(true) - 1.0).abs() < 0.001);
        assert!((corner(false) - 0.5).abs() < 0.1);
    }

    #[test]
    fn without_waypoints_in_the_middle_it_goes_straight_back() {
        let mut bench = on(&[("offset-in-0", 1.0)]);
        run(&mut bench, 500);
        bench.set("m.move-enable", false);
        run(&mut bench, 20);
        bench.set("m.backtrack-enable", false);
        run(&mut bench, 500);
        assert_eq!(offset(&bench, 0), 0.0);
    }

    #[test]
    fn no_room_for_waypoints_freezes_the_offset_and_not_the_joint() {
        let mut bench = on(&[
            ("offset-in-0", 1000.0),
            ("waypoint-sample-secs", 0.0),
            ("waypoint-threshold", 0.0),
        ]);
        bench.set("m.dbg-waypoint-limit-test", true);
        run(&mut bench, 100);
        assert!(bench.get::<bool>("m.waypoint-limit"));
        assert_eq!(bench.get::<i32>("m.waypoint-percent-used"), 100);
        let frozen = offset(&bench, 0);
        bench.set("m.pos-0", 7.0);
        run(&mut bench, 100);
        assert_eq!(offset(&bench, 0), frozen);
        assert_eq!(bench.get::<f64>("m.pos-plusoffset-0"), 7.0 + frozen);
        bench.set("m.apply-offsets", false);
        run(&mut bench, 5000);
        assert!(!bench.get::<bool>("m.waypoint-limit"));
        assert_eq!(offset(&bench, 0), 0.0);
    }

    #[test]
    fn what_stood_still_goes_on_to_its_target() {
        let mut bench = on(&[("offset-in-0", 1.0)]);
        run(&mut bench, 60);
        bench.set("m.offset-vel-0", 0.0);
        run(&mut bench, 10);
        let stood = offset(&bench, 0);
        assert!(0.0 < stood && stood < 1.0);
        run(&mut bench, 10);
        assert_eq!(offset(&bench, 0), stood);
        bench.set("m.offset-vel-0", 10.0);
        run(&mut bench, 500);
        assert_eq!(offset(&bench, 0), 1.0);
    }

    #[test]
    fn odd_numbers_pass() {
        let pins = ["offset-in-0", "offset-vel-0", "offset-accel-0", "pos-0", "fb-0", "epsilon"];
        let more = ["offset-min-0", "offset-max-0", "waypoint-threshold", "waypoint-sample-secs"];
        for pin in pins.iter().chain(&more) {
            for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN] {
                let mut bench = on(&[("offset-in-0", 1.0)]);
                run(&mut bench, 20);
                let name = format!("m.{pin}");
                let usual: f64 = bench.get(&name);
                bench.set(&name, odd);
                run(&mut bench, 5);
                assert!(offset(&bench, 0).is_finite(), "{pin} {odd}");
                bench.set(&name, usual);
                // At 10 units per second, a distant offset takes too long to remove: start again.
                bench.set("m.power-on", false);
                run(&mut bench, 1);
                bench.set("m.power-on", true);
                run(&mut bench, 500);
                assert_eq!(offset(&bench, 0), 1.0, "{pin} {odd}");
                assert_eq!(bench.get::<f64>("m.pos-plusoffset-0"), 1.0, "{pin} {odd}");
            }
        }
        let mut bench = on(&[("offset-in-0", 1.0)]);
        run(&mut bench, 20);
        for pin in ["offset-in-0", "offset-vel-0", "offset-accel-0"] {
            let name = format!("m.{pin}");
            let usual: f64 = bench.get(&name);
            bench.set(&name, f64::NAN);
            run(&mut bench, 5);
            bench.set(&name, usual);
        }
        run(&mut bench, 500);
        assert_eq!(offset(&bench, 0), 1.0, "without beginning again");
    }

    #[test]
    fn refusals() {
        for n in ["10", "-1"] {
            let mut bench = Bench::new();
            let said = bench.load::<Moveoff>(&[&format!("personality={n}")]).unwrap_err();
            assert!(said.contains(n) && said.contains('9'), "{said}");
            assert!(bench.names().is_empty());
        }
    }
}
