//! Threshold: which pixels are darker than their surroundings.

use crate::picture::smooth;

/// Deviation of the smoothing before the threshold, in pixels.
const SMOOTHING: f64 = 0.8;
/// Half the window of the local threshold, in pixels.
const HALF_WINDOW: usize = 25;
/// Least difference from the local mean that makes a pixel dark.
const BELOW_MEAN: f64 = 10.0;
/// Ratio of the darkest to the brightest part of the background below which light is uneven.
const UNEVEN: f32 = 0.75;

/// Returns the pixels that are dark, for a picture whose marks are dark.
pub(crate) fn dark(values: &[f32], width: usize, height: usize) -> Vec<bool> {
    let smoothed = smooth(values, width, height, SMOOTHING);
    if is_uneven(&smoothed, width, height) {
        local(&smoothed, width, height)
    } else {
        let level = otsu(&smoothed);
        smoothed.iter().map(|v| *v < level).collect()
    }
}

/// Returns whether the background is much darker in a part of the picture.
fn is_uneven(values: &[f32], width: usize, height: usize) -> bool {
    let mut levels = Vec::new();
    for row in 0..3 {
        for column in 0..3 {
            let mut tile: Vec<f32> = Vec::new();
            for y in (height * row / 3..height * (row + 1) / 3).step_by(2) {
                let line = values.get(y * width..).unwrap_or_default();
                let (from, to) = (width * column / 3, width * (column + 1) / 3);
                tile.extend(line.get(from..to).unwrap_or_default().iter().step_by(2));
            }
            tile.sort_by(f32::total_cmp);
            levels.push(tile.get(tile.len() * 9 / 10).copied().unwrap_or_default());
        }
    }
    let most = levels.iter().copied().fold(0.0, f32::max);
    let least = levels.iter().copied().fold(f32::MAX, f32::min);
    least < UNEVEN * most
}

/// Returns the level that separates two classes best (Otsu, A threshold selection method, 1979).
fn otsu(values: &[f32]) -> f32 {
    let mut counts = [0.0_f64; 256];
    for value in values {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a byte")]
        let bin = value.min(255.0) as usize;
        if let Some(count) = counts.get_mut(bin) {
            *count += 1.0;
        }
    }
    let total: f64 = counts.iter().sum();
    let weighted: f64 = counts.iter().enumerate().map(|(n, c)| n as f64 * c).sum();
    let (mut below, mut sum, mut best) = (0.0, 0.0, (0.0, 0_u16));
    for (level, count) in (0_u16..).zip(counts) {
        below += count;
        sum += f64::from(level) * count;
        let above = total - below;
        if below == 0.0 || above == 0.0 {
            continue;
        }
        let difference = sum / below - (weighted - sum) / above;
        let between = below * above * difference * difference;
        if between > best.0 {
            best = (between, level);
        }
    }
    f32::from(best.1) + 1.0
}

/// Returns the pixels that are darker than the mean of their window.
fn local(values: &[f32], width: usize, height: usize) -> Vec<bool> {
    // Sums of all pixels above and to the left.
    let mut sums = vec![0.0_f64; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0.0;
        for x in 0..width {
            row += f64::from(values.get(y * width + x).copied().unwrap_or_default());
            let above = sums.get(y * (width + 1) + x + 1).copied().unwrap_or_default();
            if let Some(to) = sums.get_mut((y + 1) * (width + 1) + x + 1) {
                *to = above + row;
            }
        }
    }
    let sum = |x: usize, y: usize| sums.get(y * (width + 1) + x).copied().unwrap_or_default();
    let mut out = Vec::with_capacity(values.len());
    for y in 0..height {
        let (top, bottom) = (y.saturating_sub(HALF_WINDOW), (y + HALF_WINDOW + 1).min(height));
        for x in 0..width {
            let (left, right) = (x.saturating_sub(HALF_WINDOW), (x + HALF_WINDOW + 1).min(width));
            let total = sum(right, bottom) - sum(left, bottom) - sum(right, top) + sum(left, top);
            let mean = total / ((right - left) * (bottom - top)) as f64;
            let value = f64::from(values.get(y * width + x).copied().unwrap_or_default());
            out.push(value < mean - BELOW_MEAN);
        }
    }
    out
}
