//! Well-known programs that have broken planners, and everyday work.

use crate::{AXES, Mode, Motion, Program, Rng, Step};
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// Names that [`named`] knows.
pub const NAMES: [&str; 16] = [
    "arcs-r4",
    "pocket",
    "spiral",
    "engraving",
    "surface",
    "surface-noise",
    "circle-in-lines",
    "five-axis",
    "tiny-corners",
    "reversal",
    "full-circle",
    "hundred-turns",
    "grains",
    "long-haul",
    "pure-rotary",
    "rotary-with-specks",
];

/// Makes the program with this name at a blend tolerance and feed; an unknown name gives none.
pub fn named(name: &str, tolerance: f64, feed: f64) -> Option<Program> {
    let name = *NAMES.iter().find(|n| **n == name)?;
    let mut out = Writer { steps: Vec::new(), mode: Mode::Blend(tolerance), feed };
    let mut rng = Rng::new(99);
    match name {
        "arcs-r4" => {
            for k in 0..40 {
                out.flat_arc(4.0, FRAC_PI_2 * f64::from(k), if k % 2 == 0 { 2.5 } else { -2.5 });
            }
        }
        "pocket" => pocket(&mut out),
        "spiral" => {
            let mut at = (0.0, 0.0);
            for k in 1..3000 {
                let angle = 0.05 * f64::from(k);
                let (sin, cos) = libm::sincos(angle);
                let next = (0.1 * angle * cos, 0.1 * angle * sin);
                out.line(next.0 - at.0, next.1 - at.1, 0.0);
                at = next;
            }
        }
        "engraving" => engraving(&mut out, &mut rng),
        "surface" => surface(&mut out, &mut rng, 0.0),
        "surface-noise" => surface(&mut out, &mut rng, 1e-3),
        "circle-in-lines" => {
            for k in 0..600 {
                let (sin, cos) = libm::sincos(0.01 * f64::from(k) + 0.005);
                out.line(-0.1 * sin, 0.1 * cos, 0.0);
            }
        }
        "five-axis" => five_axis(&mut out),
        "tiny-corners" => {
            for k in 0..30 {
                out.line(80.0, 0.0, 0.0);
                out.line(0.0, 0.02, 0.0);
                out.line(if k % 2 == 0 { -80.0 } else { -79.99 }, 0.0, 0.0);
                out.line(0.0, 0.02, 0.0);
            }
        }
        "reversal" => {
            for k in 1..20 {
                out.line(5.0 * f64::from(k), 0.0, 0.0);
                out.line(-5.0 * f64::from(k), 1e-4 * f64::from(k % 3), 0.0);
            }
        }
        "full-circle" => {
            for radius in [0.01, 0.5, 4.0, 40.0] {
                out.flat_arc(radius, 0.3, TAU);
                out.flat_arc(radius, 0.3, -TAU);
            }
        }
        "hundred-turns" => out.push(Motion::Arc {
            center: [-5.0, 0.0, 0.0],
            normal: [0.0, 0.0, 1.0],
            angle: 100.0 * TAU,
            rise: 50.0,
            others: [0.0; 6],
        }),
        "grains" => {
            for k in 0..200 {
                let small = 1e-9 * f64::from(k % 7);
                out.line(10.0, 0.0, 0.0);
                out.line(small, 1e-9, 0.0);
                out.line(0.0, 5.0, -small);
            }
        }
        "long-haul" => {
            out.line(1e6, 0.0, 0.0);
            out.line(0.0, 1.0, 0.0);
            out.line(-1e6, 1.0, 0.0);
        }
        "pure-rotary" => {
            for k in 0..20 {
                let mut by = [0.0; AXES];
                let turn = if k % 3 == 0 { -90.0 } else { 45.0 };
                if let Some(x) = by.get_mut(3 + k % 3) {
                    *x = turn;
                }
                out.push(Motion::Line { by });
            }
        }
        _ => {
            // XYZ of 5e-9 mm beside a turn of 100 degrees.
            for k in 0..12 {
                let mut by = [0.0; AXES];
                by[0] = 5e-9;
                by[3] = if k % 2 == 0 { 100.0 } else { -100.0 };
                out.push(Motion::Line { by });
                out.line(0.01, 0.0, 0.0);
            }
        }
    }
    Some(Program { name, seed: 0, start: [0.0; AXES], steps: out.steps })
}

