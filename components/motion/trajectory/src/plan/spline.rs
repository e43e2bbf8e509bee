//! B-splines and NURBS as moves.
//!
//! Between two knots the curve is a polynomial N over a polynomial w, the sum of the weights. Each such span becomes
//! curves of degree five with the values and the first two derivatives of the span at both ends. For such a curve P, the
//! difference P·w − N is a polynomial; its largest Bernstein coefficient over the least weight bounds the distance from
//! the programmed curve. Spans are halved until the bound is inside [`SHARE`] of the tolerance; a span of a cubic
//! B-spline is met exactly. The path coordinate is proportional to the parameter of the curve, so that P is as smooth as
//! the programmed curve: at a single knot of a cubic there is no joint, at a multiple knot there is a blend.
#![expect(
    clippy::indexing_slicing,
    reason = "the constructor has checked the numbers of knots and points"
)]

use super::Planner;
use crate::{
    curve::{Curve, Derivatives},
    error::{Error, SplineFault},
    kinematics::Kinematics,
    moves::{Mode, SHORTEST, check, lead},
    pose::{Group, Pose},
    segment::{Segment, Tolerances},
};

/// Share of the tolerance that the approximation of a spline may use; its joints keep to the rest.
const SHARE: f64 = 0.1;

/// Largest distance between the end of the move before and the start of a spline.
const START: f64 = 1e-6;

/// Largest change of direction over a piece, in radians; beyond it the piece is halved.
const TURN: f64 = 0.35;

/// Times that a span is halved at most.
const HALVINGS: u32 = 8;

/// Largest number of curves that a spline becomes.
const MAX_CURVES: usize = 4096;

/// Largest ratio of two weights.
const WEIGHTS: f64 = 1e6;

/// A B-spline (all weights equal) or NURBS in nine axes, of degree two or three.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<Weighted>,
}

/// A control point times its weight, and the weight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Weighted {
    point: Pose,
    weight: f64,
}

impl Spline {
    /// Curve with these knots, and control points with their weights: there are as many knots as control points, and
    /// `degree` + 1 more.
    pub fn new(degree: usize, knots: &[f64], points: &[(Pose, f64)]) -> Result<Self, SplineFault> {
        if !(2..=3).contains(&degree) {
            return Err(SplineFault::Degree);
        }
        if points.len() <= degree || knots.len() != points.len() + degree + 1 {
            return Err(SplineFault::Count);
        }
        let usable = |(point, weight): &(Pose, f64)| point.is_usable() && *weight > 0.0;
        let least = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        if !points.iter().all(usable) || points.iter().any(|p| p.1 > WEIGHTS * least) {
            return Err(SplineFault::Weight);
        }
        let rising = knots.windows(2).all(|k| matches!(k, [a, b] if a <= b));
        // Inside, at least one order of continuity is left at each knot.
        let inner = knots.get(1..knots.len() - 1).unwrap_or_default();
        let joined = inner.windows(degree + 1).all(|k| k.first() < k.last());
        let wide = knots.iter().all(|k| k.abs() <= 1e9);
        if !rising || !joined || !wide {
            return Err(SplineFault::Knots);
        }
        let points = points.iter().map(|(p, w)| Weighted { point: *p * *w, weight: *w }).collect();
        Ok(Self { degree, knots: knots.to_vec(), points })
    }

    /// Cubic B-spline with uniform knots that starts at the first control point and ends at the last.
    pub fn cubic(points: &[Pose]) -> Result<Self, SplineFault> {
        let spans = u32::try_from(points.len().saturating_sub(3)).unwrap_or(0);
        let inner = (0..=spans).map(f64::from);
        let knots: Vec<f64> =
            [0.0; 3].into_iter().chain(inner).chain([f64::from(spans); 3]).collect();
        let points: Vec<(Pose, f64)> = points.iter().map(|p| (*p, 1.0)).collect();
        Self::new(3, &knots, &points)
    }

    /// Spans that are not empty: their number, start and end.
    fn spans(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let bounds = self.knots.windows(2).enumerate();
        let spans = bounds.skip(self.degree).take(self.points.len() - self.degree);
        spans.map(|(k, w)| (k, w[0], w[1])).filter(|(_, a, b)| a < b)
    }

    /// Returns true if the curve has two continuous derivatives at this inner knot.
    fn is_smooth(&self, knot: f64) -> bool {
        let first = self.knots.partition_point(|k| *k < knot);
        let next = self.knots.partition_point(|k| *k <= knot);
        next - first + 2 <= self.degree
    }

    /// Blossom of a span: the polynomial in one argument per degree that agrees with the curve where all are equal.
    fn blossom(&self, span: usize, args: &[f64]) -> Weighted {
        let first = span - self.degree;
        let mut d = [Weighted::default(); 4];
        d[..=self.degree].copy_from_slice(&self.points[first..=span]);
        for (round, u) in args.iter().enumerate() {
            for j in (round + 1..=self.degree).rev() {
                let (low, high) =
                    (self.knots[first + j], self.knots[first + self.degree + j - round]);
                let share = (u - low) / (high - low);
                d[j] = d[j - 1].mix(&d[j], share);
            }
        }
        d[self.degree]
    }

