//! Connected regions of dark pixels, with their holes filled.

use hal_align::Vector;

/// Region of a picture: a rectangle with a frame of free pixels around it.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    /// Column and row of the rectangle's first pixel; may be left of or above the picture.
    pub(crate) left: i64,
    pub(crate) top: i64,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Pixels of the region.
    pub(crate) dark: Vec<bool>,
    /// Pixels of the region and of its holes.
    pub(crate) filled: Vec<bool>,
    /// The region touches the border of the picture.
    pub(crate) at_border: bool,
}

/// Width of the frame around a region, in pixels.
pub(crate) const FRAME: usize = 8;
/// Regions of fewer pixels are noise.
const LEAST: usize = 30;

/// Largest number of regions that are looked at.
const MAX_REGIONS: usize = 10_000;

/// Limits beyond which a region is no mark, so that it needs no map of its pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Largest number of dark pixels.
    pub(crate) pixels: usize,
    /// Largest width and height.
    pub(crate) side: usize,
}

/// Region beyond the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LargeRegion {
    /// Middle of its rectangle.
    pub(crate) middle: Vector,
    /// Number of dark pixels.
    pub(crate) pixels: usize,
    /// Longer side of its rectangle.
    pub(crate) side: usize,
}

/// Passes on the regions of dark pixels that touch by sides or corners, one after the other.
pub(crate) fn regions(
    dark: &[bool],
    width: usize,
    height: usize,
    limits: Limits,
    mut each: impl FnMut(Result<&Region, LargeRegion>),
) {
    let mut seen = vec![false; dark.len()];
    let mut stack: Vec<u32> = Vec::new();
    let mut pixels: Vec<u32> = Vec::new();
    let index = |at: usize| u32::try_from(at).unwrap_or(0);
    let mut regions = 0;
    for start in 0..dark.len() {
        if !dark.get(start).copied().unwrap_or(false) || seen.get(start).copied().unwrap_or(true) {
            continue;
        }
        pixels.clear();
        let mut around = PixelBox { left: usize::MAX, top: usize::MAX, right: 0, bottom: 0 };
        let mut count = 0_usize;
        stack.push(index(start));
        if let Some(s) = seen.get_mut(start) {
            *s = true;
        }
        while let Some(at) = stack.pop() {
            let at = usize::try_from(at).unwrap_or(0);
            let (x, y) = (at % width, at / width);
            around.take(x, y);
            count += 1;
            // Of a large region only the number and the rectangle matter.
            if count <= limits.pixels {
                pixels.push(index(at));
            }
            for ny in y.saturating_sub(1)..(y + 2).min(height) {
                for nx in x.saturating_sub(1)..(x + 2).min(width) {
                    let at = ny * width + nx;
                    if let (Some(true), Some(s @ false)) = (dark.get(at), seen.get_mut(at)) {
                        *s = true;
                        stack.push(index(at));
                    }
                }
            }
        }
        if count < LEAST {
            continue;
        }
        if count > limits.pixels || around.side() > limits.side {
            let (middle, side) = (around.middle(), around.side());
            each(Err(LargeRegion { middle, pixels: count, side }));
        } else {
            each(Ok(&Region::of(&pixels, &around, width, height)));
        }
        regions += 1;
        if regions >= MAX_REGIONS {
            return;
        }
    }
}

/// Rectangle around pixels.
struct PixelBox {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

impl PixelBox {
    fn take(&mut self, x: usize, y: usize) {
        (self.left, self.right) = (self.left.min(x), self.right.max(x));
        (self.top, self.bottom) = (self.top.min(y), self.bottom.max(y));
    }

    /// Returns the longer side.
    fn side(&self) -> usize {
        (self.right - self.left).max(self.bottom - self.top) + 1
    }

    fn middle(&self) -> Vector {
        Vector::new(
            (self.left + self.right + 1) as f64 / 2.0,
            (self.top + self.bottom + 1) as f64 / 2.0,
        )
    }
}

impl Region {
    fn of(pixels: &[u32], around: &PixelBox, width: usize, height: usize) -> Self {
        let PixelBox { left, top, right, bottom } = *around;
        let own_width = right - left + 1 + 2 * FRAME;
        let own_height = bottom - top + 1 + 2 * FRAME;
        let mut dark = vec![false; own_width * own_height];
        for at in pixels {
            let at = usize::try_from(*at).unwrap_or(0);
            let (x, y) = (at % width, at / width);
            let at = (y - top + FRAME) * own_width + (x - left + FRAME);
            if let Some(to) = dark.get_mut(at) {
                *to = true;
            }
        }
        let filled = fill(&dark, own_width, own_height);
        let frame = i64::try_from(FRAME).unwrap_or(0);
        let signed = |n: usize| i64::try_from(n).unwrap_or(0) - frame;
        Self {
            left: signed(left),
            top: signed(top),
            width: own_width,
            height: own_height,
            dark,
            filled,
            at_border: left == 0 || top == 0 || right + 1 >= width || bottom + 1 >= height,
        }
    }

    /// Returns the middle of the rectangle.
    pub(crate) fn middle(&self) -> Vector {
        Vector::new(
            self.left as f64 + self.width as f64 / 2.0,
            self.top as f64 + self.height as f64 / 2.0,
        )
    }

    /// Returns whether a pixel of the rectangle belongs to the filled region.
    pub(crate) fn is_filled(&self, x: usize, y: usize) -> bool {
        x < self.width && self.filled.get(y * self.width + x).copied().unwrap_or(false)
    }

    /// Returns the number of pixels of the filled region.
    pub(crate) fn area(&self) -> usize {
        self.filled.iter().filter(|f| **f).count()
    }
}

/// Returns all pixels that cannot be reached from outside.
fn fill(dark: &[bool], width: usize, height: usize) -> Vec<bool> {
    let mut filled = vec![true; dark.len()];
    let mut stack = vec![(0_usize, 0_usize)];
    while let Some((x, y)) = stack.pop() {
        let at = y * width + x;
        let (Some(false), Some(inside @ true)) = (dark.get(at), filled.get_mut(at)) else {
            continue;
        };
        *inside = false;
        if x > 0 {
            stack.push((x - 1, y));
        }
        if y > 0 {
            stack.push((x, y - 1));
        }
        if x + 1 < width {
            stack.push((x + 1, y));
        }
        if y + 1 < height {
            stack.push((x, y + 1));
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line from corner to corner, and a square of 20 pixels beside it: a map of the line would be the whole picture.
    #[test]
    fn a_large_region_has_no_map() {
        const N: usize = 1000;
        let is_dark = |x: usize, y: usize| x.abs_diff(y) < 2 || (700..720).contains(&x) && y < 20;
        let dark: Vec<bool> = (0..N * N).map(|at| is_dark(at % N, at / N)).collect();
        let mut found = Vec::new();
        regions(&dark, N, N, Limits { pixels: 4000, side: 100 }, |region| {
            found.push(region.map(|r| (r.left, r.top, r.dark.len(), r.area(), r.at_border)));
        });
        let line = LargeRegion { middle: Vector::new(500.0, 500.0), pixels: 3 * N - 2, side: N };
        assert_eq!(found, [Err(line), Ok((692, -8, 36 * 36, 400, true))]);
        regions(&dark, N, N, Limits { pixels: 399, side: N }, |region| {
            assert!(region.is_err());
        });
    }
}
