//! `ohmic`.
use hal_component::{Component, In, Out, Period, Update};

/// Ohmic sensing of contact between torch and metal, from the voltage that a THCAD card measures.
///
/// The card turns a voltage into a frequency f. The voltage at the card is (f - f0) / ((fmax - f0) /
/// `thcad-fullscale`), where f0 and fmax are the card's calibration frequencies divided by `thcad-divide`. The voltage
/// at the torch is that voltage times `volt-divider`. While probing, a voltage above 1 V sets `ohmic-on`, or a voltage
/// above 0 V if `ohmic-threshold` is 0; the value of `ohmic-threshold` has no other effect, as measured on LinuxCNC
/// 2.9. While probing, `ohmic-on` follows the voltage. While not probing, `ohmic-on` only turns off, when the voltage
/// falls below `ohmic-low`.
///
/// The defaults of `ohmic-low` and `ohmic-threshold` are those of LinuxCNC 2.10; in 2.9 they are 5 and 18.
///
/// # Example
///
/// ```hal
/// loadrt ohmic
/// loadrt threads name1=servo period1=1000000
/// addf ohmic.0 servo
/// setp ohmic.0.thcad-0-volt-freq 100000
/// setp ohmic.0.thcad-max-volt-freq 900000
/// setp ohmic.0.velocity-in 15625
/// setp ohmic.0.is-probing 1
/// start
/// run 1ms
/// getp ohmic.0.ohmic-volts # -> 12.25
/// getp ohmic.0.ohmic-on # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Ohmic {
    /// Frequency of the card at 0 V, before division, in hertz.
    #[hal(name = "thcad-0-volt-freq")]
    zero_freq: In<f64>,
    /// Frequency of the card at full scale, before division, in hertz.
    #[hal(name = "thcad-max-volt-freq")]
    max_freq: In<f64>,
    /// Frequency divider of the card: 1, 32, 64 or 128.
    #[hal(default = 32.0)]
    thcad_divide: In<f64>,
    /// Full-scale voltage of the card: 5, 10 or 300 volts.
    #[hal(default = 5.0)]
    thcad_fullscale: In<f64>,
    /// Measured frequency, in hertz.
    velocity_in: In<f64>,
    /// Volts at the torch for one volt at the card.
    #[hal(default = 4.9)]
    volt_divider: In<f64>,
    /// Contact threshold while probing, in volts: 0 V if this is 0, else 1 V.
    #[hal(default = 22.0)]
    ohmic_threshold: In<f64>,
    /// Voltage at the torch, in volts, below which contact ends while not probing.
    #[hal(default = 21.0)]
    ohmic_low: In<f64>,
    /// True if the voltage at the card is at or above full scale: there is an arc. (In LinuxCNC 2.9, but not in 2.10.)
    arc_on: Out<bool>,
    /// Voltage at the card, in volts. (In LinuxCNC 2.9, but not in 2.10.)
    thcad_volts: Out<f64>,
    /// Voltage at the torch, in volts.
    ohmic_volts: Out<f64>,
    /// True while the torch touches the metal.
    ohmic_on: Out<bool>,
    /// Set TRUE while probing for contact.
    is_probing: In<bool>,
}

impl Update for Ohmic {
    fn update(&mut self, _: Period) {
        let divide = self.thcad_divide.get();
        let zero = self.zero_freq.get() / divide;
        // Adding 0.0 turns a range of -0.0 into +0.0, so that the scale gets the right sign.
        let range = self.max_freq.get() - self.zero_freq.get() + 0.0;
        let scale = 1.0 / (range / self.thcad_fullscale.get() / divide);
        let volts = (self.velocity_in.get() - zero) * scale;
        self.thcad_volts.set(volts);
        self.arc_on.set(volts >= self.thcad_fullscale.get());
        let volts = volts * self.volt_divider.get();
        self.ohmic_volts.set(volts);
        if self.is_probing.get() {
            let least = if self.ohmic_threshold.get() == 0.0 { 0.0 } else { 1.0 };
            self.ohmic_on.set(volts > least);
        } else if volts < self.ohmic_low.get() {
            self.ohmic_on.set(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Ohmic;
    use hal_bench::trace::replay;

    #[test]
    fn volts() {
        let rows = "load ohmic
            set ohmic.0.thcad-0-volt-freq 100000
            set ohmic.0.thcad-max-volt-freq 900000
            set ohmic.0.ohmic-low 5
            run ohmic.0
            within 1e-12
            in ohmic.0.velocity-in ohmic.0.is-probing
            out ohmic.0.ohmic-volts ohmic.0.thcad-volts ohmic.0.ohmic-on ohmic.0.arc-on
            3125 0 | 0 0 0 0
            15625 0 | 12.25 2.5 0 0
            28125 0 | 24.5 5 0 1
            28125 1 | 24.5 5 1 1
            4687.5 1 | 1.53125 0.3125 1 0
            0 1 | -3.0625 -0.625 0 0
            15625 1 | 12.25 2.5 1 0
            9375 0 | 6.125 1.25 1 0
            4687.5 0 | 1.53125 0.3125 0 0
            9375 0 | 6.125 1.25 0 0";
        assert_eq!(replay::<Ohmic>(rows), 10);
    }
}
