//! Random walks of events through the real controller and through the body of `hal-safety`: both are equal after each event.
//!
//! A cycle has 20 ms, in which a joint changes its velocity by a fifth of its limit. What begins to move has time to reach its
//! velocity, and what brakes comes to rest in a known time, so that the body knows whether the joint moves without a position.

use crate::Motmod;
use hal_bench::{Bench, Random};
use hal_component::{
    MotionCommand, MotionEnd, MotionId, MotionRef, MotionStatus, MotionToken, StopEpoch,
    motion_flags as flags, motion_kind as kind, motion_source,
};
use hal_safety::{
    Jog, Mode, OrderKind, OrderSource, Parked, Reaction, SafetyMachine,
    plant::{Act, Config, Given, Plant, Way},
};
use std::collections::BTreeSet;
use toolchange::Iocontrol;
use trivkins::Trivkins;

/// Servo period in nanoseconds.
const PERIOD: i64 = 20_000_000;
/// Velocity of all motion; the joint reaches it in five cycles.
const VELOCITY: f64 = 10.0;
/// Cycles in which everything that brakes comes to rest, and everything that begins has its velocity.
const SETTLE: usize = 12;
/// Cycles that may pass while a joint brakes, or is homed, before the walk lets it settle.
const SHORT: u32 = 3;
/// Events of a walk.
const EVENTS: usize = 50;

/// The real controller with a joint that follows.
struct Real {
    bench: Bench,
    motion: MotionRef,
    token: MotionToken,
    base: StopEpoch,
    counts: i32,
    moves: f64,
    /// Distance of the feedback from the command.
    lag: f64,
}

impl Real {
    fn new(config: &Config) -> Self {
        let mut bench = Bench::new().with_interlock();
        bench.load::<Iocontrol>(&[]).unwrap();
        bench.load::<Trivkins>(&["coordinates=x"]).unwrap();
        bench.load::<Motmod>(&["num_joints=1"]).unwrap();
        let stop = if config.fault_stop == Reaction::Ramp { "ramp" } else { "drop" };
        let joint = format!(
            "joint=0 max-velocity={VELOCITY} max-acceleration=100 min-limit=-1e9 max-limit=1e9 ferror=1 \
             min-ferror=1 fault-stop={stop} volatile-home={}",
            config.is_volatile
        );
        bench.command("motion.configure", &joint.split(' ').collect::<Vec<_>>()).unwrap();
        bench.command("iocontrol.estop-reset", &[]).unwrap();
        bench.run("iocontrol", 10 * PERIOD);
        bench.set("iocontrol.0.emc-enable-in", true);
        bench.run("iocontrol", 10 * PERIOD);
        for wheel in ["joint.0", "axis.x"] {
            bench.set(&format!("{wheel}.jog-enable"), true);
            bench.set(&format!("{wheel}.jog-scale"), 1e6);
        }
        let motion: MotionRef = bench.find();
        let token = motion.acquire("task").unwrap();
        let base = motion.epoch();
        let mut real = Self { bench, motion, token, base, counts: 0, moves: 0.0, lag: 0.0 };
        real.cycles(3);
        real.base = real.motion.epoch();
        real
    }

    fn cycles(&mut self, n: usize) {
        for _ in 0..n {
            let cmd: f64 = self.bench.get("joint.0.motor-pos-cmd");
            self.bench.set("joint.0.motor-pos-fb", cmd - self.lag);
            self.bench.pass(PERIOD);
            self.bench.run("motion-command-handler", PERIOD);
            self.bench.run("motion-controller", PERIOD);
            self.bench.work("motmod.planner", 64).unwrap();
        }
    }

    fn push(&mut self, source: OrderSource, command: &MotionCommand) -> MotionId {
        let (token, source) = match source {
            OrderSource::Task => (self.token, motion_source::TASK),
            OrderSource::Local => (MotionToken::LOCAL, motion_source::LOCAL),
            OrderSource::Remote => (MotionToken::LOCAL, motion_source::REMOTE),
        };
        self.motion.push(token, &MotionCommand { source, ..*command }).unwrap()
    }

    fn order(&mut self, order: OrderKind, source: OrderSource, given: Given) -> MotionId {
        let new = MotionCommand::new;
        let jog = |flags| MotionCommand { flags, speed: VELOCITY, ..new(kind::JOG) };
        let all = |kind| MotionCommand { flags: flags::ALL, ..new(kind) };
        let command = match order {
            OrderKind::Enable => new(kind::ENABLE),
            OrderKind::Mode(mode) => MotionCommand { mode: mode as u32, ..new(kind::MODE) },
            OrderKind::Home => all(kind::HOME),
            OrderKind::Unhome => all(kind::UNHOME),
            OrderKind::Jog(Jog::Joint) => jog(flags::JOINT),
            OrderKind::Jog(Jog::Axis) => jog(flags::AXIS),
            OrderKind::Move => {
                self.moves += 1.0;
                let mut pose = [0.0; 9];
                pose[0] = 1e5 + self.moves;
                MotionCommand {
                    letters: 1,
                    pose,
                    speed_kind: 2,
                    speed: VELOCITY,
                    ..new(kind::MOVE)
                }
            }
            OrderKind::Resume => new(kind::RESUME),
            OrderKind::Step => new(kind::STEP),
            _ => panic!("{order:?} is in no walk"),
        };
        let now = self.motion.epoch();
        let epoch = match given {
            Given::Now => 0,
            Given::BeforeStop => StopEpoch { stops: now.stops - 1, ..now }.number(),
            Given::BeforePause => StopEpoch { pauses: now.pauses.wrapping_sub(1), ..now }.number(),
        };
        self.push(source, &MotionCommand { epoch, ..command })
    }

