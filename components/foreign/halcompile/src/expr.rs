//! Expressions over an instance's personality: sizes of arrays, and conditions of items.

use crate::{
    Problem,
    token::{Miss, Parsed, fail, keyword, sign, stop, then_blank, whole},
};
use core::fmt;
use nom::{Parser, branch::alt, combinator::opt};

/// Maximum nesting depth of parentheses.
const DEEP: usize = 40;

/// Integer expression; every value but 0 is true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Expr {
    /// Integer literal.
    Number(i128),
    /// Personality of the instance.
    Personality,
    /// Two operands and their operator.
    Pair(Box<Expr>, Sign, Box<Expr>),
    /// `a ? b : c`.
    Choice(Box<Expr>, Box<Expr>, Box<Expr>),
}

/// Binary operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sign {
    /// Operator as written; C and Rust agree on all of them.
    pub text: &'static str,
    /// Precedence; a higher value binds tighter.
    binds: u8,
    /// Kind of the operator's operands and result.
    pub gives: Gives,
}

/// Kinds of operands and result of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gives {
    /// Number, from numbers.
    Number,
    /// Truth value, from numbers.
    Truth,
    /// Truth value, from truth values.
    Both,
}

/// All operators, longer ones before their own prefixes.
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
    /// Returns whether the expression uses the personality.
    #[must_use]
    pub fn asks(&self) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Personality => true,
            Self::Pair(a, _, b) => a.asks() || b.asks(),
            Self::Choice(a, b, c) => a.asks() || b.asks() || c.asks(),
        }
    }

    /// Returns the value for a personality, or `None` where C defines none.
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

/// Formats the expression as C text, with every part in parentheses.
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

/// Parses an expression.
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

/// Parses operators of at least this precedence; those of equal precedence associate to the left.
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

/// Turns an error into a failure: no alternative is tried, so the missing part is what is reported.
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
