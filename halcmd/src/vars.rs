//! Variables: `$NAME` from the environment, `[SECTION]NAME` from the INI file.

use crate::{Error, error::nearest, ini::Ini};
use nom::{
    IResult, Parser,
    bytes::complete::{is_not, take_while},
};

/// The longest line after replacement, in bytes.
pub const MAX_LINE: usize = 2044;
/// The longest name of a variable.
pub const MAX_NAME: usize = 127;

/// Where values come from.
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

/// Replaces variables, also inside quotes. What is inserted is not looked at again.
///
/// # Errors
/// A name is empty, too long, not closed or not found, or the line becomes too long.
pub fn replace(line: &str, values: Values<'_>) -> Result<String, Error> {
    let mut out = String::new();
    let mut rest = line;
    while !rest.is_empty() {
        rest = match rest.chars().next() {
            Some('$') => {
                let (after, name) = name(tail(rest))?;
                out.push_str(
                    &(values.environment)(name)
                        .ok_or_else(|| Error::NoEnvironment { name: name.into() })?,
                );
                after
            }
            Some('[') => {
                let (after, section) = section(tail(rest))?;
                let (after, name) = name(after)?;
                out.push_str(ini_value(values.ini, section, name)?);
                after
            }
            _ => {
                let (after, text) = plain(rest).unwrap_or(("", rest));
                out.push_str(text);
                after
            }
        };
        if out.len() > MAX_LINE {
            return Err(Error::LineTooLong);
        }
    }
    Ok(out)
}

/// `(NAME)`, or the longest run of name characters.
fn name(text: &str) -> Result<(&str, &str), Error> {
    let (after, name) = match text.strip_prefix('(') {
        Some(inner) => {
            let (name, after) = inner.split_once(')').ok_or(Error::MissingParenthesis)?;
            (after, name)
        }
        None => run(text).unwrap_or((text, "")),
    };
    match name.len() {
        0 => Err(Error::EmptyVariable),
        1..=MAX_NAME => Ok((after, name)),
        _ => Err(Error::VariableTooLong),
    }
}

fn section(text: &str) -> Result<(&str, &str), Error> {
    let (section, after) = text.split_once(']').ok_or(Error::MissingBracket)?;
    if section.len() > MAX_NAME { Err(Error::VariableTooLong) } else { Ok((after, section)) }
}

fn ini_value<'a>(ini: Option<&'a Ini>, section: &str, name: &str) -> Result<&'a str, Error> {
    ini.and_then(|ini| ini.get(section, name)).ok_or_else(|| {
        let known = ini.map(|i| i.names().collect::<Vec<_>>()).unwrap_or_default();
        let near = nearest(&format!("[{section}]{name}"), known.iter().map(String::as_str));
        Error::NoIniVariable { section: section.into(), name: name.into(), near }
    })
}

fn run(text: &str) -> IResult<&str, &str> {
    take_while(|c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_')).parse(text)
}

fn plain(text: &str) -> IResult<&str, &str> {
    is_not("$[").parse(text)
}

/// What follows the first character, which takes one byte.
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
            .unwrap_or_else(|e| format!("! {e}"))
    }

    #[test]
    fn every_form_of_a_variable() {
        for (line, want) in [
            ("print [SEC]VAR", "print 12.5"),
            ("print [SEC](VAR)mm", "print 12.5mm"),
            (
                "print [SEC]VAR-2",
                "! Ini variable '[SEC]VAR-2' not found.; did you mean '[SEC]VAR'?",
            ),
            ("print [SEC]LIST", "print a"),
            ("print [SEC]EMPTY", "print "),
            ("print [SEC]SPACED", "print some value with spaces"),
            ("print \"[SEC]SPACED\"", "print \"some value with spaces\""),
            ("print [SEC]QUOTED", "print \"q v\""),
            ("print [SEC]TRAIL", "print 5   # trailing comment"),
            ("print []VAR", "print 12.5"),
            ("print [](VAR)", "print 12.5"),
            ("print [NO]NOSUCHTHING", "! Ini variable '[NO]NOSUCHTHING' not found."),
            ("print [SEC]VAT", "! Ini variable '[SEC]VAT' not found.; did you mean '[SEC]VAR'?"),
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
            ("print $BIG$BIG$BIG$BIG", "! Line too long."),
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
        assert!(replaced("[sec]var").starts_with("! Ini variable '[sec]var' not found."));
        let nothing = Values { environment: &|_| None, ini: None };
        let error = replace("[SEC]VAR", nothing).unwrap_err().to_string();
        assert_eq!(error, "Ini variable '[SEC]VAR' not found.");
    }
}
