//! Measurement of a region: sub-pixel centre, shape and angle from the coverage of each pixel.

use crate::{
    moments::{Covered, Moments, centroid},
    picture::Picture,
    refine::refine,
    region::{FRAME, Region},
    search::MarkKind,
};
use hal_align::Vector;
use libm::{fabs, hypot, sqrt};

/// Distance of pixels inside the mark that are surely covered, in pixels.
const INSIDE: usize = 2;
/// Distance outside the mark within which a pixel may be covered in part, in pixels.
const OUTSIDE: usize = 3;
/// Least difference of mark and background.
const CONTRAST: f64 = 25.0;
/// Uncertainty that remains without noise, in pixels.
const FLOOR: f64 = 0.005;
/// Uncertainty by the model of an edge, in pixels.
const MODEL: f64 = 0.002;

/// Mark in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundMark {
    /// Kind of the mark.
    pub kind: MarkKind,
    /// Centre in pixels from the left and from the top; the first pixel ends at 1.
    pub centre: Vector,
    /// Angle of a square in degrees between -45 and 45, from X towards the downward Y; of a circle 0.
    pub angle: f64,
    /// Area in square pixels.
    pub area: f64,
    /// Standard deviation of each coordinate of the centre, in pixels, from the noise of the background.
    pub uncertainty: f64,
    /// Brightness of the background less that of the mark.
    pub contrast: f64,
}

/// Measures of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measures {
    pub(crate) centre: Vector,
    pub(crate) area: f64,
    /// 1 for a disc, 0.955 for a square, less for anything else.
    pub(crate) roundness: f64,
    /// Ratio of the second moments along and across the longest direction.
    pub(crate) elongation: f64,
    /// 0 for a disc, 1 for a square.
    pub(crate) squareness: f64,
    pub(crate) angle: f64,
    pub(crate) uncertainty: f64,
    pub(crate) contrast: f64,
}

impl Measures {
    /// Returns the measures of these moments about the centroid.
    fn of(m: &Moments, uncertainty: f64, contrast: f64) -> Self {
        let sum = m.xx + m.yy;
        let radius = hypot((m.xx - m.yy) / 2.0, m.xy);
        let size = hypot(m.real, m.imaginary);
        Self {
            centre: m.centre,
            area: m.mass,
            roundness: m.mass * m.mass / (core::f64::consts::TAU * sum),
            elongation: (sum / 2.0 + radius) / (sum / 2.0 - radius).max(1e-9),
            squareness: 60.0 * size / (m.mass * m.mass * m.mass),
            angle: m.angle().to_degrees(),
            uncertainty,
            contrast,
        }
    }
}

/// Light on the background around a mark: a plane, by least squares.
struct Light {
    level: f64,
    x: f64,
    y: f64,
    /// Deviation of the background from the plane.
    noise: f64,
}

impl Light {
    fn at(&self, x: f64, y: f64) -> f64 {
        self.level + self.x * x + self.y * y
    }
}

/// Pixel of the rectangle of a region.
#[derive(Clone, Copy)]
struct Pixel {
    x: f64,
    y: f64,
    value: f64,
    place: Place,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Core,
    Edge,
    Background,
}

/// Measures a region. Returns `None` if the mark is too faint.
pub(crate) fn measure(picture: &Picture, region: &Region) -> Option<Measures> {
    let pixels = pixels(picture, region);
    let light = light(&pixels)?;
    // Brightness of the mark, and as a part of the light.
    let (mut ratios, mut values) = (Vec::new(), Vec::new());
    for y in 0..region.height {
        for x in 0..region.width {
            let dark = |x: usize, y: usize| region.dark.get(y * region.width + x) == Some(&true);
            let is_inner = x > 0 && y > 0 && dark(x, y) && dark(x - 1, y) && dark(x, y - 1);
            if is_inner && dark(x + 1, y) && dark(x, y + 1) {
                let (px, py, value) = pixel(picture, region, x, y);
                ratios.push(value / light.at(px, py).max(1.0));
                values.push(value);
            }
        }
    }
    let (ratio, level) = (median(&mut ratios)?, median(&mut values)?);
    // The light on a dark background says little about the light on a bright mark.
    let mark = |lit: f64| if ratio < 1.0 { lit * ratio } else { level };
    let middle = region.middle();
    let lit = light.at(middle.x, middle.y);
    let contrast = lit - mark(lit);
    if fabs(contrast) < CONTRAST {
        return None;
    }
    let (mut covered, mut edge): (Vec<Covered>, Vec<Covered>) = (Vec::new(), Vec::new());
    for p in pixels.iter().filter(|p| p.place != Place::Background) {
        let lit = light.at(p.x, p.y);
        let part = (lit - p.value) / (lit - mark(lit));
        let within = match p.place {
            Place::Core => 1.0,
            _ if part > 0.0 => part.min(1.0),
            _ => 0.0,
        };
        if p.place == Place::Edge {
            edge.push((p.x, p.y, part));
        }
        if within > 0.0 {
            covered.push((p.x, p.y, within));
        }
    }
    let centre = centroid(&covered);
    let moments = Moments::about(centre, covered.iter().copied());
    let spread: f64 = edge.iter().map(|p| (p.0 - centre.x) * (p.0 - centre.x)).sum();
    let noise = light.noise / fabs(contrast);
    let deviation = noise * sqrt(spread) / moments.mass;
    let mut measures = Measures::of(&moments, hypot(deviation, FLOOR), contrast);
    let is_square = measures.squareness > 0.5;
    // The profile of an edge is a model, the centroid none: without noise the centroid is exact.
    if let Some(better) = refine(&covered, &edge, &moments, is_square, noise)
        && hypot(better.deviation, MODEL) < deviation
    {
        measures.centre = better.centre;
        measures.uncertainty = hypot(better.deviation, FLOOR);
    }
    measures.centre.is_usable().then_some(measures)
}