    /// Bézier points, of degree three, between two parameters of a span.
    fn bezier(&self, span: usize, from: f64, to: f64) -> [Weighted; 4] {
        let point = |args: &[f64]| self.blossom(span, args);
        if self.degree == 3 {
            return [
                point(&[from, from, from]),
                point(&[from, from, to]),
                point(&[from, to, to]),
                point(&[to, to, to]),
            ];
        }
        let (a, b, c) = (point(&[from, from]), point(&[from, to]), point(&[to, to]));
        [a, a.mix(&b, 2.0 / 3.0), b.mix(&c, 1.0 / 3.0), c]
    }

    /// Lengths in the three groups, by chords.
    fn lengths(&self, spans: &[(usize, f64, f64)]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (span, from, to) in spans {
            let at = |k: u8| {
                let u = from + (to - from) * (f64::from(k) / 16.0);
                self.blossom(*span, &[u; 3][..self.degree]).pose()
            };
            let mut last = at(0);
            for k in 1..=16 {
                let next = at(k);
                let by = next - last;
                for (sum, group) in sums.iter_mut().zip(Group::ALL) {
                    *sum += by.norm(group);
                }
                last = next;
            }
        }
        sums
    }

    /// Cuts the curve into segments; `proto` has everything but the curve and its length.
    fn segments(
        &self,
        start: &Pose,
        proto: &Segment,
        tolerances: &Tolerances,
    ) -> Result<Vec<Segment>, SplineFault> {
        let spans: Vec<_> = self.spans().collect();
        let lengths = self.lengths(&spans);
        let (main, lead) = lead(lengths);
        if lengths.iter().all(|l| *l < 1e3 * SHORTEST) {
            return Err(SplineFault::Short);
        }
        let mut out: Vec<Segment> = Vec::new();
        let mut end: Option<Derivatives> = None;
        // A run of spans with two continuous derivatives has one scale of the path coordinate.
        let runs = spans.chunk_by(|_, next| self.is_smooth(next.1));
        for run in runs {
            let width: f64 = run.iter().map(|(_, from, to)| to - from).sum();
            let scale = self.lengths(run).into_iter().fold(0.0, f64::max) / width;
            if scale * width < 1e3 * SHORTEST {
                return Err(SplineFault::Short);
            }
            let mut smooth = false;
            for (span, from, to) in run {
                let mut pieces = 1_u32;
                let curves = loop {
                    let first = if smooth { end.as_ref() } else { None };
                    let pose = end.map_or(*start, |e| e.pose);
                    match self.pieces((*span, *from, *to), pieces, scale, pose, first, tolerances) {
                        (curves, true) => break curves,
                        (curves, _) if pieces >> HALVINGS > 0 => {
                            if curves.iter().any(|(_, ratio)| *ratio > 1.0) {
                                return Err(SplineFault::Sharp);
                            }
                            break curves;
                        }
                        _ => pieces *= 2,
                    }
                };
                if out.len() + curves.len() > MAX_CURVES {
                    return Err(SplineFault::Long);
                }
                let length = scale * (to - from) / f64::from(pieces);
                for (curve, _) in curves {
                    let lead_speed =
                        if lead == main { 1.0 } else { curve.bounds(0.0, length, lead).speed };
                    out.push(Segment { curve, length, lead, main, lead_speed, smooth, ..*proto });
                    smooth = true;
                    end = Some(curve.at(length));
                }
            }
        }
        Ok(out)
    }

    /// Curves for equal parts of a span, each with the ratio of its deviation to its share of the tolerance, and true if
    /// all are good enough.
    fn pieces(
        &self,
        (span, from, to): (usize, f64, f64),
        count: u32,
        scale: f64,
        start: Pose,
        first: Option<&Derivatives>,
        tolerances: &Tolerances,
    ) -> (Vec<(Curve, f64)>, bool) {
        let mut out = Vec::new();
        let mut good = true;
        let mut begin = first.copied();
        let length = scale * (to - from) / f64::from(count);
        for k in 0..count {
            let at = |k: u32| from + (to - from) * (f64::from(k) / f64::from(count));
            let b = self.bezier(span, at(k), if k + 1 == count { to } else { at(k + 1) });
            let [b0, b1, b2, b3] = b;
            let mut a = begin.unwrap_or_else(|| ending(&b0, &b1, &b2, length));
            if k == 0 {
                a.pose = start;
            }
            let z = ending(&b3, &b2, &b1, -length);
            let curve = Curve::hermite(&a, &z, length);
            let ratio = deviation(&a, &z, length, &b, tolerances) / SHARE;
            let bend = curve.bounds(0.0, length, Group::Xyz).second;
            let slow = a.first.dot_all(&a.first).min(z.first.dot_all(&z.first)).sqrt();
            good &= ratio <= 1.0 && bend.dot_all(&bend).sqrt() * length <= TURN * slow;
            out.push((curve, ratio));
            begin = Some(z);
        }
        (out, good)
    }
}

