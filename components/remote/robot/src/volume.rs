//! Places that the tool may go to.

use crate::line::number;
use hal_arm::{
    Arm, CONFIGURATIONS, Frame, Joints,
    rotation::{Vector, from_zyz},
};
use std::fmt;

/// Part zero in robot coordinates.
pub type Zero = [f64; 3];

/// Reads a part zero: three numbers separated by commas.
///
/// # Errors
/// The text says something else; the error names the first word that is not a number.
pub fn parse_zero(text: &str) -> Result<Zero, String> {
    let mut numbers = Vec::new();
    for word in text.split(',') {
        numbers.push(number(word).ok_or_else(|| format!("'{}' is not a number", word.trim()))?);
    }
    <Zero>::try_from(numbers).map_err(|_| "three numbers are needed, such as -400,0,-30".to_owned())
}

/// Reads a work volume: the least X, Y and Z, then the greatest, separated by commas.
///
/// # Errors
/// The text says something else, or a least coordinate is above the greatest.
pub fn parse_volume(text: &str) -> Result<([f64; 3], [f64; 3]), String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    let needed = "six numbers are needed, such as -550,-250,-100,-250,250,40";
    let ends = numbers.and_then(|n| <[f64; 6]>::try_from(n).ok()).ok_or(needed)?;
    let [x0, y0, z0, x1, y1, z1] = ends;
    if x0 > x1 || y0 > y1 || z0 > z1 {
        return Err("a least coordinate is above the greatest".to_owned());
    }
    Ok(([x0, y0, z0], [x1, y1, z1]))
}

/// Box of the work, in robot coordinates, and the arm that must reach every point with its tool downwards.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Volume {
    /// Least X, Y and Z; inclusive.
    pub min: [f64; 3],
    /// Greatest X, Y and Z; inclusive.
    pub max: [f64; 3],
    /// Arm.
    pub arm: Arm,
    /// Length of the tool beyond the flange.
    pub tool: f64,
}

/// Point that the tool must not go to.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Outside {
    /// A coordinate is outside the box.
    Box {
        /// Letter of the axis.
        axis: char,
        /// Coordinate.
        at: f64,
        /// Limit that it is beyond.
        limit: f64,
    },
    /// No configuration of the arm reaches the point.
    Arm,
}

impl fmt::Display for Outside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box { axis, at, limit } => {
                let sign = if at > limit { '>' } else { '<' };
                write!(f, "outside the work volume: robot {axis} {at:.3} {sign} {limit}")
            }
            Self::Arm => f.write_str("the joints of the arm do not reach it"),
        }
    }
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            min: [-550.0, -250.0, -100.0],
            max: [-250.0, 250.0, 40.0],
            arm: Arm::RS03N,
            tool: 0.0,
        }
    }
}

impl Volume {
    /// Returns a point of the part frame in robot coordinates.
    #[must_use]
    pub const fn robot(zero: &Zero, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x0, y0, z0] = *zero;
        [x0 - y, y0 + x, z0 + z]
    }

    /// Checks a point in robot coordinates.
    ///
    /// # Errors
    /// The tool must not go there.
    pub fn check(&self, point: [f64; 3]) -> Result<(), Outside> {
        let limits = self.min.iter().zip(&self.max);
        for ((axis, at), (low, high)) in ['X', 'Y', 'Z'].into_iter().zip(point).zip(limits) {
            // NaN is outside too.
            if !(*low <= at && at <= *high) {
                let limit = if at > *high { *high } else { *low };
                return Err(Outside::Box { axis, at, limit });
            }
        }
        let flange = self.flange(point);
        let reaches = |c| self.arm.solve(&flange, c, &[0.0; 6]).is_ok();
        if (0..CONFIGURATIONS).any(reaches) { Ok(()) } else { Err(Outside::Arm) }
    }

    /// Returns the joints that bring the tool to a point in robot coordinates, those nearest to `last`; `None` if there are
    /// none.
    #[must_use]
    pub fn joints(&self, point: [f64; 3], last: &Joints) -> Option<Joints> {
        let flange = self.flange(point);
        let far = |way: &Joints| {
            let turns = way.iter().zip(last).map(|(a, b)| (a - b).abs());
            turns.fold(0.0, f64::max)
        };
        let ways = (0..CONFIGURATIONS).filter_map(|c| self.arm.solve(&flange, c, last).ok());
        ways.map(|way| way.joints).min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// Returns the flange when the tool points downwards at a point in robot coordinates.
    fn flange(&self, point: [f64; 3]) -> Frame {
        let down = from_zyz([-90.0, 180.0, 0.0]);
        let origin = Vector::from(point) - down * Vector::new(0.0, 0.0, self.tool);
        Frame { origin, turn: down }
    }
}
