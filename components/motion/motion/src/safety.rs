//! Realtime. The safety machine at work: what it knows of joints and path, and what they do as it says.

use crate::{
    commands::{
        command::{JogTarget, Mode, Request},
        refusal::Refusal,
    },
    guards::{interlock::Lockout, stop_line},
    homing::sequence::{check, with_partners},
    path::Parked,
    source::{REMOTE_ENDED, of},
    state::State,
};
use hal_component::{MotionSource, StopEpoch};
use hal_safety::{Answer, Epoch, Event, Facts, OrderKind, Power, Refused, Shift, Stop};

impl State {
    /// Returns whether the amplifiers are on.
    pub(crate) const fn is_on(&self) -> bool {
        self.machine.is_on()
    }

    /// Returns the mode.
    pub(crate) const fn mode(&self) -> Mode {
        self.machine.mode()
    }

    /// Returns whether the joints brake after a fault, with which the machine goes off.
    pub(crate) fn is_stopping(&self) -> bool {
        self.machine.power() == Power::Stops
    }

    /// Lets the safety machine decide on a request, and does what it decides but for the request itself.
    pub(crate) fn take(
        &mut self,
        request: &Request,
        source: MotionSource,
        given: StopEpoch,
    ) -> Result<Answer, Refusal> {
        let order = request.order();
        let mut facts = self.facts();
        let target = self.needs_target(request);
        let place = self.needs_place(order, &facts);
        (facts.target, facts.place) = (target.is_ok(), place.is_ok());
        let answer = self.machine.on(Event::Order(order, of(source), epoch(given)), &facts);
        self.obey(&answer, REMOTE_ENDED);
        let Some(refused) = answer.refused else { return Ok(answer) };
        let why = match refused {
            Refused::Target => target.err(),
            Refused::Place => place.err(),
            Refused::Estop => self.inputs.lockout.map(Lockout::refusal),
            _ => None,
        };
        if order == OrderKind::Move && !is_early(refused) {
            self.coord_error = true;
        }
        Err(why.unwrap_or_else(|| Refusal::new(refused.text())))
    }

    /// Tells the safety machine of an event, and does what it decides, with a reason for what ends.
    pub(crate) fn tell(&mut self, event: Event, why: &'static str) -> Answer {
        let facts = self.facts();
        let answer = self.machine.on(event, &facts);
        self.obey(&answer, why);
        answer
    }

    /// Stops what the safety machine stops, and changes the mode.
    pub(crate) fn obey(&mut self, answer: &Answer, why: &'static str) {
        if answer.raises {
            self.raise_epoch();
        }
        if answer.pauses {
            self.line.raise(stop_line::Stop::Pause);
        }
        match answer.stop {
            Stop::None => {}
            Stop::Jogs => self.stop_jogs(why),
            Stop::JogsAtOnce => self.halt_jogs(why),
            Stop::Homing => self.end_homing(why),
            Stop::Path => self.path.pause(),
            Stop::Pause => {
                self.end_homing(why);
                self.stop_jogs(why);
                if !self.path.is_idle() {
                    self.path.pause();
                }
            }
            Stop::Motion => self.brake(why),
            Stop::Abort => self.abort(why),
            Stop::Ramp => self.ramp(why),
            Stop::Drop => self.cut(why),
        }
        self.forget_home(answer.unhome);
        match answer.shift {
            Shift::Stay => {}
            Shift::To(_) => self.sync("the mode has changed"),
            Shift::Park => {
                self.path.set_parked(Parked::Away(self.pose));
                self.sync("the mode has changed");
            }
        }
    }

    /// Returns what the safety machine knows in this moment; what an order needs is added to it.
    pub(crate) fn facts(&self) -> Facts {
        let bits = |is: fn(&crate::joint::Joint) -> bool| {
            let joints = self.joints.iter().enumerate().filter(|(_, j)| j.active && is(j));
            joints.fold(0, |bits, (n, _)| bits | 1 << n)
        };
        let (jogs, homes, path) = (self.is_jogging(), self.is_homing(), !self.path.is_idle());
        Facts {
            epoch: epoch(self.line.epoch()),
            estop: self.inputs.lockout.is_some(),
            enable: self.inputs.enable,
            jog_inhibit: self.inputs.jog_inhibit,
            homing_inhibit: self.inputs.homing_inhibit,
            configured: self.active().next().is_some(),
            jogs,
            homes: homes || self.homing.is_some(),
            path,
            rests_on_path: self.path.can_park(),
            parked: match self.path.parked() {
                Parked::No => hal_safety::Parked::No,
                Parked::Away(_) => hal_safety::Parked::Away,
                Parked::Returns(_) | Parked::Back(_) => hal_safety::Parked::Returns,
            },
            claimed: self.origin.is_claimed(),
            target: true,
            place: true,
            rests: !jogs && !homes && !path && self.rests(),
            moving: bits(|j| j.vel_cmd != 0.0),
            open_loop: self.open_loop,
            volatile: bits(|j| j.config.home.is_volatile),
        }
    }

