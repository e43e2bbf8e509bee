//! Connected regions of dark pixels, with their holes filled.

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

/// Returns the regions of dark pixels that touch by sides or corners.
pub(crate) fn regions(dark: &[bool], width: usize, height: usize) -> Vec<Region> {
    let mut seen = vec![false; dark.len()];
    let mut out = Vec::new();
    let mut stack: Vec<(usize, usize)> = Vec::new();
    for start in 0..dark.len() {
        if !dark.get(start).copied().unwrap_or(false) || seen.get(start).copied().unwrap_or(true) {
            continue;
        }
        let mut pixels = Vec::new();
        stack.push((start % width, start / width));
        if let Some(s) = seen.get_mut(start) {
            *s = true;
        }
        while let Some((x, y)) = stack.pop() {
            pixels.push((x, y));
            for ny in y.saturating_sub(1)..(y + 2).min(height) {
                for nx in x.saturating_sub(1)..(x + 2).min(width) {
                    let at = ny * width + nx;
                    if let (Some(true), Some(s @ false)) = (dark.get(at), seen.get_mut(at)) {
                        *s = true;
                        stack.push((nx, ny));
                    }
                }
            }
        }
        if pixels.len() >= LEAST {
            out.push(Region::of(&pixels, width, height));
        }
    }
    out
}

impl Region {
    fn of(pixels: &[(usize, usize)], width: usize, height: usize) -> Self {
        let columns = pixels.iter().map(|p| p.0);
        let rows = pixels.iter().map(|p| p.1);
        let (left, right) = (columns.clone().min().unwrap_or(0), columns.max().unwrap_or(0));
        let (top, bottom) = (rows.clone().min().unwrap_or(0), rows.max().unwrap_or(0));
        let own_width = right - left + 1 + 2 * FRAME;
        let own_height = bottom - top + 1 + 2 * FRAME;
        let mut dark = vec![false; own_width * own_height];
        for (x, y) in pixels {
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
