//! Realtime. One spindle.

use crate::{
    commands::{config::SpindleConfig, refusal::Refusal},
    pins::{Shown, SpindlePins, packed},
};
use hal_component::{Messages, MotionSource, TicketHandle};

/// Commanded state of a spindle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spindle {
    /// Speed in turns per minute, negative in reverse.
    speed: f64,
    on: bool,
    brake: bool,
    /// Speeds that the sources of motion have commanded and not taken back; 0 is none.
    commanded: [f64; SOURCES],
    /// The pin inhibit has stopped a spindle that a program had turned: it stays stopped until a command or a resume.
    is_kept_off: bool,
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
    /// True once the measured speed has been negative: it has a sign.
    has_sign: bool,
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
    pub(crate) inhibit: bool,
}

/// Number of sources of motion.
const SOURCES: usize = 3;

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

const INHIBITED: &str = "spindle {} was stopped, and cannot turn again: spindle.{}.inhibit is TRUE";
const NO_OVERRIDE: &str = "spindle {} was stopped, and cannot turn again: its override is 0";

/// Time in seconds for which is-oriented may be TRUE on a turning spindle before the operator is informed.
const LATE: f64 = 1.0;

impl Default for Spindle {
    fn default() -> Self {
        Self {
            speed: 0.0,
            on: false,
            brake: false,
            commanded: [0.0; SOURCES],
            is_kept_off: false,
            scale: 1.0,
            at_speed: true,
            config: SpindleConfig::default(),
            orient: Orient::Nowhere,
            fault: 0,
            angle: 0.0,
            mode: 0,
            inputs: SpindleInputs::default(),
            has_sign: false,
            seeks: false,
            index_enable: None,
            sync_error: 0.0,
            shown: Shown::default(),
        }
    }
}

impl Spindle {
    /// Turns the spindle for a source, which may take its command back with zero. Another source that stops the
    /// spindle leaves that command: feeds of the source wait for a resume then. So does the source itself if `keeps`,
    /// as in the middle of a path.
    pub(crate) fn command(&mut self, speed: f64, source: MotionSource, keeps: bool) {
        // A program does not turn a spindle that somebody else has stopped: that takes a resume, or its own M5 before.
        let is_stopped = source == MotionSource::Task && self.is_lost(source) && !self.turns();
        if !is_stopped || speed == 0.0 {
            self.halt("the spindle was commanded to turn or to stop");
            if speed != 0.0 {
                self.turn(speed);
            }
        }
        if (speed != 0.0 || !keeps)
            && let Some(place) = self.commanded.get_mut(source as usize)
        {
            *place = speed;
        }
    }

    /// Turns the spindle round, for the path that follows it.
    pub(crate) fn turn_round(&mut self, speed: f64) {
        self.halt("the spindle was commanded to turn or to stop");
        self.turn(speed);
        for commanded in self.commanded.iter_mut().filter(|c| **c != 0.0) {
            *commanded = speed;
        }
    }

    fn turn(&mut self, speed: f64) {
        let on = speed != 0.0;
        *self = Self { speed, on, brake: !on, is_kept_off: false, ..*self };
    }

    /// Returns whether somebody else has stopped the spindle since this source turned it.
    pub(crate) fn is_lost(&self, source: MotionSource) -> bool {
        let commanded = self.commanded.get(source as usize).copied().unwrap_or_default();
        commanded != 0.0 && self.speed_out() == 0.0
    }

    /// Returns the reason why the spindle cannot turn again for this source, if it was stopped; `n` is its number.
    pub(crate) fn may_restart(&self, source: MotionSource, n: usize) -> Result<(), Refusal> {
        let n = n as f64;
        if !self.is_lost(source) {
            return Ok(());
        }
        if self.inputs.inhibit {
            return Err(Refusal::with(INHIBITED, [n, n, 0.0, 0.0]));
        }
        if self.scale == 0.0 {
            return Err(Refusal::with(NO_OVERRIDE, [n, 0.0, 0.0, 0.0]));
        }
        Ok(())
    }

    /// Turns the spindle as this source has commanded, if it was stopped. Returns whether it was.
    pub(crate) fn restart(&mut self, source: MotionSource) -> bool {
        let speed = self.commanded.get(source as usize).copied().unwrap_or_default();
        let is_lost = self.is_lost(source);
        if is_lost {
            self.halt("the spindle was commanded to turn or to stop");
            self.turn(speed);
        }
        is_lost
    }

    /// Returns the speed of the pin speed-out: with the override, within the spindle's limits, and 0 while it may not turn.
    fn speed_out(&self) -> f64 {
        if self.turns() { self.config.limited(self.speed * self.scale) } else { 0.0 }
    }

    const fn turns(&self) -> bool {
        self.on && !self.inputs.inhibit && !self.is_kept_off
    }

    /// Returns the higher one of the measured and the commanded speed, in turns per second.
    pub(crate) fn turns_a_second(&self) -> f64 {
        let (measured, commanded) = (self.inputs.speed.abs(), self.turns_commanded());
        if measured > commanded { measured } else { commanded }
    }

    /// Returns the measured turns per second as far as they are those of the command: 0 while the spindle turns against it, and
    /// if they are NaN. A sensor that has never shown a negative speed may have no sign.
    pub(crate) fn turns_as_commanded(&self) -> f64 {
        let measured = self.inputs.speed;
        let has_reversed = if self.speed < 0.0 {
            self.has_sign && measured > STANDSTILL
        } else {
            self.speed > 0.0 && measured < -STANDSTILL
        };
        if has_reversed || measured.is_nan() { 0.0 } else { measured.abs() }
    }

    /// Returns the commanded speed with the override, in turns per second.
    pub(crate) fn turns_commanded(&self) -> f64 {
        self.speed_out().abs() / 60.0
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

    /// Stops the spindle, and forgets the commands of all sources.
    pub(crate) fn stop(&mut self, why: &'static str) {
        self.halt(why);
        (self.commanded, self.is_kept_off) = ([0.0; SOURCES], false);
    }

    fn halt(&mut self, why: &'static str) {
        if let Orient::Turning { ticket, .. } = self.orient {
            ticket.fail(why);
        }
        *self = Self { speed: 0.0, on: false, brake: true, orient: Orient::Nowhere, ..*self };
    }

    /// Stops the spindle for a source and orients it to an angle; the ticket is done when it is at rest there.
    pub(crate) fn orient(
        &mut self,
        (angle, mode): (f64, i32),
        source: MotionSource,
        ticket: TicketHandle,
    ) {
        let is_again = matches!(self.orient, Orient::Turning { .. });
        self.halt("the spindle was commanded to orient");
        if let Some(place) = self.commanded.get_mut(source as usize) {
            *place = 0.0;
        }
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
            inhibit: pins.inhibit.get(),
        };
        self.has_sign |= self.inputs.speed < -STANDSTILL;
        let by_program = self.commanded.get(MotionSource::Task as usize).is_some_and(|c| *c != 0.0);
        self.is_kept_off |= self.on && self.inputs.inhibit && by_program;
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
        !self.turns() || pins.at_speed.get()
    }

    /// Arms or disarms the handshake with the encoder's index.
    pub(crate) const fn seek_index(&mut self, seeks: bool) {
        if seeks != self.seeks {
            (self.seeks, self.index_enable) = (seeks, Some(seeks));
        }
    }

    /// Writes the pins.
    pub(crate) fn write_pins(&mut self, pins: &SpindlePins) {
        let (runs, speed) = (self.turns(), self.speed_out());
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
