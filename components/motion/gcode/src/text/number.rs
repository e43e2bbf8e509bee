//! Decimal numbers: a sign, digits, one point; no exponent.

use nom::{Parser, bytes::complete::take_while, character::complete::one_of, combinator::opt};

use crate::{
    error::Problem,
    text::{Fault, Input, Parsed, fail},
};

/// The powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Reads a decimal number with an optional sign.
pub fn number(input: Input<'_>) -> Parsed<'_, f64> {
    let digits = || take_while::<_, Input<'_>, Fault<'_>>(|b: u8| b.is_ascii_digit());
    let (rest, sign) = opt(one_of("+-")).parse(input)?;
    let (rest, whole) = digits().parse(rest)?;
    let (rest, fraction) = match rest.split_first() {
        Some((b'.', after)) => digits().parse(after)?,
        _ => (rest, &[][..]),
    };
    if whole.is_empty() && fraction.is_empty() {
        return fail(input, missing(input, rest));
    }
    let value = exact(whole, fraction).unwrap_or_else(|| slow(whole, fraction));
    if !value.is_finite() {
        return fail(input, Problem::NumberTooLarge);
    }
    Ok((rest, if sign == Some('-') { -value } else { value }))
}

/// Returns the problem of a place without a number; `rest` is what follows its sign and point.
fn missing(input: Input<'_>, rest: Input<'_>) -> Problem {
    if input.is_empty() {
        return Problem::NoNumber;
    }
    let read = input.get(..input.len().saturating_sub(rest.len())).unwrap_or_default();
    Problem::NumberFormat { shown: String::from_utf8_lossy(read).into() }
}

/// Reads an unsigned integer, as line numbers and O-words have.
pub fn unsigned(input: Input<'_>) -> Parsed<'_, u32> {
    let (rest, digits) =
        take_while::<_, Input<'_>, Fault<'_>>(|b: u8| b.is_ascii_digit()).parse(input)?;
    if digits.is_empty() {
        return fail(input, Problem::BadUnsigned);
    }
    let mut value = 0u32;
    for d in digits {
        let next = value.checked_mul(10).and_then(|v| v.checked_add(u32::from(d - b'0')));
        match next {
            Some(v) => value = v,
            None => return fail(input, Problem::NumberTooLarge),
        }
    }
    Ok((rest, value))
}

/// Computes the value by one exactly rounded division, where digits and point allow it.
fn exact(whole: &[u8], fraction: &[u8]) -> Option<f64> {
    if whole.len() + fraction.len() > 15 {
        return None;
    }
    let digits = whole.iter().chain(fraction);
    let mantissa = digits.fold(0u64, |m, d| m * 10 + u64::from(d - b'0'));
    let scale = POWERS.get(fraction.len())?;
    Some(mantissa as f64 / scale)
}

fn slow(whole: &[u8], fraction: &[u8]) -> f64 {
    let mut text: Vec<u8> = vec![b'0'];
    text.extend(whole);
    text.push(b'.');
    text.extend(fraction);
    text.push(b'0');
    core::str::from_utf8(&text).ok().and_then(|t| t.parse().ok()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_as_the_standard_library_rounds() {
        for text in [
            "1",
            "-2.5",
            "+.5",
            "0.1",
            "123456.789",
            "3.",
            "99999999999999999999.1",
            "1234567890.1234567",
            "9007199254740993.5",
            "4025767862.0673558",
            "0.3000000000000000444",
            "5.000000000000000277",
        ] {
            let expected: f64 = text.parse().unwrap();
            let (rest, value) = number(text.as_bytes()).unwrap();
            assert!(rest.is_empty());
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
        }
    }

    #[test]
    fn numbers_have_no_exponent_and_one_point() {
        assert_eq!(number(b"1e5").unwrap(), (&b"e5"[..], 1.0));
        assert_eq!(number(b"1.2.3").unwrap(), (&b".3"[..], 1.2));
        assert!(number(b".").is_err());
        assert!(number(b"-").is_err());
        assert!(number("9".repeat(400).as_bytes()).is_err());
    }
}
