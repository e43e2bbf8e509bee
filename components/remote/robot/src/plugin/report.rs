//! The state as lines, and as JSON.

use super::cause::Cause;
use crate::{Program, Zero};
use serde_json::{Value as Json, json};
use std::sync::Arc;

/// Answer of `robot.status`.
#[derive(Debug, Default)]
pub(crate) struct Report {
    /// Name of the state; empty before the first step.
    pub(crate) state: &'static str,
    pub(crate) program: Option<Arc<Program>>,
    /// Number of the first line that is not known to be executed.
    pub(crate) line: usize,
    pub(crate) zero: Option<Zero>,
    pub(crate) cause: Option<Cause>,
    /// Text of the last problem; empty without one.
    pub(crate) problem: String,
}

impl Report {
    /// Returns lines for people.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut out = vec![format!("state {}", self.state)];
        if let Some([x, y, z]) = self.zero {
            out.push(format!("part zero {x:.3} {y:.3} {z:.3}"));
        }
        if let Some(program) = &self.program {
            let (file, lines) = (program.file.display(), program.records.len());
            let text = format!("program {file}: line {} of {lines} {}", self.line, self.command());
            out.push(text.trim_end().to_owned());
            out.extend(program.warnings.iter().map(|warning| format!("warning: {warning}")));
        }
        let problem = self.problem();
        if !problem.is_empty() {
            out.push(format!("problem: {problem}"));
        }
        out
    }

    /// Returns an object for programs.
    pub(crate) fn json(&self) -> Json {
        let program = self.program.as_deref();
        json!({
            "state": self.state,
            "file": program.map(|p| p.file.display().to_string()).unwrap_or_default(),
            "lines": program.map_or(0, |p| p.records.len()),
            "line": self.line,
            "command": self.command(),
            "zero": self.zero,
            "warnings": program.map_or(&[][..], |p| &p.warnings),
            "problem": self.problem(),
        })
    }

    /// Returns the line to the robot that is not known to be executed; empty without one.
    fn command(&self) -> String {
        let record = self.program.as_ref().and_then(|program| program.records.get(self.line));
        record.map(|record| record.command.to_string()).unwrap_or_default()
    }

    /// Returns the last problem; empty without one.
    fn problem(&self) -> String {
        match (self.cause, self.problem.as_str()) {
            (Some(cause), "") => cause.with(self.line),
            (None | Some(Cause::Unreachable), problem) => problem.to_owned(),
            (Some(cause), problem) => format!("{}; {problem}", cause.with(self.line)),
        }
    }
}
