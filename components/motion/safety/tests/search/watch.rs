//! The invariants: what they remember of the events so far, and what must hold after each.
//!
//! They see orders, stops, inputs and what moves. They do not see the machine's own state, but for whether the amplifiers are on.

use crate::{model::Key, remote::Remote};
use hal_safety::{
    Ends, OrderKind, OrderSource, Parked, Reaction,
    lease::OnLoss,
    plant::{Act, Given, Plant, PlantMotion, Seen, Way},
};

/// Memory of the invariants.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    /// An enable order came, with all inputs as they should be, after the last e-stop, off, fault and gap.
    armed: bool,
    /// An order to move came after the last stop.
    ordered: bool,
    /// A soft fault has come, and the machine may still brake.
    ramps: bool,
    /// The path was paused, and nothing has resumed it.
    paused: bool,
    /// The spindle of the path was stopped, and nothing has turned it again.
    spindle_lost: bool,
    /// Sources of what moves.
    jog_by: OrderSource,
    way_by: OrderSource,
    home_by: OrderSource,
    /// A program was started under the lease, and has not ended.
    job: bool,
    /// The start of the program said that it goes on without the lease.
    goes_on: bool,
    /// The program has begun.
    begun: bool,
    /// The lease was lost with such a program, and nothing has ended the hold.
    held: bool,
    /// The remote jog in progress lasts while a button is held.
    pub(crate) held_jog: bool,
    /// A remote jog has arrived.
    pub(crate) remote_jog: bool,
    /// Cycles since the page answered last.
    pub(crate) quiet: u32,
    /// Cycles in which a held jog has gone on although it was not permitted.
    late: u32,
    /// In this step, a command has ended a hold.
    pub(crate) releases: bool,
}

impl Watch {
    /// A program is announced.
    pub(crate) fn start(&mut self, release: bool, said: Option<OnLoss>) {
        self.goes_on = said.map_or(self.job && self.goes_on, |said| said == OnLoss::Continue);
        self.job = true;
        if release {
            self.release();
        }
    }

    /// A person ends a hold.
    pub(crate) fn release(&mut self) {
        (self.held, self.releases) = (false, true);
    }

