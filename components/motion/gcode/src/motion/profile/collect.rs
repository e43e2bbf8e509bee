//! The profile of a cycle, read from the lines of its subroutine.

use super::contour::{Arc, Piece, round};
use crate::{
    canon::Issued,
    environment::Environment,
    error::Problem,
    interpret::{BlockError, Interpreter, Run, Step, block::Block, codes::GGroup},
    motion::geometry::Point,
    parameters::system::Reader,
    program::Found,
    state::{Cursor, Level, LevelKind},
    text::{clean, evaluate::evaluate, line::Line, oword::Action},
};

/// The most pieces of a profile.
const MAX_PIECES: usize = 100_000;

/// A corner that is rounded or cut: its size, and whether it is a chamfer.
type Corner = Option<(f64, bool)>;

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
        // The subroutine has parameters of its own.
        let saved = self.state.numbered.locals();
        self.state.numbered.set_locals(&[]);
        self.state.levels.push(Level::new(file.clone(), start, LevelKind::Sub));
        let pieces = self.collect(&label, &file, start, env, out);
        self.state.levels.pop();
        self.state.numbered.set_locals(&saved);
        let pieces = pieces?;
        let mut run = Run::new(&mut self.state, env, out);
        run.number = block.number;
        let code = block.motion.unwrap_or_default();
        run.run_profile(block, code, &pieces)?;
        let mut block = block.clone();
        let asked = run.execute(&mut block, step + 1)?;
        self.after(&mut block, asked, env, out)
    }

    /// Reads the moves of a subroutine. Other words, and other O-words, mean nothing here.
    fn collect(
        &mut self,
        label: &str,
        file: &str,
        start: Cursor,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Vec<Piece>, BlockError> {
        let position = self.state.position;
        let mut at = Point::new(position.z, position.x);
        let (mut pieces, mut corners): (Vec<Piece>, Vec<Corner>) = (Vec::new(), Vec::new());
        let mut began = false;
        let (mut raw, mut cleaned) = (Vec::new(), Vec::new());
        let (mut line, mut cursor) = (Line::default(), start);
        let mut motion = 10;
        loop {
            let Some(next) = self.read(file, cursor, env, &mut raw)? else {
                let (label, line) = (label.into(), start.line);
                return Err(Problem::EndMissing { label, line }.into());
            };
            cursor = next;
            clean::clean(&raw, &mut cleaned).map_err(|(_, problem)| BlockError::from(problem))?;
            line.parse(&cleaned).map_err(|fault| BlockError::from(fault.problem))?;
            if let Some(word) = &line.oword {
                if matches!(word.action, Action::Endsub(_)) {
                    break;
                }
                continue;
            }
            let block = self.words(&line, env)?;
            if let Some(code @ (0 | 10 | 20 | 30)) = block.g(GGroup::Motion) {
                motion = code;
            }
            if !block.has_any(b"xzuw") {
                continue;
            }
            let end = self.end_of(&block, at);
            if began {
                let corner =
                    block.get(b'a').map(|r| (r, false)).or(block.get(b'c').map(|r| (r, true)));
                let mut piece = Piece::line(at, end);
                if motion >= 20 {
                    let run = Run::new(&mut self.state, env, out);
                    let shape = run.shape(&block, at, end, motion == 20)?;
                    piece.arc = Some(Arc { centre: shape.centre, left: shape.turns > 0 });
                }
                if !piece.is_short() {
                    pieces.push(piece);
                    corners.push(corner);
                }
                if pieces.len() > MAX_PIECES {
                    return Err(Problem::OutputTooLarge { limit: MAX_PIECES }.into());
                }
            }
            began = true;
            at = end;
        }
        Ok(rounded(pieces, &corners)?)
    }

    /// Returns the words of a line.
    fn words(&self, line: &Line, env: &dyn Environment) -> Result<Block, BlockError> {
        let reader = Reader { state: &self.state, environment: env };
        let mut block = Block::default();
        for word in &line.words {
            let value =
                evaluate(&word.value, word.at, &reader).map_err(|(_, p)| BlockError::from(p))?;
            block.add(word.letter, word.at, value, &self.state.settings.remaps)?;
        }
        Ok(block)
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
