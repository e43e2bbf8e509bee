//! Realtime. Execution of commands.

use crate::{
    commands::command::{
        Arc, Command, Jog, JogDistance, JogTarget, Joints, Move, Request, Run, Speed,
    },
    commands::refusal::Refusal,
    guards::stop_line::Stop,
    jogger::{By, Jogger, TravelLimits},
    names::{JointText, Names, joint_text},
    path::order::{Kind, PathMove},
    spindle::Spindle,
    state::State,
};
use hal_component::{MotionSource, TicketHandle};
use hal_safety::Event;
use hal_trajectory::Shape;

/// Time at which a ticket is completed.
#[derive(Clone, Copy, PartialEq, Eq)]
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
                    && self.is_on()
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
                let taken = self.take(&request, source, given);
                let rests_late = taken.as_ref().is_ok_and(|taken| taken.rests_late);
                match taken.and_then(|taken| self.request(request, source, &taken, ticket)) {
                    Ok(answer) => {
                        if rests_late {
                            self.path.pause();
                        }
                        if answer == Answer::Done {
                            ticket.done();
                        }
                    }
                    // The owner of motion has many moves under way at a stop, and tells what is wrong with a step of its job,
                    // with its line.
                    Err(why)
                        if source == MotionSource::Task
                            && (why.is_stale() || request.is_of_job()) =>
                    {
                        why.fail(ticket);
                    }
                    Err(why) => why.report(&self.say, ticket),
                }
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
        for (stop, event, why) in STOPS {
            // In e-stop the guard switches off, and keeps its cause.
            let is_of_guard = stop == Stop::Off && self.inputs.lockout.is_some();
            if pulled.has(stop) && !is_of_guard {
                self.tell(event, why);
            }
        }
    }

    fn request(
        &mut self,
        request: Request,
        source: MotionSource,
        taken: &hal_safety::Answer,
        ticket: TicketHandle,
    ) -> Result<Answer, Refusal> {
        match request {
            Request::Enable if taken.powers => return Ok(self.enable(ticket)),
            // The stop line has switched it off already; the setting volatile-home counts if it was commanded before.
            Request::Disable if !self.is_on() => drop(self.tell(Event::Off, SWITCHED_OFF)),
            // The stop line has paused, and aborted below. The mode has changed.
            Request::Enable | Request::Disable | Request::Mode(_) | Request::Run(Run::Pause) => {}
            Request::Home(set) => {
                self.home(set, ticket);
                return Ok(Answer::Later);
            }
            Request::Unhome(set) => self.unhome(set)?,
            Request::Jog(jog) => return self.jog(jog, ticket),
            Request::JogStop(target) => return Ok(self.jog_stop(target, ticket)),
            Request::Move(m) => return self.move_to(m, ticket),
            Request::PathOutput(output) if self.path.is_idle() => self.set_output(output),
            Request::PathOutput(output) => self.path.push_output(output)?,
            Request::Run(Run::Resume) => {
                self.restart_spindles(source)?;
                self.resume(taken.resume)?;
            }
            Request::Run(Run::Step) => {
                self.restart_spindles(source)?;
                self.path.run(Run::Step)?;
            }
            Request::Run(run) => self.path.run(run)?,
            Request::Abort => return Ok(self.await_stop(ticket)),
            Request::Spindle(change) => self.change_spindle(change, source)?,
            Request::Orient(n, angle, mode) => {
                if let Some(spindle) = self.spindles.get_mut(n) {
                    spindle.orient((angle, mode), source, ticket);
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

    /// Switches on; the safety machine has agreed.
    fn enable(&mut self, ticket: TicketHandle) -> Answer {
        for joint in &mut self.joints {
            joint.error = false;
            joint.track_feedback("the machine was off");
        }
        self.sync("the machine was off");
        self.leave_world();
        self.last_jump.clear();
        if self.feed.scale > 1.0 {
            self.feed.scale = 1.0;
        }
        self.enable_ticket = Some(ticket);
        Answer::Later
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
        let limits = match jog.target {
            JogTarget::Joint(n) => self.joint_limits(n)?,
            JogTarget::Axis(letter) => self.jog_limits(letter)?,
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
                return Err(past_switch(&self.names, n, up));
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
                    let (text, numbers, count) = self.names.with_numbers(&ENDS, n, &[goes]);
                    self.say.warn(text, numbers.get(..count).unwrap_or_default());
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

    /// Returns the limits of a jog of a joint, if it jogs by itself.
    pub(crate) fn joint_limits(&self, n: usize) -> Result<TravelLimits, Refusal> {
        let Some(joint) = self.joints.get(n).filter(|j| j.active) else {
            return Err(not_configured(n));
        };
        if let Some((why, say)) = joint.refuses_jog() {
            return Err(Refusal::joint(why, say, n));
        }
        Ok(joint.jog_limits())
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
            turns: m.sync.map_or(0.0, |sync| {
                self.spindles.get(sync.spindle).map_or(0.0, Spindle::turns_commanded)
            }),
        };
        self.path.push(&self.pose, &m.to, order, Some(ticket))
    }

    /// Plans the rest of the path again if a limit has become tighter. A path that has ended is left in any case.
    fn replan(&mut self, is_tighter: bool) {
        if is_tighter || self.path.is_idle() {
            self.path.replan();
        }
    }

    fn await_stop(&mut self, ticket: TicketHandle) -> Answer {
        if let Some(earlier) = self.stop_ticket.replace(ticket) {
            earlier.fail("superseded by another stop command");
        }
        Answer::Later
    }
}

const SWITCHED_OFF: &str = "the machine was switched off";

/// Stops that commands ask for, the strongest first, with their causes.
const STOPS: [(Stop, Event, &str); 3] = [
    (Stop::Off, Event::Off, SWITCHED_OFF),
    (Stop::Abort, Event::Abort, "aborted"),
    (Stop::Pause, Event::Pause, "paused"),
];

const fn not_configured(n: usize) -> Refusal {
    Refusal::joint(
        "the joint is not configured, see motion.configure",
        "joint {} is not configured, see motion.configure",
        n,
    )
}

static ENDS: JointText = joint_text!("jog of ", " ends at its limit, {}");
static PAST_MAX: JointText = joint_text!("Can't jog ", " further past max hard limit.");
static PAST_MIN: JointText = joint_text!("Can't jog ", " further past min hard limit.");

fn past_switch(names: &Names, n: usize, up: bool) -> Refusal {
    let (why, say) = match up {
        true => ("cannot jog further past the positive limit switch", &PAST_MAX),
        false => ("cannot jog further past the negative limit switch", &PAST_MIN),
    };
    Refusal::joint(why, names.text(say, n).0, n)
}
