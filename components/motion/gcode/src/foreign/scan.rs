//! The codes and words of one line, as any control writes them.

use crate::text::{
    comment::{Kind, classify},
    oword,
};

/// Largest number of words of a line that are looked at.
const MAX_WORDS: usize = 64;

/// A word of a line: a letter and a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ScannedWord {
    pub(super) letter: u8,
    pub(super) value: f64,
    /// The number has neither decimal point nor sign.
    pub(super) is_whole: bool,
    /// Number of digits before the decimal point.
    pub(super) digits: usize,
}

impl ScannedWord {
    /// Returns ten times the number of a code; `None` if it has more than one decimal.
    pub(super) fn tenfold(self) -> Option<u32> {
        tenfold(self.value)
    }
}

/// Returns ten times the number of a code; `None` if it has more than one decimal, or is not from 0 to 9999.
pub(super) fn tenfold(value: f64) -> Option<u32> {
    let tenfold = libm::round(value * 10.0);
    let fits = (0.0..=99_990.0).contains(&tenfold) && libm::fabs(tenfold - value * 10.0) < 1e-3;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 99990")]
    fits.then_some(tenfold as u32)
}

/// A line in parts; its memory is used again.
#[derive(Default)]
pub(super) struct Scan {
    /// The line in lower case, without spaces, comments, the mark of block delete and its number.
    pub(super) text: Vec<u8>,
    /// The comments in lower case.
    pub(super) remarks: Vec<u8>,
    /// The words.
    pub(super) words: Vec<ScannedWord>,
    /// The line is more than letters with numbers.
    pub(super) is_odd: bool,
    /// The line has a word that only LinuxCNC has.
    pub(super) is_own: bool,
}

impl Scan {
    /// Takes a line apart.
    pub(super) fn line(&mut self, raw: &[u8]) {
        self.text.clear();
        self.remarks.clear();
        self.words.clear();
        (self.is_odd, self.is_own) = (false, false);
        self.clean(raw);
        self.strip();
        self.is_own |= self.is_o_word() || contains(&self.text, b"#<");
        self.read();
    }

    /// Parts text and comments.
    fn clean(&mut self, raw: &[u8]) {
        let mut rest = raw;
        while let Some((first, after)) = rest.split_first() {
            rest = after;
            let end = match first {
                b';' => rest.len(),
                b'(' => rest.iter().position(|b| *b == b')').unwrap_or(rest.len()),
                b if b.is_ascii_whitespace() => continue,
                b => {
                    self.text.push(b.to_ascii_lowercase());
                    continue;
                }
            };
            let (comment, after) = rest.split_at_checked(end).unwrap_or((rest, &[]));
            rest = after.get(1..).unwrap_or_default();
            self.is_own |= *first == b'(' && is_own_comment(comment);
            self.remarks.extend(comment.iter().map(u8::to_ascii_lowercase));
            self.remarks.push(b'\n');
        }
        self.is_own |= contains(&self.remarks, b"linuxcnc") || contains(&self.remarks, b"emc2");
    }

    /// Takes the mark of block delete and the number of the line off. Heidenhain writes the number without N.
    fn strip(&mut self) {
        let mut start = usize::from(self.text.first() == Some(&b'/'));
        start += usize::from(self.text.get(start) == Some(&b'n'));
        let digits = self.text.get(start..).unwrap_or_default();
        let digits = digits.iter().take_while(|b| b.is_ascii_digit()).count();
        let is_name = digits == 0 && start > 0 && self.text.get(start - 1) == Some(&b'n');
        self.text.drain(..start + digits - usize::from(is_name));
    }

    /// Tells whether the line is an O-word with a name or a keyword, which no other control has.
    fn is_o_word(&self) -> bool {
        let Some(rest) = self.text.strip_prefix(b"o") else { return false };
        if rest.first() == Some(&b'<') {
            return true;
        }
        oword::label(rest).is_ok_and(|(rest, _)| oword::keyword(rest).is_some())
    }