/// Returns the centre and the value of a pixel of a region's rectangle.
fn pixel(picture: &Picture, region: &Region, x: usize, y: usize) -> (f64, f64, f64) {
    let place = |first: i64, n: usize| first + i64::try_from(n).unwrap_or(0);
    let (column, row) = (place(region.left, x), place(region.top, y));
    let near = |n: i64| usize::try_from(n).unwrap_or(0);
    let value = picture.at(near(column), near(row));
    (column as f64 + 0.5, row as f64 + 0.5, f64::from(value))
}

/// Returns the pixels of a region and around it, by their place.
fn pixels(picture: &Picture, region: &Region) -> Vec<Pixel> {
    let mut out = Vec::with_capacity(region.width * region.height);
    let sums = sums(region);
    for y in 0..region.height {
        for x in 0..region.width {
            let near = |reach: usize| {
                let (left, right) = (x.saturating_sub(reach), (x + reach + 1).min(region.width));
                let (top, bottom) = (y.saturating_sub(reach), (y + reach + 1).min(region.height));
                let sum =
                    |x: usize, y: usize| sums.get(y * (region.width + 1) + x).copied().unwrap_or(0);
                (sum(right, bottom) + sum(left, top)) - (sum(left, bottom) + sum(right, top))
            };
            let place = if region.is_filled(x, y) {
                // The frame keeps this neighbourhood within the rectangle.
                let all = near(INSIDE) as usize == (2 * INSIDE + 1) * (2 * INSIDE + 1);
                if all { Place::Core } else { Place::Edge }
            } else if near(OUTSIDE) > 0 {
                Place::Edge
            } else if near(FRAME - 1) > 0 {
                Place::Background
            } else {
                continue;
            };
            let (px, py, value) = pixel(picture, region, x, y);
            let inside =
                0.0 < px && px < picture.width() as f64 && 0.0 < py && py < picture.height() as f64;
            if inside {
                out.push(Pixel { x: px, y: py, value, place });
            }
        }
    }
    out
}

/// Returns the number of filled pixels left of and above each corner of a pixel.
fn sums(region: &Region) -> Vec<u32> {
    let columns = region.width + 1;
    let mut sums = vec![0; columns * (region.height + 1)];
    for y in 0..region.height {
        let mut row = 0;
        for x in 0..region.width {
            row += u32::from(region.is_filled(x, y));
            let above = sums.get(y * columns + x + 1).copied().unwrap_or(0);
            if let Some(sum) = sums.get_mut((y + 1) * columns + x + 1) {
                *sum = above + row;
            }
        }
    }
    sums
}

/// Returns the light on the background.
fn light(pixels: &[Pixel]) -> Option<Light> {
    let mut values: Vec<f64> =
        pixels.iter().filter(|p| p.place == Place::Background).map(|p| p.value).collect();
    if values.len() < 12 {
        return None;
    }
    let level = median(&mut values)?;
    let mut deviations: Vec<f64> = values.iter().map(|v| fabs(v - level)).collect();
    let usual = median(&mut deviations)?.max(3.0);
    // Other figures near the mark are not background.
    let own = |p: &&Pixel| p.place == Place::Background && fabs(p.value - level) < 6.0 * usual;
    let (mut n, mut x, mut y, mut v) = (0.0, 0.0, 0.0, 0.0);
    for p in pixels.iter().filter(own) {
        (n, x, y, v) = (n + 1.0, x + p.x, y + p.y, v + p.value);
    }
    let (x, y, v) = (x / n, y / n, v / n);
    let (mut xx, mut xy, mut yy, mut xv, mut yv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for p in pixels.iter().filter(own) {
        let (dx, dy, dv) = (p.x - x, p.y - y, p.value - v);
        (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        (xv, yv) = (xv + dx * dv, yv + dy * dv);
    }
    let det = xx * yy - xy * xy;
    let slope = ((xv * yy - yv * xy) / det, (yv * xx - xv * xy) / det);
    let (by_x, by_y) = if slope.0.is_finite() && slope.1.is_finite() { slope } else { (0.0, 0.0) };
    let mut light = Light { level: v - by_x * x - by_y * y, x: by_x, y: by_y, noise: 0.0 };
    let square = |p: &Pixel| (p.value - light.at(p.x, p.y)) * (p.value - light.at(p.x, p.y));
    light.noise = sqrt(pixels.iter().filter(own).map(square).sum::<f64>() / n);
    Some(light)
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let upper = values.get(middle)?;
    let lower = values.get(middle.saturating_sub(1))?;
    Some(if values.len().is_multiple_of(2) { (upper + lower) / 2.0 } else { *upper })
}
