//! The survey of a file: its signs, counted within bounds of memory and time.

use std::collections::BTreeMap;

use super::{
    Control,
    row::{CodeRow, Sign, Weight},
    scan::{Scan, ScannedWord, contains},
    table::ROWS,
};
use crate::{
    environment::{Environment, Text},
    interpret::codes::{g_group, m_code},
    program::Sources,
    remap::{Code as Remapped, Remap},
    state::Cursor,
};

/// Largest number of lines that are looked at.
pub const MAX_LINES: u32 = 1_000_000;
/// Largest number of bytes that are looked at.
pub const MAX_BYTES: u64 = 64 << 20;
/// Largest number of bytes of a line that are looked at.
const MAX_LINE: usize = 256;
/// Largest number of lines whose comments may tell a control.
const MAX_REMARKS: u32 = 2000;
/// Largest number of different codes that are counted.
const MAX_CODES: usize = 256;
/// Largest number of lines that are kept of a code.
const MAX_PLACES: usize = 4;

/// The uses of a code or word.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Number of uses.
    pub count: u64,
    /// The lines of the first uses.
    pub lines: Vec<u32>,
    /// The number of the first use's P.
    pub value: f64,
}

impl Seen {
    fn add(&mut self, line: u32, value: f64) {
        if self.count == 0 {
            self.value = value;
        }
        self.count = self.count.saturating_add(1);
        if self.lines.len() < MAX_PLACES && self.lines.last() != Some(&line) {
            self.lines.push(line);
        }
    }
}

/// A code or word that means nothing here, or something else.
#[derive(Clone, Debug, PartialEq)]
pub struct Unread {
    /// The code or word.
    pub code: CodeName,
    /// Uses of it.
    pub seen: Seen,
    /// Meaning there; `None` if the table does not have it.
    pub row: Option<&'static CodeRow>,
}

/// A code, or a word of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CodeName {
    /// A letter, and ten times the number.
    Number(u8, u32),
    /// The place of a row in the table.
    Row(usize),
}

/// A file that was written for another control.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// The controls that have the most of its signs; more than one if the signs do not tell them apart.
    pub controls: Vec<Control>,
    /// The signs of these controls.
    pub signs: Vec<CodeName>,
    /// Codes that mean nothing here, or something else, in the order of the first uses.
    pub unread: Vec<Unread>,
    /// Number of lines that were looked at.
    pub lines: u32,
    /// The file ends there.
    pub is_whole: bool,
}

/// Looks for the signs of other controls in a file. Codes of `remaps` and user programs of the environment are no signs.
///
/// Returns `None` if the file is not recognised as that of another control. At most [`MAX_LINES`] lines and [`MAX_BYTES`]
/// bytes are read.
///
/// # Errors
/// The file cannot be read; the reason.
pub fn survey(
    text: &Text,
    remaps: &[Remap],
    env: &dyn Environment,
) -> Result<Option<Findings>, Box<str>> {
    let mut counts = Counts::default();
    let mut sources = Sources::default();
    sources.put("", text.clone());
    let (mut scan, mut raw, mut cursor) = (Scan::default(), Vec::new(), Cursor::default());
    let mut is_whole = true;
    while let Some(next) =
        sources.line("", cursor, MAX_LINE, env, &mut raw).map_err(|p| p.to_string())?
    {
        if cursor.line >= MAX_LINES || next.offset > MAX_BYTES {
            is_whole = false;
            break;
        }
        cursor = next;
        scan.line(&raw);
        if scan.is_own {
            return Ok(None);
        }
        counts.line(&scan, cursor.line);
    }
    counts.codes.retain(|(letter, tenfold), _| {
        !is_understood(*letter, *tenfold, remaps, env) || is_other(*letter, *tenfold)
    });
    let known = |letter, tenfold| is_understood(letter, tenfold, remaps, env);
    Ok(counts.findings(&known).map(|f| Findings { lines: cursor.line, is_whole, ..f }))
}

