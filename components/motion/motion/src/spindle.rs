//! Realtime. One spindle.

use crate::{
    commands::config::SpindleConfig,
    pins::{Shown, SpindlePins, packed},
};
use hal_component::{Messages, TicketHandle};

/// Commanded state of a spindle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spindle {
    /// Speed in turns per minute, negative in reverse.
    speed: f64,
    on: bool,
    brake: bool,
    pub(crate) scale: f64,
    /// True if moves need not wait for the spindle, in this cycle.
    pub(crate) at_speed: bool,
    pub(crate) config: SpindleConfig,
    orient: Orient,
    /// Fault that ended the last orientation; 0 is none.
    fault: i32,
    /// Angle and direction of the last orientation.
    angle: f64,
    mode: i32,
    pub(crate) inputs: SpindleInputs,
    /// True while a move waits for the index.
    seeks: bool,
    /// Pending value of index-enable.
    index_enable: Option<bool>,
    /// Distance of the axes from their place at this spindle.
    pub(crate) sync_error: f64,
    shown: Shown<4>,
}

/// Inputs of this cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SpindleInputs {
    /// Turns since the index.
    pub(crate) revs: f64,
    /// Measured speed in turns per second.
    pub(crate) speed: f64,
    pub(crate) index_enable: bool,
}

/// State of an orientation.
#[derive(Clone, Copy, Debug, Default)]
enum Orient {
    #[default]
    Nowhere,
    /// In progress. `is_again`: it replaces an orientation to another angle, so the pin `orient` must fall for a cycle.
    /// `late`: time in seconds for which is-oriented has been TRUE although the spindle turned.
    Turning {
        ticket: TicketHandle,
        is_again: bool,
        late: f64,
    },
    Locked,
}

/// Maximum speed of a spindle that counts as at rest, in turns per second: a degree in 28 ms.
const STANDSTILL: f64 = 0.1;

/// Time in seconds for which is-oriented may be TRUE on a turning spindle before the operator is informed.
const LATE: f64 = 1.0;

impl Default for Spindle {
    fn default() -> Self {
        Self {
            speed: 0.0,
            on: false,
            brake: false,
            scale: 1.0,
            at_speed: true,
            config: SpindleConfig::default(),
            orient: Orient::Nowhere,
            fault: 0,
            angle: 0.0,
            mode: 0,
            inputs: SpindleInputs::default(),
            seeks: false,
            index_enable: None,
            sync_error: 0.0,
            shown: Shown::default(),
        }
    }
}

impl Spindle {
    /// Turns the spindle; zero stops it.
    pub(crate) fn turn(&mut self, speed: f64) {
        self.stop("the spindle was commanded to turn or to stop");
        if speed != 0.0 {
            *self = Self { speed, on: true, brake: false, ..*self };
        }
    }

    /// Returns the commanded speed in turns per minute, without override.
    pub(crate) const fn speed(&self) -> f64 {
        self.speed
    }

    pub(crate) const fn has_brake(&self) -> bool {
        self.brake
    }

    pub(crate) const fn brake(&mut self, brake: bool) {
        self.brake = brake;
    }

    pub(crate) fn stop(&mut self, why: &'static str) {
        if let Orient::Turning { ticket, .. } = self.orient {
            ticket.fail(why);
        }
        *self = Self { speed: 0.0, on: false, brake: true, orient: Orient::Nowhere, ..*self };
    }

    /// Stops the spindle and orients it to an angle; the ticket is done when it is at rest there.
    pub(crate) fn orient(&mut self, angle: f64, mode: i32, ticket: TicketHandle) {
        let is_again = matches!(self.orient, Orient::Turning { .. });
        self.stop("the spindle was commanded to orient");
        let orient = Orient::Turning { ticket, is_again, late: 0.0 };
        *self = Self { brake: false, orient, fault: 0, angle, mode, ..*self };
    }

    /// Returns the state of the orientation (0 none, 1 oriented, 2 in progress), and the fault that ended the last one.
    pub(crate) const fn orientation(&self) -> (u32, i32) {
        let state = match self.orient {
            Orient::Nowhere => 0,
            Orient::Locked => 1,
            Orient::Turning { .. } => 2,
        };
        (state, self.fault)
    }

    /// Reads the pins; `n` is the number of the spindle.
    pub(crate) fn read_pins(&mut self, n: usize, pins: &SpindlePins, dt: f64, say: &Messages) {
        self.inputs = SpindleInputs {
            revs: pins.revs.get(),
            speed: pins.speed_in.get(),
            index_enable: pins.index_enable.get(),
        };
        let Orient::Turning { ticket, is_again, late } = &mut self.orient else { return };
        if core::mem::take(is_again) {
            // An is-oriented that belongs to the previous angle does not count.
            return;
        }
        let (fault, speed) = (pins.orient_fault.get(), self.inputs.speed);
        if fault != 0 {
            say.error("spindle {} orient fault {}", &[n as f64, f64::from(fault)]);
            self.stop("spindle orient fault");
            self.fault = fault;
            return;
        }
        if !pins.is_oriented.get() {
            return;
        }
        if speed.abs() <= STANDSTILL {
            ticket.done();
            *self = Self { brake: true, orient: Orient::Locked, ..*self };
            return;
        }
        let before = *late;
        *late += dt;
        if before < LATE && LATE <= *late {
            let text = "spindle {} is not locked: is-oriented is TRUE, but speed-in is {} turns/s";
            say.error(text, &[n as f64, speed]);
        }
    }

    /// Returns whether moves need not wait for the spindle.
    pub(crate) fn is_ready(&self, pins: &SpindlePins) -> bool {
        !self.on || pins.at_speed.get()
    }

    /// Arms or disarms the handshake with the encoder's index.
    pub(crate) const fn seek_index(&mut self, seeks: bool) {
        if seeks != self.seeks {
            (self.seeks, self.index_enable) = (seeks, Some(seeks));
        }
    }

    /// Writes the pins.
    pub(crate) fn write_pins(&mut self, pins: &SpindlePins) {
        let runs = self.on && !pins.inhibit.get();
        let speed = if runs { self.config.limited(self.speed * self.scale) } else { 0.0 };
        let orients = matches!(self.orient, Orient::Turning { is_again: false, .. });
        let is_locked = matches!(self.orient, Orient::Locked);
        let state = packed([runs, self.brake, orients, is_locked]);
        let changed = self.shown.changes([
            state | u64::from(self.mode.cast_unsigned()) << 32,
            speed.to_bits(),
            self.speed.to_bits(),
            self.angle.to_bits(),
        ]);
        if changed {
            pins.on.set(runs);
            pins.forward.set(speed > 0.0);
            pins.reverse.set(speed < 0.0);
            pins.brake.set(self.brake);
            pins.speed_out.set(speed);
            pins.speed_out_abs.set(speed.abs());
            pins.speed_out_rps.set(speed / 60.0);
            pins.speed_out_rps_abs.set(speed.abs() / 60.0);
            pins.speed_cmd_rps.set(self.speed / 60.0);
            pins.orient.set(orients);
            pins.locked.set(is_locked);
            pins.orient_angle.set(self.angle);
            pins.orient_mode.set(self.mode);
        }
        pins.sync_error.set(self.sync_error);
        if let Some(value) = self.index_enable.take() {
            pins.index_enable.set(value);
        }
    }
}
