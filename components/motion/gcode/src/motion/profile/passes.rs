//! The passes of a cycle, in a frame in which the profile goes forward and lies below the tool.

use super::{
    Cycle, Turned,
    contour::{NEAR, Piece},
    levels::{Levels, Peaks},
    moved::moved,
};
use crate::{error::Problem, interpret::Run, motion::geometry::Point};

impl Run<'_> {
    /// Makes the passes of G70.
    pub(super) fn finish(
        &mut self,
        cycle: &mut Cycle,
        turned: Turned,
        profile: &[Piece],
    ) -> Result<(), Problem> {
        let last = cycle.end_distance;
        let step = (cycle.distance - last) / f64::from(cycle.passes);
        let distance = |pass: u32| f64::from(pass - 1) * step + last;
        let widest = distance(if step < 0.0 { 1 } else { cycle.passes });
        let outermost = moved(profile, widest);
        self.approach(cycle, turned, &outermost, widest)?;
        let top = top_of(&outermost);
        for pass in (1..=cycle.passes).rev() {
            let pieces = moved(profile, distance(pass));
            let Some(first) = pieces.first() else { continue };
            let start = turned.position(first.from, cycle.place);
            if turned.point(cycle.place).second < first.from.second - NEAR {
                let beside = Point::new(turned.point(cycle.place).first, first.from.second);
                self.profile_line(turned.position(beside, cycle.place), true)?;
            }
            self.profile_line(start, true)?;
            if self.state.compensation.moves_path() && has_closed_slot(&pieces) {
                return Err(Problem::CompGouge);
            }
            for piece in &pieces {
                self.along(turned, piece)?;
            }
            if pass > 1 {
                let end = pieces.last().map_or(Point::default(), |p| p.direction(p.to));
                let falls = end.second < 0.0 && end.first < 0.1;
                if falls && self.state.compensation.moves_path() {
                    return Err(Problem::ProfileEndFalls);
                }
                self.back_over(cycle, turned, top)?;
            }
        }
        Ok(())
    }

    /// Moves from the end of a profile to the place of the cycle, over all that is between.
    fn back_over(&mut self, cycle: &Cycle, turned: Turned, top: f64) -> Result<(), Problem> {
        let (end, place) = (turned.point(self.programmed()), turned.point(cycle.place));
        let room = self.room_to_return();
        let height = top.max(place.second) + room;
        if room > 0.0 || end.second < top - NEAR || place.second < top - NEAR {
            for along in [end.first, place.first] {
                self.profile_line(turned.position(Point::new(along, height), cycle.place), true)?;
            }
        }
        self.profile_line(cycle.place, true)
    }

    /// Returns how far above a profile its moves back are: compensation puts the tool below them.
    fn room_to_return(&self) -> f64 {
        let comp = &self.state.compensation;
        if comp.moves_path() { 4.0 * comp.radius } else { 0.0 }
    }

    /// Moves from the place of a cycle to one before the moved profile, which becomes the place of the cycle.
    fn approach(
        &mut self,
        cycle: &mut Cycle,
        turned: Turned,
        pieces: &[Piece],
        distance: f64,
    ) -> Result<(), Problem> {
        let Some(begin) = pieces.first().map(|p| p.from) else { return Ok(()) };
        let mut place = turned.point(cycle.place);
        let top = top_of(pieces);
        let room = self.room_to_return();
        if place.first > begin.first && (room > 0.0 || place.second < top - NEAR) {
            // The tool leaves a pocket upwards.
            let height = top.max(place.second) + room;
            let before =
                if room > 0.0 { begin.first - distance.max(0.0) - room } else { begin.first };
            for along in [place.first, before] {
                self.profile_line(turned.position(Point::new(along, height), cycle.place), true)?;
            }
            place = Point::new(begin.first, place.second.max(begin.second));
        } else if place.second < begin.second - NEAR {
            // It passes the corner at the begin of the profile at its distance.
            place.first = place.first.min(begin.first - distance.max(0.0));
        } else {
            place.first = place.first.min(begin.first);
        }
        if room > 0.0 {
            // On the way down to a wall, the tool is between the way and the wall.
            place.first = place.first.min(begin.first - distance.max(0.0) - room);
        }
        cycle.place = turned.position(place, cycle.place);
        self.profile_line(cycle.place, true)
    }

    /// Makes the passes of G71 and G72.
    pub(super) fn rough(
        &mut self,
        cycle: &mut Cycle,
        turned: Turned,
        profile: &[Piece],
    ) -> Result<(), Problem> {
        let exact: Vec<Piece> = profile.iter().map(|p| p.exact()).collect();
        let mut pieces = moved(&exact, cycle.distance);
        self.approach(cycle, turned, &pieces, cycle.distance)?;
        let place = turned.point(cycle.place);
        // The allowance may leave nothing of a profile.
        let (Some(first), Some(last)) = (pieces.first().copied(), pieces.last().copied()) else {
            return Ok(());
        };
        if last.to.second < place.second - NEAR {
            let end = Point::new(last.to.first, place.second);
            pieces.push(Piece::straight(last.to, end));
        }
        let parts: Vec<Piece> = pieces.iter().flat_map(Piece::monotone).collect();
        let only_pockets = matches!(cycle.code, 712 | 722);
        let top = if only_pockets { first.from.second } else { place.second };
        let levels = Levels::new(top, cycle.increment, &parts)?;
        let peaks = Peaks::new(&parts);
        let cut = Cut { cycle, turned, parts: &parts, peaks: &peaks };
        let begin = turned.position(first.from, cycle.place);
        if only_pockets || first.from.second < place.second - NEAR {
            if !only_pockets {
                let entry = Piece::straight(place, first.from);
                self.descend(&cut, levels, &entry, 0, true)?;
            }
            self.rapid(begin)?;
        } else {
            let beside = Point::new(place.first, first.from.second);
            self.feed(turned.position(beside, cycle.place))?;
            self.feed(begin)?;
        }
        match cycle.code {
            711 | 721 => self.over_pockets(&cut),
            _ => self.follow(&cut, levels, only_pockets),
        }
    }

    /// Follows a profile, and cuts across at each level that it falls through.
    fn follow(
        &mut self,
        cut: &Cut<'_>,
        mut levels: Levels,
        only_pockets: bool,
    ) -> Result<(), Problem> {
        // The part of an arc that was not made yet.
        let mut begun: Option<Point> = None;
        let mut fell = false;
        for (index, part) in cut.parts.iter().enumerate() {
            let falling = part.to.second < part.from.second - NEAR;
            if only_pockets && falling && !fell {
                // Each pocket is cut from its rim on.
                levels.top = part.from.second;
            }
            fell = falling;
            let cuts = levels.between(part.from.second, part.to.second).next().is_some();
            let mut done =
                if cuts { self.descend(cut, levels, part, index + 1, false)? } else { *part };
            done.from = begun.take().unwrap_or(done.from);
            // The bottom of an arc does not divide it.
            let next = cut.parts.get(index + 1);
            if falling && next.is_some_and(|n| n.arc.is_some() && n.arc == part.arc) {
                begun = Some(done.from);
            } else if !done.is_short() {
                self.along(cut.turned, &done)?;
            }
        }
        Ok(())
    }

    /// Cuts across at each level that a falling piece passes. Returns what is left of the piece.
    fn descend(
        &mut self,
        cut: &Cut<'_>,
        levels: Levels,
        piece: &Piece,
        after: usize,
        rapid: bool,
    ) -> Result<Piece, Problem> {
        let mut rest = *piece;
        for level in levels.between(piece.from.second, piece.to.second) {
            let Some(wall) = cut.wall(after, level) else { continue };
            let at = rest.at_level(level);
            let (before, behind) = rest.split(at);
            if rapid {
                self.rapid(cut.turned.position(at, self.state.position))?;
            } else if before.arc.is_none() || !before.is_short() {
                self.along(cut.turned, &before)?;
            }
            rest = behind;
            self.across(cut, at, wall, rapid)?;
        }
        Ok(rest)
    }

    /// Cuts from a place to a wall and comes back above the cut.
    fn across(
        &mut self,
        cut: &Cut<'_>,
        at: Point,
        wall: Point,
        rapid: bool,
    ) -> Result<(), Problem> {
        let place =
            |along: f64, level: f64| cut.turned.position(Point::new(along, level), cut.cycle.place);
        // A short cut has no room for the whole retraction.
        let half = (wall.first - at.first) / 2.0;
        let retract = cut.cycle.retract.min(half.max(0.0));
        let above = at.second + retract;
        self.feed(place(wall.first, at.second))?;
        self.rapid(place(wall.first - retract, above))?;
        self.rapid(place(at.first + retract, above))?;
        let back = place(at.first, at.second);
        if rapid { self.rapid(back) } else { self.feed(back) }
    }

    /// Follows a profile straight over its pockets.
    fn over_pockets(&mut self, cut: &Cut<'_>) -> Result<(), Problem> {
        let mut index = 0;
        while let Some(part) = cut.parts.get(index) {
            let start = cut.turned.position(part.from, self.state.position);
            self.feed(start)?;
            index += 1;
            let level = part.from.second;
            if part.to.second >= level - NEAR {
                self.along(cut.turned, part)?;
                continue;
            }
            let Some(wall) = cut.peaks.first_at(index, level - NEAR) else { break };
            let Some(rising) = cut.parts.get(wall) else { break };
            let at = rising.at_level(level);
            self.feed(cut.turned.position(at, self.state.position))?;
            let rest = rising.split(at).1;
            if !rest.is_short() {
                self.along(cut.turned, &rest)?;
            }
            index = wall + 1;
        }
        Ok(())
    }
}

/// A profile whose pieces rise or fall throughout, and the cycle that cuts it.
struct Cut<'a> {
    cycle: &'a Cycle,
    turned: Turned,
    parts: &'a [Piece],
    peaks: &'a Peaks,
}

impl Cut<'_> {
    /// Returns the first place, from a part on, at which the profile rises to a level.
    fn wall(&self, from: usize, level: f64) -> Option<Point> {
        let index = self.peaks.first_at(from, level - NEAR)?;
        self.parts.get(index).map(|p| p.at_level(level))
    }
}

/// Tells whether a piece that falls is followed by one that comes straight back: no tool fits between them.
fn has_closed_slot(pieces: &[Piece]) -> bool {
    pieces.iter().zip(pieces.iter().skip(1)).any(|(piece, next)| {
        let (fall, rise) = (piece.direction(piece.to), next.direction(next.from));
        fall.second < 0.0 && rise.second > 0.0 && fall.dot(rise) < -0.99
    })
}

/// Returns the highest level of some pieces.
fn top_of(pieces: &[Piece]) -> f64 {
    let ends = pieces.iter().flat_map(Piece::monotone).flat_map(|p| [p.from.second, p.to.second]);
    ends.fold(f64::NEG_INFINITY, f64::max)
}
