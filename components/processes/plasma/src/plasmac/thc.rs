//! Realtime. Torch height control.

use super::{
    inputs,
    numbers::{at_most, later, short},
    outputs::Status,
    settings,
};
use hal_component::{Period, Touch};

/// Height control state of one cut.
#[derive(Default, Touch)]
pub(super) struct Thc {
    /// Seconds since the feed rate was reached.
    #[state]
    since: f32,
    #[state]
    sum: f32,
    #[state]
    samples: i32,
    #[state]
    target: f64,
    /// True if the target voltage is known.
    #[state]
    aims: bool,
    /// True if height control worked in the last cycle.
    #[state]
    pub(super) active: bool,
    #[state]
    error: f64,
    #[state]
    volts: Option<f64>,
    #[state]
    rising: i32,
    #[state]
    level: i32,
    #[state]
    void: bool,
    /// Height override that Z has been moved for, in volts.
    #[state]
    overridden: f64,
    /// Remaining counts of that move.
    #[state]
    left: i32,
}

impl Thc {
    /// Resets the state at the start of a cut.
    pub(super) fn begin(&mut self) {
        *self = Self { error: self.error, ..Self::default() };
    }

    /// Returns whether there is no target yet.
    pub(super) const fn waits(&self) -> bool {
        !self.aims
    }

    /// Determines the target voltage. Returns whether it is known.
    fn aim(
        &mut self,
        settings: (&settings::Thc, &settings::Cut),
        speed: (f64, f64),
        steady: Option<Option<f64>>,
        volts: f64,
        period: Period,
    ) -> bool {
        if self.aims {
            return true;
        }
        if self.samples == 0 {
            if speed.0.is_nan() || speed.1.is_nan() || speed.0 < speed.1 {
                return false;
            }
            if let Some(steady) = steady {
                self.aims = steady.is_some();
                self.target = steady.unwrap_or(self.target);
                return self.aims;
            }
            if f64::from(self.since) < settings.0.delay.get() {
                self.since = later(self.since, period);
                return false;
            }
        }
        if settings.0.use_auto_volts.get() {
            self.sum = short(f64::from(self.sum) + volts);
            self.samples += 1;
            if self.samples < settings.0.target_samples.get() {
                return false;
            }
            self.target = f64::from(short(f64::from(self.sum) / f64::from(self.samples)));
        } else {
            self.target = settings.1.cut_volts.get();
        }
        self.aims = true;
        true
    }

    /// Returns whether the torch is over a void.
    fn is_void(&mut self, settings: &settings::Thc, volts: f64, period: Period) -> bool {
        let slope = (volts - self.volts.unwrap_or(volts)) / period.secs();
        let steep = f64::from(settings.voidlock_slope.get());
        self.volts = Some(volts);
        self.rising = if slope > steep { self.rising.saturating_add(1) } else { 0 };
        self.level = if slope.abs() <= steep { self.level.saturating_add(1) } else { 0 };
        if self.rising > settings.voidlock_on_cycles.get() {
            self.void = true;
        }
        if self.level >= settings.voidlock_off_cycles.get() {
            self.void = false;
        }
        self.void && settings.voidlock_enable.get()
    }

    /// Returns the counts of a move for a changed height override: up in one cycle, down at the setup speed. The
    /// control loop pauses meanwhile.
    #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
    fn overrides(&mut self, settings: &settings::Thc, scale: f64, setup: i32) -> Option<i32> {
        let wanted = settings.height_override.get();
        if wanted != self.overridden {
            let change = wanted - self.overridden;
            self.left =
                self.left.saturating_add((change * settings.height_per_volt.get() / scale) as i32);
            self.overridden = wanted;
            return Some(0);
        }
        if self.left == 0 {
            return None;
        }
        let by = self.left.max(setup.saturating_abs().saturating_neg());
        self.left -= by;
        Some(by)
    }

    /// Determines the target if needed. Returns the counts by which to move the torch.
    pub(super) fn step(
        &mut self,
        settings: (&settings::Thc, &settings::Cut),
        machine: &inputs::MachinePins,
        status: &Status,
        (scale, setup): (f64, i32),
        steady: Option<Option<f64>>,
        (volts, most, may, period): (f64, f64, bool, Period),
    ) -> f64 {
        let wanted = status.requested_feed_rate.get();
        let speed = machine.velocity.get() * 60.0;
        if !self.aims {
            status.cornerlock.set(true);
            if self.aim(settings, (speed, wanted), steady, volts, period) {
                status.target_volts.set(self.target);
            }
            return 0.0;
        }
        if let Some(by) = self.overrides(settings.0, scale, setup) {
            status.led_up.set(false);
            status.led_down.set(false);
            return f64::from(by);
        }
        let void = self.is_void(settings.0, volts, period);
        if !may {
            status.led_up.set(false);
            status.led_down.set(false);
            return 0.0;
        }
        let slow = settings.0.cornerlock_enable.get()
            && speed < wanted * settings.0.cornerlock_threshold.get() / 100.0;
        status.cornerlock.set(slow);
        status.voidlock.set(void);
        self.active = !slow && !void;
        let error = self.target + settings.0.height_override.get() - volts;
        let error = if error.abs() < settings.0.threshold.get() { 0.0 } else { error };
        if !self.active {
            self.error = 0.0;
            status.led_up.set(false);
            status.led_down.set(false);
            return 0.0;
        }
        let change = (error - self.error) / period.secs();
        self.error = error;
        let by = settings.0.p_gain.get() * error
            + settings.0.i_gain.get() * error * period.secs()
            + settings.0.d_gain.get() * change;
        // Each LED stays on until the voltage is within the threshold.
        status.led_up.set(by != 0.0 && (status.led_up.get() || by > 0.0));
        status.led_down.set(by != 0.0 && (status.led_down.get() || by < 0.0));
        let resolution = f64::from(at_most(settings.1.resolution.get(), 1000));
        (by * resolution / 10.0).max(-most).min(most)
    }
}