/// Tells whether a code means something here: by the language, a remap or a user's program.
fn is_understood(letter: u8, tenfold: u32, remaps: &[Remap], env: &dyn Environment) -> bool {
    let code = u16::try_from(tenfold).unwrap_or(u16::MAX);
    let number = f64::from(tenfold) / 10.0;
    let remapped = remaps.iter().any(|r| match r.code {
        Remapped::G(g) => letter == b'g' && g == code,
        Remapped::M(_) => letter == b'm' && r.code.is_m(number),
        Remapped::Word(_) => false,
    });
    let built_in = match letter {
        b'g' => g_group(code).is_some(),
        _ => m_code(number).is_ok_and(|(m, _)| m < 100 || env.user_code(m) != Ok(false)),
    };
    remapped || built_in
}

/// Tells whether the table has another meaning for a code of the language.
fn is_other(letter: u8, tenfold: u32) -> bool {
    ROWS.iter().any(|r| r.weight == Weight::Other && r.sign == Sign::Code(letter, tenfold))
}

/// Counts of marks.
struct Counts {
    codes: BTreeMap<(u8, u32), Seen>,
    /// The uses of the rows that are not codes.
    rows: Vec<Seen>,
    /// The rows that depend on a code, by it.
    by_code: BTreeMap<(u8, u32), Vec<usize>>,
    /// The rows of texts.
    texts: Vec<usize>,
    /// The rows of comments.
    remarks: Vec<usize>,
}

impl Default for Counts {
    fn default() -> Self {
        let mut out = Self {
            codes: BTreeMap::new(),
            rows: vec![Seen::default(); ROWS.len()],
            by_code: BTreeMap::new(),
            texts: Vec::new(),
            remarks: Vec::new(),
        };
        for (index, row) in ROWS.iter().enumerate() {
            match row.sign {
                Sign::Code(..) | Sign::Codes(..) => {}
                Sign::With(letter, code, _) | Sign::WholeP(letter, code) => {
                    out.by_code.entry((letter, code)).or_default().push(index);
                }
                Sign::Remark(_) => out.remarks.push(index),
                _ => out.texts.push(index),
            }
        }
        out
    }
}

impl Counts {
    fn line(&mut self, scan: &Scan, line: u32) {
        for word in &scan.words {
            if let (b'g' | b'm', Some(tenfold)) = (word.letter, word.tenfold()) {
                self.code(scan, (word.letter, tenfold), line);
            }
        }
        if scan.is_odd || matches!(scan.text.first(), Some(b'o' | b't' | b'e' | b'p')) {
            for index in &self.texts {
                let (Some(row), Some(seen)) = (ROWS.get(*index), self.rows.get_mut(*index)) else {
                    continue;
                };
                if has_text(row.sign, scan) {
                    seen.add(line, 0.0);
                }
            }
        }
        if line <= MAX_REMARKS && !scan.remarks.is_empty() {
            for index in &self.remarks {
                if let (Some(CodeRow { sign: Sign::Remark(text), .. }), Some(seen)) =
                    (ROWS.get(*index), self.rows.get_mut(*index))
                    && contains(&scan.remarks, text.as_bytes())
                {
                    seen.add(line, 0.0);
                }
            }
        }
    }

    fn code(&mut self, scan: &Scan, key: (u8, u32), line: u32) {
        if let Some(seen) = self.codes.get_mut(&key) {
            seen.add(line, 0.0);
        } else if self.codes.len() < MAX_CODES {
            self.codes.entry(key).or_default().add(line, 0.0);
        }
        for index in self.by_code.get(&key).into_iter().flatten() {
            let Some(row) = ROWS.get(*index) else { continue };
            let found = match row.sign {
                Sign::With(_, _, letter) => word(scan, letter),
                Sign::WholeP(..) => word(scan, b'p').filter(|p| p.is_whole && p.value > 0.0),
                _ => None,
            };
            if let (Some(found), Some(seen)) = (found, self.rows.get_mut(*index)) {
                seen.add(line, found.value);
            }
        }
    }

    /// Returns what a row has counted; codes that are understood here are no signs.
    fn seen(&self, index: usize, row: &CodeRow, known: &dyn Fn(u8, u32) -> bool) -> bool {
        match row.sign {
            Sign::Code(letter, code) => {
                self.codes.contains_key(&(letter, code)) && !known(letter, code)
            }
            Sign::Codes(..) => false,
            _ => self.rows.get(index).is_some_and(|seen| seen.count > 0),
        }
    }

