//! `lowpass`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Low-pass filter of first order.
///
/// # Example
///
/// ```hal
/// loadrt lowpass
/// loadrt threads name1=servo period1=1000000
/// addf lowpass.0 servo
/// start
/// setp lowpass.0.gain 0.5
/// setp lowpass.0.in 8
/// run 1ms
/// getp lowpass.0.out # -> 4
/// run 1ms
/// getp lowpass.0.out # -> 6
/// setp lowpass.0.load 1
/// run 1ms
/// getp lowpass.0.out # -> 8
/// ```
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
