//! The plainest body that obeys a machine: one joint, its jogs, its homing, and a path of one long move.
//!
//! It has no positions. Something moves, brakes or rests, and an [`Act`] says how much time passes. The deciding function is an
//! argument of [`Plant::act`], so that a test can put a wrong one in its place.

mod obey;

use crate::{
    Answer, Epoch, Event, Facts, Mode, OrderKind, OrderSource, Parked, Power, Reaction,
    SafetyMachine, Trouble,
};

/// A deciding function: [`SafetyMachine::on`], or a wrong one.
pub type Decide = fn(&mut SafetyMachine, Event, &Facts) -> Answer;

/// Motion of joints and axes by themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PlantMotion {
    /// Joints and axes rest.
    #[default]
    Rests,
    /// Joints and axes go to a target.
    Runs,
    /// Joints and axes brake.
    Brakes,
}

/// State of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Way {
    /// There is none.
    #[default]
    None,
    /// A move waits at rest.
    Waits,
    /// The axes move along it.
    Moves,
    /// The axes brake, and will rest on it.
    Brakes,
    /// The axes brake, and the path ends then.
    Ends,
}

/// Settings of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Config {
    /// Reaction to a limit switch and to a following error.
    pub fault_stop: Reaction,
    /// True if axes move only when the joint is homed.
    pub needs_homed: bool,
    /// True if the home is lost without power.
    pub is_volatile: bool,
    /// True if nothing measures the joint's place.
    pub is_open_loop: bool,
}

/// Time in which an order was given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Given {
    /// In this cycle.
    #[default]
    Now,
    /// Before the last stop.
    BeforeStop,
    /// After the last stop, and before the last pause.
    BeforePause,
}

/// Event of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// An order arrives.
    Order(OrderKind, OrderSource, Given),
    /// A stop is commanded.
    Off,
    /// A stop is commanded.
    Abort,
    /// A stop is commanded.
    Pause,
    /// The e-stop comes or goes.
    Estop(bool),
    /// The enable input changes.
    Enable(bool),
    /// The limit switch closes or opens.
    Limit(bool),
    /// The feed is held, or no longer.
    Hold(bool),
    /// The owner of motion claims it, or no longer.
    Claim(bool),
    /// A fault lasts for this cycle.
    Fault,
    /// A following error lasts for this cycle; true: twice its limit.
    Following(bool),
    /// The process stood still.
    Gap,
    /// A jog wheel turns.
    Wheel,
    /// The pin that stops jogs rises; true: at once.
    JogStop(bool),
    /// The probe trips.
    Probe,
    /// Somebody stops the spindle that was turned for the path.
    SpindleStop,
    /// A cycle passes.
    Wait,
    /// Time passes in which all that brakes comes to rest, and homing ends.
    Settle,
    /// Jogs and the path arrive.
    Arrive,
}

/// The body with its machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Plant {
    /// Machine that decides.
    pub machine: SafetyMachine,
    /// Settings.
    pub config: Config,
    /// E-stop.
    pub estop: bool,
    /// Enable input.
    pub enable: bool,
    /// Limit switch.
    pub limit: bool,
    /// Hold of the feed.
    pub hold: bool,
    /// Claim of the owner of motion.
    pub claimed: bool,
    /// Stop epoch.
    pub epoch: Epoch,
    /// Jogs, and joints that brake after homing.
    pub jog: PlantMotion,
    /// True if a jog wheel drives that motion.
    pub by_wheel: bool,
    /// True while the joint is being homed.
    pub homes: bool,
    /// True if the joint is homed.
    pub homed: bool,
    /// The path.
    pub way: Way,
    /// True if the path is paused.
    pub paused: bool,
    /// Place of the axes relative to a paused path.
    pub parked: Parked,
    /// True if the spindle of the path was stopped, and nothing has turned it again.
    pub spindle_lost: bool,
    /// True if the axes have moved since they left the path.
    pub strayed: bool,
    /// True if the epoch has risen in this cycle because motion stopped by itself.
    has_risen: bool,
}

