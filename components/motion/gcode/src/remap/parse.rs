//! The text of a `REMAP` entry.

use core::fmt;

use super::{Argument, Code, Remap};
use crate::{function::Hook, interpret::codes};

/// A `REMAP` entry that means nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the fields are parts of the message")]
pub enum Error {
    /// No code.
    NoCode,
    /// The first word is no code.
    NotACode { word: Box<str> },
    /// The code may not be remapped.
    Fixed { code: Code },
    /// The modal group is none of those allowed.
    Group { code: Code, group: Box<str> },
    /// A letter of `argspec` means nothing.
    Letter { code: Code, letter: char },
    /// Neither `ngc=` nor `py=`.
    NoBody { code: Code },
    /// Both `ngc=` and `py=`.
    TwoBodies { code: Code },
    /// An option that is unknown.
    Option { code: Code, option: Box<str> },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCode => write!(f, "REMAP without a code: REMAP=CODE argspec=… ngc=…"),
            Self::NotACode { word } => {
                write!(f, "REMAP '{word}': the code is a G or M code, or T, S or F")
            }
            Self::Fixed { code } => write!(
                f,
                "REMAP {code}: the code cannot be remapped (M0, M1, M6, M60, M61, T, S, F and unused codes can)"
            ),
            Self::Group { code, group } => {
                write!(f, "REMAP {code}: modalgroup={group} (1 for G codes, 4 to 10 for M codes)")
            }
            Self::Letter { code, letter } => {
                write!(f, "REMAP {code}: '{letter}' in argspec (letters of words, @ ^ > and N)")
            }
            Self::NoBody { code } => write!(f, "REMAP {code}: ngc= is missing"),
            Self::TwoBodies { code } => write!(f, "REMAP {code}: ngc= and py= exclude each other"),
            Self::Option { code, option } => write!(
                f,
                "REMAP {code}: unknown option '{option}' (modalgroup argspec ngc py prolog epilog)"
            ),
        }
    }
}

impl std::error::Error for Error {}

/// The codes of the language that may be remapped.
const OPEN: [u16; 5] = [0, 1, 6, 60, 61];

impl Remap {
    /// Parses the value of an entry: the code, and options separated by blanks.
    ///
    /// # Errors
    /// The code or an option means nothing.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mut words = text.split_whitespace();
        let code = code(words.next().ok_or(Error::NoCode)?)?;
        let mut out = Self {
            code,
            group: if matches!(code, Code::M(_)) { 10 } else { 1 },
            arguments: Vec::new(),
            positional: false,
            needs_speed: false,
            needs_feed: false,
            line_number: false,
            ngc: Box::default(),
            hooks: Vec::new(),
        };
        for word in words {
            let (option, value) = word.split_once('=').unwrap_or((word, ""));
            match option {
                "modalgroup" => out.modal_group(value)?,
                "argspec" => out.argspec(value)?,
                "ngc" => out.ngc = value.to_ascii_lowercase().into(),
                "py" | "python" => out.hooks.push((Hook::Body, value.into())),
                "prolog" => out.hooks.push((Hook::Prolog, value.into())),
                "epilog" => out.hooks.push((Hook::Epilog, value.into())),
                _ => return Err(Error::Option { code, option: option.into() }),
            }
        }
        match (out.ngc.is_empty(), out.hook(Hook::Body)) {
            (true, None) => Err(Error::NoBody { code }),
            (false, Some(_)) => Err(Error::TwoBodies { code }),
            _ => Ok(out),
        }
    }

    fn modal_group(&mut self, value: &str) -> Result<(), Error> {
        let wrong = || Error::Group { code: self.code, group: value.into() };
        let group: u8 = value.parse().map_err(|_| wrong())?;
        let fits = match self.code {
            Code::G(_) => group == 1,
            Code::M(_) => (4..=10).contains(&group),
            Code::Word(_) => true,
        };
        if !fits {
            return Err(wrong());
        }
        self.group = group;
        Ok(())
    }

    fn argspec(&mut self, value: &str) -> Result<(), Error> {
        for letter in value.chars() {
            match letter {
                '@' => self.positional = true,
                '^' => self.needs_speed = true,
                '>' => self.needs_feed = true,
                'n' | 'N' => self.line_number = true,
                'a'..='z' | 'A'..='Z' if !matches!(letter, 'g' | 'G' | 'm' | 'M' | 'o' | 'O') => {
                    let byte = u8::try_from(letter).unwrap_or_default();
                    let letter = byte.to_ascii_lowercase();
                    let required = byte.is_ascii_uppercase();
                    self.arguments.push(Argument { letter, required });
                }
                _ => return Err(Error::Letter { code: self.code, letter }),
            }
        }
        Ok(())
    }
}

