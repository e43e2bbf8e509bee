//! The simulated table: a sheet with figures on a machine, and a camera above it, from an INI file.

use crate::{
    draw::{Figure, Sheet, View},
    picture::Picture,
    search::MarkKind,
};
use core::fmt;
use hal_align::{Matrix, Parts, Transform, Vector};
use hal_ini::{Entry, Ini};
use std::path::Path;

/// Largest number of figures.
const MAX_FIGURES: usize = 1000;
/// Largest side of the picture.
const MAX_SIDE: f64 = 2000.0;

/// Simulated table with its camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    sheet: Sheet,
    /// Picture of the camera at the machine's origin.
    view: View,
    /// Place of the sheet.
    part: Parts,
    /// From the machine's position to the place in the middle of the picture.
    offset: Vector,
}

/// Problem of the file of a table, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct TableProblem(String);

impl fmt::Display for TableProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Table {
    /// Reads the section `[TABLE]` of a file.
    ///
    /// # Errors
    /// The file cannot be read, or an entry is wrong.
    pub fn read(path: &Path) -> Result<Self, TableProblem> {
        Self::of(&Ini::read(path).map_err(|e| TableProblem(e.to_string()))?)
    }

    /// Parses a text; `name` is that of its file.
    ///
    /// # Errors
    /// An entry is wrong.
    pub fn parse(name: &str, text: &[u8]) -> Result<Self, TableProblem> {
        Self::of(&Ini::parse(name, text).map_err(|e| TableProblem(e.to_string()))?)
    }

    fn of(ini: &Ini) -> Result<Self, TableProblem> {
        let linear = Matrix::new(0.02, 0.0, 0.0, -0.02);
        let mut out = Self {
            sheet: Sheet { background: 220.0, ink: 40.0, figures: Vec::new() },
            view: View::new(640, 480, linear, Vector::ZERO),
            part: Transform::IDENTITY.parts(),
            offset: Vector::ZERO,
        };
        for entry in ini.section("TABLE") {
            out.entry(entry)?;
        }
        Ok(out)
    }

