//! The state as lines, and as JSON.

use crate::Zero;
use serde_json::{Value as Json, json};

/// Answer of `robot.status`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Report {
    /// Name of the state; empty before the first step.
    pub(crate) state: &'static str,
    /// File of the program; empty without one.
    pub(crate) file: String,
    /// Number of lines to the robot.
    pub(crate) lines: usize,
    /// Number of the first line that is not known to be executed.
    pub(crate) line: usize,
    /// Line to the robot with that number.
    pub(crate) command: String,
    pub(crate) zero: Option<Zero>,
    pub(crate) warnings: Vec<String>,
    /// Last problem; empty without one.
    pub(crate) problem: String,
}

impl Report {
    /// Returns lines for people.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut out = vec![format!("state {}", self.state)];
        if let Some([x, y, z]) = self.zero {
            out.push(format!("part zero {x:.3} {y:.3} {z:.3}"));
        }
        if !self.file.is_empty() {
            let Self { file, line, lines, command, .. } = self;
            out.push(
                format!("program {file}: line {line} of {lines} {command}").trim_end().to_owned(),
            );
        }
        out.extend(self.warnings.iter().map(|warning| format!("warning: {warning}")));
        if !self.problem.is_empty() {
            out.push(format!("problem: {}", self.problem));
        }
        out
    }

    /// Returns an object for programs.
    pub(crate) fn json(&self) -> Json {
        let Self { state, file, lines, line, command, zero, warnings, problem } = self;
        json!({
            "state": state, "file": file, "lines": lines, "line": line, "command": command, "zero": zero,
            "warnings": warnings, "problem": problem,
        })
    }
}
