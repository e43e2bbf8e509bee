//! G70 to G72.2: turning cycles along a profile that a subroutine describes.

mod collect;
mod contour;
mod levels;
mod moved;
mod passes;

use serde::{Deserialize, Serialize};

use super::{
    arc::{Shape, in_plane},
    geometry::Point,
};
use crate::{
    axis::Position,
    canon::{Call, Plane},
    error::Problem,
    interpret::{Run, block::Block},
    state::FeedMode,
};
use contour::Piece;

/// The largest coordinate or distance of a cycle, in program units.
const LARGEST: f64 = 1e9;

/// The code of the finish.
const FINISH: u16 = 700;

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

/// A problem of a profile with its line; 0 for that of the cycle.
pub(crate) struct ProfileError {
    line: u32,
    problem: Problem,
}

impl From<Problem> for ProfileError {
    fn from(problem: Problem) -> Self {
        Self { line: 0, problem }
    }
}

/// Returns the side of a profile that the tool is on, by the levels of the profile's ends and of the tool: 1 above it, -1
/// below. If the tool is between the ends, it is on the side to which the profile goes; `behind` tells that it is behind
/// the begin, where a tool at the level of the begin can only be on the other side.
fn side(start: f64, end: f64, tool: f64, behind: bool) -> f64 {
    let is_above = if tool > start && tool > end {
        true
    } else if (tool < start && tool < end) || (behind && tool == start && end > start) {
        false
    } else {
        end >= start || (behind && tool == start)
    };
    if is_above { 1.0 } else { -1.0 }
}

/// Tells whether a coordinate or distance is a number that a machine may have.
fn is_in_reach(value: f64) -> bool {
    (-LARGEST..=LARGEST).contains(&value)
}

impl Run<'_> {
    /// Checks the words of a cycle and moves to its place. Returns the label of its subroutine.
    pub(crate) fn begin_profile(&mut self, b: &Block) -> Result<Box<str>, Problem> {
        if self.state.modal.plane != Plane::Xz {
            return Err(Problem::ProfilePlane);
        }
        if self.state.compensation.is_on() {
            if b.motion != Some(FINISH) {
                return Err(Problem::CompWith { code: "G71 to G72.2" });
            }
            if self.state.modal.feed_mode == FeedMode::InverseTime {
                return Err(Problem::CycleInverse);
            }
        }
        self.check_feed(b, "g1")?;
        // Bad words are told before the first move.
        self.words_of_profile(b, b.motion.unwrap_or_default())?;
        let label = b.integer(b'q')?.ok_or(Problem::ProfileNeedsQ)?;
        let mut place = self.programmed();
        place.x = b.get(b'x').unwrap_or(place.x);
        place.z = b.get(b'z').unwrap_or(place.z);
        self.profile_line(place, true)?;
        Ok(label.to_string().into())
    }

    /// Runs a cycle along the pieces of its profile, in Z and X of the program.
    pub(crate) fn run_profile(
        &mut self,
        b: &Block,
        code: u16,
        profile: &[Piece],
    ) -> Result<(), ProfileError> {
        let place = self.programmed();
        let mut cycle = self.words_of_profile(b, code)?;
        let finish = code == FINISH;
        let (Some(first), Some(last)) = (profile.first(), profile.last()) else {
            return Err(Problem::ProfileEmpty.into());
        };
        // The profile goes along one axis; G70 finds out which.
        let facing = cycle.facing || (finish && !contour::goes_forward(profile));
        let plain = Turned { facing, along: 1.0, level: 1.0 };
        let at = |p: Point| plain.point(Position { z: p.first, x: p.second, ..place });
        let (start, end, from) = (at(first.from), at(last.to), plain.point(place));
        let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
        // The tool comes from before a profile that is only a wall.
        let along = match end.first - start.first {
            0.0 => sign(start.first - from.first),
            way => sign(way),
        };
        let behind = along * (from.first - start.first) > 0.0;
        let level = side(start.second, end.second, from.second, behind);
        let turned = Turned { facing, along, level };
        let pieces: Vec<Piece> = profile
            .iter()
            .map(|piece| {
                let turn = |p: Point| turned.point(Position { z: p.first, x: p.second, ..place });
                piece.mapped(turn, turned.mirrors())
            })
            .collect();
        contour::check_forward(&pieces)
            .map_err(|line| ProfileError { line, problem: Problem::ProfileGoesBack })?;
        let comp = &self.state.compensation;
        // The tool is on the left of a profile that goes forward below it.
        if comp.moves_path() && (comp.sign() > 0.0) == turned.mirrors() {
            return Err(Problem::ProfileSide.into());
        }
        if finish {
            self.finish(&mut cycle, turned, &pieces)?;
        } else {
            self.rough(&mut cycle, turned, &pieces)?;
        }
        Ok(())
    }

    /// Returns the words of a cycle.
    fn words_of_profile(&self, b: &Block, code: u16) -> Result<Cycle, Problem> {
        let place = self.programmed();
        let passes = match u32::try_from(b.integer(b'p')?.unwrap_or(1)) {
            Ok(n) if (1..=100_000).contains(&n) => n,
            _ => return Err(Problem::NegativeWord { letter: 'P' }),
        };
        let cycle = Cycle {
            code,
            place,
            facing: (720..=722).contains(&code),
            distance: b.get(b'd').unwrap_or(0.0),
            end_distance: b.get(b'e').unwrap_or(0.0),
            passes,
            increment: b.get(b'i').unwrap_or(1.0),
            retract: b.get(b'r').unwrap_or(0.5),
        };
        if code != FINISH && cycle.increment <= 0.0 {
            return Err(Problem::ProfileIncrement);
        }
        if cycle.retract < 0.0 {
            return Err(Problem::NegativeWord { letter: 'R' });
        }
        let lengths = [
            ('X', place.x),
            ('Z', place.z),
            ('D', cycle.distance),
            ('E', cycle.end_distance),
            ('I', cycle.increment),
            ('R', cycle.retract),
        ];
        match lengths.into_iter().find(|(_, v)| !is_in_reach(*v)) {
            Some((letter, _)) => Err(Problem::ProfileRange { letter }),
            None => Ok(cycle),
        }
    }

    /// Makes a straight move of a finish, with compensation.
    fn profile_line(&mut self, end: Position, rapid: bool) -> Result<(), Problem> {
        if self.state.compensation.moves_path() {
            return self.compensated_line(&Block::default(), end, rapid);
        }
        if rapid { self.rapid(end) } else { self.feed(end) }
    }

    /// Moves along a piece at feed.
    fn along(&mut self, turned: Turned, piece: &Piece) -> Result<(), Problem> {
        let end = turned.position(piece.to, self.state.position);
        let Some(arc) = piece.arc.filter(|_| !piece.is_nearly_straight()) else {
            return self.profile_line(end, false);
        };
        let centre = turned.position(arc.centre, end);
        let turns = if arc.left == turned.mirrors() { -1 } else { 1 };
        if self.state.compensation.moves_path() {
            let shape = Shape { centre: in_plane(Plane::Xz, centre), turns };
            return self.compensated_arc(&Block::default(), end, shape);
        }
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
