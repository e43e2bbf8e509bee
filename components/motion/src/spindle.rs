//! Realtime. One spindle.

use crate::pins::SpindlePins;
use hal_component::{Messages, TicketHandle};

/// A spindle as it was commanded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spindle {
    /// Turns per minute, negative in reverse.
    speed: f64,
    on: bool,
    brake: bool,
    pub(crate) scale: f64,
    orient: Orient,
    /// The angle and direction that were asked for last.
    angle: f64,
    mode: i32,
}

/// Whether it stands at an angle.
#[derive(Clone, Copy, Debug, Default)]
enum Orient {
    #[default]
    Nowhere,
    Turning(TicketHandle),
    Locked,
}

impl Default for Spindle {
    fn default() -> Self {
        Self {
            speed: 0.0,
            on: false,
            brake: false,
            scale: 1.0,
            orient: Orient::Nowhere,
            angle: 0.0,
            mode: 0,
        }
    }
}

impl Spindle {
    /// Turns; zero stops.
    pub(crate) fn turn(&mut self, speed: f64) {
        self.stop("the spindle was told to turn or to stop");
        if speed != 0.0 {
            *self = Self { speed, on: true, brake: false, ..*self };
        }
    }

    pub(crate) const fn brake(&mut self, brake: bool) {
        self.brake = brake;
    }

    pub(crate) fn stop(&mut self, why: &'static str) {
        if let Orient::Turning(ticket) = self.orient {
            ticket.fail(why);
        }
        *self = Self { speed: 0.0, on: false, brake: true, orient: Orient::Nowhere, ..*self };
    }

    /// Stops, and is to stand at an angle; the ticket is done when it does.
    pub(crate) fn orient(&mut self, angle: f64, mode: i32, ticket: TicketHandle) {
        self.stop("the spindle was told to orient");
        *self = Self { brake: false, orient: Orient::Turning(ticket), angle, mode, ..*self };
    }

    /// Reads the pins; `n` is its number.
    pub(crate) fn sense(&mut self, n: usize, pins: &SpindlePins, say: &Messages) {
        let Orient::Turning(ticket) = self.orient else { return };
        let fault = pins.orient_fault.get();
        if fault != 0 {
            say.error("spindle {} orient fault {}", &[n as f64, f64::from(fault)]);
            self.stop("spindle orient fault");
        } else if pins.is_oriented.get() {
            ticket.done();
            *self = Self { brake: true, orient: Orient::Locked, ..*self };
        }
    }

    /// Whether moves need not wait for it.
    pub(crate) fn is_ready(&self, pins: &SpindlePins) -> bool {
        !self.on || pins.at_speed.get()
    }

    /// Writes the pins.
    pub(crate) fn show(&self, pins: &SpindlePins) {
        let runs = self.on && !pins.inhibit.get();
        let speed = if runs { self.speed * self.scale } else { 0.0 };
        pins.on.set(runs);
        pins.forward.set(speed > 0.0);
        pins.reverse.set(speed < 0.0);
        pins.brake.set(self.brake);
        pins.speed_out.set(speed);
        pins.speed_out_abs.set(speed.abs());
        pins.speed_out_rps.set(speed / 60.0);
        pins.speed_out_rps_abs.set(speed.abs() / 60.0);
        pins.speed_cmd_rps.set(self.speed / 60.0);
        pins.orient.set(matches!(self.orient, Orient::Turning(_)));
        pins.locked.set(matches!(self.orient, Orient::Locked));
        pins.orient_angle.set(self.angle);
        pins.orient_mode.set(self.mode);
    }
}
