//! The job: marks, model, camera and source of pictures, from an INI file.

use crate::eye::Station;
use hal_align::{Conditions, MAX_MARKS, Matrix, Model, Vector};
use hal_ini::{Entry, Ini, beside};
use hal_marks::{Camera, Files, Ink, MarkKind, Picture, Search, Source, Table};
use std::path::{Path, PathBuf};

/// Largest number of pictures of a look.
const MAX_FRAMES: f64 = 100.0;

/// Problem of a job whose pictures have no origin.
pub(crate) const NO_CAMERA: &str = "the job has no camera: [CAMERA]SOURCE";

/// Origin of pictures.
pub(crate) enum Pictures {
    None,
    Table(Box<Table>),
    Files(Box<dyn Source>),
}

/// Returns the picture of a simulated table from this station, with the noise of a seed; `None` if the camera stalls.
pub(crate) fn draw(table: &Table, station: &Station, seed: u64) -> Option<Picture> {
    let Station { light, part_x, part_y, stalls, .. } = *station;
    (!stalls).then(|| table.picture(station.at(), Vector::new(part_x, part_y), light, seed))
}

/// Job with its camera.
pub(crate) struct MarkJob {
    /// Marks in the file's coordinates.
    pub(crate) marks: Vec<Vector>,
    /// Expected place of each mark on the machine.
    pub(crate) expected: Vec<Option<Vector>>,
    pub(crate) options: Conditions,
    pub(crate) kind: MarkKind,
    /// Diameter or side of the marks, in mm.
    pub(crate) size: f64,
    pub(crate) ink: Ink,
    /// Pictures of a look.
    pub(crate) frames: usize,
    /// Expected place of the file's origin.
    pub(crate) near: Vector,
    pub(crate) camera: Camera,
    /// Longest wait for a picture, in seconds.
    pub(crate) timeout: f64,
    /// Longest time from the light to the file of a live picture, in seconds.
    pub(crate) delay: f64,
    pub(crate) pictures: Pictures,
    /// Kind of their origin: none, sim or files.
    pub(crate) source: &'static str,
}

impl Default for MarkJob {
    fn default() -> Self {
        let linear = Matrix::new(0.02, 0.0, 0.0, -0.02);
        Self {
            marks: Vec::new(),
            expected: Vec::new(),
            options: Conditions::default(),
            kind: MarkKind::Circle,
            size: 2.0,
            ink: Ink::Dark,
            frames: 5,
            near: Vector::ZERO,
            camera: Camera { linear, offset: Vector::ZERO },
            timeout: 5.0,
            delay: 1.0,
            pictures: Pictures::None,
            source: "none",
        }
    }
}

