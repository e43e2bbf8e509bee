//! Realtime. Generators of pulse width and pulse density.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Writes},
    numbers::whole,
};
use hal_component::{Error, In, ParamRw, Touch, pins};
use hal_firmware::{Tag, registers};

/// Rate register's steps for the clock: the accumulator of rates has 16 bits.
const RATE_STEPS: f64 = 65_536.0;

/// Parts of a step of the duty with dither.
const FRACTION: f64 = 16.0;

/// Form of pulse density in the mode register.
const PDM: u32 = 3 << 3;

/// Forms of the output: pulse width with direction, up and down, pulse density, pulse width with direction swapped.
const FORMS: core::ops::RangeInclusive<i32> = 1..=4;

pins! {
    /// Generator of pulses.
    struct Generator {
        /// Value to put out, in units.
        value: In<f64> = "value", 0.0;
        /// TRUE to put it out.
        enable: In<bool> = "enable", false;
        /// Value of a full duty, in units; 0 counts as 1. Beyond it, the duty saturates.
        scale: ParamRw<f64> = "scale", 1.0;
        /// Form of the output: 1 pulse width and direction, 2 up and down, 3 pulse density and direction, 4 direction and pulse width.
        output_type: ParamRw<i32> = "output-type", 1;
        /// TRUE for half a duty at a value of 0, and none at minus one scale.
        offset_mode: ParamRw<bool> = "offset-mode", false;
        /// TRUE to alternate between two widths, which makes the mean finer than a step of the duty.
        dither: ParamRw<bool> = "dither", false;
    }
}

/// A generator with its registers.
#[derive(Touch)]
struct Instance {
    pins: Generator,
    #[state]
    value: u16,
    #[state]
    mode: Kept,
}

/// Function half that writes.
#[derive(Touch)]
struct Generators {
    instances: Vec<Instance>,
    pwm_frequency: ParamRw<u32>,
    pdm_frequency: ParamRw<u32>,
    #[state]
    clock: f64,
    #[state]
    pwm_rate: Kept,
    #[state]
    pdm_rate: Kept,
    #[state]
    enable: Kept,
}

/// Width of the duty in bits, its code in the mode register, and the rate register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Width {
    bits: u32,
    rate: u32,
}

/// Returns the most bits that a frequency leaves: the card counts a period of 2^bits at a rate below its clock.
fn width(clock: f64, frequency: u32) -> Width {
    for bits in (9..=12_u32).rev() {
        let rate =
            libm::floor(f64::from(frequency) * RATE_STEPS * f64::from(1_u32 << bits) / clock);
        if rate < RATE_STEPS {
            return Width { bits, rate: whole(rate, 65_535).max(1) };
        }
    }
    Width { bits: 9, rate: 65_535 }
}

impl Writes for Generators {
    fn write(&mut self, to: &mut Outgoing<'_>, _: Cycle) {
        let width = width(self.clock, self.pwm_frequency.get());
        self.pwm_rate.put(to, width.rate);
        let density = libm::floor(f64::from(self.pdm_frequency.get()) * RATE_STEPS / self.clock);
        self.pdm_rate.put(to, whole(density, 65_535));
        let mut enable = 0;
        for (n, instance) in self.instances.iter_mut().enumerate() {
            enable |= if instance.pins.enable.get() { 1 << n } else { 0 };
            instance.write(to, width.bits);
        }
        self.enable.put(to, enable);
    }
}

impl Instance {
    fn write(&mut self, to: &mut Outgoing<'_>, bits: u32) {
        let form = self.pins.output_type.get();
        let form = if FORMS.contains(&form) {
            form
        } else {
            self.pins.output_type.set(1);
            1
        };
        // Pulse density always has 12 bits.
        let bits = if form == 3 { 12 } else { bits };
        let (size, backward) = self.value();
        let dithers = self.pins.dither.get() && form != 3;
        let fraction = if dithers { FRACTION } else { 1.0 };
        let most = f64::from((1_u32 << bits) - 1) * fraction;
        let value = if self.pins.offset_mode.get() {
            let signed = if backward { -size } else { size };
            f64::midpoint(signed, 1.0) * most + 0.5
        } else {
            size * most
        };
        let value = whole(value, u32::MAX);
        // Sixteenths of a step stand below the steps.
        let value = if dithers { value << 12 } else { value << 16 };
        to.put(self.value, value | u32::from(backward) << 31);
        // Form of the outputs.
        let form = match form {
            2 => 2 << 3,
            3 => PDM,
            4 => 1 << 3,
            _ => 0,
        };
        // New values begin with a period of the pulse width; pulse density has none.
        let with_period = if form == PDM { 0 } else { 1 << 5 };
        self.mode.put(to, (bits - 9) | with_period | form | u32::from(dithers) << 6);
    }

    /// Returns the value over the scale: its size from 0 to 1, and whether it is negative. A disabled generator has 0.
    fn value(&self) -> (f64, bool) {
        let scale = self.pins.scale.get();
        let scale = if scale.is_finite() && scale != 0.0 {
            scale
        } else {
            self.pins.scale.set(1.0);
            1.0
        };
        let value = if self.pins.enable.get() { self.pins.value.get() / scale } else { 0.0 };
        let size = value.abs();
        // NaN counts as 0.
        let size = if size > 1.0 {
            1.0
        } else if size >= 0.0 {
            size
        } else {
            0.0
        };
        (size, value < 0.0)
    }
}

/// Creates the pins of all generators.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, used)) = m.module(Tag::Pwm) else { return Ok(()) };
    let mut instances = Vec::new();
    for instance in 0..used {
        let name = m.at(&format!("pwmgen.{instance:02}"));
        instances.push(Instance {
            pins: Generator::make(m.b, &name)?,
            value: m.address(&module, registers::PWM_VALUE, instance)?,
            mode: Kept::new(m.address(&module, registers::PWM_MODE, instance)?),
        });
    }
    let about = "Frequency of all generators of pulse width, in hertz; beyond what the card can, it saturates";
    let name = m.at("pwmgen.pwm_frequency");
    let pwm_frequency = m.b.item(&name, about, 20_000)?;
    let about = "Frequency of the slots of all generators of pulse density, in hertz";
    let name = m.at("pwmgen.pdm_frequency");
    let pdm_frequency = m.b.item(&name, about, 20_000)?;
    m.writes.push(Box::new(Generators {
        instances,
        pwm_frequency,
        pdm_frequency,
        clock: m.clock(&module)?,
        pwm_rate: Kept::new(m.address(&module, registers::PWM_RATE, 0)?),
        pdm_rate: Kept::new(m.address(&module, registers::PWM_PDM_RATE, 0)?),
        enable: Kept::new(m.address(&module, registers::PWM_ENABLE, 0)?),
    }));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The frequency that a width makes is the one asked for, within a step of the rate.
    #[test]
    fn the_rate_makes_the_frequency() {
        let clock = 200e6;
        for (frequency, bits) in [(1, 12), (20_000, 12), (48_000, 12), (97_000, 11), (390_000, 9)] {
            let width = width(clock, frequency);
            assert_eq!(width.bits, bits, "{frequency}");
            let made = f64::from(width.rate) * clock / RATE_STEPS / f64::from(1_u32 << bits);
            let step = clock / RATE_STEPS / f64::from(1_u32 << bits);
            assert!((made - f64::from(frequency)).abs() <= step, "{made} for {frequency}");
        }
        assert_eq!(width(clock, u32::MAX), Width { bits: 9, rate: 65_535 });
    }
}
