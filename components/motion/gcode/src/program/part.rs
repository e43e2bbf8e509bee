//! Parts of a program: M98 and M99.

use super::Found;
use crate::{
    environment::Environment,
    error::Problem,
    interpret::{BlockError, Interpreter},
    state::{Level, LevelKind},
};

impl Interpreter {
    /// Runs M98.
    pub(crate) fn call_part(
        &mut self,
        part: i32,
        repeats: i32,
        env: &dyn Environment,
    ) -> Result<(), BlockError> {
        let label = part.to_string();
        let Some(repeats) = u32::try_from(repeats).ok().filter(|r| *r > 0) else {
            return Ok(());
        };
        self.check_levels()?;
        let (file, start) = self.locate(Found::Part(&label), &label, env)?;
        let mut level = Level::new(file, start, LevelKind::Part(start, repeats));
        level.label = label.into();
        self.state.count_arguments(&mut level, 0)?;
        self.state.levels.push(level);
        Ok(())
    }

    /// Runs M99. Returns false in the main program.
    pub(crate) fn end_part(&mut self, env: &dyn Environment) -> Result<bool, BlockError> {
        let level = self.level()?;
        match level.kind {
            LevelKind::Part(start, left) if left > 1 => {
                level.kind = LevelKind::Part(start, left - 1);
                level.cursor = start;
                level.open.clear();
                level.pass = level.pass.wrapping_add(1);
                Ok(true)
            }
            LevelKind::Part(..) => self.pop_level(env).map(|()| true),
            LevelKind::Sub => Err(Problem::SubEndedByM99.into()),
            LevelKind::Function(_) | LevelKind::Text(_) => Err(Problem::M99Context.into()),
            LevelKind::Main { .. } | LevelKind::Mdi => Ok(false),
        }
    }
}
