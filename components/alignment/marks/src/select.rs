//! The wanted mark among those of a picture, and the mean of several pictures.

use crate::{
    measure::Found,
    search::{Rejected, Search, Seen},
};
use core::fmt;
use hal_align::Vector;

/// Difference of the distances of two marks, as a part of the smaller one, below which the choice is unclear.
const CLEAR: f64 = 0.2;
/// Largest distance of a picture's centre from the mean, in pixels.
const SCATTER: f64 = 0.3;

/// Reason why a mark was not found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unfound {
    /// No mark: the number of other regions, and the reason of the one that is nearest.
    None(usize, Option<Rejected>),
    /// Two marks that are about as near: their distances in pixels.
    Ambiguous(f64, f64),
    /// Pictures that differ: the largest distance from the mean, in pixels.
    Scatter(f64),
    /// No pictures.
    NoPictures,
}

impl fmt::Display for Unfound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None(0, _) | Self::None(_, None) => {
                f.write_str("there is no mark in the picture")
            }
            Self::None(n, Some(why)) => write!(
                f,
                "there is no mark among {n} figures in the picture; the nearest one is none: {why}"
            ),
            Self::Ambiguous(a, b) => write!(
                f,
                "two marks are about as near ({a:.1} and {b:.1} pixels): move closer to the one that is meant"
            ),
            Self::Scatter(by) => write!(
                f,
                "the pictures differ by {by:.2} pixels, and {SCATTER} are allowed: the camera or the part moves, or the picture is poor"
            ),
            Self::NoPictures => f.write_str("there are no pictures"),
        }
    }
}

/// Returns the mark nearest to a place in the picture, in pixels.
///
/// # Errors
/// There is none, or two are about as near.
pub fn choose(seen: &Seen, near: Vector) -> Result<Found, Unfound> {
    let distance = |m: &Found| (m.centre - near).length();
    let mut marks: Vec<&Found> = seen.marks.iter().collect();
    marks.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    match marks.as_slice() {
        [] => {
            let far = |r: &&(Vector, Rejected)| (r.0 - near).length();
            let nearest = seen.rejected.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            Err(Unfound::None(seen.rejected.len(), nearest.map(|r| r.1)))
        }
        [first, second, ..] if distance(second) <= distance(first) * (1.0 + CLEAR) => {
            Err(Unfound::Ambiguous(distance(first), distance(second)))
        }
        [first, ..] => Ok(**first),
    }
}

/// Mean of the marks of several pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// Mark with the mean of the centres and angles.
    pub mark: Found,
    /// Largest distance of a centre from the mean, in pixels.
    pub scatter: f64,
    /// Number of pictures.
    pub pictures: usize,
}

/// Returns the mean of one mark in several pictures.
///
/// # Errors
/// There are no marks, or they scatter.
pub fn average(marks: &[Found]) -> Result<Mean, Unfound> {
    let n = marks.len() as f64;
    let first = marks.first().ok_or(Unfound::NoPictures)?;
    let centre = marks.iter().fold(Vector::ZERO, |a, m| a + m.centre) * (1.0 / n);
    let scatter = marks.iter().map(|m| (m.centre - centre).length()).fold(0.0, f64::max);
    if !matches!(scatter.partial_cmp(&SCATTER), Some(core::cmp::Ordering::Less)) {
        return Err(Unfound::Scatter(scatter));
    }
    // A square looks the same after a quarter: the angles are differences from the first.
    let off = |m: &Found| {
        let by = m.angle - first.angle;
        by - 90.0 * libm::round(by / 90.0)
    };
    let angle = first.angle + marks.iter().map(off).sum::<f64>() / n;
    let angle = angle - 90.0 * libm::round(angle / 90.0);
    let uncertainty = first.uncertainty / libm::sqrt(n);
    let mark = Found { centre, angle, uncertainty, ..*first };
    Ok(Mean { mark, scatter, pictures: marks.len() })
}

impl Search {
    /// Returns a text for messages, such as `circle of 100 pixels`.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{} of {:.0} pixels", self.kind.name(), self.size)
    }
}
