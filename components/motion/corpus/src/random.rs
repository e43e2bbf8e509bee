//! Random programs.

use crate::{AXES, Mode, Motion, Program, Rng, Spline, Step};

/// Kind of a random program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Lines of up to 30 units in every axis.
    Lines,
    /// Dense code: lines of 0.05 to 0.3 units whose direction drifts.
    Tiny,
    /// Arcs and helices, half of them with a radius of 4.
    Arcs,
    /// Lines in a plane, with reversals.
    Reversals,
    /// Lines with rotary axes that move much faster or slower than XYZ.
    Rotary,
    /// Lengths from 1e-9 to 1e3 units, side by side.
    Scales,
    /// All of the above in one program.
    Mixed,
    /// B-splines and NURBS beside lines, arcs and dense code.
    Splines,
}

impl Kind {
    /// Every kind of lines and arcs.
    pub const ALL: [Self; 7] = [
        Self::Lines,
        Self::Tiny,
        Self::Arcs,
        Self::Reversals,
        Self::Rotary,
        Self::Scales,
        Self::Mixed,
    ];

    /// Name of the kind.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lines => "lines",
            Self::Tiny => "tiny",
            Self::Arcs => "arcs",
            Self::Reversals => "reversals",
            Self::Rotary => "rotary",
            Self::Scales => "scales",
            Self::Mixed => "mixed",
            Self::Splines => "splines",
        }
    }
}

/// Options of a random program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Number of moves.
    pub count: usize,
    /// Number of axes that move, 1 to 9.
    pub axes: usize,
    /// Mode of most moves.
    pub mode: Mode,
    /// Programmed feed.
    pub feed: f64,
    /// Share of moves that end with an exact stop.
    pub stops: f64,
    /// Half the size of the work area; moves that leave it turn back.
    pub area: f64,
}

/// Makes a random program.
pub fn random(kind: Kind, seed: u64, options: &Options) -> Program {
    let mut rng = Rng::new(seed);
    let mut pose = [0.0; AXES];
    let mut heading = rng.between(0.0, core::f64::consts::TAU);
    let mut steps = Vec::with_capacity(options.count);
    while steps.len() < options.count {
        let mut one = kind;
        if kind == Kind::Mixed {
            one = rng.pick(&Kind::ALL, Kind::Lines);
        }
        if kind == Kind::Splines {
            let kinds = [Kind::Splines, Kind::Splines, Kind::Lines, Kind::Arcs, Kind::Tiny];
            one = rng.pick(&kinds, kind);
        }
        let arcs_fit = options.axes >= 2;
        let motion = match one {
            Kind::Lines | Kind::Mixed => lines(&mut rng, options.axes),
            Kind::Tiny => tiny(&mut rng, &mut heading, options.axes),
            Kind::Arcs if arcs_fit => arc(&mut rng, &mut heading, options.axes),
            Kind::Arcs | Kind::Reversals => reversals(&mut rng, &mut heading, options.axes),
            Kind::Rotary => rotary(&mut rng, options.axes),
            Kind::Scales => scales(&mut rng, options.axes),
            Kind::Splines => spline(&mut rng, &mut heading, options.axes),
        };
        let far = |p: &[f64; AXES]| p.iter().any(|x| x.abs() > options.area);
        let outside = far(&motion.end(&pose))
            || matches!(&motion, Motion::Spline(s) if s.placed(&pose).iter().any(|p| far(&p.0)));
        let motion = if outside { home(&mut rng, &pose) } else { motion };
        pose = motion.end(&pose);
        let stop = rng.chance(options.stops);
        let mode = if stop { Mode::ExactStop } else { options.mode };
        let feed = if rng.chance(0.1) { options.feed * rng.log(0.05, 5.0) } else { options.feed };
        steps.push(Step { motion, mode, feed });
    }
    Program { name: kind.name(), seed, start: [0.0; AXES], steps }
}

/// A line to the neighbourhood of the origin.
fn home(rng: &mut Rng, pose: &[f64; AXES]) -> Motion {
    let share = rng.between(0.7, 1.1);
    Motion::Line { by: pose.map(|x| -share * x) }
}

fn in_axes(axes: usize, mut value: impl FnMut(usize) -> f64) -> [f64; AXES] {
    let mut by = [0.0; AXES];
    for (k, x) in by.iter_mut().take(axes).enumerate() {
        *x = value(k);
    }
    by
}

fn lines(rng: &mut Rng, axes: usize) -> Motion {
    let still = if rng.chance(0.2) { rng.below(9) } else { 99 };
    let by = in_axes(axes, |k| {
        let d = rng.between(-30.0, 30.0);
        if u64::try_from(k).is_ok_and(|k| k == still) && axes > 1 { 0.0 } else { d }
    });
    Motion::Line { by }
}

