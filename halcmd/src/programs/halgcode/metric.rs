//! Inches into millimetres.

use super::tokens::{Token, Value, Word};
use hal_gcode::text::clean;

/// The modal codes that say what a word means.
pub(super) struct Metric {
    inch: bool,
    /// Ten times the G code of motion.
    motion: u16,
    inverse: bool,
    surface: bool,
}

/// Unit of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counts {
    /// Inches.
    Length,
    /// Feet.
    Feet,
    /// Something else.
    Other,
}

/// The codes of a line.
#[derive(Default)]
struct Codes {
    g: Vec<u16>,
    m: Vec<u16>,
    l: Option<f64>,
}

impl Codes {
    fn has(&self, code: u16) -> bool {
        self.g.contains(&code)
    }
}

impl Metric {
    /// Begins a program. It begins in inches unless its first unit is G21.
    pub(super) fn new(raw: &[u8]) -> Self {
        Self { inch: !begins_metric(raw), motion: 800, inverse: false, surface: false }
    }

    /// Changes the tokens of a line.
    ///
    /// # Errors
    /// A value comes from the machine, so its unit would change with the program's.
    pub(super) fn line(&mut self, tokens: &mut [Token]) -> Result<(), String> {
        let codes = codes(tokens)?;
        let was_inch = self.inch;
        for code in &codes.g {
            match code {
                200 => self.inch = true,
                210 => self.inch = false,
                930 => self.inverse = true,
                940 | 950 => self.inverse = false,
                960 => self.surface = true,
                970 => self.surface = false,
                0..=39 | 50..=53 | 330 | 331 | 382..=385 | 700..=890 => self.motion = *code,
                _ => {}
            }
        }
        for token in tokens.iter_mut() {
            match token {
                Token::Word(word) if word.letter == 'G' && word.value.number == Some(20.0) => {
                    word.value = Value { text: "21".into(), number: Some(21.0) };
                }
                Token::Word(word) if self.inch => {
                    let counts = self.counts(word, &codes);
                    convert(word, counts)?;
                }
                // The feed and the speed of a line are read before its unit.
                Token::Word(word) if was_inch && matches!(word.letter, 'F' | 'S') => {
                    let counts = self.counts(word, &codes);
                    convert(word, counts)?;
                }
                Token::Assignment { target, value } if self.inch => machine_value(target)
                    .or_else(|| machine_value(&value.text))
                    .map_or(Ok(()), |name| Err(refusal(&name)))?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns what a word counts on a line with these codes.
    fn counts(&self, word: &Word, codes: &Codes) -> Counts {
        use Counts::{Feet, Length, Other};
        let table = codes.has(100) && matches!(codes.l, Some(1.0 | 10.0 | 11.0));
        let length = |yes: bool| if yes { Length } else { Other };
        let motion = self.motion;
        let profile = matches!(motion, 700..=722);
        let other_q = codes.m.iter().any(|m| matches!(m, 19 | 61 | 66..=68 | 98 | 100..));
        match word.letter {
            'X' | 'Y' | 'Z' | 'U' | 'V' | 'W' | '@' | 'K' => Length,
            'I' => length(!table && motion != 331),
            'J' => length(!table),
            'R' if codes.has(100) => length(table),
            'R' => length(!codes.m.contains(&19) && motion != 760),
            'P' | 'Q' if codes.has(640) => Length,
            'Q' => length(!other_q && !codes.has(100) && matches!(motion, 50 | 730 | 830)),
            'P' => {
                length(!other_q && !codes.has(40) && !codes.has(100) && matches!(motion, 50 | 760))
            }
            'E' => length(motion == 760 || profile),
            'D' => length(codes.has(411) || codes.has(421) || profile),
            'F' => length(!self.inverse),
            'S' if self.surface => Feet,
            _ => Other,
        }
    }
}

/// Tells whether the first unit of a program is G21.
fn begins_metric(raw: &[u8]) -> bool {
    let mut cleaned = Vec::new();
    for line in raw.split(|b| *b == b'\n') {
        if clean::clean(line, &mut cleaned).is_err() {
            continue;
        }
        let Some(tokens) = super::tokens::tokens(line) else { continue };
        let unit = tokens.iter().find_map(|t| match t {
            Token::Word(w) if w.letter == 'G' => {
                w.value.number.filter(|n| *n == 20.0 || *n == 21.0)
            }
            _ => None,
        });
        if let Some(unit) = unit {
            return unit == 21.0;
        }
    }
    false
}

fn codes(tokens: &[Token]) -> Result<Codes, String> {
    let mut out = Codes::default();
    for token in tokens {
        let Token::Word(word) = token else { continue };
        if !matches!(word.letter, 'G' | 'M' | 'L') {
            continue;
        }
        let Some(number) = word.value.number else {
            return Err(format!(
                "{}{} is computed: which unit follows cannot be known",
                word.letter, word.value.text
            ));
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "other numbers are no codes"
        )]
        let tenfold = (number * 10.0).round() as u16;
        match word.letter {
            'G' => out.g.push(tenfold),
            'M' => out.m.push(tenfold / 10),
            _ => out.l = Some(number),
        }
    }
    Ok(out)
}

fn refusal(name: &str) -> String {
    format!(
        "{name} is the machine's, in the unit of the program: it cannot be turned into millimetres"
    )
}

/// Returns a parameter in an expression whose value is a length of the machine.
fn machine_value(text: &str) -> Option<String> {
    for part in text.split('#').skip(1) {
        if let Some(name) = part.strip_prefix('<') {
            let name = name.split('>').next().unwrap_or_default();
            let letter =
                name.strip_prefix("_abs_").or_else(|| name.strip_prefix('_')).unwrap_or_default();
            if matches!(letter, "x" | "y" | "z" | "u" | "v" | "w" | "feed") {
                return Some(format!("#<{name}>"));
            }
            continue;
        }
        let digits: String = part.chars().take_while(char::is_ascii_digit).collect();
        if matches!(
            digits.parse::<u32>(),
            Ok(5061..=5069 | 5161..=5390 | 5401..=5410 | 5420..=5428)
        ) {
            return Some(format!("#{digits}"));
        }
    }
    None
}

fn convert(word: &mut Word, counts: Counts) -> Result<(), String> {
    let (factor, decimals, text) = match counts {
        Counts::Length => (254, 1, "25.4"),
        Counts::Feet => (3048, 4, "0.3048"),
        Counts::Other => return Ok(()),
    };
    if word.value.number.is_none() {
        if let Some(name) = machine_value(&word.value.text) {
            return Err(refusal(&name));
        }
        word.value.text = format!("[{}*{text}]", word.value.text);
        return Ok(());
    }
    let product = exact(&word.value.text, factor, decimals);
    let product =
        product.ok_or_else(|| format!("{}{}: too many digits", word.letter, word.value.text))?;
    word.value = Value { number: product.parse().ok(), text: product };
    Ok(())
}

/// Multiplies a decimal number exactly by `factor` / 10^`decimals`.
fn exact(text: &str, factor: i128, decimals: usize) -> Option<String> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", text.trim_start_matches('+')),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa: i128 = format!("0{whole}{fraction}").parse().ok()?;
    let product = mantissa.checked_mul(factor)?.to_string();
    let places = fraction.len() + decimals;
    let padded = format!("{product:0>width$}", width = places + 1);
    let (whole, fraction) = padded.split_at_checked(padded.len() - places)?;
    Some(format!("{sign}{whole}.{fraction}"))
}

#[cfg(test)]
mod tests {
    use super::super::format::{Numbers, format};
    use super::exact;

