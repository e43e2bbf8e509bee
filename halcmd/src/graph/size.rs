//! Size of a box, and the positions of its contents.

use super::drawing::{Boxed, Pin};

/// Grid of rows and gaps. It keeps the wires of neighbours from lying on each other.
pub(super) const GRID: i64 = 20;
/// Offsets within a row at which wires leave outputs, reach inputs and pass by. All are different.
pub(super) const OUT: i64 = 7;
pub(super) const IN: i64 = 13;
/// Offsets for passing wires. A wire takes the first one that no neighbour has.
pub(super) const BY: [i64; 3] = [10, 17, 3];

/// Widths of a character in tenths of a pixel: in titles, pin names and small text.
const TITLE: i64 = 84;
const TEXT: i64 = 67;
pub(super) const SMALL: i64 = 61;

/// A box with the positions of its contents.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sized {
    pub(super) boxed: Boxed,
    pub(super) width: i64,
    pub(super) height: i64,
    /// Tops of functions, headings, pins (left and right) and parameters.
    pub(super) functs: Vec<i64>,
    pub(super) headings: Vec<i64>,
    pub(super) left: Vec<Vec<i64>>,
    pub(super) right: Vec<Vec<i64>>,
    pub(super) params: Vec<i64>,
}

impl Sized {
    pub(super) fn new(boxed: Boxed) -> Self {
        let mut s = Self { width: text_width(&boxed.title(), TITLE) + 24, ..Self::default() };
        let headed = boxed.sections.first().is_some_and(|s| !s.name.is_empty());
        let mut y = match (boxed.functs.is_empty(), headed) {
            (true, true) => GRID,
            (true, false) => 2 * GRID,
            _ => 26,
        };
        let mut widen = |width: i64| s.width = s.width.max(width);
        for (name, _) in &boxed.functs {
            widen(text_width(name, SMALL) + 32);
            s.functs.push(y);
            y += 16;
        }
        y = (y + GRID - 1) / GRID * GRID;
        for section in &boxed.sections {
            s.headings.push(y);
            if !section.name.is_empty() {
                widen(text_width(&section.name, SMALL) + 24);
                y += GRID;
            }
            let tops = |pins: &[Pin]| (y..).step_by(20).take(pins.len()).collect::<Vec<i64>>();
            let widest = |pins: &[Pin]| pins.iter().map(|p| text_width(&p.label, TEXT)).max();
            let (left, right) = (widest(&section.left), widest(&section.right));
            widen(left.unwrap_or(0) + right.unwrap_or(0) + 44);
            let rows = section.left.len().max(section.right.len());
            s.left.push(tops(&section.left));
            s.right.push(tops(&section.right));
            y += GRID * i64::try_from(rows).unwrap_or(0);
        }
        for (name, value) in &boxed.params {
            widen(text_width(name, SMALL) + text_width(value, SMALL) + 40);
            s.params.push(y);
            y += GRID;
        }
        s.height = y + GRID / 2;
        s.boxed = boxed;
        s
    }

    /// Returns its pins with their tops, and whether they are on the left.
    pub(super) fn pins(&self) -> impl Iterator<Item = (&Pin, i64, bool)> {
        let sections = self.boxed.sections.iter().zip(self.left.iter().zip(&self.right));
        sections.flat_map(|(section, (left, right))| {
            let left = section.left.iter().zip(left).map(|(pin, top)| (pin, *top, true));
            left.chain(section.right.iter().zip(right).map(|(pin, top)| (pin, *top, false)))
        })
    }
}

/// Returns the width of a text whose characters are `tenths` tenths of a pixel wide.
pub(super) fn text_width(text: &str, tenths: i64) -> i64 {
    // Beyond the scripts of Europe, a character may be two columns wide.
    let width = |c: char| if u32::from(c) < 0x1100 { 1 } else { 2 };
    let characters: i64 = text.chars().map(width).sum();
    (characters * tenths + 9) / 10
}
