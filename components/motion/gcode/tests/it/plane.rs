//! Plane geometry of the oracles, written apart from that of the crate: distances to lines and arcs, and random numbers.

use std::f64::consts::TAU;

pub(crate) type Point = [f64; 2];

/// A source of numbers that are the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Returns a number from 0 to below 1.
    pub(crate) fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the number is from 0 to below the count"
    )]
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count - 1)
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }
}

/// A line, or an arc about a centre that turns to the left or right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Move {
    pub(crate) from: Point,
    pub(crate) to: Point,
    pub(crate) arc: Option<(Point, bool)>,
}

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn length(a: Point) -> f64 {
    a[0].hypot(a[1])
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Returns the place at a distance in a direction.
pub(crate) fn ahead(from: Point, angle: f64, distance: f64) -> Point {
    [from[0] + distance * angle.cos(), from[1] + distance * angle.sin()]
}

impl Move {
    pub(crate) fn line(from: Point, to: Point) -> Self {
        Self { from, to, arc: None }
    }

    /// Returns the angle of an arc, from 0 to a turn; a whole turn if it ends where it begins.
    pub(crate) fn sweep(&self) -> f64 {
        let Some((centre, left)) = self.arc else { return 0.0 };
        let angle = |p: Point| (p[1] - centre[1]).atan2(p[0] - centre[0]);
        let turn = (angle(self.to) - angle(self.from)).rem_euclid(TAU);
        let turn = if left { turn } else { TAU - turn };
        if length(sub(self.from, self.to)) < 1e-9 { TAU } else { turn }
    }

    /// Returns the place at a share of the way.
    pub(crate) fn at(&self, share: f64) -> Point {
        let Some((centre, left)) = self.arc else {
            let way = sub(self.to, self.from);
            return [self.from[0] + share * way[0], self.from[1] + share * way[1]];
        };
        let out = sub(self.from, centre);
        let turn = self.sweep() * share * if left { 1.0 } else { -1.0 };
        // The radius goes evenly from that of the begin to that of the end.
        let (r0, r1) = (length(out), length(sub(self.to, centre)));
        ahead(centre, out[1].atan2(out[0]) + turn, r0 + share * (r1 - r0))
    }

    /// Returns the unit direction at a share of the way.
    pub(crate) fn direction(&self, share: f64) -> Point {
        let way = match self.arc {
            None => sub(self.to, self.from),
            Some((centre, left)) => {
                let out = sub(self.at(share), centre);
                if left { [-out[1], out[0]] } else { [out[1], -out[0]] }
            }
        };
        let size = length(way);
        [way[0] / size, way[1] / size]
    }

    /// Returns the distance of a place from the nearest one of the way.
    pub(crate) fn distance(&self, at: Point) -> f64 {
        let ends = length(sub(at, self.from)).min(length(sub(at, self.to)));
        match self.arc {
            None => {
                let way = sub(self.to, self.from);
                let square = dot(way, way);
                let share = if square > 0.0 { dot(sub(at, self.from), way) / square } else { 0.0 };
                if (0.0..=1.0).contains(&share) { length(sub(at, self.at(share))) } else { ends }
            }
            Some((centre, left)) => {
                let way = sub(at, centre);
                let angle = |p: Point| (p[1] - centre[1]).atan2(p[0] - centre[0]);
                let turn = (angle(at) - angle(self.from)).rem_euclid(TAU);
                let turn = if left { turn } else { TAU - turn };
                let radius = length(sub(self.from, centre));
                let sweep = self.sweep();
                if turn <= sweep { (length(way) - radius).abs() } else { ends }
            }
        }
    }

    /// Returns the places at which the way crosses the upright line at `along`.
    pub(crate) fn levels(&self, along: f64) -> Vec<f64> {
        let between = |a: f64, b: f64| a.min(b) <= along && along <= a.max(b);
        match self.arc {
            None if self.from[0] == self.to[0] || !between(self.from[0], self.to[0]) => Vec::new(),
            None => {
                let share = (along - self.from[0]) / (self.to[0] - self.from[0]);
                vec![self.at(share)[1]]
            }
            Some((centre, left)) => {
                let radius = length(sub(self.from, centre));
                let square = radius * radius - (along - centre[0]).powi(2);
                if square < 0.0 {
                    return Vec::new();
                }
                let angle = |p: Point| (p[1] - centre[1]).atan2(p[0] - centre[0]);
                let holds = |level: &f64| {
                    let turn = (angle([along, *level]) - angle(self.from)).rem_euclid(TAU);
                    (if left { turn } else { TAU - turn }) <= self.sweep()
                };
                let half = square.sqrt();
                [centre[1] - half, centre[1] + half].into_iter().filter(holds).collect()
            }
        }
    }
}
