//! Findings as text: `file:line: level[code]: text`, remedy, and the source line for a person.

use super::texts::Texts;
use hal_protocol::{At, Finding, Level};
use std::fmt::Write;

/// Format of findings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Shown {
    /// True to show source lines with carets, for a person.
    pub(super) lines: bool,
    /// True to use colour.
    pub(super) colour: bool,
}

impl Shown {
    /// Returns the format for standard output.
    pub(super) fn for_terminal() -> Self {
        let person = rustix::termios::isatty(std::io::stdout());
        let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        Self { lines: person, colour: person && !plain }
    }
}

/// Returns all findings and the summary.
pub(super) fn write(findings: &[Finding], texts: &Texts, shown: Shown) -> String {
    let mut out = String::new();
    for f in findings {
        // Writing to a string does not fail.
        one(&mut out, f, texts, shown).unwrap_or_default();
    }
    out + &summary(findings)
}

fn one(out: &mut String, f: &Finding, texts: &Texts, shown: Shown) -> core::fmt::Result {
    if let Some(at) = &f.at {
        write!(out, "{at}: ")?;
    }
    let (on, off) = match (shown.colour, f.level) {
        (false, _) => ("", ""),
        (true, Level::Error) => ("\x1b[1;31m", "\x1b[0m"),
        (true, Level::Warning) => ("\x1b[1;33m", "\x1b[0m"),
        (true, Level::Note) => ("\x1b[1;36m", "\x1b[0m"),
    };
    writeln!(out, "{on}{}[{}]{off}: {}", f.level.name(), f.code, f.text)?;
    if shown.lines
        && let Some(at) = &f.at
    {
        line(out, at, &f.subject, texts, (on, off))?;
    }
    if !f.remedy.is_empty() {
        writeln!(out, "    do: {}", f.remedy)?;
    }
    for r in &f.related {
        writeln!(out, "    {}: {}", r.at, r.text)?;
    }
    Ok(())
}

/// Writes the source line with carets under the subject.
fn line(
    out: &mut String,
    at: &At,
    subject: &str,
    texts: &Texts,
    (on, off): (&str, &str),
) -> core::fmt::Result {
    let index = (at.line as usize).checked_sub(1);
    let Some(text) = index.and_then(|i| texts.get(&at.file)?.get(i)) else { return Ok(()) };
    let text = text.replace('\t', " ");
    let number = at.line.to_string();
    let begins = text.len() - text.trim_start().len();
    let (from, length) = match text.find(subject).filter(|_| !subject.is_empty()) {
        Some(at) => (at, subject.len()),
        None => (begins, text.trim().len()),
    };
    let left = text.get(..from).unwrap_or_default().chars().count();
    let marked = text.get(from..from + length).unwrap_or_default().chars().count().max(1);
    writeln!(out, "  {number} | {text}")?;
    writeln!(
        out,
        "  {} | {}{on}{}{off}",
        " ".repeat(number.len()),
        " ".repeat(left),
        "^".repeat(marked)
    )
}

/// Counts the findings of each level.
fn summary(findings: &[Finding]) -> String {
    let count = |level| findings.iter().filter(|f| f.level == level).count();
    let levels = [Level::Error, Level::Warning, Level::Note];
    let parts: Vec<String> = levels
        .into_iter()
        .map(|level| (count(level), level.name()))
        .filter(|(n, _)| *n > 0)
        .map(|(n, name)| format!("{n} {name}{}", if n == 1 { "" } else { "s" }))
        .collect();
    if parts.is_empty() { "nothing found\n".to_owned() } else { format!("{}\n", parts.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_protocol::Code;

    #[test]
    fn for_programs_and_for_people() {
        let findings = [
            Finding::new(Code::NoSuchName, "and2.0.ot", "Pin 'and2.0.ot' does not exist".into())
                .at(Some(At::new("m.hal", 2)))
                .remedy("did you mean 'and2.0.out'?")
                .related(Some(At::new("m.hal", 1)), "loaded here"),
            Finding::new(Code::NoReader, "x", "nothing reads signal 'x'".into()),
        ];
        let lines = ["loadrt and2".to_owned(), "net\tx and2.0.ot".to_owned()];
        let texts = Texts::from([("m.hal".to_owned(), lines.to_vec())]);
        assert_eq!(
            write(&findings, &texts, Shown::default()),
            "m.hal:2: error[H202]: Pin 'and2.0.ot' does not exist\n    \
             do: did you mean 'and2.0.out'?\n    m.hal:1: loaded here\n\
             note[H306]: nothing reads signal 'x'\n1 error, 1 note\n"
        );
        assert_eq!(
            write(findings.get(..1).unwrap(), &texts, Shown { lines: true, colour: true }),
            "m.hal:2: \x1b[1;31merror[H202]\x1b[0m: Pin 'and2.0.ot' does not exist\n  \
             2 | net x and2.0.ot\n    |       \x1b[1;31m^^^^^^^^^\x1b[0m\n    \
             do: did you mean 'and2.0.out'?\n    m.hal:1: loaded here\n1 error\n"
        );
        assert_eq!(write(&[], &texts, Shown::default()), "nothing found\n");
    }
}
