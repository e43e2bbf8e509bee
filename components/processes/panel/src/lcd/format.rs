//! Parser of `fmt_strings=`: text, escapes and formats of values, by pages.

use super::field::{Field, MAX_LEN};

/// Part of a page.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Literal character.
    Byte(u8),
    /// Line break: clears the rest of the line and begins the next.
    NewLine,
    /// Four blanks.
    Tab,
    /// Formatted value.
    Value(Kind, Field),
}

/// Type of a value, and its notation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Float with decimals.
    Float,
    /// Signed integer.
    Signed,
    /// Unsigned integer, in this base.
    Unsigned(u64),
    /// Character given by its code, repeated over the field.
    Character,
    /// Character for true, and character for false.
    Bit(u8, u8),
}

/// Default number of decimals.
const DECIMALS: usize = 4;

/// Parses the pages of one display.
pub(super) fn read(text: &str) -> Result<Vec<Vec<Part>>, String> {
    if text.is_empty() {
        return Err("there is nothing to show".to_owned());
    }
    text.split('|').map(page).collect()
}

fn page(text: &str) -> Result<Vec<Part>, String> {
    let (mut parts, mut rest) = (Vec::new(), text.as_bytes());
    while let Some((first, after)) = rest.split_first() {
        let part;
        (part, rest) = match first {
            b'\\' => escape(after)?,
            b'%' => value(after)?,
            byte => (Part::Byte(*byte), after),
        };
        parts.push(part);
    }
    Ok(parts)
}

/// Parses the part after a backslash.
fn escape(rest: &[u8]) -> Result<(Part, &[u8]), String> {
    match rest {
        [b'n' | b'N', after @ ..] => Ok((Part::NewLine, after)),
        [b't' | b'T', after @ ..] => Ok((Part::Tab, after)),
        _ => code(rest).map(|(byte, after)| (Part::Byte(byte), after)),
    }
}

/// Parses the part after the backslash of a single character.
fn code(rest: &[u8]) -> Result<(u8, &[u8]), String> {
    let digit = |d: &u8| char::from(*d).to_digit(16).and_then(|d| u8::try_from(d).ok());
    match rest {
        [b'\\', after @ ..] => Ok((b'\\', after)),
        [high, low, after @ ..] if digit(high).is_some() && digit(low).is_some() => {
            Ok((digit(high).unwrap_or(0) << 4 | digit(low).unwrap_or(0), after))
        }
        _ => {
            Err("after a backslash there is n, t, another one, or two hexadecimal digits"
                .to_owned())
        }
    }
}

/// Parses the part after a percent sign.
fn value(mut rest: &[u8]) -> Result<(Part, &[u8]), String> {
    if let [b'%', after @ ..] = rest {
        return Ok((Part::Byte(b'%'), after));
    }
    let mut field = Field { decimals: DECIMALS, ..Field::default() };
    while let [flag @ (b' ' | b'0' | b'+' | b'-'), after @ ..] = rest {
        field.zeros |= *flag == b'0';
        field.plus |= *flag == b'+';
        rest = after;
    }
    if let Some(width) = number(&mut rest) {
        if !(1..=MAX_LEN).contains(&width) {
            return Err(format!("a width is 1 to {MAX_LEN}, and {width} is not"));
        }
        field.width = width;
    }
    let mut given = None;
    if let [b'.', after @ ..] = rest {
        rest = after;
        given = number(&mut rest);
    }
    let Some((letter, mut after)) = rest.split_first() else {
        return Err("a % ends it without a letter of a format".to_owned());
    };
    let kind = match letter {
        b'f' | b'F' => {
            let most = if field.width == 0 { MAX_LEN } else { field.width } - 1;
            field.decimals = given.unwrap_or(DECIMALS);
            if field.decimals > most {
                let n = field.decimals;
                return Err(format!("{n} decimals are too many: here there is room for {most}"));
            }
            Kind::Float
        }
        b'i' | b'd' => Kind::Signed,
        b'u' => Kind::Unsigned(10),
        b'x' | b'X' => Kind::Unsigned(16),
        b'o' => Kind::Unsigned(8),
        b'c' => Kind::Character,
        b'b' => {
            let (yes, no);
            (yes, after) = character(after)?;
            (no, after) = character(after)?;
            Kind::Bit(yes, no)
        }
        other => {
            let letter = char::from(*other);
            return Err(format!("'{letter}' is no format; there are f, i, d, u, x, o, c and b"));
        }
    };
    Ok((Part::Value(kind, field), after))
}

