//! Words and points that wait for the lines behind them: those of canned cycles and of NURBS.

use serde::{Deserialize, Serialize};

use crate::canon::ControlPoint;

/// The sticky words of canned cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cycle {
    /// Ten times the G code of the chain in progress.
    pub active: Option<u16>,
    /// The level along the cycle's axis where the chain began.
    pub initial: f64,
    /// The word of the bottom.
    pub bottom: f64,
    /// R.
    pub r: f64,
    /// P.
    pub p: Option<f64>,
    /// Q.
    pub q: Option<f64>,
    /// I, J and K.
    pub ijk: [f64; 3],
}

impl Cycle {
    /// Scales the lengths after a change of units.
    pub(crate) fn scale(&mut self, k: f64) {
        self.initial *= k;
        self.bottom *= k;
        self.r *= k;
        self.q = self.q.map(|q| q * k);
        self.ijk = self.ijk.map(|v| v * k);
    }
}

/// A NURBS between G5.2 and G5.3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Nurbs {
    /// The order.
    pub order: u32,
    /// The control points.
    pub points: Vec<ControlPoint>,
}
