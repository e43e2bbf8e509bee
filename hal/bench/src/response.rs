//! Measurement of a filter's response to a sine wave.

use core::f64::consts::TAU;

/// Returns the gain and the phase, in radians, of `step` for a sine wave of `cycles` cycles in
/// `samples` runs.
///
/// `step` first receives the sine wave for at least `settle` runs, and then once more for the
/// measurement. The result is the correlation of the output with the sine over whole cycles. For a
/// linear filter that has settled it is exact, except for rounding errors of each sample. A
/// negative phase means that the output lags.
///
/// ```
/// use hal_bench::response;
///
/// let mut last = 0.0;
/// let late = |x| std::mem::replace(&mut last, x) * 0.5;
/// let (gain, phase) = response(late, 1, 8, 8);
/// assert!((gain - 0.5).abs() <= 8.0 * f64::EPSILON);
/// assert!((phase + std::f64::consts::FRAC_PI_4).abs() <= 8.0 * f64::EPSILON);
/// ```
pub fn response(
    mut step: impl FnMut(f64) -> f64,
    cycles: u32,
    samples: u32,
    settle: u32,
) -> (f64, f64) {
    let (mut re, mut im) = (0.0, 0.0);
    let settling = settle.div_ceil(samples) * samples;
    for n in 0..settling + samples {
        // Integer arithmetic, so that the angle is as exact at the end as at the beginning.
        let part = u64::from(n) * u64::from(cycles) % u64::from(samples);
        let (sin, cos) = (TAU * part as f64 / f64::from(samples)).sin_cos();
        let out = step(cos);
        if n >= settling {
            re += out * cos;
            im -= out * sin;
        }
    }
    let half = f64::from(samples) / 2.0;
    (re.hypot(im) / half, im.atan2(re))
}
