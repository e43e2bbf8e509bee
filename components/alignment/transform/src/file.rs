//! Alignments as INI files: marks, or a matrix, with model and tolerance.

use crate::{
    Matrix, Transform, Vector,
    fit::{Conditions, Fit, MAX_MARKS, Mark, Misfit, Model, fit},
};
use core::fmt;
use hal_ini::{Entry, Ini};
use std::path::Path;

/// Alignment: marks with the conditions of their fit, or a transform.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Alignment {
    /// Conditions of the fit.
    pub options: Conditions,
    /// Marks.
    pub marks: Vec<Mark>,
    /// Transform that is given instead of marks.
    pub given: Option<Transform>,
}

/// Problem of a file, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct FileProblem {
    place: String,
    what: Problem,
}

#[derive(Clone, Debug, PartialEq)]
enum Problem {
    Ini(hal_ini::Error),
    Unknown(Box<str>),
    Model(Box<str>),
    Numbers(Box<str>, usize),
    Range(&'static str, &'static str),
    Both,
    Neither,
    Fit(Misfit),
}

impl fmt::Display for FileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = &self.place;
        match &self.what {
            Problem::Ini(error) => write!(f, "{error}"),
            Problem::Unknown(name) => write!(
                f,
                "{place}: [ALIGN]{name} has no meaning: MARK, MATRIX, MODEL, TOLERANCE, MIRROR"
            ),
            Problem::Model(name) => write!(
                f,
                "{place}: MODEL is '{name}', must be auto, shift, rigid, similarity, scale-xy or affine"
            ),
            Problem::Numbers(name, n) => write!(f, "{place}: {name} takes {n} finite numbers"),
            Problem::Range(name, range) => write!(f, "{place}: {name} must be {range}"),
            Problem::Both => {
                write!(f, "{place}: [ALIGN] has a MATRIX, and marks that give another")
            }
            Problem::Neither => write!(
                f,
                "{place}: [ALIGN] has neither MARK (file X Y, machine X Y) nor MATRIX (m11 m12 m21 m22 X Y)"
            ),
            Problem::Fit(misfit) => write!(f, "{place}: {misfit}"),
        }
    }
}

impl Alignment {
    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or an entry is wrong.
    pub fn read(path: &Path) -> Result<Self, FileProblem> {
        let name = path.display().to_string();
        let problem = |e| FileProblem { place: name.clone(), what: Problem::Ini(e) };
        Self::of(&Ini::read(path).map_err(problem)?, &name)
    }

    /// Parses a text; `name` is that of its file.
    ///
    /// # Errors
    /// An entry is wrong.
    pub fn parse(name: &str, text: &[u8]) -> Result<Self, FileProblem> {
        let problem = |e| FileProblem { place: name.to_owned(), what: Problem::Ini(e) };
        Self::of(&Ini::parse(name, text).map_err(problem)?, name)
    }

    fn of(ini: &Ini, name: &str) -> Result<Self, FileProblem> {
        let mut out = Self::default();
        for entry in ini.section("ALIGN") {
            let place = format!("{}:{}", entry.file, entry.line);
            out.entry(entry).map_err(|what| FileProblem { place, what })?;
        }
        let what = match (out.given, out.marks.is_empty()) {
            (Some(_), false) => Problem::Both,
            (None, true) => Problem::Neither,
            _ => return Ok(out),
        };
        Err(FileProblem { place: name.to_owned(), what })
    }

    fn entry(&mut self, entry: &Entry) -> Result<(), Problem> {
        let value = entry.value.as_str();
        match entry.name.as_str() {
            "MODEL" => {
                let model = Model::of(value).ok_or_else(|| Problem::Model(value.into()));
                self.options.model = model?;
            }
            "TOLERANCE" => {
                let [tolerance] = numbers(entry)?;
                if !(1e-6..=100.0).contains(&tolerance) {
                    return Err(Problem::Range("TOLERANCE", "between 0.000001 and 100 mm"));
                }
                self.options.tolerance = tolerance;
            }
            "MIRROR" => match value {
                "0" => self.options.mirror = false,
                "1" => self.options.mirror = true,
                _ => return Err(Problem::Range("MIRROR", "0 or 1")),
            },
            "MARK" => {
                let [x, y, to_x, to_y] = numbers(entry)?;
                let mark = Mark { file: Vector::new(x, y), machine: Vector::new(to_x, to_y) };
                if self.marks.len() >= MAX_MARKS {
                    return Err(Problem::Range("the number of marks", "1000 at most"));
                }
                self.marks.push(mark);
            }
            "MATRIX" => {
                let [m11, m12, m21, m22, x, y] = numbers(entry)?;
                let linear = Matrix::new(m11, m12, m21, m22);
                if linear.inverse().is_none() {
                    return Err(Problem::Range("MATRIX", "one that has an inverse"));
                }
                self.given = Some(Transform { linear, shift: Vector::new(x, y) });
            }
            other => return Err(Problem::Unknown(other.into())),
        }
        Ok(())
    }

