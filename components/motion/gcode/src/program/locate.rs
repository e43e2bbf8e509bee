//! The search for the definition of a subroutine or part.

use super::Found;
use crate::{
    environment::Environment,
    error::{Place, Problem},
    interpret::{BlockError, Interpreter},
    state::Cursor,
};

impl Interpreter {
    /// Finds a definition in the files of the calls in progress, the innermost first, or in a file of its own.
    pub(crate) fn locate(
        &mut self,
        wanted: Found<'_>,
        label: &str,
        env: &dyn Environment,
    ) -> Result<(Box<str>, Cursor), BlockError> {
        let files: Vec<Box<str>> = self.state.levels.iter().rev().map(|l| l.file.clone()).collect();
        let longest = self.state.settings.limits.line_length;
        for file in &files {
            if let Some(start) = self.sources.find(file, wanted, longest, env)? {
                return Ok((file.clone(), start));
            }
        }
        // A label is no path: the writer of a program chooses no files of other folders.
        let is_name = !label.contains('/') && !label.ends_with(".ngc");
        if is_name && let Some(start) = self.sources.find(label, wanted, longest, env)? {
            return Ok((label.into(), start));
        }
        let (other, problem) = match wanted {
            Found::Sub(label) => (Found::Part(label), Problem::PartCalled),
            Found::Part(label) => (Found::Sub(label), Problem::SubAsPart),
        };
        for file in files {
            if let Some(Cursor { line, .. }) = self.sources.find(&file, other, longest, env)? {
                // The definition is the place, and the line in execution is its call.
                self.problem_at = self.places();
                self.problem_at.push(Place { file, line, column: 0 });
                return Err(problem.into());
            }
        }
        Err(Problem::LabelMissing { label: label.into() }.into())
    }
}
