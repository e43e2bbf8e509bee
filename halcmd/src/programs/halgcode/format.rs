//! `halgcode format`: the same program with other text.

use super::{
    help::usage_of,
    metric::Metric,
    tokens::{Token, bytes, tokens},
};
use crate::{
    Stdio, Terminal,
    programs::options::{Opt, mixed, plain, usage},
    terminal::print_error,
};
use hal_gcode::text::{
    expression::{FUNCTIONS, OPERATORS},
    oword,
};
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Arguments of the command.
pub(super) const ARGUMENTS: &str = "[options] FILE";
/// Purpose of the command.
pub(super) const HELP: &str = "the same program, tidied, renumbered or in millimetres";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Output,
    Renumber,
    NoNumbers,
    Millimetres,
    Help,
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        long: Some("output"),
        help: "the file to write; standard output if none is given",
        ..Opt::short_with(Id::Output, 'o', "FILE")
    },
    Opt {
        long: Some("renumber"),
        help: "numbers lines in this step",
        ..Opt::short_with(Id::Renumber, 'n', "STEP")
    },
    Opt { long: Some("no-numbers"), help: "removes line numbers", ..Opt::flag(Id::NoNumbers, 'r') },
    Opt {
        long: Some("mm"),
        help: "millimetres for inches; a program without G20 and G21 is in inches",
        ..Opt::flag(Id::Millimetres, 'm')
    },
    Opt { long: Some("help"), help: "print this", ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs `format` with these words. The status is 1 if a line could not be read; it is kept as it was.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = mixed("halgcode", OPTIONS, words).map_err(|e| e.to_string())?;
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.as_deref();
    let is_given = |wanted| given.iter().any(|(id, _)| *id == wanted);
    if is_given(Id::Help) {
        Stdio.out(&usage_of("format", ARGUMENTS, HELP, &usage(OPTIONS)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let [file] = rest.as_slice() else {
        return Err("which file? halgcode format [options] FILE".into());
    };
    let step = match value(Id::Renumber) {
        None => None,
        Some(text) => {
            let step = text.parse::<u32>().ok().filter(|n| (1..=10_000).contains(n));
            Some(step.ok_or_else(|| format!("'{text}' is no step: 1 to 10000"))?)
        }
    };
    let numbers = match (step, is_given(Id::NoNumbers)) {
        (Some(_), true) => return Err("--renumber and --no-numbers exclude each other".into()),
        (Some(step), false) => Numbers::Step(step),
        (None, true) => Numbers::None,
        (None, false) => Numbers::Keep,
    };
    let raw = hal_ini::file::whole(Path::new(file))
        .map_err(|e| format!("{file}: {}", hal_output::reason(&e)))?;
    let mut unread = Vec::new();
    let out = format(&raw, numbers, is_given(Id::Millimetres), &mut unread)
        .map_err(|(line, reason)| format!("{file}:{line}: {reason}"))?;
    match value(Id::Output).map(PathBuf::from) {
        Some(path) => hal_output::write(&path, &out)
            .map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?,
        None => write(&out)?,
    }
    for line in &unread {
        print_error(&format!(
            "{file}:{line}: kept as it was; halgcode check {} says why\n",
            Path::new(file).display()
        ));
    }
    Ok(if unread.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Writes bytes to standard output, which may be of any encoding.
fn write(bytes: &[u8]) -> Result<(), String> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Stdio.out(text).map_err(String::from),
        Err(_) => Err("a comment is not UTF-8: use -o FILE".into()),
    }
}

/// The treatment of line numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    Keep,
    None,
    Step(u32),
}

/// Returns the formatted program. `unread` gets the lines that are no lines of the language.
///
/// # Errors
/// A line cannot be turned into millimetres: its number, and the reason.
pub(super) fn format(
    raw: &[u8],
    numbers: Numbers,
    millimetres: bool,
    unread: &mut Vec<u32>,
) -> Result<Vec<u8>, (u32, String)> {
    let mut metric = millimetres.then(|| Metric::new(raw));
    let mut out = Vec::with_capacity(raw.len());
    let mut open: Vec<(String, String)> = Vec::new();
    let mut next = 0u32;
    let ended = raw.last() != Some(&b'\n');
    let count = raw.split(|b| *b == b'\n').count();
    for (index, line) in raw.split(|b| *b == b'\n').enumerate() {
        let number = u32::try_from(index).unwrap_or(u32::MAX).saturating_add(1);
        if index + 1 == count && line.is_empty() {
            break;
        }
        let Some(mut tokens) = tokens(line) else {
            unread.push(number);
            out.extend(line);
            out.push(b'\n');
            continue;
        };
        if let Some(metric) = &mut metric {
            metric.line(&mut tokens).map_err(|reason| (number, reason))?;
        }
        renumber(&mut tokens, numbers, &mut next);
        let depth = depth(&tokens, &mut open);
        let text = print(&tokens);
        if !text.is_empty() {
            out.extend(core::iter::repeat_n(b' ', 2 * depth.min(40)));
        }
        out.extend(bytes(&text));
        if index + 1 < count || !ended || !text.is_empty() {
            out.push(b'\n');
        }
    }
    Ok(out)
}

/// Changes the line number. Lines without words of their own get none.
fn renumber(tokens: &mut Vec<Token>, numbers: Numbers, next: &mut u32) {
    if numbers == Numbers::Keep {
        return;
    }
    tokens.retain(|t| !matches!(t, Token::Number(_)));
    let Numbers::Step(step) = numbers else { return };
    if tokens.iter().any(|t| matches!(t, Token::Word(_) | Token::Assignment { .. })) {
        *next = next.saturating_add(step);
        let at = usize::from(tokens.first() == Some(&Token::Delete));
        tokens.insert(at, Token::Number(next.to_string()));
    }
}

/// Returns how deep a line is inside of subroutines, loops and conditions.
fn depth(tokens: &[Token], open: &mut Vec<(String, String)>) -> usize {
    let word = tokens.iter().find_map(|t| match t {
        Token::OWord { label, rest } => Some((label, oword::keyword(rest.as_bytes())?)),
        _ => None,
    });
    let Some((label, keyword)) = word else { return open.len() };
    let closes = |open: &mut Vec<(String, String)>| {
        if let Some(at) = open.iter().rposition(|(l, _)| l == label) {
            open.truncate(at);
        }
    };
    let ends_do = open.last().is_some_and(|(l, k)| l == label && k == "do");
    match keyword {
        "while" if ends_do => {
            closes(open);
            open.len()
        }
        "endsub" | "endif" | "endwhile" | "endrepeat" => {
            closes(open);
            open.len()
        }
        "else" | "elseif" => open.len().saturating_sub(1),
        "sub" | "if" | "while" | "do" | "repeat" => {
            open.push((label.clone(), keyword.to_owned()));
            open.len() - 1
        }
        _ => open.len(),
    }
}

fn print(tokens: &[Token]) -> String {
    let mut out = String::new();
    for token in tokens {
        // The slash stands before its line without a gap.
        if !out.is_empty() && out != "/" {
            out.push(' ');
        }
        match token {
            Token::Delete => out.push('/'),
            Token::Percent => out.push('%'),
            Token::Number(n) => out.push_str(&format!("N{n}")),
            Token::Comment(text) => out.push_str(text.trim_end()),
            Token::Word(w) => out.push_str(&format!("{}{}", w.letter, expression(&w.value.tidy()))),
            Token::Assignment { target, value } => {
                out.push_str(&format!("{}={}", expression(target), expression(&value.tidy())));
            }
            Token::OWord { label, rest } => {
                out.push_str(&format!("o{}", expression(label)));
                let word = oword::keyword(rest.as_bytes()).unwrap_or_default();
                if !word.is_empty() {
                    out.push_str(&format!(" {word}"));
                }
                for argument in arguments(rest.get(word.len()..).unwrap_or_default()) {
                    out.push_str(&format!(" {}", expression(argument)));
                }
            }
        }
    }
    out
}

/// Splits `[1][2](c)[3]` into its parts.
fn arguments(text: &str) -> Vec<&str> {
    let mut out = Vec::new();
    let (mut depth, mut start, mut comment) = (0u32, 0, false);
    for (at, c) in text.char_indices() {
        match c {
            '(' if depth == 0 => comment = true,
            ')' if comment => comment = false,
            '[' if !comment => depth += 1,
            ']' if !comment => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 && !comment {
            let end = at + c.len_utf8();
            out.extend(text.get(start..end));
            start = end;
        }
    }
    out.extend(text.get(start..).filter(|t| !t.is_empty()));
    out
}

/// Sets operators that are words apart from their values.
fn expression(text: &str) -> String {
    if text.starts_with('(') {
        return text.to_owned();
    }
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        if c == '<' {
            let end = rest.find('>').map_or(rest.len(), |e| e + 1);
            out.push_str(rest.get(..end).unwrap_or(rest));
            rest = rest.get(end..).unwrap_or_default();
            continue;
        }
        let function = FUNCTIONS.iter().map(|(n, _)| *n).chain(["atan", "exists"]);
        let function = function
            .into_iter()
            .find(|n| rest.strip_prefix(n).is_some_and(|after| after.starts_with('[')));
        let operator = OPERATORS.iter().map(|(n, ..)| *n);
        let mut operator = operator.filter(|n| n.starts_with(|c: char| c.is_ascii_alphabetic()));
        if let Some(name) = function {
            out.push_str(name);
            rest = rest.get(name.len()..).unwrap_or_default();
        } else if let Some(name) = operator.find(|n| rest.starts_with(n)) {
            out.push_str(&format!(" {name} "));
            rest = rest.get(name.len()..).unwrap_or_default();
        } else {
            out.push(c);
            rest = rest.get(c.len_utf8()..).unwrap_or_default();
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formatted(text: &str, numbers: Numbers, mm: bool) -> String {
        let mut unread = Vec::new();
        String::from_utf8(format(text.as_bytes(), numbers, mm, &mut unread).unwrap()).unwrap()
    }

    #[test]
    fn text_is_tidied_and_comments_stay() {
        let text = "%\r\n n5g0  x+1.50y-0.0(Go  There)\r\n\r\no<Sub>  SUB\ng1z[ #1LT2 and sin[30]gt 0]f10;Down\n\
                    o101 if[#<a b>eq 3]\n/x1\no101 else\nx2\no101 endif\no<sub> endsub\no<sub>call[1][ 2 ]\nm2\n%\n";
        let wanted = "%\nN5 G0 X1.5 Y0 (Go  There)\n\no<sub> sub\n  G1 Z[#1 lt 2 and sin[30] gt 0] F10 ;Down\n  \
                      o101 if [#<ab> eq 3]\n    /X1\n  o101 else\n    X2\n  o101 endif\no<sub> endsub\n\
                      o<sub> call [1] [2]\nM2\n%\n";
        assert_eq!(formatted(text, Numbers::Keep, false), wanted);
        assert_eq!(formatted(wanted, Numbers::Keep, false), wanted, "formatted twice");
    }

    #[test]
    fn lines_get_numbers_or_lose_them() {
        let text = "(a)\nn1 g0 x1\n/n2 x2\no1 repeat [2]\nn3 x3\no1 endrepeat\nm2\n";
        let wanted = "(a)\nN10 G0 X1\n/N20 X2\no1 repeat [2]\n  N30 X3\no1 endrepeat\nN40 M2\n";
        assert_eq!(formatted(text, Numbers::Step(10), false), wanted);
        let wanted = "(a)\nG0 X1\n/X2\no1 repeat [2]\n  X3\no1 endrepeat\nM2\n";
        assert_eq!(formatted(text, Numbers::None, false), wanted);
    }

    #[test]
    fn other_encodings_and_lines_that_are_none_stay() {
        let mut unread = Vec::new();
        let out =
            format(b"g0x1(Gr\xfc\xdfe)\ng1 x[\nm2", Numbers::Keep, false, &mut unread).unwrap();
        assert_eq!(out, b"G0 X1 (Gr\xfc\xdfe)\ng1 x[\nM2\n");
        assert_eq!(unread, [2]);
    }
}
