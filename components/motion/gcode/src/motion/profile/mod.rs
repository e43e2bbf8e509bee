//! G70 to G72.2: turning cycles along a profile that a subroutine describes.

mod collect;
mod contour;
mod passes;

use serde::{Deserialize, Serialize};

use super::geometry::Point;
use crate::{
    axis::Position,
    canon::{Call, Plane},
    error::Problem,
    interpret::{Run, block::Block},
};
use contour::Piece;

/// The most passes of a cycle.
const MAX_PASSES: f64 = 100_000.0;

/// The words of a cycle, in program units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Cycle {
    code: u16,
    /// The place between passes.
    place: Position,
    /// Z is the axis of the levels (G72), not X.
    facing: bool,
    distance: f64,
    end_distance: f64,
    passes: u32,
    increment: f64,
    retract: f64,
}

/// The directions in which levels fall and cuts run: a frame in which the profile goes forward and lies below.
#[derive(Clone, Copy, Debug)]
struct Turned {
    facing: bool,
    along: f64,
    level: f64,
}

impl Turned {
    fn point(self, position: Position) -> Point {
        let (along, level) =
            if self.facing { (position.x, position.z) } else { (position.z, position.x) };
        Point::new(self.along * along, self.level * level)
    }

    fn position(self, point: Point, like: Position) -> Position {
        let (along, level) = (self.along * point.first, self.level * point.second);
        let (x, z) = if self.facing { (along, level) } else { (level, along) };
        Position { x, z, ..like }
    }

    /// Tells whether the frame turns the other way round than Z and X do.
    fn mirrors(self) -> bool {
        (self.along * self.level < 0.0) != self.facing
    }
}

impl Run<'_> {
    /// Checks the words of a cycle and moves to its place. Returns the label of its subroutine.
    pub(crate) fn begin_profile(&mut self, b: &Block) -> Result<Box<str>, Problem> {
        if self.state.modal.plane != Plane::Xz {
            return Err(Problem::ProfilePlane);
        }
        if self.state.compensation.is_on() {
            return Err(Problem::CompWith { code: "G70 to G72.2" });
        }
        self.check_feed(b, "g1")?;
        let label = b.integer(b'q')?.ok_or(Problem::ProfileNeedsQ)?;
        let mut place = self.state.position;
        place.x = b.get(b'x').unwrap_or(place.x);
        place.z = b.get(b'z').unwrap_or(place.z);
        self.rapid(place)?;
        Ok(label.to_string().into())
    }

    /// Runs a cycle along the pieces of its profile, in Z and X of the program.
    pub(crate) fn run_profile(
        &mut self,
        b: &Block,
        code: u16,
        profile: &[Piece],
    ) -> Result<(), Problem> {
        let place = self.state.position;
        let whole = |letter: u8, default: i32| b.integer(letter).map(|v| v.unwrap_or(default));
        let passes = match u32::try_from(whole(b'p', 1)?) {
            Ok(n) if (1..=100_000).contains(&n) => n,
            _ => return Err(Problem::NegativeWord { letter: 'P' }),
        };
        let finish = code == 700;
        let mut cycle = Cycle {
            code,
            place,
            facing: (720..=722).contains(&code),
            distance: b.get(b'd').unwrap_or(0.0),
            end_distance: b.get(b'e').unwrap_or(0.0),
            passes,
            increment: b.get(b'i').unwrap_or(1.0),
            retract: b.get(b'r').unwrap_or(0.5),
        };
        if !finish && cycle.increment <= 0.0 {
            return Err(Problem::ProfileIncrement);
        }
        let (Some(first), Some(last)) = (profile.first(), profile.last()) else {
            return Err(Problem::ProfileEmpty);
        };
        // The profile goes along one axis; G70 finds out which.
        let facing = cycle.facing || (finish && !contour::goes_forward(profile));
        let plain = Turned { facing, along: 1.0, level: 1.0 };
        let at = |p: Point| plain.point(Position { z: p.first, x: p.second, ..place });
        let (start, end, from) = (at(first.from), at(last.to), plain.point(place));
        let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
        let turned = Turned {
            facing,
            along: sign(end.first - start.first),
            level: match end.second - start.second {
                0.0 => sign(from.second - start.second),
                above => sign(above),
            },
        };
        let pieces: Vec<Piece> = profile
            .iter()
            .map(|piece| {
                let turn = |p: Point| turned.point(Position { z: p.first, x: p.second, ..place });
                piece.mapped(turn, turned.mirrors())
            })
            .collect();
        contour::check_forward(&pieces)?;
        // The tool comes from before the profile.
        let (mut before, begin) = (turned.point(place), pieces.first().map(|p| p.from));
        if let Some(begin) = begin.filter(|b| b.first < before.first) {
            before.first = begin.first;
        }
        cycle.place = turned.position(before, place);
        self.rapid(cycle.place)?;
        if finish {
            self.finish(&cycle, turned, &pieces)
        } else {
            self.rough(&cycle, turned, &pieces)
        }
    }

    /// Moves along a piece at feed.
    fn along(&mut self, turned: Turned, piece: &Piece) -> Result<(), Problem> {
        let end = turned.position(piece.to, self.state.position);
        let Some(arc) = piece.arc else { return self.feed(end) };
        let centre = turned.position(arc.centre, end);
        let turns = if arc.left == turned.mirrors() { -1 } else { 1 };
        self.emit(Call::ArcFeed {
            plane: Plane::Xz,
            end,
            centre_first: centre.z,
            centre_second: centre.x,
            turns,
        })?;
        self.state.position = end;
        Ok(())
    }
}
