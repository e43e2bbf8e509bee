//! A block: the values of a line's words, by letter and by modal group.

use serde::{Deserialize, Serialize};

use crate::{
    error::Problem,
    interpret::codes::{self, GGroup, MGroup},
    remap::{Code as Remapped, Remap},
    text::expression::Left,
};

/// The number of letters with `$`, `@` and `^`.
const LETTERS: usize = 29;

/// A code and its place on the line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Code {
    /// Ten times the number of a G code, or the number of an M code.
    pub code: u16,
    /// The place of its letter.
    pub at: Left,
}

/// The words of a line by letter and group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Block {
    values: [Option<f64>; LETTERS],
    places: [Left; LETTERS],
    g: [Option<Code>; GGroup::COUNT],
    m: [Option<Code>; MGroup::COUNT],
    m_count: u8,
    /// The N number.
    pub number: Option<u32>,
    /// The motion that this block makes, as ten times its G code.
    pub motion: Option<u16>,
    /// A comment that means something, expanded at its turn.
    pub remark: Option<(u8, Box<str>)>,
}

fn slot(letter: u8) -> usize {
    match letter {
        b'a'..=b'z' => usize::from(letter - b'a'),
        b'$' => 26,
        b'@' => 27,
        _ => 28,
    }
}

impl Block {
    /// Adds a word. Codes that the language has not come from `remaps`.
    pub fn add(
        &mut self,
        letter: u8,
        at: Left,
        value: f64,
        remaps: &[Remap],
    ) -> Result<(), Problem> {
        match letter {
            b'g' => self.add_g(at, value, remaps),
            b'm' => self.add_m(at, value, remaps),
            _ => {
                if let Some(place) = self.places.get_mut(slot(letter)) {
                    *place = at;
                }
                match self.values.get_mut(slot(letter)) {
                    Some(empty @ None) => {
                        *empty = Some(value);
                        Ok(())
                    }
                    _ => Err(Problem::MultipleWords { letter: char::from(letter) }),
                }
            }
        }
    }

    fn add_g(&mut self, at: Left, value: f64, remaps: &[Remap]) -> Result<(), Problem> {
        let code = codes::g_code(value)?;
        let group = match codes::g_group(code) {
            Some(group) => group,
            None if remaps.iter().any(|r| r.code == Remapped::G(code)) => GGroup::Motion,
            None => return Err(Problem::UnknownG { code: value }),
        };
        match self.g.get_mut(group as usize) {
            Some(empty @ None) => {
                *empty = Some(Code { code, at });
                Ok(())
            }
            _ => Err(Problem::SameGGroup),
        }
    }

    fn add_m(&mut self, at: Left, value: f64, remaps: &[Remap]) -> Result<(), Problem> {
        let remapped = remaps.iter().find(|r| r.code.is_m(value));
        let (code, group) = match (codes::m_code(value), remapped) {
            // A code of the language keeps its group; a user's code has that of its remap.
            (Ok((code, group)), None) => (code, group),
            (Ok((code, group)), _) if code < 100 => (code, group),
            (_, Some(remap)) => (remap.code.number(), remap.m_group()),
            (Err(problem), None) => return Err(problem),
        };
        match self.m.get_mut(group as usize) {
            Some(empty @ None) => {
                *empty = Some(Code { code, at });
                self.m_count += 1;
                Ok(())
            }
            _ => Err(Problem::SameMGroup),
        }
    }

    /// Returns the value of a word.
    pub fn get(&self, letter: u8) -> Option<f64> {
        self.values.get(slot(letter)).copied().flatten()
    }

    /// Sets the value of a word that was not on the line.
    pub fn set(&mut self, letter: u8, value: Option<f64>) {
        if let Some(v) = self.values.get_mut(slot(letter)) {
            *v = value;
        }
    }

    /// Tells whether the word is there.
    pub fn has(&self, letter: u8) -> bool {
        self.get(letter).is_some()
    }

    /// Tells whether any of the words is there.
    pub fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|l| self.has(*l))
    }

    /// Returns the place of a word.
    pub fn place(&self, letter: u8) -> Left {
        self.places.get(slot(letter)).copied().unwrap_or(0)
    }

    /// Returns the G code of a group.
    pub fn g(&self, group: GGroup) -> Option<u16> {
        self.g.get(group as usize).copied().flatten().map(|c| c.code)
    }

    /// Returns the place of the G code of a group.
    pub fn g_place(&self, group: GGroup) -> Option<Left> {
        self.g.get(group as usize).copied().flatten().map(|c| c.at)
    }

    /// Returns the M code of a group.
    pub fn m(&self, group: MGroup) -> Option<u16> {
        self.m.get(group as usize).copied().flatten().map(|c| c.code)
    }

    /// Returns the place of the M code of a group.
    pub fn m_place(&self, group: MGroup) -> Option<Left> {
        self.m.get(group as usize).copied().flatten().map(|c| c.at)
    }

    /// Returns the number of M codes.
    pub fn m_count(&self) -> u8 {
        self.m_count
    }

    /// Tells whether a word of an axis is there; polar words count.
    pub fn has_axes(&self) -> bool {
        self.has_any(b"xyzabcuvw@^")
    }

    /// Returns the integer of a word.
    pub fn integer(&self, letter: u8) -> Result<Option<i32>, Problem> {
        match self.get(letter) {
            None => Ok(None),
            Some(v) => crate::text::evaluate::integer(v).map(Some).map_err(|_| {
                Problem::ValueNotInteger { letter: char::from(letter.to_ascii_uppercase()) }
            }),
        }
    }
}
