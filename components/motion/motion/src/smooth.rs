//! Realtime. A moving average of steps, which limits jerk.

/// Largest number of steps that the average spans.
const MOST: usize = 512;

/// Moving average of the steps of a planner, one in each cycle.
#[derive(Debug, Default)]
pub(crate) struct Smooth {
    /// Last steps; empty if there is no average.
    ring: Box<[f64]>,
    /// Number of steps that it spans; 0 and 1 pass each step on.
    samples: usize,
    next: usize,
    sum: f64,
    /// Number of cycles without a step.
    flat: usize,
}

impl Smooth {
    /// Average that can span steps.
    pub(crate) fn new() -> Self {
        Self { ring: vec![0.0; MOST].into_boxed_slice(), ..Self::default() }
    }

    /// Returns whether steps pass on as they are.
    pub(crate) const fn is_off(&self) -> bool {
        self.samples <= 1
    }

    /// Returns whether every step has passed on.
    pub(crate) const fn is_flat(&self) -> bool {
        self.samples <= 1 || self.flat >= self.samples
    }

    /// Returns the number of steps that the average spans.
    pub(crate) const fn samples(&self) -> usize {
        self.samples
    }

    /// Changes the number of steps that the average spans. Every step must have passed on.
    pub(crate) fn choose(&mut self, samples: f64) {
        let most = self.ring.len();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below the length of the ring"
        )]
        let whole = if samples > 1.0 && samples < most as f64 { samples as usize } else { most };
        let samples = if samples > 1.0 { whole } else { 0 };
        if samples != self.samples {
            (self.samples, self.next, self.sum, self.flat) = (samples, 0, 0.0, samples);
        }
    }

    /// Takes a step, and returns the average.
    pub(crate) fn pass(&mut self, step: f64) -> f64 {
        self.flat = if step == 0.0 { self.flat.saturating_add(1) } else { 0 };
        if let Some(slot) = self.ring.get_mut(self.next) {
            self.sum += step - *slot;
            *slot = step;
        }
        self.next += 1;
        if self.next >= self.samples {
            self.next = 0;
            // The sum is formed again once a revolution, so that rounding does not grow.
            self.sum = self.ring.iter().take(self.samples).sum();
        }
        if self.is_flat() { 0.0 } else { self.sum / self.samples as f64 }
    }

    /// Reduces all steps that have not passed on to a part. Returns what is left of them.
    pub(crate) fn slow_down(&mut self, factor: f64) -> f64 {
        let n = self.samples;
        let mut left = 0.0;
        for (k, slot) in self.ring.iter_mut().take(n).enumerate() {
            *slot *= factor;
            // The newest step stands before `next`.
            let age = (self.next + n - 1 - k) % n;
            left += *slot * (n - 1 - age) as f64 / n as f64;
        }
        self.sum *= factor;
        left
    }

    /// Forgets all steps.
    pub(crate) fn reset(&mut self) {
        if !self.is_flat() {
            self.ring.iter_mut().take(self.samples).for_each(|slot| *slot = 0.0);
        }
        (self.sum, self.flat) = (0.0, self.samples);
    }
}