    /// Passes a cycle with an act; returns whether an order was refused.
    fn act(&mut self, act: Act) -> bool {
        let (mut order, mut pulse) = (None, None);
        match act {
            Act::Order(what, source, given) => order = Some(self.order(what, source, given)),
            Act::Off => drop(self.push(OrderSource::Local, &MotionCommand::new(kind::DISABLE))),
            Act::Abort => drop(self.push(OrderSource::Local, &MotionCommand::new(kind::ABORT))),
            Act::Pause => drop(self.push(OrderSource::Local, &MotionCommand::new(kind::PAUSE))),
            Act::Estop(on) => self.bench.set("iocontrol.0.emc-enable-in", !on),
            Act::Enable(on) => self.bench.set("motion.enable", on),
            Act::Limit(on) => self.bench.set("joint.0.pos-lim-sw-in", on),
            Act::Hold(on) => self.bench.set("motion.feed-inhibit", on),
            Act::Claim(on) => assert!(self.motion.claim(self.token, on)),
            Act::Fault => pulse = Some("joint.0.amp-fault-in"),
            Act::Following(twice) => self.lag = if twice { 3.0 } else { 1.5 },
            Act::Gap => self.bench.gap(),
            Act::Wheel => {
                self.counts += 1;
                self.bench.set("joint.0.jog-counts", self.counts);
                self.bench.set("axis.x.jog-counts", self.counts);
            }
            Act::JogStop(false) => pulse = Some("motion.jog-stop"),
            Act::JogStop(true) => pulse = Some("motion.jog-stop-immediate"),
            Act::Probe => pulse = Some("motion.probe-input"),
            Act::SpindleStop => panic!("no walk has a spindle"),
            Act::Wait | Act::Settle | Act::Arrive => {}
        }
        if let Some(pin) = pulse {
            self.bench.set(pin, true);
        }
        self.cycles(1);
        if let Some(pin) = pulse {
            self.bench.set(pin, false);
        }
        self.lag = 0.0;
        order.is_some_and(|id| matches!(self.motion.poll(id), MotionEnd::Failed(_)))
    }
}

/// State that the real and the model machine must have in common.
#[derive(Debug, PartialEq)]
struct Common {
    enabled: bool,
    mode: u32,
    homing: bool,
    homed: bool,
    paused: bool,
    away: bool,
    path: bool,
    stops: u32,
    pauses: u32,
    /// True if the joint moves; `None` while it is homed, where it may rest or brake.
    moves: Option<bool>,
    refused: bool,
}

fn real(real: &Real, refused: bool) -> Common {
    let s: MotionStatus = real.bench.snapshot("motion.status");
    let now = StopEpoch::of(s.epoch).unwrap();
    Common {
        enabled: s.enabled,
        mode: s.mode,
        homing: s.homing,
        homed: s.joint_homed[0],
        paused: s.paused,
        away: s.away,
        path: s.queue != 0,
        stops: now.stops - real.base.stops,
        pauses: now.pauses - real.base.pauses,
        moves: (!s.homing).then_some(s.joint_velocity[0] != 0.0),
        refused,
    }
}

fn model(p: &Plant, refused: bool) -> Common {
    Common {
        enabled: p.machine.is_on(),
        mode: p.machine.mode() as u32,
        homing: p.homes,
        homed: p.homed,
        paused: p.paused,
        away: p.parked != Parked::No,
        path: p.way != Way::None,
        stops: p.epoch.stops - 1,
        pauses: p.epoch.pauses,
        moves: (!p.homes).then_some(p.moves()),
        refused,
    }
}