fn code(word: &str) -> Result<Code, Error> {
    let wrong = || Error::NotACode { word: word.into() };
    let (first, number) = word.split_at_checked(1).ok_or_else(wrong)?;
    let first = first.bytes().next().unwrap_or_default().to_ascii_lowercase();
    if matches!(first, b't' | b's' | b'f') && number.is_empty() {
        return Ok(Code::Word(first));
    }
    let value: f64 = number.parse().map_err(|_| wrong())?;
    match first {
        b'g' => {
            let code = Code::G(codes::g_code(value).map_err(|_| wrong())?);
            match code {
                Code::G(n) if codes::g_group(n).is_some() => Err(Error::Fixed { code }),
                _ => Ok(code),
            }
        }
        b'm' => {
            let n: u16 = number.parse().ok().filter(|n| *n <= 999).ok_or_else(wrong)?;
            let fixed = codes::m_code(value).is_ok() && n < 100 && !OPEN.contains(&n);
            if fixed { Err(Error::Fixed { code: Code::M(n) }) } else { Ok(Code::M(n)) }
        }
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_has_a_code_words_and_a_subroutine() {
        let remap = Remap::parse("M400  modalgroup=5 argspec=@Pq^>n ngc=MyProc").unwrap();
        assert_eq!((remap.code, remap.group, &*remap.ngc), (Code::M(400), 5, "myproc"));
        let letters: Vec<(u8, bool)> =
            remap.arguments.iter().map(|a| (a.letter, a.required)).collect();
        assert_eq!(letters, [(b'p', true), (b'q', false)]);
        assert!(remap.positional && remap.needs_speed && remap.needs_feed && remap.line_number);
        assert_eq!(Remap::parse("g88.6 ngc=a").unwrap().code, Code::G(886));
        assert_eq!(Remap::parse("T prolog=p ngc=a").unwrap().hook(Hook::Prolog), Some("p"));
        assert_eq!(Remap::parse("M6 py=change").unwrap().hook(Hook::Body), Some("change"));
    }

    #[test]
    fn each_wrong_entry_has_its_message() {
        let cases = [
            ("", "REMAP without a code"),
            ("X ngc=a", "REMAP 'X': the code is"),
            ("G ngc=a", "REMAP 'G': the code is"),
            ("é ngc=a", "REMAP 'é': the code is"),
            ("G1 ngc=a", "REMAP G1: the code cannot be remapped"),
            ("M3 ngc=a", "REMAP M3: the code cannot be remapped"),
            ("G88.6 modalgroup=2 ngc=a", "REMAP G88.6: modalgroup=2"),
            ("M400 modalgroup=11 ngc=a", "REMAP M400: modalgroup=11"),
            ("M400 argspec=P# ngc=a", "REMAP M400: '#' in argspec"),
            ("M400 argspec=P", "REMAP M400: ngc= is missing"),
            ("M400 ngc=a py=b", "REMAP M400: ngc= and py= exclude"),
            ("M400 ncg=a", "REMAP M400: unknown option 'ncg'"),
        ];
        for (text, wanted) in cases {
            let error = Remap::parse(text).unwrap_err().to_string();
            assert!(error.starts_with(wanted), "{text}: {error}");
        }
    }
}
