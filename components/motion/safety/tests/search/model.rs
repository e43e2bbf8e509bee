//! State that is searched: the body with its machine, a remote operator, and the memory of the invariants.

use crate::{
    remote::{Remote, RemoteAct},
    watch::Watch,
};
use hal_safety::{
    Jog, Mode, OrderKind, OrderSource, Parked, SafetyMachine,
    plant::{Act, Config, Decide, Given, Plant, PlantMotion, Seen, Way},
};

/// An event of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Move {
    /// In motion.
    Act(Act),
    /// At the remote operator.
    Remote(RemoteAct),
}

/// The parts that decide: those of the product, or wrong ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts {
    pub(crate) decide: Decide,
    /// Changes the body after a cycle, for faults of what obeys.
    pub(crate) spoil: fn(before: &Plant, act: Act, after: &mut Plant),
    /// Changes the remote side after a cycle.
    pub(crate) spoil_remote: fn(before: &Remote, after: &mut Remote),
}

impl Default for Parts {
    fn default() -> Self {
        Self { decide: SafetyMachine::on, spoil: |_, _, _| (), spoil_remote: |_, _| () }
    }
}

/// A state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Model {
    pub(crate) plant: Plant,
    pub(crate) remote: Option<Remote>,
    pub(crate) watch: Watch,
}

impl Model {
    pub(crate) fn new(config: Config, has_remote: bool) -> Self {
        let remote = has_remote.then(Remote::new);
        Self { plant: Plant::new(config), remote, watch: Watch::default() }
    }

    /// Returns the state after an event, with the invariant that is broken; `None` if the event changes nothing by itself.
    pub(crate) fn step(
        mut self,
        next: Move,
        parts: &Parts,
    ) -> Option<(Self, Option<&'static str>)> {
        let before = self;
        let act = match next {
            Move::Act(act) => act,
            Move::Remote(act) => {
                let remote = self.remote.as_mut()?;
                remote.command(act, &mut self.watch)?;
                Act::Wait
            }
        };
        if matches!(next, Move::Act(_)) && is_void(&self.plant, act) {
            return None;
        }
        let mut broken = None;
        let mut check = |from: &Plant, act, seen, to: &Plant, watch: &mut Watch| {
            broken = broken.or(watch.motion(from, act, seen, to));
        };
        if let Some(remote) = &mut self.remote {
            let stops = remote.cycle(act, &mut self.watch);
            self.plant.hold = remote.words.hold;
            if stops {
                pass(&mut self, Act::JogStop(false), parts, &mut check);
            }
        }
        if let Some(remote) = &mut self.remote
            && core::mem::take(&mut remote.has_arrived)
        {
            let order = OrderKind::Jog(Jog::Joint);
            let seen = pass(
                &mut self,
                Act::Order(order, OrderSource::Remote, Given::Now),
                parts,
                &mut check,
            );
            self.watch.remote_jog |= !seen.refused;
        }
        pass(&mut self, act, parts, &mut check);
        if let Some(remote) = &mut self.remote {
            let aborts = remote.keep(&self.plant);
            if aborts {
                pass(&mut self, Act::Abort, parts, &mut check);
            }
        }
        if let (Some(was), Some(remote)) = (&before.remote, &mut self.remote) {
            (parts.spoil_remote)(was, remote);
            broken = broken.or(self.watch.remote(
                was,
                remote,
                &before.plant,
                &self.plant,
                act == Act::Settle,
            ));
            remote.normalise();
        }
        self.watch.forget(&self.plant);
        self.plant.epoch = before.plant.epoch;
        Some((self, broken))
    }

    /// Returns a number that tells this state from every other one with the same settings.
    pub(crate) fn key(&self) -> u128 {
        let mut key = Key(0);
        let p = &self.plant;
        key.put(3, p.machine.power() as u32);
        key.put(3, p.machine.mode() as u32);
        let (main, beside) = p.machine.sources();
        // The machine looks at its sources only while something moves or waits to move.
        let is_idle = p.jog == PlantMotion::Rests && p.way == Way::None && !p.homes;
        key.put(3, if is_idle { 0 } else { main as u32 });
        key.put(3, if p.jog == PlantMotion::Rests { 0 } else { beside as u32 });
        let bits = [
            p.by_wheel,
            p.spindle_lost,
            p.estop,
            p.enable,
            p.limit,
            p.hold,
            p.claimed,
            p.homes,
            p.homed,
            p.paused,
            p.strayed,
        ];
        bits.into_iter().for_each(|bit| key.put(2, bit.into()));
        key.put(3, p.jog as u32);
        key.put(5, p.way as u32);
        key.put(3, p.parked as u32);
        self.watch.put(&mut key);
        if let Some(remote) = &self.remote {
            remote.put(&mut key);
        }
        key.0
    }
}

