//! Realtime. Execution of commands.

use crate::{
    commands::command::{
        Arc, Command, Ends, FeedChange, Jog, JogDistance, JogTarget, Joints, Mode, Move, Output,
        Request, Run, Speed, SpindleChange,
    },
    commands::refusal::Refusal,
    guards::stop_line::Stop,
    jogger::{By, Jogger, TravelLimits},
    path::Parked,
    path::order::{Kind, PathMove},
    setup::put,
    state::State,
};
use hal_component::{MotionSource, StopEpoch, TicketHandle};
use hal_trajectory::Shape;

/// Time at which a ticket is completed.
enum Answer {
    /// Now: the command is complete.
    Done,
    /// Later: the code that carries the command out holds the ticket.
    Later,
}

impl State {
    /// Executes a command, or begins to.
    pub(crate) fn execute(&mut self, command: Command) {
        match command {
            Command::Joint(n, config) => {
                self.replan(
                    self.joints.get(n).is_some_and(|j| !j.active || config.is_tighter(&j.config)),
                );
                if self.joints.get_mut(n).is_some_and(|j| j.configure(config))
                    && self.enabled
                    && self.is_idle()
                {
                    self.sync("a joint was configured");
                    self.leave_world();
                }
                self.configure_module(n);
                self.update_planning_fractions();
                self.lower_limits();
            }
            Command::Axis(n, config) => {
                self.replan(self.axes.get(n).is_some_and(|a| config.is_tighter(&a.config)));
                if let Some(axis) = self.axes.get_mut(n) {
                    axis.config = config;
                }
                self.update_planning_fractions();
                self.lower_limits();
            }
            Command::Spindle(n, config) => {
                if let Some(spindle) = self.spindles.get_mut(n) {
                    spindle.config = config;
                }
            }
            Command::Traj(config) => {
                self.replan(config.is_tighter(&self.traj));
                self.traj = config;
            }
            Command::Request(request, source, given, ticket) => {
                let says_more = self.inputs.lockout.is_some() && matches!(request, Request::Enable);
                if self.is_stale(&request, given) && !says_more {
                    return self.refuse_stale(source, ticket);
                }
                let admitted = self.admit(&request, source);
                match admitted.and_then(|()| self.request(request, ticket)) {
                    Ok(Answer::Done) => ticket.done(),
                    Ok(Answer::Later) => {}
                    Err(why) => return why.report(&self.say, ticket),
                }
                self.rest_late_move(&request, given);
            }
        }
    }

    /// Executes the stops that were commanded since it was last called.
    pub(crate) fn obey_line(&mut self) {
        let pulled = self.line.take();
        if pulled.is_none() {
            return;
        }
        // One stop, also where an e-stop has switched off by command and by the interlock.
        self.has_risen |= pulled.has(Stop::Off);
        // In e-stop the guard switches off, and keeps its cause.
        if pulled.has(Stop::Off) && self.enabled && self.inputs.lockout.is_none() {
            self.turn_off(OFF);
        }
        if pulled.has(Stop::Abort) {
            self.abort();
        }
        if pulled.has(Stop::Pause) {
            self.pause();
        }
    }

    /// Returns whether an order was given before a stop that ends it.
    fn is_stale(&self, request: &Request, given: StopEpoch) -> bool {
        let now = self.line.epoch();
        match request.ends() {
            Ends::Never => false,
            Ends::Stops => given.stops != now.stops,
            Ends::Pauses => given != now,
        }
    }

    /// Refuses an order that was given before a stop. The owner of motion has many moves under way at a stop, and knows.
    fn refuse_stale(&self, source: MotionSource, ticket: TicketHandle) {
        match source {
            MotionSource::Task => STALE.fail(ticket),
            MotionSource::Local | MotionSource::Remote => STALE.report(&self.say, ticket),
        }
    }

    /// A move that was given before a pause rests with the path.
    fn rest_late_move(&mut self, request: &Request, given: StopEpoch) {
        if matches!(request, Request::Move(_)) && given.pauses != self.line.epoch().pauses {
            self.path.pause();
        }
    }