    /// Checks a cycle of motion.
    pub(crate) fn motion(
        &mut self,
        from: &Plant,
        act: Act,
        seen: Seen,
        to: &Plant,
    ) -> Option<&'static str> {
        self.remember(from, act, seen, to);
        self.begun |= self.job && is_program(to);
        let is_on = to.machine.is_on();
        let checks = [
            (is_on && !self.armed && !self.ramps, "on without an enable order after the last stop"),
            ((to.estop || !to.enable) && (is_on || to.moves()), "on or moving in an e-stop"),
            (!is_on && to.moves(), "moves without power"),
            (!is_on && (to.way != Way::None || to.paused), "a path outlives the power"),
            (to.is_driven() && !self.ordered, "moves without an order after the last stop"),
            (to.is_driven() && self.ramps, "goes on after a soft fault"),
            (
                to.way == Way::Moves && self.spindle_lost,
                "a feed runs on a spindle that was stopped",
            ),
            (to.way == Way::Moves && self.paused, "a paused path moves"),
            (to.way == Way::Moves && (to.hold || to.parked != Parked::No), "a held path moves"),
            (
                !from.is_driven() && to.is_driven() && !self.is_order_to_move(act),
                "something begins to move by itself",
            ),
            (!from.machine.is_on() && is_on && !is_enable(act), "goes on by itself"),
            (is_stop(act) && to.is_driven(), "goes on after a stop"),
            (is_cut(act, from) && (is_on || to.moves()), "power after what cuts it"),
            (
                act == Act::Settle && from.machine.is_on() && self.ramps && is_on,
                "a ramp never ends",
            ),
            (
                act == Act::Abort && to.way != Way::None && to.way != Way::Ends,
                "an abort leaves a path",
            ),
            (is_too_old(act) && !seen.refused, "an order from before a stop is taken"),
            (
                is_enable(act) && seen.taken && (from.estop || !from.enable),
                "an enable order is taken in an e-stop",
            ),
            (
                is_order(act) && from.is_driven() && from.machine.mode() != to.machine.mode(),
                "the mode changes in motion",
            ),
            (is_foreign(self, from, act, seen), "two sources move"),
            (!is_home_kept(from, act, to), "the home of a joint changes by itself"),
        ];
        let broken = checks.into_iter().find(|(is_broken, _)| *is_broken).map(|(_, what)| what);
        self.name_sources(act, seen);
        broken
    }

    /// Remembers what an event means for what may follow.
    fn remember(&mut self, from: &Plant, act: Act, seen: Seen, to: &Plant) {
        let soft = self.is_soft(from, act, seen);
        match act {
            Act::Order(OrderKind::Enable, _, Given::Now) if !from.estop && from.enable => {
                self.armed |= !self.ramps && !from.limit;
            }
            Act::Order(order, _, Given::Now) if begins(order) => self.ordered = true,
            // Such a move rests, until something resumes it.
            Act::Order(OrderKind::Move, _, Given::BeforePause) | Act::Wheel => self.ordered = true,
            _ => {}
        }
        if is_cut(act, from)
            || soft
            || matches!(act, Act::Off | Act::Gap | Act::Estop(true) | Act::Enable(false))
        {
            (self.armed, self.ordered) = (false, false);
        }
        if act == Act::Abort {
            self.ordered = false;
        }
        self.ramps = (self.ramps || soft) && to.machine.is_on();
        match act {
            Act::Pause => self.paused |= from.way != Way::None,
            Act::Order(OrderKind::Move, _, Given::BeforePause) => self.paused |= !seen.refused,
            Act::SpindleStop => {
                self.spindle_lost |= from.way != Way::None;
                self.paused |= self.spindle_lost;
            }
            Act::Order(OrderKind::Resume | OrderKind::Step, _, Given::Now) => {
                (self.paused, self.spindle_lost) = (false, false);
            }
            _ => {}
        }
        self.paused &= to.way != Way::None;
        self.spindle_lost &= to.way != Way::None;
    }

    /// Returns whether an event ends motion by a ramp.
    fn is_soft(&self, from: &Plant, act: Act, seen: Seen) -> bool {
        let is_on = from.machine.is_on() || self.armed;
        // The switch may also be closed as homing ends.
        let is_closed = act == Act::Limit(true) || from.limit && act != Act::Limit(false);
        // During homing, the switch is one of homing.
        let begins_home = matches!(act, Act::Order(OrderKind::Home, ..)) && !seen.refused;
        let fault = is_closed && !from.homes && !begins_home || act == Act::Following(false);
        is_on && fault && from.config.fault_stop == Reaction::Ramp
    }

    /// Returns whether an event is an order after which something may begin to move.
    fn is_order_to_move(&self, act: Act) -> bool {
        match act {
            Act::Order(order, _, given) => begins(order) && given == Given::Now,
            Act::Wheel | Act::Hold(false) => true,
            _ => self.releases,
        }
    }

    fn name_sources(&mut self, act: Act, seen: Seen) {
        let Act::Order(order, source, _) = act else {
            if act == Act::Wheel {
                self.jog_by = OrderSource::Local;
            }
            return;
        };
        match order {
            _ if seen.refused => {}
            OrderKind::Jog(_) => self.jog_by = source,
            OrderKind::Move => self.way_by = source,
            OrderKind::Home => self.home_by = source,
            _ => {}
        }
    }

    /// Checks a cycle of the remote side.
    pub(crate) fn remote(
        &mut self,
        was: &Remote,
        is: &Remote,
        from: &Plant,
        to: &Plant,
        is_long: bool,
    ) -> Option<&'static str> {
        let has_lost = was.words.number != 0 && is.words.number == 0 || was.allow && !is.allow;
        // What moves as the lease ends is held, and what moves until the end of the hold.
        if has_lost && self.job && !self.goes_on && !self.releases {
            self.held = true;
        }
        self.begun |= self.job && is_program(from);
        // What was announced has a time in which it must begin.
        if !is_program(to) && (self.begun || is_long) {
            (self.job, self.begun, self.goes_on) = (false, false, false);
        }
        self.held &= self.job;
        let permitted = is.words.number != 0 && is.allow && self.quiet <= Remote::jog_lasts();
        let goes_on = self.held_jog && self.remote_jog && to.jog == PlantMotion::Runs && !permitted;
        // It may arrive behind an edge of jog-stop, which has one in every other cycle.
        self.late = if goes_on { self.late + 1 } else { 0 };
        let is_late = self.late > 2;
        let checks = [
            (is.words.number != 0 && self.quiet > Remote::lease_lasts(), "a lease without beats"),
            (is_late, "a held jog without beats"),
            (self.held && to.way == Way::Moves, "a held program moves"),
        ];
        if is.words.number == 0 {
            self.quiet = 0;
        }
        checks.into_iter().find(|(is_broken, _)| *is_broken).map(|(_, what)| what)
    }

    /// Forgets what has ended.
    pub(crate) fn forget(&mut self, plant: &Plant) {
        self.releases = false;
        if plant.jog == PlantMotion::Rests {
            (self.jog_by, self.remote_jog, self.held_jog) = (OrderSource::default(), false, false);
        }
        if plant.way == Way::None {
            self.way_by = OrderSource::default();
        }
        if !plant.homes {
            self.home_by = OrderSource::default();
        }
        self.ordered &= plant.machine.is_on();
    }

    pub(crate) fn put(&self, key: &mut Key) {
        let bits = [
            self.armed,
            self.ordered,
            self.ramps,
            self.paused,
            self.spindle_lost,
            self.job,
            self.begun,
            self.goes_on,
            self.held,
            self.held_jog,
            self.remote_jog,
        ];
        bits.into_iter().for_each(|bit| key.put(2, bit.into()));
        [self.jog_by, self.way_by, self.home_by].into_iter().for_each(|by| key.put(3, by as u32));
        key.put(4, self.late);
        key.put(Remote::QUIET + 1, self.quiet);
    }
}

