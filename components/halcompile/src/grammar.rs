//! The declarations: from text to a tree.

use crate::{
    Problem,
    expr::{Expr, expr},
    place::{Fault, Span},
    token::{
        Miss, Parsed, blank, c_word, fail, found, hal_word, keyword, real, sign, stop, text,
        then_blank, whole,
    },
    tree::{
        Array, At, Body, Declaration, Direction, Function, Item, KINDS, Kind, ModParam, OptionLine,
        TEXTS, Tree, Value, Variable,
    },
};
use nom::{Parser, branch::alt, combinator::opt};

/// How many faults of one file are told.
const MOST_FAULTS: usize = 20;

/// Reads a file; after a fault it goes on behind the next `;`.
///
/// # Errors
/// Everything that does not follow the grammar.
pub(crate) fn parse(source: &str) -> Result<Tree, Vec<Fault>> {
    let Some((head, body)) = split(source) else {
        let end = source.trim_end().len();
        let mut faults = declared(source).err().unwrap_or_default();
        faults.push(Fault { span: Span { start: end, end }, problem: Problem::NoSeparator });
        return Err(faults);
    };
    let (name, doc, declarations) = declared(head)?;
    Ok(Tree { name, doc, declarations, body })
}

/// The declarations, and the C text behind the line `;;`.
fn split(source: &str) -> Option<(&str, Body)> {
    let mut at = 0;
    for (i, line) in source.split_inclusive('\n').enumerate() {
        let next = at + line.len();
        if line.trim_end_matches(['\n', '\r']) == ";;" {
            let text = source.get(next..)?.replace("\r\n", "\n");
            return Some((source.get(..at)?, Body { text, line: i + 2 }));
        }
        at = next;
    }
    None
}

type Head = (At<String>, Option<String>, Vec<Declaration>);

fn declared(head: &str) -> Result<Head, Vec<Fault>> {
    let file = File { head };
    let mut faults = Vec::new();
    let mut named = None;
    let mut declarations = Vec::new();
    let mut rest = match blank(head) {
        Ok((rest, ())) => rest,
        Err(e) => return Err(vec![file.fault(e)]),
    };
    match file.component(rest) {
        Ok((after, found)) => (rest, named) = (after, Some(found)),
        Err(e) => {
            rest = recovered(rest, &e);
            faults.push(file.fault(e));
        }
    }
    while !rest.is_empty() && faults.len() < MOST_FAULTS {
        match file.declaration(rest) {
            Ok((after, found)) => {
                declarations.push(found);
                rest = after;
            }
            Err(e) => {
                rest = recovered(rest, &e);
                faults.push(file.fault(e));
            }
        }
    }
    match named {
        Some((name, doc)) if faults.is_empty() => Ok((name, doc, declarations)),
        _ => Err(faults),
    }
}

/// What follows the next `;` after a fault, texts and comments aside; nothing if they are the fault.
fn recovered<'a>(from: &'a str, error: &nom::Err<Miss>) -> &'a str {
    let at = match error {
        nom::Err::Error(miss) | nom::Err::Failure(miss) => from.len().saturating_sub(miss.left),
        nom::Err::Incomplete(_) => return "",
    };
    let mut rest = from.get(at..).unwrap_or_default();
    loop {
        let Some(next) = rest.find([';', '"', '/', '\n']) else { return "" };
        let (_, here) = rest.split_at_checked(next).unwrap_or_default();
        rest = match here.as_bytes().first() {
            Some(b';') => {
                let behind = here.get(1..).unwrap_or_default();
                return blank(behind).map_or("", |(rest, ())| rest);
            }
            // A line that begins with the word of a declaration ends what was wrong before it.
            Some(b'\n') => {
                let line = here.get(1..).unwrap_or_default();
                if next + at > 0 && WORDS.iter().any(|(w, _)| keyword(w, "")(line).is_ok()) {
                    return line;
                }
                line
            }
            Some(b'"') => text(here).map_or("", |(rest, _)| rest),
            _ => match blank(here) {
                Ok((after, ())) if after.len() < here.len() => after,
                Ok(_) => here.get(1..).unwrap_or_default(),
                Err(_) => return "",
            },
        };
    }
}

/// The words that declarations begin with, as messages name them.
const WORDS: &[(&str, &str)] = &[
    ("pin", "'pin'"),
    ("param", "'param'"),
    ("function", "'function'"),
    ("variable", "'variable'"),
    ("option", "'option'"),
    ("see_also", "'see_also'"),
    ("notes", "'notes'"),
    ("description", "'description'"),
    ("examples", "'examples'"),
    ("license", "'license'"),
    ("author", "'author'"),
    ("include", "'include'"),
    ("modparam", "'modparam'"),
];

/// Once the first word of a declaration has been read, what is missing is what is wrong.
fn must<'a, T>(
    mut parser: impl FnMut(&'a str) -> Parsed<'a, T>,
) -> impl FnMut(&'a str) -> Parsed<'a, T> {
    move |input| {
        parser(input).map_err(|e| match e {
            nom::Err::Error(miss) => nom::Err::Failure(miss),
            other => other,
        })
    }
}

/// The `;` of a declaration. What else could have stood there belongs to the message.
fn end<'a>(others: &[(&'static str, bool)], input: &'a str) -> Parsed<'a, ()> {
    if let Ok((rest, _)) = sign(";", "';'")(input) {
        return Ok((rest, ()));
    }
    let mut miss = Miss::wanted(input, "';'");
    let open = others.iter().filter(|(_, free)| *free).map(|(text, _)| *text);
    miss.wanted = open.chain(["';'"]).collect();
    stop(miss)
}

