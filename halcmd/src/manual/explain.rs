//! `halcmd explain`: meaning, consequences, example and remedy of each finding of `check`.

mod explanation;
mod functs;
mod ini;
mod links;
mod loading;
mod script;
mod steps;
mod values;
mod wiring;

use crate::{Error, Terminal, language::hint::nearest};
use hal_protocol::Code;

pub use explanation::Explanation;

const GROUPS: &[&[Explanation]] = &[
    script::ROWS,
    loading::ROWS,
    links::ROWS,
    wiring::ROWS,
    ini::WIRING,
    values::ROWS,
    functs::ROWS,
    steps::ROWS,
    ini::ROWS,
];

/// Returns every row, in order of codes.
pub fn rows() -> impl Iterator<Item = &'static Explanation> {
    GROUPS.iter().copied().flatten()
}

/// Returns the explanation of a code.
#[must_use]
pub fn row(code: Code) -> Option<&'static Explanation> {
    rows().find(|row| row.code == code)
}

/// Runs `halcmd explain [CODE…]`.
///
/// # Errors
/// There is no such code.
pub fn main(words: &[String], terminal: &mut dyn Terminal) -> Result<u8, Error> {
    if words.is_empty() {
        terminal.out(&list())?;
    }
    for (i, word) in words.iter().enumerate() {
        let Some(code) = Code::parse(word) else {
            let near = nearest(&word.to_ascii_uppercase(), Code::ALL.iter().map(|c| c.id()));
            return Err(Error::NoCode { word: word.as_str().into(), near });
        };
        terminal.out(if i == 0 { "" } else { "\n" })?;
        terminal.out(&explained(code))?;
    }
    Ok(0)
}

/// Returns a list of all codes, one per line.
#[must_use]
pub fn list() -> String {
    let line = |code: &Code| format!("{code}  {:<7}  {}\n", code.level().name(), code.title());
    let lines: String = Code::ALL.iter().map(line).collect();
    lines + "\n'halcmd explain CODE' tells more\n"
}

/// Returns the table of codes for the README.
#[must_use]
pub fn markdown() -> String {
    let line = |c: &Code| format!("| `{c}` | {} | {} |\n", c.level().name(), c.title());
    let lines: String = Code::ALL.iter().map(line).collect();
    format!("| code | level | what it is |\n|---|---|---|\n{lines}")
}

fn explained(code: Code) -> String {
    let mut text = format!("{code} ({}): {}\n", code.level().name(), code.title());
    let Some(row) = row(code) else { return text };
    for (title, body) in
        [("", row.means), ("Why it matters: ", row.matters), ("What to do: ", row.remedy)]
    {
        text.push_str(&format!("\n{}", crate::manual::wrap::wrapped(&format!("{title}{body}"), 0)));
    }
    for (title, script) in [("This shows it:", row.wrong), ("This is right:", row.right)] {
        text.push_str(&format!("\n{title}\n"));
        for line in script.lines() {
            text.push_str(format!("    {line}").trim_end());
            text.push('\n');
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_its_row_in_order() {
        let codes: Vec<Code> = rows().map(|row| row.code).collect();
        assert_eq!(codes, Code::ALL);
        for row in rows() {
            for (what, text) in [("means", row.means), ("matters", row.matters), ("do", row.remedy)]
            {
                assert!(text.ends_with('.'), "{}: {what}: {text}", row.code);
            }
            assert_eq!(row.wrong.matches("# <--").count(), 1, "{}", row.code);
        }
    }

    #[test]
    fn the_readme_has_this_table() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
        let head = "| code | level |";
        let table = markdown();
        let rows = table.strip_prefix(head).unwrap().trim_end();
        hal_golden::check_part(file.as_ref(), head, "\n\n", rows);
    }

    #[test]
    fn codes_are_listed_and_explained() {
        let mut terminal = crate::Captured::default();
        assert_eq!(main(&[], &mut terminal), Ok(0));
        assert!(terminal.out.starts_with("H101  error    a line that cannot be read\n"));
        let text = explained(Code::NoReader);
        assert!(text.starts_with("H306 (note): a signal that nothing reads\n\n"), "{text}");
        assert!(text.contains("# <--"));
        let error = main(&["h3066".to_owned()], &mut terminal).unwrap_err().whole();
        assert_eq!(error, "there is no code 'h3066'; did you mean H306?");
    }
}
