//! Realtime. Whether the voltage has been steady for a while.

use super::{
    numbers::{at_most, short},
    wants,
};
use hal_component::Touch;

/// As many voltages are kept, and no more are asked for.
const MOST: usize = 1000;

/// The voltages since the torch was lit.
#[derive(Touch)]
pub(super) struct Steady {
    #[state]
    volts: Box<[f32]>,
    /// Where the next one goes.
    #[state]
    next: usize,
    /// How many there are.
    #[state]
    count: usize,
}

impl Default for Steady {
    fn default() -> Self {
        Self { volts: vec![0.0; MOST].into(), next: 0, count: 0 }
    }
}

impl Steady {
    /// Keeps a voltage; without a torch, none.
    pub(super) fn keep(&mut self, lit: bool, volts: f64) {
        if !lit {
            self.count = 0;
            return;
        }
        if let Some(place) = self.volts.get_mut(self.next) {
            *place = short(volts);
        }
        self.next = (self.next + 1) % MOST;
        self.count = (self.count + 1).min(MOST);
    }

    /// The mean of the last voltages, if there are as many as are wanted and they are near each other.
    pub(super) fn mean(&self, wants: &wants::Thc) -> Option<f64> {
        let wanted = usize::try_from(at_most(wants.sample_counts.get(), 1000)).unwrap_or(MOST);
        if self.count < wanted {
            return None;
        }
        let (mut low, mut high, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0_f32);
        for back in (1..=wanted).rev() {
            let volts = self.volts.get((self.next + MOST - back) % MOST).copied()?;
            low = low.min(volts);
            high = high.max(volts);
            sum += volts;
        }
        let near = f64::from(high - low) <= wants.sample_threshold.get();
        near.then(|| f64::from(short(f64::from(sum) / wanted as f64)))
    }
}
