//! O-words: the words of flow control and their arguments.

use crate::{
    error::Problem,
    text::{
        Input, Parsed,
        expression::{Expr, angled, bracketed, left, value},
        fail,
        number::unsigned,
    },
};

/// The most arguments of a call.
pub const MAX_ARGUMENTS: usize = 30;

/// The label of an O-word.
#[derive(Clone, Debug, PartialEq)]
pub enum Label {
    /// `o<name>` or `o123`.
    Name(Box<str>),
    /// `o[expression]` or `o#n`: the value is the number.
    Computed(Box<Expr>),
}

/// The keyword of an O-word, with its expressions.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names are the keywords")]
pub enum Action {
    Sub,
    Endsub(Option<Expr>),
    Return(Option<Expr>),
    Call(Vec<Expr>),
    Do,
    While(Expr),
    Endwhile,
    If(Expr),
    Elseif(Expr),
    Else,
    Endif,
    Repeat(Expr),
    Endrepeat,
    Break,
    Continue,
    /// `o123` alone: the begin of a program part for M98.
    Bare,
}

/// An O-word with its label.
#[derive(Clone, Debug, PartialEq)]
pub struct OWord {
    /// The label.
    pub label: Label,
    /// The action.
    pub action: Action,
}

/// The keywords; a longer one comes before its beginning.
const KEYWORDS: [&str; 15] = [
    "sub",
    "endsub",
    "return",
    "call",
    "do",
    "endwhile",
    "while",
    "if",
    "elseif",
    "else",
    "endif",
    "repeat",
    "endrepeat",
    "break",
    "continue",
];

/// Reads the label behind `o`.
pub fn label(input: Input<'_>) -> Parsed<'_, Label> {
    match input {
        [b'<', ..] => {
            let (rest, name) = angled(input)?;
            Ok((rest, Label::Name(name)))
        }
        [b'[' | b'#', ..] => {
            let (rest, expr) = value(input)?;
            Ok((rest, Label::Computed(Box::new(expr))))
        }
        _ => {
            let (rest, n) = unsigned(input)?;
            Ok((rest, Label::Name(n.to_string().into())))
        }
    }
}

/// Returns the keyword that `input` begins with.
pub fn keyword(input: Input<'_>) -> Option<&'static str> {
    KEYWORDS.iter().copied().find(|k| input.starts_with(k.as_bytes()))
}

/// Reads the keyword and its arguments.
pub fn action(input: Input<'_>) -> Parsed<'_, Action> {
    if matches!(input.first(), None | Some(b'(' | b';')) {
        return Ok((input, Action::Bare));
    }
    let Some(word) = keyword(input) else {
        return fail(input, Problem::UnknownOCommand);
    };
    let rest = input.get(word.len()..).unwrap_or_default();
    match word {
        "endsub" | "return" => {
            let (rest, result) = match rest.first() {
                Some(b'[') => {
                    let (rest, e) = bracketed(rest)?;
                    (rest, Some(e))
                }
                _ => (rest, None),
            };
            let made = if word == "endsub" { Action::Endsub } else { Action::Return };
            Ok((rest, made(result)))
        }
        "call" => arguments(rest),
        "while" | "if" | "elseif" | "repeat" => {
            let (rest, e) = bracketed(rest)?;
            let action = match word {
                "while" => Action::While(e),
                "if" => Action::If(e),
                "elseif" => Action::Elseif(e),
                _ => Action::Repeat(e),
            };
            Ok((rest, action))
        }
        "sub" => Ok((rest, Action::Sub)),
        "do" => Ok((rest, Action::Do)),
        "endwhile" => Ok((rest, Action::Endwhile)),
        "else" => Ok((rest, Action::Else)),
        "endif" => Ok((rest, Action::Endif)),
        "endrepeat" => Ok((rest, Action::Endrepeat)),
        "break" => Ok((rest, Action::Break)),
        _ => Ok((rest, Action::Continue)),
    }
}

fn arguments(input: Input<'_>) -> Parsed<'_, Action> {
    let mut rest = input;
    let mut list = Vec::new();
    loop {
        match rest.first() {
            Some(b'[') => {
                if list.len() == MAX_ARGUMENTS {
                    return fail(rest, Problem::TooManyArguments);
                }
                let (after, e) = bracketed(rest)?;
                list.push(e);
                rest = after;
            }
            Some(b'(') => {
                let end = rest.iter().position(|b| *b == b')').map_or(rest.len(), |p| p + 1);
                rest = rest.get(end..).unwrap_or_default();
            }
            _ => return Ok((rest, Action::Call(list))),
        }
    }
}

/// Returns where a value stands, for errors of its evaluation.
pub fn place(input: Input<'_>) -> u32 {
    left(input)
}
