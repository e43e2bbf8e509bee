//! Variables: `$NAME` from the environment, `[SECTION]NAME` from the INI file.

use crate::{
    Error,
    ini::Ini,
    language::fault::{Fault, Span},
};
use std::borrow::Cow;

/// Maximum length of a line after replacement, in bytes.
pub const MAX_LINE: usize = 2044;
/// Maximum length of a variable's name, in bytes.
pub const MAX_NAME: usize = 127;

/// Sources of the values.
#[derive(Clone, Copy)]
pub struct Values<'a> {
    /// The environment.
    pub environment: &'a dyn Fn(&str) -> Option<String>,
    /// The INI file, if there is one.
    pub ini: Option<&'a Ini>,
}

impl core::fmt::Debug for Values<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Values").field("ini", &self.ini).finish_non_exhaustive()
    }
}

/// A line after replacement.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Replaced {
    /// Text after replacement.
    pub(crate) text: String,
    /// Positions of the values in the text, and of their variables in the line.
    values: Vec<(Span, Span)>,
}

/// Replaces variables, also inside quotes. Inserted values are not scanned again.
///
/// # Errors
/// A name is empty, too long, not closed or not found, or the line becomes too long.
pub fn replace(line: &str, values: Values<'_>) -> Result<String, Error> {
    replaced(line, values).map(|r| r.text).map_err(|fault| *fault.error)
}

/// Like [`replace`], with the positions of the variables, or of the wrong one.
pub(crate) fn replaced(line: &str, values: Values<'_>) -> Result<Replaced, Fault> {
    let mut out = Replaced::default();
    let mut rest = line;
    while !rest.is_empty() {
        let start = line.len() - rest.len();
        let found = match rest.chars().next() {
            Some('$') => environment(tail(rest), values),
            Some('[') => ini_value(tail(rest), values.ini),
            _ => {
                let (text, after) = before(rest, |c| matches!(c, '$' | '['));
                out.text.push_str(text);
                rest = after;
                continue;
            }
        };
        let (after, value) = found.map_err(|(error, after)| {
            Fault::at(error, start..(line.len() - after.len()).max(start + 1))
        })?;
        let from = out.text.len();
        out.text.push_str(&value);
        let variable = start..line.len() - after.len();
        if out.text.len() > MAX_LINE {
            return Err(Fault::at(Error::LineTooLong, variable));
        }
        out.values.push((from..out.text.len(), variable));
        rest = after;
    }
    if out.text.len() > MAX_LINE {
        return Err(Fault::at(Error::LineTooLong, 0..line.len()));
    }
    Ok(out)
}

impl Replaced {
    /// Returns the part of the line from which a part of the text comes. A value comes from its
    /// whole variable.
    pub(crate) fn origin(&self, part: &Span) -> Span {
        let start = self.position(part.start, |variable| variable.start);
        let end = self.position(part.end.max(part.start + 1) - 1, |variable| variable.end - 1);
        start..(end + 1).max(start)
    }

    fn position(&self, at: usize, edge: impl Fn(&Span) -> usize) -> usize {
        let before = self.values.iter().rev().find(|(value, _)| value.start <= at);
        match before {
            None => at,
            Some((value, variable)) if at < value.end => edge(variable),
            Some((value, variable)) => variable.end + (at - value.end),
        }
    }
}

/// The rest of the text and the value, or the error and the rest of the text.
type Found<'a> = Result<(&'a str, Cow<'a, str>), (Error, &'a str)>;

fn environment<'a>(text: &'a str, values: Values<'a>) -> Found<'a> {
    let (after, name) = name(text)?;
    let value = (values.environment)(name).map(Cow::Owned);
    let missing = || (Error::NoEnvironment { name: name.into() }, after);
    value.map(|value| (after, value)).ok_or_else(missing)
}

fn ini_value<'a>(text: &'a str, ini: Option<&'a Ini>) -> Found<'a> {
    let (after, section) = section(text)?;
    let (after, name) = name(after)?;
    match ini.and_then(|ini| ini.get(section, name)) {
        Some(value) => Ok((after, Cow::Borrowed(value))),
        None => {
            let hint = missing(ini, section, name);
            Err((Error::NoIniVariable { section: section.into(), name: name.into(), hint }, after))
        }
    }
}

/// Returns the remedy for a missing INI variable.
fn missing(ini: Option<&Ini>, section: &str, name: &str) -> Box<str> {
    let Some(ini) = ini else { return "no INI file was given: -i names one".into() };
    if let Some(broken) = ini.broken() {
        return format!("nothing is found in a file with an error: {}", broken).into();
    }
    match ini.nearest(section, name) {
        Some((near, true)) => format!("did you mean {near}?").into(),
        Some((near, false)) => format!("nearest to it is {near}").into(),
        None => "the INI file has no variable".into(),
    }
}

/// Returns the INI entries that a line names, as section and name. Malformed ones are omitted.
pub(crate) fn mentioned(line: &str) -> Vec<(String, String)> {
    let found = line.match_indices('[').filter_map(|(at, _)| {
        let (after, section) = section(tail(line.get(at..)?)).ok()?;
        let (_, name) = name(after).ok()?;
        Some((section.to_owned(), name.to_owned()))
    });
    found.collect()
}

