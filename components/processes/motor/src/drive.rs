//! Realtime. Outputs of `bldc` to a drive.
use crate::letters::{Drive, Letters};
use hal_component::{Builder, Error, Out, ParamRw, Touch};
use std::f64::consts::TAU;

/// Phase that is driven high and phase that is driven low, for each sector.
const PATHS: [(usize, usize); 6] = [(1, 0), (2, 0), (2, 1), (0, 1), (0, 2), (1, 2)];

/// Commanded direction of the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    /// Sector of trapezoidal drive, 0 to 5, if known.
    pub(crate) sector: Option<usize>,
    /// Angle of the rotor, in electrical turns.
    pub(crate) rotor: f64,
    /// Angle of sinusoidal drive, in electrical turns; `None` for trapezoidal drive.
    pub(crate) phase: Option<f64>,
}

/// Output pins.
#[derive(Touch)]
pub(crate) struct Outputs {
    /// Three values, or three high and three low values.
    values: Vec<Out<f64>>,
    bits: Vec<Out<bool>>,
    pattern: Option<ParamRw<u32>>,
    #[state]
    drive: Drive,
}

impl Outputs {
    pub(crate) fn declare(
        b: &mut Builder<'_>,
        name: &str,
        letters: Letters,
    ) -> Result<Self, Error> {
        let mut out =
            Self { values: Vec::new(), bits: Vec::new(), pattern: None, drive: letters.drive };
        let (mut values, mut bits) = (Vec::new(), Vec::new());
        match letters.drive {
            Drive::Values => values.push((
                "value",
                "Drive level of phase {}, in the unit of value; negative for low.",
            )),
            Drive::Bits => bits.push(("on", "True drives phase {} high, false drives it low.")),
            Drive::SixValues => {
                values.push(("high", "High drive level of phase {}, in the unit of value."));
                values.push(("low", "Low drive level of phase {}, in the unit of value."));
            }
            Drive::SixBits => {
                bits.push(("high-on", "True drives phase {} high."));
                bits.push(("low-on", "True drives phase {} low."));
            }
            Drive::Hall | Drive::Gray => {}
        }
        for (pin, doc) in values {
            for phase in ["A", "B", "C"] {
                let doc = doc.replace("{}", phase);
                out.values.push(b.item(&format!("{name}.{phase}-{pin}"), &doc, 0.0)?);
            }
        }
        for (pin, doc) in bits {
            for phase in ["A", "B", "C"] {
                let doc = doc.replace("{}", phase);
                out.bits.push(b.item(&format!("{name}.{phase}-{pin}"), &doc, false)?);
            }
        }
        if letters.any("H") {
            for i in 1..=3 {
                let doc = format!("Simulated state of Hall sensor {i} of the drive's motor.");
                out.bits.push(b.item(&format!("{name}.hall{i}-out"), &doc, false)?);
            }
            let doc =
                "The drive's pattern of Hall sensors, as `pattern`; beyond 47 all stay false.";
            out.pattern = Some(b.item(&format!("{name}.output-pattern"), doc, 25)?);
        }
        if letters.any("F") {
            for i in [1, 2, 4, 8] {
                let doc = format!("Bit {i} of the Gray code of the rotor's sixteenth of a turn.");
                let bit = b.item(&format!("{name}.C{i}-out"), &doc, false)?;
                if letters.drive == Drive::Gray {
                    out.bits.push(bit);
                }
            }
        }
        Ok(out)
    }

    /// Drives the field with this magnitude; `back` is the direction for outputs without a sign.
    pub(crate) fn give(&self, field: Field, out: f64, back: bool) {
        let path = field.sector.and_then(|s| PATHS.get(s)).copied();
        let back = match self.drive {
            Drive::Values => out < 0.0,
            Drive::Bits | Drive::SixValues | Drive::SixBits | Drive::Hall | Drive::Gray => back,
        };
        let path = path.map(|(high, low)| if back { (low, high) } else { (high, low) });
        let much = out.abs();
        match (self.drive, field.phase) {
            (Drive::Values, Some(phase)) => {
                put(&self.values, &sines(phase).map(|v| out.abs() * v));
            }
            (Drive::Values, None) => put(&self.values, &[0, 1, 2].map(|i| along(path, i, much))),
            (Drive::SixValues, Some(phase)) => {
                let [a, b, c] = sines(phase);
                let much = out.abs();
                let up = |v: f64| if v > 0.0 { much * v } else { 0.0 };
                let down = |v: f64| if v > 0.0 { 0.0 } else { -(much * v) };
                put(&self.values, &[up(a), up(b), up(c), down(a), down(b), down(c)]);
            }
            (Drive::SixValues, None) => {
                let (high, low) = path.unzip();
                let of = |at: Option<usize>, i| if at == Some(i) { much } else { 0.0 };
                let [up, down] = [high, low].map(|at| [0, 1, 2].map(|i| of(at, i)));
                put(&self.values, &[up[0], up[1], up[2], down[0], down[1], down[2]]);
            }
            (Drive::Bits, _) => match path {
                Some((high, low)) => {
                    for (i, is) in [(high, true), (low, false)] {
                        if let Some(bit) = self.bits.get(i) {
                            bit.set(is);
                        }
                    }
                }
                None => put(&self.bits, &[false; 3]),
            },
            (Drive::SixBits, _) => {
                let (high, low) = path.unzip();
                let (high, low) = (|i| high == Some(i), |i| low == Some(i));
                put(&self.bits, &[high(0), high(1), high(2), low(0), low(1), low(2)]);
            }
            (Drive::Hall, _) => {
                let pattern = self.pattern.as_ref().map_or(0, ParamRw::get);
                let code = field.sector.and_then(|s| crate::hall::code(pattern, s)).unwrap_or(0);
                put(&self.bits, &[4, 2, 1].map(|bit| code & bit != 0));
            }
            (Drive::Gray, _) => {
                let passed = (1..16).filter(|&i| f64::from(i) / 16.0 < field.rotor).count();
                let code = passed ^ passed >> 1;
                put(&self.bits, &[1, 2, 4, 8].map(|bit| code & bit != 0));
            }
        }
    }
}

fn put<T: hal_component::Value>(pins: &[Out<T>], values: &[T]) {
    for (pin, &value) in pins.iter().zip(values) {
        pin.set(value);
    }
}

/// Returns the value of a phase in trapezoidal drive.
fn along(path: Option<(usize, usize)>, phase: usize, much: f64) -> f64 {
    match path {
        Some((high, _)) if high == phase => much,
        Some((_, low)) if low == phase => -much,
        _ => 0.0,
    }
}

/// Returns the fractions of the three phases in sinusoidal drive.
fn sines(phase: f64) -> [f64; 3] {
    let (sin, cos) = (libm::sin(TAU * phase), libm::cos(TAU * phase));
    let (half, part) = (-0.5 * cos, libm::sqrt(3.0) / 2.0 * sin);
    [cos, half + part, half - part]
}