    /// Returns the transform, with the fit of the marks if they gave it.
    ///
    /// # Errors
    /// The marks give none.
    pub fn solve(&self, name: &str) -> Result<(Transform, Option<Fit>), FileProblem> {
        if let Some(given) = self.given {
            return Ok((given, None));
        }
        let fit = fit(&self.marks, &self.options)
            .map_err(|e| FileProblem { place: name.to_owned(), what: Problem::Fit(e) })?;
        Ok((fit.transform, Some(fit)))
    }

    /// Returns the text of a file with this alignment.
    #[must_use]
    pub fn text(&self) -> String {
        let Conditions { model, tolerance, mirror } = self.options;
        let mut out =
            String::from("# Marks: X and Y in the file, X and Y on the machine, in mm.\n[ALIGN]\n");
        out.push_str(&format!(
            "MODEL = {}\nTOLERANCE = {tolerance}\nMIRROR = {}\n",
            model.name(),
            u8::from(mirror)
        ));
        for Mark { file, machine } in &self.marks {
            let (x, y, to_x, to_y) = (file.x, file.y, machine.x, machine.y);
            out.push_str(&format!("MARK = {x} {y} {to_x:.6} {to_y:.6}\n"));
        }
        if let Some(Transform { linear: m, shift }) = self.given {
            out.push_str(&format!(
                "MATRIX = {} {} {} {} {} {}\n",
                m.m11, m.m12, m.m21, m.m22, shift.x, shift.y
            ));
        }
        out
    }
}

/// Reads numbers separated by blanks.
fn numbers<const N: usize>(entry: &Entry) -> Result<[f64; N], Problem> {
    let wrong = || Problem::Numbers(entry.name.as_str().into(), N);
    let mut out = [0.0; N];
    let mut words = entry.value.split_whitespace();
    for to in &mut out {
        let number = words.next().and_then(|w| w.parse::<f64>().ok());
        *to = number.filter(|n| libm::fabs(*n) < 1e9).ok_or_else(wrong)?;
    }
    if words.next().is_some() { Err(wrong()) } else { Ok(out) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Alignment, String> {
        Alignment::parse("part.ini", text.as_bytes()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_file_is_read_as_it_was_written() {
        let text = "[ALIGN]\nMODEL = affine\nTOLERANCE = 0.05\nMIRROR = 1\nMARK = 0 0 1 2\nMARK = 9 0 3 4\n";
        let read = parse(text).unwrap();
        assert_eq!((read.options.model, read.options.mirror), (Model::Affine, true));
        assert_eq!(parse(&read.text()).unwrap(), read);
        let matrix = parse("[ALIGN]\nMATRIX = 1 0.1 -0.2 1.5 3 4\n").unwrap();
        assert_eq!(parse(&matrix.text()).unwrap(), matrix);
        assert_eq!(matrix.solve("part.ini").unwrap().0.shift, Vector::new(3.0, 4.0));
    }

    #[test]
    fn wrong_entries_are_refused_with_their_place() {
        for (text, wanted) in [
            ("MARK = 1 2 3", "part.ini:2: MARK takes 4 finite numbers"),
            ("MARK = 1 2 3 nan", "part.ini:2: MARK takes 4 finite numbers"),
            ("MATRIX = 1 2 2 4 0 0", "part.ini:2: MATRIX must be one that has an inverse"),
            (
                "MARK = 1 2 3 4\nMATRIX = 1 0 0 1 0 0",
                "part.ini: [ALIGN] has a MATRIX, and marks that give another",
            ),
            (
                "MODEL = bent",
                "part.ini:2: MODEL is 'bent', must be auto, shift, rigid, similarity, scale-xy or affine",
            ),
            ("TOLERANCE = 0", "part.ini:2: TOLERANCE must be between 0.000001 and 100 mm"),
            ("MIRROR = yes", "part.ini:2: MIRROR must be 0 or 1"),
            (
                "MRK = 1",
                "part.ini:2: [ALIGN]MRK has no meaning: MARK, MATRIX, MODEL, TOLERANCE, MIRROR",
            ),
            (
                "",
                "part.ini: [ALIGN] has neither MARK (file X Y, machine X Y) nor MATRIX (m11 m12 m21 m22 X Y)",
            ),
        ] {
            assert_eq!(parse(&format!("[ALIGN]\n{text}\n")).unwrap_err(), wanted);
        }
        let two = parse("[ALIGN]\nMODEL = affine\nMARK = 0 0 0 0\nMARK = 9 0 9 0\n").unwrap();
        let error = two.solve("part.ini").unwrap_err().to_string();
        assert_eq!(error, "part.ini: 2 marks: the model affine needs between 3 and 1000");
    }
}
