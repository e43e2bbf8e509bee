//! G5 to G5.3: cubic and quadratic splines, and NURBS.

use crate::{
    canon::{Call, ControlPoint, Plane},
    error::Problem,
    interpret::{Run, block::Block},
    state::Nurbs,
};

/// The most control points of a NURBS.
const MAX_POINTS: usize = 100_000;

fn point(x: f64, y: f64, weight: f64) -> ControlPoint {
    ControlPoint { x, y, weight }
}

impl Run<'_> {
    fn check_spline(&self, b: &Block) -> Result<(), Problem> {
        if self.state.modal.plane != Plane::Xy {
            return Err(Problem::SplinePlane);
        }
        if self.state.compensation.is_on() {
            return Err(Problem::SplineComp);
        }
        if b.has_any(b"zabcuvw") {
            return Err(Problem::SplineAxes);
        }
        self.check_feed(b, "arc")
    }

    pub(super) fn cubic(&mut self, b: &Block) -> Result<(), Problem> {
        self.check_spline(b)?;
        let (Some(p), Some(q)) = (b.get(b'p'), b.get(b'q')) else { return Err(Problem::SplinePq) };
        let from = self.state.position;
        let (i, j) = match (b.get(b'i'), b.get(b'j')) {
            (Some(i), Some(j)) => (i, j),
            // Without I and J, the curve goes on as the last one ended.
            (None, None) => self.state.spline.map_or((0.0, 0.0), |(p, q)| (-p, -q)),
            _ => return Err(Problem::SplineIj),
        };
        let end = self.target(b)?;
        let points = vec![
            point(from.x, from.y, 1.0),
            point(from.x + i, from.y + j, 1.0),
            point(end.x + p, end.y + q, 1.0),
            point(end.x, end.y, 1.0),
        ];
        self.emit(Call::NurbsFeed { order: 4, points, end })?;
        self.state.position = end;
        self.state.spline = Some((p, q));
        Ok(())
    }

    pub(super) fn quadratic(&mut self, b: &Block) -> Result<(), Problem> {
        self.check_spline(b)?;
        let (Some(i), Some(j)) = (b.get(b'i'), b.get(b'j')) else {
            return Err(Problem::QuadraticIj);
        };
        let from = self.state.position;
        let end = self.target(b)?;
        let points = vec![
            point(from.x, from.y, 1.0),
            point(from.x + i, from.y + j, 1.0),
            point(end.x, end.y, 1.0),
        ];
        self.emit(Call::NurbsFeed { order: 3, points, end })?;
        self.state.position = end;
        Ok(())
    }

    pub(super) fn nurbs_point(&mut self, b: &Block) -> Result<(), Problem> {
        self.check_spline(b)?;
        let weight = b.get(b'p').unwrap_or(1.0);
        if weight <= 0.0 || !b.has(b'p') {
            return Err(Problem::NurbsWeight);
        }
        if !b.has_any(b"xy") && self.state.nurbs.is_some() {
            return Err(Problem::NurbsXy);
        }
        if self.state.nurbs.is_none() {
            let order = match b.integer(b'l')? {
                None => 3,
                Some(l) => u32::try_from(l)
                    .ok()
                    .filter(|l| (2..=64).contains(l))
                    .ok_or(Problem::NurbsOrder)?,
            };
            let from = self.state.position;
            self.state.nurbs = Some(Nurbs { order, points: vec![point(from.x, from.y, weight)] });
            if !b.has_any(b"xy") {
                return Ok(());
            }
        }
        let previous = self.state.nurbs.as_ref().and_then(|n| n.points.last().copied());
        let value = |letter: u8, before: f64| match b.get(letter) {
            None => before,
            Some(v) if self.state.modal.absolute => v,
            Some(v) => before + v,
        };
        let before = previous.unwrap_or(point(0.0, 0.0, 1.0));
        let next = point(value(b'x', before.x), value(b'y', before.y), weight);
        if let Some(nurbs) = &mut self.state.nurbs {
            if nurbs.points.len() >= MAX_POINTS {
                return Err(Problem::OutputTooLarge { limit: MAX_POINTS });
            }
            nurbs.points.push(next);
        }
        Ok(())
    }

    pub(super) fn nurbs_end(&mut self) -> Result<(), Problem> {
        let Some(nurbs) = self.state.nurbs.take() else { return Err(Problem::NurbsNotOpen) };
        if nurbs.points.len() < usize::try_from(nurbs.order).unwrap_or(usize::MAX) {
            return Err(Problem::NurbsFew);
        }
        let mut end = self.state.position;
        if let Some(last) = nurbs.points.last() {
            (end.x, end.y) = (last.x, last.y);
        }
        self.emit(Call::NurbsFeed { order: nurbs.order, points: nurbs.points, end })?;
        self.state.position = end;
        Ok(())
    }

    /// Forgets what another motion code ends.
    pub(super) fn close_curves(&mut self, code: u16) -> Result<(), Problem> {
        if code != 50 {
            self.state.spline = None;
        }
        if !matches!(code, 52 | 53) {
            self.state.nurbs = None;
        }
        Ok(())
    }
}
