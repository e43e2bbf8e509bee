//! Points of the curves of G5 and its kin.

use super::ControlPoint;

/// Returns a point of a rational B-spline with clamped uniform knots, at `share` of its length of parameters.
pub fn curve_point(order: u32, points: &[ControlPoint], share: f64) -> Option<(f64, f64)> {
    let degree = usize::try_from(order).ok()?.checked_sub(1)?;
    let spans = points.len().checked_sub(degree)?;
    let knot = |i: usize| (i.saturating_sub(degree)).min(spans) as f64;
    let u = share * spans as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to the number of spans"
    )]
    let span = degree + (u as usize).min(spans.checked_sub(1)?);
    let mut d: Vec<[f64; 3]> = points
        .get(span - degree..=span)?
        .iter()
        .map(|p| [p.x * p.weight, p.y * p.weight, p.weight])
        .collect();
    for level in 1..=degree {
        for j in (level..=degree).rev() {
            let i = j + span - degree;
            let (low, high) = (knot(i), knot(i + degree + 1 - level));
            let a = if high > low { (u - low) / (high - low) } else { 0.0 };
            let (before, here) = (*d.get(j - 1)?, d.get_mut(j)?);
            for (h, b) in here.iter_mut().zip(before) {
                *h = (1.0 - a) * b + a * *h;
            }
        }
    }
    let [x, y, w] = *d.last()?;
    (w != 0.0).then(|| (x / w, y / w))
}
