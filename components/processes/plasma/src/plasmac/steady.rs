//! Realtime. Detector of a steady voltage.

use super::{
    numbers::{at_most, short},
    settings,
};
use hal_component::Touch;

/// Capacity of the ring of voltages, and the maximum of `thc-sample-counts`.
const MAX: usize = 1000;

/// Voltages since the torch was lit.
#[derive(Touch)]
pub(super) struct Steady {
    #[state]
    volts: Box<[f32]>,
    /// Index of the next entry.
    #[state]
    next: usize,
    /// Number of valid entries.
    #[state]
    count: usize,
}

impl Default for Steady {
    fn default() -> Self {
        Self { volts: vec![0.0; MAX].into(), next: 0, count: 0 }
    }
}

impl Steady {
    /// Stores a voltage. While the torch is off, discards all of them.
    pub(super) fn keep(&mut self, lit: bool, volts: f64) {
        if !lit {
            self.count = 0;
            return;
        }
        if let Some(place) = self.volts.get_mut(self.next) {
            *place = short(volts);
        }
        self.next = (self.next + 1) % MAX;
        self.count = (self.count + 1).min(MAX);
    }

    /// Returns the mean of the last `thc-sample-counts` voltages if there are as many and they differ by no more than
    /// the threshold.
    pub(super) fn mean(&self, settings: &settings::Thc) -> Option<f64> {
        let wanted = usize::try_from(at_most(settings.sample_counts.get(), 1000)).unwrap_or(MAX);
        if self.count < wanted {
            return None;
        }
        let (mut low, mut high, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0_f32);
        for back in (1..=wanted).rev() {
            let volts = self.volts.get((self.next + MAX - back) % MAX).copied()?;
            low = low.min(volts);
            high = high.max(volts);
            sum += volts;
        }
        let near = f64::from(high - low) <= settings.sample_threshold.get();
        near.then(|| f64::from(short(f64::from(sum) / wanted as f64)))
    }
}
