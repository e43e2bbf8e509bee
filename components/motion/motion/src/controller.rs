//! Realtime. The two functions: one receives commands, the other executes them and moves.

use crate::{
    commands::command::{Command, Mode},
    guards::{gap::Unseen, interlock::Interlock},
    outputs::Outputs,
    path::order::HandOver,
    pins::Pins,
    state::State,
    status::{Cycle, Status},
};
use hal_component::{Clock, Gives, KinematicsRef, Period, Receiver, Sender, Touch, Update};
use libm::sqrt;

/// Maximum number of commands executed in a cycle, because planning a move takes time.
const PER_CYCLE: usize = 16;

/// State of `motion-command-handler`.
#[derive(Debug, Touch)]
pub(crate) struct Handler {
    from: Receiver<Command>,
    to: Sender<Command>,
    /// A command for which the controller had no room.
    #[state]
    held: Option<Command>,
}

impl Handler {
    pub(crate) const fn new(from: Receiver<Command>, to: Sender<Command>) -> Self {
        Self { from, to, held: None }
    }
}

impl Update for Handler {
    fn update(&mut self, _: Period) {
        for _ in 0..PER_CYCLE {
            let Some(command) = self.held.take().or_else(|| self.from.take()) else { return };
            if let Err(command) = self.to.send(command) {
                self.held = Some(command);
                return;
            }
        }
    }
}

/// State of `motion-controller`.
#[derive(Debug, Touch)]
pub(crate) struct Controller {
    pub(crate) from: Receiver<Command>,
    pub(crate) pins: Pins,
    pub(crate) interlock: Interlock,
    pub(crate) kinematics: KinematicsRef,
    pub(crate) clock: Clock,
    #[state]
    pub(crate) last_ns: Option<i64>,
    /// Number of gaps in time up to the last cycle.
    #[state]
    pub(crate) gaps: Option<u32>,
    /// Number of failures of drivers' hardware up to the last cycle.
    #[state]
    pub(crate) failures: Option<u32>,
    /// Number of cycles so far.
    #[state]
    pub(crate) cycle: u64,
    pub(crate) status: Status,
    #[state]
    pub(crate) outputs: Outputs,
    /// Declares that the path passes orders to the planner.
    pub(crate) hand: Gives<HandOver>,
    #[state]
    pub(crate) state: State,
}

impl Update for Controller {
    fn update(&mut self, period: Period) {
        let dt = period.secs();
        if dt > 0.0 {
            self.advance(dt);
            self.put_out(dt);
        }
    }
}

impl Controller {
    /// Reads the pins, executes commands, and computes all positions.
    pub(crate) fn advance(&mut self, dt: f64) {
        let now = self.clock.now_ns();
        let last = self.last_ns.replace(now).map_or(0, |last| now.wrapping_sub(last));
        self.pins.general.last_period.set(u32::try_from(last).unwrap_or(u32::MAX));
        self.state.dt = dt;
        self.state.now_ns = now;
        let before = self.state.inputs;
        self.state.read_pins(&self.pins);
        let failures = self.interlock.failures();
        // A failure that has ended since the last cycle counts too.
        let has_failed = self
            .failures
            .replace(failures.ever)
            .map_or(failures.now > 0, |last| last != failures.ever);
        self.state.inputs.lockout = self.interlock.read(has_failed || failures.now > 0);
        self.state.has_risen = false;
        let gaps = self.clock.gaps();
        if self.gaps.replace(gaps).is_some_and(|last| last != gaps) {
            self.state.note_unseen(Unseen::Gap, &self.pins);
        }
        if has_failed {
            self.state.note_unseen(Unseen::Hardware, &self.pins);
        }
        self.state.obey_line();
        self.state.note_stops(&before);
        self.state.switch_kinematics(&self.pins.switch);
        while let Some(command) = self.from.take() {
            // A stop that was commanded before this order comes before it.
            self.state.obey_line();
            self.state.execute(command);
        }
        self.state.guard(&self.pins);
        self.state.advance(&self.pins, dt);
        self.state.epoch = self.state.line.epoch().number();
    }

    /// Writes the pins and the snapshot.
    pub(crate) fn put_out(&mut self, dt: f64) {
        let s = &mut self.state;
        s.put_out(dt);
        s.watch(&self.pins, dt);
        s.follow_wait();
        s.find_feedback();
        self.cycle = self.cycle.wrapping_add(1);
        let enabled = s.is_on();
        let joints = s.joints.iter_mut().zip(&self.pins.joints).enumerate();
        let changed = joints.fold(0, |changed, (n, (joint, pins))| {
            changed | u32::from(joint.write_pins(pins, enabled)) << n
        });
        if s.module.is_some() {
            s.write_module_pins();
        }
        let cycle = Cycle {
            number: self.cycle,
            time_ns: self.last_ns.unwrap_or_default(),
            velocity: velocity(s),
        };
        self.status.publish(s, &self.pins.lists, cycle, changed);
        self.outputs.write_pins(s, &self.pins, self.status.record());
    }
}

/// Returns the current velocity: along the path, or of all jogs together.
fn velocity(s: &State) -> f64 {
    match s.mode() {
        Mode::Free => sqrt(s.active().map(|j| j.vel_cmd * j.vel_cmd).sum()),
        Mode::Teleop => sqrt(s.axes.iter().map(|a| a.teleop.tp.vel * a.teleop.tp.vel).sum()),
        Mode::Coord => s.path.velocity(),
    }
}
