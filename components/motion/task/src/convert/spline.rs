//! Curves of G5, G5.1 and G5.2 as chords: motion joins short lines to curves within the tolerance of the path.

use super::{Action, Converter};
use crate::outside::{Order, PathEnd, Shape};
use hal_gcode::{
    axis::Position,
    canon::{ControlPoint, PathMode, curve_point},
};

/// Smallest and largest number of chords of a curve.
const FEWEST: u32 = 8;
const MOST: u32 = 4096;

/// Part of the tolerance that chords use; the path along them keeps to the rest.
const SHARE: f64 = 0.1;

/// Largest distance of chords from the curve, and the one on an exact path, in millimetres. Coarser chords turn further
/// from each to the next, so that a looser path would be slower.
const COARSEST: f64 = 0.000_1;
const EXACT: f64 = 0.000_02;

impl Converter {
    /// Adds the chords of a curve. Returns false if it has too few control points.
    pub(super) fn spline(
        &mut self,
        (order, points): (u32, &[ControlPoint]),
        end: Position,
        line: u32,
        out: &mut Vec<Action>,
    ) -> bool {
        let unit = self.frame.unit.millimetres();
        let tolerance = match self.path {
            PathMode::Continuous { tolerance } if tolerance > 0.0 => {
                (SHARE * tolerance).min(COARSEST / unit)
            }
            PathMode::Continuous { .. } => COARSEST / unit,
            PathMode::ExactPath | PathMode::ExactStop => EXACT / unit,
        };
        let Some(mut ends) = chords(order, points, tolerance) else { return false };
        // The last one is the end itself.
        ends.pop();
        let ends = ends.into_iter().map(|(x, y)| (Position { x, y, ..end }, false));
        for (to, is_last) in ends.chain([(end, true)]) {
            let mut order = self.to(to, Shape::Line, false, line);
            if let Order::Move(m) = &mut order {
                m.end = match m.end {
                    PathEnd::Blend(tolerance) => PathEnd::Blend((1.0 - SHARE) * tolerance),
                    PathEnd::Stop if !is_last => PathEnd::Exact,
                    other => other,
                };
                m.cam_tolerance *= 1.0 - SHARE;
            }
            out.push(Action::Path(order));
        }
        true
    }
}

/// Returns the ends of chords within a distance of a curve, as far as `MOST` chords can be.
fn chords(order: u32, points: &[ControlPoint], tolerance: f64) -> Option<Vec<(f64, f64)>> {
    let mut count = FEWEST;
    loop {
        // Every other point is the end of a chord; the point between shows the distance.
        let share = |n: u32| f64::from(n) / f64::from(2 * count);
        let all = (0..=2 * count).map(|n| curve_point(order, points, share(n)));
        let all = all.collect::<Option<Vec<_>>>()?;
        let is_near = all.windows(3).step_by(2).all(|w| match w {
            [a, b, c] => distance(*a, *b, *c) <= tolerance,
            _ => true,
        });
        if is_near || count >= MOST {
            return Some(all.into_iter().skip(2).step_by(2).collect());
        }
        count *= 2;
    }
}

/// Returns the distance of a point from the line between two others.
fn distance(from: (f64, f64), at: (f64, f64), to: (f64, f64)) -> f64 {
    let ((x, y), (u, v)) = ((at.0 - from.0, at.1 - from.1), (to.0 - from.0, to.1 - from.1));
    let length = (u * u + v * v).sqrt();
    if length > 0.0 { (x * v - y * u).abs() / length } else { (x * x + y * y).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_are_as_fine_as_the_tolerance_asks() {
        // A quarter of a circle of radius 10, as a NURBS.
        let point = |x, y, weight| ControlPoint { x, y, weight };
        let quarter =
            [point(10.0, 0.0, 1.0), point(10.0, 10.0, 0.5_f64.sqrt()), point(0.0, 10.0, 1.0)];
        let mut counts = Vec::new();
        for tolerance in [0.1, 0.001, 0.000_01] {
            let ends = chords(3, &quarter, tolerance).unwrap();
            let mut last = (10.0_f64, 0.0_f64);
            for (x, y) in &ends {
                assert!((x.hypot(*y) - 10.0).abs() < 1e-12);
                let middle = ((x + last.0) / 2.0).hypot((y + last.1) / 2.0);
                assert!(10.0 - middle <= 1.1 * tolerance, "{tolerance}: {middle}");
                last = (*x, *y);
            }
            assert!(last.0.abs() < 1e-12 && (last.1 - 10.0).abs() < 1e-12);
            counts.push(ends.len());
        }
        assert!(counts.is_sorted() && counts[0] == 8 && counts[2] < 2000, "{counts:?}");
        assert_eq!(chords(4, &quarter, 0.1), None);
    }
}
