//! The words of a line with their places in its bytes.

use super::Reason;
use hal_gcode::{
    error::Problem,
    text::{
        clean,
        evaluate::{Values, evaluate},
        expression::{Expr, value},
        line::{Line, Target},
        oword::OWord,
    },
};
use std::collections::BTreeMap;

/// Word of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Word {
    /// Letter in lower case.
    pub(super) letter: u8,
    /// Offset of the letter.
    pub(super) at: usize,
    /// Offset of its value.
    pub(super) from: usize,
    /// Offset behind its value.
    pub(super) to: usize,
    /// Value, if it is known.
    pub(super) value: Option<f64>,
}

impl Word {
    /// Returns its column, from 1.
    pub(super) fn column(&self) -> u32 {
        u32::try_from(self.at).unwrap_or(u32::MAX).saturating_add(1)
    }
}

/// Words of a line. Its memory is used again for the next line.
#[derive(Default)]
pub(super) struct Words {
    pub(super) list: Vec<Word>,
    /// The line begins with `/`.
    pub(super) deletable: bool,
    /// The line's O-word.
    pub(super) flow: Option<OWord>,
    line: Line,
    cleaned: Vec<u8>,
    /// Offset in the line of each byte of the cleaned line.
    places: Vec<usize>,
}

impl Words {
    /// Reads a line. `known` evaluates expressions.
    pub(super) fn read(&mut self, raw: &[u8], known: Option<&Known>) -> Result<(), (u32, Reason)> {
        self.list.clear();
        self.flow = None;
        let column = |at: usize| u32::try_from(at).unwrap_or(u32::MAX).saturating_add(1);
        let cleaned = clean::clean(raw, &mut self.cleaned);
        cleaned.map_err(|(at, problem)| (column(at), Reason::Syntax(problem)))?;
        self.place(raw);
        let length = self.cleaned.len();
        self.line.parse(&self.cleaned).map_err(|fault| {
            let at = self.places.get(length - fault.at.len());
            (at.map_or(0, |at| column(*at)), Reason::Syntax(fault.problem))
        })?;
        self.deletable = self.line.deletable;
        self.flow = self.line.oword.take();
        for word in &self.line.words {
            let at = length.saturating_sub(usize::try_from(word.at).unwrap_or(0));
            let behind = self.cleaned.get(at + 1..).unwrap_or_default();
            let left = value(behind).map_or(0, |(rest, _)| rest.len());
            let place = |n: usize| self.places.get(n).copied().unwrap_or(raw.len());
            self.list.push(Word {
                letter: word.letter,
                at: place(at),
                from: place(at + 1),
                to: place(length - left - 1) + 1,
                value: number(&word.value, known),
            });
        }
        Ok(())
    }

    /// Finds the place of each byte of the cleaned line.
    fn place(&mut self, raw: &[u8]) {
        self.places.clear();
        let mut comment = None;
        for (at, byte) in raw.iter().copied().enumerate() {
            let kept = match comment {
                Some(b';') => byte != b'\r',
                Some(_) => true,
                None => !matches!(byte, b' ' | b'\t' | b'\r' | b'\n' | 0x0b | 0x0c),
            };
            match (comment, byte) {
                (None, b'(' | b';') => comment = Some(byte),
                (Some(b'('), b')') => comment = None,
                _ => {}
            }
            if kept {
                self.places.push(at);
            }
        }
    }

    /// Returns the first word with this letter.
    pub(super) fn get(&self, letter: u8) -> Option<&Word> {
        self.list.iter().find(|w| w.letter == letter)
    }

    /// Returns whether there is a word with one of these letters.
    pub(super) fn has(&self, letters: &[u8]) -> bool {
        self.list.iter().any(|w| letters.contains(&w.letter))
    }

    /// Returns the value of a word that must be known.
    pub(super) fn number(&self, letter: u8) -> Result<Option<f64>, (u32, Reason)> {
        let Some(word) = self.get(letter) else { return Ok(None) };
        let shown = char::from(letter.to_ascii_uppercase());
        word.value.map(Some).ok_or((word.column(), Reason::Expression(shown)))
    }
}

/// Returns the value of an expression, if it is a number or can be evaluated.
fn number(expr: &Expr, known: Option<&Known>) -> Option<f64> {
    match (expr, known) {
        (Expr::Number(n), _) => Some(*n),
        (_, Some(known)) => evaluate(expr, 0, known).ok(),
        (_, None) => None,
    }
}

/// Last numbered parameter that the program alone sets: the machine sets those behind it, such as the place of a probe.
const LAST_OWN: i32 = 5000;

/// Parameters that the program has set, on a way without flow control.
#[derive(Default)]
pub(super) struct Known {
    numbered: BTreeMap<i32, f64>,
    named: BTreeMap<Box<str>, f64>,
}

impl Known {
    /// Forgets all values.
    pub(super) fn forget(&mut self) {
        self.numbered.clear();
        self.named.clear();
    }

    /// Takes the values that a line sets; they hold from the next line on.
    pub(super) fn assign(&mut self, words: &Words, expands: bool) {
        if !expands {
            return;
        }
        let mut new = Vec::new();
        for (_, target, expr) in &words.line.assignments {
            let value = evaluate(expr, 0, self).ok().filter(|_| !words.deletable);
            let index = match target {
                Target::Numbered(index) => match evaluate(index, 0, self) {
                    #[expect(clippy::cast_possible_truncation, reason = "the range is checked")]
                    Ok(n) if libm::fabs(n) < 1e6 => Some(libm::round(n) as i32),
                    // An unknown target may be any parameter.
                    _ => {
                        self.forget();
                        return;
                    }
                },
                Target::Named(_) => None,
            };
            new.push((index, target, value));
        }
        for (index, target, value) in new {
            match (index, target, value) {
                (Some(n), _, _) if n > LAST_OWN => None,
                (Some(n), _, Some(value)) => self.numbered.insert(n, value),
                (Some(n), _, None) => self.numbered.remove(&n),
                (None, Target::Named(name), Some(value)) => self.named.insert(name.clone(), value),
                (None, Target::Named(name), None) => self.named.remove(name),
                (None, Target::Numbered(_), _) => None,
            };
        }
    }
}

impl Values for Known {
    fn numbered(&self, index: i32) -> Result<f64, Problem> {
        self.numbered.get(&index).copied().ok_or(Problem::NotANumber)
    }

    fn named(&self, name: &str) -> Result<f64, Problem> {
        self.named.get(name).copied().ok_or(Problem::NotANumber)
    }

    fn exists(&self, name: &str) -> bool {
        self.named.contains_key(name)
    }
}
