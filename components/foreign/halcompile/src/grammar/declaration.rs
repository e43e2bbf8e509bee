//! Parsers of each declaration, after its keyword.

use super::{File, doc, end, must};
use crate::{
    Problem,
    expr::{Expr, expr},
    token::{
        Miss, Parsed, blank, c_word, fail, hal_word, keyword, real, sign, stop, text, then_blank,
        whole,
    },
    tree::{
        Array, At, Declaration, Direction, Function, Item, KINDS, Kind, ModParam, OptionLine,
        Value, Variable,
    },
};
use nom::{Parser, branch::alt, combinator::opt};

impl<'a> File<'a> {
    pub(super) fn item(
        self,
        directions: &'static [(&'static str, Direction)],
        input: &'a str,
    ) -> Parsed<'a, Declaration> {
        let (rest, direction) = must(one_of(directions, |(w, _)| w))(input)?;
        let (rest, kind) = must(one_of(KINDS, |k: &Kind| k.word))(rest)?;
        let (rest, name) = must(self.name(hal_word, "a name"))(rest)?;
        let (rest, array) = opt(|i| self.array(i)).parse(rest)?;
        let (rest, default) = opt(|i| self.default(i)).parse(rest)?;
        let (rest, condition) = opt(|i| self.condition(i)).parse(rest)?;
        let (rest, doc) = doc(rest)?;
        let free = doc.is_none();
        let others = [
            ("'[' and a size", free && array.is_none() && default.is_none() && condition.is_none()),
            ("'=' and a value", free && default.is_none() && condition.is_none()),
            ("'if' and an expression", free && condition.is_none()),
            ("a text in \"…\"", free),
        ];
        let (rest, ()) = end(&others, rest)?;
        let item =
            Item { direction: direction.1, kind: *kind, name, array, default, condition, doc };
        Ok((rest, Declaration::Item(item)))
    }

    fn array(self, input: &'a str) -> Parsed<'a, Array> {
        let (rest, _) = sign("[", "'['")(input)?;
        let (rest, max) = must(self.at(size))(rest)?;
        let (rest, size) = opt(|i| {
            let (rest, _) = sign(":", "':'")(i)?;
            must(expr)(rest)
        })
        .parse(rest)?;
        let wanted =
            if size.is_some() { "']' or an operator" } else { "':' and an expression, or ']'" };
        let (rest, _) = must(sign("]", wanted))(rest)?;
        Ok((rest, Array { max, size }))
    }

    fn default(self, input: &'a str) -> Parsed<'a, At<Value>> {
        let (rest, _) = sign("=", "'='")(input)?;
        must(self.at(value))(rest)
    }

    fn condition(self, input: &'a str) -> Parsed<'a, Expr> {
        let (rest, _) = keyword("if", "'if'")(input)?;
        must(expr)(rest)
    }

    pub(super) fn function(self, input: &'a str) -> Parsed<'a, Declaration> {
        let (rest, name) = must(self.name(hal_word, "the function's name"))(input)?;
        let fp = keyword("fp", "'fp'").map(|_| true);
        let (rest, fp) = opt(alt((fp, keyword("nofp", "'nofp'").map(|_| false)))).parse(rest)?;
        let (rest, doc) = doc(rest)?;
        let free = doc.is_none();
        let others = [
            ("'fp'", free && fp.is_none()),
            ("'nofp'", free && fp.is_none()),
            ("a text in \"…\"", free),
        ];
        let (rest, ()) = end(&others, rest)?;
        Ok((rest, Declaration::Function(Function { name, fp, doc })))
    }

    /// Parses a C type, its stars, and the name, which is the last word.
    pub(super) fn variable(self, input: &'a str) -> Parsed<'a, Declaration> {
        let (mut rest, first) = must(self.name(c_word, "a C type"))(input)?;
        let mut words = vec![first.value];
        let mut stars = 0;
        let name = loop {
            if let (after, Some(_)) = opt(sign("*", "'*'")).parse(rest)? {
                (rest, stars) = (after, stars + 1);
                continue;
            }
            let (after, word) = must(self.name(c_word, "the variable's name"))(rest)?;
            rest = after;
            if stars > 0
                || !matches!(rest.chars().next(), Some(c) if c == '*' || c == '_' || c.is_alphabetic())
            {
                break word;
            }
            words.push(word.value);
        };
        let bracket = |i| {
            let (rest, _) = sign("[", "'['")(i)?;
            let number = |i| whole(i).map(|(rest, n)| (rest, n.to_string()));
            let constant = |i| c_word(i).map(|(rest, w)| (rest, w.to_owned()));
            let size = |i| {
                alt((number, constant))
                    .parse(i)
                    .map_err(|_: nom::Err<Miss>| nom::Err::Failure(Miss::wanted(i, "a size")))
            };
            let (rest, size) = self.at(size)(rest)?;
            let (rest, _) = must(sign("]", "']'"))(rest)?;
            Ok((rest, size))
        };
        let (rest, array) = opt(bracket).parse(rest)?;
        let (rest, default) = opt(|i| self.default(i)).parse(rest)?;
        let others = [
            ("'[' and a size", array.is_none() && default.is_none()),
            ("'=' and a value", default.is_none()),
        ];
        let (rest, ()) = end(&others, rest)?;
        let default = default.map(|d| d.value);
        Ok((
            rest,
            Declaration::Variable(Variable {
                c_type: words.join(" "),
                stars,
                name,
                array,
                default,
            }),
        ))
    }

    pub(super) fn option(self, input: &'a str) -> Parsed<'a, Declaration> {
        let (rest, name) = must(self.name(c_word, "the option's name"))(input)?;
        // A C type of several words, such as `struct line`, counts as one name.
        let words = |i: &'a str| {
            let (mut rest, first) = c_word(i)?;
            let mut name = first.to_owned();
            while let Ok((after, ())) = blank(rest)
                && let Ok((after, word)) = c_word(after)
            {
                name = format!("{name} {word}");
                rest = after;
            }
            Ok((
                rest,
                match truth(&name) {
                    Some(truth) => Value::Truth(truth),
                    None => Value::Name(name),
                },
            ))
        };
        let any = |i: &'a str| {
            alt((text.map(Value::Text), real.map(Value::Real), whole.map(Value::Whole), words))
                .parse(i)
        };
        let (rest, value) = opt(self.at(any)).parse(rest)?;
        let (rest, ()) = end(&[("a value", value.is_none())], rest)?;
        Ok((rest, Declaration::Option(OptionLine { name, value })))
    }

    pub(super) fn include(self, input: &'a str) -> Parsed<'a, Declaration> {
        let header = |input: &'a str| {
            let close = match input.chars().next() {
                Some('<') => '>',
                Some('"') => '"',
                _ => return fail(Miss::wanted(input, "a header in \"…\" or <…>")),
            };
            let line = input.lines().next().unwrap_or_default();
            match line.get(1..).and_then(|l| l.find(close)) {
                Some(long) if long > 0 => {
                    let (header, rest) = input.split_at_checked(long + 2).unwrap_or_default();
                    Ok((rest, header.to_owned()))
                }
                _ => fail(Miss::wanted(input, "a header in \"…\" or <…>")),
            }
        };
        let (rest, header) = must(self.at(header))(input)?;
        let (rest, ()) = end(&[], rest)?;
        Ok((rest, Declaration::Include(header)))
    }

    pub(super) fn mod_param(self, input: &'a str) -> Parsed<'a, Declaration> {
        const TYPES: &[(&str, bool)] = &[("int", true), ("dummy", false)];
        let (rest, kind) = must(one_of(TYPES, |(w, _)| w))(input)?;
        let (rest, name) = must(self.name(c_word, "the parameter's name"))(rest)?;
        let (rest, default) = opt(|i| self.default(i)).parse(rest)?;
        let (rest, doc) = doc(rest)?;
        let free = doc.is_none();
        let (rest, ()) = end(
            &[("'=' and a value", free && default.is_none()), ("a text in \"…\"", free)],
            rest,
        )?;
        let default = default.map(|d| d.value);
        Ok((rest, Declaration::ModParam(ModParam { is_int: kind.1, name, default, doc })))
    }
}

/// Returns a parser that finds a row of a table by its word.
fn one_of<'a, T>(
    rows: &'static [T],
    word: fn(&T) -> &'static str,
) -> impl FnMut(&'a str) -> Parsed<'a, &'static T> {
    then_blank(move |input: &'a str| {
        let named = c_word(input).ok();
        match named.and_then(|(rest, n)| rows.iter().find(|r| word(r) == n).map(|r| (rest, r))) {
            Some(found) => Ok(found),
            None => {
                let mut miss = Miss::wanted(input, "");
                miss.wanted = rows.iter().map(word).collect();
                fail(miss)
            }
        }
    })
}

fn size(input: &str) -> Parsed<'_, u32> {
    match whole(input) {
        Ok((rest, n)) => match u32::try_from(n) {
            Ok(n) if n <= 65_536 => Ok((rest, n)),
            _ => {
                let long = input.len() - rest.len();
                let number = input.get(..long).unwrap_or_default().into();
                stop(Miss::problem(input, long, Problem::NumberTooLarge { number }))
            }
        },
        Err(nom::Err::Error(_)) => fail(Miss::wanted(input, "a size")),
        Err(e) => Err(e),
    }
}

fn value(input: &str) -> Parsed<'_, Value> {
    let named = |i| {
        c_word(i).map(|(rest, name)| {
            (rest, truth(name).map_or_else(|| Value::Name(name.to_owned()), Value::Truth))
        })
    };
    let none = |i| fail(Miss::wanted(i, "a value"));
    let mut parser = alt((real.map(Value::Real), whole.map(Value::Whole), named, none));
    match parser.parse(input) {
        Err(nom::Err::Error(_)) => fail(Miss::wanted(input, "a value")),
        other => other,
    }
}

fn truth(word: &str) -> Option<bool> {
    match word {
        "yes" | "true" | "TRUE" => Some(true),
        "no" | "false" | "FALSE" => Some(false),
        _ => None,
    }
}