    fn metric(text: &str) -> Result<String, (u32, String)> {
        let out = format(text.as_bytes(), Numbers::Keep, true, &mut Vec::new())?;
        Ok(String::from_utf8(out).unwrap())
    }

    #[test]
    fn words_that_count_inches_are_turned_and_others_stay() {
        let rows = [
            ("g20 g0 x1 y-.5 a90", "G21 G0 X25.4 Y-12.7 A90"),
            ("g2 x1 i0.25 p3 f10", "G2 X25.4 I6.35 P3 F254"),
            ("g83 z-1 r.1 q.05 p2 l3", "G83 Z-25.4 R2.54 Q1.27 P2 L3"),
            ("g64 p0.001 q.0005", "G64 P0.0254 Q0.0127"),
            ("g10 l2 p1 x1 r30", "G10 L2 P1 X25.4 R30"),
            ("g10 l1 p1 x1 r.5 i30 j60 q2", "G10 L1 P1 X25.4 R12.7 I30 J60 Q2"),
            ("g93 g1 x1 f2", "G93 G1 X25.4 F2"),
            ("g96 s100 d2000", "G96 S30.48 D2000"),
            ("g41.1 d.25", "G41.1 D6.35"),
            ("m67 e1 q2", "M67 E1 Q2"),
            ("g33.1 z1 k.05 i2", "G33.1 Z25.4 K1.27 I2"),
            ("g1 x#1 y[#2+1]", "G1 X[#1*25.4] Y[[#2+1]*25.4]"),
            ("#<a>=3 (#<a> inches)", "#<a>=3 (#<a> inches)"),
            ("g4 p2", "G4 P2"),
            ("g21 x1\nx2", "G21 X1\nX2"),
        ];
        for (text, wanted) in rows {
            assert_eq!(metric(text).as_deref(), Ok(&*format!("{wanted}\n")), "{text}");
        }
        assert_eq!(metric("g0 x1\ng21 x1\n").unwrap(), "G0 X1\nG21 X1\n");
        assert!(metric("g20\ng0 x[#5420+1]").unwrap_err().1.starts_with("#5420 is the machine's"));
        assert!(metric("g#1").unwrap_err().1.starts_with("G#1 is computed"));
    }

    #[test]
    fn decimals_are_exact() {
        assert_eq!(exact("0.1", 254, 1).as_deref(), Some("2.54"));
        assert_eq!(exact("-123456.789", 254, 1).as_deref(), Some("-3135802.4406"));
        assert_eq!(exact(".001", 254, 1).as_deref(), Some("0.0254"));
        assert_eq!(exact(&"9".repeat(60), 254, 1), None);
    }
}
