//! The machine: its power, its mode and its sources of motion, and the one function that decides.

use crate::{
    Answer, Event, Facts, Jog, Mode, OrderKind, OrderSource, Parked, Refused, Resume, Shift, Stop,
    Trouble,
};

/// Power of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Power {
    /// Amplifiers are off.
    #[default]
    Off,
    /// Amplifiers are on, and orders are taken.
    On,
    /// Amplifiers are on while the joints brake after a fault; then the machine goes off.
    Stops,
}

/// State that a machine keeps from one event to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SafetyMachine {
    power: Power,
    mode: Mode,
    /// Source of the last motion.
    source: OrderSource,
    /// Source of the last jog beside a path that rests.
    beside: OrderSource,
}

impl SafetyMachine {
    /// A machine that is off, in free mode.
    pub const OFF: Self = Self {
        power: Power::Off,
        mode: Mode::Free,
        source: OrderSource::Local,
        beside: OrderSource::Local,
    };

    /// Returns the power.
    #[must_use]
    pub const fn power(&self) -> Power {
        self.power
    }

    /// Returns whether the amplifiers are on.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        !matches!(self.power, Power::Off)
    }

    /// Returns the mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns the source of what moves, or of what moved last; `is_beside`: a jog beside a path that rests.
    #[must_use]
    pub const fn source(&self, is_beside: bool) -> OrderSource {
        if is_beside { self.beside } else { self.source }
    }

    /// Returns the source of the last motion, and that of the last jog beside a path that rests.
    #[must_use]
    pub const fn sources(&self) -> (OrderSource, OrderSource) {
        (self.source, self.beside)
    }

    /// Takes an event, and decides.
    pub fn on(&mut self, event: Event, facts: &Facts) -> Answer {
        match event {
            Event::Order(order, source, given) => {
                // In an e-stop, that is what the order must wait for.
                let is_estopped = facts.estop && matches!(order, OrderKind::Enable);
                if !is_estopped && given.is_too_old(order.ends(), facts.epoch) {
                    return Answer::refuse(Refused::Stale);
                }
                let rests_late =
                    matches!(order, OrderKind::Move) && given.pauses != facts.epoch.pauses;
                match self.order(order, source, facts) {
                    Ok(answer) => Answer { rests_late, ..answer },
                    Err(answer) => answer,
                }
            }
            Event::Off if self.is_on() => self.drop(facts),
            Event::Off => Answer { unhome: facts.volatile, ..Answer::OK },
            Event::Abort => Answer::stop(Stop::Abort),
            Event::Pause => Answer::stop(Stop::Pause),
            Event::Cut => Answer { raises: true, ..Answer::OK },
            Event::Trouble(trouble) => self.trouble(trouble, facts),
            Event::Gap => self.gap(facts),
            Event::Wheel => self.wheel(facts).unwrap_or_else(|answer| answer),
            Event::JogStop { at_once: false } => Answer::stop(Stop::Jogs),
            Event::JogStop { at_once: true } => Answer::stop(Stop::JogsAtOnce),
            Event::Probe if facts.homes => Answer::stop(Stop::Homing),
            Event::Probe if facts.jogs => Answer::stop(Stop::Jogs),
            Event::HomingFailed => Answer::stop(Stop::Homing),
            Event::SpindleStopped => Answer { pauses: true, ..Answer::stop(Stop::Path) },
            Event::Back => self.shift(Mode::Coord),
            Event::NoPlace => self.shift(Mode::Free),
            Event::Cycle if matches!(self.power, Power::Stops) && facts.rests => self.drop(facts),
            Event::Probe | Event::Cycle => Answer::OK,
        }
    }

    /// Decides on an order that is not too late. What is refused changes nothing but what a stop in the answer ends.
    fn order(
        &mut self,
        order: OrderKind,
        source: OrderSource,
        facts: &Facts,
    ) -> Result<Answer, Answer> {
        self.admit(order, source, facts)?;
        let answer = match order {
            OrderKind::Enable => self.enable(facts),
            OrderKind::Mode(mode) => self.set_mode(mode, facts),
            OrderKind::Home => self.home(facts),
            OrderKind::Unhome => self.unhome(facts),
            OrderKind::Jog(jog) => self.jog(jog, facts),
            OrderKind::Move => {
                self.needs_power(Refused::MoveOff)?;
                self.set_mode(Mode::Coord, facts)
            }
            OrderKind::Resume => self.resume(facts),
            OrderKind::Step | OrderKind::Reverse | OrderKind::Forward => self.run(order, facts),
            OrderKind::Spindle { powers: true, .. } | OrderKind::Orient => {
                self.needs_power(Refused::SpindleOff)?;
                Ok(Answer::OK)
            }
            OrderKind::PathOutput
            | OrderKind::Spindle { .. }
            | OrderKind::Setting
            | OrderKind::Harmless => Ok(Answer::OK),
        }?;
        if matches!(
            order,
            OrderKind::Jog(_) | OrderKind::Home | OrderKind::Move | OrderKind::PathOutput
        ) {
            self.begin(source, facts);
        }
        Ok(answer)
    }

    /// Refuses an order while another source moves the machine. A local source ends remote motion.
    fn admit(&self, order: OrderKind, source: OrderSource, facts: &Facts) -> Result<(), Answer> {
        match order {
            OrderKind::Jog(_) | OrderKind::Home | OrderKind::Move | OrderKind::PathOutput => {}
            OrderKind::Mode(_) | OrderKind::Orient | OrderKind::Spindle { drives: true, .. } => {
                let is_foreign = facts.claimed && !matches!(source, OrderSource::Task);
                return if is_foreign { Err(Answer::refuse(Refused::Program)) } else { Ok(()) };
            }
            _ => return Ok(()),
        }
        let is_jog = matches!(order, OrderKind::Jog(_));
        let Some(mover) = self.moving_source(is_jog, facts).filter(|mover| *mover != source) else {
            return Ok(());
        };
        Err(match mover {
            OrderSource::Remote if source == OrderSource::Local => {
                Answer { stop: ends_remote(is_jog, facts), ..Answer::refuse(Refused::Ended) }
            }
            OrderSource::Task => Answer::refuse(Refused::Program),
            OrderSource::Local => Answer::refuse(Refused::Local),
            OrderSource::Remote => Answer::refuse(Refused::Remote),
        })
    }

    /// Returns the source that moves the machine, or that has claimed it. Beside a path that rests in a pause, another
    /// source may jog.
    fn moving_source(&self, is_jog: bool, facts: &Facts) -> Option<OrderSource> {
        if is_jog && rests_on_path(facts) {
            return facts.jogs.then_some(self.beside);
        }
        if !is_idle(facts) {
            return Some(self.source);
        }
        facts.claimed.then_some(OrderSource::Task)
    }

    const fn begin(&mut self, source: OrderSource, facts: &Facts) {
        if rests_on_path(facts) {
            self.beside = source;
        } else {
            self.source = source;
        }
    }

    const fn needs_power(&self, why: Refused) -> Result<(), Answer> {
        match self.power {
            Power::On => Ok(()),
            Power::Off => Err(Answer::refuse(why)),
            Power::Stops => Err(Answer::refuse(Refused::Stops)),
        }
    }

    fn enable(&mut self, facts: &Facts) -> Result<Answer, Answer> {
        if facts.estop {
            return Err(Answer::refuse(Refused::Estop));
        }
        if !facts.enable {
            return Err(Answer::refuse(Refused::EnableInput));
        }
        if !facts.configured {
            return Err(Answer::refuse(Refused::NoJoint));
        }
        if self.power == Power::Stops {
            return Err(Answer::refuse(Refused::Stops));
        }
        let powers = self.power == Power::Off;
        self.power = Power::On;
        Ok(Answer { powers, ..Answer::OK })
    }

    /// Changes the mode, which requires a machine at rest.
    fn set_mode(&mut self, mode: Mode, facts: &Facts) -> Result<Answer, Answer> {
        if mode == self.mode {
            return Ok(Answer::OK);
        }
        let parks = self.mode == Mode::Coord && mode == Mode::Teleop && facts.rests_on_path;
        let why = if facts.parked != Parked::No {
            Some(Refused::PathPaused)
        } else if !is_idle(facts) && !parks {
            Some(Refused::ModeMoves)
        } else if !facts.place {
            Some(Refused::Place)
        } else {
            None
        };
        if let Some(why) = why {
            return Err(Answer::refuse(why));
        }
        let shift = if parks { Shift::Park } else { Shift::To(mode) };
        self.mode = mode;
        Ok(Answer { shift, ..Answer::OK })
    }

    fn home(&mut self, facts: &Facts) -> Result<Answer, Answer> {
        self.needs_power(Refused::HomeOff)?;
        if facts.homing_inhibit {
            return Err(Answer::refuse(Refused::HomingInhibit));
        }
        if facts.homes {
            return Err(Answer::refuse(Refused::Homing));
        }
        if !facts.target {
            return Err(Answer::refuse(Refused::Target));
        }
        self.set_mode(Mode::Free, facts)
    }

    fn unhome(&mut self, facts: &Facts) -> Result<Answer, Answer> {
        if !facts.target {
            return Err(Answer::refuse(Refused::Target));
        }
        if !is_idle(facts) {
            return Err(Answer::refuse(Refused::UnhomeMoves));
        }
        if self.is_on() { self.set_mode(Mode::Free, facts) } else { Ok(Answer::OK) }
    }

    fn jog(&mut self, jog: Jog, facts: &Facts) -> Result<Answer, Answer> {
        self.needs_power(Refused::JogOff)?;
        if facts.jog_inhibit {
            return Err(Answer::refuse(Refused::JogInhibit));
        }
        if facts.homes {
            return Err(Answer::refuse(Refused::JogHoming));
        }
        if facts.parked == Parked::Returns {
            return Err(Answer::refuse(Refused::JogReturns));
        }
        if !facts.target {
            return Err(Answer::refuse(Refused::Target));
        }
        let mode = match jog {
            Jog::Joint => Mode::Free,
            Jog::Axis => Mode::Teleop,
        };
        self.set_mode(mode, facts)
    }

    /// Goes on along a paused path, or sends the axes back to it first.
    fn resume(&self, facts: &Facts) -> Result<Answer, Answer> {
        if self.power == Power::Stops {
            return Err(Answer::refuse(Refused::Stops));
        }
        let resume = match facts.parked {
            Parked::No => Resume::Path,
            Parked::Returns => Resume::No,
            Parked::Away if facts.jogs => return Err(Answer::refuse(Refused::ResumeJogs)),
            Parked::Away => Resume::Return,
        };
        Ok(Answer { resume, ..Answer::OK })
    }

    /// Steps along the path, or turns its direction.
    fn run(&self, order: OrderKind, facts: &Facts) -> Result<Answer, Answer> {
        if self.power == Power::Stops {
            return Err(Answer::refuse(Refused::Stops));
        }
        if facts.parked != Parked::No {
            return Err(Answer::refuse(Refused::Away));
        }
        if self.mode != Mode::Coord && order != OrderKind::Forward {
            return Err(Answer::refuse(Refused::NoPath));
        }
        Ok(Answer::OK)
    }

    /// A wheel has turned: it begins local motion, or ends remote motion.
    fn wheel(&mut self, facts: &Facts) -> Result<Answer, Answer> {
        self.needs_power(Refused::JogOff)?;
        if facts.jog_inhibit {
            return Err(Answer::refuse(Refused::JogInhibit));
        }
        if facts.homes {
            return Err(Answer::refuse(Refused::JogHoming));
        }
        self.admit(OrderKind::Jog(Jog::Joint), OrderSource::Local, facts)?;
        self.begin(OrderSource::Local, facts);
        Ok(Answer::OK)
    }

    /// Begins to switch off, or cuts the power, for a cause.
    fn trouble(&mut self, trouble: Trouble, facts: &Facts) -> Answer {
        match self.power {
            Power::Off => Answer::OK,
            _ if trouble.cuts() => Answer { raises: true, ..self.drop(facts) },
            Power::On => {
                self.power = Power::Stops;
                Answer { raises: true, ..Answer::stop(Stop::Ramp) }
            }
            Power::Stops => Answer::OK,
        }
    }

    /// Cuts the power; joints that moved, and whose place nothing measures, are no longer homed.
    fn gap(&mut self, facts: &Facts) -> Answer {
        let lost = facts.moving & facts.open_loop;
        let answer = if self.is_on() { self.drop(facts) } else { Answer::OK };
        Answer { raises: true, unhome: answer.unhome | lost, ..answer }
    }

    const fn drop(&mut self, facts: &Facts) -> Answer {
        self.power = Power::Off;
        Answer { unhome: facts.volatile, ..Answer::stop(Stop::Drop) }
    }

    fn shift(&mut self, mode: Mode) -> Answer {
        let is_new = self.mode != mode;
        self.mode = mode;
        Answer { shift: if is_new { Shift::To(mode) } else { Shift::Stay }, ..Answer::OK }
    }
}

/// Returns whether nothing moves and nothing waits to move.
const fn is_idle(facts: &Facts) -> bool {
    !facts.path && !facts.jogs && !facts.homes
}

/// Returns whether a path rests in a pause, with the axes on it or away from it.
const fn rests_on_path(facts: &Facts) -> bool {
    facts.rests_on_path || !matches!(facts.parked, Parked::No)
}

/// Returns the stop that ends remote motion. A jog beside a path that rests ends jogs alone, and leaves the path.
const fn ends_remote(is_jog: bool, facts: &Facts) -> Stop {
    if is_jog && rests_on_path(facts) { Stop::Jogs } else { Stop::Motion }
}
