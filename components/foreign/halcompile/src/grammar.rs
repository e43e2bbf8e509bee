//! Parser of the declarations, from text to a tree.

mod declaration;

use crate::{
    Problem,
    place::{Fault, Span},
    token::{Miss, Parsed, blank, c_word, fail, found, keyword, sign, stop, text, then_blank},
    tree::{At, Body, Declaration, Direction, TEXTS, Tree},
};
use nom::{Parser, combinator::opt};

/// Maximum number of faults reported for one file.
const MAX_FAULTS: usize = 20;

/// Parses a file; after a fault, it continues after the next `;`.
///
/// # Errors
/// All violations of the grammar.
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

/// Splits a file into the declarations and the C text after the line `;;`.
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
    while !rest.is_empty() && faults.len() < MAX_FAULTS {
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

/// Returns the text after the next `;` that follows a fault, outside of strings and comments. Returns nothing if one of
/// those is the fault.
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
            // A line that begins with the keyword of a declaration ends the faulty one before it.
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

/// Keywords of declarations, with their form in messages.
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

/// Turns an error into a failure once the keyword of a declaration has been read, so that the missing part is reported.
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

/// Parses the `;` of a declaration. The message also names the other tokens that were possible there.
fn end<'a>(others: &[(&'static str, bool)], input: &'a str) -> Parsed<'a, ()> {
    if let (rest, Some(_)) = opt(sign(";", "';'")).parse(input)? {
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

/// Text of the file, which converts the parsers' rests to byte offsets.
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
        let misses_end = wanted.contains(&"';'");
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
        // A token missing at the end of a line is reported there, not at the start of the next line.
        let before = self.head.get(..start).unwrap_or_default();
        let on_line = before.trim_end().len();
        if start == self.head.len()
            || (misses_end && before.get(on_line..).is_some_and(|b| b.contains('\n')))
        {
            start = on_line;
        }
        Fault { span: Span { start, end: start + long }, problem }
    }

    /// Returns a parser that also yields the span of the result, and skips blanks after it.
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
}
