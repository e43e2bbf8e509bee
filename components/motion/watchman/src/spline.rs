//! Programmed B-splines and NURBS, by the basis functions of Cox and de Boor. Only the constructor allocates.

use crate::shape::{AXES, along, dot3};

/// Samples between two knots.
const SAMPLES: u32 = 16;

/// Most halvings of the interval between two samples where the curve turns.
const HALVINGS: u32 = 14;

/// Highest degree.
const DEGREE: usize = 5;

/// A B-spline or NURBS in nine axes. Its fractions run from 0 to 1 with the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<([f64; AXES], f64)>,
    /// Fractions and poses, several between any two knots, so close that the curve turns little from one to the next. A
    /// distance then has one least value between them.
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
        let mut samples: Vec<(f64, [f64; AXES])> = Vec::new();
        for span in knots.windows(2).skip(degree).take(count - degree) {
            let &[a, b] = span else { continue };
            if a >= b {
                continue;
            }
            for k in 0..SAMPLES {
                let u = a + (b - a) * (f64::from(k) / f64::from(SAMPLES));
                out.sample((u - begin) / (end - begin), 0, &mut samples);
            }
        }
        out.sample(1.0, 0, &mut samples);
        out.samples = samples;
        Some(out)
    }

    /// Appends the sample at the fraction `t`, and before it more of them if the curve turns on the way from the last one.
    fn sample(&self, t: f64, halvings: u32, samples: &mut Vec<(f64, [f64; AXES])>) {
        let pose = self.at(t);
        if let Some((last, from)) = samples.last()
            && halvings < HALVINGS
            && self.turns((*last, from), (t, &pose))
        {
            self.sample(last + 0.5 * (t - last), halvings + 1, samples);
            self.sample(t, halvings + 1, samples);
            return;
        }
        samples.push((t, pose));
    }

    /// Returns true if one of four parts of the curve leads more than 30° away from the whole, in XYZ, ABC or UVW.
    fn turns(&self, from: (f64, &[f64; AXES]), to: (f64, &[f64; AXES])) -> bool {
        let whole = along(from.1, to.1);
        let mut last = *from.1;
        (1..=4).any(|k| {
            let next = self.at(from.0 + 0.25 * f64::from(k) * (to.0 - from.0));
            let part = along(&last, &next);
            last = next;
            whole.iter().zip(&part).any(|(whole, part)| {
                let (both, lengths) =
                    (dot3(*whole, *part), dot3(*whole, *whole) * dot3(*part, *part));
                // A part that stands still does not turn; one that leads back does, however short the whole is.
                dot3(*part, *part) > 0.0 && (both <= 0.0 || both * both < 0.75 * lengths)
            })
        })
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