impl MarkJob {
    /// Reads a file, and opens the source of pictures. An error is `file:line: text`.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let ini = Ini::read(path).map_err(|e| e.to_string())?;
        let mut out = Self::default();
        for entry in ini.section("JOB") {
            out.job(entry)?;
        }
        for entry in ini.section("CAMERA") {
            out.camera(entry, path.parent().unwrap_or(Path::new("")))?;
        }
        if out.marks.is_empty() {
            return Err(format!("{}: [JOB] has no MARK = X Y", path.display()));
        }
        Ok(out)
    }

    /// Returns what to search for in pictures.
    pub(crate) fn wanted(&self) -> Search {
        Search { kind: self.kind, size: self.camera.pixels(self.size), ink: self.ink }
    }

    fn job(&mut self, entry: &Entry) -> Result<(), String> {
        let value = entry.value.as_str();
        match entry.name.as_str() {
            "MARK" if self.marks.len() >= MAX_MARKS => {
                return Err(wrong(entry, "at most 1000 marks"));
            }
            "MARK" if value.split_whitespace().count() == 4 => {
                let [x, y, to_x, to_y] = numbers(entry)?;
                self.marks.push(Vector::new(x, y));
                self.expected.push(Some(Vector::new(to_x, to_y)));
            }
            "MARK" => {
                self.marks.push(vector(entry)?);
                self.expected.push(None);
            }
            "NEAR" => self.near = vector(entry)?,
            "MODEL" => {
                let names = "must be auto, shift, rigid, similarity, scale-xy or affine";
                self.options.model = Model::of(value).ok_or_else(|| wrong(entry, names))?;
            }
            "TOLERANCE" => self.options.tolerance = between(entry, 1e-6, 100.0)?,
            "MIRROR" => {
                self.options.mirror = match value {
                    "0" => false,
                    "1" => true,
                    _ => return Err(wrong(entry, "must be 0 or 1")),
                }
            }
            "KIND" => {
                self.kind =
                    MarkKind::of(value).ok_or_else(|| wrong(entry, "must be circle or square"))?;
            }
            "SIZE" => self.size = between(entry, 1.0, 10.0)?,
            "INK" => {
                self.ink = match value {
                    "dark" => Ink::Dark,
                    "bright" => Ink::Bright,
                    _ => return Err(wrong(entry, "must be dark or bright")),
                }
            }
            "FRAMES" => {
                let frames = between(entry, 1.0, MAX_FRAMES)?;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "the range is checked"
                )]
                let frames = frames as usize;
                self.frames = frames;
            }
            _ => {
                return Err(wrong(
                    entry,
                    "has no meaning: MARK, NEAR, MODEL, TOLERANCE, MIRROR, KIND, SIZE, INK, FRAMES",
                ));
            }
        }
        Ok(())
    }

    fn camera(&mut self, entry: &Entry, folder: &Path) -> Result<(), String> {
        match entry.name.as_str() {
            "MATRIX" => {
                let [m11, m12, m21, m22] = numbers(entry)?;
                let linear = Matrix::new(m11, m12, m21, m22);
                if linear.inverse().is_none() {
                    return Err(wrong(entry, "the matrix has no inverse"));
                }
                self.camera.linear = linear;
            }
            "OFFSET" => self.camera.offset = vector(entry)?,
            "TIMEOUT" => self.timeout = between(entry, 0.01, 600.0)?,
            "DELAY" => self.delay = between(entry, 0.0, 60.0)?,
            "SOURCE" => {
                let forms = "must be 'sim FILE', 'files FOLDER' or 'live FOLDER'";
                let (kind, name) = entry
                    .value
                    .split_once(char::is_whitespace)
                    .ok_or_else(|| wrong(entry, forms))?;
                let path: PathBuf = beside(folder, name);
                let files = |is_live| -> Result<Pictures, String> {
                    let files = Files::open(&path, is_live);
                    let files = files.map_err(|e| wrong(entry, &e.to_string()))?;
                    Ok(Pictures::Files(Box::new(files)))
                };
                self.source = if kind == "sim" { "sim" } else { "files" };
                self.pictures = match kind {
                    "sim" => {
                        let table = Table::read(&path).map_err(|e| e.to_string())?;
                        Pictures::Table(Box::new(table))
                    }
                    "files" => files(false)?,
                    "live" => files(true)?,
                    _ => return Err(wrong(entry, forms)),
                };
            }
            _ => {
                return Err(wrong(entry, "has no meaning: SOURCE, MATRIX, OFFSET, TIMEOUT, DELAY"));
            }
        }
        Ok(())
    }
}

fn wrong(entry: &Entry, text: &str) -> String {
    let Entry { section, name, value, file, line } = entry;
    format!("{file}:{line}: [{section}]{name} = {value}: {text}")
}

fn between(entry: &Entry, low: f64, high: f64) -> Result<f64, String> {
    let [n] = numbers(entry)?;
    if low <= n && n <= high {
        return Ok(n);
    }
    Err(wrong(entry, &format!("must be between {low} and {high}")))
}

fn vector(entry: &Entry) -> Result<Vector, String> {
    let [x, y] = numbers(entry)?;
    Ok(Vector::new(x, y))
}

/// Reads numbers separated by blanks.
fn numbers<const N: usize>(entry: &Entry) -> Result<[f64; N], String> {
    let text = || wrong(entry, &format!("{N} finite numbers are needed"));
    let mut out = [0.0; N];
    let mut words = entry.value.split_whitespace();
    for to in &mut out {
        let number = words.next().and_then(|w| w.parse::<f64>().ok());
        *to = number.filter(|n| libm::fabs(*n) < 1e7).ok_or_else(text)?;
    }
    if words.next().is_some() { Err(text()) } else { Ok(out) }
}