impl Weighted {
    fn mix(&self, other: &Self, share: f64) -> Self {
        let point = self.point * (1.0 - share) + other.point * share;
        Self { point, weight: self.weight * (1.0 - share) + other.weight * share }
    }

    fn pose(&self) -> Pose {
        self.point * (1.0 / self.weight)
    }

    /// Returns a + b·k.
    fn plus(&self, other: &Self, k: f64) -> Self {
        Self { point: self.point + other.point * k, weight: self.weight + other.weight * k }
    }
}

/// Pose and two derivatives at the end of a Bézier curve whose points from that end on are given. A negative length is
/// that of the curve read backward.
fn ending(b0: &Weighted, b1: &Weighted, b2: &Weighted, length: f64) -> Derivatives {
    let n1 = Weighted::default().plus(b1, 3.0).plus(b0, -3.0);
    let n2 = Weighted::default().plus(b2, 6.0).plus(b1, -12.0).plus(b0, 6.0);
    let part = 1.0 / b0.weight;
    let pose = b0.pose();
    let first = (n1.point - pose * n1.weight) * part;
    let second = (n2.point - first * (2.0 * n1.weight) - pose * n2.weight) * part;
    let k = 1.0 / length;
    Derivatives { pose, first: first * k, second: second * (k * k), third: Pose::ZERO }
}

/// Bounds the ratio of the distance between the curve of degree five through both ends and the rational curve with these
/// Bézier points to the tolerance, at equal parameters.
fn deviation(
    a: &Derivatives,
    z: &Derivatives,
    length: f64,
    b: &[Weighted; 4],
    tolerances: &Tolerances,
) -> f64 {
    let p = a.bernstein(z, length);
    let least = b.iter().map(|b| b.weight).fold(f64::INFINITY, f64::min);
    // Binomial coefficients of degree 3 and 5 over those of degree 8.
    let (three, five) = ([1.0, 3.0, 3.0, 1.0], [1.0, 5.0, 10.0, 10.0, 5.0, 1.0]);
    let eight = [1.0, 8.0, 28.0, 56.0, 70.0, 56.0, 28.0, 8.0, 1.0];
    let mut worst: f64 = 0.0;
    for (k, whole) in eight.iter().enumerate() {
        let mut sum = Pose::ZERO;
        for (j, (b, c3)) in b.iter().zip(three).enumerate() {
            let other = k.checked_sub(j).and_then(|i| Some((p.get(i)?, five.get(i)?)));
            if let Some((p, c5)) = other {
                sum = sum + (*p * b.weight - b.point) * (c3 * c5 / whole);
            }
        }
        worst = worst.max(tolerances.ratio(&sum) / least);
    }
    worst
}

impl<K: Kinematics> Planner<K> {
    /// Adds a B-spline or NURBS as a move; feed, mode and line are as in [`Move`](crate::Move). A refused move changes
    /// nothing.
    pub fn push_spline(
        &mut self,
        spline: &Spline,
        feed: f64,
        mode: Mode,
        line: u32,
    ) -> Result<(), Error> {
        if self.track.len() >= self.room {
            return Err(Error::Full);
        }
        check(feed, mode, line)?;
        let refused = |fault| Error::Spline { line, fault };
        let tolerances = self.tolerance(&mode);
        let first = spline.spans().next();
        let start = first.map(|(k, u, _)| spline.blossom(k, &[u; 3][..spline.degree]).pose());
        let by = start.unwrap_or_default() - self.position;
        if by.dot_all(&by).sqrt() > START {
            return Err(refused(SplineFault::Start));
        }
        // Inside the curve there is no stop.
        let inner = if mode == Mode::ExactStop { Mode::Exact } else { mode };
        let proto = Segment {
            curve: Curve::Line { start: Pose::ZERO, slope: Pose::ZERO },
            length: 0.0,
            lead: Group::Xyz,
            main: Group::Xyz,
            lead_speed: 1.0,
            feed: feed.min(1e9),
            rounded_for: feed.min(1e9),
            rapid: false,
            mode: inner,
            line,
            smooth: false,
            off: SHARE,
        };
        let mut segments = spline.segments(&self.position, &proto, &tolerances).map_err(refused)?;
        if let Some(last) = segments.last_mut() {
            last.mode = mode;
        }
        if !self.direct {
            for segment in &segments {
                self.check_reach(segment)?;
            }
        }
        self.flush(false);
        for segment in &segments {
            self.position = segment.curve.pose(segment.length);
            self.place(Some(segment));
        }
        self.publish();
        Ok(())
    }
}
