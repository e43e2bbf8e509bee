//! `lowpass`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Low-pass filter of first order.
#[derive(Component)]
pub(crate) struct Lowpass {
    /// The number.
    in_: In<f64>,
    /// While true, the output is the number.
    load: In<bool>,
    /// The filtered number.
    out: Out<f64>,
    /// Which part of the distance to the number the output covers at each run: 1 follows at
    /// once, 0 never. For a corner at f hertz with a period of T seconds it is 1 - exp(-2πfT).
    gain: ParamRw<f64>,
}

impl Update for Lowpass {
    fn update(&mut self, _: Period) {
        let (x, out) = (self.in_.get(), self.out.get());
        let next = if self.load.get() { x } else { out + (x - out) * self.gain.get() };
        self.out.set(next);
    }
}

#[cfg(test)]
mod tests {
    use super::Lowpass;
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Lowpass>(include_str!("../traces/lowpass.txt")), 100);
    }
}