/// Passes a cycle, and checks it.
fn pass(
    model: &mut Model,
    act: Act,
    parts: &Parts,
    check: &mut impl FnMut(&Plant, Act, Seen, &Plant, &mut Watch),
) -> Seen {
    let from = model.plant;
    let seen = model.plant.act(act, parts.decide);
    (parts.spoil)(&from, act, &mut model.plant);
    check(&from, act, seen, &model.plant, &mut model.watch);
    seen
}

/// Returns whether an act has no meaning in this state.
fn is_void(p: &Plant, act: Act) -> bool {
    match act {
        Act::Estop(on) => p.estop == on,
        Act::Enable(on) => p.enable == on,
        Act::Limit(on) => p.limit == on,
        Act::Hold(on) => p.hold == on,
        Act::Claim(on) => p.claimed == on,
        Act::Arrive => p.jog != PlantMotion::Runs && p.way != Way::Moves,
        Act::SpindleStop => p.way == Way::None || p.spindle_lost,
        Act::Wait => p.parked == Parked::No && !p.homes,
        _ => false,
    }
}

/// A number from values, each in its own bits.
#[derive(Debug)]
pub(crate) struct Key(u128);

impl Key {
    /// Appends a value, of which there are `count`.
    pub(crate) fn put(&mut self, count: u32, value: u32) {
        assert!(value < count && self.0 >> 110 == 0, "{value} of {count}");
        self.0 = self.0 << (u32::BITS - (count - 1).leading_zeros()) | u128::from(value);
    }
}

const fn order(order: OrderKind, source: OrderSource, given: Given) -> Move {
    Move::Act(Act::Order(order, source, given))
}

/// Orders that both searches have.
fn orders() -> Vec<Move> {
    use Given::{BeforePause, BeforeStop, Now};
    use OrderSource::{Local, Remote, Task};
    let (joint, axis) = (OrderKind::Jog(Jog::Joint), OrderKind::Jog(Jog::Axis));
    vec![
        order(OrderKind::Enable, Local, Now),
        order(OrderKind::Mode(Mode::Free), Local, Now),
        order(OrderKind::Mode(Mode::Teleop), Task, Now),
        order(OrderKind::Mode(Mode::Coord), Task, Now),
        order(OrderKind::Home, Local, Now),
        order(OrderKind::Home, Remote, Now),
        order(OrderKind::Unhome, Local, Now),
        order(joint, Local, Now),
        order(joint, Local, BeforeStop),
        order(axis, Local, Now),
        order(axis, Remote, Now),
        order(OrderKind::Move, Task, Now),
        order(OrderKind::Move, Task, BeforePause),
        order(OrderKind::Resume, Local, Now),
        order(OrderKind::Resume, Local, BeforePause),
        order(OrderKind::Step, Local, Now),
        Move::Act(Act::Off),
        Move::Act(Act::Abort),
        Move::Act(Act::Pause),
        Move::Act(Act::Estop(true)),
        Move::Act(Act::Estop(false)),
        Move::Act(Act::Fault),
        Move::Act(Act::Following(false)),
        Move::Act(Act::Gap),
        Move::Act(Act::Claim(true)),
        Move::Act(Act::Claim(false)),
        Move::Act(Act::Settle),
        Move::Act(Act::Arrive),
    ]
}

/// Events of motion without a remote operator.
pub(crate) fn alone() -> Vec<Move> {
    let mut all = orders();
    let joint = OrderKind::Jog(Jog::Joint);
    let more = [
        Act::Order(OrderKind::Enable, OrderSource::Local, Given::BeforeStop),
        Act::Order(OrderKind::Home, OrderSource::Local, Given::BeforePause),
        Act::Order(joint, OrderSource::Local, Given::BeforePause),
        Act::Order(joint, OrderSource::Remote, Given::Now),
        Act::Order(OrderKind::Move, OrderSource::Task, Given::BeforeStop),
        Act::Order(OrderKind::Resume, OrderSource::Local, Given::BeforeStop),
        Act::Order(OrderKind::Move, OrderSource::Local, Given::Now),
        Act::Order(OrderKind::Move, OrderSource::Remote, Given::Now),
        Act::Following(true),
        Act::Enable(false),
        Act::Enable(true),
        Act::Limit(true),
        Act::Limit(false),
        Act::Hold(true),
        Act::Hold(false),
        Act::Wheel,
        Act::JogStop(false),
        Act::JogStop(true),
        Act::Probe,
        Act::SpindleStop,
        Act::Wait,
    ];
    all.extend(more.map(Move::Act));
    all
}

/// Events of motion with a remote operator.
pub(crate) fn with_remote() -> Vec<Move> {
    let mut all = orders();
    all.extend(RemoteAct::ALL.map(Move::Remote));
    all
}
