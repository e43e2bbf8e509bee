//! Geometry of a cutter-location file: the path of a robot arm along it, with the joints that are chosen.

use super::{Geometry, Point};
use halcmd::programs::halgcode::apt;
use serde::Serialize;
use std::path::Path;

/// Millimetres in an inch.
const INCH: f64 = 25.4;
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
    pub(crate) fn read(cell: Option<&Path>, file: &Path, is_inch: bool) -> Result<Self, String> {
        let cell = cell.ok_or(
            "a cutter-location file is shown in the cell of its arm: halpanel --cell FILE",
        )?;
        let found = apt::path(cell, file)?;
        let unit = if is_inch { 1.0 / INCH } else { 1.0 };
        let placed = |[x, y, z, a, b, c]: [f64; 6]| [x * unit, y * unit, z * unit, a, b, c];
        // The arm turns the tool, and the file says how: A B C move.
        let mut geometry = Geometry { others: 0b111, whole: true, ..Geometry::default() };
        let mut last: Option<[f64; 3]> = None;
        for step in &found.steps {
            let [x, y, z, a, b, c] = placed(step.tip);
            let at = [x, y, z];
            let from = last.replace(at);
            let long = from.map_or(0.0, |from| {
                at.iter().zip(from).map(|(to, from)| (to - from).powi(2)).sum::<f64>().sqrt()
            });
            let is_cut = !step.is_rapid && long > 0.0 && step.seconds > 0.0;
            #[expect(clippy::cast_possible_truncation, reason = "a picture")]
            let feed = if is_cut { (60.0 * long / step.seconds) as f32 } else { 0.0 };
            let kind = match (from, is_cut) {
                (None, _) => 0,
                (Some(_), false) => 1,
                (Some(_), true) => 2,
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