    /// Returns whether no joint moves that motion moves.
    fn rests(&self) -> bool {
        self.active().all(|j| j.vel_cmd == 0.0 || j.extra && j.homing.homed)
    }

    /// Refuses a request whose joint cannot do what is asked.
    fn needs_target(&self, request: &Request) -> Result<(), Refusal> {
        match request {
            Request::Home(set) if self.module.is_some() => self.wanted(*set).map(drop),
            Request::Home(set) => {
                check(&self.joints, with_partners(&self.joints, self.wanted(*set)?))
            }
            Request::Unhome(set) => self.wanted(*set).map(drop),
            Request::Jog(jog) => match jog.target {
                JogTarget::Joint(n) => self.joint_limits(n).map(drop),
                JogTarget::Axis(_) => Ok(()),
            },
            _ => Ok(()),
        }
    }

    /// Refuses an order that needs another mode, in which nothing can move from here.
    fn needs_place(&self, order: OrderKind, facts: &Facts) -> Result<(), Refusal> {
        let moves = facts.path || facts.jogs || facts.homes;
        let Some(mode) = order.mode().filter(|mode| *mode != self.mode()) else { return Ok(()) };
        if moves && !facts.rests_on_path {
            return Ok(());
        }
        if mode == Mode::Free {
            self.needs_no_offset()?;
        }
        self.needs_world(mode)
    }

    /// Brakes everything; the path ends where it comes to rest.
    fn brake(&mut self, why: &'static str) {
        self.path.abort_with(Refusal::new(why));
        self.end_homing(why);
        self.stop_jogs(why);
    }

    fn abort(&mut self, why: &'static str) {
        self.origin.free();
        let tapping = self.path.abort();
        self.end_homing(why);
        self.stop_jogs(why);
        let all = self.spindles.iter_mut().enumerate();
        all.filter(|(n, _)| tapping != Some(*n)).for_each(|(_, s)| s.stop(why));
    }

    /// Brakes everything after a fault; [`Self::end_ramp`] switches off when all joints rest.
    fn ramp(&mut self, cause: &'static str) {
        self.ramp_cause = cause;
        self.brake(cause);
        self.spindles.iter_mut().for_each(|spindle| spindle.stop(cause));
        if let Some(ticket) = self.enable_ticket.take() {
            ticket.fail(cause);
        }
    }

    /// Switches off at the end of a ramp.
    pub(crate) fn end_ramp(&mut self) {
        if self.is_stopping() {
            self.tell(Event::Cycle, self.ramp_cause);
        }
    }

    /// Switches off: all motion ends at once, and all tickets that wait for motion are refused.
    fn cut(&mut self, cause: &'static str) {
        self.count_hard_stop();
        self.path.clear(Refusal::new(cause));
        self.end_homing(cause);
        for joint in &mut self.joints {
            joint.track_feedback(cause);
        }
        for axis in &mut self.axes {
            axis.teleop.reset(axis.teleop.tp.pos, cause);
        }
        for spindle in &mut self.spindles {
            spindle.stop(cause);
        }
        if let Some(ticket) = self.enable_ticket.take() {
            ticket.fail(cause);
        }
        self.override_moved = false;
    }
}

/// Returns the epoch of a record.
const fn epoch(given: StopEpoch) -> Epoch {
    Epoch { stops: given.stops, pauses: given.pauses }
}

/// Returns whether an order is refused before anything of it is looked at.
const fn is_early(refused: Refused) -> bool {
    matches!(
        refused,
        Refused::Stale | Refused::Program | Refused::Local | Refused::Remote | Refused::Ended
    )
}
