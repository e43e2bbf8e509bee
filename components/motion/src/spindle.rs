//! Realtime. One spindle.

use crate::pins::SpindlePins;

/// A spindle as it was commanded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spindle {
    /// Turns per minute, negative in reverse.
    speed: f64,
    on: bool,
    brake: bool,
    pub(crate) scale: f64,
}

impl Default for Spindle {
    fn default() -> Self {
        Self { speed: 0.0, on: false, brake: false, scale: 1.0 }
    }
}

impl Spindle {
    /// Turns; zero stops.
    pub(crate) fn turn(&mut self, speed: f64) {
        if speed == 0.0 {
            self.stop();
        } else {
            *self = Self { speed, on: true, brake: false, ..*self };
        }
    }

    pub(crate) const fn brake(&mut self, brake: bool) {
        self.brake = brake;
    }

    pub(crate) const fn stop(&mut self) {
        *self = Self { speed: 0.0, on: false, brake: true, scale: self.scale };
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
    }
}
