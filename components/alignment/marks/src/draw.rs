//! Drawn pictures of a sheet with marks.

use crate::{
    picture::{Picture, smooth},
    random::Random,
    search::MarkKind,
};
use hal_align::{Matrix, Transform, Vector};
use libm::fabs;

/// Samples of a pixel at an edge, along each side.
const SAMPLES: u32 = 8;

/// Figure on a sheet, in millimetres of the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Figure {
    /// Mark of a kind: its centre, diameter or side, and angle in degrees; the width of its line if it is an outline.
    Mark {
        /// Kind.
        kind: MarkKind,
        /// Centre.
        centre: Vector,
        /// Diameter or side.
        size: f64,
        /// Angle in degrees, counterclockwise.
        angle: f64,
        /// Width of the line of an outline.
        outline: Option<f64>,
    },
    /// Bar, such as a line or a part of a letter: centre, length and width, angle in degrees.
    Bar {
        /// Centre.
        centre: Vector,
        /// Length and width.
        size: Vector,
        /// Angle in degrees, counterclockwise.
        angle: f64,
    },
}

impl Figure {
    /// Returns the distance of a point from the edge, or less: positive inside.
    fn depth(&self, point: Vector) -> f64 {
        let turned =
            |centre: Vector, angle: f64| Matrix::rotation(-angle.to_radians()) * (point - centre);
        match *self {
            Self::Mark { kind, centre, size, angle, outline } => {
                let p = turned(centre, angle);
                let depth = match kind {
                    MarkKind::Circle => size / 2.0 - p.length(),
                    MarkKind::Square => size / 2.0 - fabs(p.x).max(fabs(p.y)),
                };
                outline.map_or(depth, |width| depth.min(width - depth))
            }
            Self::Bar { centre, size, angle } => {
                let p = turned(centre, angle);
                (size.x / 2.0 - fabs(p.x)).min(size.y / 2.0 - fabs(p.y))
            }
        }
    }
}

/// Sheet with figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Brightness of the sheet, 0 to 255.
    pub background: f64,
    /// Brightness of the figures.
    pub ink: f64,
    /// Figures.
    pub figures: Vec<Figure>,
}

/// Camera above a sheet, and the quality of its picture.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Width and height of the picture in pixels.
    pub size: (usize, usize),
    /// From pixels to millimetres of the machine.
    pub linear: Matrix,
    /// Place of the machine in the middle of the picture.
    pub at: Vector,
    /// Place of the sheet on the machine.
    pub part: Transform,
    /// Tilt of the camera: relative change of the scale per pixel, along X and Y of the picture.
    pub tilt: Vector,
    /// Deviation of the blur in pixels.
    pub blur: f64,
    /// Deviation of the noise.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Change of the light across the picture, as a part of the light in its middle.
    pub light: Vector,
}

impl View {
    /// Returns a view without blur, noise and tilt.
    #[must_use]
    pub fn new(width: usize, height: usize, linear: Matrix, at: Vector) -> Self {
        Self {
            size: (width, height),
            linear,
            at,
            part: Transform::IDENTITY,
            tilt: Vector::ZERO,
            blur: 0.0,
            noise: 0.0,
            seed: 1,
            light: Vector::ZERO,
        }
    }

    fn middle(&self) -> Vector {
        Vector::new(self.size.0 as f64 / 2.0, self.size.1 as f64 / 2.0)
    }

    /// Returns the place of the machine that is seen at a place of the picture.
    #[must_use]
    pub fn machine(&self, pixel: Vector) -> Vector {
        let from = pixel - self.middle();
        self.at + self.linear * (from * (1.0 / (1.0 + self.tilt.dot(from))))
    }

    /// Returns the place of the picture at which a place of the machine is seen.
    #[must_use]
    pub fn pixel(&self, machine: Vector) -> Option<Vector> {
        let from = self.linear.inverse()? * (machine - self.at);
        Some(self.middle() + from * (1.0 / (1.0 - self.tilt.dot(from))))
    }

    /// Draws the picture. Returns `None` if the sheet's place has no inverse.
    #[must_use]
    pub fn draw(&self, sheet: &Sheet) -> Option<Picture> {
        let (width, height) = self.size;
        let to_sheet = self.part.inverse()?;
        let stretch = to_sheet.linear.stretches().0 * self.linear.stretches().0;
        let near = stretch * (1.0 + self.tilt.length() * (width + height) as f64);
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let place = |dx, dy| {
                    to_sheet.apply(self.machine(Vector::new(x as f64 + dx, y as f64 + dy)))
                };
                let middle = place(0.5, 0.5);
                let depth = |p: Vector| {
                    sheet.figures.iter().map(|f| f.depth(p)).fold(f64::NEG_INFINITY, f64::max)
                };
                let deep = depth(middle);
                let covered = if fabs(deep) > near {
                    f64::from(u8::from(deep > 0.0))
                } else {
                    let step = 1.0 / f64::from(SAMPLES);
                    let at = |n: u32| (f64::from(n) + 0.5) * step;
                    let points = (0..SAMPLES * SAMPLES)
                        .map(|n| place(at(n % SAMPLES), at(n / SAMPLES)))
                        .filter(|p| depth(*p) > 0.0);
                    points.count() as f64 * step * step
                };
                let from = Vector::new(
                    (x as f64 + 0.5) / width as f64 - 0.5,
                    (y as f64 + 0.5) / height as f64 - 0.5,
                );
                let lit = 1.0 + self.light.dot(from);
                let value = sheet.background + (sheet.ink - sheet.background) * covered;
                #[expect(clippy::cast_possible_truncation, reason = "a brightness")]
                values.push((value * lit) as f32);
            }
        }
        if self.blur > 0.0 {
            values = smooth(&values, width, height, self.blur);
        }
        let mut random = Random::new(self.seed);
        let byte = |v: f32| {
            let noise = if self.noise > 0.0 { self.noise * random.normal() } else { 0.0 };
            let v = libm::round(f64::from(v) + noise);
            let v = if v > 0.0 { v.min(255.0) } else { 0.0 };
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a byte")]
            let byte = v as u8;
            byte
        };
        Some(Picture::new(width, height, values.into_iter().map(byte).collect()))
    }
}
