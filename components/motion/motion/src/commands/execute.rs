//! Realtime. Execution of commands.

use crate::{
    commands::command::{
        Ask, Command, Far, FeedChange, Jog, Joints, Mode, Move, Output, SpindleChange, What,
    },
    commands::refusal::Refusal,
    jogger::{By, Jogger, Room},
    path::line::Wish,
    state::State,
};
use hal_component::TicketHandle;

/// Time at which a ticket is completed.
enum Answer {
    /// Now: the command is complete.
    Done,
    /// Later: the code that carries the command out holds the ticket.
    Later,
}

impl State {
    /// Executes a command, or begins to.
    pub(crate) fn obey(&mut self, command: Command) {
        match command {
            Command::Joint(n, config) => {
                if self.joints.get_mut(n).is_some_and(|j| j.configure(config))
                    && self.enabled
                    && self.is_idle()
                {
                    self.sync("a joint was configured");
                    self.leave_world();
                }
                self.lower_limits();
            }
            Command::Axis(n, config) => {
                if let Some(axis) = self.axes.get_mut(n) {
                    axis.config = config;
                }
                self.share();
                self.lower_limits();
            }
            Command::Traj(config) => self.traj = config,
            Command::Ask(ask, ticket) => match self.ask(ask, ticket) {
                Ok(Answer::Done) => ticket.done(),
                Ok(Answer::Later) => {}
                Err(why) => why.report(&self.say, ticket),
            },
        }
    }

    fn ask(&mut self, ask: Ask, ticket: TicketHandle) -> Result<Answer, Refusal> {
        match ask {
            Ask::Enable => return self.enable(ticket),
            Ask::Disable => self.turn_off("the machine was switched off"),
            Ask::Mode(mode) => self.set_mode(mode)?,
            Ask::Home(set) => {
                self.home(set, ticket)?;
                return Ok(Answer::Later);
            }
            Ask::Unhome(set) => self.unhome(set)?,
            Ask::Jog(jog) => return self.jog(jog, ticket),
            Ask::JogStop(what) => return Ok(self.jog_stop(what, ticket)),
            Ask::Move(m) => return self.move_to(m, ticket),
            Ask::Abort => return Ok(self.abort(ticket)),
            Ask::Spindle(change) => self.change_spindle(change)?,
            Ask::Orient(n, angle, mode) => {
                self.needs_enabled("the spindle cannot turn: the machine is not enabled")?;
                if let Some(spindle) = self.spindles.get_mut(n) {
                    spindle.orient(angle, mode, ticket);
                }
                return Ok(Answer::Later);
            }
            Ask::Output(output) => self.put(output),
            Ask::Feed(change) => self.change_feed(change),
            Ask::OverrideLimits => {
                let at_switch = self.active().any(|j| j.senses.at_max || j.senses.at_min);
                self.overriding = at_switch;
                self.override_moved = false;
            }
        }
        Ok(Answer::Done)
    }

    fn enable(&mut self, ticket: TicketHandle) -> Result<Answer, Refusal> {
        if let Some(lockout) = self.inputs.lockout {
            return Err(lockout.refusal());
        }
        if !self.inputs.enable {
            return Err(Refusal::new("can't enable motion, enable input is false"));
        }
        if self.active().next().is_none() {
            return Err(Refusal::new(
                "can't enable motion, no joint is configured, see motion.configure",
            ));
        }
        if self.enabled {
            return Ok(Answer::Done);
        }
        for joint in &mut self.joints {
            joint.error = false;
            joint.follow("the machine was off");
        }
        self.sync("the machine was off");
        self.leave_world();
        self.last_jump.clear();
        self.enabled = true;
        self.enabling = Some(ticket);
        Ok(Answer::Later)
    }

    pub(crate) fn needs_enabled(&self, text: &'static str) -> Result<(), Refusal> {
        if self.enabled { Ok(()) } else { Err(Refusal::new(text)) }
    }

    /// Returns the joints of a set; a set of all bits means all active joints.
    pub(crate) fn wanted(&self, set: Joints) -> Result<Joints, Refusal> {
        let active = |n: &usize| self.joints.get(*n).is_some_and(|j| j.active);
        let actives = (0..self.joints.len()).filter(active).fold(0, |s, n| s | 1 << n);
        if set == Joints::MAX {
            return Ok(actives);
        }
        match (0..self.joints.len()).find(|n| (set & !actives) >> n & 1 == 1) {
            Some(n) => Err(not_configured(n)),
            None => Ok(set),
        }
    }

    fn jog(&mut self, jog: Jog, ticket: TicketHandle) -> Result<Answer, Refusal> {
        self.needs_enabled("cannot jog: the machine is not enabled")?;
        if self.inputs.jog_inhibit {
            return Err(Refusal::new("cannot jog while jog-inhibit is active"));
        }
        if self.is_homing() {
            return Err(Refusal::new("cannot jog while homing"));
        }
        let room = match jog.what {
            What::Joint(n) => self.joint_room(n)?,
            What::Axis(letter) => {
                self.set_mode(Mode::Teleop)?;
                self.jog_room(letter)?
            }
        };
        let Some(jogger) = self.jogger(jog.what) else {
            return Err(Refusal::new("cannot jog: no such joint or axis"));
        };
        let tp = jogger.tp;
        let target = match jog.far {
            Far::On if jog.velocity > 0.0 => f64::INFINITY,
            Far::On => f64::NEG_INFINITY,
            Far::By(distance) => tp.target + distance,
            Far::To(position) => position,
        };
        if let What::Joint(n) = jog.what
            && let Some(senses) = self.joints.get(n).map(|j| j.senses)
        {
            let up = target > tp.pos;
            if (up && senses.at_max) || (target < tp.pos && senses.at_min) {
                return Err(past_switch(n, up));
            }
        }
        let held = (jog.far != Far::On).then_some(ticket);
        let mut goes = target;
        if let Some(jogger) = self.jogger(jog.what) {
            jogger.go(target, jog.velocity.abs(), &room, By::Command, held);
            goes = jogger.tp.target;
        }
        if held.is_none() {
            return Ok(Answer::Done);
        }
        if goes != target {
            match jog.what {
                What::Joint(n) => {
                    self.say.warn("jog of joint {} ends at its limit, {}", &[n as f64, goes]);
                }
                What::Axis(_) => self.say.warn("jog ends at the axis's limit, {}", &[goes]),
            }
        }
        Ok(Answer::Later)
    }