fn tiny(rng: &mut Rng, heading: &mut f64, axes: usize) -> Motion {
    *heading += rng.between(-0.12, 0.12);
    let length = rng.between(0.05, 0.3);
    let (sin, cos) = libm::sincos(*heading);
    let by = in_axes(axes, |k| match k {
        0 => cos * length,
        1 => sin * length,
        _ => rng.between(-0.01, 0.01),
    });
    Motion::Line { by }
}

fn reversals(rng: &mut Rng, heading: &mut f64, axes: usize) -> Motion {
    if rng.chance(0.1) {
        *heading += core::f64::consts::PI;
    } else if rng.chance(0.5) {
        *heading += rng.between(-1.5, 1.5);
    }
    let length = rng.between(1.0, 60.0);
    let (sin, cos) = libm::sincos(*heading);
    Motion::Line {
        by: in_axes(axes, |k| match k {
            0 => cos * length,
            1 => sin * length,
            _ => 0.0,
        }),
    }
}

fn arc(rng: &mut Rng, heading: &mut f64, axes: usize) -> Motion {
    let radius = if rng.chance(0.5) { 4.0 } else { rng.between(0.5, 40.0) };
    let sign = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let angle = sign * if rng.chance(0.1) { core::f64::consts::TAU } else { rng.between(0.3, 5.5) };
    if rng.chance(0.4) {
        *heading += rng.between(-2.0, 2.0);
    }
    let (sin, cos) = libm::sincos(*heading);
    let center = [-radius * sign * sin, radius * sign * cos, 0.0];
    *heading += angle;
    let mut rise = 0.0;
    let mut others = [0.0; 6];
    if axes > 2 && rng.chance(0.3) {
        rise = rng.between(-0.5, 0.5) * radius * angle.abs();
    }
    if rng.chance(0.3) {
        for x in others.iter_mut().take(axes.saturating_sub(3)) {
            *x = rng.between(-20.0, 20.0);
        }
    }
    Motion::Arc { center, normal: [0.0, 0.0, 1.0], angle, rise, others }
}

/// Four to nine control points, half of them rational; some knots are double, and some joints to the move before are
/// tangent in X and Y.
fn spline(rng: &mut Rng, heading: &mut f64, axes: usize) -> Motion {
    let degree = if rng.chance(0.3) { 2 } else { 3 };
    let count = degree + 1 + usize::try_from(rng.below(6)).unwrap_or(0);
    let step = rng.pick(&[0.1, 1.0, 10.0, 10.0], 1.0);
    let wild = rng.pick(&[0.3, 1.0, 3.0], 1.0);
    let rational = rng.chance(0.5);
    if rng.chance(0.5) {
        *heading += rng.between(-2.0, 2.0);
    }
    let mut by = [0.0; AXES];
    let mut points = Vec::with_capacity(count);
    for k in 0..count {
        let weight = if rational { rng.log(0.3, 3.0) } else { 1.0 };
        points.push((by, weight));
        if k + 1 == count {
            break;
        }
        if k > 0 {
            *heading += rng.between(-wild, wild);
        }
        let length = step * rng.between(0.3, 1.5);
        let (sin, cos) = libm::sincos(*heading);
        for (axis, x) in by.iter_mut().take(axes).enumerate() {
            *x += match axis {
                0 => cos * length,
                1 => sin * length,
                _ => rng.between(-0.5, 0.5) * length,
            };
        }
    }
    let mut knots = vec![0.0; degree + 1];
    let (mut last, mut double) = (0.0, true);
    for _ in degree + 1..count {
        double = !double && rng.chance(0.15);
        last += if double { 0.0 } else { rng.between(0.5, 2.0) };
        knots.push(last);
    }
    knots.extend(vec![last + 1.0; degree + 1]);
    Motion::Spline(Box::new(Spline { degree, knots, points }))
}

fn rotary(rng: &mut Rng, axes: usize) -> Motion {
    let linear = rng.pick(&[0.0, 1e-8, 0.01, 1.0, 30.0], 0.0);
    let turning = rng.pick(&[0.01, 1.0, 90.0], 1.0);
    Motion::Line {
        by: in_axes(axes, |k| {
            let size = if axes <= 3 || (3..6).contains(&k) { turning } else { linear };
            rng.between(-size, size)
        }),
    }
}

fn scales(rng: &mut Rng, axes: usize) -> Motion {
    let length = if rng.chance(0.2) { 1e-9 } else { rng.log(1e-7, 1e3) };
    Motion::Line { by: in_axes(axes, |_| rng.between(-length, length)) }
}
