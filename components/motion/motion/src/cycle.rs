//! Realtime. Update of positions in one cycle.

use crate::{
    axis,
    commands::command::Mode,
    commands::refusal::Refusal,
    jogger::TravelLimits,
    path::Parked,
    pins::Pins,
    state::{Inputs, State},
    switch::SwitchPins,
};
use hal_component::{Pose, Wait};
use hal_safety::Event;
use hal_trajectory::Scales;

impl State {
    /// Reads the pins.
    pub(crate) fn read_pins(&mut self, pins: &Pins) {
        let g = &pins.general;
        let before = self.inputs;
        self.inputs = Inputs {
            lockout: before.lockout,
            enable: g.enable.get(),
            jog_inhibit: g.jog_inhibit.get(),
            homing_inhibit: g.homing_inhibit.get(),
            jog_stop: g.jog_stop.get(),
            jog_stop_immediate: g.jog_stop_immediate.get(),
            probe: g.probe_input.get(),
        };
        if self.module.is_some() {
            self.read_module_pins();
        }
        for (joint, pins) in self.joints.iter_mut().zip(&pins.joints) {
            joint.read_pins(pins);
        }
        let locks = self.joints.iter_mut().map(|j| &mut j.lock).filter(|l| l.exists);
        for (lock, pins) in locks.zip(&pins.unlocks) {
            lock.read_pins(pins);
        }
        for (n, (spindle, pins)) in self.spindles.iter_mut().zip(&pins.spindles).enumerate() {
            spindle.read_pins(n, pins, self.dt, &self.say);
        }
        self.at_speed = true;
        for (spindle, pins) in self.spindles.iter_mut().zip(&pins.spindles) {
            spindle.at_speed = spindle.is_ready(pins);
            self.at_speed &= spindle.at_speed;
        }
        if self.inputs.probe && !before.probe {
            self.trip_probe();
        }
        if self.inputs.jog_stop && !before.jog_stop {
            self.tell(Event::JogStop { at_once: false }, "stopped by motion.jog-stop");
        }
        if self.inputs.jog_stop_immediate && !before.jog_stop_immediate {
            let why = "stopped by motion.jog-stop-immediate";
            self.tell(Event::JogStop { at_once: true }, why);
        }
        self.read_feed(pins);
    }

    /// Stops every jog without a ramp.
    pub(crate) fn halt_jogs(&mut self, why: &'static str) {
        let mut is_hard = false;
        for jogger in self.jogs() {
            is_hard |= jogger.tp.active;
            jogger.reset(jogger.tp.pos, why);
        }
        // What goes on, such as a path, is judged on.
        if is_hard {
            self.count_hard_stop();
        }
    }

    /// Computes the factors of feeds and of rapid moves. Adaptive feed and holds count for both.
    fn read_feed(&mut self, pins: &Pins) {
        let g = &pins.general;
        let mut scales = Scales { feed: self.feed.scale, rapid: self.feed.rapid };
        self.feed.reverse = false;
        if self.feed.adaptive {
            let wanted = g.adaptive_feed.get();
            let most = self.traj.max_feed_override;
            self.feed.reverse = wanted < 0.0;
            // NaN counts as zero.
            let wanted = if wanted.is_nan() { 0.0 } else { libm::fabs(wanted) };
            let factor = if wanted < most { wanted } else { most };
            scales = Scales { feed: scales.feed * factor, rapid: scales.rapid * factor };
        }
        let last = &mut self.feed.last;
        for (last, scale) in [(&mut last.feed, scales.feed), (&mut last.rapid, scales.rapid)] {
            *last = if scale > 0.0 { scale } else { *last };
        }
        let is_inhibited = g.feed_inhibit.get();
        let is_held = self.feed.hold && g.feed_hold.get();
        self.feed.retract = if is_inhibited { Scales::HOLD } else { self.feed.last };
        self.feed.held = match (is_inhibited, is_held) {
            (true, _) => Some(Wait::FeedInhibit),
            (false, true) => Some(Wait::FeedHold),
            (false, false) => None,
        };
        self.feed.net = if is_inhibited || is_held { Scales::HOLD } else { scales };
    }

