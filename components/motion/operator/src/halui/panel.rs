//! The panel: one look at all pins.

use super::{
    groups::{
        General, Jog, Joint, Knob, Modes, Positions, Program, Selected, Speeds, Spindle, Stick,
        Tool,
    },
    jog::{Jogging, Kind, Pace},
    link::Machine,
};
use crate::pins::Button;
use hal_component::{
    IoRequest, MotionCommand, MotionStatus, OperatorRequest, OperatorView, Out, Period, Touch,
    Update, motion_flags as flags, motion_kind as kind,
};
use libm::{cos, sin};

/// Step of the buttons that change the speed of a spindle, in turns per minute.
const SPINDLE_STEP: f64 = 100.0;

/// A spindle of the panel.
#[derive(Debug, Touch)]
pub(crate) struct SpindlePart {
    pub(crate) pins: Spindle,
    pub(crate) knob: Knob,
    /// Last speed in turns per minute, without sign.
    #[state]
    pub(crate) speed: f64,
}

/// A joint of the panel.
#[derive(Debug, Touch)]
pub(crate) struct JointPart {
    pub(crate) pins: Joint,
    pub(crate) lamp: Selected,
    pub(crate) jog: Jog,
    pub(crate) stick: Stick,
    #[state]
    pub(crate) jogging: Jogging,
}

/// An axis of the panel.
#[derive(Debug, Touch)]
pub(crate) struct AxisPart {
    pub(crate) jog: Jog,
    pub(crate) stick: Stick,
    /// Lamp and positions, if the machine has the axis.
    pub(crate) shown: Option<(Selected, Positions)>,
    #[state]
    pub(crate) jogging: Jogging,
}

/// All pins of `halui`.
#[derive(Debug, Touch)]
pub(crate) struct Panel {
    pub(crate) machine: Machine,
    pub(crate) general: General,
    pub(crate) modes: Modes,
    pub(crate) program: Program,
    pub(crate) tool: Tool,
    pub(crate) offsets: Vec<Out<f64>>,
    pub(crate) feed: Knob,
    pub(crate) rapid: Knob,
    pub(crate) velocity: Knob,
    pub(crate) spindles: Vec<SpindlePart>,
    pub(crate) joint_speeds: Speeds,
    pub(crate) joints: Vec<JointPart>,
    pub(crate) joint: Joint,
    pub(crate) joint_jog: Jog,
    #[state]
    pub(crate) joint_jogging: Jogging,
    pub(crate) axis_speeds: Speeds,
    pub(crate) axes: Vec<AxisPart>,
    pub(crate) axis_jog: Jog,
    #[state]
    pub(crate) axis_jogging: Jogging,
    pub(crate) mdi: Vec<Button>,
    /// Lines of MDI, one for each button.
    #[state]
    pub(crate) lines: Vec<String>,
    /// Selected joint and axis.
    #[state]
    pub(crate) selected: (u32, u32),
    /// Highest velocity of coordinated moves that the machine was configured with.
    #[state]
    pub(crate) top_velocity: Option<f64>,
}

impl Update for Panel {
    fn update(&mut self, _: Period) {
        let view = self.machine.task.view();
        self.buttons(view.is_some());
        self.modes();
        self.program(view.is_some());
        for (button, line) in self.mdi.iter_mut().zip(&self.lines) {
            if button.is_pressed() {
                self.machine.task(OperatorRequest::Mdi(line.clone()));
            }
        }
        let Some(status) = self.machine.motion.status() else { return };
        self.dials(&status);
        self.turn_spindles(&status);
        self.move_joints();
        self.move_axes();
        self.show(&status, view.as_ref());
    }
}