    fn request(&mut self, request: Request, ticket: TicketHandle) -> Result<Answer, Refusal> {
        match request {
            Request::Enable => return self.enable(ticket),
            // The stop line has switched it off already, and aborted and paused below.
            Request::Disable => {}
            Request::Mode(mode) => self.set_mode(mode)?,
            Request::Home(set) => {
                self.home(set, ticket)?;
                return Ok(Answer::Later);
            }
            Request::Unhome(set) => self.unhome(set)?,
            Request::Jog(jog) => return self.jog(jog, ticket),
            Request::JogStop(target) => return Ok(self.jog_stop(target, ticket)),
            Request::Move(m) => return self.move_to(m, ticket),
            Request::PathOutput(output) if self.path.is_idle() => self.set_output(output),
            Request::PathOutput(output) => self.path.push_output(output)?,
            Request::Run(run) => self.run(run)?,
            Request::Abort => return Ok(self.await_stop(ticket)),
            Request::Spindle(change) => self.change_spindle(change)?,
            Request::Orient(n, angle, mode) => {
                self.needs_enabled("the spindle cannot turn: the machine is not enabled")?;
                if let Some(spindle) = self.spindles.get_mut(n) {
                    spindle.orient(angle, mode, ticket);
                }
                return Ok(Answer::Later);
            }
            Request::Output(output) => self.set_output(output),
            Request::Feed(change) => self.change_feed(change),
            Request::OverrideLimits => {
                let at_switch = self.active().any(|j| j.inputs.at_max || j.inputs.at_min);
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
            joint.track_feedback("the machine was off");
        }
        self.sync("the machine was off");
        self.leave_world();
        self.last_jump.clear();
        self.enabled = true;
        if self.feed.scale > 1.0 {
            self.feed.scale = 1.0;
        }
        self.enable_ticket = Some(ticket);
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
        if matches!(self.path.parked(), Parked::Returns(_) | Parked::Back(_)) {
            return Err(Refusal::new("cannot jog while the axes go back to their path"));
        }
        let limits = match jog.target {
            JogTarget::Joint(n) => self.joint_limits(n)?,
            JogTarget::Axis(letter) => {
                self.set_mode(Mode::Teleop)?;
                self.jog_limits(letter)?
            }
        };
        let Some(jogger) = self.jogger(jog.target) else {
            return Err(Refusal::new("cannot jog: no such joint or axis"));
        };
        let (at, goal) = (jogger.tp.pos, jogger.tp.target);
        let target = match jog.distance {
            JogDistance::Continuous if jog.velocity > 0.0 => f64::INFINITY,
            JogDistance::Continuous => f64::NEG_INFINITY,
            JogDistance::Incremental(by) => goal + by,
            JogDistance::Absolute(position) => position,
        };
        if let JogTarget::Joint(n) = jog.target
            && let Some(inputs) = self.joints.get(n).map(|j| j.inputs)
        {
            let up = target > at;
            if (up && inputs.at_max) || (target < at && inputs.at_min) {
                return Err(past_switch(n, up));
            }
        }
        let held = (jog.distance != JogDistance::Continuous).then_some(ticket);
        let mut goes = target;
        if let Some(jogger) = self.jogger(jog.target) {
            jogger.set_target(target, jog.velocity.abs(), &limits, By::Command, held);
            goes = jogger.tp.target;
        }
        if held.is_none() {
            return Ok(Answer::Done);
        }
        if goes != target {
            match jog.target {
                JogTarget::Joint(n) => {
                    self.say.warn("jog of joint {} ends at its limit, {}", &[n as f64, goes]);
                }
                JogTarget::Axis(_) => self.say.warn("jog ends at the axis's limit, {}", &[goes]),
            }
        }
        Ok(Answer::Later)
    }

    fn jogger(&mut self, target: JogTarget) -> Option<&mut Jogger> {
        match target {
            JogTarget::Joint(n) => self.joints.get_mut(n).map(|j| &mut j.free),
            JogTarget::Axis(n) => self.axes.get_mut(n).map(|a| &mut a.teleop),
        }
    }

    fn joint_limits(&mut self, n: usize) -> Result<TravelLimits, Refusal> {
        let Some(joint) = self.joints.get(n).filter(|j| j.active) else {
            return Err(not_configured(n));
        };
        if let Some((why, say)) = joint.refuses_jog() {
            return Err(Refusal::joint(why, say, n));
        }
        let limits = joint.jog_limits();
        self.set_mode(Mode::Free)?;
        Ok(limits)
    }

    fn jog_stop(&mut self, target: Option<JogTarget>, ticket: TicketHandle) -> Answer {
        let why = "the jog was stopped";
        let Some(target) = target else {
            self.stop_jogs(why);
            return self.await_stop(ticket);
        };
        match self.jogger(target) {
            Some(jogger) if jogger.is_jog() => {
                jogger.stop(why, Some(ticket));
                Answer::Later
            }
            _ => Answer::Done,
        }
    }

    /// Brakes every jog.
    pub(crate) fn stop_jogs(&mut self, why: &'static str) {
        for jogger in self.jogs() {
            jogger.stop(why, None);
        }
    }

    /// Returns the jogs of joints and axes that are in progress.
    pub(crate) fn jogs(&mut self) -> impl Iterator<Item = &mut Jogger> {
        let joints = self.joints.iter_mut().map(|j| &mut j.free);
        joints.chain(self.axes.iter_mut().map(|a| &mut a.teleop)).filter(|j| j.is_jog())
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
        if m.probe.is_some() {
            self.probe.found = false;
        }
        let end = hal_trajectory::Pose::ZERO;
        let (shape, kind) = match m.arc {
            None if m.probe.is_some() => (Shape::Line { end }, Kind::Probe),
            None if m.speed == Speed::Rapid => (Shape::Line { end }, Kind::Rapid),
            None => (Shape::Line { end }, Kind::Feed),
            Some(Arc { center, normal, turns }) => {
                (Shape::Arc { end, center, normal, turns }, Kind::Arc)
            }
        };
        let (feed, is_time) = match m.speed {
            // The feed is that of the spindle.
            _ if m.sync.is_some() => (f64::INFINITY, false),
            Speed::Default => (traj.default_velocity, false),
            Speed::Rapid => (f64::INFINITY, false),
            Speed::Feed(v) => (v, false),
            Speed::Time(t) => (t, true),
        };
        let order = PathMove {
            shape,
            kind,
            mode: m.mode,
            probe: m.probe,
            feed,
            is_time,
            acceleration: m.acceleration.filter(|a| *a < most).unwrap_or(most),
            line: m.line,
            sync: m.sync,
        };
        self.path.push(&self.pose, &m.to, order, Some(ticket))
    }

    fn run(&mut self, run: Run) -> Result<(), Refusal> {
        if run == Run::Pause {
            return Ok(());
        }
        let is_away = self.path.parked() != Parked::No;
        if is_away && run != Run::Resume {
            return Err(Refusal::new("the axes have left the path: motion.resume goes back to it"));
        }
        if self.mode != Mode::Coord && run != Run::Resume && run != Run::Forward {
            return Err(Refusal::new("there is no path: it needs coordinated mode"));
        }
        if run == Run::Resume { self.resume() } else { self.path.run(run) }
    }

    /// Plans the rest of the path again if a limit has become tighter. A path that has ended is left in any case.
    fn replan(&mut self, is_tighter: bool) {
        if is_tighter || self.path.is_idle() {
            self.path.replan();
        }
    }

    /// Brakes everything that moves; the path rests where it comes to a stop.
    fn pause(&mut self) {
        self.end_homing("paused");
        self.stop_jogs("paused");
        if !self.path.is_idle() {
            self.path.pause();
        }
    }

    fn abort(&mut self) {
        self.origin.free();
        let tapping = self.path.abort();
        self.end_homing("aborted");
        self.stop_jogs("aborted");
        let all = self.spindles.iter_mut().enumerate();
        all.filter(|(n, _)| tapping != Some(*n)).for_each(|(_, s)| s.stop("aborted"));
    }

    fn await_stop(&mut self, ticket: TicketHandle) -> Answer {
        if let Some(earlier) = self.stop_ticket.replace(ticket) {
            earlier.fail("superseded by another stop command");
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

    pub(crate) fn set_output(&mut self, output: Output) {
        match output {
            Output::Digital(n, value) => put(&mut self.digital_out, n, value),
            Output::ToolOffset(offset) => {
                self.tool_offset = offset;
                self.tool_offsets = self.tool_offsets.wrapping_add(1);
            }
            Output::Analog(n, value) => put(&mut self.analog_out, n, value),
        }
    }

    fn change_feed(&mut self, change: FeedChange) {
        let feed = &mut self.feed;
        feed.scale = change.scale.unwrap_or(feed.scale);
        feed.rapid = change.rapid.unwrap_or(feed.rapid);
        feed.adaptive = change.adaptive.unwrap_or(feed.adaptive);
        feed.hold = change.hold.unwrap_or(feed.hold);
    }
}

const OFF: &str = "the machine was switched off";

const STALE: Refusal = Refusal::new("a stop has come meanwhile: give the command again");

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