    fn jogger(&mut self, what: What) -> Option<&mut Jogger> {
        match what {
            What::Joint(n) => self.joints.get_mut(n).map(|j| &mut j.free),
            What::Axis(n) => self.axes.get_mut(n).map(|a| &mut a.teleop),
        }
    }

    fn joint_room(&mut self, n: usize) -> Result<Room, Refusal> {
        let Some(joint) = self.joints.get(n).filter(|j| j.active) else {
            return Err(not_configured(n));
        };
        if joint.extra && joint.homing.homed {
            return Err(Refusal::new("cannot jog: a homed extra joint follows posthome-cmd"));
        }
        let room = joint.room();
        self.set_mode(Mode::Free)?;
        Ok(room)
    }

    fn jog_stop(&mut self, what: Option<What>, ticket: TicketHandle) -> Answer {
        let why = "the jog was stopped";
        let Some(what) = what else {
            self.stop_jogs(why);
            return self.stand(ticket);
        };
        match self.jogger(what) {
            Some(jogger) if matches!(jogger.by, By::Command | By::Wheel) => {
                jogger.stop(why, Some(ticket));
                Answer::Later
            }
            _ => Answer::Done,
        }
    }

    /// Brakes every jog.
    pub(crate) fn stop_jogs(&mut self, why: &'static str) {
        let joints = self.joints.iter_mut().map(|j| &mut j.free);
        for jogger in joints.chain(self.axes.iter_mut().map(|a| &mut a.teleop)) {
            if matches!(jogger.by, By::Command | By::Wheel) {
                jogger.stop(why, None);
            }
        }
    }

    fn move_to(&mut self, m: Move, ticket: TicketHandle) -> Result<Answer, Refusal> {
        let pushed = self.push(m, ticket);
        self.coord_error = pushed.is_err();
        pushed.map(|()| Answer::Later)
    }

    fn push(&mut self, m: Move, ticket: TicketHandle) -> Result<(), Refusal> {
        self.needs_enabled("need to be enabled, in coord mode for linear move")?;
        self.set_mode(Mode::Coord)?;
        let traj = &self.traj;
        let most = traj.max_acceleration;
        let wish = Wish {
            velocity: m.velocity.unwrap_or(traj.default_velocity),
            acceleration: m.acceleration.filter(|a| *a < most).unwrap_or(most),
            max_velocity: traj.max_velocity,
        };
        let Self { path, pose, kinematics, joints, axes, shares, .. } = self;
        let machine = crate::path::line::Machine { kinematics, joints, axes, shares };
        path.push(*pose, m.to, wish, machine, ticket)
    }

    fn abort(&mut self, ticket: TicketHandle) -> Answer {
        self.path.abort();
        self.end_homing("aborted");
        self.stop_jogs("aborted");
        for spindle in &mut self.spindles {
            spindle.stop("aborted");
        }
        self.stand(ticket)
    }

    fn stand(&mut self, ticket: TicketHandle) -> Answer {
        if let Some(earlier) = self.standing.replace(ticket) {
            earlier.fail("another stop took its place");
        }
        Answer::Later
    }

    fn change_spindle(&mut self, change: SpindleChange) -> Result<(), Refusal> {
        if change.speed.is_some_and(|s| s != 0.0) {
            self.needs_enabled("the spindle cannot turn: the machine is not enabled")?;
        }
        let Some(spindle) = self.spindles.get_mut(change.spindle) else {
            return Err(Refusal::new("there is no such spindle"));
        };
        if let Some(scale) = change.scale {
            spindle.scale = scale;
        }
        if let Some(speed) = change.speed {
            spindle.turn(speed);
        }
        if let Some(brake) = change.brake {
            spindle.brake(brake);
        }
        Ok(())
    }

    fn put(&mut self, output: Output) {
        match output {
            Output::Digital(n, value) => {
                if let Some(place) = self.digital_out.get_mut(n) {
                    *place = value;
                }
            }
            Output::Analog(n, value) => {
                if let Some(place) = self.analog_out.get_mut(n) {
                    *place = value;
                }
            }
        }
    }

    fn change_feed(&mut self, change: FeedChange) {
        let feed = &mut self.feed;
        feed.scale = change.scale.unwrap_or(feed.scale);
        feed.adaptive = change.adaptive.unwrap_or(feed.adaptive);
        feed.hold = change.hold.unwrap_or(feed.hold);
    }
}

const fn not_configured(n: usize) -> Refusal {
    Refusal::joint(
        "the joint is not configured, see motion.configure",
        "joint {} is not configured, see motion.configure",
        n,
    )
}

const fn past_switch(n: usize, up: bool) -> Refusal {
    if up {
        Refusal::joint(
            "cannot jog further past the positive limit switch",
            "Can't jog joint {} further past max hard limit.",
            n,
        )
    } else {
        Refusal::joint(
            "cannot jog further past the negative limit switch",
            "Can't jog joint {} further past min hard limit.",
            n,
        )
    }
}