impl Panel {
    fn buttons(&mut self, has_task: bool) {
        let (g, m) = (&mut self.general, &self.machine);
        if g.estop.is_pressed() {
            m.estop();
        }
        if g.estop_reset.is_pressed() {
            m.io(IoRequest::EstopReset);
        }
        if g.abort.is_pressed() | self.program.stop.is_pressed() {
            m.abort();
        }
        if g.off.is_pressed() {
            m.simple(kind::DISABLE);
        }
        if g.on.is_pressed() {
            // A task switches motion off again in e-stop; without one, motion alone decides.
            let is_held = m.io_state().is_some_and(|io| !io.estop.is_released());
            if has_task && is_held {
                m.say.error("the machine is in e-stop: estop.reset comes first", &[]);
            } else {
                m.simple(kind::ENABLE);
            }
        }
        if g.home_all.is_pressed() {
            m.motion(&MotionCommand { flags: flags::ALL, ..MotionCommand::new(kind::HOME) });
        }
        let set = |on: bool, off: bool| if off { Some(false) } else { on.then_some(true) };
        let flood = set(g.flood_on.is_pressed(), g.flood_off.is_pressed());
        let mist = set(g.mist_on.is_pressed(), g.mist_off.is_pressed());
        let lube = set(g.lube_on.is_pressed(), g.lube_off.is_pressed());
        if flood.is_some() || mist.is_some() || lube.is_some() {
            m.io(IoRequest::Coolant { mist, flood, lube });
        }
    }

    fn modes(&mut self) {
        let (p, m) = (&mut self.modes, &self.machine);
        for (button, mode) in [(&mut p.manual, 0), (&mut p.auto, 1), (&mut p.mdi, 2)] {
            if button.is_pressed() {
                m.task(OperatorRequest::Mode(mode));
            }
        }
        for (button, mode) in [(&mut p.joint, 0), (&mut p.teleop, 1)] {
            if button.is_pressed() {
                m.motion(&MotionCommand { mode, ..MotionCommand::new(kind::MODE) });
            }
        }
    }

    fn program(&mut self, has_task: bool) {
        let (p, m) = (&mut self.program, &self.machine);
        if p.run.is_pressed() {
            m.task(OperatorRequest::Run);
        }
        if p.pause.is_pressed() {
            m.simple(kind::PAUSE);
        }
        for (button, request, command) in [
            (&mut p.resume, OperatorRequest::Resume, kind::RESUME),
            (&mut p.step, OperatorRequest::Step, kind::STEP),
        ] {
            match (button.is_pressed(), has_task) {
                (false, _) => {}
                (true, true) => m.task(request),
                (true, false) => m.simple(command),
            }
        }
        for (button, request) in [
            (&mut p.stop_on, OperatorRequest::OptionalStop(true)),
            (&mut p.stop_off, OperatorRequest::OptionalStop(false)),
            (&mut p.delete_on, OperatorRequest::BlockDelete(true)),
            (&mut p.delete_off, OperatorRequest::BlockDelete(false)),
        ] {
            if button.is_pressed() {
                m.task(request);
            }
        }
    }

    fn dials(&mut self, status: &MotionStatus) {
        let m = &self.machine;
        if let Some(scale) = self.feed.turn(status.feed_override) {
            let feed = MotionCommand::new(kind::FEED);
            m.motion(&MotionCommand { flags: flags::HAS_SCALE, scale, ..feed });
        }
        let rapid = status.rapid_override;
        // Rapid moves are never faster than the machine's limits.
        if let Some(value) = self.rapid.turn(rapid).map(|scale| scale.min(1.0))
            && value != rapid
        {
            let feed = MotionCommand::new(kind::FEED);
            m.motion(&MotionCommand { flags: flags::HAS_RAPID, value, ..feed });
        }
        let now = status.max_velocity;
        let top = *self.top_velocity.get_or_insert(now);
        if let Some(value) = self.velocity.turn(now) {
            // Motion needs a velocity above 0.
            let value = if value > top { top } else { value };
            if value > 0.0 {
                m.motion(&MotionCommand { value, ..super::configure(0, "max-velocity") });
            }
        }
    }

