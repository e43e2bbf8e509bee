//! Realtime. The two functions: one receives commands, the other executes them and moves.

use crate::{
    commands::command::{Command, Mode},
    guards::interlock::Interlock,
    path::order::HandOver,
    pins::{GeneralPins, Pins},
    state::State,
    status,
};
use hal_component::{
    Clock, Gives, KinematicsRef, MotionStatus, Period, Receiver, Sender, Snapshot, Touch, Update,
};
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
    /// Number of cycles so far.
    #[state]
    pub(crate) cycle: u64,
    pub(crate) status: Snapshot<MotionStatus>,
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
        self.state.read_pins(&self.pins);
        self.state.inputs.lockout = self.interlock.read();
        self.state.switch_kinematics(&self.pins.switch);
        while let Some(command) = self.from.take() {
            self.state.execute(command);
        }
        self.state.guard(&self.pins);
        self.state.advance(&self.pins, dt);
    }

    /// Writes the pins and the snapshot.
    pub(crate) fn put_out(&mut self, dt: f64) {
        self.state.put_out(dt);
        self.state.watch(&self.pins, dt);
        self.state.find_feedback();
        self.cycle = self.cycle.wrapping_add(1);
        let time_ns = self.last_ns.unwrap_or_default();
        let velocity = velocity(&self.state);
        let status = status::of(&self.state, &self.pins.lists, self.cycle, time_ns, velocity);
        write_pins(&mut self.state, &self.pins, &status);
        self.status.set(&status);
    }
}

fn write_pins(s: &mut State, pins: &Pins, status: &MotionStatus) {
    for (joint, pins) in s.joints.iter_mut().zip(&pins.joints) {
        joint.write_pins(pins, s.enabled);
    }
    for (lock, pins) in s.joints.iter().map(|j| &j.lock).filter(|l| l.exists).zip(&pins.unlocks) {
        lock.write_pins(pins);
    }
    for ((axis, pins), pos) in s.axes.iter().zip(&pins.axes).zip(s.pose) {
        axis.write_pins(pins, pos);
    }
    for (spindle, pins) in s.spindles.iter_mut().zip(&pins.spindles) {
        spindle.write_pins(pins);
    }
    for (pin, value) in pins.lists.digital_out.iter().zip(&s.digital_out) {
        pin.set(*value);
    }
    for (pin, value) in pins.lists.analog_out.iter().zip(&s.analog_out) {
        pin.set(*value);
    }
    let g = &pins.general;
    g.motion_enabled.set(s.enabled);
    g.in_position.set(status.in_position);
    g.coord_mode.set(s.mode == Mode::Coord);
    g.teleop_mode.set(s.mode == Mode::Teleop);
    g.tp_reverse.set(status.reverse);
    g.coord_error.set(s.coord_error);
    g.on_soft_limit.set(s.on_soft_limit);
    let (active, limited) = s.is_offset();
    g.eoffset_active.set(active);
    g.eoffset_limited.set(limited);
    g.is_all_homed.set(status.all_homed);
    g.jog_is_active.set(status.jogging);
    g.current_vel.set(status.velocity);
    g.distance_to_go.set(status.distance_to_go);
    g.motion_type.set(status.motion_type.cast_signed());
    g.program_line.set(status.line.cast_signed());
    g.requested_vel.set(status.requested_velocity);
    let (_, feed) = s.path.feeds();
    g.interp_iscircle.set(status.motion_type == 3);
    g.interp_feedrate.set(status.requested_velocity);
    let ([x, y, z], radius) = s.path.circle();
    g.interp_arc_center_x.set(x);
    g.interp_arc_center_y.set(y);
    g.interp_arc_center_z.set(z);
    g.interp_arc_radius.set(radius);
    let (heading, left) = s.path.headings();
    g.interp_heading.set(heading);
    g.interp_normal_heading.set(left);
    g.interp_line_number.set(status.line.cast_signed());
    g.interp_motion_type.set(status.motion_type.cast_signed());
    let tool = [
        &g.tooloffset_x,
        &g.tooloffset_y,
        &g.tooloffset_z,
        &g.tooloffset_a,
        &g.tooloffset_b,
        &g.tooloffset_c,
        &g.tooloffset_u,
        &g.tooloffset_v,
        &g.tooloffset_w,
    ];
    for (pin, offset) in tool.into_iter().zip(&s.tool_offset) {
        pin.set(*offset);
    }
    let (travelled, along) = s.path.along();
    let t = &pins.traces;
    t.tc_0_pos.set(travelled);
    t.tc_0_vel.set(along);
    t.traj_pos_out.set(travelled);
    t.traj_vel_out.set(along);
    t.traj_active_tc.set(status.segment);
    write_feed(g, feed, s.traj.units_per_mm);
}

fn write_feed(g: &GeneralPins, feed: f64, units_per_mm: f64) {
    let mm = feed / units_per_mm;
    let inches = mm / 25.4;
    g.feed_upm.set(feed * 60.0);
    g.feed_mm_per_second.set(mm);
    g.feed_mm_per_minute.set(mm * 60.0);
    g.feed_inches_per_second.set(inches);
    g.feed_inches_per_minute.set(inches * 60.0);
}

/// Returns the current velocity: along the path, or of all jogs together.
fn velocity(s: &State) -> f64 {
    match s.mode {
        Mode::Free => sqrt(s.active().map(|j| j.vel_cmd * j.vel_cmd).sum()),
        Mode::Teleop => sqrt(s.axes.iter().map(|a| a.teleop.tp.vel * a.teleop.tp.vel).sum()),
        Mode::Coord => s.path.velocity(),
    }
}