fn doc(input: &str) -> Parsed<'_, Option<String>> {
    opt(then_blank(text)).parse(input)
}

/// Where parsers find what byte of the file they are at.
#[derive(Clone, Copy)]
struct File<'a> {
    head: &'a str,
}

impl<'a> File<'a> {
    fn fault(self, error: nom::Err<Miss>) -> Fault {
        let (nom::Err::Error(miss) | nom::Err::Failure(miss)) = error else {
            return Fault { span: Span::default(), problem: Problem::NotText };
        };
        let mut start = self.head.len().saturating_sub(miss.left);
        let Miss { long, wanted, problem, .. } = miss;
        let problem = problem.map_or_else(
            || {
                let rest = self.head.get(start..).unwrap_or_default();
                let found = match found(rest) {
                    "" => "the end of the declarations".into(),
                    word => format!("'{word}'").into(),
                };
                Problem::Expected { wanted, found }
            },
            |problem| *problem,
        );
        if start == self.head.len() {
            start = self.head.trim_end().len();
        }
        Fault { span: Span { start, end: start + long }, problem }
    }

    /// What a parser gives, with its place; blanks behind it are skipped.
    fn at<T>(
        self,
        mut parser: impl FnMut(&'a str) -> Parsed<'a, T>,
    ) -> impl FnMut(&'a str) -> Parsed<'a, At<T>> {
        move |input| {
            let start = self.head.len() - input.len();
            let (rest, value) = parser(input)?;
            let end = self.head.len() - rest.len();
            let (rest, ()) = blank(rest)?;
            Ok((rest, At { value, span: Span { start, end } }))
        }
    }

    fn name(
        self,
        parser: fn(&'a str) -> Parsed<'a, &'a str>,
        wanted: &'static str,
    ) -> impl FnMut(&'a str) -> Parsed<'a, At<String>> {
        self.at(move |input| match parser(input) {
            Ok((rest, name)) => Ok((rest, name.to_owned())),
            Err(_) => fail(Miss::wanted(input, wanted)),
        })
    }

    fn component(self, input: &'a str) -> Parsed<'a, (At<String>, Option<String>)> {
        let (rest, _) = keyword("component", "'component'")(input)?;
        let (rest, name) = must(self.name(c_word, "the component's name"))(rest)?;
        let (rest, doc) = doc(rest)?;
        let (rest, ()) = end(&[("a text in \"…\"", doc.is_none())], rest)?;
        Ok((rest, (name, doc)))
    }

    fn declaration(self, input: &'a str) -> Parsed<'a, Declaration> {
        let word = |(text, wanted): &(&'static str, &'static str)| keyword(text, wanted)(input);
        let Some((rest, word)) = WORDS.iter().find_map(|w| word(w).ok()) else {
            let mut miss = Miss::wanted(input, "");
            miss.wanted = WORDS.iter().map(|(_, wanted)| *wanted).collect();
            return fail(miss);
        };
        match word {
            "pin" => self.item(
                &[("in", Direction::In), ("out", Direction::Out), ("io", Direction::Io)],
                rest,
            ),
            "param" => self.item(&[("r", Direction::R), ("rw", Direction::Rw)], rest),
            "function" => self.function(rest),
            "variable" => self.variable(rest),
            "option" => self.option(rest),
            "include" => self.include(rest),
            "modparam" => self.mod_param(rest),
            _ => {
                let (rest, value) = must(self.at(text))(rest)?;
                let (rest, ()) = end(&[], rest)?;
                let kind = TEXTS.iter().find(|(name, _)| *name == word).map(|(_, kind)| *kind);
                match kind {
                    Some(kind) => Ok((rest, Declaration::Text(kind, value))),
                    None => fail(Miss::wanted(input, "a declaration")),
                }
            }
        }
    }

    fn item(
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
        let (rest, size) = match sign(":", "':'")(rest) {
            Ok((rest, _)) => must(expr)(rest).map(|(rest, e)| (rest, Some(e)))?,
            Err(_) => (rest, None),
        };
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

    fn function(self, input: &'a str) -> Parsed<'a, Declaration> {
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

    /// The words of a type, stars, and the name, which is the last word of all.
    fn variable(self, input: &'a str) -> Parsed<'a, Declaration> {
        let (mut rest, first) = must(self.name(c_word, "a C type"))(input)?;
        let mut words = vec![first.value];
        let mut stars = 0;
        let name = loop {
            if let Ok((after, _)) = sign("*", "'*'")(rest) {
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

    fn option(self, input: &'a str) -> Parsed<'a, Declaration> {
        let (rest, name) = must(self.name(c_word, "the option's name"))(input)?;
        // A C type of several words, as `struct line`, is one name.
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

    fn include(self, input: &'a str) -> Parsed<'a, Declaration> {
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

    fn mod_param(self, input: &'a str) -> Parsed<'a, Declaration> {
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

/// A row of a table, by its word.
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
