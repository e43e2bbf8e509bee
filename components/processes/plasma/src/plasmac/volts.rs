//! Realtime. Arc voltage, and detection of the arc.

use super::{inputs::Arc, numbers::short};
use hal_component::{Period, Touch};

/// Filtered arc voltage, and the number of cycles for which it has been steady.
#[derive(Default, Touch)]
pub(super) struct Volts {
    #[state]
    filtered: f32,
    #[state]
    before: f64,
    #[state]
    steady: i32,
    #[state]
    ok: bool,
}

impl Volts {
    /// Returns the arc voltage of this cycle, in volts.
    pub(super) fn read(&mut self, arc: &Arc, period: Period) -> f64 {
        let input = arc.voltage_in.get();
        let hertz = arc.lowpass_frequency.get().abs();
        if hertz == 0.0 {
            self.filtered = short(input);
        } else {
            let part = 1.0 - libm::exp(-core::f64::consts::TAU * hertz * period.secs());
            let before = f64::from(self.filtered);
            let filtered = if before.is_finite() { before } else { 0.0 };
            self.filtered = short(filtered + part * (input - filtered));
        }
        let input = f64::from(self.filtered.abs());
        let volts = (input - arc.voltage_offset.get()) * arc.voltage_scale.get().abs();
        let volts = libm::round(volts * 1000.0) / 1000.0;
        if volts.abs() < arc.zero_window.get() { 0.0 } else { volts }
    }

    /// Returns whether there is an arc while the torch is on.
    pub(super) fn arc(&mut self, arc: &Arc, mode: i32, volts: f64) -> bool {
        if mode != 0 {
            return arc.ok_in.get();
        }
        if !(arc.ok_low.get()..=arc.ok_high.get()).contains(&volts) {
            self.torch_off();
        } else if !self.ok {
            let near = (volts - self.before).abs() <= arc.ok_sample_threshold.get();
            self.steady = if near || self.steady == 0 { self.steady + 1 } else { 0 };
            self.ok = self.steady >= arc.ok_sample_counts.get();
        }
        self.before = volts;
        self.ok
    }

    /// Resets the detection when the torch is off.
    pub(super) fn torch_off(&mut self) {
        self.steady = 0;
        self.ok = false;
    }
}
