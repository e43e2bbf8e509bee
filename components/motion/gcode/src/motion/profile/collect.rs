//! The profile of a cycle, read from the lines of its subroutine.

use super::{
    contour::{Arc, Piece, round},
    is_in_reach,
};
use crate::{
    canon::Issued,
    environment::Environment,
    error::Problem,
    interpret::{BlockError, Interpreter, Run, Step, block::Block, codes::GGroup},
    motion::geometry::Point,
    program::Found,
    state::{Level, LevelKind},
    text::{clean, line::Line, oword::Action},
};

/// The most pieces of a profile.
const MAX_PIECES: usize = 100_000;

/// A corner that is rounded or cut: its size, and whether it is a chamfer.
type Corner = Option<(f64, bool)>;

/// The moves of a profile so far.
struct Course {
    pieces: Vec<Piece>,
    corners: Vec<Corner>,
    began: bool,
    motion: u16,
}

impl Interpreter {
    /// Runs a cycle along a profile, and then the rest of its block.
    pub(crate) fn profile(
        &mut self,
        block: &Block,
        step: u8,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, BlockError> {
        let label = Run::new(&mut self.state, env, out).begin_profile(block)?;
        let (file, start) = self.locate(Found::Sub(&label), &label, env)?;
        self.check_levels()?;
        // The subroutine has parameters and a position of its own.
        let saved = self.state.numbered.locals();
        let (position, line, depth) =
            (self.state.position, self.state.line, self.state.levels.len());
        // It describes the part: compensation is that of the cycle's moves.
        let programmed = Run::new(&mut self.state, env, out).programmed();
        let compensation = core::mem::take(&mut self.state.compensation);
        self.state.position = programmed;
        self.state.numbered.set_locals(&[]);
        let mut level = Level::new(file.clone(), start, LevelKind::Sub);
        level.label = label;
        self.state.levels.push(level);
        let pieces = self.collect(depth, env, out);
        if pieces.is_err() {
            self.note_place(self.state.line);
        }
        self.state.levels.truncate(depth);
        self.state.numbered.set_locals(&saved);
        self.state.position = position;
        self.state.compensation = compensation;
        self.state.line = line;
        let pieces = pieces?;
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        let code = block.motion.unwrap_or_default();
        if let Err(error) = run.run_profile(block, code, &pieces) {
            if error.line > 0 {
                self.state.levels.push(Level::new(file, start, LevelKind::Sub));
                self.note_place(error.line);
                self.state.levels.truncate(depth);
            }
            return Err(error.problem.into());
        }
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        let mut block = block.clone();
        let asked = run.execute(&mut block, step + 1)?;
        self.after(&mut block, asked, env, out)
    }

    /// Runs the lines of the innermost level, whose depth is `depth`, and returns the moves of G0 to G3 in them.
    /// Assignments and O-words do what they always do; other words mean nothing here.
    fn collect(
        &mut self,
        depth: usize,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Vec<Piece>, BlockError> {
        let mut course =
            Course { pieces: Vec::new(), corners: Vec::new(), began: false, motion: 10 };
        let (mut raw, mut cleaned) = (Vec::new(), Vec::new());
        let mut line = Line::default();
        let (mut read, mut quiet) = (0, 0);
        while let Some(level) = self.state.levels.get(depth..).and_then(<[Level]>::last) {
            let (file, at) = (level.file.clone(), level.cursor);
            if !level.is_of_file() {
                return Err(Problem::ProfileCalls { label: level.label.clone() }.into());
            }
            self.count_line(&mut read, &mut quiet)?;
            let Some(next) = self.read(&file, at, env, &mut raw)? else {
                let label = self.state.levels.last().map(|l| l.label.clone()).unwrap_or_default();
                return Err(Problem::EndMissing { label, line: at.line }.into());
            };
            if let Some(level) = self.state.levels.last_mut() {
                level.cursor = next;
            }
            self.state.line = next.line;
            clean::clean(&raw, &mut cleaned).map_err(|(_, problem)| BlockError::from(problem))?;
            line.parse(&cleaned).map_err(|fault| BlockError::from(fault.problem))?;
            if line.deletable && self.state.settings.block_delete {
                continue;
            }
            if let Some(word) = &line.oword {
                // The end of the profile keeps its level, so that its caller is not ended with it.
                if matches!(word.action, Action::Endsub(_) | Action::Return(_))
                    && self.state.levels.len() == depth + 1
                {
                    break;
                }
                self.flow(word, at, env)?;
                continue;
            }
            let mut block = Block::default();
            self.values(&line, &mut block, env)?;
            let pieces = course.pieces.len();
            self.add_move(&mut course, &block, env, out)?;
            if course.pieces.len() > pieces {
                quiet = 0;
            }
        }
        Ok(rounded(course.pieces, &course.corners)?)
    }

    /// Counts a line of a profile against the limits of a run. All of them are one step of it: that of their cycle.
    fn count_line(&self, read: &mut u64, quiet: &mut u64) -> Result<(), BlockError> {
        let limits = self.state.settings.limits;
        if self.state.lines_run.saturating_add(*read) >= limits.lines {
            return Err(Problem::LinesSpent { limit: limits.lines }.into());
        }
        if *quiet > limits.quiet_lines {
            return Err(Problem::RunAway { limit: limits.quiet_lines }.into());
        }
        *read += 1;
        *quiet += 1;
        Ok(())
    }

    /// Adds the move of a block to a profile. The first one is the way to its begin.
    fn add_move(
        &mut self,
        course: &mut Course,
        block: &Block,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<(), BlockError> {
        if let Some(code @ (0 | 10 | 20 | 30)) = block.g(GGroup::Motion) {
            course.motion = code;
        }
        if !block.has_any(b"xzuw") {
            return Ok(());
        }
        let at = Point::new(self.state.position.z, self.state.position.x);
        let end = self.end_of(block, at);
        self.state.position.z = end.first;
        self.state.position.x = end.second;
        for (letter, value) in [('Z', end.first), ('X', end.second)] {
            if !is_in_reach(value) {
                return Err(Problem::ProfileRange { letter }.into());
            }
        }
        if !course.began {
            course.began = true;
            return Ok(());
        }
        let corner = block.get(b'a').map(|r| (r, false)).or(block.get(b'c').map(|r| (r, true)));
        let mut piece = Piece { line: self.state.line, ..Piece::straight(at, end) };
        if course.motion >= 20 {
            let run = Run::new(&mut self.state, env, out);
            let shape = run.shape(block, at, end, course.motion == 20)?;
            if piece.is_short() || shape.turns.unsigned_abs() != 1 {
                return Err(Problem::ProfileGoesBack.into());
            }
            piece.arc = Some(Arc { centre: shape.centre, left: shape.turns > 0 });
        }
        if !piece.is_short() {
            course.pieces.push(piece);
            course.corners.push(corner);
        }
        if course.pieces.len() > MAX_PIECES {
            return Err(Problem::OutputTooLarge { limit: MAX_PIECES }.into());
        }
        Ok(())
    }

    /// Returns the end of a move in Z and X; U and W are distances.
    fn end_of(&self, block: &Block, from: Point) -> Point {
        let half = if self.state.modal.diameter { 0.5 } else { 1.0 };
        let along = |word: Option<f64>, by: Option<f64>, from: f64| match (word, by) {
            (Some(v), _) if self.state.modal.absolute => v,
            (Some(v), _) | (None, Some(v)) => from + v,
            (None, None) => from,
        };
        let scaled = |letter: u8| block.get(letter).map(|v| v * half);
        Point::new(
            along(block.get(b'z'), block.get(b'w'), from.first),
            along(scaled(b'x'), scaled(b'u'), from.second),
        )
    }
}

/// Puts fillets and chamfers between the pieces.
fn rounded(pieces: Vec<Piece>, corners: &[Corner]) -> Result<Vec<Piece>, Problem> {
    let mut out: Vec<Piece> = Vec::with_capacity(pieces.len());
    let mut corner: Corner = None;
    for (piece, next) in pieces.into_iter().zip(corners) {
        match (corner, out.pop()) {
            (Some((radius, chamfer)), Some(before)) if radius > 0.0 => {
                let (before, between, piece) = round(before, piece, radius, chamfer)?;
                out.extend([before, between, piece]);
            }
            (_, before) => {
                out.extend(before);
                out.push(piece);
            }
        }
        corner = *next;
    }
    Ok(out)
}
