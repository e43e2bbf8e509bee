//! Arcs as straight segments.
#![expect(clippy::indexing_slicing, reason = "axes, below nine")]

use pyo3::prelude::*;
use std::f64::consts::TAU;

/// Number of segments of a full turn unless the caller gives one.
const SEGMENTS: u32 = 128;
/// The fewest segments of an arc.
const MIN_SEGMENTS: u32 = 3;
/// The most segments of an arc.
const MAX_SEGMENTS: f64 = 1e6;
/// A place of nine axes, as a tuple of Python.
type AxisPositions = (f64, f64, f64, f64, f64, f64, f64, f64, f64);

const LETTERS: [&str; 9] = ["x", "y", "z", "a", "b", "c", "u", "v", "w"];

fn offsets(canon: &Bound<'_, PyAny>, prefix: &str) -> PyResult<[f64; 9]> {
    let mut out = [0.0; 9];
    for (slot, letter) in out.iter_mut().zip(LETTERS) {
        *slot = canon.getattr(format!("{prefix}_offset_{letter}"))?.extract()?;
    }
    Ok(out)
}

/// Returns the places of the first, second and third axis of a plane among the nine.
const fn axes(plane: i32) -> (usize, usize, usize) {
    match plane {
        2 => (1, 2, 0),
        3 => (2, 0, 1),
        _ => (0, 1, 2),
    }
}

/// Rotates the first two coordinates.
fn rotated(mut at: [f64; 9], cos: f64, sin: f64) -> [f64; 9] {
    let [x, y, ..] = at;
    at[0] = x * cos - y * sin;
    at[1] = x * sin + y * cos;
    at
}

fn sum(a: [f64; 9], b: [f64; 9], sign: f64) -> [f64; 9] {
    std::array::from_fn(|i| a[i] + sign * b[i])
}

/// `arc_to_segments(CANON, X1, Y1, CX, CY, ROT, Z1, A, B, C, U, V, W[, MAX_SEGMENTS])`: returns the ends of straight
/// segments along an arc from `CANON.lo`, in machine coordinates. `MAX_SEGMENTS` is the number in a full turn.
#[pyfunction]
#[pyo3(signature = (canon, x1, y1, cx, cy, rot, z1, a, b, c, u, v, w, max_segments=SEGMENTS, /))]
#[expect(clippy::too_many_arguments, reason = "arguments of the Python function")]
pub(super) fn arc_to_segments(
    canon: &Bound<'_, PyAny>,
    x1: f64,
    y1: f64,
    cx: f64,
    cy: f64,
    rot: i32,
    z1: f64,
    a: f64,
    b: f64,
    c: f64,
    u: f64,
    v: f64,
    w: f64,
    max_segments: u32,
) -> PyResult<Vec<AxisPositions>> {
    let start = canon.getattr("lo")?;
    let start: [f64; 9] = start
        .extract::<Vec<f64>>()?
        .try_into()
        .map_err(|_| pyo3::exceptions::PyTypeError::new_err("lo must have nine coordinates"))?;
    let cos: f64 = canon.getattr("rotation_cos")?.extract()?;
    let sin: f64 = canon.getattr("rotation_sin")?.extract()?;
    let (g5x, g92) = (offsets(canon, "g5x")?, offsets(canon, "g92")?);
    let (first, second, third) = axes(canon.getattr("plane")?.extract()?);
    let from = sum(rotated(sum(start, g5x, -1.0), cos, -sin), g92, -1.0);
    let mut to = [0.0, 0.0, 0.0, a, b, c, u, v, w];
    (to[first], to[second], to[third]) = (x1, y1, z1);
    let begin = (from[second] - cy).atan2(from[first] - cx);
    let end = (y1 - cy).atan2(x1 - cx);
    let sweep = swept(begin, end, rot);
    let radius = (from[first] - cx).hypot(from[second] - cy);
    let steps = (f64::from(max_segments) * sweep.abs() / TAU).floor();
    let steps = steps.min(MAX_SEGMENTS);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1e6")]
    let steps = (steps as u32).max(MIN_SEGMENTS);
    let machine = |at| {
        let [x, y, z, a, b, c, u, v, w] = sum(rotated(sum(at, g92, 1.0), cos, sin), g5x, 1.0);
        (x, y, z, a, b, c, u, v, w)
    };
    let mut out = Vec::with_capacity(steps as usize);
    for i in 1..steps {
        let share = f64::from(i) / f64::from(steps);
        let mut at: [f64; 9] = std::array::from_fn(|n| from[n] + share * (to[n] - from[n]));
        let (sine, cosine) = (begin + share * sweep).sin_cos();
        at[first] = cx + radius * cosine;
        at[second] = cy + radius * sine;
        out.push(machine(at));
    }
    out.push(machine(to));
    Ok(out)
}

/// Returns the angle from `begin` to `end` for a number of turns, negative for clockwise ones.
fn swept(begin: f64, end: f64, turns: i32) -> f64 {
    let clockwise = turns < 0;
    let part =
        if clockwise { (begin - end).rem_euclid(TAU) } else { (end - begin).rem_euclid(TAU) };
    // An arc that ends where it begins is a whole turn.
    let part = if part < 1e-9 || TAU - part < 1e-9 { TAU } else { part };
    let more = f64::from(turns.unsigned_abs().saturating_sub(1)) * TAU;
    if clockwise { -(part + more) } else { part + more }
}