/// Parses one of the two characters that show a bit.
fn character(rest: &[u8]) -> Result<(u8, &[u8]), String> {
    match rest {
        [b'\\', after @ ..] => code(after),
        [byte, after @ ..] => Ok((*byte, after)),
        [] => Err("after %b there are two characters, for true and for false".to_owned()),
    }
}

/// Parses a decimal number, which saturates at the maximum.
fn number(rest: &mut &[u8]) -> Option<usize> {
    let mut number = None;
    while let [digit @ b'0'..=b'9', after @ ..] = *rest {
        let so_far: usize = number.unwrap_or(0);
        number = Some(so_far.saturating_mul(10).saturating_add(usize::from(digit - b'0')));
        *rest = after;
    }
    number
}

#[cfg(test)]
mod tests {
    use super::{Field, Kind, Part, read};

    fn field(width: usize, zeros: bool, plus: bool, decimals: usize) -> Field {
        Field { width, zeros, plus, decimals }
    }

    #[test]
    fn pages() {
        let plain = |c: char| Part::Byte(c as u8);
        let value = |kind, width, zeros, plus, decimals| {
            Part::Value(kind, field(width, zeros, plus, decimals))
        };
        for (text, page) in [
            ("a%%b", vec![plain('a'), plain('%'), plain('b')]),
            (
                r"\n\t\\\7c\FF",
                vec![Part::NewLine, Part::Tab, plain('\\'), plain('|'), Part::Byte(255)],
            ),
            ("%f", vec![value(Kind::Float, 0, false, false, 4)]),
            ("%+09.3f", vec![value(Kind::Float, 9, true, true, 3)]),
            ("%+ 4d!", vec![value(Kind::Signed, 4, false, true, 4), plain('!')]),
            ("%8.f", vec![value(Kind::Float, 8, false, false, 4)]),
            ("%08u", vec![value(Kind::Unsigned(10), 8, true, false, 4)]),
            (
                "%X%o",
                vec![
                    value(Kind::Unsigned(16), 0, false, false, 4),
                    value(Kind::Unsigned(8), 0, false, false, 4),
                ],
            ),
            ("%20c", vec![value(Kind::Character, 20, false, false, 4)]),
            (
                r"%b\FF %b10",
                vec![
                    value(Kind::Bit(255, b' '), 0, false, false, 4),
                    value(Kind::Bit(b'1', b'0'), 0, false, false, 4),
                ],
            ),
        ] {
            assert_eq!(read(text).unwrap(), [page], "{text}");
        }
        let sizes = |t| read(t).unwrap().iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!(sizes("ab|c|"), [2, 1, 0]);
        assert_eq!(sizes("|a"), [0, 1]);
    }

    #[test]
    fn refusals() {
        for (text, why) in [
            ("", "there is nothing to show"),
            ("a%", "a % ends it without a letter of a format"),
            ("%5.2", "a % ends it without a letter of a format"),
            ("a%|b", "a % ends it without a letter of a format"),
            ("%q", "'q' is no format; there are f, i, d, u, x, o, c and b"),
            ("%ld", "'l' is no format; there are f, i, d, u, x, o, c and b"),
            ("%21i", "a width is 1 to 20, and 21 is not"),
            ("%99999999999999999999999i", "a width is 1 to 20, and 18446744073709551615 is not"),
            ("%3.3f", "3 decimals are too many: here there is room for 2"),
            ("%4f", "4 decimals are too many: here there is room for 3"),
            ("%.20f", "20 decimals are too many: here there is room for 19"),
            (r"\", "after a backslash there is n, t, another one, or two hexadecimal digits"),
            (r"\4", "after a backslash there is n, t, another one, or two hexadecimal digits"),
            (r"\4g", "after a backslash there is n, t, another one, or two hexadecimal digits"),
            ("%b", "after %b there are two characters, for true and for false"),
            ("%b1", "after %b there are two characters, for true and for false"),
            (r"%b1\n", "after a backslash there is n, t, another one, or two hexadecimal digits"),
        ] {
            assert_eq!(read(text).unwrap_err(), why, "{text}");
        }
    }
}
