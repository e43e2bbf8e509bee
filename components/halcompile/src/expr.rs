//! Expressions over an instance's personality: sizes of arrays, and which instances have an item.

use crate::{
    Problem,
    token::{Miss, Parsed, fail, keyword, sign, stop, then_blank, whole},
};
use core::fmt;
use nom::{Parser, branch::alt, combinator::opt};

/// How deep parentheses may be nested.
const DEEP: usize = 40;

/// An expression; its value is a whole number, and every one but 0 is true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expr {
    /// A number.
    Number(i128),
    /// The instance's personality.
    Personality,
    /// Two values and what is between them.
    Pair(Box<Expr>, Sign, Box<Expr>),
    /// `a ? b : c`.
    Choice(Box<Expr>, Box<Expr>, Box<Expr>),
}

/// A sign between two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sign {
    /// As written; C and Rust agree on all of them.
    pub text: &'static str,
    /// How closely it binds.
    binds: u8,
    /// What its value is.
    pub gives: Gives,
}

/// What comes of a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gives {
    /// A number, from numbers.
    Number,
    /// Yes or no, from numbers.
    Truth,
    /// Yes or no, from such.
    Both,
}

/// Every sign, longer ones before those that they begin with.
const SIGNS: &[Sign] = &[
    Sign { text: "&&", binds: 2, gives: Gives::Both },
    Sign { text: "||", binds: 1, gives: Gives::Both },
    Sign { text: "==", binds: 4, gives: Gives::Truth },
    Sign { text: "!=", binds: 4, gives: Gives::Truth },
    Sign { text: "<<", binds: 6, gives: Gives::Number },
    Sign { text: "<=", binds: 5, gives: Gives::Truth },
    Sign { text: "<", binds: 5, gives: Gives::Truth },
    Sign { text: ">>", binds: 6, gives: Gives::Number },
    Sign { text: ">=", binds: 5, gives: Gives::Truth },
    Sign { text: ">", binds: 5, gives: Gives::Truth },
    Sign { text: "&", binds: 3, gives: Gives::Number },
    Sign { text: "+", binds: 7, gives: Gives::Number },
    Sign { text: "-", binds: 7, gives: Gives::Number },
    Sign { text: "*", binds: 8, gives: Gives::Number },
    Sign { text: "/", binds: 8, gives: Gives::Number },
];

impl Expr {
    /// Whether a personality is asked for at all.
    #[must_use]
    pub fn asks(&self) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Personality => true,
            Self::Pair(a, _, b) => a.asks() || b.asks(),
            Self::Choice(a, b, c) => a.asks() || b.asks() || c.asks(),
        }
    }

    /// Its value for a personality; none where C has none.
    #[must_use]
    pub fn value(&self, personality: i64) -> Option<i64> {
        let truth = |t: bool| Some(i64::from(t));
        match self {
            Self::Number(n) => i64::try_from(*n).ok(),
            Self::Personality => Some(personality),
            Self::Choice(a, b, c) => {
                if a.value(personality)? == 0 { c } else { b }.value(personality)
            }
            Self::Pair(a, sign, b) => {
                let a = a.value(personality)?;
                if sign.text == "&&" && a == 0 || sign.text == "||" && a != 0 {
                    return truth(a != 0);
                }
                let b = b.value(personality)?;
                match sign.text {
                    "&&" | "||" => truth(b != 0),
                    "==" => truth(a == b),
                    "!=" => truth(a != b),
                    "<" => truth(a < b),
                    "<=" => truth(a <= b),
                    ">" => truth(a > b),
                    ">=" => truth(a >= b),
                    "<<" => a.checked_shl(u32::try_from(b).ok()?),
                    ">>" => a.checked_shr(u32::try_from(b).ok()?),
                    "&" => Some(a & b),
                    "+" => a.checked_add(b),
                    "-" => a.checked_sub(b),
                    "*" => a.checked_mul(b),
                    _ => a.checked_div(b),
                }
            }
        }
    }
}