/// Parses `(NAME)`, or the longest run of name characters.
fn name(text: &str) -> Result<(&str, &str), (Error, &str)> {
    let (after, name) = match text.strip_prefix('(') {
        Some(inner) => {
            let (name, after) = inner.split_once(')').ok_or((Error::MissingParenthesis, ""))?;
            (after, name)
        }
        None => {
            let letter = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
            let (name, after) = before(text, |c| !letter(c));
            (after, name)
        }
    };
    match name.len() {
        0 => Err((Error::EmptyVariable, after)),
        1..=MAX_NAME => Ok((after, name)),
        _ => Err((Error::VariableTooLong, after)),
    }
}

fn section(text: &str) -> Result<(&str, &str), (Error, &str)> {
    let (section, after) = text.split_once(']').ok_or((Error::MissingBracket, ""))?;
    let long = section.len() > MAX_NAME;
    if long { Err((Error::VariableTooLong, after)) } else { Ok((after, section)) }
}

/// Splits a text before the first character that `ends` it.
fn before(text: &str, ends: impl Fn(char) -> bool) -> (&str, &str) {
    text.find(ends).and_then(|at| text.split_at_checked(at)).unwrap_or((text, ""))
}

/// Returns the text after the first character, which takes one byte.
fn tail(text: &str) -> &str {
    text.get(1..).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    const INI: &str = "[SEC]\nVAR = 12.5\nSPACED = some value with spaces\nLIST = a\nLIST = b\n\
        EMPTY =\nQUOTED = \"q v\"\nTRAIL = 5   # trailing comment\n\
        [S_1]\nCONT = one \\\n   two\nESC = a\\tb\\x41\n";

    fn replaced(line: &str) -> String {
        let ini = Ini::parse("test.ini", INI.as_bytes()).unwrap();
        let environment = |name: &str| match name {
            "HOME" => Some("/home/me".to_owned()),
            "USER" => Some("me".to_owned()),
            "BIG" => Some("x".repeat(600)),
            _ => None,
        };
        replace(line, Values { environment: &environment, ini: Some(&ini) })
            .unwrap_or_else(|e| format!("! {}", e.whole()))
    }

    #[test]
    fn every_form_of_a_variable() {
        for (line, want) in [
            ("print [SEC]VAR", "print 12.5"),
            ("print [SEC](VAR)mm", "print 12.5mm"),
            ("print [SEC]VAR-2", "! Ini variable '[SEC]VAR-2' not found; did you mean [SEC]VAR?"),
            ("print [SEC]LIST", "print a"),
            ("print [SEC]EMPTY", "print "),
            ("print [SEC]SPACED", "print some value with spaces"),
            ("print \"[SEC]SPACED\"", "print \"some value with spaces\""),
            ("print [SEC]QUOTED", "print \"q v\""),
            ("print [SEC]TRAIL", "print 5   # trailing comment"),
            ("print []VAR", "print 12.5"),
            ("print [](VAR)", "print 12.5"),
            (
                "print [NO]NOSUCHTHING",
                "! Ini variable '[NO]NOSUCHTHING' not found; nearest to it is [SEC]LIST",
            ),
            ("print [SEC]VAT", "! Ini variable '[SEC]VAT' not found; did you mean [SEC]VAR?"),
            ("print \"[S_1]CONT\"", "print \"one    two\""),
            ("print \"[S_1]ESC\"", "print \"a\tbA\""),
            ("print $HOME", "print /home/me"),
            ("print $(HOME)/x $HOME/x", "print /home/me/x /home/me/x"),
            ("print $USER$HOME", "print me/home/me"),
            ("print a$(USER)b", "print ameb"),
            ("print $NOSUCHENV", "! Environment variable 'NOSUCHENV' not found."),
            ("print $", "! Empty variable name."),
            ("print $()", "! Empty variable name."),
            ("print []", "! Empty variable name."),
            ("print [SEC]()", "! Empty variable name."),
            ("print [SEC", "! Missing close square bracket."),
            ("print $(HOME", "! Missing close parenthesis."),
            ("print [SEC](VAR", "! Missing close parenthesis."),
            (
                "print $BIG$BIG$BIG$BIG",
                "! Line too long; a line has at most 1023 bytes, and 2044 with the values of its variables",
            ),
            ("no variables", "no variables"),
            ("", ""),
        ] {
            assert_eq!(replaced(line), want, "{line}");
        }
        assert_eq!(replaced(&format!("${}", "n".repeat(128))), "! Variable name too long.");
        assert_eq!(replaced("$BIG$BIG$BIG").len(), 1800);
    }

    #[test]
    fn case_matters_and_no_ini_file_has_nothing() {
        assert!(replaced("[sec]var").starts_with("! Ini variable '[sec]var' not found; "));
        let nothing = Values { environment: &|_| None, ini: None };
        let error = replace("[SEC]VAR", nothing).unwrap_err().to_string();
        assert_eq!(error, "Ini variable '[SEC]VAR' not found.");
    }
}
