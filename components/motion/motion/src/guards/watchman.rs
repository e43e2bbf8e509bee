//! Realtime. The watchman of the machine: judges all joints, writes its pins, and switches the machine off if it may.

use crate::{guards::watch::WatchCounters, pins::Pins, state::State};

const CAUSE: &str = "a joint broke its limits, and motion.watch.stop is TRUE";

impl State {
    /// Judges the commands of this cycle, writes the watchman's pins, and switches the machine off after a violation if
    /// it may.
    pub(crate) fn watch(&mut self, pins: &Pins, dt: f64) {
        if pins.watch.reset.get() {
            self.watch = WatchCounters::default();
            self.joints.iter_mut().for_each(|j| j.watch.forget());
        }
        let line = self.path.current().map_or(0, |c| c.line);
        let mut broken = None;
        for (n, joint) in self.joints.iter_mut().enumerate().filter(|(_, j)| j.active) {
            if joint.extra && joint.homing.homed {
                // It follows posthome-cmd, which no planner makes.
                joint.watch.stop();
                continue;
            }
            if !joint.watch.step(joint.step_guard.command(), dt, line) {
                self.watch.violations = self.watch.violations.wrapping_add(1);
                broken.get_or_insert(n);
            }
            let Some(worst) = pins.joints.get(n).and_then(|pins| joint.watch.write_pins(pins))
            else {
                continue;
            };
            if worst.ratio > self.watch.worst {
                self.watch.worst = worst.ratio;
                self.watch.joint = i32::try_from(n).unwrap_or(0);
                self.watch.line = worst.line.cast_signed();
            }
        }
        if let Some(n) = broken {
            self.report_violation(n, pins.watch.stop.get());
        }
        let (w, pins) = (&self.watch, &pins.watch);
        pins.violations.set(w.violations);
        pins.hard_stops.set(w.hard_stops);
        pins.worst.set(w.worst);
        pins.joint.set(w.joint);
        pins.line.set(w.line);
    }

    /// Reports the first violation; switches the machine off if the watchman may.
    fn report_violation(&mut self, n: usize, stops: bool) {
        let Some(joint) = self.joints.get_mut(n) else { return };
        if stops || !core::mem::replace(&mut self.watch.was_reported, true) {
            let r = joint.watch.report();
            let [n, line] = [n as f64, f64::from(r.velocity.line)];
            if r.jerk.ratio > 1.0 {
                let text = "joint {}: {} times its jerk and {} times its acceleration, line {}";
                self.say.error(text, &[n, r.jerk.ratio, r.acceleration.ratio, line]);
            } else {
                let text = "joint {}: {} times its velocity and {} times its acceleration, line {}";
                self.say.error(text, &[n, r.velocity.ratio, r.acceleration.ratio, line]);
            }
        }
        if stops {
            joint.error = true;
            self.stop_for(CAUSE);
        }
    }

    /// Counts a stop at once: not judged, because it is meant to break the limits.
    pub(crate) fn count_hard_stop(&mut self) {
        let mut moved = false;
        for joint in &mut self.joints {
            moved |= joint.watch.is_on && joint.watch.moves;
            joint.watch.stop();
        }
        if moved {
            self.watch.hard_stops = self.watch.hard_stops.wrapping_add(1);
        }
    }
}
