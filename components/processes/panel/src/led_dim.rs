//! `led_dim`.
use hal_component::{Component, In, Out, Period, Update};

/// Power of a lamp for a wanted perceived brightness.
///
/// The eye does not respond linearly. The power follows the lightness of CIE 1931: L / 903.3 for a lightness L up to 8,
/// and ((L + 16) / 116)³ above. LinuxCNC 2.9 does not have this component.
///
/// # Example
///
/// What looks half as bright needs 18 percent of the power.
///
/// ```hal
/// loadrt led_dim
/// loadrt threads name1=servo period1=1000000
/// addf led-dim.0 servo
/// setp led-dim.0.in 50
/// start
/// run 1ms
/// getp led-dim.0.out # -> 0.1841865
/// ```
#[derive(Component)]
pub(crate) struct LedDim {
    /// Perceived brightness, from 0 to 100; values beyond are limited to that range, and NaN counts as 0.
    in_: In<f64>,
    /// Power, from 0 to 1.
    out: Out<f64>,
}

impl Update for LedDim {
    fn update(&mut self, _: Period) {
        let wanted = self.in_.get();
        let light = if wanted > 100.0 { 100.0 } else { wanted.max(0.0) };
        self.out.set(if light > 8.0 {
            let root = (light + 16.0) / 116.0;
            root * root * root
        } else {
            light / 903.3
        });
    }
}

#[cfg(test)]
mod tests {
    use super::LedDim;
    use hal_bench::trace::replay;

    #[test]
    fn cie_1931() {
        let rows = "load led_dim
            within 1e-9
            run led-dim.0
            in led-dim.0.in
            out led-dim.0.out
            0 | 0
            4 | 0.004428207683
            8 | 0.008856415366
            42 | 0.125
            100 | 1
            250 | 1
            -3 | 0
            nan | 0";
        assert_eq!(replay::<LedDim>(rows), 8);
    }
}