    fn turn_spindles(&mut self, status: &MotionStatus) {
        let m = &self.machine;
        for (n, spindle) in self.spindles.iter_mut().enumerate() {
            let index = u32::try_from(n).unwrap_or(u32::MAX);
            let speed = status.spindle_speed.get(n).copied().unwrap_or(0.0);
            let scale = status.spindle_override.get(n).copied().unwrap_or(1.0);
            if speed != 0.0 {
                spindle.speed = speed.abs();
            }
            let command = MotionCommand { index, ..MotionCommand::new(kind::SPINDLE) };
            let turn_at = |speed: f64| {
                m.motion(&MotionCommand { flags: flags::HAS_SPEED, speed, ..command });
            };
            let p = &mut spindle.pins;
            let forward = p.start.is_pressed() | p.forward.is_pressed();
            let reverse = p.reverse.is_pressed();
            let step = f64::from(p.increase.is_pressed()) - f64::from(p.decrease.is_pressed());
            if p.stop.is_pressed() {
                turn_at(0.0);
            } else if (forward || reverse) && spindle.speed == 0.0 {
                let text = "spindle {} has no speed yet: motion.spindle or S gives one";
                m.say.error(text, &[n as f64]);
            } else if forward != reverse {
                turn_at(if forward { spindle.speed } else { -spindle.speed });
            } else if step != 0.0 && speed != 0.0 {
                let faster = speed.abs() + step * SPINDLE_STEP;
                turn_at(if faster > 0.0 { faster.copysign(speed) } else { 0.0 });
            }
            let (on, off) = (p.brake_on.is_pressed(), p.brake_off.is_pressed());
            if on != off {
                let brake = flags::HAS_BRAKE | if on { flags::BRAKE } else { 0 };
                m.motion(&MotionCommand { flags: brake, ..command });
            }
            if let Some(scale) = spindle.knob.turn(scale) {
                m.motion(&MotionCommand { flags: flags::HAS_SCALE, scale, ..command });
            }
            let p = &spindle.pins;
            p.is_on.set(speed != 0.0);
            p.is_forward.set(speed > 0.0);
            p.is_backward.set(speed < 0.0);
            p.is_brake.set(status.spindle_brake.get(n).copied().unwrap_or(false));
        }
    }

    fn move_joints(&mut self) {
        let (m, pins) = (&self.machine, &self.joint_speeds);
        let pace = Pace { speed: pins.speed.get(), deadband: pins.deadband.get() };
        for (n, joint) in (0_u32..).zip(&mut self.joints) {
            if joint.stick.select.is_pressed() {
                self.selected.0 = n;
            }
            home(m, n, &mut joint.pins);
            let analog = joint.stick.analog.get();
            joint.jogging.step(m, Kind::Joint, n, &mut joint.jog, analog, pace);
        }
        home(m, self.selected.0, &mut self.joint);
        self.joint_jogging.step(m, Kind::Joint, self.selected.0, &mut self.joint_jog, 0.0, pace);
    }

    fn move_axes(&mut self) {
        let (m, pins) = (&self.machine, &self.axis_speeds);
        let pace = Pace { speed: pins.speed.get(), deadband: pins.deadband.get() };
        for (n, axis) in (0_u32..).zip(&mut self.axes) {
            if axis.stick.select.is_pressed() && axis.shown.is_some() {
                self.selected.1 = n;
            }
            let analog = axis.stick.analog.get();
            axis.jogging.step(m, Kind::Axis, n, &mut axis.jog, analog, pace);
        }
        self.axis_jogging.step(m, Kind::Axis, self.selected.1, &mut self.axis_jog, 0.0, pace);
    }