/// As C text: every part in parentheses.
impl fmt::Display for Expr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(n) if *n < 0 => write!(f, "({n})"),
            Self::Number(n) => write!(f, "{n}"),
            Self::Personality => f.write_str("personality"),
            Self::Pair(a, sign, b) => write!(f, "({a} {} {b})", sign.text),
            Self::Choice(a, b, c) => write!(f, "({a} ? {b} : {c})"),
        }
    }
}

/// An expression.
pub(crate) fn expr(input: &str) -> Parsed<'_, Expr> {
    choice(input, 0)
}

fn choice(input: &str, depth: usize) -> Parsed<'_, Expr> {
    if depth > DEEP {
        return stop(Miss::problem(input, 1, Problem::TooDeep));
    }
    let (rest, first) = pair(input, 1, depth)?;
    let (rest, Some(_)) = opt(sign("?", "'?'")).parse(rest)? else { return Ok((rest, first)) };
    let (rest, yes) = must(choice(rest, depth + 1))?;
    let (rest, _) = must(sign(":", "':'")(rest))?;
    let (rest, no) = must(choice(rest, depth + 1))?;
    Ok((rest, Expr::Choice(Box::new(first), Box::new(yes), Box::new(no))))
}

/// Everything that binds at least so closely; equal signs from left to right.
fn pair(input: &str, least: u8, depth: usize) -> Parsed<'_, Expr> {
    let (mut rest, mut left) = single(input, depth)?;
    let mut long = 0;
    loop {
        let next = SIGNS.iter().find(|s| rest.starts_with(s.text)).filter(|s| s.binds >= least);
        let Some(found) = next else { return Ok((rest, left)) };
        long += 1;
        if long > DEEP {
            return stop(Miss::problem(rest, 1, Problem::TooDeep));
        }
        let (after, _) = sign(found.text, "an operator")(rest)?;
        let (after, right) = must(pair(after, found.binds + 1, depth))?;
        left = Expr::Pair(Box::new(left), *found, Box::new(right));
        rest = after;
    }
}

fn single(input: &str, depth: usize) -> Parsed<'_, Expr> {
    if let (rest, Some(_)) = opt(sign("(", "'('")).parse(input)? {
        let (rest, inside) = must(choice(rest, depth + 1))?;
        let (rest, _) = must(sign(")", "')' or an operator")(rest))?;
        return Ok((rest, inside));
    }
    let number = then_blank(whole).map(Expr::Number);
    let personality = keyword("personality", "'personality'").map(|_| Expr::Personality);
    let open = |i| fail(Miss::wanted(i, "'('"));
    alt((number, personality, open)).parse(input)
}

/// There is no way back: what is missing is what is wrong.
fn must<T>(parsed: Parsed<'_, T>) -> Parsed<'_, T> {
    parsed.map_err(|e| match e {
        nom::Err::Error(miss) => nom::Err::Failure(miss),
        other => other,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_bind_as_in_c() {
        let of = |t| expr(t).map(|(rest, e)| (e.to_string(), rest)).unwrap();
        assert_eq!(of("personality & 3 == 1 ;"), ("(personality & (3 == 1))".into(), ";"));
        assert_eq!(of("(personality>>2)&7"), ("((personality >> 2) & 7)".into(), ""));
        assert_eq!(of("1+2*3-4"), ("((1 + (2 * 3)) - 4)".into(), ""));
        assert_eq!(
            of("personality&1||personality<4&&1 ? 2 : 0x10"),
            ("(((personality & 1) || ((personality < 4) && 1)) ? 2 : 16)".into(), "")
        );
    }

    #[test]
    fn values_as_in_c() {
        let of = |t, p| expr(t).unwrap().1.value(p);
        assert_eq!(of("(personality>>4)&15", 0x53), Some(5));
        assert_eq!(of("personality > 2 ? 8 : personality * 2", 2), Some(4));
        assert_eq!(of("8 / personality", 0), None);
        assert_eq!(of("personality && 8 / personality", 0), Some(0));
    }

    #[test]
    fn depth_is_bounded() {
        for text in ["(".repeat(100_000), "1+".repeat(100_000), "1?1:".repeat(100_000)] {
            assert!(expr(&text).is_err());
        }
    }
}