    /// Switches to the kinematics type that the pin names, once nothing moves; the pose is then computed from the joints
    /// with the new type.
    pub(crate) fn switch_kinematics(&mut self, pins: &SwitchPins) {
        let requested = self.switch.requested(pins, self.kinematics.types(), &self.say);
        let Some((to, wanted)) = requested else { return };
        if to == self.switch.is || !self.is_idle() {
            return;
        }
        let before = self.switch.is;
        if !self.kinematics.switch(to) || !self.find_pose() {
            self.kinematics.switch(before);
            self.find_pose();
            let why = "the kinematics of type {} have no pose for these joints";
            return self.switch.refuse(wanted, why, &self.say);
        }
        if self.mode() != Mode::Free
            && let Err(why) = self.needs_pose()
        {
            self.kinematics.switch(before);
            self.find_pose();
            self.switch.refuse(wanted, "cannot switch to kinematics of type {}", &self.say);
            return why.say(&self.say);
        }
        self.switch.is = to;
        self.sync("the kinematics have changed");
    }

    /// Updates jog wheels and homing, then the position of every joint.
    pub(crate) fn advance(&mut self, pins: &Pins, dt: f64) {
        self.wheels(pins);
        self.homing_cycle(dt);
        self.on_soft_limit = false;
        self.offsets(pins, dt);
        if self.is_on() {
            match self.mode() {
                Mode::Free => self.free(dt),
                Mode::Teleop => self.teleop(dt),
                Mode::Coord => self.coord(dt),
            }
            self.extras(pins, dt);
        } else {
            for joint in &mut self.joints {
                joint.track_feedback("the machine is off");
            }
            self.sync("the machine is off");
        }
        let is_on = self.is_on();
        for joint in &mut self.joints {
            joint.correct(&self.tables, dt, is_on);
        }
        if self.has_locks {
            self.joints.iter_mut().for_each(|joint| joint.work_lock(is_on));
        }
        self.tell_spindles();
        self.end_override();
        self.end_ramp();
        if self.stop_ticket.is_some() {
            let rests = self.path.parked() != Parked::No && !self.is_jogging();
            if (self.is_idle() || rests)
                && let Some(ticket) = self.stop_ticket.take()
            {
                ticket.done();
            }
        }
    }

    fn wheels(&mut self, pins: &Pins) {
        if self.have_wheels_stopped(pins) {
            return;
        }
        let ready = self.is_wheel_turned(pins) && self.take_wheel();
        let allowed = ready && self.mode() == Mode::Free;
        for (joint, pins) in self.joints.iter_mut().zip(&pins.joints) {
            if joint.free.has_counted(pins.jog_counts) {
                continue;
            }
            let wheel = pins.wheel();
            let allowed = allowed && joint.active && joint.refuses_jog().is_none();
            let turned = allowed && joint.free.is_turned(&wheel);
            let limits = if turned { joint.jog_limits() } else { TravelLimits::default() };
            let inputs = joint.inputs;
            joint.free.wheel(&wheel, turned, || {
                // A joint may not move farther onto a limit switch that is overridden.
                let mut limits = limits;
                if inputs.at_max {
                    limits.max = f64::NEG_INFINITY;
                }
                if inputs.at_min {
                    limits.min = f64::INFINITY;
                }
                limits
            });
        }
        let allowed = ready && self.mode() == Mode::Teleop;
        for (n, pins) in pins.axes.iter().enumerate() {
            if self.axes.get(n).is_none_or(|a| a.teleop.has_counted(pins.jog_counts)) {
                continue;
            }
            let wheel = axis::wheel(pins);
            let turned = self.axes.get(n).is_some_and(|a| a.teleop.is_turned(&wheel));
            let limits = if allowed && turned { self.jog_limits(n).ok() } else { None };
            if let Some(axis) = self.axes.get_mut(n) {
                axis.teleop.wheel(&wheel, limits.is_some(), || limits.unwrap_or_default());
            }
        }
    }