    /// Reads the words.
    fn read(&mut self) {
        let mut at = 0;
        while let Some(byte) = self.text.get(at).copied() {
            at += 1;
            match byte {
                b'a'..=b'z' => at = self.word(byte, at),
                b'[' => {
                    let inner = self.text.get(at..).unwrap_or_default();
                    at += inner.iter().position(|b| *b == b']').unwrap_or(inner.len());
                }
                b'$' | b'?' | b'!' | b'~' | b':' | b'%' | b'=' | b'"' => self.is_odd = true,
                _ => {}
            }
        }
    }

    /// Reads the number behind a letter; returns the place behind it.
    fn word(&mut self, letter: u8, at: usize) -> usize {
        let rest = self.text.get(at..).unwrap_or_default();
        let sign = usize::from(matches!(rest.first(), Some(b'+' | b'-')));
        let number = rest.get(sign..).unwrap_or_default();
        let length = number.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
        let digits = number.iter().take_while(|b| b.is_ascii_digit()).count();
        let number = rest.get(..sign + length).unwrap_or_default();
        // What follows a letter is a part of a name.
        let is_name = at >= 2 && self.text.get(at - 2).is_some_and(u8::is_ascii_alphabetic);
        let value = core::str::from_utf8(number).ok().and_then(|t| t.parse::<f64>().ok());
        match value {
            Some(value) if !is_name && self.words.len() < MAX_WORDS => {
                let is_whole = sign == 0 && digits == length;
                self.words.push(ScannedWord { letter, value, is_whole, digits });
            }
            Some(_) => {}
            None => self.is_odd |= rest.first().is_none_or(|b| !matches!(b, b'#' | b'[')),
        }
        at + sign + length
    }
}

/// Tells whether a comment acts in LinuxCNC only.
fn is_own_comment(comment: &[u8]) -> bool {
    let text = String::from_utf8_lossy(comment);
    !matches!(classify(&text).0, Kind::Plain | Kind::Message)
}

/// Tells whether a text is a part of another one.
pub(super) fn contains(whole: &[u8], part: &[u8]) -> bool {
    whole.len() >= part.len() && whole.windows(part.len()).any(|w| w == part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(text: &str) -> Scan {
        let mut out = Scan::default();
        out.line(text.as_bytes());
        out
    }

    #[test]
    fn a_line_is_taken_apart() {
        let line = scan("/N10 G05.1 Q1 X-3. (Hello) P200 ; There");
        assert_eq!(line.text, b"g05.1q1x-3.p200");
        assert_eq!(line.remarks, b"hello\n there\n");
        let words: Vec<_> = line.words.iter().map(|w| (w.letter, w.value, w.is_whole)).collect();
        assert_eq!(
            words,
            [(b'g', 5.1, false), (b'q', 1.0, true), (b'x', -3.0, false), (b'p', 200.0, true)]
        );
        assert_eq!(line.words[0].tenfold(), Some(51));
        assert!(!line.is_odd && !line.is_own);
    }

    #[test]
    fn numbers_of_lines_go_and_names_stay() {
        for (text, rest) in [
            ("12 BEGIN PGM A MM", "beginpgma" as &str),
            ("N5", ""),
            ("NAME", "name"),
            ("/ 7 L X+1", "lx+1"),
            ("$N0=G21", "$n0=g21"),
        ] {
            let line = scan(text);
            assert!(line.text.starts_with(rest.as_bytes()), "{text}: {:?}", line.text);
            assert!(!rest.is_empty() || line.text.is_empty());
        }
        assert!(scan("L X+1 R0 FMAX").is_odd && scan("$H").is_odd && scan("R1=5").is_odd);
        assert!(!scan("G1 X#1 Y[#2+SIN[3]]").is_odd);
    }

    #[test]
    fn words_that_only_linuxcnc_has_are_known() {
        for own in ["o<a> call", "O100 sub", "o[#1] IF [1]", "#<a>=1", "(debug, a)", "; LinuxCNC"] {
            assert!(scan(own).is_own, "{own}");
        }
        for other in ["O1234", "o100 (x)", "#100=1", "(MSG, a)", "(a remark)"] {
            assert!(!scan(other).is_own, "{other}");
        }
    }
}