    fn entry(&mut self, entry: &Entry) -> Result<(), TableProblem> {
        let range = |n: f64, low: f64, high: f64| {
            if low <= n && n <= high {
                Ok(n)
            } else {
                Err(wrong(entry, &format!("{n} is not between {low} and {high}")))
            }
        };
        match entry.name.as_str() {
            "BACKGROUND" => self.sheet.background = range(one(entry)?, 0.0, 255.0)?,
            "INK" => self.sheet.ink = range(one(entry)?, 0.0, 255.0)?,
            "NOISE" => self.view.noise = range(one(entry)?, 0.0, 100.0)?,
            "BLUR" => self.view.blur = range(one(entry)?, 0.0, 4.0)?,
            "LIGHT" => {
                let [x, y] = numbers(entry)?;
                self.view.light = Vector::new(range(x, -1.0, 1.0)?, range(y, -1.0, 1.0)?);
            }
            "PICTURE" => {
                let [width, height] = numbers(entry)?;
                let side = |n: f64| -> Result<usize, TableProblem> {
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "the range is checked"
                    )]
                    Ok(range(n, 16.0, MAX_SIDE)? as usize)
                };
                self.view.size = (side(width)?, side(height)?);
            }
            "CAMERA" => {
                let [m11, m12, m21, m22] = numbers(entry)?;
                self.view.linear = Matrix::new(m11, m12, m21, m22);
                if self.view.linear.inverse().is_none() {
                    return Err(wrong(entry, "the matrix has no inverse"));
                }
            }
            "OFFSET" => {
                let [x, y] = numbers(entry)?;
                self.offset = Vector::new(x, y);
            }
            "PART" => {
                let [turn, scale_x, scale_y, shear, x, y] = numbers(entry)?;
                let shift = Vector::new(x, y);
                self.part = Parts { turn, scale_x, scale_y, shear, shift };
                if Transform::from_parts(&self.part).inverse().is_none() {
                    return Err(wrong(entry, "the part has a scale of 0"));
                }
            }
            "MARK" | "BAR" => {
                if self.sheet.figures.len() >= MAX_FIGURES {
                    return Err(wrong(entry, "more than 1000 figures"));
                }
                self.sheet.figures.push(figure(entry)?);
            }
            other => {
                return Err(wrong(
                    entry,
                    &format!(
                        "[TABLE]{other} has no meaning: BACKGROUND, INK, NOISE, BLUR, LIGHT, PICTURE, CAMERA, OFFSET, PART, MARK, BAR"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Returns the true place of the sheet on the machine.
    #[must_use]
    pub fn part(&self) -> Transform {
        Transform::from_parts(&self.part)
    }

    /// Draws the picture that the camera takes at a position of the machine. `shift` moves the sheet, `light` scales
    /// its brightness, and `number` distinguishes the noise of pictures.
    #[must_use]
    pub fn picture(&self, position: Vector, shift: Vector, light: f64, number: u64) -> Picture {
        let mut part = self.part();
        part.shift = part.shift + shift;
        let view = View { at: position + self.offset, part, seed: number, ..self.view.clone() };
        let light = if (0.0..=2.0).contains(&light) { light } else { 0.0 };
        let mut sheet = self.sheet.clone();
        sheet.background *= light;
        sheet.ink *= light;
        let black = || Picture::new(self.view.size.0, self.view.size.1, Vec::new());
        view.draw(&sheet).unwrap_or_else(black)
    }
}

/// Reads a figure: `MARK = KIND X Y SIZE [OUTLINE [ANGLE]]`, `BAR = X Y LENGTH WIDTH ANGLE`.
fn figure(entry: &Entry) -> Result<Figure, TableProblem> {
    if entry.name == "BAR" {
        let [x, y, length, width, angle] = numbers(entry)?;
        return Ok(Figure::Bar {
            centre: Vector::new(x, y),
            size: Vector::new(length, width),
            angle,
        });
    }
    let (name, rest) = entry.value.split_once(char::is_whitespace).unwrap_or((&entry.value, ""));
    let kind = MarkKind::of(name)
        .ok_or_else(|| wrong(entry, &format!("'{name}' is neither circle nor square")))?;
    let numbers: Vec<f64> = rest.split_whitespace().filter_map(number).collect();
    let words = rest.split_whitespace().count();
    let (x, y, size, outline, angle) = match numbers.as_slice() {
        [x, y, size] if words == 3 => (*x, *y, *size, 0.0, 0.0),
        [x, y, size, outline] if words == 4 => (*x, *y, *size, *outline, 0.0),
        [x, y, size, outline, angle] if words == 5 => (*x, *y, *size, *outline, *angle),
        _ => return Err(wrong(entry, "a mark is KIND X Y SIZE [OUTLINE [ANGLE]]")),
    };
    let outline = (outline > 0.0).then_some(outline);
    Ok(Figure::Mark { kind, centre: Vector::new(x, y), size, angle, outline })
}

fn wrong(entry: &Entry, text: &str) -> TableProblem {
    TableProblem(format!("{}:{}: {}: {text}", entry.file, entry.line, entry.name))
}

fn number(word: &str) -> Option<f64> {
    word.parse::<f64>().ok().filter(|n| libm::fabs(*n) < 1e7)
}

fn one(entry: &Entry) -> Result<f64, TableProblem> {
    let [n] = numbers(entry)?;
    Ok(n)
}

/// Reads numbers separated by blanks.
fn numbers<const N: usize>(entry: &Entry) -> Result<[f64; N], TableProblem> {
    let text = || wrong(entry, &format!("{N} numbers are needed, not '{}'", entry.value));
    let mut out = [0.0; N];
    let mut words = entry.value.split_whitespace();
    for to in &mut out {
        *to = words.next().and_then(number).ok_or_else(text)?;
    }
    if words.next().is_some() { Err(text()) } else { Ok(out) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_entries_are_refused_with_their_place() {
        for (text, wanted) in [
            ("INK = 300", "table.conf:2: INK: 300 is not between 0 and 255"),
            ("INK = nan", "table.conf:2: INK: 1 numbers are needed, not 'nan'"),
            ("PICTURE = 9 100", "table.conf:2: PICTURE: 9 is not between 16 and 2000"),
            ("CAMERA = 1 2 2 4", "table.conf:2: CAMERA: the matrix has no inverse"),
            ("PART = 0 0 1 0 0 0", "table.conf:2: PART: the part has a scale of 0"),
            ("MARK = star 1 2 3", "table.conf:2: MARK: 'star' is neither circle nor square"),
            ("MARK = circle 1 2", "table.conf:2: MARK: a mark is KIND X Y SIZE [OUTLINE [ANGLE]]"),
            ("BAR = 1 2 3", "table.conf:2: BAR: 5 numbers are needed, not '1 2 3'"),
        ] {
            let error = Table::parse("table.conf", format!("[TABLE]\n{text}\n").as_bytes());
            assert_eq!(error.unwrap_err().to_string(), wanted);
        }
        let error = Table::parse("t.ini", b"[TABLE]\nCOLOUR = 1\n").unwrap_err().to_string();
        assert!(error.starts_with("t.ini:2: COLOUR: [TABLE]COLOUR has no meaning"), "{error}");
    }
}
