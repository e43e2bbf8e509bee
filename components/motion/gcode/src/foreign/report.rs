//! The texts: of a file that was recognised, of one code, and of one line.

use core::fmt;

use super::{
    Control, Findings, Unread,
    row::{CodeRow, Sign, Weight},
    scan::{Scan, tenfold},
    survey::{CodeName, has_text, rows_of},
    table::ROWS,
};

impl fmt::Display for CodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let row = match self {
            Self::Number(letter, tenfold) => return number(f, *letter, *tenfold),
            Self::Row(index) => ROWS.get(*index),
        };
        match row.map(|row| (row.sign, row.shown)) {
            Some((Sign::With(letter, code, word), _)) => {
                number(f, letter, code)?;
                write!(f, " {}", upper(word))
            }
            Some((Sign::WholeP(letter, code), _)) => {
                number(f, letter, code)?;
                f.write_str(" P")
            }
            Some((Sign::Remark(text), _)) => write!(f, "the comment \"{text}\""),
            Some((_, shown)) => f.write_str(shown),
            None => Ok(()),
        }
    }
}

fn number(f: &mut fmt::Formatter<'_>, letter: u8, tenfold: u32) -> fmt::Result {
    write!(f, "{}{}", upper(letter), tenfold / 10)?;
    if tenfold.is_multiple_of(10) { Ok(()) } else { write!(f, ".{}", tenfold % 10) }
}

fn upper(letter: u8) -> char {
    char::from(letter.to_ascii_uppercase())
}

impl fmt::Display for Unread {
    /// Writes the code, its number of uses and lines, what it means there and what to write instead.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.code)?;
        if let Some(CodeRow { sign: Sign::WholeP(..), .. }) = self.row {
            write!(f, "{}", self.seen.value)?;
        }
        let many = if self.seen.count == 1 { "" } else { "s" };
        let lines: Vec<String> = self.seen.lines.iter().map(u32::to_string).collect();
        let more = if self.seen.lines.len() as u64 == self.seen.count { "" } else { ", ..." };
        let word = if lines.len() == 1 && more.is_empty() { "line" } else { "lines" };
        write!(f, " ({} time{many}, {word} {}{more})", self.seen.count, lines.join(", "))?;
        match self.row {
            Some(row @ CodeRow { sign: Sign::WholeP(..), .. }) => {
                write!(f, ": {}; write P{} for the seconds", meaning(row), self.seen.value / 1e3)
            }
            Some(row) => write!(f, ": {}; {}", meaning(row), row.instead),
            None => write!(f, ": it is no code of LinuxCNC; see the manual of the other control"),
        }
    }
}

impl Findings {
    /// Returns the controls, such as "Fanuc or Haas".
    pub fn control(&self) -> String {
        join(&self.controls.iter().map(|c| c.name()).collect::<Vec<_>>(), " or ")
    }

    /// Returns the sentence that names the control, and its first signs.
    pub fn sentence(&self) -> String {
        const SHOWN: usize = 5;
        let signs: Vec<String> = self.signs.iter().take(SHOWN).map(CodeName::to_string).collect();
        let more = if self.signs.len() > SHOWN { ", ..." } else { "" };
        format!(
            "this program is for {}, not for LinuxCNC ({}{more})",
            self.control(),
            signs.join(", ")
        )
    }

    /// Returns the sentence and the first `most` codes in one line.
    pub fn summary(&self, most: usize) -> String {
        let mut out = self.sentence();
        for unread in self.unread.iter().take(most) {
            out.push_str(&format!("; {unread}"));
        }
        let left = self.unread.len().saturating_sub(most);
        if left > 0 {
            out.push_str(&format!("; {left} more: halgcode check lists them"));
        }
        out
    }
}

/// Returns what a row means, with the controls that have it.
fn meaning(row: &CodeRow) -> String {
    let owners: Vec<&str> = row.of.iter().copied().map(Control::owner).collect();
    format!("{} {}", join(&owners, " and "), row.means)
}

fn join(names: &[&str], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., end] => format!("{}{last}{end}", first.join(", ")),
    }
}

/// Returns what a code means on other controls and what to write instead, such as "G187 is Haas's smoothing level; leave it
/// out, or use G64 P". `letter` is `g` or `m`.
pub fn advice(letter: u8, code: f64) -> Option<String> {
    let code = tenfold(code)?;
    let strange = |row: &&CodeRow| row.weight == Weight::Strange;
    let mut rows: Vec<&CodeRow> = rows_of(letter, code).filter(strange).collect();
    // A row of its own tells more than one of many codes. From 200 on, those are numbers that remaps of LinuxCNC have too.
    let has_own = rows.iter().any(|row| matches!(row.sign, Sign::Code(..)));
    rows.retain(|row| matches!(row.sign, Sign::Code(..)) || !(has_own || 2000 <= code));
    let told: Vec<String> =
        rows.iter().map(|row| format!("{}; {}", meaning(row), row.instead)).collect();
    let name = CodeName::Number(letter, code);
    (!told.is_empty()).then(|| format!("{name} is {}", told.join(". Or it is ")))
}

/// Returns what a line that cannot be read means on other controls: its text, or its first code that is in the table.
pub fn line_advice(line: &[u8]) -> Option<String> {
    let mut scan = Scan::default();
    scan.line(line);
    let strange = ROWS.iter().enumerate().filter(|(_, row)| row.weight == Weight::Strange);
    let text = strange.filter(|(_, row)| has_text(row.sign, &scan)).min_by_key(|(_, row)| {
        // What the line begins with tells more than what is in it.
        matches!(row.sign, Sign::Has(_))
    });
    if let Some((index, row)) = text {
        return Some(format!("{} is {}; {}", CodeName::Row(index), meaning(row), row.instead));
    }
    let codes = scan.words.iter().filter(|w| matches!(w.letter, b'g' | b'm'));
    codes.filter_map(|w| advice(w.letter, w.value)).next()
}