/// Returns whether an order begins motion.
const fn begins(order: OrderKind) -> bool {
    matches!(
        order,
        OrderKind::Jog(_) | OrderKind::Home | OrderKind::Move | OrderKind::Resume | OrderKind::Step
    )
}

const fn is_enable(act: Act) -> bool {
    matches!(act, Act::Order(OrderKind::Enable, _, Given::Now))
}

/// Returns whether a program may be in progress.
fn is_program(p: &Plant) -> bool {
    p.claimed || p.way != Way::None || p.moves()
}

const fn is_order(act: Act) -> bool {
    matches!(act, Act::Order(..))
}

/// Returns whether an act stops all motion.
const fn is_stop(act: Act) -> bool {
    matches!(act, Act::Off | Act::Abort | Act::Pause | Act::Estop(true) | Act::Enable(false))
}

/// Returns whether an act cuts the power in its cycle.
fn is_cut(act: Act, from: &Plant) -> bool {
    let drops = from.config.fault_stop == Reaction::Drop;
    match act {
        Act::Off | Act::Estop(true) | Act::Enable(false) | Act::Fault | Act::Gap => true,
        Act::Following(twice) => twice || drops,
        Act::Limit(true) => drops && !from.homes,
        _ => false,
    }
}

/// Returns whether an order was given before a stop that ends it.
fn is_too_old(act: Act) -> bool {
    match act {
        Act::Order(order, _, Given::BeforeStop) => order.ends() != Ends::Never,
        Act::Order(
            OrderKind::Jog(_) | OrderKind::Home | OrderKind::Resume | OrderKind::Step,
            _,
            Given::BeforePause,
        ) => true,
        _ => false,
    }
}

/// Returns whether an order of one source was taken while another one moves the machine.
fn is_foreign(watch: &Watch, from: &Plant, act: Act, seen: Seen) -> bool {
    let Act::Order(order, source, _) = act else { return false };
    if seen.refused || !matches!(order, OrderKind::Jog(_) | OrderKind::Home | OrderKind::Move) {
        return false;
    }
    let jogs =
        from.jog == PlantMotion::Runs && watch.jog_by != source && from.parked != Parked::Returns;
    let moves = from.way == Way::Moves && watch.way_by != source;
    let homes = from.homes && watch.home_by != source;
    jogs || moves || homes
}

/// Returns whether the joint is homed as before, or something has changed that.
fn is_home_kept(from: &Plant, act: Act, to: &Plant) -> bool {
    let is_lost_in_gap = act == Act::Gap && from.moves() && from.config.is_open_loop;
    if is_lost_in_gap && to.homed {
        return false;
    }
    let goes_off = from.machine.is_on() && !to.machine.is_on();
    let is_volatile = goes_off && from.config.is_volatile;
    match (from.homed, to.homed) {
        (true, true) => !is_volatile,
        (false, true) => act == Act::Settle && from.homes,
        (true, false) => {
            let order = matches!(act, Act::Order(OrderKind::Home | OrderKind::Unhome, ..));
            order || is_lost_in_gap || is_volatile
        }
        (false, false) => true,
    }
}
