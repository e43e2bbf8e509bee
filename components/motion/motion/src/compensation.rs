//! Realtime. Correction of a joint's mechanics: backlash, or the measured errors of its screw.

use crate::commands::config::JointConfig;
use std::sync::{Arc, OnceLock};

/// Maximum number of points of a table.
pub(crate) const MAX_POINTS: usize = 256;

/// Maximum number of different tables during the life of the component.
pub(crate) const MAX_TABLES: usize = 64;

/// Corrections at one position of a joint, in machine units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    pub(crate) position: f64,
    /// Correction while the joint moves in positive direction.
    pub(crate) forward: f64,
    /// Correction while the joint moves in negative direction.
    pub(crate) reverse: f64,
}

/// Measured errors of a screw: points in ascending order of their positions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table(pub(crate) Vec<Point>);

/// All tables so far. The control side adds a table before it sends its place; a table never changes and is freed
/// with the component, so that the realtime side frees nothing.
#[derive(Clone, Debug)]
pub(crate) struct Tables(Arc<[OnceLock<Table>; MAX_TABLES]>);

impl Default for Tables {
    fn default() -> Self {
        Self(Arc::new([const { OnceLock::new() }; MAX_TABLES]))
    }
}

impl Tables {
    /// Returns the place of a table, which is added unless there is an equal one; `None` if there is no room.
    pub(crate) fn place(&self, table: &Table) -> Option<usize> {
        self.0.iter().position(|slot| {
            // A slot that was empty now holds this table.
            slot.get_or_init(|| table.clone()) == table
        })
    }

    fn get(&self, n: usize) -> Option<&Table> {
        self.0.get(n)?.get()
    }

    /// Returns the correction at a position after movement in a direction, positive if `forward`; before any movement,
    /// the mean of both. Screw errors count only once the joint is homed.
    pub(crate) fn correction(
        &self,
        config: &JointConfig,
        position: f64,
        homed: bool,
        forward: Option<bool>,
    ) -> f64 {
        let half = 0.5 * config.backlash;
        let both = match config.table {
            None => (half, -half),
            Some(_) if !homed => (0.0, 0.0),
            Some(n) => self.get(n).map_or((0.0, 0.0), |table| table.at(position)),
        };
        match forward {
            Some(true) => both.0,
            Some(false) => both.1,
            None => 0.5 * (both.0 + both.1),
        }
    }
}

impl Table {
    /// Returns the forward and the reverse correction at a position: linear between points, constant beyond the ends.
    fn at(&self, position: f64) -> (f64, f64) {
        let next = self.0.partition_point(|p| p.position <= position);
        let before = next.checked_sub(1).and_then(|n| self.0.get(n));
        match (before, self.0.get(next)) {
            (Some(a), Some(b)) => {
                let part = (position - a.position) / (b.position - a.position);
                let between = |a: f64, b: f64| a + (b - a) * part;
                (between(a.forward, b.forward), between(a.reverse, b.reverse))
            }
            (Some(p), None) | (None, Some(p)) => (p.forward, p.reverse),
            (None, None) => (0.0, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let point = |position, forward, reverse| Point { position, forward, reverse };
        Table(vec![point(-10.0, 0.1, 0.0), point(0.0, 0.0, -0.2), point(5.0, 0.5, 0.3)])
    }

    #[test]
    fn linear_between_points_and_constant_beyond() {
        for (position, forward, reverse) in [
            (-1e9, 0.1, 0.0),
            (-10.0, 0.1, 0.0),
            (-5.0, 0.05, -0.1),
            (0.0, 0.0, -0.2),
            (2.5, 0.25, 0.05),
            (5.0, 0.5, 0.3),
            (1e9, 0.5, 0.3),
        ] {
            let (a, b) = table().at(position);
            assert!(
                (a - forward).abs() < 1e-12 && (b - reverse).abs() < 1e-12,
                "{position}: {a} {b}"
            );
        }
        assert_eq!(Table(Vec::new()).at(3.0), (0.0, 0.0));
    }

    #[test]
    fn equal_tables_share_a_place_and_room_ends() {
        let tables = Tables::default();
        assert_eq!(tables.place(&table()), Some(0));
        assert_eq!(tables.place(&table()), Some(0));
        for n in 1..MAX_TABLES {
            let other = Table(vec![Point { position: n as f64, forward: 0.0, reverse: 0.0 }]);
            assert_eq!(tables.place(&other), Some(n));
        }
        assert_eq!(tables.place(&Table(Vec::new())), None);
        assert_eq!(tables.place(&table()), Some(0));
    }

    #[test]
    fn direction_and_homing() {
        let tables = Tables::default();
        let backlash = JointConfig { backlash: 0.4, ..JointConfig::default() };
        for (forward, want) in [(Some(true), 0.2), (Some(false), -0.2), (None, 0.0)] {
            assert_eq!(tables.correction(&backlash, 1.0, false, forward), want);
        }
        let screw = JointConfig { table: tables.place(&table()), ..backlash };
        for (homed, forward, want) in [
            (true, Some(true), 0.1),
            (true, Some(false), 0.0),
            (true, None, 0.05),
            (false, Some(true), 0.0),
        ] {
            assert_eq!(tables.correction(&screw, -20.0, homed, forward), want);
        }
    }
}