    fn show(&self, s: &MotionStatus, view: Option<&OperatorView>) {
        let io = self.machine.io_state();
        let g = &self.general;
        g.is_on.set(s.enabled);
        g.units_per_mm.set(s.units_per_mm);
        g.is_estop.set(io.map_or(s.estop, |io| !io.estop.is_released()));
        g.is_flood.set(io.is_some_and(|io| io.flood));
        g.is_mist.set(io.is_some_and(|io| io.mist));
        g.is_lube.set(io.is_some_and(|io| io.lube));
        self.tool.number.set(io.map_or(0, |io| u32::try_from(io.tool).unwrap_or(0)));
        let shown =
            view.copied().unwrap_or(OperatorView { zero: s.tool_offset, ..OperatorView::IDLE });
        self.tool.diameter.set(shown.tool_diameter);
        for (pin, offset) in self.offsets.iter().zip(s.tool_offset) {
            pin.set(offset);
        }
        let p = &self.modes;
        p.is_manual.set(shown.mode == 0);
        p.is_auto.set(shown.mode == 1);
        p.is_mdi.set(shown.mode == 2);
        p.is_joint.set(s.mode == 0);
        p.is_teleop.set(s.mode == 1);
        let p = &self.program;
        p.is_idle.set(shown.program == 0);
        p.is_running.set(shown.program == 1);
        p.is_paused.set(shown.program == 2);
        p.is_stop.set(shown.optional_stop != 0);
        p.is_delete.set(shown.block_delete != 0);
        self.show_selected();
        self.show_joints(s);
        self.show_axes(s, &shown);
    }

    /// Shows which joint and which axis are selected.
    pub(crate) fn show_selected(&self) {
        let (joint, axis) = self.selected;
        self.joint_speeds.selected.set(joint);
        self.axis_speeds.selected.set(axis);
        for (n, part) in (0_u32..).zip(&self.joints) {
            part.lamp.is_selected.set(n == joint);
        }
        for (n, part) in (0_u32..).zip(&self.axes) {
            if let Some((lamp, _)) = &part.shown {
                lamp.is_selected.set(n == axis);
            }
        }
    }

    fn show_joints(&self, s: &MotionStatus) {
        for (n, joint) in self.joints.iter().enumerate() {
            show_joint(&joint.pins, n, s);
        }
        show_joint(&self.joint, self.selected.0 as usize, s);
    }

    fn show_axes(&self, s: &MotionStatus, view: &OperatorView) {
        let mut relative = s.pose_feedback;
        for (place, zero) in relative.iter_mut().zip(view.zero) {
            *place -= zero;
        }
        let [x, y, ..] = relative;
        let (sine, cosine) = (sin(view.rotation.to_radians()), cos(view.rotation.to_radians()));
        if view.rotation != 0.0 {
            relative[0] = x * cosine + y * sine;
            relative[1] = y * cosine - x * sine;
        }
        let values = s.pose.iter().zip(&s.pose_feedback).zip(&relative);
        for (axis, ((commanded, feedback), relative)) in self.axes.iter().zip(values) {
            if let Some((_, pins)) = &axis.shown {
                pins.commanded.set(*commanded);
                pins.feedback.set(*feedback);
                pins.relative.set(*relative);
            }
        }
    }
}

fn home(machine: &Machine, index: u32, pins: &mut Joint) {
    for (button, what) in [(&mut pins.home, kind::HOME), (&mut pins.unhome, kind::UNHOME)] {
        if button.is_pressed() {
            machine.motion(&MotionCommand { index, ..MotionCommand::new(what) });
        }
    }
}

fn show_joint(pins: &Joint, n: usize, s: &MotionStatus) {
    let of = |list: &[bool; 16]| list.get(n).copied().unwrap_or(false);
    pins.is_homed.set(of(&s.joint_homed));
    pins.has_fault.set(of(&s.joint_fault));
    pins.at_max.set(of(&s.joint_at_max));
    pins.at_min.set(of(&s.joint_at_min));
    pins.above.set(s.joints_above >> n & 1 == 1);
    pins.below.set(s.joints_below >> n & 1 == 1);
    pins.overrides.set(s.overriding_limits);
}
