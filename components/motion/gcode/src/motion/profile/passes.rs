//! The passes of a cycle, in a frame in which the profile goes forward and lies below the tool.

use super::{
    Cycle, MAX_PASSES, Turned,
    contour::{NEAR, Piece, check_forward, offset},
};
use crate::{error::Problem, interpret::Run, motion::geometry::Point};

impl Run<'_> {
    /// Makes the passes of G70.
    pub(super) fn finish(
        &mut self,
        cycle: &Cycle,
        turned: Turned,
        profile: &[Piece],
    ) -> Result<(), Problem> {
        let passes = f64::from(cycle.passes);
        for pass in (1..=cycle.passes).rev() {
            let step = (cycle.distance - cycle.end_distance) / passes;
            let distance = f64::from(pass - 1) * step + cycle.end_distance;
            let pieces = offset(profile, distance);
            check_forward(&pieces)?;
            let Some(first) = pieces.first() else { return Err(Problem::ProfileEmpty) };
            let start = turned.position(first.from, cycle.place);
            self.rapid(start)?;
            for piece in &pieces {
                self.along(turned, piece)?;
            }
            if pass > 1 {
                self.rapid(cycle.place)?;
            }
        }
        Ok(())
    }

    /// Makes the passes of G71 and G72.
    pub(super) fn rough(
        &mut self,
        cycle: &Cycle,
        turned: Turned,
        profile: &[Piece],
    ) -> Result<(), Problem> {
        let place = turned.point(cycle.place);
        let mut pieces = offset(profile, cycle.distance);
        check_forward(&pieces)?;
        let (Some(first), Some(last)) = (pieces.first().copied(), pieces.last().copied()) else {
            return Err(Problem::ProfileEmpty);
        };
        if last.to.second < place.second - NEAR {
            let end = Point::new(last.to.first, place.second);
            pieces.push(Piece::line(last.to, end));
        }
        let depth = (place.second - first.from.second) / cycle.increment;
        if !(0.0..MAX_PASSES).contains(&libm::fabs(depth)) {
            return Err(Problem::OutputTooLarge { limit: 100_000 });
        }
        let parts: Vec<Piece> = pieces.iter().flat_map(Piece::monotone).collect();
        let only_pockets = matches!(cycle.code, 712 | 722);
        let no_pockets = matches!(cycle.code, 711 | 721);
        let top = if only_pockets { first.from.second } else { place.second };
        let mut levels = Levels { top, increment: cycle.increment };
        if only_pockets {
            self.rapid(turned.position(first.from, cycle.place))?;
        } else {
            let entry = Piece::line(place, first.from);
            let begin = turned.position(first.from, cycle.place);
            if first.from.second < place.second - NEAR {
                self.descend(cycle, turned, levels, &entry, &parts, true)?;
                self.rapid(begin)?;
            } else {
                self.feed(begin)?;
            }
        }
        if no_pockets {
            return self.over_pockets(turned, &parts);
        }
        let mut rest = parts.as_slice();
        // The part of an arc that was not made yet.
        let mut begun: Option<Point> = None;
        let mut fell = false;
        while let Some((part, after)) = rest.split_first() {
            let falling = part.to.second < part.from.second - NEAR;
            if only_pockets && falling && !fell {
                // Each pocket is cut from its rim on.
                levels.top = part.from.second;
            }
            fell = falling;
            let cuts = levels.between(part.from.second, part.to.second).next().is_some();
            let mut done =
                if cuts { self.descend(cycle, turned, levels, part, after, false)? } else { *part };
            done.from = begun.take().unwrap_or(done.from);
            // The bottom of an arc does not divide it.
            let goes_on =
                falling && after.first().is_some_and(|n| n.arc.is_some() && n.arc == part.arc);
            if goes_on {
                begun = Some(done.from);
            } else if !done.is_short() {
                self.along(turned, &done)?;
            }
            rest = after;
        }
        Ok(())
    }

    /// Cuts across at each level that a falling piece passes. Returns what is left of the piece.
    fn descend(
        &mut self,
        cycle: &Cycle,
        turned: Turned,
        levels: Levels,
        piece: &Piece,
        after: &[Piece],
        rapid: bool,
    ) -> Result<Piece, Problem> {
        let mut rest = *piece;
        for level in levels.between(piece.from.second, piece.to.second) {
            let Some(at) = rest.at_level(level) else { continue };
            let Some(wall) = next_rise(after, level) else { continue };
            let (before, behind) = rest.split(at);
            if rapid {
                self.rapid(turned.position(at, self.state.position))?;
            } else if before.arc.is_none() || !before.is_short() {
                self.along(turned, &before)?;
            }
            rest = behind;
            let place =
                |along: f64, level: f64| turned.position(Point::new(along, level), cycle.place);
            let (near, far) = (at.first + cycle.retract, wall.first - cycle.retract);
            self.feed(place(wall.first, level))?;
            self.rapid(place(far, level + cycle.retract))?;
            self.rapid(place(near, level + cycle.retract))?;
            if rapid {
                self.rapid(place(at.first, level))?;
            } else {
                self.feed(place(at.first, level))?;
            }
        }
        Ok(rest)
    }

    /// Follows a profile straight over its pockets.
    fn over_pockets(&mut self, turned: Turned, parts: &[Piece]) -> Result<(), Problem> {
        let mut rest = parts;
        while let Some((part, after)) = rest.split_first() {
            let start = turned.position(part.from, self.state.position);
            self.feed(start)?;
            rest = after;
            let level = part.from.second;
            if part.to.second >= level - NEAR {
                self.along(turned, part)?;
                continue;
            }
            while let Some((next, after)) = rest.split_first() {
                rest = after;
                let rises = next.to.second > next.from.second + NEAR;
                if rises
                    && next.to.second >= level - NEAR
                    && let Some(at) = next.at_level(level)
                {
                    self.feed(turned.position(at, self.state.position))?;
                    self.along(turned, &next.split(at).1)?;
                    break;
                }
            }
        }
        Ok(())
    }
}

/// Returns the first place at which the pieces rise to a level.
fn next_rise(pieces: &[Piece], level: f64) -> Option<Point> {
    let rises = |p: &&Piece| p.to.second >= level - NEAR && p.to.second > p.from.second + NEAR;
    pieces.iter().find(rises).and_then(|p| p.at_level(level))
}

/// The levels of cuts.
#[derive(Clone, Copy, Debug)]
struct Levels {
    top: f64,
    increment: f64,
}

impl Levels {
    /// Iterates over the levels from `high`, included, down to `low`, which is none.
    fn between(self, high: f64, low: f64) -> impl Iterator<Item = f64> {
        let first = libm::ceil((self.top - high) / self.increment - 1e-9);
        let first = if first > 0.0 { first } else { 0.0 };
        (0..100_000u32)
            .map(move |n| self.top - (first + f64::from(n)) * self.increment)
            .take_while(move |level| *level > low + 1e-9)
    }
}
