//! `ilowpass`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Low-pass filter of a count, such as a hand wheel's.
#[derive(Component)]
pub(crate) struct Ilowpass {
    /// The count.
    in_: In<i32>,
    /// The smoothed count, times `scale`; it wraps at 32 bits.
    out: Out<i32>,
    /// What the smoothed count is multiplied by, so that steps become fine.
    #[hal(default = 1024.0)]
    scale: ParamRw<f64>,
    /// How much of the way to the count is gone in each run, 0 to 1.
    #[hal(default = 0.5)]
    gain: ParamRw<f64>,
    #[state]
    value: f64,
}

impl Update for Ilowpass {
    #[expect(clippy::cast_possible_truncation, reason = "the count wraps")]
    fn update(&mut self, _: Period) {
        self.value += (f64::from(self.in_.get()) - self.value) * self.gain.get();
        self.out.set(libm::floor(self.value * self.scale.get() + 0.5) as i64 as i32);
    }
}

#[cfg(test)]
mod tests {
    use super::Ilowpass;
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Ilowpass>(include_str!("../traces/ilowpass.txt")), 240);
    }
}
