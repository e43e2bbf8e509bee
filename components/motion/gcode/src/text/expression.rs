//! Expressions: numbers, parameters, functions, operators and brackets, as a tree.

use core::cell::Cell;

use crate::{
    error::Problem,
    text::{Input, Parsed, fail, number::number},
};

/// The deepest nesting of brackets, functions, signs and parameter marks.
pub const MAX_NESTING: u32 = 64;

/// The largest number of operators in one value; it bounds the depth of the tree.
pub const MAX_OPERATORS: u32 = 512;

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// Absolute value.
    Abs,
    /// Arc cosine in degrees.
    Acos,
    /// Arc sine in degrees.
    Asin,
    /// Cosine of degrees.
    Cos,
    /// Power of e.
    Exp,
    /// The largest integer that is not above the value.
    Fix,
    /// The smallest integer that is not below the value.
    Fup,
    /// Natural logarithm.
    Ln,
    /// The nearest integer, halves away from zero.
    Round,
    /// Sine of degrees.
    Sin,
    /// Square root.
    Sqrt,
    /// Tangent of degrees.
    Tan,
}

/// The functions of one argument, by name.
pub const FUNCTIONS: [(&str, Function); 12] = [
    ("abs", Function::Abs),
    ("acos", Function::Acos),
    ("asin", Function::Asin),
    ("cos", Function::Cos),
    ("exp", Function::Exp),
    ("fix", Function::Fix),
    ("fup", Function::Fup),
    ("ln", Function::Ln),
    ("round", Function::Round),
    ("sin", Function::Sin),
    ("sqrt", Function::Sqrt),
    ("tan", Function::Tan),
];

/// An operator between two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// `**`
    Power,
    /// `*`
    Times,
    /// `/`
    Divide,
    /// `mod`: the result is never negative.
    Modulo,
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `eq`, within 0.0001.
    Equal,
    /// `ne`
    NotEqual,
    /// `gt`
    Greater,
    /// `ge`
    GreaterOrEqual,
    /// `lt`
    Less,
    /// `le`
    LessOrEqual,
    /// `and`
    And,
    /// `or`
    Or,
    /// `xor`
    Xor,
}

/// The operators with their precedence; a higher one binds more tightly.
pub const OPERATORS: [(&str, Operator, u8); 15] = [
    ("**", Operator::Power, 5),
    ("*", Operator::Times, 4),
    ("/", Operator::Divide, 4),
    ("mod", Operator::Modulo, 4),
    ("+", Operator::Plus, 3),
    ("-", Operator::Minus, 3),
    ("eq", Operator::Equal, 2),
    ("ne", Operator::NotEqual, 2),
    ("gt", Operator::Greater, 2),
    ("ge", Operator::GreaterOrEqual, 2),
    ("lt", Operator::Less, 2),
    ("le", Operator::LessOrEqual, 2),
    ("and", Operator::And, 1),
    ("or", Operator::Or, 1),
    ("xor", Operator::Xor, 1),
];

/// The bytes that are left of a line at some place; they say where the place is.
pub type Left = u32;

/// The tree of an expression. Each node that can fail knows its place.
#[derive(Clone, Debug, PartialEq)]
pub enum Expr {
    /// A number.
    Number(f64),
    /// `#n`
    Numbered(Left, Box<Expr>),
    /// `#<name>`
    Named(Left, Box<str>),
    /// `exists[#<name>]`
    Exists(Box<str>),
    /// `exists[#n]`
    ExistsNumbered(Left, Box<Expr>),
    /// A function of one argument.
    Call(Left, Function, Box<Expr>),
    /// `atan[y]/[x]`
    Atan(Box<Expr>, Box<Expr>),
    /// A value with a minus sign.
    Negative(Box<Expr>),
    /// Two values and an operator.
    Binary(Left, Operator, Box<Expr>, Box<Expr>),
}

pub(crate) fn left(input: Input<'_>) -> Left {
    Left::try_from(input.len()).unwrap_or(Left::MAX)
}

