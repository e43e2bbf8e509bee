//! Places of nine axes as points in space, for drawings.
//!
//! A geometry is a list of axes. From left to right, each translates or rotates the point that the axes before it have
//! made. `-` reverses the next axis, and `!` rotates about the offset of the coordinate system instead of the machine's origin.
#![expect(clippy::indexing_slicing, reason = "axes and coordinates, below the lengths")]

use crate::connection::locked;
use pyo3::{exceptions::PyTypeError, prelude::*, types::PyTuple};
use std::sync::Mutex;

/// Largest turn of a rotary axis in one straight piece, in degrees.
const PIECE_DEGREES: f64 = 10.0;
/// The most straight pieces of a line.
const MAX_PIECES: f64 = 10_000.0;

/// Offset of the coordinate system, and a flag that is set if rotations are about it.
static OFFSETS: Mutex<(bool, [f64; 3])> = Mutex::new((false, [0.0; 3]));

/// `gui_respect_offsets(COORDINATES, ON)`: rotations are about the offset of the coordinate system.
#[pyfunction]
#[pyo3(signature = (coordinates, on, /))]
pub(crate) fn gui_respect_offsets(coordinates: &str, on: i32) {
    let _: &str = coordinates;
    locked(&OFFSETS).0 = on != 0;
}

/// `gui_rot_offsets(X, Y, Z)`: sets the offset for rotations, in inches.
#[pyfunction]
#[pyo3(signature = (x, y, z, /))]
pub(crate) fn gui_rot_offsets(x: f64, y: f64, z: f64) {
    locked(&OFFSETS).1 = [x, y, z];
}

/// A step from one point to the next.
#[derive(Clone, Copy)]
enum Step {
    /// Adds an axis to a coordinate.
    Translate { axis: usize, to: usize, sign: f64 },
    /// Rotates about a coordinate by an axis.
    Rotate { axis: usize, about: usize, sign: f64 },
}

/// The steps of a geometry.
struct Geometry {
    steps: Vec<Step>,
    center: [f64; 3],
}

impl Geometry {
    fn new(text: &str) -> Self {
        let (respect, offset) = *locked(&OFFSETS);
        let (mut steps, mut sign) = (Vec::new(), 1.0);
        for letter in text.chars() {
            let place = "XYZABCUVW".find(letter.to_ascii_uppercase());
            match place {
                Some(axis @ 3..=5) => steps.push(Step::Rotate { axis, about: axis - 3, sign }),
                Some(axis) => steps.push(Step::Translate { axis, to: axis % 3, sign }),
                None => {}
            }
            sign = if letter == '-' { -1.0 } else { 1.0 };
        }
        Self { steps, center: if respect { offset } else { [0.0; 3] } }
    }

    /// Tells whether any axis rotates.
    fn rotates(&self) -> bool {
        self.steps.iter().any(|s| matches!(s, Step::Rotate { .. }))
    }

    fn point(&self, place: &[f64; 9]) -> [f64; 3] {
        let mut at = [0.0; 3];
        for step in &self.steps {
            match *step {
                Step::Translate { axis, to, sign } => at[to] += sign * place[axis],
                Step::Rotate { axis, about, sign } => {
                    let (sin, cos) = (sign * place[axis]).to_radians().sin_cos();
                    let (p, q) = ((about + 1) % 3, (about + 2) % 3);
                    let (a, b) = (at[p] - self.center[p], at[q] - self.center[q]);
                    at[p] = self.center[p] + a * cos - b * sin;
                    at[q] = self.center[q] + a * sin + b * cos;
                }
            }
        }
        at
    }

    /// Adds the ends of the straight pieces of a line.
    fn line(&self, from: &[f64; 9], to: &[f64; 9], out: &mut Vec<[f64; 3]>) {
        let turn = (3..6).map(|i| (to[i] - from[i]).abs()).fold(0.0, f64::max);
        let pieces = (turn / PIECE_DEGREES).ceil().min(MAX_PIECES);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 10000")]
        let pieces = if self.rotates() { (pieces as u32).max(1) } else { 1 };
        let mut last = self.point(from);
        for i in 1..=pieces {
            let share = f64::from(i) / f64::from(pieces);
            let at = std::array::from_fn(|n| from[n] + share * (to[n] - from[n]));
            let next = self.point(&at);
            out.extend([last, next]);
            last = next;
        }
    }
}

/// `vertex9(GEOMETRY, PLACE)`: returns the point of a place of nine axes.
#[pyfunction]
#[pyo3(signature = (geometry, place, /))]
pub(crate) fn vertex9(geometry: &str, place: [f64; 9]) -> (f64, f64, f64) {
    let [x, y, z] = Geometry::new(geometry).point(&place);
    (x, y, z)
}

/// Returns the straight pieces of a line between two places: two points for each.
#[pyfunction]
#[pyo3(signature = (geometry, from, to, /))]
pub(crate) fn pieces(geometry: &str, from: [f64; 9], to: [f64; 9]) -> Vec<[f64; 3]> {
    let mut out = Vec::new();
    Geometry::new(geometry).line(&from, &to, &mut out);
    out
}

/// Lines in a row with one number: the number, the first point, and the number of points.
type Run = (u32, usize, usize);

/// Returns the straight pieces of all lines (number, from, to, …): the coordinates of their points as 32-bit floats, and the
/// runs of lines with one number.
#[pyfunction]
#[pyo3(signature = (geometry, lines, /))]
pub(crate) fn vertices(geometry: &str, lines: &Bound<'_, PyAny>) -> PyResult<(Vec<u8>, Vec<Run>)> {
    let geometry = Geometry::new(geometry);
    let mut points = Vec::new();
    let mut runs: Vec<Run> = Vec::new();
    for line in lines.try_iter()? {
        let line = line?.cast_into::<PyTuple>()?;
        let number: u32 = line.get_item(0)?.extract()?;
        let first = points.len();
        geometry.line(&nine(&line, 1)?, &nine(&line, 2)?, &mut points);
        let count = points.len() - first;
        match runs.last_mut() {
            Some(run) if run.0 == number => run.2 += count,
            _ => runs.push((number, first, count)),
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "precise enough for a drawing")]
    let bytes = points.iter().flatten().flat_map(|v| (*v as f32).to_ne_bytes()).collect();
    Ok((bytes, runs))
}

fn nine(line: &Bound<'_, PyTuple>, index: usize) -> PyResult<[f64; 9]> {
    let place: Vec<f64> = line.get_item(index)?.extract()?;
    place.try_into().map_err(|_| PyTypeError::new_err("a place has nine coordinates"))
}