/// Collects moves with one mode and feed.
struct Writer {
    steps: Vec<Step>,
    mode: Mode,
    feed: f64,
}

impl Writer {
    fn push(&mut self, motion: Motion) {
        self.steps.push(Step { motion, mode: self.mode, feed: self.feed });
    }

    fn line(&mut self, x: f64, y: f64, z: f64) {
        self.push(Motion::Line { by: [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] });
    }

    /// An arc in XY that starts in the direction `heading`.
    fn flat_arc(&mut self, radius: f64, heading: f64, angle: f64) {
        let (sin, cos) = libm::sincos(heading);
        let r = if angle < 0.0 { -radius } else { radius };
        let center = [-r * sin, r * cos, 0.0];
        let normal = [0.0, 0.0, 1.0];
        self.push(Motion::Arc { center, normal, angle, rise: 0.0, others: [0.0; 6] });
    }
}

/// A rectangular pocket with rounded corners, from the inside to the outside, entered by a helix.
fn pocket(out: &mut Writer) {
    out.push(Motion::Arc {
        center: [2.0, 0.0, 0.0],
        normal: [0.0, 0.0, 1.0],
        angle: 3.0 * TAU,
        rise: -3.0,
        others: [0.0; 6],
    });
    for k in 1..6 {
        let side = 6.0 * f64::from(k);
        for corner in 0..4 {
            let heading = FRAC_PI_2 * f64::from(corner);
            let (sin, cos) = libm::sincos(heading);
            out.line(side * cos, side * sin, 0.0);
            out.flat_arc(4.0, heading, FRAC_PI_2);
        }
        out.line(-3.0, -3.0, 0.0);
    }
}

/// Letters as short strokes and small arcs, with retracts.
fn engraving(out: &mut Writer, rng: &mut Rng) {
    for _ in 0..40 {
        out.line(0.0, 0.0, -1.0);
        let mut heading = rng.between(0.0, TAU);
        for _ in 0..rng.below(8) + 2 {
            if rng.chance(0.5) {
                let length = rng.between(0.1, 3.0);
                let (sin, cos) = libm::sincos(heading);
                out.line(length * cos, length * sin, 0.0);
                heading += rng.between(-2.0, 2.0);
            } else {
                let angle = rng.between(-PI, PI);
                out.flat_arc(rng.between(0.1, 1.5), heading, angle);
                heading += angle;
            }
        }
        out.line(0.0, 0.0, 1.0);
        out.line(rng.between(-3.0, 6.0), rng.between(-2.0, 2.0), 0.0);
    }
}

/// Surface finishing: rows of 0.1 mm lines over a wavy surface, with this noise.
fn surface(out: &mut Writer, rng: &mut Rng, noise: f64) {
    for row in 0..4 {
        let sign = if row % 2 == 0 { 1.0 } else { -1.0 };
        let mut last = 0.0;
        for k in 1..=300 {
            let x = 0.1 * f64::from(k);
            let z = 2.0 * libm::sin(0.35 * x) + rng.between(-noise, noise);
            out.line(0.1 * sign, rng.between(-noise, noise), z - last);
            last = z;
        }
        out.line(0.0, 0.3, -last);
    }
}

/// A swept surface in five axes: X Y Z with the tilt of A and C.
fn five_axis(out: &mut Writer) {
    for k in 0..400 {
        let t = 0.02 * f64::from(k);
        let (sin, cos) = libm::sincos(t);
        let mut by = [0.0; AXES];
        by[0] = 0.2 * cos;
        by[1] = 0.2 * sin;
        by[2] = 0.05 * libm::sin(3.0 * t);
        by[3] = 0.4 * libm::cos(2.0 * t);
        by[5] = 1.1;
        out.push(Motion::Line { by });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_a_finite_program() {
        for name in NAMES {
            let program = named(name, 0.01, 100.0).unwrap();
            assert!(!program.steps.is_empty(), "{name}");
            assert!(program.poses().iter().flatten().all(|x| x.is_finite()), "{name}");
            assert!(program.size() < 2e6, "{name}: {}", program.size());
        }
        assert!(named("unheard-of", 0.1, 1.0).is_none());
    }
}