/// Reads a value: a number, parameter, function or expression in brackets, with an optional sign.
pub fn value(input: Input<'_>) -> Parsed<'_, Expr> {
    value_at(input, 0, &Cell::new(0))
}

/// Reads `[expression]`.
pub fn bracketed(input: Input<'_>) -> Parsed<'_, Expr> {
    bracketed_at(input, 0, &Cell::new(0))
}

/// Reads the name of a parameter behind `#`: `<name>`.
pub fn angled(input: Input<'_>) -> Parsed<'_, Box<str>> {
    let Some((b'<', inner)) = input.split_first() else {
        return fail(input, Problem::NoName);
    };
    let Some(end) = inner.iter().position(|b| *b == b'>') else {
        return fail(input, Problem::UnclosedName);
    };
    let (name, rest) = inner.split_at_checked(end).unwrap_or((inner, &[]));
    if name.is_empty() || name.len() > 256 {
        return fail(input, Problem::NoName);
    }
    let name: Box<str> = String::from_utf8_lossy(name).into();
    Ok((rest.get(1..).unwrap_or_default(), name))
}

fn value_at<'a>(input: Input<'a>, depth: u32, operators: &Cell<u32>) -> Parsed<'a, Expr> {
    if depth > MAX_NESTING {
        return fail(input, Problem::NestedTooDeep { limit: MAX_NESTING });
    }
    match input {
        [b'[', ..] => bracketed_at(input, depth, operators),
        [b'#', rest @ ..] => parameter(rest, depth, operators),
        [b'+', next, ..] if !starts_number(*next) => {
            value_at(input.get(1..).unwrap_or_default(), depth + 1, operators)
        }
        [b'-', next, ..] if !starts_number(*next) => {
            let (rest, inner) = value_at(input.get(1..).unwrap_or_default(), depth + 1, operators)?;
            Ok((rest, Expr::Negative(Box::new(inner))))
        }
        [b'a'..=b'z', ..] => function(input, depth, operators),
        _ => {
            let (rest, n) = number(input)?;
            Ok((rest, Expr::Number(n)))
        }
    }
}

fn starts_number(byte: u8) -> bool {
    byte.is_ascii_digit() || byte == b'.'
}

fn parameter<'a>(input: Input<'a>, depth: u32, operators: &Cell<u32>) -> Parsed<'a, Expr> {
    let at = left(input).saturating_add(1);
    if input.first() == Some(&b'<') {
        let (rest, name) = angled(input)?;
        return Ok((rest, Expr::Named(at, name)));
    }
    let (rest, index) = value_at(input, depth + 1, operators)?;
    Ok((rest, Expr::Numbered(at, Box::new(index))))
}

fn function<'a>(input: Input<'a>, depth: u32, operators: &Cell<u32>) -> Parsed<'a, Expr> {
    if let Some(rest) = input.strip_prefix(b"exists") {
        return exists(rest, depth, operators);
    }
    if let Some(rest) = input.strip_prefix(b"atan") {
        let (rest, y) = bracketed_at(rest, depth + 1, operators)?;
        let Some((b'/', rest)) = rest.split_first() else {
            return fail(rest, Problem::AtanNeedsSlash);
        };
        let (rest, x) = match rest.first() {
            Some(b'[') => bracketed_at(rest, depth + 1, operators)?,
            _ => return fail(rest, Problem::AtanNeedsBracket),
        };
        return Ok((rest, Expr::Atan(Box::new(y), Box::new(x))));
    }
    for (name, function) in FUNCTIONS {
        if let Some(rest) = input.strip_prefix(name.as_bytes()) {
            let at = left(input);
            let (rest, inner) = bracketed_at(rest, depth + 1, operators)?;
            return Ok((rest, Expr::Call(at, function, Box::new(inner))));
        }
    }
    fail(input, Problem::UnknownWord { first: char::from(input.first().copied().unwrap_or(b'?')) })
}

/// Reads the parameter in brackets behind `exists`.
fn exists<'a>(input: Input<'a>, depth: u32, operators: &Cell<u32>) -> Parsed<'a, Expr> {
    let Some(rest) = input.strip_prefix(b"[") else {
        return fail(input, Problem::NoBracket);
    };
    let Some(inner) = rest.strip_prefix(b"#") else {
        return fail(rest, Problem::ExistsNeedsName);
    };
    let (after, found) = match parameter(inner, depth, operators)? {
        (after, Expr::Named(_, name)) => (after, Expr::Exists(name)),
        (after, Expr::Numbered(at, index)) => (after, Expr::ExistsNumbered(at, index)),
        _ => return fail(input, Problem::ExistsNeedsName),
    };
    match after.split_first() {
        Some((b']', after)) => Ok((after, found)),
        _ => fail(after, Problem::ExistsUnclosed),
    }
}

fn bracketed_at<'a>(input: Input<'a>, depth: u32, operators: &Cell<u32>) -> Parsed<'a, Expr> {
    if depth > MAX_NESTING {
        return fail(input, Problem::NestedTooDeep { limit: MAX_NESTING });
    }
    let Some((b'[', inner)) = input.split_first() else {
        return fail(input, Problem::NoBracket);
    };
    let (rest, tree) = sum(inner, 1, depth + 1, operators)?;
    match rest.split_first() {
        Some((b']', rest)) => Ok((rest, tree)),
        Some(_) => fail(rest, Problem::UnknownOperator),
        None => fail(rest, Problem::UnclosedExpression),
    }
}

/// Reads operands joined by operators of at least `least` precedence; equals join from the left.
fn sum<'a>(input: Input<'a>, least: u8, depth: u32, operators: &Cell<u32>) -> Parsed<'a, Expr> {
    let (mut rest, mut tree) = value_at(input, depth, operators)?;
    while let Some((length, operator, precedence)) = operator(rest) {
        if precedence < least {
            break;
        }
        operators.set(operators.get() + 1);
        if operators.get() > MAX_OPERATORS {
            return fail(rest, Problem::TooManyOperators { limit: MAX_OPERATORS });
        }
        let at = left(rest);
        let after = rest.get(length..).unwrap_or_default();
        let (next, right) = sum(after, precedence + 1, depth, operators)?;
        tree = Expr::Binary(at, operator, Box::new(tree), Box::new(right));
        rest = next;
    }
    Ok((rest, tree))
}

fn operator(input: Input<'_>) -> Option<(usize, Operator, u8)> {
    OPERATORS.iter().find_map(|(text, operator, precedence)| {
        input.starts_with(text.as_bytes()).then_some((text.len(), *operator, *precedence))
    })
}
