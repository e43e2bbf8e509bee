//! Realtime. Causes that switch the machine off.

use crate::{commands::refusal::Refusal, joint::Joint, pins::Pins, state::State};

impl State {
    /// Checks every cause to switch off; completes the ticket of the enable command.
    pub(crate) fn guard(&mut self, pins: &Pins) {
        if self.enabled
            && let Some(cause) = self.cause(pins)
        {
            self.stop_for(cause);
        }
        if let Some(ticket) = self.enable_ticket.take() {
            ticket.done();
        }
    }

    /// Returns the first cause to switch off; reports all causes to the operator.
    fn cause(&mut self, pins: &Pins) -> Option<&'static str> {
        let mut cause = None;
        if let Some(lockout) = self.inputs.lockout {
            self.say.error(lockout.cause(), &[]);
            cause.get_or_insert(lockout.cause());
        } else if !self.inputs.enable {
            self.say.error("motion stopped by enable input", &[]);
            cause.get_or_insert("motion stopped by enable input");
        }
        for (n, _) in pins.spindles.iter().enumerate().filter(|(_, s)| s.amp_fault_in.get()) {
            self.say.error("spindle {} amplifier fault", &[n as f64]);
            cause.get_or_insert("spindle amplifier fault");
        }
        let troubled = |j: &Joint| {
            let inputs = &j.inputs;
            inputs.at_max | inputs.at_min | inputs.amp_fault | j.was_ferrored
        };
        if self.joints.iter().any(troubled) {
            self.judge_joints(&mut cause);
        }
        for (n, _) in pins.lists.misc_errors.iter().enumerate().filter(|(_, e)| e.get()) {
            self.say.error("Motion Stopped by misc error {}", &[n as f64]);
            cause.get_or_insert("motion stopped by misc error");
        }
        cause
    }

    /// Reports joints on switches, with faults, or with following errors.
    fn judge_joints(&mut self, cause: &mut Option<&'static str>) {
        for (n, joint) in self.joints.iter_mut().enumerate().filter(|(_, j)| j.active) {
            let on_switch = joint.inputs.at_max || joint.inputs.at_min;
            let mut trip = |text, why| {
                self.say.error(text, &[n as f64]);
                joint.error = true;
                cause.get_or_insert(why);
            };
            if on_switch && !self.overriding && !joint.homing.has_limits() {
                trip("joint {} on limit switch error", "joint on limit switch error");
            }
            if joint.inputs.amp_fault {
                trip("joint {} amplifier fault", "joint amplifier fault");
            }
        }
        for (n, joint) in self.joints.iter_mut().enumerate().filter(|(_, j)| j.is_ferrored()) {
            self.say.error("joint {} following error", &[n as f64]);
            joint.error = true;
            cause.get_or_insert("joint following error");
        }
    }

    /// Switches the machine off for a cause that is kept.
    pub(crate) fn stop_for(&mut self, cause: &'static str) {
        self.stops.keep(self.now_ns, cause);
        self.raise_epoch();
        self.turn_off(cause);
    }

    /// Switches the machine off: all motion ends, and all tickets that wait for motion are refused.
    pub(crate) fn turn_off(&mut self, cause: &'static str) {
        self.enabled = false;
        self.count_hard_stop();
        self.path.clear(Refusal::new(cause));
        self.end_homing(cause);
        for joint in &mut self.joints {
            joint.homing.homed &= !joint.config.home.is_volatile;
            joint.track_feedback(cause);
        }
        self.unhome_volatile();
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