/// Effect of an act.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// True if an order was refused, or failed in its cycle.
    pub refused: bool,
    /// True if the machine took an order, whatever became of it in this cycle.
    pub taken: bool,
}

impl Plant {
    /// Returns a machine that is off, with all inputs as they should be.
    #[must_use]
    pub const fn new(config: Config) -> Self {
        Self {
            machine: SafetyMachine::OFF,
            config,
            estop: false,
            enable: true,
            limit: false,
            hold: false,
            claimed: false,
            epoch: Epoch { stops: 1, pauses: 0 },
            jog: PlantMotion::Rests,
            by_wheel: false,
            homes: false,
            homed: false,
            way: Way::None,
            paused: false,
            parked: Parked::No,
            spindle_lost: false,
            strayed: false,
            has_risen: false,
        }
    }

    /// Returns whether anything moves.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.jog != PlantMotion::Rests || self.homes || !matches!(self.way, Way::None | Way::Waits)
    }

    /// Returns whether anything moves other than to brake.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.jog == PlantMotion::Runs || self.homes || self.way == Way::Moves
    }

    /// Passes a cycle with an act.
    pub fn act(&mut self, act: Act, decide: Decide) -> Seen {
        self.has_risen = false;
        let mut seen = Seen::default();
        let mut fault = None;
        let mut arrives = false;
        match act {
            Act::Off => self.command(Event::Off, decide),
            Act::Abort => self.command(Event::Abort, decide),
            Act::Pause => self.command(Event::Pause, decide),
            Act::Estop(on) => {
                if on && !self.estop {
                    self.tell(Event::Cut, decide);
                }
                self.estop = on;
            }
            Act::Enable(on) => {
                if !on && self.enable {
                    self.tell(Event::Cut, decide);
                }
                self.enable = on;
            }
            Act::Limit(on) => self.limit = on,
            Act::Hold(on) => self.hold = on,
            Act::Claim(on) => self.claimed = on,
            Act::Fault => fault = Some(Trouble::Hard),
            Act::Following(twice) => {
                fault = Some(Trouble::Following { by: self.config.fault_stop, twice });
            }
            Act::Gap => {
                self.tell(Event::Gap, decide);
            }
            Act::JogStop(at_once) => {
                self.tell(Event::JogStop { at_once }, decide);
            }
            Act::Probe => {
                self.tell(Event::Probe, decide);
            }
            Act::SpindleStop => self.spindle_lost = self.way != Way::None,
            Act::Settle => self.settle(),
            Act::Arrive => arrives = self.arrive(),
            Act::Order(order, source, given) => seen = self.order(order, source, given, decide),
            Act::Wheel | Act::Wait => {}
        }
        self.guard(fault, decide);
        if act == Act::Wheel && self.machine.mode() != Mode::Coord {
            let answer = self.tell(Event::Wheel, decide);
            // A wheel does not take over what something else moves.
            if answer.refused.is_none() && (self.jog == PlantMotion::Rests || self.by_wheel) {
                self.run_jog();
                self.by_wheel = true;
            }
        }
        self.advance(arrives, decide);
        if matches!(act, Act::Order(OrderKind::Enable, ..)) {
            seen.refused |= !self.machine.is_on();
        }
        seen
    }

    /// Obeys a commanded stop, which raises the epoch whatever the machine does.
    fn command(&mut self, stop: Event, decide: Decide) {
        if stop == Event::Pause {
            self.epoch.pauses = self.epoch.pauses.wrapping_add(1);
        } else {
            self.epoch.stops = self.epoch.stops.wrapping_add(1);
        }
        self.tell(stop, decide);
    }

    fn order(
        &mut self,
        order: OrderKind,
        source: OrderSource,
        given: Given,
        decide: Decide,
    ) -> Seen {
        let fails = Seen { refused: true, taken: true };
        let Epoch { stops, pauses } = self.epoch;
        let given = match given {
            Given::Now => self.epoch,
            Given::BeforeStop => Epoch { stops: stops.wrapping_sub(1), pauses },
            Given::BeforePause => Epoch { stops, pauses: pauses.wrapping_sub(1) },
        };
        let was_on = self.machine.is_on();
        let answer = self.tell(Event::Order(order, source, given), decide);
        if answer.refused.is_some() {
            return Seen { refused: true, taken: false };
        }
        match order {
            OrderKind::Enable if !was_on => {
                self.leave();
                if self.machine.mode() != Mode::Free && !self.has_place() {
                    self.tell(Event::NoPlace, decide);
                }
            }
            OrderKind::Home => {
                (self.homes, self.homed, self.jog) = (true, false, PlantMotion::Rests);
            }
            OrderKind::Unhome => self.homed = false,
            OrderKind::Jog(_) => self.run_jog(),
            // The path takes no moves while it brakes to its end.
            OrderKind::Move if self.way == Way::Ends => return fails,
            OrderKind::Move if self.way == Way::None => self.way = Way::Waits,
            OrderKind::Step if self.way == Way::None => return fails,
            OrderKind::Step => (self.paused, self.spindle_lost) = (false, false),
            // It turns the spindle again.
            OrderKind::Resume => self.spindle_lost = false,
            _ => {}
        }
        self.paused |= answer.rests_late;
        Seen { refused: false, taken: true }
    }

    fn run_jog(&mut self) {
        (self.jog, self.by_wheel) = (PlantMotion::Runs, false);
        self.strayed |= self.parked == Parked::Away;
    }

    const fn has_place(&self) -> bool {
        self.homed || !self.config.needs_homed
    }

    /// Reports the causes to switch off that this cycle has.
    fn guard(&mut self, fault: Option<Trouble>, decide: Decide) {
        if !self.machine.is_on() {
            return;
        }
        let cut = (self.estop || !self.enable).then_some(Trouble::Hard);
        // During homing, the limit switch is one of homing.
        let limit = (self.limit && !self.homes).then_some(Trouble::Limit(self.config.fault_stop));
        for trouble in [cut, limit, fault].into_iter().flatten() {
            self.tell(Event::Trouble(trouble), decide);
        }
    }

    /// All that brakes comes to rest, and homing ends.
    fn settle(&mut self) {
        if self.jog == PlantMotion::Brakes {
            self.jog = PlantMotion::Rests;
        }
        match self.way {
            Way::Brakes => self.way = Way::Waits,
            Way::Ends => self.leave(),
            Way::None | Way::Waits | Way::Moves => {}
        }
        if self.homes && !self.limit {
            (self.homes, self.homed) = (false, true);
        }
    }

    /// Ends all that moves at its target; returns whether axes arrive at the path that they had left.
    fn arrive(&mut self) -> bool {
        let is_back = self.parked == Parked::Returns && self.jog == PlantMotion::Runs;
        if self.jog == PlantMotion::Runs {
            self.jog = PlantMotion::Rests;
        }
        if self.way == Way::Moves {
            self.leave();
        }
        is_back
    }

    fn advance(&mut self, arrives: bool, decide: Decide) {
        if self.homes && self.limit {
            self.tell(Event::HomingFailed, decide);
            // The switch is no longer one of homing.
            self.tell(Event::Trouble(Trouble::Limit(self.config.fault_stop)), decide);
        }
        if self.parked == Parked::Returns && self.jog == PlantMotion::Rests {
            if arrives || !self.strayed {
                self.parked = Parked::No;
                self.tell(Event::Back, decide);
                (self.paused, self.strayed) = (false, false);
            } else {
                self.parked = Parked::Away;
            }
        }
        if self.spindle_lost && !self.paused {
            self.tell(Event::SpindleStopped, decide);
        }
        let is_free = self.machine.power() == Power::On && self.machine.mode() == Mode::Coord;
        let is_held = self.paused || self.hold || self.spindle_lost;
        let goes = is_free && self.parked == Parked::No && !is_held;
        self.way = match self.way {
            Way::Waits | Way::Brakes if goes => Way::Moves,
            Way::Moves if !goes => Way::Brakes,
            way => way,
        };
        self.tell(Event::Cycle, decide);
        self.by_wheel &= self.jog != PlantMotion::Rests;
    }
}
