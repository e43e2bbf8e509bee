//! Search: the marks of a picture, and why other regions are none.

use crate::{
    measure::{FoundMark, Measures, measure},
    picture::Picture,
    region::{Limits, Region, regions},
    threshold::dark,
};
use core::{f64::consts::PI, fmt};
use hal_align::Vector;

/// Kinds of marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// Disc or ring.
    Circle,
    /// Square, filled or outline.
    Square,
}

impl MarkKind {
    /// Returns the kind of a name.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        match name {
            "circle" => Some(Self::Circle),
            "square" => Some(Self::Square),
            _ => None,
        }
    }

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Circle => "circle",
            Self::Square => "square",
        }
    }

    /// Returns the diameter or side of a mark of this area.
    #[must_use]
    pub fn side(self, area: f64) -> f64 {
        match self {
            Self::Circle => libm::sqrt(area * core::f64::consts::FRAC_1_PI) * 2.0,
            Self::Square => libm::sqrt(area),
        }
    }
}

/// Brightness of marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ink {
    /// Darker than their background.
    #[default]
    Dark,
    /// Brighter than their background.
    Bright,
}

/// Description of the marks to search for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Kind of the marks.
    pub kind: MarkKind,
    /// Diameter, or side, in pixels.
    pub size: f64,
    /// Brightness.
    pub ink: Ink,
}

/// Reason why a region is no mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rejected {
    /// A region that touches the border of the picture.
    Border,
    /// An area in square pixels, and the expected one.
    Area(f64, f64),
    /// A length in pixels, and the largest one of a mark.
    Side(f64, f64),
    /// A region that differs too little from the background.
    Faint,
    /// A shape: roundness, elongation, squareness.
    Shape(f64, f64, f64),
    /// A mark of the other kind.
    Kind,
}

impl fmt::Display for Rejected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Border => f.write_str("it touches the border of the picture"),
            Self::Area(got, wanted) => {
                write!(f, "its area is {got:.0} square pixels, and {wanted:.0} are expected")
            }
            Self::Side(got, most) => {
                write!(f, "it is {got:.0} pixels long, and a mark has at most {most:.0}")
            }
            Self::Faint => f.write_str("it differs too little from the background"),
            Self::Shape(r, e, s) => write!(
                f,
                "its shape is neither a circle nor a square (roundness {r:.2}, elongation {e:.2}, squareness {s:.2})"
            ),
            Self::Kind => f.write_str("it is a mark of the other kind"),
        }
    }
}

/// Result of a search.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Marks.
    pub marks: Vec<FoundMark>,
    /// Places of regions that are none, in pixels, with the reason.
    pub rejected: Vec<(Vector, Rejected)>,
}

/// Largest deviation of the area, as a part of the expected one.
const AREA: f64 = 0.3;
/// Largest area before the exact one is known, as a part of the expected one.
const ROUGH_MOST: f64 = (1.0 + AREA) * 1.4;
/// Slack of the longest side in pixels: blur and threshold may add this length to a mark of any size.
const SIDE_SLACK: usize = 16;
/// Least roundness.
const ROUND: f64 = 0.85;
/// Largest elongation.
const ELONGATED: f64 = 1.2;
/// Largest squareness of a circle.
const CIRCLE: f64 = 0.2;
/// Least squareness of a square.
const SQUARE: f64 = 0.7;

/// Searches a picture for marks.
#[must_use]
pub fn search(picture: &Picture, wanted: &Search) -> Seen {
    let (width, height) = (picture.width(), picture.height());
    let mut seen = Seen::default();
    if width < 8 || height < 8 || !wanted.size.is_finite() {
        return seen;
    }
    let value = |b: &u8| match wanted.ink {
        Ink::Dark => f32::from(*b),
        Ink::Bright => f32::from(255 - *b),
    };
    let values: Vec<f32> = picture.pixels().iter().map(value).collect();
    let dark = dark(&values, width, height);
    let expected = expected(wanted);
    let whole = |n: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of pixels"
        )]
        let whole = n as usize;
        whole
    };
    let limits = Limits {
        pixels: whole(expected * ROUGH_MOST),
        side: whole(2.0 * wanted.size).saturating_add(SIDE_SLACK),
    };
    regions(&dark, width, height, limits, |region| match region {
        Ok(region) => match judge(picture, region, wanted) {
            Ok(mark) => seen.marks.push(mark),
            Err(reason) => seen.rejected.push((region.middle(), reason)),
        },
        Err(large) => {
            let reason = if large.pixels > limits.pixels {
                Rejected::Area(large.pixels as f64, expected)
            } else {
                Rejected::Side(large.side as f64, limits.side as f64)
            };
            seen.rejected.push((large.middle, reason));
        }
    });
    seen
}

/// Returns the area of the wanted marks in square pixels.
fn expected(wanted: &Search) -> f64 {
    match wanted.kind {
        MarkKind::Circle => PI / 4.0 * wanted.size * wanted.size,
        MarkKind::Square => wanted.size * wanted.size,
    }
}

/// Judges a region.
fn judge(picture: &Picture, region: &Region, wanted: &Search) -> Result<FoundMark, Rejected> {
    let expected = expected(wanted);
    let fits = |area: f64| (1.0 - AREA) * expected <= area && area <= (1.0 + AREA) * expected;
    let rough = region.area() as f64;
    // The threshold lies anywhere in a blurred edge: the exact area follows.
    if rough < expected * (1.0 - AREA) * 0.7 || expected * ROUGH_MOST < rough {
        return Err(Rejected::Area(rough, expected));
    }
    if region.at_border {
        return Err(Rejected::Border);
    }
    let m = measure(picture, region).ok_or(Rejected::Faint)?;
    if !fits(m.area) {
        return Err(Rejected::Area(m.area, expected));
    }
    let Measures { roundness, elongation, squareness, .. } = m;
    let shape = Rejected::Shape(roundness, elongation, squareness);
    // Not a number fails each of these.
    if !(ROUND < roundness && elongation < ELONGATED) {
        return Err(shape);
    }
    let kind = if squareness < CIRCLE {
        MarkKind::Circle
    } else if SQUARE < squareness && squareness < 1.3 {
        MarkKind::Square
    } else {
        return Err(shape);
    };
    if kind != wanted.kind {
        return Err(Rejected::Kind);
    }
    let angle = if kind == MarkKind::Square { m.angle } else { 0.0 };
    let Measures { centre, area, uncertainty, contrast, .. } = m;
    Ok(FoundMark { kind, centre, angle, area, uncertainty, contrast })
}

#[cfg(test)]
mod tests {
    //! The page of the crate.

    #[test]
    fn the_page_has_the_bounds_of_the_search() {
        let page = include_str!("../README.md");
        let side = format!("twice the mark's size plus {} pixels", super::SIDE_SLACK);
        let area = format!("more than {:.0} % from the expected one", 100.0 * super::AREA);
        for text in [side, area] {
            assert!(page.contains(&text), "{text}");
        }
    }
}