    /// Returns whether all wheels are where they were in the last cycle.
    fn have_wheels_stopped(&self, pins: &Pins) -> bool {
        let mut joints = self.joints.iter().zip(&pins.joints);
        let mut axes = self.axes.iter().zip(&pins.axes);
        joints.all(|(joint, pins)| joint.free.has_counted(pins.jog_counts))
            && axes.all(|(axis, pins)| axis.teleop.has_counted(pins.jog_counts))
    }

    /// Returns whether a wheel that counts in this mode has turned.
    fn is_wheel_turned(&self, pins: &Pins) -> bool {
        match self.mode() {
            Mode::Free => {
                let mut joints = self.joints.iter().zip(&pins.joints);
                joints.any(|(joint, pins)| joint.active && joint.free.is_turned(&pins.wheel()))
            }
            Mode::Teleop => {
                let mut axes = self.axes.iter().zip(&pins.axes);
                axes.any(|(axis, pins)| axis.teleop.is_turned(&axis::wheel(pins)))
            }
            Mode::Coord => false,
        }
    }

    fn free(&mut self, dt: f64) {
        for joint in self.joints.iter_mut().filter(|j| j.active) {
            if !(joint.extra && joint.homing.homed) {
                joint.place_free(dt);
            }
        }
        self.find_pose();
    }

    fn teleop(&mut self, dt: f64) {
        let before = self.pose;
        for (axis, pos) in self.axes.iter_mut().zip(&mut self.pose) {
            axis.teleop.step(dt);
            *pos = axis.teleop.tp.pos;
        }
        if let Err(why) = self.place(&before, dt) {
            for (axis, pos) in self.axes.iter_mut().zip(before) {
                axis.teleop.reset(pos, why.text());
            }
            self.hold(before, why, dt);
        }
        if self.on_soft_limit {
            self.stop_jogs("a joint is beyond its limit");
        }
        self.end_return();
    }

    /// Moves the joints to the pose with the offsets.
    pub(crate) fn place(&mut self, before: &Pose, dt: f64) -> Result<(), Refusal> {
        let places = self.paced(before, dt)?;
        if self.has_locks
            && let Some(n) =
                self.joints.iter().zip(&places).position(|(j, place)| j.is_held(*place))
        {
            return Err(Refusal::joint(
                "a joint that would move is locked",
                "joint {} would move, and is locked",
                n,
            ));
        }
        self.on_soft_limit = false;
        for (joint, place) in self.joints.iter_mut().zip(&places) {
            if joint.active && !joint.extra {
                self.on_soft_limit |= joint.is_beyond(*place);
                joint.place(*place, dt);
            }
        }
        self.stays = None;
        Ok(())
    }

    /// Keeps joints, axes and offsets where they are. The operator receives the reason once, for as long as it lasts.
    pub(crate) fn hold(&mut self, before: Pose, why: Refusal, dt: f64) {
        self.pose = before;
        for axis in &mut self.axes {
            axis.offset.hold();
        }
        for joint in &mut self.joints {
            joint.place(joint.pos_cmd, dt);
        }
        if self.stays.replace(why.text()) != Some(why.text()) {
            why.say(&self.say);
        }
    }

    fn extras(&mut self, pins: &Pins, dt: f64) {
        let first = self.joints.len() - pins.extras.len();
        for (joint, pins) in self.joints.iter_mut().skip(first).zip(&pins.extras) {
            let pos = pins.posthome_cmd.get();
            if joint.active && joint.homing.homed && pos.is_finite() {
                joint.place(pos, dt);
                joint.free.tp.reset(pos);
            }
        }
    }

    /// Enforces limits again after the jog for which they were overridden.
    fn end_override(&mut self) {
        if !self.overriding {
            return;
        }
        if self.joints.iter().any(|j| j.free.tp.active) {
            self.override_moved = true;
        } else if self.override_moved {
            self.overriding = false;
            self.override_moved = false;
        }
    }
}
