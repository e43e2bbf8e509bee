//! `constant`.
use hal_component::{Component, Out, ParamRw, Period, Update};

/// Constant number.
///
/// A signal can be set to a constant as well, as long as no pin writes it; a parameter is saved with the machine.
///
/// # Example
///
/// ```hal
/// loadrt constant
/// loadrt threads name1=servo period1=1000000
/// addf constant.0 servo
/// net level constant.0.out
/// start
/// setp constant.0.value 2.5
/// run 1ms
/// gets level # -> 2.5
/// ```
#[derive(Component)]
pub(crate) struct Constant {
    /// Value of the constant, in any unit.
    out: Out<f64>,
    /// Value for `out`, in the same unit.
    value: ParamRw<f64>,
}

impl Update for Constant {
    fn update(&mut self, _: Period) {
        self.out.set(self.value.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Constant;
    use hal_bench::trace::replay;

    #[test]
    fn it_follows_its_parameter() {
        let rows = replay::<Constant>(
            "load constant
             run constant.0
             in constant.0.value
             out constant.0.out
             1.5 | 1.5
             -inf | -inf
             nan | nan
             . | nan",
        );
        assert_eq!(rows, 4);
    }
}
