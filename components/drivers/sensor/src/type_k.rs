//! Realtime. Type K thermocouples: conversion between temperature and voltage by the polynomials of ITS-90.
//!
//! Values are in single precision: each term is computed in double precision, and rounded when it is added.

/// Coefficients of millivolts by temperature below 0 °C.
const COLD: [f32; 11] = [
    0.0,
    3.945_012_8e-2,
    2.362_237_3e-5,
    -3.285_890_7e-7,
    -4.990_482_7e-9,
    -6.750_906e-11,
    -5.741_032_6e-13,
    -3.108_887_3e-15,
    -1.045_160_9e-17,
    -1.988_926_7e-20,
    -1.632_269_8e-23,
];
/// Coefficients of millivolts by temperature from 0 °C, without the Gaussian term around 127 °C.
const WARM: [f32; 10] = [
    -1.760_041_3e-2,
    3.892_120_3e-2,
    1.855_877e-5,
    -9.945_759_4e-8,
    3.184_094_7e-10,
    -5.607_284_4e-13,
    5.607_506e-16,
    -3.202_072e-19,
    9.715_115e-23,
    -1.210_472_16e-26,
];
/// Gaussian term: height, width and centre.
const BELL: [f32; 3] = [1.185_976e-1, -1.183_432e-4, 1.269_686e2];
/// Coefficients of temperature by millivolts below 0.
const BELOW: [f32; 9] = [
    0.0,
    2.517_346_2e1,
    -1.166_287_8,
    -1.083_363_8,
    -8.977_354e-1,
    -3.734_237_6e-1,
    -8.663_265e-2,
    -1.045_059_8e-2,
    -5.192_057_6e-4,
];
/// Coefficients of temperature by millivolts up to [`MIDDLE`].
const LOW: [f32; 10] = [
    0.0,
    2.508_355e1,
    7.860_106e-2,
    -2.503_131e-1,
    8.315_27e-2,
    -1.228_034e-2,
    9.804_036e-4,
    -4.413_03e-5,
    1.057_734e-6,
    -1.052_755e-8,
];
/// Coefficients of temperature by millivolts from [`MIDDLE`] to [`HIGHEST`].
const HIGH: [f32; 7] = [
    -1.318_058e2,
    4.830_222e1,
    -1.646_031,
    5.464_731e-2,
    -9.650_715e-4,
    8.802_193e-6,
    -3.110_81e-8,
];
const MIDDLE: f64 = 20.644;
/// Upper end of the polynomials, in millivolts.
const HIGHEST: f64 = 54.886;

/// Returns the voltage, in millivolts, between a junction at this temperature in °C and one at 0 °C.
pub(crate) fn millivolts(celsius: f32) -> f32 {
    if celsius < 0.0 {
        return sum(&COLD, celsius);
    }
    let [height, width, place] = BELL.map(f64::from);
    let far = f64::from(celsius) - place;
    single(f64::from(sum(&WARM, celsius)) + height * libm::exp(width * (far * far)))
}

/// Returns the temperature, in °C, of a junction with this voltage against one at 0 °C; `None` above 54.886 mV, which
/// is 1372 °C. Below -5.891 mV (-200 °C), the result is far too low.
pub(crate) fn celsius(millivolts: f32) -> Option<f32> {
    let v = f64::from(millivolts);
    if v > HIGHEST {
        return None;
    }
    Some(if v < 0.0 {
        sum(&BELOW, millivolts)
    } else if v < MIDDLE {
        sum(&LOW, millivolts)
    } else {
        sum(&HIGH, millivolts)
    })
}

fn sum(terms: &[f32], x: f32) -> f32 {
    let (mut sum, mut power) = (0.0_f32, 0.0);
    for term in terms {
        sum = single(f64::from(sum) + f64::from(*term) * libm::pow(f64::from(x), power));
        power += 1.0;
    }
    sum
}

/// Rounds to single precision, in which values are stored.
#[expect(clippy::cast_possible_truncation, reason = "it rounds")]
pub(crate) const fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::{celsius, millivolts};

    /// Values from the type K table of IEC 60584-1, which is in microvolts.
    const TABLE: [(f32, f32); 13] = [
        (-200.0, -5.891),
        (-100.0, -3.554),
        (-50.0, -1.889),
        (-10.0, -0.392),
        (0.0, 0.0),
        (10.0, 0.397),
        (25.0, 1.0),
        (100.0, 4.096),
        (300.0, 12.209),
        (500.0, 20.644),
        (1000.0, 41.276),
        (1300.0, 52.410),
        (1370.0, 54.819),
    ];

    #[test]
    fn the_table() {
        for (t, v) in TABLE {
            assert!((millivolts(t) - v).abs() < 6e-4, "{t} °C: {} mV", millivolts(t));
            // By its definition, the inverse is accurate to 0.06 °C, and the table to 0.5 µV.
            let back = celsius(v).unwrap();
            assert!((back - t).abs() < 0.1, "{v} mV: {back} °C");
        }
    }

    #[test]
    fn there_and_back() {
        for t in -200_i16..=1370 {
            let t = f32::from(t);
            let back = celsius(millivolts(t)).unwrap();
            assert!((back - t).abs() < 0.08, "{t} °C: {back}");
        }
        assert_eq!(celsius(54.9), None);
    }
}
