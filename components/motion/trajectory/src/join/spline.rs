//! The spline through a window of lines: a uniform cubic B-spline.

use crate::{curve::Curve, pose::Pose};

/// A uniform cubic B-spline.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    pub(super) control: Vec<Pose>,
    pub(super) spacing: f64,
}

impl Spline {
    pub(super) fn pieces(&self) -> usize {
        self.control.len().saturating_sub(3)
    }

    /// Spline that passes near its control points, instead of inside their polygon. The three points at either end, which
    /// give its ends, stay.
    pub(super) fn through(&self) -> Self {
        let mut control = self.control.clone();
        let inner = control.len().saturating_sub(6);
        for (point, around) in
            control.iter_mut().skip(3).take(inner).zip(self.control.windows(3).skip(2))
        {
            if let [a, b, c] = around {
                *point = *b - (*a - *b * 2.0 + *c) * (1.0 / 6.0);
            }
        }
        Self { control, spacing: self.spacing }
    }

    /// Returns all pieces as polynomials.
    pub(super) fn curves(&self) -> Vec<Curve> {
        let pieces = (0..self.pieces()).map_while(|k| self.piece(k));
        pieces.map(|piece| piece.curve(self.spacing)).collect()
    }

    /// Returns a piece as a polynomial.
    pub(super) fn piece(&self, number: usize) -> Option<Cubic> {
        let points = self.control.get(number..number + 4)?;
        let &[a, b, c, d] = points else { return None };
        let sixth = 1.0 / 6.0;
        let c0 = (a + b * 4.0 + c) * sixth;
        let c1 = (c - a) * 0.5;
        let c2 = (a - b * 2.0 + c) * 0.5;
        let c3 = (d - a + (b - c) * 3.0) * sixth;
        Some(Cubic([c0, c1, c2, c3]))
    }
}

/// A piece of a spline: coefficients of a polynomial in the share of its length.
pub(super) struct Cubic([Pose; 4]);

impl Cubic {
    /// Returns the value and the first derivative at `s`.
    #[inline]
    pub(super) fn at(&self, s: f64, length: f64) -> [Pose; 2] {
        let u = s / length;
        let [c0, c1, c2, c3] = self.0;
        let first = ((c3 * 3.0 * u + c2 * 2.0) * u + c1) * (1.0 / length);
        [((c3 * u + c2) * u + c1) * u + c0, first]
    }

    pub(super) fn curve(&self, length: f64) -> Curve {
        let [c0, c1, c2, c3] = self.0;
        Curve::Poly { c: [c0, c1, c2, c3, Pose::ZERO, Pose::ZERO], length }
    }
}