/// Returns the next event.
fn pick(random: &mut Random, p: &Plant) -> Act {
    use OrderSource::{Local, Remote, Task};
    let given = match random.below(8) {
        0 if p.epoch.stops > 2 => Given::BeforeStop,
        1 if p.epoch.pauses > 0 => Given::BeforePause,
        _ => Given::Now,
    };
    let (joint, axis) = (OrderKind::Jog(Jog::Joint), OrderKind::Jog(Jog::Axis));
    let any = random.pick(&[Task, Local, Local, Remote]);
    if !p.machine.is_on() && random.below(2) == 0 {
        return Act::Order(OrderKind::Enable, Local, given);
    }
    match random.below(40) {
        0..2 => Act::Order(OrderKind::Enable, Local, given),
        2..4 => {
            let mode = random.pick(&[Mode::Free, Mode::Teleop, Mode::Coord]);
            Act::Order(OrderKind::Mode(mode), any, given)
        }
        4..6 => Act::Order(OrderKind::Home, any, given),
        6 => Act::Order(OrderKind::Unhome, Local, given),
        7..10 => Act::Order(joint, any, given),
        10..13 => Act::Order(axis, any, given),
        13..17 => Act::Order(OrderKind::Move, any, given),
        17..20 => Act::Order(OrderKind::Resume, any, given),
        20 => Act::Order(OrderKind::Step, any, given),
        21 => Act::Off,
        22 => Act::Abort,
        23..26 => Act::Pause,
        26 => Act::Estop(!p.estop),
        27 => Act::Enable(!p.enable),
        28 => Act::Limit(!p.limit),
        29 => Act::Hold(!p.hold),
        30 => Act::Claim(!p.claimed),
        31 => Act::Fault,
        32 => Act::Following(random.below(3) == 0),
        33..35 => Act::Wheel,
        35 => Act::JogStop(random.below(2) == 0),
        36 => Act::Probe,
        37 => Act::Gap,
        _ => Act::Wait,
    }
}

/// A walk; returns the states of the body that it visited.
fn walk(seed: u64, seen: &mut BTreeSet<Plant>) {
    let mut random = Random::new(seed);
    let config = Config {
        fault_stop: random.pick(&[Reaction::Drop, Reaction::Ramp]),
        needs_homed: false,
        is_volatile: random.below(2) == 0,
        is_open_loop: true,
    };
    let (mut body, mut rig) = (Plant::new(config), Real::new(&config));
    let mut trail = Vec::new();
    let before_all = body.epoch;
    // Cycles since something began to brake, or to be homed.
    let mut since = 0;
    for _ in 0..EVENTS {
        let before = body;
        let act = pick(&mut random, &body);
        if body.homes && matches!(act, Act::Limit(_)) {
            // The switch is one of homing, which looks at it only later.
            continue;
        }
        trail.push(act);
        let refused = body.act(act, SafetyMachine::on).refused;
        let is_refused = rig.act(act);
        let back = before.parked == Parked::Away
            && matches!(act, Act::Order(OrderKind::Resume, ..))
            && !refused;
        let comes_back = body.parked == Parked::Returns && before.parked == Parked::Returns;
        let begins = body.is_driven() && !before.is_driven() && !body.homes;
        since = if before.is_driven() && !before.homes { 0 } else { since + 1 };
        let must = begins && body.parked != Parked::Returns
            || before.homes && !body.homes
            || before.parked == Parked::Returns
            || back && body.parked != Parked::Returns
            || matches!(act, Act::Order(OrderKind::Move, ..))
            || since >= SHORT;
        // A return that was stopped brakes, and does not arrive.
        let returns = body.parked == Parked::Returns && body.is_driven();
        if returns && (comes_back || random.below(2) == 0) {
            trail.push(Act::Arrive);
            body.act(Act::Arrive, SafetyMachine::on);
            for _ in 0..2000 {
                if !rig.bench.snapshot::<MotionStatus>("motion.status").away {
                    break;
                }
                rig.cycles(1);
            }
            rig.cycles(SETTLE);
            since = 0;
        } else if !returns && (must || body.parked == Parked::Returns || random.below(3) == 0) {
            trail.push(Act::Settle);
            body.act(Act::Settle, SafetyMachine::on);
            rig.cycles(SETTLE);
            since = 0;
        }
        let (real, model) = (real(&rig, is_refused), model(&body, refused));
        // On its way back, an axis has a cycle in which it may not move yet.
        assert!(
            real == model
                || body.parked == Parked::Returns && real == Common { moves: real.moves, ..model },
            "seed {seed}: {trail:?}\n{real:?}\n{body:#?}\n{:?}",
            rig.bench.said()
        );
        let mut state = body;
        state.epoch = before_all;
        seen.insert(state);
    }
    let violations: u32 = rig.bench.get("motion.watch.violations");
    assert_eq!(violations, 0, "seed {seed}: {trail:?}\n{:?}", rig.bench.said());
}

fn walks(seeds: core::ops::Range<u64>) {
    let mut seen = BTreeSet::new();
    seeds.for_each(|seed| walk(seed, &mut seen));
}

#[test]
fn walks_of_the_controller_equal_those_of_the_body() {
    walks(0..2000);
}

#[test]
#[ignore = "minutes: cargo test -p motion --release a_hundred_thousand_walks -- --ignored --nocapture"]
fn a_hundred_thousand_walks_of_the_controller_equal_those_of_the_body() {
    walks(1_000_000..1_100_000);
}