    fn findings(&self, known: &dyn Fn(u8, u32) -> bool) -> Option<Findings> {
        let signs: Vec<(usize, &'static CodeRow)> = ROWS
            .iter()
            .enumerate()
            .filter(|(k, row)| row.weight != Weight::Other && self.seen(*k, row, known))
            .collect();
        let score = |control: Control| {
            let own = || signs.iter().filter(|(_, row)| row.of.contains(&control));
            let is_strange = own().any(|(_, row)| row.weight == Weight::Strange);
            if is_strange { own().count() } else { 0 }
        };
        let best = Control::ALL.into_iter().map(score).max().filter(|best| *best >= 2)?;
        let controls: Vec<Control> =
            Control::ALL.into_iter().filter(|c| score(*c) == best).collect();
        let is_of = |row: &CodeRow| row.of.iter().any(|c| controls.contains(c));
        let signs = signs.iter().filter(|(_, row)| is_of(row));
        let signs = signs.map(|(k, row)| match row.sign {
            Sign::Code(letter, tenfold) => CodeName::Number(letter, tenfold),
            _ => CodeName::Row(*k),
        });
        let (signs, unread) = (signs.collect(), self.unread(&is_of, known));
        Some(Findings { controls, signs, unread, lines: 0, is_whole: true })
    }

    /// Tells whether each use of a code has a word that gives it a row of its own.
    fn has_own_row(&self, key: (u8, u32), count: u64, is_of: &dyn Fn(&CodeRow) -> bool) -> bool {
        let mut rows = self.by_code.get(&key).into_iter().flatten();
        rows.any(|k| {
            let (row, seen) = (ROWS.get(*k), self.rows.get(*k));
            row.is_some_and(is_of) && seen.is_some_and(|seen| seen.count == count)
        })
    }

    fn unread(
        &self,
        is_of: &dyn Fn(&CodeRow) -> bool,
        known: &dyn Fn(u8, u32) -> bool,
    ) -> Vec<Unread> {
        let mut out = Vec::new();
        for ((letter, tenfold), seen) in &self.codes {
            let row = rows_of(*letter, *tenfold).find(|row| is_of(row));
            if self.has_own_row((*letter, *tenfold), seen.count, is_of) {
                continue;
            }
            let other = row.is_some_and(|row| row.weight == Weight::Other);
            if other || !known(*letter, *tenfold) {
                let code = CodeName::Number(*letter, *tenfold);
                out.push(Unread { code, seen: seen.clone(), row });
            }
        }
        for (index, (row, seen)) in ROWS.iter().zip(&self.rows).enumerate() {
            let is_named = matches!(row.weight, Weight::Strange | Weight::Other);
            if is_named && seen.count > 0 && is_of(row) {
                out.push(Unread { code: CodeName::Row(index), seen: seen.clone(), row: Some(row) });
            }
        }
        out.sort_by_key(|u| (u.seen.lines.first().copied(), u.code));
        out
    }
}

/// Returns the rows of a code.
pub(super) fn rows_of(letter: u8, tenfold: u32) -> impl Iterator<Item = &'static CodeRow> {
    ROWS.iter().filter(move |row| match row.sign {
        Sign::Code(l, code) => l == letter && code == tenfold,
        Sign::Codes(l, first, last) => l == letter && (first..=last).contains(&tenfold),
        _ => false,
    })
}

fn word(scan: &Scan, letter: u8) -> Option<ScannedWord> {
    scan.words.iter().find(|w| w.letter == letter).copied()
}

/// Tells whether a line has the text of a sign.
pub(super) fn has_text(sign: Sign, scan: &Scan) -> bool {
    let text = &*scan.text;
    match sign {
        Sign::Begins(start) => text.starts_with(start.as_bytes()),
        Sign::Is(whole) => text == whole.as_bytes(),
        Sign::Has(part) => contains(text, part.as_bytes()),
        Sign::Assigns(letter) => assigns(letter, text),
        Sign::Program(least, most) => is_program(text, least, most),
        Sign::FourDigitTool => {
            scan.words.iter().any(|w| w.letter == b't' && w.digits == 4 && w.is_whole)
        }
        _ => false,
    }
}

fn assigns(letter: u8, text: &[u8]) -> bool {
    let Some((first, rest)) = text.split_first() else { return false };
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    *first == letter && digits > 0 && rest.get(digits) == Some(&b'=')
}

fn is_program(text: &[u8], least: usize, most: usize) -> bool {
    let Some(digits) = text.strip_prefix(b"o") else { return false };
    (least..=most).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit)
}
