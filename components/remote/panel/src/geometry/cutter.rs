//! Geometry of a cutter-location file: the path of a robot arm along it, with the joints that are chosen.

use super::{Geometry, Point};
use halcmd::programs::halgcode::apt;
use serde::Serialize;
use std::path::Path;

/// Millimetres in an inch.
const INCH: f64 = 25.4;
/// Motion in millimetres that is none: the tip of a tool that only turns is rounded.
const STILL: f64 = 5e-4;
/// Endings of the names of cutter-location files.
const ENDINGS: &[&str] = &["apt", "cl", "cls", "aptsource"];

/// Returns whether a name is that of a cutter-location file.
pub(crate) fn is_cutter(name: &str) -> bool {
    name.rsplit_once('.')
        .is_some_and(|(_, ending)| ENDINGS.iter().any(|known| known.eq_ignore_ascii_case(ending)))
}

/// Path along a cutter-location file.
#[derive(Debug)]
pub(crate) struct Cut {
    pub(crate) geometry: Geometry,
    /// Frame of the part relative to the arm's base: X Y Z in machine units, roll, pitch and yaw in degrees.
    pub(crate) frame: [f64; 6],
    /// Cutters as tools of the path.
    pub(crate) cutters: Vec<Tool>,
}

/// Cutter as a tool of the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Tool {
    number: usize,
    /// Diameter in machine units.
    diameter: f64,
    is_ball: bool,
}

impl Cut {
    /// Reads a file, and plans its path in the cell of an arm.
    ///
    /// # Errors
    /// There is no cell, a file is wrong, or the arm cannot run the path.
    pub(crate) fn read(
        cell: Option<&Path>,
        file: &Path,
        text: &[u8],
        is_inch: bool,
    ) -> Result<Self, String> {
        let cell = cell.ok_or(
            "a cutter-location file is shown in the cell of its arm: halpanel --cell FILE",
        )?;
        let found = apt::path_of(cell, file, text)?;
        let unit = if is_inch { 1.0 / INCH } else { 1.0 };
        let placed = |[x, y, z, a, b, c]: [f64; 6]| [x * unit, y * unit, z * unit, a, b, c];
        // The arm turns the tool, and the file says how: A B C move.
        let mut geometry = Geometry { others: 0b111, whole: true, ..Geometry::default() };
        let (mut last, mut turned): (Option<[f64; 3]>, Option<[f64; 3]>) = (None, None);
        for step in &found.steps {
            let [x, y, z, a, b, c] = placed(step.tip);
            let mut at = [x, y, z];
            if let Some(from) = last.filter(|from| distance(at, *from) < STILL * unit) {
                at = from;
            }
            let from = last.replace(at);
            let long = from.map_or(0.0, |from| distance(at, from));
            let angles = turned.replace([a, b, c]).map_or(0.0, |from| distance([a, b, c], from));
            let is_cut = !step.is_rapid && step.seconds > 0.0;
            // A step that only turns the tool has a feed in degrees, as axes that turn alone have.
            let far = if long > 0.0 { long } else { angles };
            #[expect(clippy::cast_possible_truncation, reason = "a picture")]
            let feed = if is_cut { (60.0 * far / step.seconds) as f32 } else { 0.0 };
            let kind = match (from, step.is_rapid) {
                (None, _) => 0,
                (Some(_), true) => 1,
                (Some(_), false) => 2,
            };
            let offset = geometry.offset([0.0; 3]);
            let further = geometry.further([a, b, c, 0.0, 0.0, 0.0]);
            let (line, tool) = (step.line, step.cutter);
            geometry.keep(Point { at, line, feed, tool, kind, offset, further });
            geometry.joints.push(step.joints);
        }
        let cutters = (1..).zip(&found.cutters).map(|(number, cutter)| Tool {
            number,
            diameter: cutter.diameter * unit,
            is_ball: cutter.is_ball,
        });
        Ok(Self { geometry, frame: placed(found.frame), cutters: cutters.collect() })
    }
}

/// Returns the distance of two points.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
