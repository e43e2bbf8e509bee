//! Programmed B-splines and NURBS, by the basis functions of Cox and de Boor. Only the constructor allocates.

use crate::shape::AXES;

/// Samples between two knots.
const SAMPLES: u32 = 16;

/// Highest degree.
const DEGREE: usize = 5;

/// A B-spline or NURBS in nine axes. Its fractions run from 0 to 1 with the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<([f64; AXES], f64)>,
    /// Fractions and poses, several between any two knots.
    samples: Vec<(f64, [f64; AXES])>,
}

impl Spline {
    /// Curve with these knots and control points, each with its weight; `None` if the degree is above five, or the numbers
    /// of knots and points do not belong to each other.
    pub fn new(degree: usize, knots: &[f64], points: &[([f64; AXES], f64)]) -> Option<Self> {
        let count = points.len();
        if degree == 0 || DEGREE < degree || count <= degree || knots.len() != count + degree + 1 {
            return None;
        }
        let mut out =
            Self { degree, knots: knots.to_vec(), points: points.to_vec(), samples: Vec::new() };
        let (begin, end) = out.ends();
        let mut samples = Vec::new();
        for span in knots.windows(2).skip(degree).take(count - degree) {
            let &[a, b] = span else { continue };
            if a >= b {
                continue;
            }
            for k in 0..SAMPLES {
                let u = a + (b - a) * (f64::from(k) / f64::from(SAMPLES));
                samples.push((u - begin) / (end - begin));
            }
        }
        samples.push(1.0);
        out.samples = samples.into_iter().map(|t| (t, out.at(t))).collect();
        Some(out)
    }

    /// First and last parameter.
    fn ends(&self) -> (f64, f64) {
        let knot = |k: usize| self.knots.get(k).copied().unwrap_or(0.0);
        (knot(self.degree), knot(self.points.len()))
    }

    /// Pose at the fraction `t`, from 0 to 1.
    pub fn at(&self, t: f64) -> [f64; AXES] {
        let (begin, end) = self.ends();
        let u = begin + (end - begin) * t;
        let knot = |k: usize| self.knots.get(k).copied().unwrap_or(0.0);
        // The last span that begins at or before `u` and is not empty.
        let last = self.points.len() - 1;
        let mut span = self.knots.partition_point(|k| *k <= u).saturating_sub(1).min(last);
        while span > self.degree && knot(span) >= knot(span + 1) {
            span -= 1;
        }
        let span = span.max(self.degree);
        // Values of the basis functions of rising degree that are not zero on the span.
        let mut basis = [0.0; DEGREE + 1];
        basis[0] = 1.0;
        for degree in 1..=self.degree {
            let mut carried = 0.0;
            for (k, value) in basis.iter_mut().take(degree + 1).enumerate() {
                let (low, high) = (knot(span + 1 + k - degree), knot(span + 1 + k));
                // The new function at the end of the row has no old one.
                let old = if k == degree { 0.0 } else { *value };
                let part = if high > low { old / (high - low) } else { 0.0 };
                *value = carried + (high - u) * part;
                carried = (u - low) * part;
            }
        }
        let (mut pose, mut sum) = ([0.0; AXES], 0.0);
        for ((point, weight), value) in
            self.points.iter().skip(span - self.degree).zip(basis).take(self.degree + 1)
        {
            let share = weight * value;
            sum += share;
            for (x, p) in pose.iter_mut().zip(point) {
                *x += p * share;
            }
        }
        pose.map(|x| x / sum)
    }

    /// Offers the intervals on either side of each sample whose value is below that of its neighbours; if `all` is true,
    /// those between any two samples. Knots are samples, so no interval has a corner inside.
    pub(crate) fn near(
        &self,
        all: bool,
        value: impl Fn(&[f64; AXES]) -> f64,
        mut offer: impl FnMut(f64, f64),
    ) {
        // Of the last two samples: whether the value fell to it, and the fraction and value.
        let (mut fell, mut last) = (true, None::<(f64, f64)>);
        let mut before = 0.0;
        for (t, pose) in &self.samples {
            let next = value(pose);
            if let Some((at, here)) = last {
                if all {
                    offer(at, *t);
                } else if fell && here <= next {
                    offer(before, at);
                    offer(at, *t);
                }
                fell = next <= here;
                before = at;
            }
            last = Some((*t, next));
        }
        if fell && !all {
            offer(before, 1.0);
        }
    }
}
