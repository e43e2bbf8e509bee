//! The begin of a job, as the options of halrun state it.

use super::waiting::MaxWait;

/// A program to run on the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Job {
    pub(super) begin: Begin,
    /// Begins in the middle without a question.
    pub(super) yes: bool,
    /// Longest wait for something that may never come.
    pub(super) max_wait: MaxWait,
}

/// The place at which a job begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Begin {
    /// The first line of the program.
    First(String),
    /// A line of the program.
    From(String, ProgramLine),
    /// The place where the last job broke off.
    Resume,
}

/// A line of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ProgramLine {
    file: Option<String>,
    line: u32,
    pass: u32,
}

impl ProgramLine {
    /// Parses `[FILE:]LINE[/PASS]`.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (file, rest) = match text.rsplit_once(':') {
            Some((file, rest)) => (Some(file.to_owned()), rest),
            None => (None, text),
        };
        let (line, pass) = rest.split_once('/').unwrap_or((rest, "1"));
        let number = |text: &str| text.parse::<u32>().ok().filter(|n| *n > 0);
        Some(Self { file, line: number(line)?, pass: number(pass)? })
    }

    /// Returns the arguments of `task.run-from`.
    pub(super) fn args(&self) -> Vec<String> {
        let mut args = vec![format!("line={}", self.line), format!("pass={}", self.pass)];
        args.extend(self.file.iter().map(|file| format!("in={file}")));
        args
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_lines_with_a_file_and_a_pass() {
        let shown = |text| ProgramLine::parse(text).map(|p| p.args().join(" "));
        assert_eq!(shown("12").as_deref(), Some("line=12 pass=1"));
        assert_eq!(shown("12/3").as_deref(), Some("line=12 pass=3"));
        assert_eq!(shown("probe.ngc:7/2").as_deref(), Some("line=7 pass=2 in=probe.ngc"));
        for wrong in ["", "0", "12/0", "-1", "12/x", "a:", "twelve"] {
            assert_eq!(ProgramLine::parse(wrong), None, "{wrong}");
        }
    }
}
